"""`contensou run --resume`: runs that are killed again and again end like one that is not."""

from __future__ import annotations

import contextlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from conftest import ROOT
from programs import stopped

INPUTS = ROOT / "inputs"

# Many impacts, each with a damping of its own; an explicit method.
BALL = """\
&scene title = 'ball', gravity = 0, 0, -9.81, t_end = 3.0 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', mass = 0.0327, inertia = 3*1.31e-6, position = 0, 0, 0.21, spin = 0, 50.0, 0 /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 0.01, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /
&contact name = 'ball_floor', surfaces = 'ball', 'floor', damping = 'hunt_crossley',
         restitution = 0.9, friction = 'contensou_exact', friction_coefficient = 0.2,
         regularization_velocity = 1.0e-2 /
&integrator method = 'explicit8', rtol = 1e-9, max_step = 1.0e-4 /
&output file = 'top.h5', interval = 2.0e-4 /
"""

# Curvatures that change, closest points found by a search, two contacts, no dissipation.
EGG = """\
&scene title = 'egg', gravity = 0, 0, -9.81, t_end = 0.6 /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body name = 'egg', mass = 0.05, inertia = 1.2e-5, 1.2e-5, 8.0e-6, position = 0, 0, 0.0212,
      axis = 1, 0, 0, angle = 1.5, spin = 3.0, 20.0, 5.0 /
&surface name = 'shell', body = 'egg', shape = 'ellipsoid', semi_axes = 0.02, 0.02, 0.03,
         material = 'wood' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'wood' /
&surface name = 'bowl', body = 'ground', shape = 'sphere', radius = 0.2, side = 'inside',
         centre = 0, 0, 0.195, material = 'wood' /
&contact name = 'shell_floor', surfaces = 'shell', 'floor', damping = 'hunt_crossley',
         damping_coefficient = 2.0, friction = 'contensou_simplified', friction_coefficient = 0.2 /
&contact name = 'shell_bowl', surfaces = 'shell', 'bowl', damping = 'hunt_crossley',
         damping_coefficient = 2.0 /
&integrator method = 'cvode_bdf', rtol = 1e-9 /
&output file = 'top.h5', interval = 1.0e-4 /
"""

# A drive whose ramp ends while the run goes on; work is supplied; three unknown works.
DRIVE = """\
&scene title = 'drive', gravity = 0, 0, -9.81, t_end = 3.0 /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body name = 'ball', mass = 0.05, inertia = 3*8.0e-6, position = 0, 0, 0.02, spin = 0, 0, 40.0 /
&body name = 'belt', motion = 'prescribed', ramp_duration = 1.5, velocity = 0, 0, 0,
      final_velocity = 0.3, 0, 0 /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 0.02, material = 'wood' /
&surface name = 'belt', body = 'belt', shape = 'plane', material = 'wood' /
&contact name = 'ball_belt', surfaces = 'ball', 'belt', damping = 'hunt_crossley',
         damping_coefficient = 100.0, friction = 'contensou_exact', friction_coefficient = 0.2 /
&integrator method = 'cvode_adams', rtol = 1e-8 /
&output file = 'top.h5', interval = 1.0e-4 /
"""

# Explicit while the ball spins, implicit when it rests: `auto` changes once.
SPIN = """\
&scene title = 'spin', gravity = 0, 0, -9.81, t_end = 1.6 /
&material name = 'rubber', young = 1.0e6, poisson = 0.5 /
&body name = 'ball', mass = 0.5, inertia = 3*1.8e-4, position = 0, 0, 0.0298, spin = 0, 0, 30.0 /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 0.03, material = 'rubber' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'rubber' /
&contact name = 'ball_floor', surfaces = 'ball', 'floor', damping = 'hunt_crossley',
         damping_coefficient = 10.0, friction = 'contensou_exact', friction_coefficient = 0.3 /
&integrator method = 'auto', rtol = 1e-8 /
&output file = 'top.h5', interval = 2.0e-5 /
"""

# The integrator begins anew where a run was stopped, so that it takes other steps than in a run in
# a piece, and its errors, which the relative tolerance bounds, are others. So are they when the
# relative tolerance is slightly smaller: a continued run may differ from the uninterrupted one by
# as much as the farthest of those runs does, times MARGIN. There must be many of them, as their
# errors scatter widely: for the top, half of them differ by less than a twentieth of what the
# farthest does. So do those of continued runs: of 460 (top, drive, spin, ball) 9 in 10 differ by
# less than twice the farthest, the worst by 12.6 times as much. COARSEST is what a difference may
# be at most of the state, relative to its largest value; forgetting anything costs more.
VARIATIONS = tuple(1.0 - 0.04 * k for k in range(1, 13))
MARGIN = 20.0
COARSEST = 1e-3
STATE = [f"/trajectory/{name}" for name in ("position", "velocity", "quaternion", "work_friction")]

TIGHT = "--checkpoint=0.01"


def cases(scene_text):
    """The scenes by name."""
    rigid = (INPUTS / "tippe_top_rigid.nml").read_text()
    rigid = re.sub(r"t_end = \S+", "t_end = 2.5", rigid)
    return {
        "rigid": re.sub(r"&output file = \S+, interval = \S+", "&output interval = 2e-5", rigid),
        "spin": SPIN,
        "top": scene_text.replace("t_end = 0.02", "t_end = 2.2"),
        "ball": BALL,
        "egg": EGG,
        "drive": DRIVE,
    }


def complete(run, name="whole.h5", *words):
    """The uninterrupted run, and how long it takes [s]."""
    begin = time.monotonic()
    result = run("run", "top.nml", "-q", "--force", "-o", name, *words, timeout=600)
    assert result.status == 0, result.err
    return time.monotonic() - begin


def reals(path):
    """All data sets of reals that are results."""
    with h5py.File(path) as file:
        return {
            f"/{group}/{name}": item[()]
            for group in ("trajectory", "events", "summary")
            for name, item in file[group].items()
            if item.dtype.kind == "f" and name != "cpu_s"
        }


def admissible(run, tmp_path):
    """Rules for `contensou diff`, from runs with slightly smaller tolerances.

    Any build will do for them: how far results scatter is a matter of the scene and the integrator.
    """
    rtol = float(re.search(r"rtol = ([\d.e-]+)", (tmp_path / "top.nml").read_text())[1])
    whole = reals(tmp_path / "whole.h5")
    spread = dict.fromkeys(whole, 0.0)
    for factor in VARIATIONS:
        complete(run, "varied.h5", "--set", f"integrator.rtol={rtol * factor}")
        for path, values in reals(tmp_path / "varied.h5").items():
            assert values.shape == whole[path].shape, "the scene is too sensitive for this test"
            if values.size:
                spread[path] = max(spread[path], np.abs(values - whole[path]).max())
    lines = ["/integrator ignore", "/integrator/* ignore", "/summary/steps ignore"]
    lines.append("/summary/right_hand_sides ignore")
    # A row as close to an event as that may be off is before it in one run, after it in another.
    t, events = whole["/trajectory/time"], whole["/events/time"]
    off = MARGIN * spread["/events/time"]
    near = np.abs(t[:, None] - events).min(axis=1, initial=np.inf) <= off
    near[1:-1] |= near[:-2] | near[2:]
    for path, values in whole.items():
        # The last row is one of the trajectory.
        same = spread.get(path.replace("/summary/", "/trajectory/"), 0.0)
        largest = np.abs(values).max(initial=0.0)
        tolerance = MARGIN * max(spread[path], same) + 1e-12 * largest
        if path.startswith("/trajectory/") and path not in STATE:
            tolerance = max(tolerance, np.abs(values[near]).max(initial=0.0))
        if path in STATE:
            assert tolerance <= COARSEST * largest, "the scene is too sensitive for this test"
        lines.append(f"{path} {tolerance} 0")
    return "\n".join([*lines, "/trajectory/time 0 0", ""])


def compare(run, tmp_path, rules):
    """The continued run is the uninterrupted one within the tolerance; how many lives it had."""
    (tmp_path / "rules").write_text(rules)
    result = run("diff", "whole.h5", "top.h5", "--rules", "rules")
    assert result.status == 0, result.out + result.err
    with h5py.File(tmp_path / "whole.h5") as a, h5py.File(tmp_path / "top.h5") as b:
        assert b.attrs["status"] == "complete"
        # No row and no event is lost, none is there twice.
        assert np.array_equal(a["trajectory/time"][()], b["trajectory/time"][()])
        for name in ("kind", "contact"):
            assert a["events"][name].asstr()[:].tolist() == b["events"][name].asstr()[:].tolist()
        assert list(a["integrator/method"]) == list(b["integrator/method"])
        assert a["provenance/lives"][()] == 1
        return int(b["provenance/lives"][()])


def live(executable, tmp_path, *words, kill=None, after=0.0):
    """One life of a run: its exit status and what it says; `kill` is sent after some seconds."""
    process = subprocess.Popen(
        [str(executable), "run", "top.nml", *words],
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    try:
        if kill is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(timeout=after)
            process.send_signal(kill)
        _, err = process.communicate(timeout=600)
    finally:
        if process.poll() is None:
            process.kill()
    return process.returncode, err.decode()


# With 0 s between checkpoints the file is written nearly all the time, and most kills hit that.
CAMPAIGNS = {
    ("top", "0.02"): 14,
    ("ball", "0.02"): 12,
    ("egg", "0.02"): 12,
    ("drive", "0.02"): 12,
    ("rigid", "0.02"): 12,
    ("spin", "0.02"): 12,
    ("top", "0"): 10,
}


@pytest.mark.parametrize(("name", "interval"), CAMPAIGNS)
def test_kills_at_random_moments(
    run, quick_run, executable, tmp_path, scene_text, build_kind, name, interval
):
    # 74 kills and 10 more in the release build; the checked build is slow.
    wanted = CAMPAIGNS[name, interval] if build_kind == "release" else 2
    (tmp_path / "top.nml").write_text(cases(scene_text)[name])
    seconds = complete(run)
    rules = admissible(quick_run, tmp_path)
    dice = random.Random(f"{name} {interval}")
    kills = lives = 0
    while kills < wanted:
        for path in tmp_path.glob("top.h5*"):
            path.unlink()
        ended = False
        deaths = 0
        while not ended:
            number = dice.choice([signal.SIGTERM, signal.SIGKILL])
            # Later lives have less to do; after three of them the run is left in peace.
            kill = number if deaths < 3 else None
            status, err = live(
                executable,
                tmp_path,
                "--resume",
                f"--checkpoint={interval}",
                kill=kill,
                after=dice.uniform(0.0, 0.8) * seconds,
            )
            assert "error" not in err, err
            ended = status == 0
            if not ended:
                # A signal that comes before it is caught ends the program, too.
                assert status in {75, -number}, err
                # A life that ends early tells how to go on, or that there is nothing to go on from:
                # none before it, or only one that was killed before its first checkpoint.
                part = tmp_path / "top.h5.part"
                told = "--resume" in err or "beginning from the start" in err
                assert status != 75 or told or not part.exists(), err
                # A kill can come between the last row and the end of the program.
                assert status == -number or not (tmp_path / "top.h5").exists()
                deaths += 1
        kills += deaths
        lives = max(lives, compare(run, tmp_path, rules))
        assert {path.name for path in tmp_path.glob("top.h5*")} == {"top.h5"}
    assert lives > 1


def interrupted(executable, tmp_path, *words, number=signal.SIGTERM):
    """A run of a Tippe-Top that is stopped after its first rows, with a checkpoint."""
    return stopped(executable, tmp_path, ["run", "top.nml", TIGHT, "-q", *words], "top.h5", number)


@pytest.fixture
def long_scene(tmp_path, scene_text):
    """A Tippe-Top that takes so long that it can be stopped."""
    (tmp_path / "top.nml").write_text(scene_text.replace("t_end = 0.02", "t_end = 2.2"))


@pytest.mark.usefixtures("long_scene")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_rows_of_a_stopped_run_are_kept(run, executable, tmp_path, number):
    err = interrupted(executable, tmp_path, number=number)
    assert number == signal.SIGKILL or "--resume continues the run" in err
    before = (tmp_path / "top.h5.part").read_bytes()
    result = run("run", "top.nml", "-q")
    assert result.status == 74
    assert "--resume" in result.err
    assert "--force" in result.err
    assert (tmp_path / "top.h5.part").read_bytes() == before
    # The copy of an earlier life, alone, is kept as well, and taken.
    (tmp_path / "top.h5.part").rename(tmp_path / "top.h5.part.old")
    result = run("run", "top.nml", "-q")
    assert result.status == 74
    assert "top.h5.part.old" in result.err
    (tmp_path / "top.h5.part").write_bytes(b"an empty or half-copied file")
    result = run("run", "top.nml", "--resume")
    assert result.status == 0, result.err
    assert "resuming at t = " in result.err
    assert {path.name for path in tmp_path.glob("top.h5*")} == {"top.h5"}
    with h5py.File(tmp_path / "top.h5") as file:
        assert file["provenance/lives"][()] == 2


@pytest.mark.usefixtures("long_scene")
def test_force_begins_anew(run, executable, tmp_path):
    interrupted(executable, tmp_path)
    shutil.copy(tmp_path / "top.h5.part", tmp_path / "top.h5.part.old")
    result = run("run", "top.nml", "-q", "--force")
    assert result.status == 0, result.err
    assert {path.name for path in tmp_path.glob("top.h5*")} == {"top.h5"}
    with h5py.File(tmp_path / "top.h5") as file:
        assert file["provenance/lives"][()] == 1


@pytest.mark.usefixtures("long_scene")
def test_a_complete_file_is_in_the_way(run, executable, tmp_path):
    (tmp_path / "top.h5").write_bytes(b"")
    err = interrupted(executable, tmp_path, "--force")
    assert "--resume continues the run once top.h5 is moved away" in err
    (tmp_path / "top.h5").unlink()
    assert run("run", "top.nml", TIGHT, "-q", "--resume").status == 0
    interrupted(executable, tmp_path, "--force")
    result = run("run", "top.nml", TIGHT, "--resume")
    assert result.status == 0
    assert "top.h5 is complete; to go on with the run of top.h5.part, move it away" in result.err
    (tmp_path / "top.h5").unlink()
    result = run("run", "top.nml", TIGHT, "--resume")
    assert result.status == 0
    assert "resuming at t = " in result.err


def test_nothing_to_resume(run, scene):
    result = run("run", scene, "--resume")
    assert result.status == 0
    assert "nothing to resume" in result.err
    assert result.out != ""
    before = (scene.parent / "top.h5").read_bytes()
    # Now it is complete.
    result = run("run", scene, "--resume")
    assert result.status == 0
    assert "top.h5 is complete" in result.err
    assert result.out == ""
    assert (scene.parent / "top.h5").read_bytes() == before
    result = run("run", scene, "--resume", "-q")
    assert (result.status, result.out, result.err) == (0, "", "")
    result = run("run", scene, "--resume", "-q", "-o", "other.h5")
    assert (result.status, result.err) == (0, "")


@pytest.mark.parametrize(
    ("override", "words"),
    [
        (
            "contact.stem_floor.friction_coefficient=0.31",
            "contact.friction_coefficient is 0.3 in it and 0.31 here, in contact 'stem_floor'",
        ),
        ("scene.t_end=2.3", "scene.t_end is 2.2 in it and 2.3 here"),
        ("output.interval=2e-3", "output.interval is 1.0e-3 in it and 2.0e-3 here"),
        ("integrator.max_step=1e-3", "integrator has "),
    ],
)
@pytest.mark.usefixtures("long_scene")
def test_another_scene(run, executable, tmp_path, override, words):
    interrupted(executable, tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    result = run("run", "top.nml", "--resume", "--set", override)
    assert result.status == 74
    assert words in result.err
    assert "--force" in result.err
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    # Of a complete run likewise.
    assert run("run", "top.nml", "--resume", "-q").status == 0
    result = run("run", "top.nml", "--resume", "--set", override)
    assert result.status == 74
    assert words in result.err


@pytest.mark.usefixtures("long_scene")
def test_a_damaged_checkpoint(run, executable, tmp_path):
    interrupted(executable, tmp_path)
    path = tmp_path / "top.h5.part.checkpoint"
    good = path.read_bytes()
    dice = random.Random(1)
    bad = [b"", good[:-1], good[: len(good) // 2], b"contensou-checkpoint 9\n" + good]
    for _ in range(20):
        changed = bytearray(good)
        changed[dice.randrange(len(good))] ^= 1 << dice.randrange(7)
        bad.append(bytes(changed))
    for content in bad:
        path.write_bytes(content)
        result = run("run", "top.nml", "--resume", "-q")
        assert result.status == 74, content
        assert "top.h5.part.checkpoint" in result.err
        assert "--force" in result.err
        assert not (tmp_path / "top.h5").exists()
    path.write_bytes(good)
    assert run("run", "top.nml", "--resume", "-q").status == 0


@pytest.mark.usefixtures("long_scene")
def test_a_kill_after_the_last_row(run, executable, tmp_path):
    # The result is there under its name, and what was to be removed next as well.
    interrupted(executable, tmp_path)
    checkpoint = tmp_path / "top.h5.part.checkpoint"
    kept = checkpoint.read_bytes()
    assert run("run", "top.nml", "--resume", "-q").status == 0
    rows = (tmp_path / "top.h5").read_bytes()
    old = tmp_path / "top.h5.part.old"
    lock = tmp_path / "top.h5.part.lock"
    for path in (checkpoint, old, lock):
        path.write_bytes(kept)
    result = run("run", "top.nml", "--resume")
    assert (result.status, result.out) == (0, "")
    assert "top.h5 is complete" in result.err
    assert {path.name for path in tmp_path.glob("top.h5*")} == {"top.h5"}
    assert (tmp_path / "top.h5").read_bytes() == rows
    # A run that is to replace it has a file, too, and keeps its checkpoint.
    part = tmp_path / "top.h5.part"
    for path in (checkpoint, part):
        path.write_bytes(kept)
    assert run("run", "top.nml", "--resume").status == 0
    assert checkpoint.read_bytes() == part.read_bytes() == kept


@pytest.mark.usefixtures("long_scene")
def test_another_version(run, executable, tmp_path):
    interrupted(executable, tmp_path)
    path = tmp_path / "top.h5.part.checkpoint"

    def rewrite(name, value):
        lines = path.read_text().splitlines(keepends=True)[:-1]
        lines = [
            f"text {name} {len(value)} {value}\n" if line.split()[1] == name else line
            for line in lines
        ]
        total, data = 0xCBF29CE484222325, "".join(lines).encode()
        words = len(data) // 8 * 8
        for place in range(0, words, 8):
            word = int.from_bytes(data[place : place + 8], sys.byteorder)
            total = (total ^ word) * 0x100000001B3 % 2**64
            total ^= total >> 32
        for byte in data[words:]:
            total = (total ^ byte) * 0x100000001B3 % 2**64
        path.write_text("".join([*lines, f"checksum {total:016X}\n"]))

    good = path.read_text()
    rewrite("program_version", "0.0.1")
    result = run("run", "top.nml", "--resume", "-q")
    assert result.status == 74
    assert "version 0.0.1" in result.err
    path.write_text(good)
    rewrite("git_commit", "0123456789ab")
    result = run("run", "top.nml", "--resume")
    assert result.status == 0, result.err
    assert "another build, 0123456789ab" in result.err


@pytest.mark.usefixtures("long_scene")
def test_rows_that_are_not_those_of_the_checkpoint(run, executable, tmp_path):
    interrupted(executable, tmp_path, number=signal.SIGKILL)
    part = tmp_path / "top.h5.part"
    with h5py.File(part, "r+") as file:
        file["trajectory/spin"][0, 0] += 1e-9
    result = run("run", "top.nml", "--resume", "-q")
    assert result.status == 0
    assert "the rows of spin are not those of its checkpoint" in result.err
    assert "beginning from the start" in result.err
    complete(run)
    assert run("diff", "whole.h5", "top.h5").status == 0
    # A file that cannot be read at all, at worst by making the library crash.
    content = bytearray((tmp_path / "top.h5").read_bytes())
    checkpoint = None
    for seed in range(8):
        for path in tmp_path.glob("top.h5*"):
            path.unlink()
        if checkpoint is None:
            interrupted(executable, tmp_path, number=signal.SIGKILL)
            content = part.read_bytes()
            checkpoint = (tmp_path / "top.h5.part.checkpoint").read_bytes()
        dice = random.Random(seed)
        changed = bytearray(content)
        for _ in range(200):
            changed[dice.randrange(min(len(changed), 50_000))] ^= 1 << dice.randrange(8)
        part.write_bytes(changed if seed else b"")
        (tmp_path / "top.h5.part.checkpoint").write_bytes(checkpoint)
        result = run("run", "top.nml", "--resume", "-q")
        assert result.status in {0, 74}, result.err
        assert result.status == 0 or "another scene" in result.err
        if result.status == 0:
            assert run("diff", "whole.h5", "top.h5", "--until", "0.01").status == 0


def test_a_failed_run_is_not_resumed(run, scene, scene_text, tmp_path):
    scene.write_text(scene_text.replace("young = 9.1e9", "young = 1.0e2"))
    result = run("run", scene, "-q")
    assert result.status == 1
    assert (tmp_path / "top.h5.part").exists()
    result = run("run", scene, "-q", "--resume")
    assert result.status == 1
    assert "failed" in result.err
    assert "--force" in result.err


def test_two_at_a_time(run, executable, tmp_path, scene_text):
    (tmp_path / "top.nml").write_text(scene_text.replace("t_end = 0.02", "t_end = 1e4"))
    process = subprocess.Popen(
        [str(executable), "run", "top.nml", "-q", TIGHT],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        end = time.monotonic() + 60
        while not (tmp_path / "top.h5.part.checkpoint").exists():
            assert time.monotonic() < end
            time.sleep(0.001)
        result = run("run", "top.nml", "--resume")
        assert result.status == 74
        assert "another run is writing top.h5.part" in result.err
    finally:
        process.kill()
        process.wait()


def test_options(run, scene):
    result = run("run", scene, "--resume", "--force")
    assert result.status == 2
    assert "--resume continues" in result.err
    for word in ("--checkpoint=-1", "--checkpoint=often", "--checkpoint=nan"):
        result = run("run", scene, word)
        assert result.status == 2
        assert "--checkpoint needs a time" in result.err
    assert run("run", scene, "--resume=yes").status == 2
    assert run("check", scene, "--resume").status == 2
    assert "did you mean '--resume'" in run("run", scene, "--resme").err
