"""Sweeps in shards under other programs: what is submitted to batch systems, and GNU parallel.

No batch system is needed here; test_slurm.py holds what Slurm makes of it.
"""

from __future__ import annotations

import ast
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
SUBMIT = ROOT / "scripts" / "batch" / "submit"
PAGE = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
SWEEPS = sorted((ROOT / "inputs" / "sweeps").glob("*.nml"))

SWEEP = """\
&sweep scene = 'top.nml', set = 'scene.t_end = 0.01', output = 'my table.h5' /
&parameter name = 'top.angle', first = 0.05, last = 0.15, count = 40 /
"""


@pytest.fixture
def sweep(scene):
    """A sweep of forty short cases."""
    path = scene.with_name("sweep.nml")
    path.write_text(SWEEP)
    return path


@pytest.fixture
def slurm(tmp_path):
    """Stand-ins for the programs of Slurm: what sbatch was told is in `told`, a line each."""
    folder = tmp_path / "slurm"
    folder.mkdir()
    told = tmp_path / "told"
    sbatch = f'printf "%q " "$@" >>{told}\nprintf "\\n" >>{told}\nwc -l <{told}\n'
    for name, body in (("sbatch", sbatch), ("scontrol", 'echo "MaxArraySize = 11"\n')):
        program = folder / name
        program.write_text(f"#!/usr/bin/env bash\n{body}")
        program.chmod(0o755)
    return folder


@pytest.fixture
def submit(executable, sweep, slurm):
    """Run scripts/batch/submit in the folder of the sweep: status, output, messages."""

    def run_it(*options: object) -> tuple[int, str, str]:
        path = f"{slurm}{os.pathsep}{os.environ['PATH']}"
        done = captured(
            [str(SUBMIT), *map(str, options)],
            cwd=sweep.parent,
            env={**os.environ, "CONTENSOU": str(executable), "PATH": path},
            timeout=120,
        )
        return done.returncode, done.stdout, done.stderr

    return run_it


def words_of(line: str) -> dict[str, str]:
    """Options of a command line by their names, what stands free under ''."""
    words = shlex.split(line)
    options = dict(word.partition("=")[::2] for word in words if word.startswith("--"))
    return options | {"": [word for word in words if not word.startswith("--")]}


def test_submit_takes_shards_and_time_from_check(submit, executable):
    status, out, err = submit("--dry-run", "sweep.nml", "--", "--account=wood")
    assert status == 0, err
    words = words_of(out)
    # Forty cases of milliseconds are one shard, and the least limit.
    assert words["--array"] == "1"
    assert words["--time"] in ("5", "6")
    assert words["--signal"] == "B:USR1@60"
    assert words["--account"] == "wood"
    assert words["--job-name"] == "sweep"
    assert words[""] == [
        f"CONTENSOU={executable}",
        "sbatch",
        str(SUBMIT.with_name("sweep.sh")),
        "1",
        "sweep.nml",
    ]
    assert "40 cases" in err
    assert ": 1 shard of " in err
    assert f"limit {words['--time']} min" in err


def test_submit_takes_long_work_apart(submit, sweep):
    # 1e5 cases of milliseconds and more: some CPU hours, so many shards; fewer with more cores.
    sweep.write_text(SWEEP.replace("40", "4000000"))
    numbers = {}
    for cpus in (1, 2):
        status, out, err = submit("--dry-run", "--cpus", cpus, "sweep.nml")
        assert status == 0, err
        words = words_of(out)
        assert words["--cpus-per-task"] == str(cpus)
        hours = float(re.search(r"about (\S+) CPU hours", err)[1])
        shards = int(re.search(r": (\d+) shards", err)[1])
        assert words["--array"] == f"1-{shards}"
        # What a shard should take and what it may, in minutes.
        expected = 60 * hours / shards / cpus
        assert 1.5 * expected + 4.8 <= int(words["--time"]) <= 1.5 * expected + 6.2
        assert shards == 10 or 10 <= expected <= 60
        numbers[cpus] = shards
    assert numbers[1] >= 2
    # The array of this Slurm ends at 10.
    assert numbers[1] <= 10
    status, _, err = submit("--shards", 11, "sweep.nml")
    assert status == 2
    assert "up to 10 tasks" in err


def test_submit_leaves_out_what_is_complete(submit, run, sweep, tmp_path):
    for shard in (1, 4):
        assert run("sweep", "sweep.nml", "-q", "--shard", f"{shard}/6").status == 0
    status, out, err = submit("sweep.nml", "--set", "top.spin(3) = 170")
    assert status == 0, err
    assert out == "1\n"
    assert "going on with the division into 6 shards" in err
    assert "2 shards are complete, 4 are submitted" in err
    (told,) = (tmp_path / "told").read_text().splitlines()
    words = words_of(told)
    assert words["--array"] == "2-3,5-6"
    assert words[""][1:] == ["6", "sweep.nml", "top.spin(3) = 170"]
    for shard in (2, 3, 5, 6):
        assert run("sweep", "sweep.nml", "-q", "--shard", f"{shard}/6").status == 0
    status, out, err = submit("sweep.nml")
    assert (status, out) == (0, "")
    assert "all 6 shards are complete; join them with: " in err


def test_submit_joins_when_asked(submit, tmp_path):
    status, out, err = submit("--shards", 4, "--at-once", 2, "--merge", "-o", "a.h5", "sweep.nml")
    assert status == 0, err
    assert out == "1\n"
    array, merge = (tmp_path / "told").read_text().splitlines()
    assert words_of(array)["--array"] == "1-4%2"
    assert words_of(merge)["--dependency"] == "afterany:1"
    assert "merge sweep.nml -o a.h5" in merge.replace("\\", "")


def test_submit_says_what_is_wrong(submit, sweep, slurm):
    for options, words in (
        ((), "which sweep"),
        (("no.nml",), "there is no file no.nml"),
        (("--shards", "0", "sweep.nml"), "--shards takes a whole number from 1, not '0'"),
        (("--shards",), "--shards needs a value"),
        (("--shard", "2", "sweep.nml"), "unknown option '--shard'"),
        (("--shards", "41", "--dry-run", "sweep.nml"), "up to 10 tasks"),
        (("sweep.nml", "top.nml"), "one sweep at a time"),
    ):
        status, out, err = submit(*options)
        assert (status, out) == (2, ""), options
        assert words in err
    sweep.write_text(SWEEP.replace("top.angle", "top.angel"))
    status, out, err = submit("sweep.nml")
    assert (status, out) == (2, "")
    assert "angel" in err
    assert "the sweep was not submitted" in err


# ---- Other batch systems -----------------------------------------------------------------------

# Stand-ins that take what the real ones do and run it at once: options with values, and how a task
# learns which one it is.
STAND_IN = """\
#!{python}
import os, re, subprocess, sys
ENGINE = {engine!r}
WITH_VALUES = {values!r}
words, options = sys.argv[1:], []
with open({told!r}, "a") as told:
    told.write(repr(words) + "\\n")
environment = dict(os.environ)
while words and words[0].startswith("-") and words[0] != "--":
    option = words.pop(0)
    options.append((option, words.pop(0) if option in WITH_VALUES else ""))
    if option == "-pe":
        words.pop(0)
if words[0] == "--":
    words.pop(0)
value = dict(options)
if "-v" in value:
    for item in value["-v"].split(","):
        name, equals, text = item.partition("=")
        if equals:
            environment[name] = text
if ENGINE == "lsf":
    spec = re.fullmatch(r".*\\[(.*)\\](?:%\\d+)?", value["-J"])
    name = "LSB_JOBINDEX"
elif ENGINE == "sge":
    spec, name = re.fullmatch(r"(.*)", value.get("-t", "")), "SGE_TASK_ID"
else:
    spec, name = re.fullmatch(r"([^%]*)(?:%\\d+)?", value.get("-J", "")), "PBS_ARRAY_INDEX"
    environment["PBS_O_WORKDIR"] = os.getcwd()
    os.chdir("/")
tasks = []
for part in (spec[1] if spec and spec[1] else "").split(","):
    if part:
        first, _, last = part.partition("-")
        tasks += range(int(first), int(last or first) + 1)
shell = ENGINE == "lsf"
command = " ".join(words) if shell and len(words) == 1 else words
for task in tasks or [None]:
    extra = {{}} if task is None else {{name: str(task)}}
    done = subprocess.run(command, env=environment | extra, shell=isinstance(command, str),
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open({told!r}, "a") as told:
        told.write(f"ended {{done.returncode}}\\n")
print({answer!r})
"""
ENGINES = {
    "pbs": ("qsub", "-N -l -j -r -J -v -W", "12[].server"),
    "sge": ("qsub", "-t -N -S -v -r -l -j -o -tc -pe -hold_jid -b", "12.1-3:1"),
    "lsf": ("bsub", "-J -W -wt -wa -Q -n -R -o -w", "Job <12> is submitted to default queue."),
}


@pytest.fixture(params=ENGINES)
def engine(request, tmp_path):
    """A batch system: its name, a folder with its command, and the file of what it heard."""
    command, values, answer = ENGINES[request.param]
    folder = tmp_path / "engine"
    folder.mkdir()
    told = tmp_path / "told"
    text = STAND_IN.format(
        python=sys.executable,
        engine=request.param,
        values=values.split(),
        told=str(told),
        answer=answer,
    )
    (folder / command).write_text(text)
    (folder / command).chmod(0o755)
    return request.param, folder, told


@pytest.mark.sample(1)
def test_engines_run_the_shards(engine, executable, sweep, run):
    """Shards that are there already are left out; the others and the last job make one table."""
    name, folder, told = engine
    assert run("sweep", "sweep.nml", "-q", "--shard", "3/6").status == 0
    environment = {
        **os.environ,
        "CONTENSOU": str(executable),
        "PATH": f"{folder}{os.pathsep}{os.environ['PATH']}",
    }
    words = [str(SUBMIT), "--engine", name, "--at-once", "2", "--cpus", "2", "--merge", "sweep.nml"]
    dry = captured([*words, "--dry-run"], cwd=sweep.parent, env=environment, timeout=120)
    assert dry.returncode == 0, dry.stderr
    assert not told.exists()
    done = captured(words, cwd=sweep.parent, env=environment, timeout=300)
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) == {"12[].server" if name == "pbs" else "12"}
    assert "1 shards are complete, 5 are submitted" in done.stderr
    lines = told.read_text().splitlines()
    assert [line for line in lines if line.startswith("ended")] == 6 * ["ended 0"]
    asked = [ast.literal_eval(line) for line in lines if not line.startswith("ended")]
    assert len(asked) == (2 if name == "lsf" else 3)
    # What the dry run has shown is what was done.
    shown = [shlex.split(line) for line in dry.stdout.splitlines()]
    assert [words[2:] for words in shown[:-1]] == asked[:-1]
    text = " ".join(asked[0])
    expected = {
        "pbs": ("-J 1-2%2", "select=1:ncpus=2", "-l walltime=0:0"),
        "sge": ("-t 1-2", "-tc 2", "-pe smp 2", "-l h_rt=0:0", "-l s_rt=0:0"),
        "lsf": ("-J sweep[1-2,4-6]%2", "-n 2", "-W 0:0", "-Q 75"),
    }
    for option in expected[name]:
        assert option in text
    assert any(word in " ".join(asked[-1]) for word in ("afterany:12", "-hold_jid 12", "ended(12)"))
    assert run("sweep", "sweep.nml", "-q", "-o", "alone.h5").status == 0
    assert columns(sweep.with_name("my table.h5")) == columns(sweep.with_name("alone.h5"))


def test_an_array_of_pbs_has_two_shards_at_least(engine, executable, sweep):
    name = engine[0]
    environment = {**os.environ, "CONTENSOU": str(executable)}
    command = [str(SUBMIT), "--engine", name, "--dry-run", "--shards", "1", "sweep.nml"]
    done = captured(command, cwd=sweep.parent, env=environment, timeout=120)
    assert done.returncode == 0, done.stderr
    assert ("CONTENSOU_SHARD=1" in done.stdout) == (name == "pbs")
    assert ("-J" in done.stdout) == (name == "lsf")


def test_engines_that_are_not_there(executable, sweep):
    environment = {**os.environ, "CONTENSOU": str(executable)}
    for words, message in (
        (["--engine", "condor"], "--engine is slurm, pbs, sge or lsf, not 'condor'"),
        (["--engine", "lsf"], "there is no bsub here; --dry-run says what would be submitted"),
    ):
        done = captured([SUBMIT, *words, "sweep.nml"], cwd=sweep.parent, env=environment)
        assert (done.returncode, done.stdout) == (2, "")
        assert message in done.stderr


def test_a_shard_that_ends_at_once_is_cancelled_all_the_same(tmp_path):
    """Batch systems send TERM to the script and to the program at once.

    bash 5.2 may lose the status of what ends while `wait` is interrupted: so tried two dozen times.
    """
    program = tmp_path / "program"
    program.write_text("#!/bin/sh\ntrap 'exit 75' TERM\necho begun\nwhile :; do sleep 0.01; done\n")
    program.chmod(0o755)
    variables = {"SLURM_ARRAY_TASK_ID": "1", "SLURM_JOB_ID": "1", "CONTENSOU": str(program)}
    tasks = [
        subprocess.Popen(
            ["bash", SUBMIT.with_name("sweep.sh"), "1", "sweep.nml"],
            env=os.environ | variables,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        for _ in range(24)
    ]
    for task in tasks:
        assert task.stdout.readline() == "begun\n"
        os.killpg(task.pid, signal.SIGTERM)
    for task in tasks:
        _, messages = task.communicate(timeout=60)
        assert task.returncode == 75, messages
        assert "cancelled; what is done is saved" in messages


def test_gnu_parallel_runs_the_shards(executable, sweep, run):
    if shutil.which("parallel") is None:
        pytest.skip("GNU parallel is not installed")
    command = re.search(r"^parallel .*$", PAGE, re.MULTILINE)[0]
    done = captured(
        ["bash", "-c", command],
        cwd=sweep.parent,
        env={**os.environ, "PATH": f"{executable.parent}{os.pathsep}{os.environ['PATH']}"},
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert run("sweep", "sweep.nml", "-q", "-o", "alone.h5").status == 0
    assert columns(sweep.with_name("my table.h5")) == columns(sweep.with_name("alone.h5"))


def columns(path: Path) -> dict[str, bytes]:
    """All numbers of a table, bit by bit."""
    with h5py.File(path) as file:
        paths = [f"{group}/{name}" for group in ("parameters", "results") for name in file[group]]
        return {path: file[path][()].tobytes() for path in ["case", "status", *paths]}


# ---- The sweep of README.md and the shipped ones ------------------------------------------------


def test_the_sweep_of_the_readme_is_in_order(run, tmp_path):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```fortran\n(.*?)```", readme, re.DOTALL)
    scene = next(block for block in blocks if block.startswith("&scene title = 'bouncing ball'"))
    text = next(block for block in blocks if block.startswith("&sweep"))
    (tmp_path / "ball.nml").write_text(scene)
    (tmp_path / "heights.nml").write_text(text)
    result = run("check", "heights.nml", timeout=600)
    assert result.status == 0, result.err
    assert re.search(r"^cases +273$", result.out, re.MULTILINE)
    assert run("sweep", "heights.nml", "-q", "--cases", "1,273", "-o", "a.h5").status == 0
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["parameters/height"][()].tolist() == [0.1, 1.0]
        assert file["parameters/restitution"][()].tolist() == [0.5, 0.9]
        # The fall from the height of the centre to the radius.
        expected = [(2 * (height - 0.01) / 9.81) ** 0.5 for height in (0.1, 1.0)]
        assert np.allclose(file["results/first_touch_ball_floor"][()], expected, rtol=1e-6)


def test_there_are_sweeps():
    assert "tippe_top_inversion" in [path.stem for path in SWEEPS]


@pytest.mark.parametrize("path", SWEEPS, ids=lambda path: path.stem)
def test_shipped_sweep_is_in_order_and_says_what_it_shows(run, path):
    text = path.read_text(encoding="utf-8")
    assert len(re.match(r"(?:!.*\n)+\n?(?=&sweep)", text)[0]) > 150
    result = run("check", path, timeout=600)
    assert result.status == 0, result.err
    numbers = dict(re.findall(r"^(cases|cpu_hours|shards)\s+(\S+)", result.out, re.MULTILINE))
    assert int(numbers["cases"]) >= 100
    assert float(numbers["cpu_hours"]) > 0
    assert int(numbers["shards"]) >= 1
    assert re.search(rf"^ +output +{path.stem}\.h5$", result.out, re.MULTILINE)
    for page in (ROOT / "README.md", ROOT / "docs" / "sweeps.md"):
        assert f"sweeps/{path.name}" in page.read_text(encoding="utf-8")


def test_cases_of_the_tippe_top_are_the_runs_they_stand_for(run, inputs, tmp_path, build_kind):
    # One that turns over and one that does not, by the map of docs/sweeps.md.
    cases = [2050, 8030] if build_kind == "release" else [2050]
    sweep = inputs / "sweeps" / "tippe_top_inversion.nml"
    options = ["-q", "-o", "few.h5", "--cases", ",".join(map(str, cases))]
    assert run("sweep", sweep, *options, timeout=900).status == 0
    with h5py.File(tmp_path / "few.h5") as file:
        assert file["case"][()].tolist() == cases
        friction = file["parameters/friction_coefficient"][()]
        tilt = file["parameters/tilt"][()]
        touch = file["results/first_touch_stem_floor"][()]
        assert not file["status"][()].any()
    assert np.allclose(friction, [0.25, 0.85][: len(cases)], rtol=1e-12)
    assert np.isfinite(touch).tolist() == [True, False][: len(cases)]
    sets = [
        "scene.t_end=10",
        "top.spin=0,0,140",
        "top.position=0,0,0.01237",
        "integrator.method=explicit8",
        "integrator.rtol=1e-5",
        "output.interval=0.1",
        f"contact.friction_coefficient={float(friction[0])!r}",
        f"top.angle={float(tilt[0])!r}",
    ]
    words = [word for text in sets for word in ("--set", text)]
    done = run("run", inputs / "tippe_top.nml", "-q", "-o", "one.h5", *words, timeout=900)
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "one.h5") as file:
        contact = labels(file, "events/contact")
        kind = labels(file, "events/kind")
        time = file["events/time"][()]
    touches = time[(contact == "stem_floor") & (kind == "touch")]
    assert touches[0] == touch[0]


def labels(file: h5py.File, path: str) -> np.ndarray:
    """A dataset of texts."""
    return file[path].asstr()[()]
