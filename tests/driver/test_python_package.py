"""The Python package: its wheel, what it gives, and what it says to wrong use.

The wheel is built once, by scripts/wheel without optimization across files, unless CONTENSOU_WHEEL
names one. Tests use it as it lies unpacked in a folder; one installs it in a fresh environment.
"""

from __future__ import annotations

import doctest
import importlib
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
import pytest
from programs import captured

xarray = pytest.importorskip("xarray")
ROOT = Path(__file__).resolve().parents[2]
INPUTS = ROOT / "inputs"
MODULES = sorted(path.stem for path in (ROOT / "python/contensou").glob("*.py"))
SHORT = {"scene.t_end": 0.02, "output.interval": 0.002}

# Those that are read relative to them; the rest is what `contensou run` reads.
SCENES = sorted(path.relative_to(INPUTS) for path in INPUTS.rglob("*.nml"))

BALL = """\
&scene gravity = 0, 0, -9.81, t_end = 0.02 /
&material name = 'steel', young = 210000000000.0, poisson = 0.3 /
&body name = 'ball', mass = 0.0327, inertia = 1.31e-06, 1.31e-06, 1.31e-06
   position = 0, 0, 0.0101 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.01, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /
&contact name = 'it', surfaces = 'skin', 'floor', friction = 'pade22', friction_coefficient = 0.3
   drilling = .true. /
"""

GROUPS = {
    "scene": {"gravity": (0, 0, -9.81), "t_end": 0.02},
    "material": {"name": "steel", "young": 2.1e11, "poisson": np.float64(0.3)},
    "body": {
        "name": "ball",
        "mass": 0.0327,
        "inertia": np.full(3, 1.31e-6),
        "position": [0, 0, 0.0101],
    },
    "surface": [
        {"name": "skin", "body": "ball", "shape": "sphere", "radius": 1e-2, "material": "steel"},
        {"name": "floor", "body": "ground", "shape": "plane", "material": "steel"},
    ],
    "contact": {
        "name": "it",
        "surfaces": ("skin", "floor"),
        "friction": "pade22",
        "friction_coefficient": 0.3,
        "drilling": True,
    },
}

# Workers could not tell warnings of the package to a process that has no such package.
pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")


@pytest.fixture
def in_inputs(monkeypatch):
    """Work in the folder of the shipped scenes."""
    monkeypatch.chdir(INPUTS)


def called(unpacked, *words, **more):
    """What the program of the wheel leaves."""
    return captured([unpacked / "bin/contensou", *map(str, words)], **more)


# ---- The wheel ----------------------------------------------------------------------------------


def test_one_wheel_serves_all_versions_of_python(wheel):
    name = re.fullmatch(r"contensou-[\d.]+-py3-none-(manylinux_2_\d+_x86_64)\.whl", wheel.name)
    assert name
    assert wheel.stat().st_size < 15e6
    tools = ROOT / "build-wheel/tools/bin"
    if not (tools / "auditwheel").exists():
        pytest.skip("there is no auditwheel")
    shown = captured([tools / "auditwheel", "show", wheel], env={"PATH": f"{tools}:/usr/bin:/bin"})
    assert f'"{name[1]}"' in " ".join(shown.stdout.split())


def test_no_symbol_leaks(unpacked):
    """The library shows the functions of the header and nothing else; the rest is inside."""
    header = (ROOT / "include/contensou.h").read_text()
    library = unpacked / "lib/libcontensou_python.so"
    for tool in ("nm", "readelf"):
        if shutil.which(tool) is None:
            pytest.skip(f"there is no {tool}")
    lines = captured(["nm", "-D", "--defined-only", library]).stdout.splitlines()
    shown = {line.split()[-1] for line in lines}
    assert {"contensou_version", "contensou_simulation_new", "contensou_hertz"} <= shown
    assert all(re.search(rf"\b{name}\(", header) for name in shown)
    allowed = r"lib(gfortran-\w+|quadmath-\w+|c|m|mvec|gcc_s|z|pthread|dl)\.so[\d.]*|ld-linux-.*"
    for file in (library, unpacked / "bin/contensou"):
        needed = re.findall(r"NEEDED.*\[(.*)\]", captured(["readelf", "-d", file]).stdout)
        assert needed
        assert [name for name in needed if not re.fullmatch(allowed, name)] == []


def test_fresh_environment(wheel, tmp_path):
    """Two commands in an environment with nothing but pip; the second one runs a scene."""
    python = "/usr/bin/python3" if Path("/usr/bin/python3").exists() else sys.executable
    fresh = tmp_path / "fresh"
    if captured([python, "-m", "venv", fresh]).returncode != 0:
        pytest.skip(f"{python} makes no environments")
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path), **proxies()}
    install = [fresh / "bin/python", "-m", "pip", "install", "--quiet", wheel]
    done = captured(list(map(str, install)), env=environment, timeout=600)
    if done.returncode != 0 and re.search("onnection|Could not find a version", done.stderr):
        pytest.skip("the packages that it needs cannot be had here")
    assert done.returncode == 0, done.stderr
    shutil.copy(INPUTS / "tippe_top.nml", tmp_path)
    program = (
        "import contensou; t = contensou.run('tippe_top.nml', {'top.spin': (0, 0, 200),"
        " 'scene.t_end': 0.01}); print(t.sizes['time'], t.spin.values[0, 0])"
    )
    command = [str(fresh / "bin/python"), "-c", program]
    done = captured(command, env=environment, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    rows, spin = done.stdout.split()
    assert int(rows) == 11
    assert float(spin) == pytest.approx(200 * np.cos(0.1), rel=1e-3)
    done = captured([str(fresh / "bin/contensou"), "version"], env=environment)
    assert done.stdout.startswith("contensou ")
    assert "SUNDIALS" in done.stdout
    sets = ["--set", "scene.t_end=0.01", "-q", "-o", "top.h5"]
    command = [str(fresh / "bin/contensou"), "run", "tippe_top.nml", *sets]
    assert captured(command, env=environment, cwd=tmp_path).returncode == 0
    # Pages and files of bodies need nothing else; what plots says what it needs.
    for command, written in (
        (["bin/contensou", "export", "top.h5", "--to", "gltf"], "top.glb"),
        (["bin/contensou", "export", "top.h5", "--to", "vtk"], "top.vtkhdf"),
        (["bin/contensou-view", "top.h5"], "top.html"),
    ):
        done = captured([fresh / command[0], *command[1:]], env=environment, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        assert (tmp_path / written).stat().st_size > 1000
    program = (
        "import contensou as c; t = c.sweep('tippe_top.nml', {'top.angle': [0.1, 0.2]},"
        " {'scene.t_end': 0.01}); print(len(c.view('top.h5').html), len(c.view(t).html))\n"
        "try: c.plot('top.h5')\nexcept ImportError as problem: print(problem)"
    )
    done = captured([fresh / "bin/python", "-c", program], env=environment, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    sizes, said = done.stdout.splitlines()
    assert min(map(int, sizes.split())) > 10_000
    remedy = f"{fresh}/bin/python -m pip install matplotlib"
    assert said == f"contensou.plot needs matplotlib: {remedy}"
    done = captured([fresh / "bin/contensou-plot", "top.h5"], env=environment, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"has no matplotlib, which contensou-plot needs: {remedy} (" in done.stderr


def proxies():
    """What pip needs of the environment."""
    return {name: os.environ[name] for name in os.environ if re.match("(?i)(pip_|.*_proxy$)", name)}


def test_tools_of_the_wheel(unpacked, in_inputs, tmp_path):
    """The program finds its tool for formats with bodies, which draws with the Python on PATH."""
    file = tmp_path / "top.h5"
    done = called(unpacked, "run", "tippe_top.nml", "-q", "-o", file, "--set", "scene.t_end=0.01")
    assert done.returncode == 0, done.stderr
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    done = called(unpacked, "export", file, "--to", "gltf", env=os.environ | {"PATH": path})
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "top.glb").read_bytes().startswith(b"glTF")
    for name, suffix in (("plot", ".png"), ("view", ".html")):
        program = (
            f"import sys; sys.argv = ['contensou-{name}', {str(file)!r}];"
            " from contensou._program import tool; tool()"
        )
        environment = os.environ | {"PYTHONPATH": str(unpacked.parent)}
        done = captured([sys.executable, "-c", program], env=environment)
        assert done.returncode == 0, done.stderr
        assert file.with_suffix(suffix).exists()


SIMULATION = """
import sys, fmpy
kind, end = sys.argv[2], float(sys.argv[3])
result = fmpy.simulate_fmu(sys.argv[1], fmi_type=kind, stop_time=end, output_interval=end / 20,
                           output=["top.position.x", "top.position.z"])
print(*map(repr, map(float, result[-1])))
"""


@pytest.mark.parametrize("version", ["2", "3"])
def test_units_of_the_wheel_need_nothing_else(unpacked, in_inputs, tmp_path, version):
    """The program writes FMUs; the binary has beside it what is not on each Linux."""
    pytest.importorskip("fmpy", reason="FMPy is not installed")
    settings = ("--set", "scene.t_end=0.02", "--set", "output.interval=0.001")
    words = ("tippe_top.nml", "-o")
    unit = tmp_path / "unit.fmu"
    done = called(unpacked, "fmu", *words, unit, "--fmi", version, *settings)
    assert (done.returncode, done.stderr) == (0, "")
    with zipfile.ZipFile(unit) as file:
        file.extractall(tmp_path / "unit")
    (folder,) = (tmp_path / "unit/binaries").iterdir()
    beside = {path.name for path in folder.iterdir()}
    assert len(beside) > 1
    common = {"libc.so.6", "libm.so.6", "libmvec.so.1", "libgcc_s.so.1", "ld-linux-x86-64.so.2"}
    for path in folder.iterdir():
        shown = captured(["readelf", "-d", path]).stdout
        needed = set(re.findall(r"NEEDED.*\[(.*)\]", shown))
        assert needed <= common | beside
        assert not needed & beside or re.search(r"(?:RPATH|RUNPATH).*[\[:]\$ORIGIN[\]:]", shown)
    assert called(unpacked, "run", *words, tmp_path / "run.h5", "-q", *settings).returncode == 0
    with h5py.File(tmp_path / "run.h5") as file:
        expected = file["trajectory/position"][-1, 0, [0, 2]]
    for kind, error in (("CoSimulation", 0.0), ("ModelExchange", 1e-6)):
        done = captured([sys.executable, "-c", SIMULATION, unit, kind, "0.02"], cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        found = np.array(list(map(float, done.stdout.split())))[1:]
        assert np.abs(found - expected).max() <= error


@pytest.mark.parametrize("module", MODULES)
def test_examples_in_docstrings(module, contensou, in_inputs):
    name = "contensou" if module == "__init__" else f"contensou.{module}"
    found = doctest.testmod(importlib.import_module(name))
    assert found.failed == 0


def test_what_is_public_is_described(contensou):
    """Everything has a docstring and hints of types; parameters of functions are described."""
    for name in contensou.__all__:
        thing = getattr(contensou, name)
        if not callable(thing):
            continue
        assert thing.__doc__, name
        hints = getattr(thing, "__annotations__", {})
        if not isinstance(thing, type):
            assert "return" in hints, name
    assert set(contensou.__all__) <= set(dir(contensou))
    with pytest.raises(AttributeError, match="no attribute 'runn'"):
        _ = contensou.runn


def test_the_program_starts_without_numpy(unpacked):
    """The command takes a hundredth of a second more than the program itself."""
    program = "import sys, contensou, contensou._program; print('numpy' in sys.modules)"
    environment = os.environ | {"PYTHONPATH": str(unpacked.parent)}
    done = captured([sys.executable, "-c", program], env=environment)
    assert (done.returncode, done.stdout) == (0, "False\n")


# ---- Runs ---------------------------------------------------------------------------------------


def file_of(unpacked, folder, scene, settings):
    """The file of the program for the same scene and settings."""
    words = [word for path, value in settings.items() for word in ("--set", f"{path}={value}")]
    done = called(unpacked, "run", scene, "-q", "-o", folder / "run.h5", "--force", *words)
    return done, folder / "run.h5"


@pytest.mark.parametrize("scene", [path for path in SCENES if "sweeps" not in path.parts], ids=str)
def test_a_run_equals_the_file(scene, contensou, unpacked, in_inputs, tmp_path):
    """Bit for bit, in all groups but those that tell when and where it ran."""
    done, path = file_of(unpacked, tmp_path, scene, SHORT)
    if done.returncode != 0:
        with pytest.raises(contensou.ContensouError) as caught:
            contensou.run(scene, SHORT)
        assert str(caught.value) in done.stderr
        return
    tree = contensou.run_tree(scene, SHORT)
    expected = xarray.open_datatree(path, engine="h5netcdf", decode_timedelta=False)
    assert set(tree.children) == set(expected.children)
    for name in set(tree.children) - {"input", "provenance", "integrator", "summary"}:
        found, wanted = tree[name].to_dataset(), expected[name].to_dataset()
        xarray.testing.assert_identical(found, wanted)
        for key, column in found.variables.items():
            if column.dtype.kind == "f":
                assert column.values.tobytes() == wanted[key].values.tobytes()
    for name in ("summary", "integrator"):
        found, wanted = tree[name].to_dataset(), expected[name].to_dataset()
        times = [key for key in wanted.variables if key.startswith("cpu")]
        xarray.testing.assert_identical(found.drop_vars(times), wanted.drop_vars(times))
    expected.close()


def test_a_dataset_is_the_trajectory(contensou, in_inputs):
    settings = {"top.spin": (0, 0, 200), **SHORT}
    tree, found = (
        contensou.run_tree("tippe_top.nml", settings),
        contensou.run(Path("tippe_top.nml"), settings),
    )
    xarray.testing.assert_identical(found, tree["trajectory"].to_dataset())
    assert found.spin.values[0, 0] == pytest.approx(200 * np.cos(0.1), rel=1e-3)
    assert found.gap.sel(contact="ball_floor").attrs["units"] == "m"
    copy = pickle.loads(pickle.dumps(found))
    xarray.testing.assert_identical(copy, found)


def test_text_and_dictionary_are_the_same_scene(contensou):
    from_text, from_groups = contensou.run(BALL), contensou.run(GROUPS)
    xarray.testing.assert_identical(from_text, from_groups)
    text = contensou.scene_text(GROUPS)
    assert "inertia = 1.31e-06, 1.31e-06, 1.31e-06" in text
    xarray.testing.assert_identical(contensou.run(text), from_text)


def test_settings_are_values_or_texts(contensou):
    first = contensou.run(GROUPS, {"ball.position": (0, 0, 0.02), "it.drilling": False})
    second = contensou.run(GROUPS, ["ball.position=0,0,0.02", "it.drilling=.false."])
    xarray.testing.assert_identical(first, second)
    third = contensou.run(GROUPS, {"ball.position(3)": contensou.Expression("20e-3")})
    assert third.position.values[0, 0, 2] == first.position.values[0, 0, 2] == 0.02


WRONG = [
    ("no_such_file.nml", None, "FileError", "no_such_file.nml cannot be read"),
    (BALL.replace("mass", "mas"), None, "SceneError", "unknown key 'mas' in group &body"),
    (BALL, {"ball.mass": -1}, "SceneError", "mass"),
    (BALL, {"ball.mass": float("nan")}, "SceneError", "ball.mass: nan is no number"),
    (BALL, {"ball.mass": None}, "SceneError", "a NoneType cannot stand in a scene"),
    (BALL, {"ball.mass": b"1"}, "SceneError", "a bytes cannot stand in a scene"),
    (BALL, {3: 4}, "SceneError", "3 is no path"),
    (BALL, [1], "SceneError", "expected texts"),
    (BALL, {"ball.mas": 1}, "SceneError", "mas"),
    ({"scene /": {}}, None, "SceneError", "no name of a group"),
    ({"scene": {"t_end = 1 / &body": 1}}, None, "SceneError", "no name of a key"),
    ({"scene": [3]}, None, "SceneError", "expected a dictionary"),
    ({}, None, "SceneError", "there is no group &scene"),
    ({"scene": None}, None, "SceneError", "group &scene: expected a dictionary of keys and values"),
    ({"scene": 3}, None, "SceneError", "or a list of such, not 3"),
    ({"scene": "t_end"}, None, "SceneError", "or a list of such, not 't_end'"),
    ({"scene": {"title": "\ud800"}}, None, "SceneError", "scene.title: a lone surrogate"),
    ({"scene": {"title": "a\0b"}}, None, "SceneError", "scene.title: a zero byte"),
    ({"scene": {"t_end": 1 + 1j}}, None, "SceneError", "scene.t_end: a complex cannot stand"),
    (None, None, "SceneError", "scene: expected the name of a file, the text of a scene or"),
    (3, None, "SceneError", "a dictionary of its groups, not 3"),
    (b"top.nml", None, "SceneError", "a dictionary of its groups, not b'top.nml'"),
    ("no\0file", None, "SceneError", "scene: 'no\\x00file' is no name of a file in UTF-8"),
    ("\ud800", None, "SceneError", "scene: '\\ud800' is no name of a file"),
    ("\udcff.nml", None, "SceneError", "is no name of a file in UTF-8"),
    (BALL.replace("steel", "st\udc80l"), None, "SceneError", "scene: a lone surrogate"),
    (BALL, 3, "SceneError", "settings: expected a dictionary of values by path, or a list of"),
    (BALL, "ball.mass=1", "SceneError", "settings: expected a dictionary of values by path"),
    (BALL, b"ball.mass=1", "SceneError", "settings: expected a dictionary of values by path"),
    (BALL, {3: 1}, "SceneError", "3 is no path such as 'body.mass'"),
    (BALL, {"ball.mass": "1\0"}, "SceneError", "ball.mass: a zero byte"),
    (BALL, {"ball": {"mass": 1}}, "SceneError", "write 'ball.mass' for a value of it"),
    (BALL, ["ball.mass=\udfff"], "SceneError", "settings: a lone surrogate"),
]


@pytest.mark.parametrize(("scene", "settings", "kind", "message"), WRONG)
def test_wrong_use_is_an_exception(scene, settings, kind, message, contensou):
    with pytest.raises(getattr(contensou, kind)) as caught:
        contensou.run(scene, settings)
    assert message in str(caught.value)
    assert isinstance(caught.value, contensou.ContensouError)
    copy = pickle.loads(pickle.dumps(caught.value))
    assert (str(copy), copy.status) == (str(caught.value), caught.value.status)


@pytest.mark.parametrize(("scene", "settings", "kind", "message"), WRONG)
def test_a_simulation_says_the_same(scene, settings, kind, message, contensou):
    if kind == "FileError":
        message = message.replace("no_such_file.nml ", "")
    with pytest.raises(getattr(contensou, kind)) as caught:
        contensou.Simulation(scene, settings)
    assert message in str(caught.value)


def test_values_of_other_packages(contensou):
    """What stands for numbers is written as numbers."""
    array = xarray.DataArray([1.5, 2.5], dims="x")
    text = contensou.scene_text(
        {"body": {"position": array, "mass": array[0], "fixed": np.bool_(1)}}
    )
    assert text == "&body\n   position = 1.5, 2.5\n   mass = 1.5\n   fixed = .true.\n/\n"


def test_errors_are_those_of_python_too(contensou):
    assert issubclass(contensou.SceneError, ValueError)
    assert issubclass(contensou.FileError, OSError)
    assert issubclass(contensou.SimulationError, RuntimeError)
    with pytest.raises(contensou.SimulationError, match="tenth"):
        contensou.run(GROUPS, {"ball.velocity": (0, 0, -1e3)})


def test_warnings_are_warnings(contensou):
    with pytest.warns(contensou.SceneWarning, match="friction coefficient of 30"):
        contensou.run(GROUPS, {"it.friction_coefficient": 30})


@pytest.mark.parametrize(
    "call",
    [
        "run(scene, {'scene.t_end': 1e5, 'output.interval': 1.0})",
        "sweep(scene, {'top.spin(3)': [150, 180]}, {'scene.t_end': 1e4})",
        "Simulation(scene, {'scene.t_end': 1e5, 'output.interval': 1e5}).advance()",
    ],
)
def test_an_interrupt_from_the_keyboard(call, unpacked, tmp_path):
    """It ends the call and the program, and leaves no file."""
    program = f"import contensou; scene = {str(INPUTS / 'tippe_top.nml')!r}\n"
    program += "print('begun', flush=True)\ntry:\n"
    program += f"    contensou.{call}\nexcept KeyboardInterrupt:\n    print('interrupted')\n"
    environment = os.environ | {"PYTHONPATH": str(unpacked.parent), "TMPDIR": str(tmp_path)}
    process = subprocess.Popen(
        [sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "begun\n"
    deadline = time.monotonic() + 60
    started = []
    while "Simulation" not in call and not started and time.monotonic() < deadline:
        time.sleep(0.05)
        started = children(process.pid)
    assert started or "Simulation" in call
    time.sleep(0.3 if started else 3.0)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=30)
    assert (process.returncode, out) == (0, "interrupted\n")
    assert not any(Path(f"/proc/{pid}").exists() for pid in started)
    assert not leftovers(process.pid, tmp_path)


def children(pid):
    """Processes that a process has started."""
    listed = Path(f"/proc/{pid}/task/{pid}/children")
    return listed.read_text().split() if listed.exists() else []


def leftovers(pid, folder):
    """Folders that the package made in a process, other processes being at work beside it."""
    return [*Path("/dev/shm").glob(f"contensou-{pid}-*"), *folder.iterdir()]


# ---- Simulations --------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", [path for path in SCENES if "sweeps" not in path.parts], ids=str)
def test_a_simulation_has_the_rows_of_a_run(scene, contensou, in_inputs):
    """Bit for bit, and the events, whatever times it stops at."""
    settings = {**SHORT, "scene.t_end": 0.01}
    try:
        tree = contensou.run_tree(scene, settings)
    except contensou.ContensouError as problem:
        said = str(problem)
        with pytest.raises(contensou.ContensouError) as caught:
            contensou.Simulation(scene, settings).advance()
        assert str(caught.value) in said
        return
    simulation = contensou.Simulation(scene, settings)
    found = simulation.rows()
    wanted = tree["trajectory"].to_dataset()
    for name, column in found.variables.items():
        if column.dtype.kind != "f":
            assert column.values.tolist() == wanted[name].values.tolist()
            continue
        assert column.dims == wanted[name].dims
        assert column.values.tobytes() == wanted[name].values.tobytes(), name
        assert column.attrs["units"] == wanted[name].attrs["units"]
    assert {"position", "quaternion", "energy_kinetic"} <= set(found.data_vars)
    events = tree["events"].to_dataset()
    assert [event.time for event in simulation.events] == events.time.values.tolist()
    assert [event.kind for event in simulation.events] == events.kind.values.tolist()
    assert [event.contact for event in simulation.events] == events.contact.values.tolist()


def test_steps_and_what_is_there(contensou, in_inputs):
    top = contensou.Simulation("tippe_top.nml", {"top.spin": (0, 0, 200), "scene.t_end": 0.1})
    assert (top.time, top.end, top.stop) == (0.0, 0.1, 0)
    assert (top.bodies, top.contacts) == (["top"], ["ball_floor", "stem_floor"])
    body = top.body("top")
    assert body.angular_velocity.tolist() == [0, 0, 200]
    assert np.linalg.norm(body.quaternion) == pytest.approx(1)
    assert top.state[:3].tolist() == body.position.tolist()
    assert top.values("gap").shape == (2,)
    assert top.quantities["position"].dims == ("body", "xyz")
    assert top.quantities["gap"].units == "m"
    spin = top.parameters["top.spin(3)"]
    assert (spin.value, spin.unit) == (200, "rad s-1")
    assert "&body" in top.settings
    rates, matrix = top.derivative(), top.jacobian()
    assert rates[:3] == pytest.approx(body.velocity)
    h = 1e-7
    shifted = top.state
    shifted[7] += h
    assert (top.derivative(state=shifted) - rates) / h == pytest.approx(matrix[:, 7], abs=1e-3)
    assert top.indicators().tolist() == top.values("gap").tolist()
    assert top.step(0.02) == 0.02
    assert top.advance() == 0.1
    top.reset()
    assert (top.time, top.events) == (0.0, [])
    top.set({"top.spin(3)": 150, "integrator.method": "'explicit8'"})
    assert top.body("top").angular_velocity.tolist() == [0, 0, 150]
    stopped = top.advance(0.05, lambda now: now.time >= 0.009)
    assert 0.009 <= stopped < 0.02
    top.set_load("top", force=(0, 0, 0.1))
    height = top.body("top").position[2]
    top.step(0.05)
    assert top.body("top").position[2] > height


def test_events_one_after_the_other(contensou):
    ball = contensou.Simulation(GROUPS, {"ball.position(3)": 0.0101, "scene.t_end": 0.1})
    event = ball.advance_to_event()
    assert (event.kind, event.contact) == ("touch", "it")
    assert event.time == pytest.approx(np.sqrt(2 * 1e-4 / 9.81), rel=1e-6)
    assert ball.time == event.time
    assert ball.advance_to_event().kind == "lift"
    assert ball.advance_to_event(ball.time + 1e-6) is None


def test_snapshots_in_contact(contensou, in_inputs):
    """What is saved is pickled, and goes on with the same bits there and in a copy."""
    first = contensou.Simulation("tippe_top.nml", {"scene.t_end": 0.1})
    first.advance(0.013)
    assert first.values("normal_force")[0] > 0
    snapshot = pickle.loads(pickle.dumps(first.save()))
    copy = first.copy()
    second = contensou.Simulation("tippe_top.nml", {"scene.t_end": 0.1})
    second.restore(snapshot)
    for one in (first, second, copy):
        one.advance(0.05)
    assert first.state.tobytes() == second.state.tobytes() == copy.state.tobytes()
    first.restore(snapshot)
    assert first.time == 0.013


def test_loads_for_hosts(contensou, in_inputs):
    """What acts on a body is the contact forces of rows, wherever the body is put."""
    top = contensou.Simulation("tippe_top.nml")
    top.advance(0.013)
    body, load = top.body("top"), top.load("top")
    normal = top.values("normal_force")[0]
    assert load.force[2] == pytest.approx(normal, rel=1e-9)
    friction = top.values("friction_force")[0]
    assert np.linalg.norm(load.force[:2]) == pytest.approx(np.linalg.norm(friction), rel=1e-9)
    top.set_body("top", position=(1.0, 2.0, 3.0))
    assert np.abs(top.load("top").force).max() < 1e-15
    assert np.abs(top.load("top").torque).max() < 1e-15
    assert top.body("top").velocity.tolist() == body.velocity.tolist()
    top.set_body("top", *body)
    assert top.load("top").torque.tobytes() == load.torque.tobytes()
    # A torque of the host's is that of the equations: it changes the spin, with gyroscopic terms.
    there = contensou.Simulation("tippe_top.nml", {"scene.gravity": (0, 0, 0)})
    there.set_body("top", position=(0, 0, 1))
    there.set_load("top", (0, 0, 2.0), (0, 0, 3.0))
    axis = np.array([-np.sin(0.1), 0, np.cos(0.1)])
    assert there.load("top").force == pytest.approx([0, 0, 2.0])
    assert there.load("top").torque == pytest.approx(3 * axis, abs=1e-12)
    balls = contensou.Simulation("examples/break_shot.nml")
    loads = [balls.load(name).force[2] for name in balls.bodies]
    assert loads == pytest.approx([0.16614843231954618 * 9.81] * 16, rel=1e-6)


def test_wrong_use_of_a_simulation(contensou):
    make = contensou.Simulation
    for words in (("nothing.nml",), (BALL, {"ball.mas": 1}), ("&scene\0 /\n",), (3,)):
        with pytest.raises(contensou.ContensouError):
            make(*words)
    ball = make(GROUPS)
    n = ball.state.size
    wrong = [
        lambda: ball.body("bell"),
        lambda: ball.body("ba\0ll"),
        lambda: ball.body(None),
        lambda: ball.values("hight"),
        lambda: ball.rows(["hight"]),
        lambda: ball.derivative(state=np.zeros(n + 1)),
        lambda: ball.derivative(state=np.full(n, np.nan)),
        lambda: ball.jacobian(state="abc"),
        lambda: ball.indicators(state=np.zeros(0)),
        lambda: setattr(ball, "state", np.zeros(n - 1)),
        lambda: setattr(ball, "state", [None] * n),
        lambda: ball.set({"ball.mass": -1}),
        lambda: ball.set({"ball.colour": 1}),
        lambda: ball.set_body("bell"),
        lambda: ball.set_body("ball", (1, 2)),
        lambda: ball.set_body("ball", velocity="fast"),
        lambda: ball.set_body("ball", quaternion=(np.nan, 0, 0, 1)),
        lambda: ball.load("bell"),
        lambda: make(GROUPS | {"body": {"name": "ball", "motion": "fixed"}}).load("ball"),
        lambda: ball.set_load("ball", (1, 2)),
        lambda: ball.set_load("bell", (1, 2, 3)),
        lambda: ball.set_drive("ball", (1, 2, 3)),
        lambda: ball.restore(b"abc"),
        lambda: ball.restore(contensou.Snapshot(b"abc")),
        lambda: ball.restore(contensou.Snapshot(make(BALL, {"ball.mass": 2}).save().data[:-9])),
        lambda: ball.restore(contensou.Snapshot(3)),
        lambda: ball.restore(contensou.Snapshot("abc")),
        lambda: ball.advance(float("nan")),
        lambda: ball.advance(-1.0),
        lambda: ball.advance("soon"),
        lambda: ball.advance([0.01, 0.02]),
        lambda: ball.advance(0.01, 3),
        lambda: ball.advance_to_event(1j),
        lambda: ball.step(None),
        lambda: ball.rows(3),
        lambda: ball.rows([3]),
        lambda: ball.rows("hight"),
        lambda: ball.values([]),
        lambda: ball.values("\ud800"),
        lambda: ball.set(3),
        lambda: ball.set({"ball.mass": None}),
        lambda: ball.derivative("now"),
        lambda: ball.derivative(state=ball.state.astype(complex)),
        lambda: ball.derivative(state=ball.state.tobytes()),
        lambda: ball.jacobian(state=[str(number) for number in ball.state]),
        lambda: ball.indicators(state=[[1], [1, 2]]),
        lambda: setattr(ball, "state", ball.state.tobytes()),
        lambda: setattr(ball, "state", b"1"),
        lambda: setattr(ball, "state", ball.state * 1j),
        lambda: setattr(ball, "state", ball.state.astype("datetime64[s]")),
        lambda: setattr(ball, "state", [10**400] * n),
        lambda: setattr(ball, "state", None),
        lambda: ball.set_body("ball", (1, 2, 3j)),
        lambda: ball.set_load("ball", None),
        lambda: ball.set_load(None, (1, 2, 3)),
    ]
    for call in wrong:
        with pytest.raises(contensou.ContensouError):
            call()
    assert ball.advance(0.01) == 0.01
    with pytest.raises(contensou.ContensouError):
        ball.set({"ball.mass": 2})


def test_use_while_it_runs_and_after_its_end(contensou):
    ball = contensou.Simulation(GROUPS)
    heard = []

    def meddle(now):
        heard.append(now.values("position")[0, 2])
        for call in (now.reset, now.save, now.copy, now.close, lambda: now.set({"ball.mass": 2})):
            with pytest.raises(contensou.SceneError, match="is running"):
                call()

    ball.advance(0.01, meddle)
    assert heard

    class OurError(Exception):
        pass

    def fail(now):
        raise OurError

    with pytest.raises(OurError):
        ball.advance(0.02, fail)
    assert ball.advance(0.02) == 0.02
    with ball:
        pass
    assert "closed" in repr(ball)
    ball.close()
    for call in (ball.save, lambda: ball.state, lambda: ball.time, ball.advance, ball.copy):
        with pytest.raises(contensou.SceneError, match="is closed"):
            call()


def test_threads_with_different_scenes(contensou, in_inputs):
    """The bits are those of one after the other."""
    scenes = ["tippe_top.nml", "bouncing_ball.nml", "sliding_disc.nml", "rattleback.nml"]

    def last(scene):
        simulation = contensou.Simulation(scene, {"scene.t_end": 0.05})
        simulation.advance()
        return simulation.state.tobytes()

    alone = [last(scene) for scene in scenes]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(last, scenes * 3)) == alone * 3


# ---- Sweeps and pictures ------------------------------------------------------------------------


def test_a_sweep_is_its_runs(contensou, in_inputs):
    """Each cell of the grid is the run with its values; the progress is told."""
    told = []
    spins, angles = [150.0, 180.0, 200.0], [0.1, 0.2]
    table = contensou.sweep(
        "tippe_top.nml",
        {("top.spin(3)",): spins, "top.angle": {"values": angles, "column": "tilt"}},
        SHORT,
        values=[{"name": "height", "dataset": "position", "of": "top", "component": 3,
                 "time": 0.02}],
        progress=lambda share, line: told.append(share),
    )  # fmt: skip
    assert dict(table.sizes) == {"top.spin(3)": 3, "tilt": 2}
    assert table.tilt.values.tolist() == angles
    assert told[0] == 0
    assert told[-1] == 1
    for spin in spins:
        for angle in angles:
            settings = {"top.spin(3)": spin, "top.angle": angle, **SHORT}
            run = contensou.run_tree("tippe_top.nml", settings)
            cell = table.sel({"top.spin(3)": spin, "tilt": angle})
            assert cell.status == 0
            assert cell.height == run["trajectory"].position[-1, 0, 2]
            assert cell.energy_error == run["summary"].energy_error
            assert cell.touches == run["summary"].touches


def test_a_sweep_by_sampling(contensou):
    table = contensou.sweep(
        GROUPS,
        {"ball.position(3)": {"first": 0.011, "last": 0.02}, "ball.mass": {"first": 1, "last": 2}},
        sampling="sobol",
        cases=8,
        keep=["steps"],
    )
    assert dict(table.sizes) == {"case": 8}
    assert {"status", "message", "steps"} == set(table.data_vars)
    assert len(set(table["ball.mass"].values)) == 8


def test_wrong_sweeps(contensou):
    for parameters, options, message in (
        ({"ball.mas": [1, 2]}, {}, "mas"),
        ({"ball.mass": {"first": 1, "last": 2}}, {}, "'count' is missing"),
        ({"ball.mass": [1, 2]}, {"sampling": "random"}, "random"),
        ({}, {}, "parameter"),
        ({"ball.mass": [1]}, {"cassis": 3}, "cassis"),
        (3, {}, "parameters: expected a dictionary of values by path, not 3"),
        (
            {"ball.mass": 1.0},
            {},
            r"parameter 'ball.mass': expected a list of values, or .* not 1.0",
        ),
        ({"ball.mass": "1"}, {}, "parameter 'ball.mass': expected a list of values"),
        ({"ball.mass": None}, {}, "parameter 'ball.mass': expected a list of values"),
        ({"ball.mass": np.float64(3)}, {}, "parameter 'ball.mass': expected a list of values"),
        ({"ball.mass": {"values": None}}, {}, "parameter.values: a NoneType cannot stand"),
        (
            {"ball.mass": {"first": 1, "last": 2, "count": "2"}},
            {},
            "count of parameter 'ball.mass'",
        ),
        ({None: [1, 2]}, {}, "parameter.name: a NoneType cannot stand in a scene"),
        ({"ball.mass": [1, 2]}, {"values": 3}, "values: expected a list of dictionaries"),
        ({"ball.mass": [1, 2]}, {"values": [3]}, "group &value: expected a dictionary"),
        ({"ball.mass": [1, 2]}, {"keep": 3}, "keep: expected a list of names, not 3"),
        ({"ball.mass": [1, 2]}, {"jobs": 1.5}, "jobs: expected a whole number, not 1.5"),
        ({"ball.mass": [1, 2]}, {"settings": 3}, "settings: expected a dictionary"),
    ):
        with pytest.raises(contensou.SceneError, match=message):
            contensou.sweep(GROUPS, parameters, **options)
    table = contensou.sweep(GROUPS, {"ball.position(3)": [0.02, 0.001]})
    assert table.status.values.tolist() == [0, 2]
    assert "overlap" in str(table.message.values[1])


def test_pages_and_pictures(contensou, in_inputs, tmp_path):
    """Of a run in memory, of a file and of a scene; a notebook shows the page in a frame."""
    run = contensou.run("tippe_top.nml", SHORT)
    page = contensou.view(run, height=333)
    assert page.html.startswith("<!doctype html>")
    assert "333px" in page._repr_html_()
    assert "&lt;!doctype html&gt;" in page._repr_html_()
    page.save(tmp_path / "top.html")
    assert (tmp_path / "top.html").read_text(encoding="utf-8") == page.html
    mpl = pytest.importorskip("matplotlib")
    before = dict(mpl.rcParams.copy(), backend=mpl.get_backend())
    figure = contensou.plot(run)
    assert dict(mpl.rcParams) == before
    figure.savefig(tmp_path / "top.png")
    assert len(figure.axes) >= 6
    table = contensou.sweep("tippe_top.nml", {"top.spin(3)": [150, 180]}, SHORT)
    assert len(contensou.plot(table, result=["energy_error"], over=["top.spin(3)"]).axes) == 1
    assert contensou.view(table).html.startswith("<!doctype html>")
    assert len(contensou.plot("tippe_top.nml", SHORT).axes) == len(figure.axes)
    with pytest.raises(contensou.SceneError, match="do not know the run"):
        contensou.view(xarray.Dataset())
    with pytest.raises(contensou.SceneError, match="settings are for a scene"):
        contensou.view(run, SHORT)
    with pytest.raises(contensou.SceneError, match="the data is no table of a sweep"):
        contensou.plot(run, kind="map")
    for wrong, message in (
        ({"kind": "cake"}, "kind: expected one of lines, map, scatter, not 'cake'"),
        ({"result": 3}, "result: expected a list of names, not 3"),
        ({"over": ["a", "b", "c"]}, "over: expected one or two different parameters"),
        ({"where": "top.mass=1"}, "where: expected a dictionary of values by parameter"),
    ):
        with pytest.raises(contensou.SceneError, match=message):
            contensou.plot(table, **wrong)
    for wrong in (3, None, b"top.h5", "top\0.h5"):
        with pytest.raises(contensou.SceneError):
            contensou.view(wrong)
    with pytest.raises(contensou.FileError, match="cannot be written"):
        page.save(tmp_path / "none" / "top.html")
    with pytest.raises(contensou.FileError):
        contensou.view("nothing.h5")
