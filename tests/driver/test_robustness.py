"""What is left when something goes wrong: full disks, killed runs, signals, runs that fail."""

from __future__ import annotations

import contextlib
import os
import random
import resource
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

ENDLESS = ("--set", "scene.t_end=1e5", "--set", "output.interval=1e-2")
SHORT = ("--set", "scene.t_end=2e-3")


def spawn(executable, *args, cwd, **options):
    """Start a run in the background."""
    return subprocess.Popen(
        [str(executable), "run", *map(str, args)],
        cwd=cwd,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        **options,
    )


@pytest.fixture
def start(executable, tmp_path):
    """Start runs in the background; what still runs in the end is killed."""
    processes = []

    def start_it(*args, cwd=tmp_path, **options):
        process = spawn(executable, *args, cwd=cwd, **options)
        processes.append(process)
        return process

    yield start_it
    for process in processes:
        if process.poll() is None:
            process.kill()
        process.communicate()


def wait_for(path, timeout=30.0):
    """Wait until there is a file."""
    end = time.monotonic() + timeout
    while not path.exists():
        assert time.monotonic() < end, f"{path} did not appear"
        time.sleep(0.001)


def finish(process, timeout=30.0):
    """Wait for a process; its exit status and stderr."""
    _, err = process.communicate(timeout=timeout)
    return process.returncode, err.decode()


def check_readable(path, status):
    """A file with rows of equal number in all series; the rows."""
    with h5py.File(path) as file:
        assert file.attrs["status"] == status
        trajectory = file["trajectory"]
        times = trajectory["time"][()]
        series = [
            name for name, item in trajectory.items() if h5py.check_string_dtype(item.dtype) is None
        ]
        assert len(series) == 22
        for name in series:
            values = trajectory[name][()]
            assert len(values) == len(times), name
            assert np.isfinite(values).all(), name
        # No row was lost, and none is an empty one.
        assert (np.diff(times) > 0.0).all()
        if len(times):
            assert np.abs(np.linalg.norm(trajectory["quaternion"][:, 0], axis=1) - 1).max() < 1e-12
        events = file["events"]
        assert len({len(events[name]) for name in ("time", "kind", "contact")}) == 1
        assert file["input/namelist"].asstr()[()].startswith("&scene")
    return times


def check_complete(path, rows=None):
    """A complete file."""
    times = check_readable(path, "complete")
    assert rows is None or len(times) == rows


def one_error(text):
    """The message of a run that ended in trouble: one, without a trace of how the program works."""
    assert text.count("error:") == 1, text
    for word in ("Backtrace", "HDF5-DIAG", "Fortran runtime error", "SIGSEGV", "#0"):
        assert word not in text, text
    return text[text.index("error:") :]


# ---- Disks -------------------------------------------------------------------------------------


@contextlib.contextmanager
def small_disk(folder, size):
    """A file system of a few bytes."""
    folder.mkdir()
    if os.geteuid() != 0 or shutil.which("mount") is None:
        pytest.skip("only root can mount a small file system")
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    if subprocess.run(mount, capture_output=True, check=False).returncode != 0:
        pytest.skip("file systems cannot be mounted here")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], capture_output=True, check=True)


def check_full(folder, status, err):
    """How a run ends that could not write all."""
    assert status == 74, err
    message = one_error(err)
    assert "top.h5" in message
    names = {path.name for path in folder.iterdir()}
    assert names <= {"top.h5.part"}
    if names:
        check_readable(folder / "top.h5.part", "running")


@pytest.mark.parametrize("size", ["4k", "16k", "32k", "44k", "64k", "300k", "2m"])
def test_a_full_disk(run, scene, tmp_path, size):
    with small_disk(tmp_path / "disk", size) as disk:
        long = ("--set", "scene.t_end=0.2", "--set", "output.interval=1e-5")
        result = run("run", scene, "-o", disk / "top.h5", *long, "-q")
        check_full(disk, result.status, result.err)
        assert "No space left on device" in result.err
        assert result.out == ""
    # With space again the same run works.
    result = run("run", scene, "-o", tmp_path / "disk" / "top.h5")
    assert result.status == 0, result.err
    check_complete(tmp_path / "disk" / "top.h5", 21)


@pytest.mark.parametrize("size", [0, 1000, 20_000, 45_000, 200_000, 3_000_000])
def test_a_limit_on_the_size_of_files(start, scene, tmp_path, size):
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    (tmp_path / "disk").mkdir()
    long = ("--set", "scene.t_end=0.2", "--set", "output.interval=1e-5")
    process = start(scene, "-o", "disk/top.h5", *long, "-q", preexec_fn=limit)
    check_full(tmp_path / "disk", *finish(process))


def test_a_folder_that_is_not_there(run, scene, tmp_path):
    result = run("run", scene, "-o", "nowhere/top.h5")
    assert result.status == 74
    message = one_error(result.err)
    assert "nowhere/top.h5" in message
    assert "folder" in message
    assert result.out == ""
    assert not (tmp_path / "nowhere").exists()


@pytest.mark.parametrize("options", [(), ("--force",)])
def test_an_output_that_is_a_folder(run, scene, tmp_path, options):
    (tmp_path / "top.h5").mkdir()
    (tmp_path / "top.h5" / "kept").write_text("")
    result = run("run", scene, *options)
    assert result.status == 74
    assert "top.h5 is a folder" in one_error(result.err)
    assert (tmp_path / "top.h5" / "kept").exists()


def test_a_partial_file_that_is_a_folder(run, scene, tmp_path):
    (tmp_path / "top.h5.part").mkdir()
    result = run("run", scene)
    assert result.status == 74
    assert "top.h5.part" in one_error(result.err)
    assert not (tmp_path / "top.h5").exists()


@pytest.fixture
def open_folder():
    """A folder that every user can enter; pytest's own are closed to others."""
    folder = Path(tempfile.mkdtemp(prefix="contensou-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


def test_a_folder_without_permission(executable, scene_text, open_folder):
    # Nothing is forbidden to root: run as nobody then, with a copy that nobody can execute.
    (open_folder / "top.nml").write_text(scene_text)
    (open_folder / "closed").mkdir(mode=0o555)
    program = shutil.copy(executable, open_folder / "contensou")
    as_nobody = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
    process = spawn(program, "top.nml", "-o", "closed/top.h5", cwd=open_folder, **as_nobody)
    status, err = finish(process)
    assert status == 74
    assert "closed/top.h5" in one_error(err)
    assert list((open_folder / "closed").iterdir()) == []
    (open_folder / "closed").chmod(0o755)


def test_a_scene_that_cannot_be_read(run, tmp_path):
    result = run("run", "none.nml")
    assert result.status == 74
    assert "none.nml" in one_error(result.err)
    assert list(tmp_path.iterdir()) == []


# ---- Ends that nobody asked the program about ---------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_kill_at_any_moment(start, run, scene, tmp_path, sanitized, seed):
    # Kills fall anywhere in the run, and more densely around its end, where the file gets its name.
    moments = random.Random(seed)
    part, final = tmp_path / "top.h5.part", tmp_path / "top.h5"
    long = ("-q", "--set", "scene.t_end=0.1", "--set", "output.interval=1e-5")
    begin = time.monotonic()
    assert finish(start(scene, *long))[0] == 0
    duration = time.monotonic() - begin
    check_complete(final, 10001)
    final.unlink()
    killed = 0
    for trial in range(40):
        if killed == 6:
            break
        share = moments.uniform(0.0, 1.0) if trial % 2 else moments.uniform(0.85, 1.0)
        process = start(scene, *long)
        time.sleep(share * duration)
        process.kill()
        status, err = finish(process)
        # A leak checker that is killed at its work says so.
        assert err == "" or (sanitized and "Unable to get registers" in err)
        if status == -signal.SIGKILL:
            killed += 1
            if final.exists():
                # Between the new name and the end of the process.
                check_complete(final, 10001)
        else:
            assert status == 0
            check_complete(final, 10001)
        final.unlink(missing_ok=True)
        if part.exists():
            # A run that was killed in its first instants may leave what has no content yet.
            with contextlib.suppress(OSError, KeyError), h5py.File(part) as file:
                assert file.attrs.get("status", "running") in ("running", "complete")
        # The next run takes no notice, and needs no permission.
        result = run("run", scene, *SHORT)
        assert result.status == 0, result.err
        check_complete(final, 3)
        assert not part.exists()
        final.unlink()
    assert killed >= 3


def test_a_killed_run_keeps_what_was_flushed(start, scene, tmp_path, build_kind):
    # Rows reach the disk about every 5 s.
    part = tmp_path / "top.h5.part"
    process = start(scene, "-q", *ENDLESS)
    wait_for(part)
    time.sleep(5.5 if build_kind == "release" else 7.0)
    process.kill()
    assert finish(process)[0] == -signal.SIGKILL
    times = check_readable(part, "running")
    assert len(times) > 10
    np.testing.assert_allclose(times, 0.01 * np.arange(len(times)), rtol=1e-12)
    assert not (tmp_path / "top.h5").exists()


def test_a_broken_partial_file_is_replaced(run, scene, tmp_path):
    part = tmp_path / "top.h5.part"
    for content in (b"", b"\x89HDF\r\n\x1a\n", b"not HDF5 at all" * 1000):
        part.write_bytes(content)
        result = run("run", scene, *SHORT)
        assert result.status == 0, result.err
        assert "top.h5.part" in result.err
        assert not part.exists()
        (tmp_path / "top.h5").unlink()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_request_to_stop(start, run, scene, tmp_path, number):
    part, final = tmp_path / "top.h5.part", tmp_path / "top.h5"
    process = start(scene, *ENDLESS)
    wait_for(part)
    time.sleep(0.5)
    process.send_signal(number)
    status, err = finish(process)
    assert status == 75, err
    assert "top.h5.part" in err
    assert "interrupted at t = " in err
    assert "error" not in err
    assert not final.exists()
    times = check_readable(part, "interrupted")
    assert len(times) > 1
    np.testing.assert_allclose(times, 0.01 * np.arange(len(times)), rtol=1e-12)
    with h5py.File(part) as file:
        assert file["summary/rows"][()] == len(times)
        assert file["integrator/steps"][()] > 0

    # The rows so far are not lost to the next run.
    before = part.read_bytes()
    result = run("run", scene, *SHORT)
    assert result.status == 74
    message = one_error(result.err)
    assert "top.h5.part" in message
    assert "--force" in message
    assert part.read_bytes() == before
    assert not final.exists()
    result = run("run", scene, *SHORT, "-o", "other.h5")
    assert result.status == 0
    assert part.read_bytes() == before
    result = run("run", scene, *SHORT, "--force")
    assert result.status == 0, result.err
    check_complete(final, 3)
    assert not part.exists()


@pytest.mark.parametrize("pause", [0.0, 1e-4, 1e-3])
def test_a_request_to_stop_that_comes_twice(start, scene, tmp_path, pause):
    # timeout(1), and a shell that is told to stop, send to the program and to its group.
    process = start(scene, *ENDLESS)
    wait_for(tmp_path / "top.h5.part")
    time.sleep(0.3)
    process.send_signal(signal.SIGTERM)
    time.sleep(pause)
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(signal.SIGTERM)
    status, err = finish(process)
    assert status == 75, err
    check_readable(tmp_path / "top.h5.part", "interrupted")
    assert not (tmp_path / "top.h5").exists()


# ---- Two runs ----------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [(), ("--force",)])
def test_a_second_run_on_the_same_output(start, run, scene, tmp_path, options):
    part = tmp_path / "top.h5.part"
    process = start(scene, *ENDLESS)
    wait_for(part)
    time.sleep(0.3)
    result = run("run", scene, *SHORT, *options)
    assert result.status == 74
    message = one_error(result.err)
    assert "top.h5.part" in message
    assert "another" in message
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    assert finish(process)[0] == 75
    check_readable(part, "interrupted")
    assert not (tmp_path / "top.h5").exists()


def test_runs_that_start_together(start, scene, tmp_path):
    for round_ in range(5):
        name = f"together-{round_}.h5"
        options = ("-o", name, "-q", "--set", "output.interval=1e-5")
        ends = [finish(process) for process in [start(scene, *options) for _ in range(4)]]
        statuses = sorted(status for status, _ in ends)
        # One wins, the others are told.
        assert statuses == [0, 74, 74, 74], ends
        check_complete(tmp_path / name, 2001)
        assert not (tmp_path / f"{name}.part").exists()


# ---- Runs that fail ----------------------------------------------------------------------------

SOFT = """\
&scene gravity = 0, 0, -9.81, t_end = 1 /
&material name = 'jelly', young = 1e5, poisson = 0.45 /
&body name = 'pea', mass = 0.05, inertia = 3*8.0e-6, position = 0, 0, 0.03, velocity = 0, 0, -8 /
&surface name = 'skin', body = 'pea', shape = 'sphere', radius = 0.02, material = 'jelly' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'jelly' /
&contact name = 'splash', surfaces = 'skin', 'floor' /
&output file = 'soft.h5', interval = 1e-4 /
"""


ROW = """
&scene t_end = 2e-3 /
&material name = 'm', young = 1e10, poisson = 0.3 /
&body name = 'ball', density = 2000, position = 0, 0, 0, count = 4, spacing = 0.02 /
&body name = 'hit', density = 2000, velocity = 1, 0, 0
   position = -0.019012857312228224, 0.00588136597532758, 0.001990173884139 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.01, material = 'm' /
&surface name = 'cap', body = 'hit', shape = 'sphere', radius = 0.01, material = 'm' /
&contacts surfaces = '*', '*', friction = 'contensou_exact', friction_coefficient = 0.3
   damping = 'hunt_crossley', restitution = 0.5 /
&output file = 'row.h5', interval = 5e-6 /
"""


def test_a_trial_that_flies_through_a_row_of_balls(run, tmp_path):
    # The sparse matrix of that trial left an order of pivots with which no other one had a factor.
    (tmp_path / "row.nml").write_text(ROW)
    result = run("run", "row.nml", "-q")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "row.h5") as file:
        assert file["events/kind"].asstr()[()].tolist()[0] == "touch"


@pytest.mark.parametrize("method", ["cvode_bdf", "cvode_adams", "explicit8"])
@pytest.mark.parametrize("gravity", ["0,0,0", "0,0,-9.81"])
def test_an_impact_beyond_the_theory(run, tmp_path, method, gravity):
    (tmp_path / "soft.nml").write_text(SOFT)
    options = ("--set", f"integrator.method='{method}'", "--set", f"scene.gravity={gravity}")
    result = run("run", "soft.nml", "-q", *options, timeout=10)  # a few milliseconds will do
    assert result.status == 1
    message = one_error(result.err)
    failed_at = float(message.split("t = ")[1].split()[0])
    assert failed_at == pytest.approx(1.5e-3, rel=2e-3)  # 1 cm of fall and 2 mm of overlap at 8 m/s
    assert "'splash'" in message
    assert "gap" in message
    assert "stiffer" in message  # what to do about it
    assert "CVODE" not in message
    assert "soft.h5.part" in message
    assert result.out == ""
    assert not (tmp_path / "soft.h5").exists()
    times = check_readable(tmp_path / "soft.h5.part", "failed")
    assert len(times) in (15, 16)
    with h5py.File(tmp_path / "soft.h5.part") as file:
        assert file["events/kind"].asstr()[()].tolist() == ["touch"]

    result = run("run", "soft.nml", "-q")
    assert result.status == 74
    assert "soft.h5.part" in one_error(result.err)
    assert "--force" in result.err
    result = run("run", "soft.nml", "-q", "--force", "--set", "jelly.young=1e9")
    assert result.status == 0, result.err
    check_complete(tmp_path / "soft.h5")
    assert not (tmp_path / "soft.h5.part").exists()


def test_a_tolerance_beyond_double_precision(run, scene, tmp_path):
    result = run("run", scene, "-q", "--set", "integrator.rtol=1e-14", *SHORT)
    # It may fail or not, but in order.
    assert result.status in (0, 1)
    if result.status == 1:
        message = one_error(result.err)
        assert "t = " in message
        assert "rtol" in message
        check_readable(tmp_path / "top.h5.part", "failed")
        assert not (tmp_path / "top.h5").exists()
    else:
        check_complete(tmp_path / "top.h5", 3)


# ---- Streams -----------------------------------------------------------------------------------


@pytest.mark.parametrize("closed", [(1,), (2,), (1, 2), (0, 1, 2)], ids=str)
def test_closed_streams(executable, scene, tmp_path, closed):
    # The next file that is opened gets the number of a closed stream: what is meant for the stream
    # must not end up in it.
    def close():
        for number in closed:
            os.close(number)

    process = subprocess.Popen(
        [executable, "run", scene, "--set", "scene.t_end=0.1"], cwd=tmp_path, preexec_fn=close
    )
    status = process.wait(60)
    check_complete(tmp_path / "top.h5", 101)
    assert status in ((0, 74) if 1 in closed else (0,))
    content = (tmp_path / "top.h5").read_bytes()
    assert content.startswith(b"\x89HDF")
    for word in (b"simulated", b"contensou: "):
        assert word not in content


def test_a_reader_that_left(executable, scene, tmp_path):
    # As in `contensou run SCENE | head -0`.
    read, write = os.pipe()
    os.close(read)
    process = subprocess.Popen(
        [executable, "run", scene], cwd=tmp_path, stdout=write, stderr=subprocess.PIPE
    )
    os.close(write)
    status, err = finish(process)
    assert status in (74, -signal.SIGPIPE)
    assert "Backtrace" not in err
    check_complete(tmp_path / "top.h5", 21)


def test_a_reader_of_the_progress_that_left(executable, scene, tmp_path):
    # As in `contensou run SCENE 2>&1 | head -1`: progress is nobody's business then, the run is.
    read, write = os.pipe()
    os.close(read)
    process = subprocess.Popen(
        [executable, "run", scene, "--set", "scene.t_end=0.5"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=write,
    )
    os.close(write)
    process.communicate(timeout=60)
    assert process.returncode == 0
    check_complete(tmp_path / "top.h5", 501)


def test_a_full_standard_output(executable, scene, tmp_path):
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full")
    with open("/dev/full", "wb") as full:
        process = subprocess.Popen(
            [executable, "run", scene], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE
        )
    status, err = finish(process)
    assert status == 74
    assert "standard output" in one_error(err)
    check_complete(tmp_path / "top.h5", 21)


# ---- An explicit method and stiffness ----------------------------------------------------------


CONTACTS = ("ball_floor", "stem_floor")


def stiff_options(delta, **others):
    """A top whose contacts stick more and more stiffly, the smaller the velocity delta."""
    sets = {"integrator.method": "explicit8", "scene.t_end": 8.0, "output.interval": 1e-3} | others
    for contact in CONTACTS:
        sets[f"{contact}.friction"] = "coulomb"
        sets[f"{contact}.regularization_velocity"] = delta
    return [word for key, value in sets.items() for word in ("--set", f"{key}={value}")]


def test_explicit8_says_where_a_contact_is_too_stiff(run, scene, tmp_path):
    options = ("-o", "top.h5", *stiff_options(1e-6, **{"scene.t_end": 0.2}))
    result = run("run", scene, *options)
    assert result.status == 0, result.err
    advice = [line for line in result.err.splitlines() if "cvode_bdf" in line]
    assert len(advice) == 1, result.err
    assert advice[0].startswith("contensou: since t = 0.0")
    assert "stability" in advice[0]
    assert [line for line in result.out.splitlines() if line.startswith("  advice ")]
    check_complete(tmp_path / "top.h5", 201)
    # What it advises is right: the other method needs far fewer steps.
    result = run(
        "run",
        scene,
        *options,
        "--set",
        "integrator.method=cvode_bdf",
        "--force",
        "-q",
    )
    assert result.status == 0
    assert "advice" not in result.out
    with h5py.File(tmp_path / "top.h5") as file:
        assert file["integrator/right_hand_sides"][()] < 50000


def test_explicit8_gives_no_advice_where_it_is_the_faster_one(run, scene):
    for damping in (0.2, 100.0):
        options = [
            f"{contact}.damping_coefficient={damping}" for contact in ("ball_floor", "stem_floor")
        ]
        options += ["integrator.method=explicit8", "scene.t_end=2.5"]
        words = [word for text in options for word in ("--set", text)]
        result = run("run", scene, "-o", "top.h5", "--force", *words)
        assert result.status == 0, result.err
        assert "stability" not in result.err
        assert "advice" not in result.out


def test_explicit8_leaves_what_sticks_where_there_is_no_hope(run, scene, tmp_path):
    options = stiff_options(1e-9, **{"scene.t_end": 0.5})
    result = run("run", scene, "-o", "top.h5", *options)
    assert result.status == 0, result.err
    assert "friction that sticks is too stiff for explicit8" in result.out
    with h5py.File(tmp_path / "top.h5") as file:
        assert [name.decode() for name in file["integrator/method"]] == ["explicit8", "cvode_bdf"]
        assert file["integrator/method_since"][1] == pytest.approx(0.036, abs=1e-3)
        assert file["summary/energy_error_relative"][()] < 1e-6


def test_a_march_gives_up_where_there_is_no_hope(run, scene, tmp_path, build_kind):
    # With so small a velocity not even cvode_bdf, to which explicit8 leaves it, gets on.
    timeout = 10 if build_kind == "release" else 300
    result = run("run", scene, "-o", "top.h5", "-q", *stiff_options(1e-12), timeout=timeout)
    assert result.status == 1
    message = one_error(result.err)
    assert float(message.split("t = ")[1].split()[0]) == pytest.approx(0.036, abs=1e-3)
    assert "the steps have shrunk to" in message
    assert "a larger regularization_velocity may help" in message
    # That has been tried.
    assert "'cvode_bdf'" not in message
    check_readable(tmp_path / "top.h5.part", "failed")


@pytest.mark.parametrize(
    ("both", "one", "advice"),
    [
        ({}, {}, "a larger integrator.rtol or a larger regularization_velocity may help"),
        ({"tangential": "rolling"}, {}, "a larger integrator.rtol may help"),
        (
            {"tangential": "rolling"},
            {"tangential": "none"},
            "a larger integrator.rtol or a larger regularization_velocity may help",
        ),
        (
            {"tangential": "elastic"},
            {},
            "a larger integrator.rtol may help, and so may integrator.method = 'explicit8'",
        ),
    ],
)
def test_advice_is_what_the_contacts_can_have(run, scene, both, one, advice):
    """A regularization_velocity is refused where friction has no jump."""
    sets = {"integrator.max_step": 1e-13}
    sets |= {f"{name}.{key}": value for name in CONTACTS for key, value in both.items()}
    sets |= {f"{CONTACTS[0]}.{key}": value for key, value in one.items()}
    words = [word for key, value in sets.items() for word in ("--set", f"{key}={value}")]
    result = run("run", scene, "-o", "top.h5", "-q", *words)
    assert result.status == 1
    message = one_error(result.err)
    assert "the steps have shrunk to" in message
    assert f"  {advice}\n" in message + "\n"
    velocity = [f"{name}.regularization_velocity=1e-3" for name in CONTACTS]
    words += [word for text in velocity[: 1 if one else 2] for word in ("--set", text)]
    checked = run("check", scene, *words)
    assert (checked.status == 0) == ("regularization_velocity" in advice)
