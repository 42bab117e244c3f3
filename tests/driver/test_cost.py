"""What a run pays for: instructions of the right-hand side, and CPU beside bare CVODE.

Instructions are counted by valgrind's callgrind, so that the load of the machine does not matter.
It collects inside the right-hand side alone, with all that is called from there.
"""

from __future__ import annotations

import itertools
import os
import re
import shutil
import subprocess
from collections import Counter
from dataclasses import dataclass

import h5py
import pytest
from programs import captured

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


def test_gravity_that_is_not_named_saves_its_instructions(count, build_kind, table):
    named = count()
    absent = count(gravity="")
    table(
        "instructions per right-hand side, gravity",
        {"named": named.instructions, "not named": absent.instructions},
    )
    assert build_kind == "checked" or absent.instructions < named.instructions


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


def cpu_of(command, folder):
    """Run a command; its CPU seconds (user and system) and its standard output."""
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
    out = process.stdout.read()
    process.stdout.close()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    return usage.ru_utime + usage.ru_stime, out


def test_a_run_costs_little_more_than_bare_cvode(executable, build_kind, inputs, tmp_path, table):
    # Alternating runs share the machine's moods, and the smallest time of each is the one that
    # was disturbed least; more pairs are taken only while the answer is in doubt.
    scene = inputs / "tippe_top.nml"
    commands = {
        "run": [executable, "run", scene, "-o", tmp_path / "run.h5", "--force", "-q"],
        "bare": [program(executable, "bare_cvode"), scene],
    }
    limit = 1.5
    pairs, most = (5, 25) if build_kind == "release" else (1, 1)
    seconds = dict.fromkeys(commands, float("inf"))
    outputs = {}
    for pair in range(most):
        for name, command in commands.items():
            used, outputs[name] = cpu_of([str(word) for word in command], tmp_path)
            seconds[name] = min(seconds[name], used)
        if pair + 1 >= pairs and seconds["run"] <= limit * seconds["bare"]:
            break
    ratio = seconds["run"] / seconds["bare"]
    table("CPU of 8 s of the Tippe-Top [s]", seconds | {"run over bare": ratio})

    # The yardstick must be the same integration.
    with h5py.File(tmp_path / "run.h5") as file:
        assert len(file["/trajectory/time"]) == 8001
        steps = int(file["/integrator/steps"][()])
        height = float(file["/summary/position"][0, 2])
    bare_steps, bare_height = outputs["bare"].split()
    assert int(bare_steps) == pytest.approx(steps, rel=0.05)
    assert float(bare_height) == pytest.approx(height, abs=1e-8)
    if build_kind == "release":
        assert ratio <= limit


def first_touch(path, contact):
    """Time of the first touch of a contact, and the CPU seconds of the integration."""
    with h5py.File(path) as file:
        columns = ("time", "kind", "contact")
        time, kind, name = (file[f"/events/{column}"] for column in columns)
        rows = zip(time[()], kind.asstr()[()], name.asstr()[()], strict=True)
        touch = next(t for t, k, c in rows if k == "touch" and c == contact)
        return float(touch), float(file["/integrator/cpu_integration"][()])


def test_explicit8_at_equal_error(executable, build_kind, inputs, tmp_path, table):
    # A lightly damped top, which rings all the time, up to where its stem touches. At these
    # tolerances both methods have errors of about 5e-7 s.
    light = ("ball_floor.damping_coefficient=0.2", "stem_floor.damping_coefficient=0.2")
    scene = tmp_path / "scene.nml"
    text = (inputs / "tippe_top.nml").read_text().replace("t_end = 8.0", "t_end = 1.706")
    scene.write_text(text)

    def command(name, method, rtol):
        sets = (*light, f"integrator.method={method}", f"integrator.rtol={rtol}")
        words = [executable, "run", scene, "-o", tmp_path / f"{name}.h5", "--force", "-q"]
        return [str(word) for word in words] + [word for text in sets for word in ("--set", text)]

    cpu_of(command("reference", "explicit8", 1e-9), tmp_path)
    reference, _ = first_touch(tmp_path / "reference.h5", "stem_floor")
    bare_text = text.replace("damping_coefficient = 100.0", "damping_coefficient = 0.2")
    bare_text = bare_text.replace("'cvode_bdf', rtol = 1.0e-8", "'explicit8', rtol = 3.0e-7")
    assert bare_text.count("explicit8") == 1
    assert bare_text.count("damping_coefficient = 0.2") == 2
    (tmp_path / "bare.nml").write_text(bare_text)

    # What a file costs that holds next to nothing is not the method's.
    empty = [*command("empty", "explicit8", 3e-7), "--set", "scene.t_end=1e-9"]
    empty += ["--set", "output.interval=1e-9"]
    pairs, most = (3, 12) if build_kind == "release" else (1, 1)
    seconds = dict.fromkeys(("explicit8", "cvode_bdf", "bare", "empty"), float("inf"))
    errors = {}
    for pair in range(most):
        for name, rtol in (("explicit8", 3e-7), ("cvode_bdf", 1e-10)):
            cpu_of(command(name, name, rtol), tmp_path)
            touch, cpu = first_touch(tmp_path / f"{name}.h5", "stem_floor")
            errors[name] = abs(touch - reference)
            seconds[name] = min(seconds[name], cpu)
        out = cpu_of([str(program(executable, "bare_explicit8")), "bare.nml"], tmp_path)[1]
        seconds["bare"] = min(seconds["bare"], float(out.split()[2]))
        cpu_of(empty, tmp_path)
        with h5py.File(tmp_path / "empty.h5") as file:
            seconds["empty"] = min(seconds["empty"], float(file["/integrator/cpu_integration"][()]))
        own = seconds["explicit8"] - seconds["empty"]
        gain = (seconds["cvode_bdf"] - seconds["empty"]) / own
        loss = own / seconds["bare"]
        if pair + 1 >= pairs and gain >= 10.0 and loss <= 2.0:
            break
    figures = {f"error of {name} [s]": error for name, error in errors.items()}
    figures |= {f"CPU of {name} [s]": cpu for name, cpu in seconds.items()}
    table(
        "Tippe-Top, light damping, to the first touch of the stem",
        figures | {"gain": gain, "explicit8 over bare": loss},
    )
    assert errors["explicit8"] <= 1e-6
    assert errors["explicit8"] <= errors["cvode_bdf"]
    if build_kind == "release":
        assert gain >= 10.0
        assert loss <= 2.0


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
        cpu_of([str(word) for word in words], tmp_path)
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
        cpu_of([str(word) for word in words], tmp_path)
        with h5py.File(tmp_path / f"{steps}.h5") as file:
            jacobians.append(int(file["/integrator/jacobians"][()]))
            derivatives.append(int(file["/integrator/right_hand_sides"][()]))
    assert all(fresh > 1.3 * stale for fresh, stale in itertools.pairwise(jacobians)), jacobians
    assert jacobians[-1] >= 1
    # After each factorization the rate of convergence is learnt anew.
    assert derivatives[0] < 1.6 * min(derivatives)
    assert max(derivatives[1:]) < 1.3 * min(derivatives)
