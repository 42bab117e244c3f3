"""What a run pays for: instructions of the right-hand side, and of a run beside bare CVODE.

Instructions are counted by valgrind's callgrind, so that the load of the machine does not matter;
for a right-hand side inside of it alone, with all that is called from there. `scripts/bench` takes
times.
"""

from __future__ import annotations

import itertools
import os
import re
import shutil
from collections import Counter
from dataclasses import dataclass

import h5py
import pytest
from programs import captured, instructions

MODELS = ("coulomb", "contensou_simplified", "pade11", "pade22", "contensou_exact")
DAMPINGS = ("hunt_crossley", "viscous", "tsuji")
ALLOCATORS = {"malloc", "calloc", "realloc", "free", "posix_memalign", "aligned_alloc", "memalign"}
RIGHT_HAND_SIDE = "__contensou_dynamics_equations_MOD_derivative"

# A ball pressed 0.1 um into the floor; it slides, spins, and rebounds. No group or key is here that
# a case below does not name itself.
BALL = """\
&scene {gravity} t_end = 1.0 /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body name = 'top', mass = 6.0e-3, inertia = 8.0e-7, 8.0e-7, 7.0e-7,
   position = 0, 0, 0.0149999, velocity = {velocity}, axis = 0, 0, 1, angle = 0.1,
   spin = 0, 0, 180 /
&surface name = 'ball', body = 'top', shape = 'sphere', radius = 1.5e-2, material = 'wood' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'wood' /
&contact name = 'ball_floor', surfaces = 'ball', 'floor' {damping} {friction} /
"""
GRAVITY = "gravity = 0, 0, -9.81,"
DAMPING = ", damping = 'hunt_crossley', damping_coefficient = 100.0"
FRICTION = ", friction = 'contensou_exact', friction_coefficient = 0.3"
# The rim of the spot moves at 0.007 m/s about its centre, which slides:
SLOW = "0.003, 0.002, -0.01"  # slower than the rim, the rotation centre is inside the spot
FAST = "0.05, 0.02, -0.01"  # faster, the rotation centre is outside


@dataclass(frozen=True)
class Count:
    """Per evaluation of the right-hand side: instructions, and calls of each function.

    Instructions are those outside of the allocator, whose work depends on what it did before.
    Without optimization the compiler's runtime allocates too, in its general matmul; only an
    optimised build tells what the source makes the machine do.
    """

    instructions: float
    calls: dict[str, int]

    def of_module(self, *modules) -> dict[str, int]:
        """Calls of the procedures of some modules and of those in the folders of their names."""
        return {
            name: calls
            for name, calls in self.calls.items()
            if any(f"__{module}_" in name for module in modules)
        }

    def allocations(self) -> dict[str, int]:
        """Calls of the functions that allocate and release memory."""
        return {name: calls for name, calls in self.calls.items() if name in ALLOCATORS}


def parse_profile(text):
    """Instructions outside of the allocator, and calls of each function, from callgrind's file."""
    names: dict[str, str] = {}
    calls: Counter[str] = Counter()
    instructions = 0
    caller, callee, waiting = "", "", 0
    for line in text.splitlines():
        if waiting:
            # The line after "calls=" has the cost of the calls; it is zero outside of the part that
            # was collected.
            inclusive = int(line.split()[-1])
            if inclusive > 0:
                calls[callee] += waiting
            if callee in ALLOCATORS and caller not in ALLOCATORS:
                instructions -= inclusive
            waiting = 0
            continue
        if found := re.match(r"c?fn=\((\d+)\)(?: (.*))?$", line):
            number, name = found.groups()
            if name:
                names[number] = re.sub(r"'\d+$", "", name)
            if line.startswith("cfn="):
                callee = names[number]
            else:
                caller = names[number]
        elif line.startswith("calls="):
            waiting = int(line[6:].split()[0])
        elif line.startswith("summary:"):
            instructions += int(line.split()[1])
    return instructions, calls


def program(executable, name):
    """A program of tests/cost, from the build folder of the executable."""
    path = executable.parent.parent / "tests" / "cost" / name
    if not path.is_file():
        pytest.fail(f"there is no {path}: the build folder lacks the programs of tests/cost")
    return path


@pytest.fixture
def count(executable, sanitized, tmp_path):
    """Count what one evaluation of the right-hand side of a scene costs."""
    if sanitized:
        pytest.skip("valgrind and the sanitizers exclude each other")
    if shutil.which("valgrind") is None:
        pytest.skip("there is no valgrind")
    probe = program(executable, "rhs_probe")

    def profiled(probe, scene, evaluations):
        profile = tmp_path / "profile"
        done = captured(
            [
                *("valgrind", "--tool=callgrind", "--quiet"),
                *(f"--toggle-collect={RIGHT_HAND_SIDE}", f"--callgrind-out-file={profile}"),
                *(str(probe), str(scene), str(evaluations)),
            ],
            # Symbols of libraries are looked up before the first evaluation, not in it.
            env={**os.environ, "LD_BIND_NOW": "1"},
        )
        assert done.returncode == 0, done.stdout + done.stderr
        assert "NaN" not in done.stdout
        return parse_profile(profile.read_text())

    def count_it(
        gravity=GRAVITY,
        damping=DAMPING,
        friction=FRICTION,
        velocity=SLOW,
        text=None,
        evaluations=100,
    ):
        scene = tmp_path / "scene.nml"
        scene.write_text(
            text
            or BALL.format(gravity=gravity, damping=damping, friction=friction, velocity=velocity)
        )
        instructions, calls = profiled(probe, scene, evaluations)
        if calls[RIGHT_HAND_SIDE] != evaluations:
            # Rigid contacts are decided on at the beginning, by right-hand sides of their own.
            at_beginning, calls_there = profiled(probe, scene, 0)
            instructions -= at_beginning
            calls.subtract(calls_there)
        assert calls[RIGHT_HAND_SIDE] == evaluations
        # Few are the calls outside that share a caller with those inside.
        whole = {name: n // evaluations for name, n in calls.items() if n >= evaluations}
        return Count(instructions / evaluations, whole)

    return count_it


@pytest.fixture
def table(record_property):
    """Print named figures, and keep them in the report."""

    def show(title, figures):
        print(f"\n{title}")
        for name, value in figures.items():
            print(f"   {name:32s} {value:10.4g}")
            record_property(f"{title}: {name}", value)

    return show


def test_each_effect_that_is_not_named_saves_its_instructions(count, table):
    everything = count()
    without = {
        "drilling": count(friction=FRICTION + ", drilling = .false."),
        "friction": count(friction=""),
        "damping": count(damping=""),
        "friction and damping": count(friction="", damping=""),
    }
    table(
        "instructions per right-hand side",
        {"all effects": everything.instructions}
        | {f"without {name}": case.instructions for name, case in without.items()},
    )
    for name, case in without.items():
        assert case.instructions < everything.instructions, name
    assert without["friction"].instructions < without["drilling"].instructions
    bare = without["friction and damping"].instructions
    assert bare < min(without["friction"].instructions, without["damping"].instructions)

    # The exact wrench is a call that must be seen, or the tests for its absence prove nothing.
    assert everything.of_module("contensou_contact_friction", "contensou_contact_wrench")
    assert everything.of_module("contensou_contact_damping")
    for name in ("friction", "friction and damping"):
        assert not without[name].of_module("contensou_contact_friction", "contensou_contact_wrench")
    for name in ("damping", "friction and damping"):
        assert not without[name].of_module("contensou_contact_damping")


def test_gravity_costs_no_instructions(count, build_kind, table):
    """The load of a body begins with its weight, which is zero without gravity."""
    named = count()
    absent = count(gravity="")
    table(
        "instructions per right-hand side, gravity",
        {"named": named.instructions, "not named": absent.instructions},
    )
    assert build_kind == "checked" or absent.instructions == named.instructions


def test_a_contact_that_is_not_named_costs_nothing(count, build_kind):
    bodies = [
        line
        for line in BALL.format(gravity=GRAVITY, damping="", friction="", velocity=SLOW).split("&")
        if line and not line.startswith(("contact", "surface", "material"))
    ]
    lone = count(text="".join("&" + group for group in bodies))
    assert not lone.of_module(
        "contensou_contact_law",
        "contensou_contact_geometry",
        "contensou_contact_normal",
        "contensou_contact_friction",
        "contensou_contact_wrench",
        "contensou_contact_damping",
    )
    assert lone.instructions < count(friction="", damping="").instructions
    assert build_kind == "checked" or not lone.allocations()


def test_an_open_contact_costs_its_gap_alone(count):
    text = BALL.format(gravity=GRAVITY, damping=DAMPING, friction=FRICTION, velocity=SLOW)
    lifted = count(text=text.replace("0.0149999", "0.0151"))
    assert not lifted.of_module(
        "contensou_contact_friction", "contensou_contact_wrench", "contensou_contact_damping"
    )
    assert lifted.instructions < count(friction="", damping="").instructions


@pytest.mark.parametrize(
    ("key", "named"),
    [
        ("friction", ", friction = 'none'"),
        ("friction", ", friction = 'none', friction_coefficient = 0.3, drilling = .false."),
        ("damping", ", damping = 'none'"),
    ],
)
def test_naming_no_model_is_the_same_as_not_naming_it(count, key, named):
    base = {"friction": "", "damping": ""}
    assert count(**(base | {key: named})).instructions == count(**base).instructions


def test_the_cost_is_the_same_for_each_evaluation(count):
    assert count(evaluations=50).instructions == count(evaluations=500).instructions


def test_parameters_do_not_change_the_cost(count):
    one = count(friction=", friction = 'contensou_simplified', friction_coefficient = 0.3")
    two = count(friction=", friction = 'contensou_simplified', friction_coefficient = 0.6")
    assert one.instructions == two.instructions


@pytest.mark.parametrize("velocity", [SLOW, FAST], ids=["slow", "fast"])
def test_nothing_allocates_in_the_right_hand_side(count, build_kind, table, velocity):
    cases = {"none": ""}
    for model in MODELS:
        cases[model] = (
            f", friction = '{model}', friction_coefficient = 0.3, regularization_velocity = 1e-4"
        )
    counts = {name: count(friction=text, velocity=velocity) for name, text in cases.items()}
    table(
        f"instructions per right-hand side, by friction model, v = {velocity}",
        {name: case.instructions for name, case in counts.items()},
    )
    for name, case in counts.items():
        assert build_kind == "checked" or not case.allocations(), name
        assert case.calls[RIGHT_HAND_SIDE] == 1
    assert all(counts["none"].instructions < counts[name].instructions for name in MODELS)


def test_rigid_contact_allocates_nothing(count, build_kind, table):
    ball = BALL.replace("0.0149999", "0.015")
    cases = {}
    for model in (None, *MODELS):
        friction = f", friction = '{model}', friction_coefficient = 0.3" if model else ""
        if model == "coulomb":
            friction += ", regularization_velocity = 1e-4"
        for rolling in ("", ", rolling = 'hysteresis', rolling_coefficient = 0.5"):
            if rolling:
                rolling += ", rolling_regularization = 0.01"
            text = ball.format(
                gravity=GRAVITY,
                damping=", normal = 'rigid'",
                friction=friction + rolling,
                velocity="0.003, 0.002, 0",
            )
            cases[f"{model or 'none'}{' and rolling' if rolling else ''}"] = count(text=text)
    table(
        "instructions per right-hand side, rigid contact",
        {name: case.instructions for name, case in cases.items()},
    )
    for name, case in cases.items():
        assert case.of_module("contensou_dynamics_constraints"), name
        assert build_kind == "checked" or not case.allocations(), name


# A bar on two balls.
BAR = """\
&scene gravity = 0, 0, -9.81, t_end = 1.0 /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body name = 'bar', mass = 0.1, inertia = 8e-6, 8e-4, 8e-4, position = 0, 0, 0.01,
   velocity = 0.3, 0.2, 0, spin = 0, 0, 3 /
&surface name = 'left', body = 'bar', shape = 'sphere', radius = 1e-2, centre = -0.05, 0, 0,
   material = 'wood' /
&surface name = 'right', body = 'bar', shape = 'sphere', radius = 1e-2, centre = 0.05, 0, 0,
   material = 'wood' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'wood' /
&contact name = 'l', surfaces = 'left', 'floor', normal = 'rigid' {friction} /
&contact name = 'r', surfaces = 'right', 'floor', normal = 'rigid' {friction} /
"""


def test_one_or_two_rigid_contacts_cost_what_they_did(count, build_kind, table):
    if build_kind != "release":
        pytest.skip("instructions are those of a release build")
    hertz = count(damping="", velocity="0.3, 0.2, 0").instructions
    one = BALL.replace("0.0149999", "0.015").format(
        gravity=GRAVITY, damping=", normal = 'rigid'", friction=FRICTION, velocity="0.3, 0.2, 0"
    )
    shares = {
        "one": count(text=one).instructions / hertz,
        "two": count(text=BAR.format(friction=FRICTION)).instructions / hertz,
    }
    table("instructions of closed rigid contacts, over one with Hertz's force", shares)
    # 2.1 and 4.2 with link-time optimization, 2.3 and 4.4 without; what shares loads among more
    # contacts, or solves for them together, would add a fifth at least.
    assert shares["one"] < 2.4
    assert shares["two"] < 4.7


def test_damping_allocates_nothing_whichever_law(count, build_kind, table):
    counts = {
        name: count(damping=f", damping = '{name}', damping_coefficient = 0.1", friction="")
        for name in DAMPINGS
    }
    counts["none"] = count(damping="", friction="")
    table(
        "instructions per right-hand side, by damping law",
        {name: case.instructions for name, case in counts.items()},
    )
    for name, case in counts.items():
        assert build_kind == "checked" or not case.allocations(), name
    assert all(counts["none"].instructions < counts[name].instructions for name in DAMPINGS)


def run_it(command, folder):
    """Run a command; its standard output."""
    done = captured([str(word) for word in command], cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_run_costs_little_more_than_bare_cvode(executable, build_kind, inputs, tmp_path, table):
    def both(t_end):
        """Commands for the run and for its yardstick."""
        scene = tmp_path / f"{t_end}.nml"
        text = (inputs / "tippe_top.nml").read_text()
        scene.write_text(text.replace("t_end = 8.0", f"t_end = {t_end}"))
        run = [executable, "run", scene, "-o", tmp_path / "run.h5", "--force", "-q"]
        return {"run": run, "bare": [program(executable, "bare_cvode"), scene]}

    def steps_of(command):
        """Steps and height at the end."""
        out = run_it(command, tmp_path)
        if command[0] != executable:
            return int(out.split()[0]), float(out.split()[1])
        with h5py.File(tmp_path / "run.h5") as file:
            return int(file["/integrator/steps"][()]), float(file["/summary/position"][0, 2])

    # The yardstick must be the same integration.
    (steps, height), (bare_steps, bare_height) = map(steps_of, both(8.0).values())
    assert bare_steps == pytest.approx(steps, rel=0.05)
    assert bare_height == pytest.approx(height, abs=1e-8)

    # Between the ends: what a file costs that holds next to nothing is paid once.
    first, last = both(0.05), both(0.15)
    per_step = {}
    for name in first:
        work = [instructions(case[name], tmp_path, build_kind) for case in (first, last)]
        steps = [steps_of(case[name])[0] for case in (first, last)]
        per_step[name] = (work[1] - work[0]) / (steps[1] - steps[0])
    ratio = per_step["run"] / per_step["bare"]
    table("instructions of a step of the Tippe-Top", per_step | {"run over bare": ratio})
    assert ratio <= 1.4


def test_a_step_of_a_contact_that_remembers_moves_its_shells_few_times(
    count, executable, inputs, build_kind, tmp_path, table
):
    # In the right-hand side, for the state that is reached, and twice for the error of the memory;
    # a Jacobian, each tenth step, sixteen times. Steps that are tried and fail are steps, too: they
    # are so long that the method's own error bounds them. (16 with each done anew.)
    text = (inputs / "ellipsoid_egg.nml").read_text()
    text = text.replace("   friction =", "   tangential = 'elastic'\n   friction =")
    work, steps = [], []
    for t_end in (0.005, 0.01):
        scene = tmp_path / f"{t_end}.nml"
        scene.write_text(re.sub(r"t_end = \S+", f"t_end = {t_end}", text))
        run = [executable, "run", scene, "-o", tmp_path / "run.h5", "--force", "-q"]
        work.append(instructions(run, tmp_path, build_kind))
        with h5py.File(tmp_path / "run.h5") as file:
            counters = file["/integrator"]
            steps.append(int(counters["steps"][()] + counters["error_test_failures"][()]))
    per_step = (work[1] - work[0]) / (steps[1] - steps[0])
    derivative = count(text=text).instructions
    ratio = per_step / derivative
    table(
        "instructions of an egg with tangential elasticity",
        {"step": per_step, "right-hand side": derivative, "ratio": ratio, "steps": steps[1]},
    )
    assert ratio < 8.9
    # 3,200 where slip does not fade within a step of rolling and does not turn with the rates.
    assert steps[1] < 900


def first_touch(path, contact):
    """Time of the first touch of a contact, and the right-hand sides up to the end."""
    with h5py.File(path) as file:
        columns = ("time", "kind", "contact")
        time, kind, name = (file[f"/events/{column}"] for column in columns)
        rows = zip(time[()], kind.asstr()[()], name.asstr()[()], strict=True)
        touch = next(t for t, k, c in rows if k == "touch" and c == contact)
        return float(touch), int(file["/integrator/right_hand_sides"][()])


@pytest.mark.release_only("right-hand sides are the same in each build")
def test_explicit8_at_equal_error(executable, inputs, tmp_path, table):
    # A lightly damped top, which rings all the time, up to where its stem touches. At these
    # tolerances both methods have errors of about 5e-7 s.
    light = ("ball_floor.damping_coefficient=0.2", "stem_floor.damping_coefficient=0.2")
    scene = tmp_path / "scene.nml"
    text = (inputs / "tippe_top.nml").read_text().replace("t_end = 8.0", "t_end = 1.706")
    scene.write_text(text)
    found = {}
    for name, method, rtol in (
        ("reference", "explicit8", 1e-9),
        ("explicit8", "explicit8", 3e-7),
        ("cvode_bdf", "cvode_bdf", 1e-10),
    ):
        path = tmp_path / f"{name}.h5"
        sets = (*light, f"integrator.method={method}", f"integrator.rtol={rtol}")
        words = [word for text in sets for word in ("--set", text)]
        run_it([executable, "run", scene, "-o", path, "--force", "-q", *words], tmp_path)
        found[name] = first_touch(path, "stem_floor")
    reference = found.pop("reference")[0]
    errors = {name: abs(touch - reference) for name, (touch, _) in found.items()}
    figures = {f"error of {name} [s]": error for name, error in errors.items()}
    figures |= {f"right-hand sides of {name}": work for name, (_, work) in found.items()}
    table("Tippe-Top, light damping, to the first touch of the stem", figures)
    assert errors["explicit8"] <= 1e-6
    assert errors["explicit8"] <= errors["cvode_bdf"]
    # A step of twelve of them is as long as twelve of BDF, and needs no linear algebra.
    assert found["explicit8"][1] <= 1.1 * found["cvode_bdf"][1]


# Simulated time [s], and by how much the analytic Jacobian reduces the right-hand sides at least,
# against differences and against those each 51 steps. A single body that slides takes little more
# than one right-hand side a step, which no Jacobian saves: CVODE's rare differences cost it little.
JACOBIAN_SCENES = {
    "bearing_6205": (2e-3, 4.0, 3.0),
    "bearing_paper": (2e-2, 4.0, 3.0),
    "rattleback": (0.3, 2.0, 1.6),
    "sliding_ball": (None, 2.0, 1.6),
    "sliding_disc": (None, 2.0, 1.5),
    "spinning_ball": (None, 2.0, 1.0),
    "bouncing_ball": (None, 2.0, 1.4),
    "bowling": (None, 2.0, 1.1),
    "ellipsoid_egg": (2.0, 2.0, 1.1),
    "tippe_top": (0.5, 2.0, 1.1),
    "tippe_top_pade11": (0.5, 2.0, 1.1),
    "tippe_top_pade22": (0.5, 2.0, 1.1),
    "tippe_top_simplified": (0.5, 2.0, 1.1),
    "tippe_top_rigid": (None, 2.0, 1.5),
}


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", JACOBIAN_SCENES)
def test_the_analytic_jacobian_saves_right_hand_sides(executable, inputs, tmp_path, table, name):
    t_end, *bars = JACOBIAN_SCENES[name]
    kinds = {
        "analytic": ["--set", "integrator.jacobian=analytic"],
        "differences": ["--set", "integrator.jacobian=differences"],
        "rare": ["--set", "integrator.jacobian=differences"],
    }
    kinds["rare"] += ["--set", "integrator.jacobian_steps=51"]
    work, position = {}, {}
    for kind, settings in kinds.items():
        words = [executable, "run", inputs / f"{name}.nml", "-o", tmp_path / f"{kind}.h5", "-q"]
        words += ["--set", "integrator.method=cvode_bdf", *settings]
        if t_end:
            words += ["--set", f"scene.t_end={t_end}"]
        run_it(words, tmp_path)
        with h5py.File(tmp_path / f"{kind}.h5") as file:
            work[kind] = int(file["/integrator/right_hand_sides"][()])
            position[kind] = file["/summary/position"][()]
    ratios = {f"{kind} / analytic": work[kind] / work["analytic"] for kind in kinds}
    table(f"right-hand sides of cvode_bdf, {name}", work | ratios)
    for kind, bar in zip(("differences", "rare"), bars, strict=True):
        assert position["analytic"] == pytest.approx(position[kind], abs=2e-5)
        assert work[kind] >= bar * work["analytic"], kind


def test_the_freshness_of_the_jacobian_can_be_chosen(executable, inputs, tmp_path):
    jacobians, derivatives = [], []
    for steps in (1, 10, 51, 1000):
        words = [executable, "run", inputs / "tippe_top.nml", "-o", tmp_path / f"{steps}.h5", "-q"]
        words += ["--set", "scene.t_end=0.2", "--set", f"integrator.jacobian_steps={steps}"]
        run_it(words, tmp_path)
        with h5py.File(tmp_path / f"{steps}.h5") as file:
            jacobians.append(int(file["/integrator/jacobians"][()]))
            derivatives.append(int(file["/integrator/right_hand_sides"][()]))
    assert all(fresh > 1.3 * stale for fresh, stale in itertools.pairwise(jacobians)), jacobians
    assert jacobians[-1] >= 1
    # After each factorization the rate of convergence is learnt anew.
    assert derivatives[0] < 1.6 * min(derivatives)
    assert max(derivatives[1:]) < 1.3 * min(derivatives)


def test_a_ball_costs_the_same_among_many(count, inputs, table):
    # Pitch circle, loads and mass in proportion, so that the balls carry the same.
    plain = (inputs / "bearing_6205.nml").read_text()
    costs = {}
    for balls in (9, 30, 90):
        ratio = balls / 9
        text = plain.replace("ball_count = 9", f"ball_count = {balls}")
        for key, value in (
            ("pitch_diameter", 39.04e-3 * ratio),
            ("inner_speed", 188.5 / ratio),
            ("axial_load", 300.0 * ratio),
            ("radial_load", 500.0 * ratio),
            ("ring_mass", 0.5 * ratio),
        ):
            text, found = re.subn(rf"(?m)^   {key} = \S+", f"   {key} = {value!r}", text)
            assert found == 1, key
        costs[balls] = count(text=text, evaluations=20).instructions / balls
    table("instructions per right-hand side and ball", {str(n): c for n, c in costs.items()})
    assert costs[30] == pytest.approx(costs[9], rel=0.05)
    assert costs[90] == pytest.approx(costs[9], rel=0.05)
