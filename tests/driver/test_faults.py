"""Seeded faults: one wrong line of physics at a time, each of which the tests must notice.

One copy of the project is built with little optimisation; each fault changes one line of it, and
what depends on that is built again. The unit tests of physics run first and the physics tests of
the driver only if these notice nothing. The release build only, some minutes; CONTENSOU_NO_FAULTS
skips it (scripts/test --quick sets it).
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys

import pytest

# File, line, wrong line, what is wrong.
FAULTS = {
    "torque not turned into the body": (
        "dynamics/system.f90",
        "moment = to_body(self%pose(index)%rotation, self%torque(:, index))",
        "moment = to_inertial(self%pose(index)%rotation, self%torque(:, index))",
    ),
    "sign of the gyroscopic term": (
        "dynamics/system.f90",
        "rate(11:13) = (moment - cross(w, body%inertia*w))/body%inertia",
        "rate(11:13) = (moment + cross(w, body%inertia*w))/body%inertia",
    ),
    "sign of the drilling torque": (
        "dynamics/system.f90",
        "torque = load%friction_torque*at%normal",
        "torque = -load%friction_torque*at%normal",
    ),
    "sign of a lever arm": (
        "dynamics/system.f90",
        "+ cross(at%point - b%position, force)",
        "- cross(at%point - b%position, force)",
    ),
    "slip without the rotation of A": (
        "dynamics/system.f90",
        "- a%velocity - cross(a%spin, point - a%position)",
        "- a%velocity",
    ),
    "factor of the damping": (
        "contact/damping.f90",
        "f = 1.5_wp*coefficient*elastic*rate",
        "f = coefficient*elastic*rate",
    ),
    "contact that pulls": (
        "contact/damping.f90",
        "f = max(elastic + self%kernel(elastic, approach, rate, self%coefficient), 0.0_wp)",
        "f = elastic + self%kernel(elastic, approach, rate, self%coefficient)",
    ),
    "frozen spot": (
        "contact/normal.f90",
        "a = self%axis_a*sqrt(approach)",
        "a = self%axis_a*1.0e-3_wp",
    ),
    "axes of the spot mixed up": (
        "contact/normal.f90",
        "force_b = 0.2_wp*work*self%axis_b**2",
        "force_b = 0.2_wp*work*self%axis_a**2",
    ),
    "sign in the cubic of the friction force": (
        "contact/wrench_exact.f90",
        "fx = -1.5_wp*ux*(shape%d_integral - shape%j11*p - shape%j02*ux2)",
        "fx = -1.5_wp*ux*(shape%d_integral + shape%j11*p - shape%j02*ux2)",
    ),
    "power of friction": (
        "contact/law.f90",
        "load%friction_power = -(fx*vx + fy*vy + load%friction_torque*load%spin)",
        "load%friction_power = -(fx*vx + fy*vy - load%friction_torque*load%spin)",
    ),
    "sign in the rate of a quaternion": (
        "base/rotations.f90",
        "rate(4) = 0.5_wp*(q(1)*w(3) + q(2)*w(2) - q(3)*w(1)) + pull*q(4)",
        "rate(4) = 0.5_wp*(q(1)*w(3) - q(2)*w(2) - q(3)*w(1)) + pull*q(4)",
    ),
}

DRIVER_TESTS = ("tests/driver/test_corners.py", "tests/driver/test_physics.py")
SUITES = ("dynamics", "contact", "geometry", "wrench", "integrate")


class Copy:
    """A copy of the project with its build."""

    def __init__(self, root, folder):
        self.folder = folder
        skipped = shutil.ignore_patterns("__pycache__")
        for name in ("src", "drivers", "tests", "scripts", "include", "inputs"):
            shutil.copytree(root / name, folder / name, ignore=skipped)
        for name in ("meson.build", "meson_options.txt", "pyproject.toml"):
            shutil.copy(root / name, folder)
        self.command("meson", "setup", "build", "--buildtype=plain", "-Doptimization=1")
        self.build()

    def command(self, *words):
        """Run a command, which must succeed."""
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]

    def build(self):
        """Build what is out of date."""
        self.command("ninja", "-C", "build", "tests/unit_tests", "drivers/contensou")

    def unit_failures(self):
        """Number of checks of physics that fail."""
        done = subprocess.run(
            ["build/tests/unit_tests", *SUITES],
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        closing = re.search(r"^(\d+) passed, (\d+) failed$", done.stdout, re.MULTILINE)
        assert closing, done.stdout[-3000:] + done.stderr[-3000:]
        assert int(closing[1]) > 0
        return int(closing[2])

    def driver_failures(self):
        """Number of the driver's physics tests that fail; stops at the first."""
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-x", *DRIVER_TESTS],
            cwd=self.folder,
            env=os.environ | {"CONTENSOU": str(self.folder / "build/drivers/contensou")},
            capture_output=True,
            text=True,
            timeout=900,
            check=False,
        )
        assert done.returncode in (0, 1), done.stdout[-3000:]
        return done.returncode


@pytest.fixture(scope="module")
def project(root, tmp_path_factory, build_kind):
    """The copy, built without a fault, whose tests pass."""
    if build_kind != "release" or os.environ.get("CONTENSOU_NO_FAULTS"):
        pytest.skip("seeded faults take some minutes")
    copy = Copy(root, tmp_path_factory.mktemp("faults"))
    assert copy.unit_failures() == 0
    assert copy.driver_failures() == 0
    return copy


@pytest.mark.xdist_group("faults")
@pytest.mark.parametrize("name", FAULTS)
def test_fault_is_noticed(project, name):
    file, line, wrong = FAULTS[name]
    path = project.folder / "src" / file
    right = path.read_text()
    assert right.count(line) == 1, f"{line!r} is not once in {file}"
    path.write_text(right.replace(line, wrong))
    try:
        project.build()
        assert project.unit_failures() or project.driver_failures()
    finally:
        path.write_text(right)
