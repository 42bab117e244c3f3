"""Signals end a command with what it has done safe, from its first instruction on."""

from __future__ import annotations

import resource
import signal
import subprocess
import time

import pytest
from folders import content, good

ENDLESS = ("--set", "scene.t_end=1e5", "--set", "output.interval=1e-2")
STOPS = ["SIGHUP", "SIGUSR1", "SIGUSR2", "SIGXCPU", "SIGTERM", "SIGINT", "SIGALRM", "SIGQUIT"]


def begin(executable, folder, *words, ready, **options):
    """Begin a command and wait until a file is there."""
    process = subprocess.Popen(
        [str(executable), *map(str, words)],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )
    end = time.monotonic() + 60
    while not (folder / ready).exists():
        assert time.monotonic() < end, "it did not begin"
        time.sleep(0.01)
    return process


@pytest.mark.parametrize("name", STOPS)
def test_signals_end_a_run_that_can_be_resumed(executable, run, files, name):
    process = begin(executable, files, "run", "scene.nml", "-q", *ENDLESS, "-o", "x.h5",
                    ready="x.h5.part")  # fmt: skip
    process.send_signal(getattr(signal, name))
    _, err = process.communicate(timeout=60)
    assert process.returncode == 75, err
    assert err.count("\n") == 1
    assert err.startswith("contensou: interrupted at t = ")
    assert sorted(path.name for path in files.glob("x.h5*")) == [
        "x.h5.part",
        "x.h5.part.checkpoint",
    ]


@pytest.mark.parametrize("name", STOPS)
def test_signals_end_a_sweep_that_goes_on(executable, run, files, name):
    process = begin(executable, files, "sweep", "sweep.nml", "-q", *ENDLESS, "-o", "x.h5",
                    ready="x.h5.part")  # fmt: skip
    process.send_signal(getattr(signal, name))
    _, err = process.communicate(timeout=60)
    assert process.returncode == 75, err
    assert err.count("\n") == 1
    assert sorted(path.name for path in files.glob("x.h5*")) == ["x.h5.part"]


@pytest.mark.parametrize("when", ["library", "main"])
@pytest.mark.parametrize("name", STOPS)
@pytest.mark.parametrize("command", ["run", "resume", "sweep", "merge", "cost"])
def test_signals_before_the_beginning(run, files, preload, command, name, when):
    words = {"run": ["run", "scene.nml"], "resume": ["run", "scene.nml", "--resume"]}.get(
        command, [command, "scene.nml" if command == "cost" else "sweep.nml"]
    )
    if command == "merge":
        good(run("sweep", "sweep.nml", "-q", "--shard", "1/1"))
        words = ["merge", *(path.name for path in files.glob("*_shard_1_of_1.h5"))]
    before = content(files)
    number = int(getattr(signal, name))
    result = run(
        *words, "-q", "-o", "x.h5",
        env={**preload("early"), "EARLY": when, "SIGNAL": str(number)},
    )  # fmt: skip
    assert result.status == 75, result.err
    assert result.err == "contensou: interrupted; nothing was written\n"
    assert content(files) == before


@pytest.mark.parametrize("name", ["SIGTERM", "SIGXCPU", "SIGQUIT"])
def test_other_commands_end_at_once(run, files, preload, name):
    number = int(getattr(signal, name))
    result = run("check", "scene.nml",
                 env={**preload("early"), "EARLY": "main", "SIGNAL": str(number)})  # fmt: skip
    assert result.status == -number
    assert result.err == ""


@pytest.mark.parametrize("words", [("run", "scene.nml"), ("sweep", "sweep.nml")])
def test_nohup_is_respected(executable, files, words):
    process = begin(executable, files, *words, "-q", *ENDLESS, "-o", "x.h5", ready="x.h5.part",
                    preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))  # fmt: skip
    process.send_signal(signal.SIGHUP)
    time.sleep(0.3)
    assert process.poll() is None
    process.terminate()
    process.communicate(timeout=60)
    assert process.returncode == 75


@pytest.mark.parametrize("words", [("run", "scene.nml"), ("sweep", "sweep.nml", "-j", "1")])
def test_a_limit_of_cpu_time(executable, files, words):
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (1, 20))

    process = begin(executable, files, *words, "-q", *ENDLESS, "-o", "x.h5", ready="x.h5.part",
                    preexec_fn=limit)  # fmt: skip
    _, err = process.communicate(timeout=120)
    assert process.returncode == 75, err
    assert "Backtrace" not in err
