"""FMUs of scenes, validated and simulated by FMPy."""

from __future__ import annotations

import ctypes
import json
import re
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from programs import captured

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
from fmpy import validation  # noqa: E402
from fmpy.fmi1 import FMICallException  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
SCENES = sorted(path for path in (ROOT / "inputs").rglob("*.nml") if "sweeps" not in path.parts)
VERSIONS = ["2", "3"]


@pytest.fixture
def unit(run, tmp_path, sanitized):
    """Write the FMU of a scene."""
    if sanitized:
        pytest.skip("the sanitizers are not in FMPy's process")

    def write(scene, version, *options, name="unit.fmu"):
        result = run("fmu", scene, "-o", name, "--fmi", version, "--force", *options)
        assert (result.status, result.err) == (0, "")
        return tmp_path / name

    return write


@pytest.fixture
def instantiate(unit, tmp_path):
    """Instances of an FMU for co-simulation, as FMPy has them, at their beginning."""
    opened = []

    def make(scene, version, parameters=(), count=1, early=False, options=()):
        path = unit(scene, version, *options)
        description = fmpy.read_model_description(path)
        references = {v.name: v.valueReference for v in description.modelVariables}
        folder = tmp_path / "unpacked"
        if not folder.exists():
            fmpy.extract(path, folder)
        instances = []
        for i in range(count):
            arguments = {
                "guid": description.guid,
                "modelIdentifier": description.coSimulation.modelIdentifier,
                "unzipDirectory": str(folder),
                "instanceName": f"one of {i}",
            }
            instance = (fmpy.fmi2.FMU2Slave if version == "2" else fmpy.fmi3.FMU3Slave)(**arguments)
            if version == "2":
                instance.instantiate()
                instance.setupExperiment(startTime=0.0)
                put = instance.setReal
            else:
                instance.instantiate(earlyReturnAllowed=early, eventModeUsed=early)
                put = instance.setFloat64
            for name, value in parameters:
                put([references[name]], [value])
            instance.enterInitializationMode()
            instance.exitInitializationMode()
            if early:
                instance.enterStepMode()
            instances.append(instance)
        opened.extend(instances)
        return instances, references

    yield make
    for instance in opened:
        instance.freeInstance()


def values_of(instance, references, *names):
    """Numbers of an instance."""
    get = getattr(instance, "getFloat64", None) or instance.getReal
    return np.array(get([references[name] for name in names]))


PLACE = ("top.position.x", "top.position.y", "top.position.z", "ball_floor.normal_force")


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("scene", SCENES, ids=lambda path: path.stem)
def test_description_and_bits(unit, run, tmp_path, scene, version):
    """The description is in order; co-simulation has the bits of a run."""
    end = float(re.search(r"t_end *= *([0-9.e-]+)", scene.read_text())[1])
    end = min(end, 2e-3 if scene.stem == "bearing_pair" else 0.05)
    settings = ["--set", f"scene.t_end = {end}", "--set", f"output.interval = {end / 20}"]
    path = unit(scene, version, *settings)
    assert validation.validate_fmu(str(path)) == []
    assert run("run", scene, "-q", "-o", "run.h5", *settings).status == 0
    with h5py.File(tmp_path / "run.h5") as file:
        times = file["trajectory/time"][()]
        body = file["body/name"][0].decode()
        position = file["trajectory/position"][:, 0]
        energy = file["trajectory/energy_kinetic"][()]
    names = [f"{body}.position.{axis}" for axis in "xyz"] + ["energy_kinetic"]
    result = fmpy.simulate_fmu(
        str(path), fmi_type="CoSimulation", stop_time=end, output_interval=end / 20, output=names
    )
    assert len(result) == len(times) == 21
    # The host's times differ from those of the rows by rounding, where they do.
    same = result["time"] == times
    assert same.sum() >= 5
    for name, written in zip(names, [*position.T, energy], strict=True):
        assert result[name][same].tobytes() == written[same].tobytes(), name
        np.testing.assert_allclose(result[name], written, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", ["tippe_top", "bouncing_ball", "sliding_ball", "tippe_top_rigid"])
def test_model_exchange(unit, run, tmp_path, inputs, name, version):
    """With FMPy's CVODE the motion is that of a run, within what its tolerance admits."""
    end = {"bouncing_ball": 0.6}.get(name, 0.2)
    settings = ["--set", f"scene.t_end = {end}", "--set", f"output.interval = {end / 20}"]
    scene = inputs / f"{name}.nml"
    path = unit(scene, version, *settings)
    assert run("run", scene, "-q", "-o", "run.h5", *settings).status == 0
    with h5py.File(tmp_path / "run.h5") as file:
        body = file["body/name"][0].decode()
        position = file["trajectory/position"][:, 0]
    names = [f"{body}.position.{axis}" for axis in "xyz"] + ["energy_error", "energy_kinetic"]
    result = fmpy.simulate_fmu(
        str(path),
        fmi_type="ModelExchange",
        stop_time=end,
        output_interval=end / 400,
        relative_tolerance=1e-10,
        output=names,
    )
    rows = result[np.searchsorted(result["time"], np.linspace(0, end, 21) - 1e-12)]
    for axis, written in zip(names[:3], position.T, strict=True):
        assert np.abs(rows[axis] - written).max() < 1e-6
    assert np.abs(result["energy_error"]).max() < 1e-5 * np.abs(result["energy_kinetic"]).max()


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("scene", SCENES, ids=lambda path: path.stem)
def test_model_exchange_of_every_scene(unit, run, tmp_path, scene, version):
    """All bodies move and turn with FMPy's CVODE as in a run, at 20 outputs, within its tolerance.

    With tangential elasticity the spins of the run itself are uncertain by 2.3e-4.
    """
    end = 1e-3 if scene.stem.startswith("bearing") else 0.02
    end = {"oblique_impact": 3e-5, "bearing_pair": 2e-4}.get(scene.stem, end)
    remembers = "tangential = 'elastic'" in scene.read_text()
    settings = ["--set", f"scene.t_end = {end}", "--set", f"output.interval = {end / 20}"]
    path = unit(scene, version, *settings)
    assert run("run", scene, "-q", "-o", "run.h5", *settings).status == 0
    with h5py.File(tmp_path / "run.h5") as file:
        bodies = [name.decode() for name in file["body/name"]]
        position = file["trajectory/position"][()].reshape(21, -1)
        spin = file["trajectory/angular_velocity"][()].reshape(21, -1)
    result = fmpy.simulate_fmu(
        str(path),
        fmi_type="ModelExchange",
        stop_time=end,
        output_interval=end / 20,
        relative_tolerance=1e-9,
        output=[
            f"{body}.{kind}.{axis}"
            for kind in ("position", "angular_velocity")
            for body in bodies
            for axis in "xyz"
        ],
    )
    # With a row before and one after each event.
    rows = result[np.searchsorted(result["time"], np.linspace(0, end, 21) - 1e-12)]
    found = np.array([rows[name] for name in rows.dtype.names[1:]]).T
    count = position.shape[1]
    np.testing.assert_allclose(found[:, :count], position, rtol=0, atol=1e-8)
    limit = (3e-4 if remembers else 3e-6) * max(1.0, np.abs(spin).max())
    np.testing.assert_allclose(found[:, count:], spin, rtol=0, atol=limit)


@pytest.mark.parametrize("version", VERSIONS)
def test_events_of_memory(unit, inputs, version):
    """Contacts that remember have the host end its steps, and none where nothing is remembered."""
    descriptions = {
        name: fmpy.read_model_description(unit(inputs / name, version))
        for name in ("tippe_top.nml", "examples/incline.nml")
    }
    has = {name: {v.name for v in found.modelVariables} for name, found in descriptions.items()}
    assert "memory_indicator" in has["examples/incline.nml"]
    assert "memory_indicator" not in has["tippe_top.nml"]
    assert [d.numberOfEventIndicators for d in descriptions.values()] == [
        sum(name.endswith("indicator") for name in names) for names in has.values()
    ]
    result = fmpy.simulate_fmu(
        str(unit(inputs / "examples/incline.nml", version)),
        fmi_type="ModelExchange",
        stop_time=2e-3,
        output_interval=1e-3,
        relative_tolerance=1e-9,
        output=["memory_indicator"],
    )
    indicator = result["memory_indicator"]
    assert len(indicator) > 30
    assert indicator.max() < 1e-6  # to the accuracy with which CVODE finds its zeros
    assert np.all(indicator[1:][np.diff(result["time"]) == 0.0] == -1.0)


@pytest.mark.parametrize("version", VERSIONS)
def test_rigid_top_stays_on_its_floor(unit, inputs, version):
    """Also where its stem touches: what has just opened closes again where it comes lower."""
    result = fmpy.simulate_fmu(
        str(unit(inputs / "tippe_top_rigid.nml", version)),
        fmi_type="ModelExchange",
        stop_time=8.0,
        output_interval=0.016,
        relative_tolerance=1e-8,
        output=["ball_floor.gap", "stem_floor.gap", "energy_error", "top.position.z"],
    )
    assert result["stem_floor.gap"].min() < 1e-9
    assert min(result["ball_floor.gap"].min(), result["stem_floor.gap"].min()) > -1e-6
    assert np.abs(result["energy_error"]).max() < 1e-6


@pytest.mark.parametrize("version", VERSIONS)
def test_states_are_kept_in_mid_contact(instantiate, inputs, version):
    """What follows from a state that is set again has the same bits; others do not see it."""
    (one, two), references = instantiate(inputs / "tippe_top.nml", version, count=2)
    get = getattr(one, "getFMUState", None) or one.getFMUstate
    put = getattr(one, "setFMUState", None) or one.setFMUstate
    drop = getattr(one, "freeFMUState", None) or one.freeFMUstate

    def go(instance, begin, steps):
        for i in range(steps):
            instance.doStep(begin + i * 1e-3, 1e-3)
        return values_of(instance, references, *PLACE)

    go(one, 0.0, 30)
    state = get()
    assert values_of(one, references, "ball_floor.gap")[0] < 0.0
    first = go(one, 0.03, 30)
    beside = go(two, 0.0, 60)
    put(state)
    assert np.array_equal(go(one, 0.03, 30), first)
    drop(state)
    np.testing.assert_allclose(beside, first, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("version", VERSIONS)
def test_states_as_bytes(instantiate, inputs, version):
    """Another instance goes on from them with the same bits, with the parameters of the first."""
    parameters = [("top.spin(3)", 170.0), ("ball_floor.friction_coefficient", 0.25)]
    (one,), references = instantiate(inputs / "tippe_top.nml", version, parameters)
    one.doStep(0.0, 0.03)
    state = one.getFMUState()
    data = one.serializeFMUState(state)
    one.freeFMUState(state)
    one.doStep(0.03, 0.02)
    (two,), _ = instantiate(inputs / "tippe_top.nml", version, [("top.spin(3)", 100.0)])
    two.doStep(0.0, 0.01)
    state = two.deserializeFMUState(data)
    two.setFMUState(state)
    assert values_of(two, references, "top.spin(3)")[0] == 170.0
    two.doStep(0.03, 0.02)
    assert np.array_equal(values_of(one, references, *PLACE), values_of(two, references, *PLACE))
    for wrong in (data[:-1], data + b"x", data[:50], b"", data[:100] + b"\xff" * 200 + data[300:]):
        with pytest.raises(FMICallException):
            two.setFMUState(two.deserializeFMUState(wrong))
    two.freeFMUState(state)


def test_parameters_that_change_counts_are_none(unit, inputs):
    """Keys that change how many bodies there are belong to the writing of an FMU."""
    names = {}
    for balls in (8, 9):
        path = unit(inputs / "bearing_paper.nml", "3", "--set", f"bearing.ball_count = {balls}")
        names[balls] = {v.name for v in fmpy.read_model_description(path).modelVariables}
    assert not any(name.endswith("ball_count") for name in names[8])
    more = {name for name in names[9] - names[8] if not re.match(r"state\[|der\(", name)}
    assert more
    assert all("_9" in name for name in more)


@pytest.mark.parametrize("version", VERSIONS)
def test_parameters_and_inputs(instantiate, inputs, version):
    """A parameter is that of the scene; a force moves the body."""
    (one,), references = instantiate(
        inputs / "tippe_top.nml", version, [("top.spin(3)", 0.0), ("scene.gravity(3)", 0.0)]
    )
    put = getattr(one, "setFloat64", None) or one.setReal
    put([references["top.force.z"]], [6e-3])
    before = values_of(one, references, "top.position.z")[0]
    one.doStep(0.0, 0.1)
    moved = values_of(one, references, "top.position.z", "top.angular_velocity.z", "work_applied")
    assert moved[0] - before == pytest.approx(0.5 * 1.0 * 0.1**2, rel=1e-6)
    assert moved[1] == 0.0
    assert moved[2] == pytest.approx(6e-3 * (moved[0] - before), rel=1e-6)


def test_early_return(instantiate, inputs):
    """A step ends at a touch."""
    (ball,), references = instantiate(inputs / "bouncing_ball.nml", "3", early=True)
    needed, _, early, last = ball.doStep(0.0, 1.9)
    assert needed
    assert early
    assert 0.0 < last < 1.9
    (gap,) = (name for name in references if name.endswith(".gap"))
    assert abs(values_of(ball, references, gap)[0]) < 1e-9


def test_instances_leave_nothing(executable, inputs, tmp_path, sanitized, slow_build):
    """Memory does not grow with the instances that there were; the sanitizers find no leak."""
    shutil.copy(inputs / "tippe_top.nml", tmp_path / "scene.nml")
    program = executable.parents[1] / "tests/capi/fmu_instances"
    number = 100 if slow_build else 1000
    done = captured([program, tmp_path, str(number)], timeout=600)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    count, grown = map(
        int, re.fullmatch(r"(\d+) instances, .* (-?\d+) KiB\n", done.stdout).groups()
    )
    assert count == number
    assert grown < 1024 or sanitized


def refused(call, *words):
    """Whether an instance refuses a call."""
    with pytest.raises(FMICallException):
        call(*words)


def named(instance, name, version):
    """A function of FMI as FMPy gives it."""
    return getattr(instance, f"fmi{version}{name}")


@pytest.mark.parametrize("version", VERSIONS)
def test_wrong_use_is_refused(instantiate, inputs, version):
    """Each mistake is an error with a message, and the instance goes on as one without them."""
    (one, two), references = instantiate(inputs / "tippe_top.nml", version, count=2)
    put = getattr(one, "setFloat64", None) or one.setReal
    get = getattr(one, "getFloat64", None) or one.getReal
    nobody = 10_000_000
    one.doStep(0.0, 0.01)
    two.doStep(0.0, 0.01)
    for call, *words in (
        (get, [nobody]),
        (get, [references["time"], 0xFFFFFFFF]),
        (put, [nobody], [1.0]),
        (put, [references["top.mass"]], [np.nan]),
        (put, [references["top.mass"]], [1.0]),
        (put, [references["top.force.z"]], [np.inf]),
        (put, [references["top.position.z"]], [1.0]),
        (put, [references["time"]], [1.0]),
        (one.doStep, 0.01, np.nan),
        (one.doStep, 0.01, np.inf),
        (one.doStep, 0.0, 0.001),
        (one.deserializeFMUState, b""),
        (one.deserializeFMUState, b"garbage" * 1000),
        (one.getDirectionalDerivative, [references["energy_kinetic"]], [references["time"]], [1.0]),
    ):
        refused(call, *words)
    two.freeFMUState(two.getFMUState())  # which ends the step under way
    state = one.getFMUState()
    kept = ctypes.c_void_p(state.value)
    size = ctypes.c_size_t()
    bytes_of = "SerializeFMUState" if version == "3" else "SerializeFMUstate"
    size_of = "SerializedFMUStateSize" if version == "3" else "SerializedFMUstateSize"
    named(one, size_of, version)(one.component, state, ctypes.byref(size))
    small = ctypes.create_string_buffer(size.value - 1)
    kind = ctypes.POINTER(ctypes.c_ubyte) if version == "3" else ctypes.c_char_p
    write = named(one, bytes_of, version)
    refused(write, one.component, state, ctypes.cast(small, kind), len(small))
    one.freeFMUState(state)
    assert not state.value
    for gone in (state, kept, ctypes.c_void_p(12345)):
        refused(one.setFMUState, gone)
        refused(one.serializeFMUState, gone)
        one.freeFMUState(gone)
    one.terminate()
    one.terminate()
    for instance in (one, two):
        instance.doStep(0.01, 0.01)
    assert (
        values_of(one, references, *PLACE).tolist() == values_of(two, references, *PLACE).tolist()
    )


@pytest.mark.parametrize("version", VERSIONS)
def test_use_after_release(instantiate, inputs, version):
    """An instance that was released, also twice, refuses all; another one does not mind."""
    (one, two), references = instantiate(inputs / "tippe_top.nml", version, count=2)
    state = one.getFMUState()
    release = named(one, "FreeInstance", version)
    component = one.component
    release(component)
    release(component)
    for call, *words in (
        (one.doStep, 0.0, 0.01),
        (one.getFMUState,),
        (one.setFMUState, state),
        (one.reset,),
        (one.terminate,),
        (lambda: values_of(one, references, "time"),),
    ):
        refused(call, *words)
    for wrong in (None, 12345, 1 << 40):
        one.component = wrong
        refused(one.doStep, 0.0, 0.01)
        release(wrong)
    one.component = component
    # What was kept of it is a state of the other one, too.
    two.setFMUState(state)
    two.freeFMUState(state)
    two.doStep(0.0, 0.01)


@pytest.mark.parametrize("version", VERSIONS)
def test_arguments_that_are_null(unit, inputs, tmp_path, version):
    """Each function of the binary answers an instance that is none, and each argument that is NULL,
    by an error; names of variables are told in messages."""
    path = unit(inputs / "tippe_top.nml", version)
    fmpy.extract(path, tmp_path / "unpacked")
    (library,) = (tmp_path / "unpacked/binaries").rglob("*.so")
    program = NULLS.format(version=version, library=str(library), folder=str(tmp_path / "unpacked"))
    done = captured([sys.executable, "-c", program])
    assert (done.returncode, done.stderr) == (0, "")
    tried = int(done.stdout)
    assert tried > (60 if version == "3" else 35)


# Calls all functions of a binary with nothing but NULL and numbers, without and with an instance.
NULLS = """
import ctypes, re, subprocess
version, file, folder = {version}, {library!r}, {folder!r}
library = ctypes.CDLL(file)
listed = subprocess.run(["nm", "-D", "--defined-only", file], capture_output=True, text=True)
names = re.findall(rf" T (fmi{{version}}\\w+)", listed.stdout)
Pointer, Size = ctypes.c_void_p, ctypes.c_size_t
if version == 3:
    make = library.fmi3InstantiateCoSimulation
    make.restype = Pointer
    make.argtypes = [ctypes.c_char_p] * 3 + [ctypes.c_bool] * 4 + [Pointer, Size] + [Pointer] * 3
    assert make(None, None, None, 0, 0, 0, 0, None, 0, None, None, None) is None
    assert make(None, None, b"/nowhere", 0, 0, 0, 0, None, 0, None, None, None) is None
    one = make(None, None, f"{{folder}}/resources/".encode(), 0, 0, 0, 0, None, 0, None, None, None)
else:
    make = library.fmi2Instantiate
    make.restype = Pointer
    make.argtypes = [ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, Pointer,
                     ctypes.c_int, ctypes.c_int]
    for place in (None, b"", b"file:///nowhere", b"file://nowhere", b"file:%", b"%%%1"):
        assert make(None, 1, None, place, None, 0, 0) is None
    one = make(None, 1, None, f"file://{{folder}}/resources".encode(), None, 0, 0)
assert one
tried = 0
for name in names:
    if "Instantiate" in name or name.endswith(("GetVersion", "GetTypesPlatform")):
        continue
    function = getattr(library, name)
    if name.endswith("FreeInstance"):
        function.argtypes = [Pointer]
        function(None)
        continue
    for component in (None, Pointer(77), Pointer(one)):
        answers = [function(component, *[None] * 8)]
        if re.match(r"fmi\\d(Get|Set|Serialize|De[sS]erialize)(?!.*Status)", name):
            answers.append(function(component, None, Size(3), None, Size(3), None, Size(3)))
        tried += 1
        if component is None or component.value == 77:
            assert set(answers) == {{3}}, (name, answers)
        elif len(answers) > 1 and not name.endswith(("SetTime", "SetDebugLogging")):
            assert answers[1] == 3, (name, answers)
free = getattr(library, f"fmi{{version}}FreeInstance")
free.argtypes = [Pointer]
free(one)
free(one)
print(tried)
"""


@pytest.mark.parametrize("version", VERSIONS)
def test_wrong_use_of_model_exchange(unit, inputs, tmp_path, version):
    """States of the wrong length and times that are none are refused."""
    path = unit(inputs / "tippe_top.nml", version)
    description = fmpy.read_model_description(path)
    assert not description.modelExchange.providesDirectionalDerivative
    assert not description.coSimulation.providesDirectionalDerivative
    folder = tmp_path / "unpacked"
    fmpy.extract(path, folder)
    one = (fmpy.fmi2.FMU2Model if version == "2" else fmpy.fmi3.FMU3Model)(
        guid=description.guid,
        modelIdentifier=description.modelExchange.modelIdentifier,
        unzipDirectory=str(folder),
        instanceName="one",
    )
    one.instantiate()
    if version == "2":
        one.setupExperiment(startTime=0.0)
    one.enterInitializationMode()
    one.exitInitializationMode()
    n = description.numberOfContinuousStates
    state = (ctypes.c_double * (n + 1))()
    place = ctypes.cast(state, ctypes.POINTER(ctypes.c_double))
    indicators = description.numberOfEventIndicators
    rates = "GetContinuousStateDerivatives" if version == "3" else "GetDerivatives"
    for name, right in (
        ("GetContinuousStates", n),
        (rates, n),
        ("SetContinuousStates", n),
        ("GetNominalsOfContinuousStates", n),
        ("GetEventIndicators", indicators),
    ):
        for count in (0, right - 1, right + 1, 1 << 60):
            refused(named(one, name, version), one.component, place, count)
        named(one, name, version)(one.component, place, right)
    refused(one.setTime, np.nan)
    refused(one.setTime, np.inf)
    one.freeInstance()


def test_copies_of_headers_are_not_compiled(executable):
    """What is beside the binaries is for FMUs: a header that is changed may not be there yet."""
    commands = json.loads((executable.parents[1] / "compile_commands.json").read_text())
    of_units = [one["command"] for one in commands if "contensou_fmu" in one["output"]]
    assert len(of_units) >= 10
    assert not any(re.search(r" -Ifmu ", command) for command in of_units)


ELEMENT = ("--contact", "ball_floor")


def poses_of(references, state):
    """References and values of the inputs of a contact alone."""
    names = [
        f"top.{quantity}.{axis}"
        for quantity, axes in (
            ("position", "xyz"),
            ("quaternion", "wxyz"),
            ("velocity", "xyz"),
            ("angular_velocity", "xyz"),
        )
        for axis in axes
    ]
    return [references[name] for name in names], list(state)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_contact_alone(instantiate, unit, run, inputs, tmp_path, version):
    """Poses and velocities in, forces and torques out: those of a run at the same states."""
    assert validation.validate_fmu(str(unit(inputs / "tippe_top.nml", version, *ELEMENT))) == []
    (one,), references = instantiate(inputs / "tippe_top.nml", version, options=ELEMENT)
    put = getattr(one, "setFloat64", None) or one.setReal
    settings = ("--set", "scene.t_end = 0.02", "--set", "output.interval = 1e-3")
    assert run("run", inputs / "tippe_top.nml", "-q", "-o", "run.h5", *settings).status == 0
    axes = [f"{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"]
    with h5py.File(tmp_path / "run.h5") as file:
        rows = {name: data[()] for name, data in file["trajectory"].items()}
    for i in range(21):
        state = [
            *rows["position"][i, 0],
            *rows["quaternion"][i, 0],
            *rows["velocity"][i, 0],
            *rows["angular_velocity"][i, 0],
        ]
        put(*poses_of(references, state))
        one.doStep(i * 1e-3, 1e-3)
        normal = rows["contact_normal"][i, 0]
        on_b = rows["normal_force"][i, 0] * normal + rows["friction_force"][i, 0]
        arm = rows["contact_point"][i, 0] - rows["position"][i, 0]
        twist = -rows["friction_torque"][i, 0] * normal
        wrench = values_of(one, references, *(f"top.{name}" for name in axes))
        np.testing.assert_allclose(wrench[:3], -on_b, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(wrench[3:], np.cross(arm, -on_b) + twist, rtol=1e-9, atol=1e-14)
        on_ground = values_of(one, references, *(f"ground.{name}" for name in axes))
        np.testing.assert_array_equal(on_ground[:3], -wrench[:3])
        about = np.cross(rows["position"][i, 0], wrench[:3])
        np.testing.assert_allclose(on_ground[3:], -wrench[3:] - about, rtol=1e-9, atol=1e-14)
        gap, force = values_of(one, references, "ball_floor.gap", "ball_floor.normal_force")
        assert gap == rows["gap"][i, 0]
        assert force == pytest.approx(rows["normal_force"][i, 0], rel=1e-12)
    assert "stem_floor.gap" not in references
    assert "state[1]" not in references


def test_a_contact_alone_moves_a_body_of_the_host(instantiate, run, inputs, tmp_path):
    """A host with a rigid body of its own, moved by the force element, moves as the scene does."""
    scene = inputs / "tippe_top.nml"
    (one,), references = instantiate(scene, "3", options=ELEMENT)
    end, mass, inertia = 0.01, 6e-3, np.array([8e-7, 8e-7, 7e-7])
    settings = ("--set", f"scene.t_end = {end}", "--set", "integrator.rtol = 1e-10")
    assert run("run", scene, "-q", "-o", "run.h5", *settings).status == 0
    with h5py.File(tmp_path / "run.h5") as file:
        first, last = (
            np.concatenate(
                [
                    file[f"trajectory/{name}"][row, 0]
                    for name in ("position", "quaternion", "velocity", "angular_velocity")
                ]
            )
            for row in (0, -1)
        )
    outputs = [references[f"top.{kind}.{axis}"] for kind in ("force", "torque") for axis in "xyz"]

    def turned(q, vector):
        """A vector of the body in the inertial frame."""
        cross = np.cross(q[1:4], vector)
        return vector + 2 * (q[0] * cross + np.cross(q[1:4], cross))

    def rates(state):
        """The state has the angular velocity in the axes of the body."""
        q, spin = state[3:7], state[10:]
        one.setFloat64(*poses_of(references, [*state[:10], *turned(q, spin)]))
        wrench = np.array(one.getFloat64(outputs))
        acceleration = wrench[:3] / mass + [0, 0, -9.81]
        torque = turned(q * [1, -1, -1, -1], wrench[3:])
        angular = (torque - np.cross(spin, inertia * spin)) / inertia
        rate = 0.5 * np.concatenate([[-q[1:] @ spin], q[0] * spin + np.cross(q[1:], spin)])
        return np.concatenate([state[7:10], rate, acceleration, angular])

    state, steps = first.copy(), 4000
    state[10:] = turned(state[3:7] * [1, -1, -1, -1], state[10:])
    h = end / steps
    for _ in range(steps):
        k1 = rates(state)
        k2 = rates(state + h / 2 * k1)
        k3 = rates(state + h / 2 * k2)
        k4 = rates(state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        state[3:7] /= np.linalg.norm(state[3:7])
    np.testing.assert_allclose(state[:3], last[:3], rtol=0, atol=1e-9)
    np.testing.assert_allclose(state[3:7], last[3:7], rtol=0, atol=1e-6)
    spin = turned(state[3:7], state[10:])
    np.testing.assert_allclose(spin, last[10:], rtol=0, atol=2e-4)


def test_contacts_that_are_no_force_elements(run, inputs, tmp_path):
    """Those that are not there, are rigid or remember are refused, and nothing is written."""
    examples = inputs / "examples"
    for scene, contact, message in (
        (inputs / "tippe_top.nml", "floor", "expected one of: 'ball_floor', 'stem_floor'"),
        (inputs / "tippe_top_rigid.nml", "ball_floor", "rigid"),
        (examples / "oblique_impact.nml", None, "history"),
    ):
        if contact is None:
            contact = re.search(r"&contact\s+name *= *'(\w+)'", scene.read_text())[1]
        result = run("fmu", scene, "--contact", contact, "-o", "none.fmu")
        assert result.status == 2
        assert message in result.err
        assert not (tmp_path / "none.fmu").exists()


PAGE = (ROOT / "docs" / "fmu.md").read_text(encoding="utf-8")
SCRIPTS = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("script", SCRIPTS, ids=["co-simulation", "model exchange"])
def test_scripts_of_the_page(unit, run, inputs, tmp_path, script, version):
    """They end where a run does."""
    scene = inputs / "tippe_top.nml"
    unit(scene, version, name="tippe_top.fmu")
    (tmp_path / "script.py").write_text(script)
    done = captured([sys.executable, "script.py"], cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    spin = ["--set", "top.spin(3) = 200"] if "start_values" in script else []
    settings = [*spin, "--set", "scene.t_end = 0.1", "--set", "output.interval = 1e-2"]
    assert run("run", scene, "-q", "-o", "run.h5", *settings).status == 0
    with h5py.File(tmp_path / "run.h5") as file:
        heights = file["trajectory/position"][:, 0, 2]
        forces = file["trajectory/normal_force"][:, 0]
    if spin:
        rows = [line.split() for line in done.stdout.splitlines()]
        assert [row[1] for row in rows] == [f"{height:.6f}" for height in heights]
        assert [row[2] for row in rows] == [f"{force:.4f}" for force in forces]
    else:
        assert done.stdout.endswith(f" rows, {heights[-1]:.6f} m\n")


def test_modelica_model_of_the_page(unit, inputs):
    """The names in the model are those of the FMU, with the causality that it gives them."""
    (model,) = re.findall(r"^```modelica\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    names = re.findall(r"'([^']*)'", model)
    variables = {
        variable.name: variable
        for variable in fmpy.read_model_description(
            unit(inputs / "tippe_top.nml", "2")
        ).modelVariables
    }
    assert [variables[name].causality for name in names] == ["parameter", "input"]
    # What may stand between quotes in Modelica.
    assert all(re.fullmatch(r"[\w !#$%&()*+,\-./:;<=>?@\[\]^{|}~]+", name) for name in variables)


def test_mistakes(run, scene):
    """The command tells of them, and leaves nothing."""
    result = run("fmu", scene.name, "--set", "top.mass = -1")
    assert result.status == 2
    assert "expected" in result.err
    assert run("fmu", scene.name).status == 0
    again = run("fmu", scene.name)
    assert again.status == 74
    assert "exists" in again.err
