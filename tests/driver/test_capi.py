"""The C interface: the programs that the build makes of tests/capi."""

import pytest
from programs import captured


@pytest.mark.parametrize("name", ["kernels", "simulation"])
def test_c_interface(executable, inputs, name):
    program = executable.parents[1] / "tests" / "capi" / f"test_{name}"
    done = captured(
        [program, inputs][: 1 + (name == "simulation")],
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("\n") == 1, done.stdout
    assert done.stdout.endswith(" passed, 0 failed\n")
    assert done.stderr == ""
