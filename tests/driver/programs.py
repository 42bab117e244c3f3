"""Programs that the tests start."""

from __future__ import annotations

import re
import shutil
import subprocess
import time

import pytest


def captured(command, **more):
    """What a program leaves: its status, and its output as text."""
    return subprocess.run(command, capture_output=True, text=True, check=False, **more)


def instructions(command, folder, kind, status=0):
    """Instructions of a program and of those that it starts, by valgrind's cachegrind.

    They are the same whatever else the machine does, and count in a release build only.
    """
    if kind != "release":
        pytest.skip("instructions are those of a release build")
    if shutil.which("valgrind") is None:
        pytest.skip("there is no valgrind")
    words = ["valgrind", "--tool=cachegrind", "--cache-sim=no", "--trace-children=yes"]
    words += ["--cachegrind-out-file=/dev/null", f"--log-file={folder}/instructions.%p"]
    done = captured([*words, *map(str, command)], cwd=folder)
    assert done.returncode == status, done.stdout + done.stderr
    total = 0
    for path in folder.glob("instructions.*"):
        total += int(re.search(r"I +refs: +([\d,]+)", path.read_text())[1].replace(",", ""))
        path.unlink()
    return total


def stopped(executable, folder, words, output, number):
    """End a run by a signal once it has a checkpoint: what it says."""
    process = subprocess.Popen(
        [str(executable), *words],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    end = time.monotonic() + 60
    while not (folder / f"{output}.part.checkpoint").exists():
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.001)
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    assert process.returncode in {75, -number}, err
    return err.decode()
