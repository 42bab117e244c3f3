"""Sweeps as they run: rows, threads and shards, kills and signals, crashes, overhead."""

from __future__ import annotations

import contextlib
import csv
import os
import random
import resource
import shlex
import signal
import struct
import subprocess
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from programs import captured, instructions
from terminal import on_terminal

TIPPE = """\
&scene title = 'Tippe-Top', gravity = 0, 0, -9.81, t_end = 0.1 /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body name = 'top', mass = 6.0e-3, inertia = 8.0e-7, 8.0e-7, 7.0e-7,
   position = 0, 0, 0.0120149875041659, axis = 0, 1, 0, angle = 0.1, spin = 0, 0, 180.0 /
&surface name = 'ball', body = 'top', shape = 'sphere', centre = 0, 0, 3.0e-3, radius = 1.5e-2,
   material = 'wood' /
&surface name = 'stem', body = 'top', shape = 'sphere', centre = 0, 0, 16.0e-3, radius = 5.0e-3,
   material = 'wood' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'wood' /
&contact name = 'ball_floor', surfaces = 'ball', 'floor', damping = 'hunt_crossley',
   damping_coefficient = 100.0, friction = 'contensou_exact', friction_coefficient = 0.3 /
&contact name = 'stem_floor', surfaces = 'stem', 'floor', damping = 'hunt_crossley',
   damping_coefficient = 100.0, friction = 'contensou_exact', friction_coefficient = 0.3 /
&integrator method = 'explicit8', rtol = 1e-8 /
&output file = 'top.h5', interval = 1.0e-3 /
"""

# A ball that falls on a floor within 1 ms.
BALL = """\
&scene title = 'Ball', gravity = 0, 0, -9.81, t_end = 1e-3 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', mass = 0.03, inertia = 3*1.2e-6, position = 0, 0, 0.0101,
   velocity = 0, 0, -1 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 1.0e-2, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'steel' /
&contact name = 'skin_floor', surfaces = 'skin', 'floor', damping = 'hunt_crossley',
   restitution = 0.8 /
&integrator method = 'explicit8', rtol = 1e-6 /
&output file = 'ball.h5', interval = 1e-4 /
"""

FRICTION = "name = 'ball_floor.friction_coefficient', 'stem_floor.friction_coefficient'"
COMPLETE, FAILED, INVALID, LATE, CRASHED = range(5)


def write_sweep(folder, scene, sweep, *parameters, name="sweep.nml", others=""):
    """A sweep file and its scene."""
    (folder / "scene.nml").write_text(scene)
    path = folder / name
    lines = [f"&sweep scene = 'scene.nml', output = 'table.h5'\n   {sweep} /"]
    lines += [f"&parameter {parameter} /" for parameter in parameters]
    path.write_text("\n".join(lines) + "\n" + others)
    return path


def read_table(path):
    """What a table holds, but not what made it: bytes of all data sets."""
    found = {}

    def take(name, item):
        if isinstance(item, h5py.Dataset) and name.split("/")[0] in (
            "case",
            "parameters",
            "results",
            "status",
            "message",
        ):
            data = item[()]
            found[name] = [bytes(text) for text in data] if data.dtype == object else data.tobytes()

    with h5py.File(path) as file:
        file.visititems(take)
        assert file.attrs["status"] == "complete"
    assert {"case", "status", "message"} <= set(found)
    assert any(name.startswith("results/") for name in found)
    return found


def same_tables(first, second):
    """Two tables hold the same bits."""
    a, b = read_table(first), read_table(second)
    assert a.keys() == b.keys()
    for name in a:
        assert a[name] == b[name], name


def messages(file):
    """The messages of a table."""
    return [text.decode() for text in file["message"][()]]


@contextlib.contextmanager
def started(executable, *args, cwd, **options):
    """A sweep in the background; what still runs in the end is killed."""
    process = subprocess.Popen(
        [str(executable), "sweep", *map(str, args)],
        cwd=cwd,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        **options,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def children(pid):
    """Processes that a process has started and that still run."""
    try:
        text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return []
    return [int(word) for word in text.split()]


def rows_done(path, columns):
    """Rows in a journal, seen from outside: slots whose checksum is set."""
    size = 40 + 8 * columns
    data = path.read_bytes() if path.exists() else b""
    count = struct.unpack_from("=q", data, 16)[0] if len(data) >= 4096 else 0
    return sum(
        struct.unpack_from("=Q", data, 4096 + i * size)[0] != 0
        for i in range(count)
        if 4096 + (i + 1) * size <= len(data)
    )


# ---- Rows --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "changes"),
    [
        ("tippe_top", ["scene.t_end=0.05", "integrator.method='explicit8'"]),
        ("tippe_top", ["scene.t_end=0.02", "integrator.method='cvode_bdf'"]),
        ("tippe_top", ["scene.t_end=0.01", "integrator.method='cvode_adams'"]),
        ("rattleback", ["scene.t_end=0.02", "integrator.method='auto'"]),
        ("ellipsoid_egg", ["scene.t_end=0.03", "output.interval=7e-3"]),
        ("bouncing_ball", ["scene.t_end=1.0"]),
        ("tippe_top_rigid", ["scene.t_end=0.05"]),
        ("bearing_paper", ["scene.t_end=1e-3"]),
    ],
)
def test_rows_are_those_of_runs(run, tmp_path, inputs, scene, changes):
    text = (inputs / f"{scene}.nml").read_text()
    sweep = "keep = 'summary', 'final_state', 'events', set = " + ", ".join(
        '"' + change + '"' for change in changes
    )
    tolerances = [1e-9, 3e-8, 1e-6]
    write_sweep(
        tmp_path,
        text,
        sweep,
        f"name = 'integrator.rtol', vary = 'list', values = {', '.join(map(str, tolerances))}",
    )
    done = run("sweep", "sweep.nml", "-j", 3)
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "table.h5") as table:
        assert list(table["status"][()]) == [COMPLETE] * 3, messages(table)
        for i, rtol in enumerate(tolerances):
            sets = [word for change in changes for word in ("--set", change)]
            sets += ["--set", f"integrator.rtol={rtol}"]
            done = run("run", "scene.nml", *sets, "-o", "run.h5", "--force")
            assert done.status == 0, done.err
            with h5py.File(tmp_path / "run.h5") as file:
                check_row(table["results"], i, file)


def check_row(results, i, file):
    """The row of a table against the output file of the run, to the bit."""
    summary = file["summary"]
    scalars = [name for name in summary if summary[name].shape == () and name != "cpu_s"]
    assert len(scalars) == 12
    for name in scalars:
        assert results[name][i] == summary[name][()], name
    checked = 0
    bodies = list(summary["body"].asstr()[()])
    for name, labels in (
        ("position", "xyz"),
        ("velocity", "xyz"),
        ("angular_velocity", "xyz"),
        ("quaternion", "wxyz"),
    ):
        for j, body in enumerate(bodies):
            for k, label in enumerate(labels):
                assert results[f"{name}_{body}_{label}"][i] == summary[name][j, k]
                checked += 1
    assert checked == 13 * len(bodies)
    kinds = file["events/kind"].asstr()[()]
    contacts = file["events/contact"].asstr()[()]
    times = file["events/time"][()]
    for contact in file["contact/name"].asstr()[()]:
        for kind, plural in (("touch", "touches"), ("lift", "lifts")):
            mine = times[(kinds == kind) & (contacts == contact)]
            assert results[f"{plural}_{contact}"][i] == len(mine)
            for which, place in (("first", 0), ("last", -1)):
                value = results[f"{which}_{kind}_{contact}"][i]
                assert value == mine[place] if len(mine) else np.isnan(value)


def test_values_at_times_are_those_of_rows(run, tmp_path):
    values = [
        ("height", "position", "top", 3, 0.03),
        ("spin", "angular_velocity", "top", 1, 0.0),
        ("attitude", "quaternion", "top", 4, 0.1),
        ("load", "normal_force", "ball_floor", None, 0.071),
        ("slip", "slip_velocity", "ball_floor", 2, 0.07),
        ("open", "gap", "stem_floor", None, 0.05),
        ("spot", "semi_axes", "ball_floor", 2, 0.051),
        ("kinetic", "energy_kinetic", None, None, 0.052),
        ("balance", "energy_error", None, None, 0.1),
    ]
    groups = "".join(
        f"&value name = '{name}', dataset = '{dataset}', "
        + (f"of = '{of}', " if of else "")
        + (f"component = {component}, " if component else "")
        + f"time = {at} /\n"
        for name, dataset, of, component, at in values
    )
    write_sweep(
        tmp_path,
        TIPPE,
        "keep = 'summary'",
        FRICTION + ", vary = 'list', values = 0.2, 0.4",
        others=groups,
    )
    done = run("sweep", "sweep.nml", "-j", 2)
    assert done.status == 0, done.err
    sets = ["--set", "ball_floor.friction_coefficient=0.4"]
    sets += ["--set", "stem_floor.friction_coefficient=0.4"]
    assert run("run", "scene.nml", *sets).status == 0
    with h5py.File(tmp_path / "table.h5") as table, h5py.File(tmp_path / "top.h5") as file:
        trajectory = file["trajectory"]
        bodies = list(trajectory["body"].asstr()[()])
        contacts = list(trajectory["contact"].asstr()[()])
        for name, dataset, of, component, at in values:
            row = round(at / 1e-3)
            data = trajectory[dataset][row]
            if of:
                data = data[(bodies if of == "top" else contacts).index(of)]
            expected = data[component - 1] if component else data
            assert table[f"results/{name}"][1] == expected, name
        for name in ("steps", "right_hand_sides", "energy_error", "work_friction"):
            assert table[f"results/{name}"][1] == file[f"summary/{name}"][()]


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf"])
def test_values_between_rows_change_nothing_else(run, tmp_path, method):
    rows = "".join(
        f"&value name = 'h{i}', dataset = 'position', component = 3, time = {t} /\n"
        for i, t in enumerate([0.0123456, 0.03001, 0.0999, 0.05])
    )
    # Rows so rare that most steps have none.
    change = f"set = \"integrator.method='{method}'\", 'output.interval=0.05'"
    parameter = "name = 'scene.t_end', vary = 'list', values = 0.1, 0.04"
    write_sweep(tmp_path, TIPPE, change, parameter, others=rows)
    done = run("sweep", "sweep.nml")
    assert done.status == 0, done.err
    write_sweep(tmp_path, TIPPE, change, parameter)
    assert run("sweep", "sweep.nml", "-o", "plain.h5").status == 0
    fine = ["--set", f"integrator.method='{method}'", "--set", "output.interval=1e-5"]
    assert run("run", "scene.nml", *fine).status == 0
    with h5py.File(tmp_path / "table.h5") as table, h5py.File(tmp_path / "plain.h5") as plain:
        for name in plain["results"]:
            values = plain[f"results/{name}"][()]
            assert table[f"results/{name}"][()].tobytes() == values.tobytes(), name
        with h5py.File(tmp_path / "top.h5") as file:
            t = file["trajectory/time"][()]
            z = file["trajectory/position"][:, 0, 2]
        for i, at in enumerate([0.0123456, 0.03001, 0.0999]):
            expected = np.interp(at, t, z)
            assert abs(table[f"results/h{i}"][0] - expected) < 1e-9
        # Beyond the end of a case there is nothing.
        ends = [bool(np.isnan(table[f"results/h{i}"][1])) for i in range(4)]
        assert ends == [False, False, True, True]


# ---- Threads and shards ------------------------------------------------------------------------


def test_threads_and_shards_give_the_same_bits(run, tmp_path, build_kind):
    t_end = 0.03 if build_kind == "release" else 0.001
    write_sweep(
        tmp_path,
        TIPPE,
        f"keep = 'summary', 'events', 'final_state', set = 'scene.t_end={t_end}'",
        FRICTION + ", vary = 'linear', first = 0.05, last = 0.5, count = 6",
        "name = 'top.angle', vary = 'log', first = 1e-3, last = 0.3, count = 6",
        # One in three has no valid scene: no body has these moments of inertia.
        "name = 'top.inertia(3)', vary = 'list', values = 7e-7, 6e-7, 5e-6",
    )
    assert run("sweep", "sweep.nml", "-j", 1, "-o", "one.h5").status == 0
    for threads in (2, 8):
        done = run("sweep", "sweep.nml", "-j", threads, "-o", f"j{threads}.h5")
        assert done.status == 0, done.err
        same_tables(tmp_path / "one.h5", tmp_path / f"j{threads}.h5")
    for shards in (2, 5):
        for k in range(1, shards + 1):
            done = run("sweep", "sweep.nml", "-j", 2, "--shard", f"{k}/{shards}")
            assert done.status == 0, done.err
        files = [f"table_shard_{k}_of_{shards}.h5" for k in range(1, shards + 1)]
        sizes = []
        for file in files:
            with h5py.File(tmp_path / file) as table:
                sizes.append(len(table["case"]))
        assert sum(sizes) == 108
        assert max(sizes) - min(sizes) <= 1
        done = run("merge", *files, "-o", f"m{shards}.h5")
        assert done.status == 0, done.err
        same_tables(tmp_path / "one.h5", tmp_path / f"m{shards}.h5")


def test_cases_by_ranges(run, tmp_path):
    write_sweep(
        tmp_path,
        BALL,
        "",
        "name = 'ball.mass', vary = 'linear', first = 0.02, last = 0.04, count = 30",
    )
    assert run("sweep", "sweep.nml").status == 0
    done = run("sweep", "sweep.nml", "--cases", "20:22,3,2,21:25")
    assert done.status == 0, done.err
    with (
        h5py.File(tmp_path / "table.h5") as whole,
        h5py.File(tmp_path / "table_cases_2_to_25.h5") as part,
    ):
        wanted = [2, 3, *range(20, 26)]
        assert list(part["case"][()]) == wanted
        for name in whole["results"]:
            expected = whole[f"results/{name}"][()][np.array(wanted) - 1]
            assert (part[f"results/{name}"][()] == expected).all()
    for wrong in ("0:3", "5:4", "31", "1:x", "", "1,,2", "-1"):
        done = run("sweep", "sweep.nml", "--cases", wrong)
        assert done.status == 2, wrong
        assert "--cases needs ranges" in done.err
    for wrong in ("0/2", "3/2", "1", "a/b", "1/0", "/", "1/99999999999"):
        assert run("sweep", "sweep.nml", "--shard", wrong).status == 2, wrong
    for wrong in ("0", "-1", "x", "1.5", ""):
        assert run("sweep", "sweep.nml", "-j", wrong).status == 2, wrong
    assert run("sweep", "sweep.nml", "--shard", "1/31").status == 2


@pytest.mark.parametrize(
    ("arguments", "environment", "threads"),
    [
        (["-j", "3"], {"OMP_NUM_THREADS": "5"}, 3),
        (["-j3"], {}, 3),
        (["--jobs=3"], {}, 3),
        ([], {"OMP_NUM_THREADS": "5", "SLURM_CPUS_PER_TASK": "4"}, 5),
        ([], {"OMP_NUM_THREADS": "6,2"}, 6),
        ([], {"OMP_NUM_THREADS": "", "SLURM_CPUS_PER_TASK": "4"}, 4),
        ([], {"OMP_NUM_THREADS": "many", "SLURM_CPUS_PER_TASK": "4"}, 4),
        ([], {"OMP_NUM_THREADS": "", "SLURM_CPUS_PER_TASK": ""}, None),
    ],
)
def test_number_of_threads(run, tmp_path, arguments, environment, threads):
    write_sweep(
        tmp_path,
        BALL,
        "",
        "name = 'ball.mass', vary = 'linear', first = 0.02, last = 0.04, count = 8",
    )
    done = run("sweep", "sweep.nml", *arguments, env=environment)
    assert done.status == 0
    threads = threads or len(os.sched_getaffinity(0))
    words = "1 thread" if threads == 1 else f"{threads} threads"
    assert done.err.startswith(f"contensou: 8 cases on {words}\n")
    assert f"wall on {words}\n" in done.out


# ---- What there is already ---------------------------------------------------------------------


def test_complete_tables_are_left_alone(run, tmp_path):
    write_sweep(
        tmp_path,
        BALL,
        "",
        "name = 'ball.mass', vary = 'linear', first = 0.02, last = 0.04, count = 8",
    )
    assert run("sweep", "sweep.nml").status == 0
    before = (tmp_path / "table.h5").read_bytes()
    assert not (tmp_path / "table.h5.part").exists()
    # Left by a sweep that was killed at its very end.
    (tmp_path / "table.h5.part.lock").touch()
    done = run("sweep", "sweep.nml")
    assert (done.status, done.out) == (0, "table.h5 is complete, 8 cases\n")
    assert (tmp_path / "table.h5").read_bytes() == before
    assert not (tmp_path / "table.h5.part.lock").exists()
    # Of other cases, another scene, another program's.
    for arguments in (["--cases", "1:4", "-o", "table.h5"], ["--set", "scene.t_end=2e-3"]):
        done = run("sweep", "sweep.nml", *arguments)
        assert done.status == 74
        assert "--force" in done.err
        assert (tmp_path / "table.h5").read_bytes() == before
    done = run("sweep", "sweep.nml", "--set", "scene.t_end=2e-3", "--force")
    assert done.status == 0
    assert (tmp_path / "table.h5").read_bytes() != before
    (tmp_path / "table.h5").write_text("precious")
    assert run("sweep", "sweep.nml").status == 74
    assert (tmp_path / "table.h5").read_text() == "precious"


def test_unusable_outputs(run, tmp_path):
    write_sweep(tmp_path, BALL, "", "name = 'ball.mass', vary = 'list', values = 0.02, 0.03")
    (tmp_path / "folder").mkdir()
    for name in ("folder", "nowhere/table.h5"):
        done = run("sweep", "sweep.nml", "-o", name)
        assert done.status == 74
        assert name in done.err


def test_journals_of_other_sweeps_are_refused(executable, run, tmp_path):
    write_sweep(
        tmp_path, TIPPE, "", FRICTION + ", vary = 'linear', first = 0.1, last = 0.5, count = 500"
    )
    with started(executable, "sweep.nml", "-j", 1, cwd=tmp_path) as process:
        while rows_done(tmp_path / "table.h5.part", 12) < 3:
            assert process.poll() is None
            time.sleep(0.01)
        # While it is written nobody else can; the lock is waited for a while.
        process.send_signal(signal.SIGTERM)
        assert process.wait(timeout=10) == 75
    part = (tmp_path / "table.h5.part").read_bytes()
    done = run("sweep", "sweep.nml", "--set", "scene.t_end=0.01")
    assert done.status == 74
    assert "is not of this sweep" in done.err
    assert (tmp_path / "table.h5.part").read_bytes() == part
    done = run("sweep", "sweep.nml", "--set", "scene.t_end=0.01", "--force")
    assert done.status == 0
    assert not (tmp_path / "table.h5.part").exists()


def test_two_at_a_time_are_refused(executable, run, tmp_path):
    write_sweep(
        tmp_path,
        TIPPE,
        "set = 'scene.t_end=1e3'",
        FRICTION + ", vary = 'linear', first = 0.1, last = 0.5, count = 4",
    )
    with started(executable, "sweep.nml", "-j", 1, cwd=tmp_path) as process:
        while not (tmp_path / "table.h5.part").exists():
            time.sleep(0.01)
        time.sleep(0.2)
        done = run("sweep", "sweep.nml", timeout=60)
        assert done.status == 74
        assert "another process is writing table.h5.part" in done.err
        assert process.poll() is None


def test_damaged_journals_lose_only_what_is_damaged(executable, run, tmp_path):
    write_sweep(
        tmp_path,
        TIPPE,
        "set = 'scene.t_end=0.02'",
        FRICTION + ", vary = 'linear', first = 0.1, last = 0.5, count = 100",
    )
    assert run("sweep", "sweep.nml", "-o", "whole.h5").status == 0
    with started(executable, "sweep.nml", "-j", 2, cwd=tmp_path) as process:
        while rows_done(tmp_path / "table.h5.part", 12) < 30:
            assert process.poll() is None
            time.sleep(0.002)
        process.kill()
        process.wait()
    time.sleep(0.2)
    part = tmp_path / "table.h5.part"
    data = bytearray(part.read_bytes())
    size = 40 + 8 * 12
    for i in range(0, 20, 3):
        data[4096 + i * size + 8 * (i % 17)] ^= 0x10
    part.write_bytes(data)
    done = run("sweep", "sweep.nml")
    assert done.status == 0, done.err
    assert "going on with" in done.err
    same_tables(tmp_path / "whole.h5", tmp_path / "table.h5")
    # A header that was not finished is that of a new journal.
    part.write_bytes(bytes(data[:100]))
    (tmp_path / "table.h5").unlink()
    assert run("sweep", "sweep.nml").status == 0
    same_tables(tmp_path / "whole.h5", tmp_path / "table.h5")


# ---- Kills and signals -------------------------------------------------------------------------


def test_killed_at_random_moments(executable, run, tmp_path, build_kind):
    """SIGKILL to the program, its worker or both, 50 times; the table is the undisturbed one."""
    kills = 50 if build_kind == "release" else 15
    count = 300 if build_kind == "release" else 40
    write_sweep(
        tmp_path,
        TIPPE,
        "keep = 'summary', 'events', 'final_state'",
        FRICTION + f", vary = 'linear', first = 0.05, last = 0.5, count = {count}",
        "name = 'top.inertia(3)', vary = 'list', values = 7e-7, 5e-6",
    )
    assert run("sweep", "sweep.nml", "-o", "whole.h5", timeout=600).status == 0
    generator = random.Random(11)
    done = lives = finished = 0
    while done < kills or not (tmp_path / "table.h5").exists():
        if (tmp_path / "table.h5").exists():
            # Sooner than all kills were spent: once more.
            same_tables(tmp_path / "whole.h5", tmp_path / "table.h5")
            (tmp_path / "table.h5").unlink()
            finished += 1
        lives += 1
        assert lives < 20 * kills
        with started(executable, "sweep.nml", "-j", 2, cwd=tmp_path) as process:
            while process.poll() is None and done < kills:
                time.sleep(generator.uniform(0.0, 0.25))
                victim = generator.choice(["program", "worker", "both"])
                workers = children(process.pid)
                if process.poll() is not None:
                    break
                if victim != "program":
                    for worker in workers:
                        with contextlib.suppress(ProcessLookupError):
                            os.kill(worker, signal.SIGKILL)
                if victim != "worker":
                    process.kill()
                    process.wait()
                done += victim != "worker" or bool(workers)
            _, err = process.communicate(timeout=600)
            assert process.returncode in (0, -signal.SIGKILL), err
            workers = children(process.pid)
            assert not workers
    same_tables(tmp_path / "whole.h5", tmp_path / "table.h5")
    assert not (tmp_path / "table.h5.part").exists()
    print(f"{done} kills in {lives} lives, {finished} tables on the way")


def test_the_worker_dies_with_the_program(executable, tmp_path):
    write_sweep(
        tmp_path, TIPPE, "set = 'scene.t_end=1e3'", FRICTION + ", vary = 'list', values = 0.1, 0.2"
    )
    with started(executable, "sweep.nml", "-j", 2, cwd=tmp_path) as process:
        end = time.monotonic() + 60
        while not children(process.pid):
            assert time.monotonic() < end
            time.sleep(0.01)
        (worker,) = children(process.pid)
        process.kill()
        process.wait()
        end = time.monotonic() + 60
        while Path(f"/proc/{worker}/stat").exists():
            if Path(f"/proc/{worker}/stat").read_text().split(")")[1].split()[0] == "Z":
                break
            assert time.monotonic() < end, "the worker lives on"
            time.sleep(0.01)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGUSR1, signal.SIGINT])
@pytest.mark.parametrize("group", [False, True], ids=["program", "group"])
def test_signals_stop_and_the_rest_follows(executable, run, tmp_path, number, group, build_kind):
    count = 120 if build_kind == "release" else 16
    write_sweep(
        tmp_path,
        TIPPE,
        "keep = 'summary', 'events'",
        FRICTION + f", vary = 'linear', first = 0.05, last = 0.5, count = {count}",
    )
    assert run("sweep", "sweep.nml", "-o", "whole.h5", timeout=600).status == 0
    with started(executable, "sweep.nml", "-j", 2, cwd=tmp_path, start_new_session=True) as process:
        while rows_done(tmp_path / "table.h5.part", 24) < 4:
            assert process.poll() is None
            time.sleep(0.005)
        if group:
            os.killpg(process.pid, number)
        else:
            process.send_signal(number)
        _, err = process.communicate(timeout=30)
    assert process.returncode == 75, err
    assert b"the same command goes on from there" in err
    assert not (tmp_path / "table.h5").exists()
    saved = rows_done(tmp_path / "table.h5.part", 24)
    assert saved >= 4
    done = run("sweep", "sweep.nml", "-j", 2, timeout=600)
    assert done.status == 0
    assert f"going on with {count - saved} of {count} cases" in done.err
    same_tables(tmp_path / "whole.h5", tmp_path / "table.h5")


def test_signals_stop_a_case_that_does_not_end(executable, tmp_path):
    write_sweep(
        tmp_path,
        TIPPE,
        "set = 'scene.t_end=1e4', 'output.interval=1'",
        FRICTION + ", vary = 'list', values = 0.1, 0.2",
    )
    with started(executable, "sweep.nml", "-j", 2, cwd=tmp_path) as process:
        time.sleep(0.5)
        process.terminate()
        assert process.wait(timeout=30) == 75


# ---- Cases that fail ---------------------------------------------------------------------------


CRASH, HANG, EXIT, ABORT = 0.0101, 0.0102, 0.0103, 0.0104


def test_crashes_and_hangs_take_only_themselves(run, tmp_path, preload):
    steps = [0.01 + 0.0001 * i + 1e-5 for i in range(40)]
    for place, value in ((3, CRASH), (4, CRASH), (17, HANG), (20, EXIT), (21, ABORT), (39, CRASH)):
        steps[place] = value
    write_sweep(
        tmp_path,
        TIPPE,
        "set = \"integrator.method='cvode_bdf'\", 'scene.t_end=0.01', time_limit = 1.0",
        f"name = 'integrator.max_step', vary = 'list', values = {', '.join(map(repr, steps))}",
    )
    done = run("sweep", "sweep.nml", "-j", 4, env=preload("trouble"))
    assert done.status == 0, done.err
    expected = [COMPLETE] * 40
    for place in (3, 4, 20, 21, 39):
        expected[place] = CRASHED
    expected[17] = LATE
    with h5py.File(tmp_path / "table.h5") as table:
        assert list(table["status"][()]) == expected
        words = messages(table)
        assert [bool(text) for text in words] == [status != COMPLETE for status in expected]
        assert words[3] == "the program crashed: Segmentation fault"
        assert words[20] == "the program crashed: exit status 7"
        assert words[21] == "the program crashed: Aborted"
        assert "without an answer" in words[17]
        ended = table["results/steps"][()][np.array(expected) == COMPLETE]
        assert (ended > 10).all()
    assert "34 complete, 1 time limit, 5 crashed" in done.out
    # Without the library these cases are like the others; and the rows that came to their end are
    # the same.
    assert run("sweep", "sweep.nml", "-j", 2, "-o", "well.h5").status == 0
    with h5py.File(tmp_path / "table.h5") as table, h5py.File(tmp_path / "well.h5") as well:
        assert (well["status"][()] == COMPLETE).all()
        for name in well["results"]:
            ended = np.array(expected) == COMPLETE
            values = table[f"results/{name}"][()][ended]
            assert values.tobytes() == well[f"results/{name}"][()][ended].tobytes(), name


def test_a_sweep_in_which_all_crash(run, tmp_path, preload):
    write_sweep(
        tmp_path,
        TIPPE,
        f"set = \"integrator.method='cvode_bdf'\", 'integrator.max_step={CRASH}'",
        FRICTION + ", vary = 'linear', first = 0.1, last = 0.2, count = 12",
    )
    done = run("sweep", "sweep.nml", "-j", 3, env=preload("trouble"))
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "table.h5") as table:
        assert list(table["status"][()]) == [CRASHED] * 12
        assert np.isnan(table["results/time"][()]).all()


# How the cases of the next test end, by their number.
KINDS = {
    7: ("0.0101", "-1", "1e-3", "0.1", COMPLETE),
    100: ("0.003", "-1", "1e-3", "0.1", INVALID),
    200: ("0.0101", "-2000", "1e-3", "0.1", FAILED),
    300: ("0.0101", "-1", "1e-3", "1e-20", FAILED),
    350: ("0.0101", "-1", "10", "1e-6", LATE),
}


def kind_of(case):
    """One in a hundred fails, in four ways."""
    if case % 100:
        return KINDS[7]
    return KINDS[[100, 200, 300, 350][case // 100 % 4]]


def test_one_in_a_hundred_fails(run, tmp_path, build_kind):
    """CONTENSOU_SWEEP_CASES=100000 for the whole; every row is right, and the summary tells."""
    count = int(os.environ.get("CONTENSOU_SWEEP_CASES", 0)) or (
        2000 if build_kind == "release" else 400
    )
    with (tmp_path / "points.csv").open("w") as file:
        writer = csv.writer(file)
        writer.writerow(
            [
                "ball.mass",
                "ball.position(3)",
                "ball.velocity(3)",
                "scene.t_end",
                "integrator.max_step",
            ]
        )
        for case in range(1, count + 1):
            writer.writerow([f"{0.02 + 1e-7 * case:.9f}", *kind_of(case)[:4]])
    (tmp_path / "scene.nml").write_text(BALL.replace("interval = 1e-4", "interval = 1e-2"))
    (tmp_path / "sweep.nml").write_text(
        "&sweep scene = 'scene.nml', sampling = 'file', table = 'points.csv', output = 'table.h5'\n"
        "   time_limit = 0.5, keep = 'summary', 'events' /\n"
    )
    start = time.monotonic()
    done = run("sweep", "sweep.nml", "-j", 2, timeout=3000)
    print(f"{count} cases in {time.monotonic() - start:.1f} s")
    assert done.status == 0, done.err
    expected = np.array([kind_of(case)[4] for case in range(1, count + 1)])
    with h5py.File(tmp_path / "table.h5") as table:
        assert (table["case"][()] == np.arange(1, count + 1)).all()
        status = table["status"][()]
        # On a busy machine a case may take longer than it should.
        assert ((status == expected) | (status == LATE)).all()
        assert np.count_nonzero(status != expected) <= 2
        words = messages(table)
        results = {name: table[f"results/{name}"][()] for name in table["results"]}
        mass = table["parameters/ball.mass"][()]
    for i in range(count):
        case, text = i + 1, words[i]
        if status[i] == COMPLETE:
            assert text == ""
            assert results["time"][i] == 1e-3
            assert results["first_touch_skin_floor"][i] > 0
            assert mass[i] == float(f"{0.02 + 1e-7 * case:.9f}")
            continue
        assert np.isnan(results["time"][i])
        if status[i] == INVALID:
            assert "overlap" in text
        elif status[i] == LATE:
            assert "of wall time" in text
        elif kind_of(case) is KINDS[200]:
            assert "pressed deeper" in text
        else:
            assert "the run failed at t = " in text
    # Energy is in proportion to mass, and that to the number of the case.
    good = status == COMPLETE
    ratio = results["energy_initial"][good] / mass[good]
    assert np.ptp(ratio) < 1e-9 * ratio[0]
    for code, word in ((1, "failed"), (2, "invalid scene"), (3, "time limit")):
        assert f"{np.count_nonzero(status == code)} {word}" in done.out
        assert f"first case {np.flatnonzero(status == code)[0] + 1}: " in done.out
    assert "/status and /message in table.h5" in done.out
    command = shlex.split(done.out.partition(" alone is\n")[2].splitlines()[0])
    again = run(*command[1:])
    assert again.status != 0
    assert "the run failed" in again.err


def test_disk_full(executable, run, tmp_path):
    write_sweep(
        tmp_path,
        BALL,
        "",
        "name = 'ball.mass', vary = 'linear', first = 0.02, last = 0.04, count = 400",
    )

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

    with started(executable, "sweep.nml", "-j", 2, cwd=tmp_path, preexec_fn=limited) as process:
        _, err = process.communicate(timeout=60)
    assert process.returncode == 74, err
    assert err.count(b"error:") == 1
    assert b"table.h5.part" in err
    assert not (tmp_path / "table.h5").exists()
    assert run("sweep", "sweep.nml").status == 0


# ---- Trajectories ------------------------------------------------------------------------------


def test_trajectories_of_chosen_cases(executable, run, tmp_path):
    write_sweep(
        tmp_path,
        TIPPE,
        "trajectories = 2, 5, 6, keep = 'summary'",
        FRICTION + ", vary = 'list', values = 0.1, 0.2, 0.3",
        "name = 'top.inertia(3)', vary = 'list', values = 7e-7, 5e-6",
    )
    done = run("sweep", "sweep.nml")
    assert done.status == 0, done.err
    found = sorted(path.name for path in tmp_path.glob("*.h5*"))
    assert found == ["table.h5", "table_case_5.h5"]
    assert "trajectory table_case_5.h5" in done.out
    assert "trajectory of case 2: none" in done.out
    sets = ["--set", "ball_floor.friction_coefficient=0.3"]
    sets += ["--set", "stem_floor.friction_coefficient=0.3", "--set", "top.inertia(3)=7e-7"]
    assert run("run", "scene.nml", *sets).status == 0
    done = run("diff", "top.h5", "table_case_5.h5")
    assert done.status in (0, 1)
    with h5py.File(tmp_path / "top.h5") as a, h5py.File(tmp_path / "table_case_5.h5") as b:
        for name in a["trajectory"]:
            assert (a["trajectory"][name][()] == b["trajectory"][name][()]).all(), name
        with h5py.File(tmp_path / "table.h5") as table:
            for name in table["results"]:
                assert table["results"][name][4] == b["summary"][name][()], name
    # One that is in the way is not overwritten.
    (tmp_path / "table.h5").unlink()
    done = run("sweep", "sweep.nml")
    assert done.status == 74
    assert "table_case_5.h5 exists" in done.err
    assert run("sweep", "sweep.nml", "--force").status == 0


# ---- Progress ----------------------------------------------------------------------------------


def test_progress_in_tenths(run, tmp_path, build_kind):
    # Long enough for the main thread to look in between: it does so ten times a second.
    count = 900 if build_kind == "release" else 150
    vary = f", vary = 'linear', first = 0.1, last = 0.5, count = {count}"
    write_sweep(tmp_path, TIPPE, "", FRICTION + vary)
    done = run("sweep", "sweep.nml", "-j", 1, timeout=600)
    assert done.status == 0
    lines = done.err.splitlines()
    assert lines[0] == f"contensou: {count} cases on 1 thread"
    shares = []
    for line in lines[1:]:
        word, rest = line.removeprefix("contensou: ").split(" %, ")
        shares.append(int(word))
        assert rest.split(" of ")[1].startswith(f"{count} cases, ")
        assert rest.endswith(" left")
    assert shares == sorted(set(shares))
    assert set(shares) <= set(range(0, 101, 10))
    assert len(shares) >= 5
    assert run("sweep", "sweep.nml", "-q", "-o", "quiet.h5", timeout=600).err == ""


def test_progress_on_a_terminal(executable, tmp_path):
    write_sweep(
        tmp_path, TIPPE, "", FRICTION + ", vary = 'linear', first = 0.1, last = 0.5, count = 100"
    )
    status, text = on_terminal([executable, "sweep", "sweep.nml", "-j", "1"], tmp_path, 70)
    assert status == 0
    bars = [part for part in text.split("\r\x1b[K") if part.startswith("[")]
    assert len(bars) >= 2
    for bar in bars:
        assert len(bar.rstrip("\r\n")) < 70
        assert " of 100 cases, " in bar
        assert bar.rstrip().endswith("left")


# ---- What it costs -----------------------------------------------------------------------------


def work_of(executable, folder, kind, scene, parameter, counts, *words):
    """Instructions of a sweep between two numbers of cases, and those of a loop over them."""
    found = {"sweep": [], "loop": []}
    for count in counts:
        path = write_sweep(folder, scene, "", f"{parameter}, count = {count}")
        sweep = [executable, "sweep", path, "--force", "-q", *words]
        found["sweep"].append(instructions(sweep, folder, kind))
        loop = [executable.parent.parent / "tests" / "cost" / "bare_sweep", path]
        found["loop"].append(instructions(loop, folder, kind))
        with h5py.File(folder / "table.h5") as table:
            done = table["results/right_hand_sides"][()].sum()
        assert done == int(captured(list(map(str, loop)), cwd=folder).stdout)
    return {name: last - first for name, (first, last) in found.items()}


@pytest.mark.parametrize("threads", [1, 2])
def test_work_beside_a_bare_loop(executable, build_kind, tmp_path, threads):
    """At most 3 % more instructions for cases of some 5 ms, whatever the number of threads."""
    work = work_of(
        executable,
        tmp_path,
        build_kind,
        TIPPE,
        FRICTION + ", vary = 'linear', first = 0.15, last = 0.4",
        (4, 12),
        "-j",
        threads,
    )
    assert work["sweep"] <= 1.03 * work["loop"]


def test_pace_does_not_depend_on_the_number_of_cases(executable, build_kind, tmp_path):
    """Instructions per trivial case."""
    scene = BALL.replace("t_end = 1e-3", "t_end = 1e-5").replace("interval = 1e-4", "interval = 1")
    mass = "name = 'ball.mass', vary = 'linear', first = 0.02, last = 0.04"
    few, many = (
        work_of(executable, tmp_path, build_kind, scene, mass, counts, "-j", 1)["sweep"] / number
        for counts, number in (((20, 120), 100), ((120, 620), 500))
    )
    assert many < 1.1 * few
    # Before the redesign of the sources a case took 435,000.
    assert many < 4.35e5


def test_memory_does_not_depend_on_the_number_of_cases(executable, tmp_path, build_kind):
    """CONTENSOU_SWEEP_TRIVIAL=1000000 for the whole."""
    if build_kind != "release":
        pytest.skip("memory is that of a release build")
    count = int(os.environ.get("CONTENSOU_SWEEP_TRIVIAL", 40000))
    scene = BALL.replace("t_end = 1e-3", "t_end = 1e-5").replace("interval = 1e-4", "interval = 1")
    largest = {}
    for n in (count // 10, count):
        mass = f"name = 'ball.mass', vary = 'linear', first = 0.02, last = 0.04, count = {n}"
        path = write_sweep(tmp_path, scene, "", mass, name=f"sweep_{n}.nml")
        command = [executable, "sweep", path, "-j", 2, "-q", "-o", f"table_{n}.h5", "--force"]
        process = subprocess.Popen(list(map(str, command)), cwd=tmp_path, stdin=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        largest[n] = usage.ru_maxrss * 1024
        assert (tmp_path / f"table_{n}.h5").stat().st_size / n < 200 or n < count
    assert largest[count] < largest[count // 10] + 4e6
