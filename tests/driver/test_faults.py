"""Seeded faults: one wrong line of physics at a time, each of which the tests must notice.

Each fault changes one line of one file, which is compiled and linked before the library of the
build under test; what the build compiles twice, twice. First runs what is likely to notice the
fault; if it does not, or if nothing is known of that, the unit tests of physics and then the
physics tests of the driver. What notices the fault must pass without it. The release build only;
CONTENSOU_NO_FAULTS skips it (scripts/test --quick sets it).
"""

from __future__ import annotations

import gzip
import json
import os
import re
import shlex
import sys
from functools import cache
from xml.etree import ElementTree

import pytest
from programs import captured

# File, line, wrong line, what is wrong.
FAULTS = {
    "pivot of a complementarity problem": (
        "special/complementarity.f90",
        "precedes = difference < 0.0_wp",
        "precedes = difference > 0.0_wp",
    ),
    "decision which contacts close": (
        "dynamics/rests.f90",
        "if (link%free + negligible*largest_acceleration(system, link) >= least) cycle",
        "if (link%free + negligible*largest_acceleration(system, link) <= least) cycle",
    ),
    "supports that depend on each other": (
        "special/elimination.f90",
        "left = left - factor(i, j)*factor(pivot, j)",
        "left = left + factor(i, j)*factor(pivot, j)",
    ),
    "torque not turned into the body": (
        "dynamics/equations.f90",
        "moment = to_body(self%pose(index)%rotation, self%load(index)%torque)",
        "moment = to_inertial(self%pose(index)%rotation, self%load(index)%torque)",
    ),
    "sign of the gyroscopic term": (
        "dynamics/equations.f90",
        "turning = (moment - cross(w, body%inertia*w))/body%inertia",
        "turning = (moment + cross(w, body%inertia*w))/body%inertia",
    ),
    "sign of the drilling torque": (
        "dynamics/equations.f90",
        "torque = load%friction_torque*at%normal",
        "torque = -load%friction_torque*at%normal",
    ),
    "sign of a lever arm": (
        "dynamics/equations.f90",
        "+ cross(at%point - b%position, force)",
        "- cross(at%point - b%position, force)",
    ),
    "slip without the rotation of A": (
        "dynamics/mechanism.f90",
        "- a%velocity - cross(a%spin, point - a%position)",
        "- a%velocity",
    ),
    "factor of the damping": (
        "contact/damping/coefficient.f90",
        "f = 1.5_wp*coefficient*elastic*rate",
        "f = coefficient*elastic*rate",
    ),
    "contact that pulls": (
        "contact/damping/law.f90",
        "f = max(elastic + self%force(elastic, approach, rate), 0.0_wp)",
        "f = elastic + self%force(elastic, approach, rate)",
    ),
    "frozen spot": (
        "contact/normal/law.f90",
        "a = self%axis_a*sqrt(approach)",
        "a = self%axis_a*1.0e-3_wp",
    ),
    "axes of the spot mixed up": (
        "contact/normal/law.f90",
        "force_b = 0.2_wp*work*self%axis_b**2",
        "force_b = 0.2_wp*work*self%axis_a**2",
    ),
    "hysteresis of an oblique spot": (
        "contact/rolling/lever.f90",
        "arm = arm*johnson*sqrt((a*y)**2 + (b*x)**2)/speed",
        "arm = arm*johnson*a*b*speed/sqrt((b*y)**2 + (a*x)**2)",
    ),
    "impact that knows no tolerance": (
        "dynamics/routh.f90",
        "admitted = max(of_step*tolerance, smallest_tolerance)",
        "admitted = 1.0e-4_wp",
    ),
    "second spot that is missed": (
        "contact/search.f90",
        "if (.not. found .or. gap >= limit) return",
        "if (.not. found .or. gap >= limit .or. n > 0) return",
    ),
    "balance that leaks": (
        "contact/normal/law.f90",
        "force_a = 0.2_wp*work*self%axis_a**2",
        "force_a = 0.0_wp*work*self%axis_a**2",
    ),
    "sign in the cubic of the friction force": (
        "contact/wrench_exact.f90",
        "fx = -1.5_wp*ux*(shape%d_integral - shape%j11*p - shape%j02*ux2)",
        "fx = -1.5_wp*ux*(shape%d_integral + shape%j11*p - shape%j02*ux2)",
    ),
    "power of friction": (
        "contact/law.f90",
        "load%friction_power = -(wrench(1)*slides%vx + wrench(2)*slides%vy + wrench(3)*slides%w)",
        "load%friction_power = -(wrench(1)*slides%vx + wrench(2)*slides%vy - wrench(3)*slides%w)",
    ),
    "torsional stiffness of an ellipse": (
        "contact/tangential/stiffness.f90",
        "p = rest*shape%b_integral + 3.0_wp*poisson*shape%j20",
        "p = rest*shape%b_integral - 3.0_wp*poisson*shape%j20",
    ),
    "torque of a shell": (
        "contact/tangential/slip.f90",
        "force(3) = -arm*force(3)",
        "force(3) = -edge%load**2*force(3)",
    ),
    "shell that sticks too soon": (
        "contact/tangential/ellipse_pass.f90",
        "- (1.0_wp - share)*bears*arm",
        "- (1.05_wp - share)*bears*arm",
    ),
    "shell of a needle that sticks too soon": (
        "contact/tangential/abreast.f90",
        "<= (1.0_wp - share)*load*torque",
        "<= (1.05_wp - share)*load*torque",
    ),
    "ellipsoid that is not within the limit of a shell": (
        "contact/tangential/shells.f90",
        "inner_ellipsoid = 0.813_wp + 0.073_wp*ratio",
        "inner_ellipsoid = 0.813_wp + 0.12_wp*ratio",
    ),
    "shell of an ellipse that sticks too soon, without a look at its limit": (
        "contact/tangential/abreast.f90",
        "surely_stuck*plane*spin - limit",
        "1.1_wp*plane*spin - limit",
    ),
    "work of the slip of a shell of an ellipse": (
        "contact/tangential/abreast.f90",
        "+ (g(i, 3) - force(i, 3))*u(i, 3)) &\n            /max(",
        "+ g(i, 3)*u(i, 3)) &\n            /max(",
    ),
    "force after the last step of a shell of an ellipse": (
        "contact/tangential/ellipse_pass.f90",
        "force(i, 3) = f3 + slips*(m3 + c3)",
        "force(i, 3) = f3 + slips*(m2 + c3)",
    ),
    "table of sliding on an ellipse": (
        "contact/tangential/ellipse_pass.f90",
        "jaa = k2*jbb + c*ends*q(i)",
        "jaa = k2*jbb - c*ends*q(i)",
    ),
    "stiffening that makes energy": (
        "contact/tangential/trial.f90",
        "shift(j, 1) = shift(j, 1)*(before/max(now, before))",
        "shift(j, 1) = shift(j, 1)*(max(now, before)/before)",
    ),
    "shells that are merged without their forces": (
        "contact/tangential/nest.f90",
        "self%shift(at, :) = (self%share(at, :)*self%shift(at, :) &\n"
        "         + self%share(at + 1, :)*self%shift(at + 1, :))/total",
        "self%shift(at, :) = 0.5_wp*(self%shift(at, :) + self%shift(at + 1, :))",
    ),
    "strain that is let go with each step on an ellipse": (
        "contact/tangential/trial.f90",
        "new_x = was(1)*x - was(2)*y\n            new_y = was(2)*x + was(1)*y",
        "new_x = x\n            new_y = y",
    ),
    "slip along the mean of a step that turns": (
        "contact/tangential/memory.f90",
        "*(v*(dv/vv) - d)",
        "*(d*(dv/vv) - d)",
    ),
    "sliding that turns back within a step": (
        "contact/tangential/memory.f90",
        "end = in_strains(self, self%step_rates(1:3))",
        "end = in_strains(self, self%rates(1:3))",
    ),
    "twist that is kept without its energy": (
        "contact/tangential/trial.f90",
        "energy = flat + abs(uneven(j))*(0.5_wp",
        "energy = flat + 0.0_wp*(0.5_wp",
    ),
    "graze that begins at the touch": (
        "integrate/gaps.f90",
        "is_open = self%gap(index)%value > self%resolution",
        "is_open = self%gap(index)%value > huge(self%resolution)",
    ),
    "bounce that is not one for the events": (
        "integrate/explicit8.f90",
        "where (self%problem%turns) g = huge(g)",
        "where (self%problem%turns) g = g",
    ),
    "slip that ends within a step": (
        "contact/tangential/memory.f90",
        "if (begin > growth .and. end < growth) part",
        "if (begin > growth .and. end < -growth) part",
    ),
    "law of creep on the limit": (
        "contact/tangential/carry.f90",
        "bears = bears + at%slips*(steady - bears)",
        "bears = bears + at%slips*(bears - steady)",
    ),
    "memory of rigid contacts measured against forces that crush them": (
        "integrate/motion.f90",
        "usual = overlap_of_load(scene, contact, s%velocity)",
        "usual = s%usual_overlap()",
    ),
    "slip that does not fade as it rolls": (
        "contact/tangential/memory.f90",
        "now%fading = turned/shifted",
        "now%fading = shifted/shifted",
    ),
    "steady rolling that rings": (
        "contact/tangential/carry.f90",
        "steadying(3) = [0.3_wp, 0.35_wp, 1.0_wp]",
        "steadying(3) = [0.0_wp, 0.0_wp, 0.0_wp]",
    ),
    "creep that is not lost": (
        "contact/tangential/carry.f90",
        "lost = speed*(at%creepage + g*missing)",
        "lost = speed*g*missing",
    ),
    "creep that drives": (
        "contact/tangential/carry.f90",
        "if (.not. power > 0.0_wp) return",
        "if (.not. power < 0.0_wp) return",
    ),
    "work of the slip of a shell": (
        "contact/tangential/slip.f90",
        "work = dot_product(f, u)*dot_product(force - f, u)/dot_product(u, stiffness*u)",
        "work = dot_product(force, u)*dot_product(force - f, u)/dot_product(u, stiffness*u)",
    ),
    "place of the shells": (
        "contact/tangential/edges.f90",
        "load = x*(1.5_wp - 0.5_wp*y)",
        "load = x*(1.5_wp - 0.5_wp*x)",
    ),
    "sign in the rate of a quaternion": (
        "base/rotations.f90",
        "rate(4) = 0.5_wp*(q(1)*w(3) + q(2)*w(2) - q(3)*w(1)) + pull*q(4)",
        "rate(4) = 0.5_wp*(q(1)*w(3) - q(2)*w(2) - q(3)*w(1)) + pull*q(4)",
    ),
    "gaps over hollows": (
        "dynamics/mechanism.f90",
        "if (s > k/unbounded) gap%sharpness = k*k/s",
        "if (s > k/unbounded) gap%sharpness = 0.0_wp",
    ),
}

DRIVER_TESTS = (
    "tests/driver/test_rigid.py::test_legs_neither_pull_nor_sink",
    "tests/driver/test_nothing_silent.py",
    "tests/driver/test_spots.py::test_symmetric_from_the_start",
    "tests/driver/test_shots.py",
    "tests/driver/test_corners.py",
    "tests/driver/test_physics.py",
)
# The quickest first.
SUITES = (
    *("dynamics", "contact", "rigid", "integrate", "tangential", "wrench", "jacobian", "geometry"),
    "transient",
)
# Where to look first for those that only slow suites or driver tests notice.
LIKELY = {
    "axes of the spot mixed up": "jacobian",
    "hysteresis of an oblique spot": "jacobian",
    "decision which contacts close": "tests/driver/test_rigid.py::test_legs_neither_pull_nor_sink",
    "impact that knows no tolerance": (
        "tests/driver/test_nothing_silent.py::test_an_impact_holds_the_tolerance"
    ),
    "balance that leaks": "tests/driver/test_nothing_silent.py::test_two_spots_in_a_bore",
    "second spot that is missed": "tests/driver/test_spots.py::test_symmetric_from_the_start",
    "gaps over hollows": "tests/driver/test_shots.py::test_what_a_body_meets_is_seen",
    "creep that is not lost": "tests/driver/test_transient.py",
    "creep that drives": "transient",
    "steady rolling that rings": "transient",
    "law of creep on the limit": "transient",
    "strain that is let go with each step on an ellipse": "tangential",
    "slip along the mean of a step that turns": "tangential",
    "slip that does not fade as it rolls": "tangential",
    "sliding that turns back within a step": (
        "tests/driver/test_tangential_runs.py::test_what_slides_to_rest_stops"
    ),
    "twist that is kept without its energy": (
        "tests/driver/test_tangential.py::test_a_twist_is_held_under_a_load_that_pulsates"
    ),
    "graze that begins at the touch": (
        "tests/driver/test_tangential_runs.py::test_a_graze_that_begins_at_the_touch"
    ),
    "bounce that is not one for the events": (
        "tests/driver/test_tangential_rigid.py::"
        "test_a_ball_in_flight_stays_there_as_another_one_lands"
    ),
    "slip that ends within a step": (
        "tests/driver/test_tangential_runs.py::test_it_sticks_under_a_rising_load"
    ),
    "memory of rigid contacts measured against forces that crush them": (
        "tests/driver/test_tangential_runs.py::test_what_slides_up_a_slope_slides_back"
    ),
}
UNIT_TESTS = "tests/unit_tests"
PROGRAM = "drivers/contensou"


def without_source(interface):
    """A module file of gfortran without its first line, which names the source."""
    return gzip.decompress(interface.read_bytes()).partition(b"\n")[2]


def run_suite(program, name, root):
    """Run the unit tests whose suite has this in its name: how many failed."""
    done = captured([program, name], cwd=root, timeout=300)
    closing = re.search(r"^(\d+) passed, (\d+) failed$", done.stdout, re.MULTILINE)
    assert closing, done.stdout[-3000:] + done.stderr[-3000:]
    assert int(closing[1]) + int(closing[2]) > 0
    return int(closing[2])


def run_driver(program, tests, root, report):
    """Run driver tests up to the first that fails: the names of those that failed."""
    done = captured(
        [
            *(sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider"),
            *(f"--junitxml={report}", *tests),
        ],
        cwd=root,
        env=os.environ | {"CONTENSOU": str(program)},
        timeout=900,
    )
    assert done.returncode in (0, 1), done.stdout[-3000:]
    cases = [case for case in ElementTree.parse(report).iter("testcase") if len(case)]
    failed = [case for case in cases if case.find("failure") is not None]
    assert bool(failed) == (done.returncode == 1), done.stdout[-3000:]
    return [f"{case.get('classname').replace('.', '/')}.py::{case.get('name')}" for case in failed]


class Build:
    """The build under test, whose programs can be linked anew with another object of one file."""

    def __init__(self, root, folder):
        self.root = root
        self.folder = folder
        self.sound = cache(lambda suite: run_suite(folder / UNIT_TESTS, suite, root) == 0)

    def command(self, words):
        """Run a command in the build folder, which must succeed; its output."""
        done = captured(words, cwd=self.folder, timeout=600)
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
        return done.stdout

    def compile(self, file, line, wrong, folder):
        """Compile a file of the library as the build does, with a line that is wrong: objects."""
        commands = json.loads((self.folder / "compile_commands.json").read_text())
        name = file.rpartition("/")[2].removesuffix(".f90")
        # Also what is generated from it for wide registers.
        sources = [f"/src/{file}", *(f"/{name}_{suffix}.f90" for suffix in ("wide", "widest"))]
        entries = [one for one in commands if one["file"].endswith(tuple(sources))]
        assert entries
        made = []
        for i, entry in enumerate(entries):
            right = (self.folder / entry["file"]).read_text()
            assert right.count(line) == 1, f"{line!r} is not once in {entry['file']}"
            made.append(self.compile_one(entry, right.replace(line, wrong), folder, f"changed_{i}"))
        return made

    def compile_one(self, entry, text, folder, name):
        """Compile a changed file by one of the commands of the build; the object."""
        modules = self.folder / entry["output"].rpartition("/")[0]
        folder = folder / name
        folder.mkdir()
        source, made = folder / f"{name}.f90", folder / f"{name}.o"
        source.write_text(text)
        places = {entry["file"]: str(source), entry["output"]: str(made)}
        words = [places.get(word, word) for word in shlex.split(entry["command"])]
        words = [f"-J{folder}" if word.startswith("-J") else word for word in words]
        assert {str(source), str(made), f"-J{folder}"} <= set(words), entry["command"]
        self.command([word for word in words if not word.startswith(("-flto", "-ffat-lto"))])
        # What depends on the file is taken as it is, which is right while the interface stays.
        interfaces = list(folder.glob("*.mod"))
        assert interfaces
        for interface in interfaces:
            assert without_source(interface) == without_source(modules / interface.name)
        return made

    def link(self, target, made, folder):
        """Link a program with objects that take the places of those in the library."""
        words = shlex.split(self.command(["ninja", "-t", "commands", target]).splitlines()[-1])
        program = folder / target.rpartition("/")[2]
        assert words.count(target) == 1, words
        assert words.count("src/libcontensou.a") == 1, words
        words[words.index(target)] = str(program)
        at = words.index("src/libcontensou.a")
        words[at:at] = map(str, made)
        self.command(["-fno-lto" if word.startswith("-flto") else word for word in words])
        return program


@pytest.fixture(scope="module")
def build(root, executable, build_kind):
    """The build under test."""
    if build_kind != "release" or os.environ.get("CONTENSOU_NO_FAULTS"):
        pytest.skip("seeded faults with the release build only")
    folder = executable.parents[1]
    if not (folder / UNIT_TESTS).is_file() or executable != folder / PROGRAM:
        pytest.skip("the tests are not built beside this executable")
    return Build(root, folder)


def noticed_by_driver(tests, build, made, executable, folder):
    """Whether one of some driver tests fails with the fault, and passes without it."""
    program = build.link(PROGRAM, made, folder)
    failed = run_driver(program, tests, build.root, folder / "with.xml")
    if failed:
        assert not run_driver(executable, failed, build.root, folder / "without.xml")
    return bool(failed)


def test_what_is_likely_is_there():
    assert set(LIKELY) <= set(FAULTS)


@pytest.mark.parametrize("name", FAULTS)
def test_fault_is_noticed(build, root, executable, tmp_path, name):
    file, line, wrong = FAULTS[name]
    made = build.compile(file, line, wrong, tmp_path)
    likely = LIKELY.get(name, "")
    if "/" in likely and noticed_by_driver([likely], build, made, executable, tmp_path):
        return
    unit_tests = build.link(UNIT_TESTS, made, tmp_path)
    for suite in sorted(SUITES, key=lambda suite: suite != likely):
        if run_suite(unit_tests, suite, root) > 0:
            assert build.sound(suite), f"the suite {suite} fails without the fault, too"
            return
    assert noticed_by_driver(DRIVER_TESTS, build, made, executable, tmp_path), "nothing fails"
