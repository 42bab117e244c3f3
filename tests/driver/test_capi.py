"""The C interface: the program that the build makes of tests/capi."""

import subprocess


def test_c_interface(executable):
    program = executable.parents[1] / "tests" / "capi" / "test_capi"
    done = subprocess.run([program], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.endswith(" passed, 0 failed\n")
