"""FMUs of scenes, validated and simulated by FMPy."""

from __future__ import annotations

import re
import resource
import shutil
import subprocess
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
from fmpy import validation  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
SCENES = sorted((ROOT / "inputs").glob("*.nml"))
VERSIONS = ["2", "3"]


@pytest.fixture
def unit(run, tmp_path, sanitized):
    """Write the FMU of a scene."""
    if sanitized:
        pytest.skip("the sanitizers are not in FMPy's process")

    def write(scene, version, *options):
        result = run("fmu", scene, "-o", "unit.fmu", "--fmi", version, "--force", *options)
        assert (result.status, result.err) == (0, "")
        return tmp_path / "unit.fmu"

    return write


@pytest.fixture
def instantiate(unit, tmp_path):
    """Instances of an FMU for co-simulation, as FMPy has them, at their beginning."""
    opened = []

    def make(scene, version, parameters=(), count=1, early=False):
        path = unit(scene, version)
        description = fmpy.read_model_description(path)
        references = {v.name: v.valueReference for v in description.modelVariables}
        folder = tmp_path / "unpacked"
        if not folder.exists():
            fmpy.extract(path, folder)
        instances = []
        for i in range(count):
            options = {
                "guid": description.guid,
                "modelIdentifier": description.coSimulation.modelIdentifier,
                "unzipDirectory": str(folder),
                "instanceName": f"one of {i}",
            }
            instance = (fmpy.fmi2.FMU2Slave if version == "2" else fmpy.fmi3.FMU3Slave)(**options)
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
    end = min(end, 0.05)
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


@pytest.mark.parametrize("version", VERSIONS)
def test_instances_leave_nothing(instantiate, inputs, version):
    """Memory does not grow with the instances that there were."""
    instantiate(inputs / "tippe_top.nml", version)
    (one,), _ = instantiate(inputs / "tippe_top.nml", version)
    sizes = []
    for i in range(100):
        one.reset()
        if version == "2":
            one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
        one.doStep(0.0, 1e-3)
        if i % 50 == 49:
            sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    assert sizes[1] - sizes[0] < 2048


@pytest.mark.parametrize("version", VERSIONS)
def test_sources_compile(unit, inputs, tmp_path, version):
    """The sources inside make the same functions."""
    with zipfile.ZipFile(unit(inputs / "tippe_top.nml", version)) as archive:
        archive.extractall(tmp_path / "content")
    compiler = shutil.which("gcc")
    if compiler is None:
        pytest.skip("there is no gcc")
    sources = tmp_path / "content/sources"
    for name in ["variables.c", "instance.c", f"fmu{version}.c"]:
        command = [compiler, "-std=c11", "-Wall", "-Wextra", "-Werror", "-fPIC", "-I."]
        done = subprocess.run(
            [*command, "-c", name], cwd=sources, capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, "")


def test_mistakes(run, scene):
    """The command tells of them, and leaves nothing."""
    result = run("fmu", scene.name, "--set", "top.mass = -1")
    assert result.status == 2
    assert "expected" in result.err
    assert run("fmu", scene.name).status == 0
    again = run("fmu", scene.name)
    assert again.status == 74
    assert "exists" in again.err
