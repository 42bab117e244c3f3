"""The C interface: the programs that the build makes of tests/capi."""

import subprocess

import pytest


@pytest.mark.parametrize("name", ["kernels", "simulation"])
def test_c_interface(executable, inputs, name):
    program = executable.parents[1] / "tests" / "capi" / f"test_{name}"
    done = subprocess.run(
        [program, inputs][: 1 + (name == "simulation")],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("\n") == 1, done.stdout
    assert done.stdout.endswith(" passed, 0 failed\n")
    assert done.stderr == ""
