"""Pages that show runs: what is packed is within its tolerances, and a browser draws it.

The browser is Chromium without a window, the network refused; where there is none, its tests are
skipped.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
import shutil
import subprocess
import sys
import time
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from lib import browser, pages, thinning, viewing  # noqa: E402

needs_browser = pytest.mark.skipif(browser.PROGRAM is None, reason="there is no Chromium")

HOSTILE = "</script><script>window.struck=1</script><img src=x onerror='struck=1'>"
BALL = """\
&scene title = {title}, gravity = 0, 0, -9.81, t_end = {end} /
&material name = 'rubber', young = 1e7, poisson = 0.4 /
&body name = 'ball', mass = 0.05, inertia = 3*8e-6, position = 0, 0, {height}, {motion} /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.02, material = 'rubber' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'rubber' /
&contact name = 'bounce', surfaces = 'skin', 'floor', damping = 'hunt_crossley',
   restitution = 0.8, impact_velocity = 1, friction = 'coulomb', friction_coefficient = 0.3,
   regularization_velocity = 1e-3 /
&output interval = {interval} /
"""


def ball(title="'ball'", end=0.5, height=0.12, motion="spin = 0, 5, 0", interval=1e-3):
    return BALL.format(title=title, end=end, height=height, motion=motion, interval=interval)


def view(*words, cwd):
    """Run scripts/view."""
    return subprocess.run(
        [ROOT / "scripts" / "view", *map(str, words)],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
    )


def contents(page):
    """Head and arrays of a page."""
    packed = re.search(r'id="data">([^<]*)<', page)[1]
    data = zlib.decompress(base64.b64decode(packed))
    length = int.from_bytes(data[:4], "little")
    head = json.loads(data[8 : 8 + length])

    def array(place):
        kind, start, count = place
        return np.frombuffer(data, "<" + kind, count, 8 + length + start)

    return head, array


class Motion:
    """The motion of a body as a page has it, read here once more."""

    def __init__(self, head, array, number):
        body = head["bodies"][number]
        self.at, self.turned = (self.times(head, array(body[k])) for k in ("at", "turned_at"))
        self.position = array(body["position"]).reshape(-1, 3).astype(float)
        quaternion = array(body["quaternion"]).reshape(-1, 4).astype(float)
        self.quaternion = quaternion / np.linalg.norm(quaternion, axis=1)[:, None]
        self.turn = array(body["turn"]).reshape(-1, 3).astype(float)

    @staticmethod
    def times(head, steps):
        return head["start"] + head["tick"] * np.cumsum(steps.astype(np.int64))

    def positions(self, times):
        return np.stack([np.interp(times, self.at, x) for x in self.position.T], axis=1)

    def attitudes(self, times):
        if len(self.turned) == 1:
            return np.repeat(self.quaternion, len(times), axis=0)
        i = np.clip(np.searchsorted(self.turned, times, "right") - 1, 0, len(self.turned) - 2)
        share = (times - self.turned[i]) / (self.turned[i + 1] - self.turned[i])
        first, last = self.quaternion[i], self.quaternion[i + 1]
        return thinning.between(first, last, self.turn[i], share[:, None])


def check_motion(path, page):
    """All rows of a file against what the page makes of its keys."""
    head, array = contents(page)
    with h5py.File(path) as file:
        rows = file["trajectory"]
        time = rows["time"][()]
        for i in range(len(head["bodies"])):
            motion = Motion(head, array, i)
            off = np.linalg.norm(motion.positions(time) - rows["position"][:, i], axis=1)
            assert off.max() <= head["length"] * head["scale"]
            cosine = np.abs(np.sum(motion.attitudes(time) * rows["quaternion"][:, i], axis=1))
            assert np.degrees(2 * np.arccos(np.minimum(cosine, 1))).max() <= head["angle"]
    return head


@pytest.fixture
def shown(run, tmp_path):
    """Run a scene (text or path) and write its page: paths of the file and of the page."""

    def show(scene, *options, name="out"):
        path = scene
        if isinstance(scene, str):
            path = tmp_path / "scene.nml"
            path.write_text(scene)
        done = run("run", path, "-q", "-o", f"{name}.h5", "--force", *options)
        assert done.status == 0, done.err
        page = tmp_path / f"{name}.html"
        page.write_text(viewing.view(tmp_path / f"{name}.h5"), encoding="utf-8")
        return tmp_path / f"{name}.h5", page

    return show


@pytest.fixture(scope="module")
def chromium():
    """The browser."""
    program = browser.Browser()
    yield program
    program.close()


# ---- What is packed ----------------------------------------------------------------------------


@pytest.mark.parametrize("rows", [1, 2, 3, 4, 31, 1000, 20000])
def test_lines_between_keys_are_close(rows):
    time = np.linspace(0, 7, rows)
    values = np.stack([np.sin(9 * time), np.abs(np.cos(2 * time))], axis=1)
    kept = thinning.keys(rows, thinning.line_error(time, values, 1e-2))
    assert kept[0] == 0
    assert kept[-1] == rows - 1
    for column in values.T:
        assert np.abs(np.interp(time, time[kept], column[kept]) - column).max() <= 1e-2 * (1 + 1e-9)
    if rows >= 1000:
        assert len(kept) < 0.4 * rows


@pytest.mark.parametrize("interval", [1e-4, 1e-2, 1.0])
def test_fast_spins_turn_as_often_as_they_do(interval):
    """1000 rad/s, also between rows in which that is many turns."""
    rate = np.array([2.0, -1.0, 1000.0])
    time = np.arange(2001) * interval
    quaternion = thinning.exponential(time[:, None] * rate)
    turned = thinning.integral(time, np.broadcast_to(rate, (len(time), 3)))
    kept = thinning.keys(len(time), thinning.turn_error(time, quaternion, turned, np.radians(0.9)))
    assert len(kept) < 20
    between = np.linspace(time[0], time[-1], 777)
    i = np.searchsorted(time[kept], between, "right").clip(1, len(kept) - 1) - 1
    a, b = kept[i], kept[i + 1]
    drawn = thinning.between(
        quaternion[a],
        quaternion[b],
        turned[b] - turned[a],
        ((between - time[a]) / (time[b] - time[a]))[:, None],
    )
    true = thinning.exponential(between[:, None] * rate)
    assert np.abs(np.sum(drawn * true, axis=1)).min() > np.cos(np.radians(0.5))


@pytest.mark.parametrize(
    ("scene", "end"),
    [("tippe_top", 2.5), ("bearing_6205", 0.02), ("rattleback", 1.0), ("bowling", 1.0)],
)
def test_motion_is_within_its_tolerance(shown, inputs, scene, end):
    path, page = shown(inputs / f"{scene}.nml", "--set", f"scene.t_end={end}")
    head = check_motion(path, page.read_text(encoding="utf-8"))
    assert head["angle"] == pytest.approx(1.0)
    assert head["length"] == pytest.approx(1e-3)
    assert page.stat().st_size < 1.5e6


def test_an_hour_of_rows_is_small(shown, tmp_path):
    """3.6 million rows would take a gigabyte; 200,000 that move as much tell the same of sizes."""
    # So many rows from the start that they are stored in pieces as large as those of a long run.
    path, _ = shown(ball(end=0.002, height=0.02, interval=1e-7))
    rows = 200_001
    with h5py.File(path, "a") as file:
        group = file["trajectory"]
        time = np.linspace(0, 3600, rows)
        swing = np.stack([np.cos(3 * time), np.sin(3 * time), 0 * time], axis=1)
        spin = np.array([0.0, 0.0, 50.0])
        new = {
            "position": 0.05 * swing[:, None],
            "velocity": 0.15 * swing[:, None],
            "quaternion": thinning.exponential(time[:, None] * spin)[:, None],
            "angular_velocity": np.broadcast_to(spin, (rows, 1, 3)),
        }
        for name, data in list(group.items()):
            if data.maxshape[0] is None:
                data.resize(rows, axis=0)
                still = time if name == "time" else np.broadcast_to(data[0], data.shape)
                data[...] = new.get(name, still)
    page = viewing.view(path)
    assert len(page) < 5e6
    head = check_motion(path, page)
    assert head["rows"] == rows


def test_stretches_of_rows_make_one_motion(shown, inputs, monkeypatch):
    path, page = shown(inputs / "tippe_top.nml", "--set", "scene.t_end=2.5")
    whole, array = contents(page.read_text(encoding="utf-8"))
    monkeypatch.setattr(viewing, "STRETCH", 1 << 11)
    cut, pieces = contents(viewing.view(path))
    assert cut["forces"] == whole["forces"]
    for one, two in zip(whole["contacts"], cut["contacts"], strict=True):
        at = Motion.times(cut, pieces(two["at"]))
        assert (np.diff(at) > 0).all()
        assert {len(pieces(two["closed"])), len(pieces(two["point"])) // 3} == {len(at)}
        fine = np.linspace(0, 2.5, 999)
        drawn = []
        for head, get, contact in ((whole, array, one), (cut, pieces, two)):
            values = get(contact["values"]).view("<f2").reshape(-1, 9)[:, 0].astype(float)
            times = Motion.times(head, get(contact["at"]))
            drawn.append(np.interp(fine, times, values))
        assert np.abs(drawn[0] - drawn[1]).max() < 0.05


def test_body_without_surfaces_and_contacts(shown):
    scene = """&scene t_end = 0.1 /
        &body name = 'stone', mass = 1, inertia = 1, 2, 2.5, velocity = 3, 0, 1, spin = 1, 2, 3 /"""
    path, page = shown(scene)
    assert check_motion(path, page.read_text(encoding="utf-8"))["contacts"] == []


def test_too_much_motion_is_drawn_less_closely(shown, monkeypatch):
    path, page = shown(ball(end=1.0))
    usual = contents(page.read_text())[0]
    monkeypatch.setattr(viewing, "BUDGET", 6000)
    monkeypatch.setattr(viewing, "BUDGET_EACH", 0)
    page = viewing.view(path)
    head = check_motion(path, page)
    assert head["angle"] > usual["angle"]


def test_forces_and_frames_of_contacts(shown, inputs):
    path, page = shown(inputs / "tippe_top.nml", "--set", "scene.t_end=2.5")
    head, array = contents(page.read_text())
    with h5py.File(path) as file:
        rows = file["trajectory"]
        time, force = rows["time"][()], rows["normal_force"][()]
        friction = np.linalg.norm(rows["friction_force"][()], axis=2)
        largest = force.max()
        for i, contact in enumerate(head["contacts"]):
            at = Motion.times(head, array(contact["at"]))
            closed = array(contact["closed"])
            values = array(contact["values"]).view("<f2").reshape(-1, 9) * np.array(head["forces"])
            drawn = np.interp(time, at, np.where(closed, values[:, 0], 0))
            assert np.abs(drawn - force[:, i]).max() < 0.021 * largest
            rub = np.hypot(values[:, 1], values[:, 2])
            kept = np.searchsorted(time, at - 1e-9)
            assert np.abs(rub - friction[kept, i]).max() < 1e-3 * largest


# ---- Messages ----------------------------------------------------------------------------------


def test_command_writes_a_page(run, scene, tmp_path):
    assert run("run", scene, "-q").status == 0
    done = view("top.h5", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "top.html\n", "")
    page = (tmp_path / "top.html").read_text(encoding="utf-8")
    assert "three.js" not in page.split("<script>", 1)[0]
    assert "http-equiv" in page
    (tmp_path / "top.h5").rename(tmp_path / "top.h5.part")
    done = view("top.h5.part", "-o", "other.html", cwd=tmp_path)
    assert done.stdout == "other.html\n"
    done = view("top.h5.part", "-o", "top.h5.part", cwd=tmp_path)
    assert done.returncode == 2
    assert "is the file that is read" in done.stderr


def test_view_is_a_command(run, executable, scene, tmp_path):
    """`contensou view` is that program, where it lies beside it."""
    assert run("run", scene, "-q").status == 0
    done = run("view", "top.h5")
    assert (done.status, done.out, done.err) == (0, "top.html\n", "")
    assert 'id="data"' in (tmp_path / "top.html").read_text(encoding="utf-8")
    done = run("view", "top.h5", "-o", "-x.html")
    assert (done.status, (tmp_path / "-x.html").exists()) == (0, True), done.err
    done = run("view", "missing.h5")
    assert (done.status, "missing.h5 does not exist" in done.err) == (74, True)
    for words in (["view"], ["view", "top.h5", "--limit-surface", "a=1e-3"]):
        done = run(*words)
        assert (done.status, "either FILE.h5 or --limit-surface" in done.err) == (2, True)
    alone = tmp_path / "alone" / "contensou"
    alone.parent.mkdir()
    shutil.copy2(executable, alone)
    done = subprocess.run(
        [alone, "view", tmp_path / "top.h5"],
        capture_output=True,
        text=True,
        check=False,
        env={"PATH": str(alone.parent)},
    )
    assert done.returncode == 74
    assert "cannot start contensou-view" in done.stderr


def test_page_is_whole_or_not_there(run, scene, tmp_path):
    """A page that cannot be written to its end is not there, and that of before stays."""
    assert run("run", scene, "-q").status == 0
    (tmp_path / "top.html").write_text("before")
    limit = "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
    limit += "resource.setrlimit(resource.RLIMIT_FSIZE, (9999, 9999)); sys.path.insert(0, sys.argv"
    limit += "[1]); import view; sys.argv[1:] = ['top.h5']; sys.exit(view.main())"
    done = subprocess.run(
        [sys.executable, "-c", limit, str(ROOT / "scripts")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, "top.html cannot be written" in done.stderr) == (74, True), done.stderr
    assert (tmp_path / "top.html").read_text() == "before"
    assert not [path for path in tmp_path.iterdir() if path.name.startswith("top.html.")]


def test_file_that_is_being_written(executable, scene, tmp_path):
    """A run that goes on is shown as far as its rows are in the file, and goes on."""
    endless = ["--set", "scene.t_end=9e4", "--set", "output.interval=1e-4"]
    with subprocess.Popen([executable, "run", scene, "-q", *endless], cwd=tmp_path) as live:
        part = tmp_path / "top.h5.part"
        for _ in range(100):
            # Rows are flushed after five seconds.
            time.sleep(1)
            done = view(part.name, "-o", "so_far.html", cwd=tmp_path)
            if done.returncode == 0:
                break
            assert done.stderr.startswith(f"error: {part.name} "), done.stderr
            assert "Traceback" not in done.stderr
        assert live.poll() is None
        live.terminate()
    assert (done.returncode, done.stdout) == (0, "so_far.html\n"), done.stderr
    head, _ = contents((tmp_path / "so_far.html").read_text(encoding="utf-8"))
    assert head["status"] == "running"
    assert head["end"] > 0


def test_files_that_cannot_be_shown(run, scene, tmp_path):
    def refused(name, words):
        done = view(name, cwd=tmp_path)
        assert done.returncode == 74, done.stderr
        assert done.stdout == ""
        assert done.stderr.startswith(f"error: {name} "), done.stderr
        assert words in done.stderr
        assert "Traceback" not in done.stderr
        assert not (tmp_path / name).with_suffix(".html").exists()

    assert run("run", scene, "-q").status == 0
    data = (tmp_path / "top.h5").read_bytes()
    refused("nothing.h5", "does not exist")
    (tmp_path / "text.h5").write_text("no HDF5")
    refused("text.h5", "is no HDF5 file")
    (tmp_path / "half.h5").write_bytes(data[: len(data) // 2])
    refused("half.h5", "damaged")
    flipped = bytearray(data)
    flipped[len(data) // 2] ^= 4
    (tmp_path / "flipped.h5").write_bytes(flipped)
    refused("flipped.h5", "damaged")
    (tmp_path / "old.h5").write_bytes(data)
    with h5py.File(tmp_path / "old.h5", "a") as file:
        del file["surface"]
        file.attrs["filetype_version"] = "1.4"
    refused("old.h5", "contensou-trajectory 1.4")
    (tmp_path / "table.h5").write_bytes(data)
    with h5py.File(tmp_path / "table.h5", "a") as file:
        file.attrs["filetype"] = "contensou-sweep"
    refused("table.h5", "contensou-sweep")
    (tmp_path / "lost.h5").write_bytes(data)
    with h5py.File(tmp_path / "lost.h5", "a") as file:
        file["trajectory/position"][1, 0] = np.nan
    refused("lost.h5", "no numbers")


def test_library_is_as_delivered():
    folder = pages.PARTS / "three"
    assert "MIT" in (folder / "LICENSE").read_text()
    listed = (folder / "README.md").read_text()
    for name in ("three.core.min.js", "three.module.min.js"):
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() in listed


# ---- In the browser ----------------------------------------------------------------------------


def poses(program, times):
    """Poses of the bodies in the scene graph at some times: (times, bodies, 7)."""
    return np.array(
        program.value(
            f"{json.dumps(list(times))}.map(t => {{ contensou.seek(t); contensou.draw();"
            "contensou.scene.updateMatrixWorld(); return contensou.groups.map(g => {"
            "const p = g.getWorldPosition(g.position.clone()),"
            "q = g.getWorldQuaternion(g.quaternion.clone());"
            "return [p.x, p.y, p.z, q.w, q.x, q.y, q.z]; }); })"
        )
    )


def clean(program, page):
    """Neither a complaint nor a request but for the page itself."""
    assert program.complaints == []
    assert program.asked == [page.as_uri()]


def red_and_blue(picture):
    """Mean rows of the stem (red) and of the ball (blue) on the stage."""
    stage = picture[60:500, :980]
    r, g, b = np.moveaxis(stage, -1, 0)
    red = (r > 1.6 * b) & (r > 1.6 * g) & (r > 80)
    blue = (b > 1.5 * r) & (b > 100)
    assert blue.sum() > 2000
    return (np.mean(np.nonzero(red)[0]) if red.sum() > 30 else None), np.mean(np.nonzero(blue)[0])


@needs_browser
def test_top_turns_over(shown, inputs, chromium):
    path, page = shown(inputs / "tippe_top.nml")
    assert page.stat().st_size < 1.5e6
    chromium.open(page)
    for number in (4, 5, 6, 7, 3):  # bodies alone
        chromium.key(str(number))
    chromium.key("f")
    stem, hull = red_and_blue(chromium.picture())
    assert stem < hull - 20  # upright
    chromium.value("contensou.seek(8)")
    stem, hull = red_and_blue(chromium.picture())
    assert stem is None or stem > hull + 20  # on its stem
    with h5py.File(path) as file:
        rows = file["trajectory"]
        pick = np.linspace(0, len(rows["time"]) - 1, 60).astype(int)
        drawn = poses(chromium, rows["time"][()][pick])
        true = np.concatenate([rows["position"][()][pick], rows["quaternion"][()][pick]], axis=2)
    off = np.linalg.norm(drawn[..., :3] - true[..., :3], axis=2)
    head = contents(page.read_text())[0]
    assert off.max() <= head["length"] * head["scale"]
    cosine = np.abs(np.sum(drawn[..., 3:] * true[..., 3:], axis=2))
    assert np.degrees(2 * np.arccos(np.minimum(cosine, 1))).max() <= head["angle"]
    clean(chromium, page)


@needs_browser
def test_keys_buttons_and_fingers(shown, chromium):
    page = shown(ball(end=1.0))[1]
    chromium.open(page)
    now = "contensou.state.t"
    events = chromium.value("[...contensou.events.time]")
    assert len(events) > 4
    chromium.key(".")
    assert chromium.value(now) == pytest.approx(events[0])
    chromium.click("#next")
    assert chromium.value(now) == pytest.approx(events[1])
    chromium.key(",")
    assert chromium.value(now) == pytest.approx(events[0])
    chromium.key("Home")
    assert chromium.value(now) == 0
    chromium.value("document.getElementById('speed').value = 10")
    chromium.value("document.getElementById('speed').dispatchEvent(new Event('change'))")
    chromium.key(" ")
    chromium.wait(f"{now} > 0")
    chromium.wait("!contensou.state.playing")
    assert chromium.value(now) == 1.0
    # Scrubbing: the slider, and a place of the charts.
    chromium.value("document.getElementById('time').value = 0.25")
    chromium.value("document.getElementById('time').dispatchEvent(new Event('input'))")
    assert chromium.value(now) == pytest.approx(0.25)
    x, y, w, h = chromium.value(
        "(r => [r.x, r.y, r.width, r.height])"
        "(document.getElementById('charts').getBoundingClientRect())"
    )
    chromium.drag((x + w / 2, y + h / 2), (x + w / 2, y + h / 2))
    assert chromium.value(now) == pytest.approx(0.5, abs=0.01)
    # The camera turns by a drag, and comes closer when two fingers go apart.
    place = "contensou.camera.position.toArray()"
    chromium.draw()
    before = chromium.value(place)
    chromium.drag((400, 300), (500, 320))
    chromium.draw()
    assert np.linalg.norm(np.subtract(chromium.value(place), before)) > 0.01
    distance = "contensou.camera.position.distanceTo(contensou.camera.position.clone().set(0,0,0))"
    before = chromium.value(distance)
    chromium.resize(1280, 720, touch=True)
    for apart in (40, 80, 160):
        chromium.touch((500 - apart, 300), (500 + apart, 300))
    chromium.touch()
    chromium.resize(1280, 720)
    chromium.draw()
    assert chromium.value(distance) < 0.6 * before
    # Riding: the body stands still in the picture, the ground turns.
    chromium.key("r")
    chromium.draw()
    up = chromium.value("contensou.camera.up.toArray()")
    chromium.value("contensou.seek(0.8)")
    chromium.draw()
    assert np.linalg.norm(np.subtract(chromium.value("contensou.camera.up.toArray()"), up)) > 0.1
    # Light and dark.
    light = chromium.picture()[300, 30].sum()
    chromium.key("d")
    assert abs(chromium.picture()[300, 30].sum() - light) > 150
    # Layers.
    chromium.key("1")
    chromium.draw()
    assert chromium.value("contensou.groups[0].visible") is False
    clean(chromium, page)


@needs_browser
def test_impacts_are_slow(shown, chromium):
    """An impact takes two seconds, some 1e-4 to 1e-3 of real time, however fast the rest goes."""
    page = shown(ball(end=0.4, interval=1e-4))[1]
    chromium.open(page)
    touch, lift = chromium.value("[...contensou.events.time]")[:2]
    for slow in (False, True):
        if slow:
            chromium.click("#slow")
        chromium.value(f"contensou.state.speed = 1, contensou.seek({touch}), contensou.play(false)")
        chromium.draw()
        chromium.value("document.activeElement.blur()")
        chromium.key(" ")
        # Frames are at most a tenth of a second long.
        chromium.value(
            "new Promise(done => { const first = contensou.drawn.frames; (function go() {"
            "if (contensou.drawn.frames < first + 6) requestAnimationFrame(go);"
            "else { contensou.play(false); done(0); } })(); })"
        )
        shown_time = chromium.value("contensou.state.t")
        assert (touch < shown_time < lift + (lift - touch)) is slow
    clean(chromium, page)


@needs_browser
def test_arrows_grow_with_the_force(shown, chromium):
    page = shown(ball(end=0.4, height=0.05, interval=1e-4))[1]
    chromium.open(page)
    found = np.array(
        chromium.value(
            "Array.from({length: 400}, (_, i) => { contensou.seek(i * 1e-3); contensou.draw();"
            "const c = contensou.contacts[0], m = contensou.scene.getObjectByName('normal forces')"
            ".children[1].matrices;"
            "return [c.open ? 0 : c.values[0], m[14], c.open ? 0 : c.point.z]; })"
        )
    )
    force, tip, foot = found[found[:, 0] > 0].T
    length = tip - foot
    assert len(force) > 8
    order = np.argsort(force)
    assert (np.diff(length[order]) >= -1e-6).all()
    assert length.max() > 1.5 * length.min() > 0
    clean(chromium, page)


@needs_browser
def test_hostile_texts_are_texts(shown, chromium):
    title = "'" + HOSTILE.replace("'", "''") + "'"
    path, _ = shown(ball(title=title, end=0.05))
    with h5py.File(path, "a") as file:
        for name in ("body/name", "trajectory/body"):
            file[name][0] = HOSTILE
        names = file["surface/body"][()].tolist()
        names[0] = HOSTILE.encode()
        file["surface/body"][...] = names
    page = path.with_name("hostile.html")
    page.write_text(viewing.view(path), encoding="utf-8")
    assert page.read_text().count("<script") == 2 + len(pages.SCRIPTS["view"])
    assert "struck" not in page.read_text()
    chromium.open(page)
    assert chromium.value("document.getElementById('title').textContent") == HOSTILE
    assert chromium.value("document.title") == HOSTILE
    assert chromium.value("document.images.length") == 0
    assert chromium.value("window.struck ?? 0") == 0
    assert chromium.value("document.getElementById('body').options[0].text") == HOSTILE
    # What a page of this policy refuses, should a text get through all the same.
    chromium.value("document.body.insertAdjacentHTML('beforeend', '<img src=x onerror=struck=1>')")
    chromium.draw()
    assert chromium.value("window.struck ?? 0") == 0


@needs_browser
def test_shapes_of_extensions(shown, chromium):
    """A shape that the page does not know: it says so, and shows where the surface was touched."""
    path, _ = shown(ball(end=0.5, motion="spin = 0, 5, 0, velocity = 0.1, 0, 0"))
    with h5py.File(path, "a") as file:
        shapes = file["surface/shape"][()].tolist()
        assert shapes[0] == b"sphere"
        shapes[0] = b"superegg"
        file["surface/shape"][...] = shapes
    page = path.with_name("egg.html")
    page.write_text(viewing.view(path), encoding="utf-8")
    chromium.open(page)
    assert "skin (superegg)" in chromium.value("document.getElementById('about').textContent")
    points = np.array(
        chromium.value(
            "[...contensou.groups[0].getObjectByName('skin').geometry.attributes.position.array]"
        )
    ).reshape(-1, 3)
    assert len(points) > 3
    assert np.abs(np.linalg.norm(points, axis=1) - 0.02).max() < 2e-4
    chromium.picture()
    clean(chromium, page)


SCENES = sorted([*(ROOT / "inputs").glob("*.nml"), *(ROOT / "inputs/examples").glob("*.nml")])


@needs_browser
@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_every_shipped_scene_opens(shown, chromium, path):
    end = re.search(r"t_end\s*=\s*([0-9.eE+-]+)", path.read_text())[1]
    page = shown(path, "--set", f"scene.t_end={float(end) / 50}")[1]
    assert page.stat().st_size < 1.5e6
    chromium.open(page)
    chromium.value("contensou.seek(contensou.head.end / 2)")
    picture = chromium.picture()
    assert picture[60:480, 50:950].std() > 3
    assert_light(chromium)
    clean(chromium, page)


def assert_light(program, triangles=20_000):
    """What a frame costs where the processor draws: triangles, calls, pixels, and what is painted
    beside them. `frames.py` measures the time it takes."""
    # So slow that no run ends meanwhile.
    program.value("contensou.state.speed = Math.min(1e-6, contensou.head.end / 100)")
    program.value("contensou.play(true)")
    painted, changed, moved = program.value(
        "new Promise(done => { const pen = document.getElementById('spot').getContext('2d');"
        "const clear = pen.clearRect; let painted = 0; pen.clearRect = (...at) => {"
        "painted += 1; clear.apply(pen, at); }; const start = performance.now();"
        "let changed = 0, moved = 0, before = document.getElementById('time').value;"
        "const watch = new MutationObserver(all => { changed += all.length; });"
        "watch.observe(document.getElementById('clock'), { childList: true });"
        "(function go() { const now = document.getElementById('time').value;"
        "if (now !== before) moved += 1; before = now;"
        "if (performance.now() - start < 500) requestAnimationFrame(go);"
        "else { pen.clearRect = clear; watch.disconnect(); done([painted, changed, moved]); }"
        "})(); })"
    )
    assert max(painted, changed, moved) <= 5
    calls, drawn, wide, high = program.value(
        "(r => [r.info.render.calls, r.info.render.triangles, r.domElement.width,"
        "r.domElement.height])(contensou.renderer)"
    )
    program.value("contensou.play(false)")
    assert calls <= 50
    assert drawn <= triangles
    assert wide * high <= 1280 * 720


def of_contact(program, number, time):
    """Values of a contact at a time, and what the tractions of its spot make: their force and
    torque in parts of f N and f N sqrt(a b), by the middles of many fields, and the share that
    sticks."""
    return program.value(
        f"contensou.seek({time}), contensou.draw(), (c => {{ const t = page.tractionOf(c, 0),"
        "sum = [0, 0, 0, 0], [a, b] = c.values.slice(7, 9), n = 60; let all = 0;"
        "for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) {"
        "const x = (2 * i + 1) / n - 1, y = (2 * j + 1) / n - 1; if (x * x + y * y > 1) continue;"
        "const p = t(x, y), most = Math.sqrt(1 - x * x - y * y); all += most; sum[0] += p.x;"
        "sum[1] += p.y; sum[2] += (x * a * p.y - y * b * p.x) / Math.sqrt(a * b);"
        "sum[3] += p.sticks ? 1 : 0; } return [[...c.values], sum.slice(0, 3).map(s => s / all),"
        f"sum[3] / (Math.PI / 4 * n * n), c.memory || null]; }})(contensou.contacts[{number}])"
    )


@needs_browser
def test_tractions_of_rolling_spots_make_the_force(shown, chromium):
    """Of what rolls the spot sticks where it is entered, and its tractions make the force of the
    run: strength and direction."""
    scene = ROOT / "inputs/examples/rolling_bend.nml"
    path, page = shown(scene, "--set", "scene.t_end=1")
    chromium.open(page)
    values, made, share, memory = of_contact(chromium, 0, 0.8)
    assert memory["kind"] == "rolling"
    limit = memory["coefficient"] * values[0]
    root = (values[7] * values[8]) ** 0.5
    force = np.array([values[1] / limit, values[2] / limit, values[3] / (limit * root)])
    assert np.linalg.norm(made) == pytest.approx(np.linalg.norm(force), rel=0.03)
    assert np.array(made) @ force > 0.9 * np.linalg.norm(made) * np.linalg.norm(force)
    assert 0.1 < share < 0.9
    # Where the material comes in it sticks, where it leaves it slips.
    with h5py.File(path) as file:
        row = int(np.searchsorted(file["trajectory/time"][()], 0.8))
        passing = file["trajectory/rolling_velocity"][row, 0]
        major = file["trajectory/major_direction"][row, 0]
        minor = np.cross(file["trajectory/contact_normal"][row, 0], major)
    along = np.array([passing @ major, passing @ minor]) / np.linalg.norm(passing)
    ends = chromium.value(
        f"[-0.93, 0.93].map(s => page.tractionOf(contensou.contacts[0], 0)(s * {along[0]},"
        f"s * {along[1]}).sticks)"
    )
    assert ends == [True, False]
    assert "sticks in" in chromium.value("document.getElementById('figures').textContent")
    clean(chromium, page)


@needs_browser
def test_stuck_zone_of_elastic_spots(shown, chromium):
    """Of a stool on an incline below the limit the spots stick; their tractions make the force."""
    page = shown(ROOT / "inputs/examples/incline.nml", "--set", "scene.t_end=0.5")[1]
    chromium.open(page)
    values, made, share, memory = of_contact(chromium, 0, 0.5)
    assert (memory["kind"], memory["width"]) == ("elastic", 1)
    assert share == pytest.approx(values[9], abs=0.05)
    assert values[9] > 0.99
    force = np.array(values[1:3]) / (memory["coefficient"] * values[0])
    assert 0.3 < np.linalg.norm(force) < 1
    assert np.array(made[:2]) == pytest.approx(force, rel=0.03, abs=0.01)
    assert "foot_1_incline: sticks" in chromium.value(
        "document.getElementById('figures').textContent"
    )
    # While it slips from the rim, the zone is what the run tells.
    with h5py.File(page.with_suffix(".h5")) as file:
        stuck = file["trajectory/stuck_share"][:, 0]
        times = file["trajectory/time"][()]
    part = np.flatnonzero((stuck > 0.1) & (stuck < 0.9))
    for row in part[:3]:
        values, _, share, _ = of_contact(chromium, 0, float(times[row]))
        assert share == pytest.approx(stuck[row], abs=0.06)
    clean(chromium, page)


@needs_browser
def test_wheels_rails_and_springs(shown, chromium):
    """Of cones and cylinders without ends there is the part that is touched, and springs hang
    between their points."""
    path, page = shown(ROOT / "inputs/examples/wheelset.nml", "--set", "scene.t_end=1")
    chromium.open(page)
    head = contents(page.read_text())[0]
    assert 1 < head["scale"] < 10
    wheel, rail = (
        np.array(
            chromium.value(
                f"[].concat(...contensou.scene.getObjectsByProperty('name', '{name}')"
                ".map(m => { const p = m.geometry.attributes.position, all = [];"
                "for (let i = 0; i < p.count; i++) all.push([p.getX(i), p.getY(i), p.getZ(i), 1]);"
                "return all.map(([x, y, z]) => { const e = m.matrix.elements;"
                "return [0, 1, 2].map(k => e[k] * x + e[4 + k] * y + e[8 + k] * z + e[12 + k]);"
                "}); }))"
            )
        )
        for name in ("left_wheel", "left_rail")
    )
    assert 0.45 < np.hypot(wheel[:, 0], wheel[:, 2]).max() < 0.48
    assert (wheel[:, 1].min(), wheel[:, 1].max()) == pytest.approx((0.6, 0.9), abs=0.1)
    assert -1 < rail[:, 0].min() < 0 < 40 < rail[:, 0].max() < 42
    chromium.value("contensou.seek(0.7), contensou.draw()")
    with h5py.File(path) as file:
        row = int(np.searchsorted(file["trajectory/time"][()], 0.7))
        force = file["trajectory/spring_force"][row]
        largest = np.abs(file["trajectory/spring_force"][()]).max()
        place = file["trajectory/position"][row]
        turn = thinning.matrices(file["trajectory/quaternion"][row])
        points = [file[f"spring/{key}_point"][()] for key in ("first", "second")]
    for i in range(2):
        ends, drawn = chromium.value(
            f"(s => [s.ends.map(e => e.toArray()), s.force.toArray()])(contensou.springs[{i}])"
        )
        for k, body in enumerate((1, 0)):
            expected = place[body] + turn[body] @ points[k][i]
            assert np.linalg.norm(ends[k] - expected) < 2e-3 * head["scale"]
        assert np.abs(np.array(drawn) - force[i]).max() < 0.02 * largest
    with_springs = chromium.picture()
    chromium.key("s")
    assert (chromium.picture() != with_springs).any(axis=2).sum() > 20
    clean(chromium, page)


@needs_browser
def test_friction_is_seen_on_the_spot(shown, chromium):
    """Spots do not hide the arrows of friction that begin in them."""
    page = shown(ROOT / "inputs/examples/incline.nml", "--set", "scene.t_end=0.5")[1]
    chromium.open(page)
    chromium.key("End")
    both = chromium.picture()[60:480, :950]
    chromium.key("5")
    without = chromium.picture()[60:480, :950]
    green = (both[..., 1] > both[..., 0] + 30) & (both[..., 1] > both[..., 2] + 30)
    assert (green & (both != without).any(axis=2)).sum() > 30
    clean(chromium, page)


@needs_browser
def test_a_thousand_balls(shown, chromium):
    scene = """&scene title = 'balls', gravity = 0, 0, -9.81, t_end = 0.012 /
&defaults material = 'rubber', shape = 'sphere', radius = 0.01 /
&material name = 'rubber', young = 1e6, poisson = 0.4 /
&body name = 'ball', mass = 0.004, inertia = 3*1.6e-7, count = 40, 25, spacing = 0.03, 0.03,
   position = 0, 0, 0.0101, velocity = 1, 0, 0, spin = 3, 0, 7 /
&surface name = 'skin', body = 'ball' /
&surface name = 'floor', body = 'ground', shape = 'plane' /
&contacts surfaces = 'skin*', 'floor', friction = 'pade22', friction_coefficient = 0.3,
   damping = 'hunt_crossley', restitution = 0.7 /
&integrator method = 'cvode_bdf', rtol = 1e-4 /
&output interval = 1e-3 /"""
    path, page = shown(scene)
    assert page.stat().st_size < 20e6
    chromium.open(page)
    with h5py.File(path) as file:
        times = file["trajectory/time"][()]
        pick = [0, len(times) // 2, len(times) - 1]
        position = file["trajectory/position"][()][pick]
        frames = thinning.matrices(file["trajectory/quaternion"][()][pick])
    drawn = np.array(
        chromium.value(
            f"{json.dumps(times[pick].tolist())}.map(t => {{ contensou.seek(t); contensou.draw();"
            "const all = []; for (const mesh of contensou.crowds) mesh.userData.of.forEach("
            "({group}, i) => { all[group.userData.body] ="
            "[...mesh.matrices.slice(16 * i, 16 * i + 16)]; }); return all; })"
        )
    ).reshape(3, 1000, 4, 4)
    head = contents(page.read_text())[0]
    off = np.linalg.norm(drawn[..., 3, :3] - position, axis=-1)
    assert off.max() <= head["length"] * head["scale"]
    turned = np.einsum("...ji,...jk->...ik", frames, np.swapaxes(drawn[..., :3, :3], -1, -2))
    cosine = 0.5 * (np.trace(turned, axis1=-2, axis2=-1) - 1)
    assert np.degrees(np.arccos(np.minimum(cosine, 1))).max() <= head["angle"]
    assert_light(chromium, triangles=250_000)
    # A ball that is seen can be followed by a double click.
    place = chromium.value(
        "contensou.seek(0), contensou.draw(), (v => [(v.x + 1) / 2, (1 - v.y) / 2])"
        "(contensou.groups[500].position.clone().project(contensou.camera))"
    )
    high = chromium.value("document.getElementById('stage').clientHeight")
    at = (round(place[0] * 1280), round(place[1] * high))
    for count in (1, 2):
        for kind in ("mousePressed", "mouseReleased"):
            chromium.call(
                *("Input.dispatchMouseEvent",),
                **{"type": kind, "x": at[0], "y": at[1], "button": "left", "clickCount": count},
            )
    assert chromium.value("[contensou.state.camera, contensou.state.body]") == ["follow", 500]
    clean(chromium, page)


@needs_browser
def test_one_looks_into_a_bearing(shown, inputs, chromium):
    page = shown(inputs / "bearing_6205.nml", "--set", "scene.t_end=0.002")[1]
    chromium.open(page)
    for number in (4, 5, 6, 7, 3):
        chromium.key(str(number))
    with_rings = chromium.picture()[60:500, :980]
    hidden = "contensou.groups.forEach(g => g.children.forEach(m => { if (%s) m.visible = false }))"
    chromium.value(hidden % "m.userData.shape === 'torus'")
    chromium.value("contensou.state.dirty = true")
    balls = chromium.picture()[60:500, :980]
    chromium.value(hidden % "true")
    chromium.value("contensou.state.dirty = true")
    empty = chromium.picture()[60:500, :980]
    of_balls = (balls != empty).any(axis=2)
    assert of_balls.sum() > 3000
    # Most of what there is of the balls is seen with the rings, too, and these are there.
    seen = (with_rings == balls).all(axis=2) & of_balls
    assert seen.sum() > 0.6 * of_balls.sum()
    assert ((with_rings != empty).any(axis=2) & ~of_balls).sum() > 3000
    clean(chromium, page)
