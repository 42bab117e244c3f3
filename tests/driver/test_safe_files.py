"""Files are never lost, never misread, and names and texts do no harm."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import h5py
import pytest
from folders import SWEEP, content, good
from terminal import on_terminal

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "campaigns"))

import corruptions  # noqa: E402
import together  # noqa: E402

# --- 1: no command writes over its inputs ------------------------------------------------------


def spellings(folder, name):
    """Names of a file."""
    os.link(folder / name, folder / "hard")
    (folder / "soft").symlink_to(name)
    return [name, f"./{name}", str(folder / name), f"../{folder.name}/{name}", "hard", "soft"]


@pytest.mark.parametrize("force", [[], ["--force"]])
@pytest.mark.parametrize(
    ("command", "name"),
    [
        (["run", "scene.nml"], "scene.nml"),
        (["run", "scene.nml", "--resume"], "scene.nml"),
        (["sweep", "sweep.nml"], "scene.nml"),
        (["sweep", "sweep.nml"], "sweep.nml"),
        (["sweep", "cases.nml"], "cases.csv"),
        (["merge", "sweep.nml"], "scene.nml"),
        (["merge", "cases.nml"], "cases.csv"),
        (["merge", "a.h5", "b.h5"], "b.h5"),
        (["cost", "scene.nml"], "scene.nml"),
        (["cost", "scene.nml", "--csv"], "scene.nml"),
        (["equilibrium", "scene.nml"], "scene.nml"),
        (["equilibrium", "scene.nml", "--scene"], "scene.nml"),
        (["fmu", "scene.nml"], "scene.nml"),
    ],
)
def test_no_input_is_written_over(run, files, command, name, force):
    if "--resume" in command and force:
        pytest.skip("--resume and --force exclude each other")
    (files / "cases.nml").write_text(
        "&sweep scene = 'scene.nml', sampling = 'file', table = 'cases.csv' /\n"
    )
    (files / "cases.csv").write_text("top.angle\n0.1\n")
    for k, table in ((1, "a.h5"), (2, "b.h5")):
        if command[0] == "merge":
            good(run("sweep", "sweep.nml", "-q", "--cases", k, "-o", table))
    names = spellings(files, name)
    before = content(files)
    for spelling in names:
        option = [] if command[-1].startswith("--") and command[-1] != "--resume" else ["-o"]
        words = [*command, *option, spelling]
        result = run(*words, *force)
        assert result.status in (2, 74), (spelling, result)
        assert result.out == ""
        if "--resume" not in command:
            assert "is read" in result.err or "would replace the sweep file" in result.err, (
                result.err
            )
    assert content(files) == before


@pytest.mark.parametrize("name", ["scene.nml", "sweep.nml"])
def test_tables_do_not_replace_the_files_of_a_sweep(run, files, name):
    good(run("sweep", "sweep.nml", "-q", "--shard", "1/1", "-o", "a.h5"))
    before = content(files)
    result = run("merge", "a_shard_1_of_1.h5", "-o", name, "--force")
    assert result.status == 2
    assert f"the table {name} is a scene or a sweep, which is not replaced" in result.err
    assert content(files) == before


def test_no_input_is_written_over_beside_the_output(run, files):
    for name in ("x.h5.part", "x.h5.part.checkpoint"):
        os.link(files / "scene.nml", files / name)
        before = content(files)
        result = run("run", "scene.nml", "-o", "x.h5", "--force")
        assert result.status == 2
        assert name in result.err
        assert content(files) == before
        (files / name).unlink()


@pytest.mark.parametrize("tool", ["plot", "view", "spot"])
def test_a_picture_does_not_replace_what_it_shows(run, files, tool):
    good(run("run", "scene.nml", "-o", "x.png", "-q"))
    os.mkfifo(files / "pipe.png")
    (files / "link.png").symlink_to("scene.nml")
    before = content(files)
    shown = "a=1e-3,f=0.3,N=10,w=1" if tool == "spot" else "x.png"
    for name in ("x.png", "./x.png", "pipe.png", "link.png", ".")[2 * (tool == "spot") :]:
        done = plot(files, shown, "-o", name, tool=tool)
        read = "is the file that is read" in done.stderr
        assert done.returncode == (2 if read else 74)
        assert read or "would replace" in done.stderr
        assert content(files) == before


@pytest.mark.parametrize("tool", ["plot", "view"])
def test_pictures_are_written_whole(run, files, tool):
    """A limit on the size of files is a disk that is full."""
    good(run("run", "scene.nml", "-o", "x.h5", "-q"))
    (files / "old").write_text("what was there")
    before = content(files)

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    done = plot(files, "x.h5", "-o", "old", tool=tool, preexec_fn=limit)
    assert done.returncode == 74
    assert "old cannot be written: File too large" in done.stderr
    assert content(files) == before


def test_endings_of_pictures(run, files):
    good(run("run", "scene.nml", "-o", "x.h5", "-q"))
    done = plot(files, "x.h5", "-o", "x.zzz")
    assert (done.returncode, done.stdout) == (2, "")
    assert "no picture has the ending .zzz, only" in done.stderr
    for name, start in (("x", b"\x89PNG"), ("x.svg", b"<?xml"), ("x.pdf", b"%PDF")):
        done = plot(files, "x.h5", "-o", name)
        assert (done.returncode, done.stdout) == (0, f"{name}\n"), done.stderr
        assert (files / name).read_bytes().startswith(start)


def plot(folder, *words, tool="plot", **options):
    """Draw a picture."""
    return subprocess.run(
        [sys.executable, ROOT / "scripts" / f"{tool}.py", *words],
        cwd=folder,
        **options,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


# --- 2: only regular files are replaced --------------------------------------------------------


@pytest.mark.parametrize("kind", ["pipe", "socket", "folder", "device", "link", "loose link"])
def test_only_files_are_replaced(run, files, kind):
    node = files / "node"
    if kind == "pipe":
        os.mkfifo(node)
    elif kind == "socket":
        short = socket.socket(socket.AF_UNIX)
        here = os.getcwd()
        os.chdir(files)
        short.bind("node")
        os.chdir(here)
    elif kind == "folder":
        node.mkdir()
    elif kind == "device":
        node = Path("/dev/null")
    else:
        (files / "target").write_text("mine")
        node.symlink_to("target" if kind == "link" else "nothing")
    for words in (["run", "scene.nml"], ["sweep", "sweep.nml"], ["cost", "scene.nml"]):
        for options in ([], ["--force"]):
            result = run(*words, "-o", node, *options)
            assert result.status == 74, result
            assert "--force" not in result.err
            assert node.is_symlink() == ("link" in kind)
    assert kind != "link" or (files / "target").read_text() == "mine"
    assert not list(files.glob("*.part*"))


@pytest.mark.parametrize("suffix", [".part", ".part.old", ".part.checkpoint", ".part.lock"])
def test_nothing_but_files_beside_the_output(run, files, suffix):
    os.mkfifo(files / f"x.h5{suffix}")
    for option in ("--force", "--resume"):
        result = run("run", "scene.nml", "-o", "x.h5", option)
        assert result.status == 74
        assert f"x.h5{suffix}" in result.err
        assert (files / f"x.h5{suffix}").is_fifo()


# --- 3: two at once ----------------------------------------------------------------------------


def test_two_at_once(executable, tmp_path):
    """All pairs of run, resume, sweep and merge; tests/campaigns/together.py does hundreds."""
    counts, mistakes = together.campaign(str(executable), 2, tmp_path, seed=3)
    assert len(counts) == 10
    assert mistakes == []


def temporary(path, process):
    """The name that a process of this computer writes a file under."""
    total, name, mask = 0xCBF29CE484222325, socket.gethostname().encode(), 2**64 - 1
    whole = len(name) - len(name) % 8
    for at in range(0, whole, 8):
        word = int.from_bytes(name[at : at + 8], sys.byteorder)
        total = ((total ^ word) * 0x100000001B3) & mask
        total ^= total >> 32
    for byte in name[whole:]:
        total = ((total ^ byte) * 0x100000001B3) & mask
    return path.with_name(f"{path.name}.part-{(total ^ total >> 32) & 0xFFFFFFFF:08x}{process:08x}")


@pytest.mark.parametrize("command", [("sweep", "sweep.nml", "-q"), ("export", "a.h5", "--csv")])
def test_files_of_dead_processes_are_removed(run, files, command):
    good(run("run", "scene.nml", "-q", "-o", "a.h5"))
    gone = subprocess.Popen(["true"])
    gone.wait()
    alive = temporary(files / "x.h5", os.getpid())
    elsewhere = files / "x.h5.part-fedcba9876543210"
    for path in (alive, elsewhere, temporary(files / "x.h5", gone.pid)):
        path.write_text("left by a process that was killed, or not")
    old = files / "x.h5.part-0123456789abcdef"
    old.touch()
    os.utime(old, (time.time() - 7200, time.time() - 7200))
    (files / "x.h5.part.lock").touch()
    good(run(*command, "-o", "x.h5"))
    names = {path.name for path in files.glob("x.h5*")} - {"x.h5.part.lock"}
    assert names == {"x.h5", alive.name, elsewhere.name}


@pytest.mark.parametrize("command", [("run", "scene.nml"), ("sweep", "sweep.nml")])
def test_who_waits_for_a_result_may_read_it_at_once(executable, files, preload, command):
    """Readers take a lock as h5py does; the file is not locked any more when its name appears."""
    words = [str(executable), *command, "-q", "-o", "x.h5"]
    slow = {**os.environ, **preload("slow_folder")}
    with subprocess.Popen(words, cwd=files, env=slow) as process:
        while not (files / "x.h5").exists():
            assert process.poll() is None
            time.sleep(1e-3)
        with h5py.File(files / "x.h5", locking=True) as file:
            assert file.attrs["status"] in (b"complete", "complete")
        assert process.poll() is None
        assert process.wait(60) == 0


@pytest.mark.parametrize(
    "command", [("export", "a.h5", "--csv"), ("fmu", "scene.nml"), ("new", "bearing")]
)
def test_two_that_write_one_file(executable, run, files, command):
    """None removes what another one is about to finish."""
    good(run("run", "scene.nml", "-q", "-o", "a.h5"))
    for _ in range(4):
        words = [str(executable), *command, "-o", "x"]
        both = [
            subprocess.Popen(words, cwd=files, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            for _ in range(2)
        ]
        errors = [process.communicate(timeout=60)[1].decode() for process in both]
        codes = [process.returncode for process in both]
        assert codes in ([0, 74], [74, 0]), errors
        assert "exists" in "".join(errors)
        assert [path.name for path in files.glob("x*")] == ["x"]
        (files / "x").unlink()


def test_a_run_does_not_take_the_rows_of_a_sweep(run, files):
    (files / "x.h5.part").write_bytes(b"CONTJRN1" + bytes(5000))
    before = content(files)
    for option in ([], ["--resume"]):
        result = run("run", "scene.nml", "-o", "x.h5", *option)
        assert result.status == 74
        assert "x.h5.part holds the rows of a sweep" in result.err
        assert content(files) == before


def test_a_table_is_not_a_complete_run(run, files):
    good(run("sweep", "sweep.nml", "-q", "-o", "scene.h5"))
    result = run("run", "scene.nml", "-o", "scene.h5", "--resume")
    assert result.status == 74
    assert "scene.h5 is not the output of a run" in result.err


# --- 4: damaged files --------------------------------------------------------------------------


@pytest.fixture(scope="module")
def campaign(executable, tmp_path_factory):
    """Good files, and what each command makes of damaged ones."""
    return corruptions.Campaign(str(executable), tmp_path_factory.mktemp("campaign"))


@pytest.mark.parametrize("command", ["diff", "merge", "sweep", "resume", "going_on", "plot"])
def test_damaged_files(campaign, slow_build, command):
    """tests/campaigns/corruptions.py damages thousands."""
    number = {"plot": 3, "going_on": 4}.get(command, 12 if slow_build else 25)
    found = [campaign.trial(command, k) for k in range(number)]
    assert [wrong for _, wrong in found if wrong] == []
    assert any(words in ("told", "begun anew") for words, _ in found)


def test_columns_have_checksums(run, files):
    good(run("sweep", "sweep.nml", "-q", "-o", "table.h5"))
    good(run("run", "scene.nml", "-q", "-o", "run.h5"))
    with h5py.File(files / "run.h5") as file:
        assert all(data.fletcher32 for data in file["trajectory"].values() if data.chunks)
        assert file["events/time"].fletcher32
        assert file.attrs["filetype_version"] == "1.6"
    with h5py.File(files / "table.h5") as file:
        assert file["results/steps"].fletcher32
        assert file["case"].fletcher32
        assert file.attrs["filetype_version"] == "1.2"


@pytest.mark.parametrize("where", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_every_byte_counts(run, files, where):
    good(run("run", "scene.nml", "-q", "-o", "a.h5"))
    data = bytearray((files / "a.h5").read_bytes())
    data[min(int(where * len(data)), len(data) - 1)] ^= 1
    (files / "b.h5").write_bytes(data)
    result = run("diff", "a.h5", "b.h5")
    assert result.status == 2
    assert "damaged" in result.err


def test_a_file_that_another_program_has_changed_is_read(run, files):
    good(run("run", "scene.nml", "-q", "-o", "a.h5"))
    shutil.copy(files / "a.h5", files / "b.h5")
    with h5py.File(files / "b.h5", "r+") as file:
        file["trajectory/gap"][0, 0] = 1.0
    result = run("diff", "a.h5", "b.h5")
    assert result.status == 1
    assert "/trajectory/gap" in result.out


@pytest.mark.parametrize("what", ["case_count", "fingerprint", "message", "results/steps"])
def test_shards_without_a_seal_that_lack_something(run, files, what):
    """As of an earlier version of the program; a second shard that could not be opened crashed."""
    for k, table in ((1, "a.h5"), (2, "b.h5")):
        good(run("sweep", "sweep.nml", "-q", "--cases", k, "-o", table))
    with h5py.File(files / "b.h5", "r+") as file:
        if what in file.attrs:
            del file.attrs[what]
        else:
            del file[what]
    result = run("merge", "a.h5", "b.h5", "-o", "c.h5")
    assert result.status == 74
    assert "b.h5" in result.err
    assert "damaged" in result.err
    assert not (files / "c.h5").exists()


# --- 5: refused before anything runs -----------------------------------------------------------


def test_columns_that_collide(run, files):
    text = (files / "scene.nml").read_text()
    text = text.replace("name = 'ball_floor'", "name = 'b/f'")
    (files / "scene.nml").write_text(text.replace("name = 'stem_floor'", "name = 'b_f'"))
    (files / "sweep.nml").write_text(SWEEP.replace("'steps'", "'events'"))
    for command in ("sweep", "check"):
        result = run(command, "sweep.nml")
        assert result.status == 2
        assert "contact 'b/f' and contact 'b_f' would have the same column" in result.err
    assert not list(files.glob("sweep.h5*"))


@pytest.mark.parametrize("length", [236, 250, 255, 300])
def test_names_that_are_too_long(run, files, length):
    name = "n" * (length - 3) + ".h5"
    for words in (["run", "scene.nml"], ["sweep", "sweep.nml"]):
        result = run(*words, "-o", name)
        assert result.status == 74
        assert "is too long" in result.err
        assert "255 bytes" in result.err
    assert not list(files.glob("nnn*"))
    name = "n" * 230 + ".h5"
    assert run("run", "scene.nml", "-q", "-o", name).status == 0
    assert (files / name).exists()


def test_more_cases_than_a_disk_holds(run, files):
    (files / "sweep.nml").write_text(
        "&sweep scene = 'scene.nml' /\n"
        "&parameter name = 'top.angle', first = 0.1, last = 0.2, count = 1000000 /\n"
        "&parameter name = 'top.mass', first = 0.1, last = 0.2, count = 1000000 /\n"
    )
    for command in ("sweep", "check"):
        result = run(command, "sweep.nml")
        assert result.status == 2
        assert "1000000000000 cases" in result.err
        assert "free" in result.err
    assert not list(files.glob("sweep.h5*"))


# --- 6: UTF-8 ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        (b"&scene title", b"! K\xf6rper\n&scene title", "1:4"),
        (b"title = 'Tippe-Top'", b"title = 'T\xfcr'", "1:18"),
        (b"name = 'top'", b"name = 't\xc3'", "4:13"),
        (b"title = 'Tippe-Top'", b"title = '\xed\xa0\x80'", "1:17"),
    ],
)
def test_scenes_that_are_not_utf8(run, files, old, new, place):
    data = (files / "scene.nml").read_bytes()
    (files / "scene.nml").write_bytes(data.replace(old, new, 1))
    for words in (["run", "scene.nml"], ["check", "scene.nml"], ["sweep", "sweep.nml"]):
        result = run(*words)
        assert result.status == 2
        assert f"scene.nml:{place}: error: byte 0x" in result.err
        assert "is not UTF-8" in result.err
    assert not list(files.glob("*.h5*"))


def test_other_texts_that_are_not_utf8(run, files):
    (files / "sweep.nml").write_bytes(b"! \xe4\n" + SWEEP.encode())
    result = run("sweep", "sweep.nml")
    assert result.status == 2
    assert "sweep.nml:1:3: error: byte 0xE4 is not UTF-8" in result.err
    (files / "rules").write_bytes(b"/a 1 0\n/b\xff 1 0\n")
    result = run("diff", "a.h5", "b.h5", "--rules", "rules")
    assert result.status == 2
    assert "rules:2:3: error: byte 0xFF is not UTF-8" in result.err
    (files / "sweep.nml").write_text(
        "&sweep scene = 'scene.nml', sampling = 'file', table = 't.csv' /\n"
    )
    (files / "t.csv").write_bytes(b"ball_floor.friction\ncontensou_exact\npad\xe9\n")
    result = run("sweep", "sweep.nml")
    assert result.status == 2
    assert "t.csv:3:4: error: byte 0xE9 is not UTF-8" in result.err
    assert not list(files.glob("*.h5*"))


@pytest.mark.parametrize("word", [b"K\xf6rper.h5", b"--set=scene.title='\xe4'"])
def test_words_that_are_not_utf8(executable, files, word):
    words = [b"-o", word] if b"set" not in word else [word]
    done = subprocess.run(
        [os.fsencode(executable), b"run", b"scene.nml", *words],
        cwd=files,
        capture_output=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2
    assert b"is not UTF-8" in done.stderr
    assert not list(files.glob("*.h5*"))


def test_utf8_is_taken(run, files):
    text = (files / "scene.nml").read_text().replace("Tippe-Top", "Kreisel für Zoë, 球")
    (files / "scene.nml").write_bytes(b"\xef\xbb\xbf" + text.encode())
    result = good(run("run", "scene.nml", "-o", "球.h5"))
    assert "Kreisel für Zoë, 球" in result.out
    with h5py.File(files / "球.h5") as file:
        assert file.attrs["title"] == "Kreisel für Zoë, 球"


# --- 7: control characters ---------------------------------------------------------------------


def test_control_characters_are_shown(run, files):
    title = "a\x1b[31mred\x07\x7f\x9b2J\u202eevil\u2066x\u2028y"
    text = (files / "scene.nml").read_text().replace("Tippe-Top", title)
    text = text.replace("'ball_floor'", "'b\x1b]0;f\x07'")
    (files / "scene.nml").write_text(text)
    results = [run("run", "scene.nml"), run("check", "scene.nml"), run("cost", "scene.nml", "-x")]
    results.append(run("run", "no\x1b[2Jscene.nml"))
    results.append(run("run", "scene.nml", "--set", "to\x1b[2Jp.mass=1"))
    for result in results:
        shown = result.out + result.err
        for character in "\x1b\x07\x7f\x9b\u202e\u2066\u2028":
            assert character not in shown
    assert r"a\x1b[31mred\x07\x7f\u009b2J\u202eevil\u2066x\u2028y" in results[0].out
    done = plot(files, "top.h5", "-o", "a\x1b[2Jb.png")
    assert done.stdout == "a\\x1b[2Jb.png\n"


def test_exported_columns_do_not_command_a_terminal(executable, run, files):
    text = (files / "scene.nml").read_text().replace("'ball_floor'", "'b\x1b[2Jf'")
    (files / "scene.nml").write_text(text)
    good(run("run", "scene.nml", "-q"))
    words = ["export", "top.h5", "--csv", "--columns", "gap"]
    status, shown = on_terminal([executable, *words], files, 80, output=True)
    assert status == 0
    assert "\x1b" not in shown
    assert r"gap_b\x1b[2Jf" in shown
    # A file that is read again has the name as it is.
    assert "gap_b\x1b[2Jf" in good(run(*words)).out


def test_a_dumb_terminal_gets_no_escapes(executable, files, monkeypatch):
    command = [executable, "run", "scene.nml", "--set", "scene.t_end=1"]
    status, shown = on_terminal(command, files, 80)
    assert "\x1b[K" in shown
    (files / "top.h5").unlink()
    monkeypatch.setenv("TERM", "dumb")
    status, shown = on_terminal(command, files, 80)
    assert status == 0
    assert "\x1b" not in shown
    assert "contensou: 10 %" in shown
