"""`contensou export` in formats that have bodies: files are read again here and compared with the
rows, and checked by Khronos' validator where it is."""

from __future__ import annotations

import json
import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from lib import drawable, meshes, surfaces, thinning  # noqa: E402

VALIDATOR = ROOT / ".venv" / "node" / "node_modules" / "gltf-validator"
HOSTILE = "</script> \\ \x1b[31m \u202e \" ' é {}"

BALL = """\
&scene title = {title}, gravity = 0, 0, -9.81, t_end = {end} /
&material name = 'rubber', young = 1e7, poisson = 0.4 /
&body name = 'ball', mass = 0.05, inertia = 3*8e-6, position = 0, 0, 0.12, spin = {spin} /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.02, material = 'rubber' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'rubber' /
&contact name = 'bounce', surfaces = 'skin', 'floor', damping = 'hunt_crossley',
   restitution = 0.8, impact_velocity = 1, friction = 'coulomb', friction_coefficient = 0.3,
   regularization_velocity = 1e-3 /
&output interval = {interval} /
"""

# A pendulum on a spring that swings round, a spring between two bodies, and a bushing.
SPRINGS = """\
&scene t_end = 1, gravity = 0, 0, -9.81 /
&body name = 'bob', mass = 1, inertia = 3*1e-2, position = 0.3, 0, 1, spin = 0, 1, 20,
   velocity = 0, 4, 0 /
&body name = 'box', mass = 2, inertia = 3*1e-2, position = 0, 0.5, 0.7 /
&spring name = 'strut', kind = 'axial', bodies = 'ground', 'bob', first_point = 0, 0, 1.5,
   second_point = 0.05, 0, 0.05, stiffness = 60, damping = 0.2, length = 0.4 /
&spring name = 'link', kind = 'axial', bodies = 'bob', 'box', first_point = 0, 0, 0,
   second_point = 0, 0, 0, stiffness = 40, length = 0.5 /
&spring name = 'mount', bodies = 'ground', 'box', first_point = 0, 0.5, 0.7, stiffness = 1e4,
   damping = 3, rotational_stiffness = 1 /
&output interval = 0.01 /
"""

# Every shape on a body, touched from outside and, but for planes, on the ground from inside.
SIZES = {
    "sphere": "radius = 0.03",
    "plane": "normal = 0, 0.6, 0.8",
    "cylinder": "radius = 0.01, direction = 1, 2, 2",
    "ellipsoid": "semi_axes = 0.01, 0.02, 0.03, axis = 1, 0, 0, angle = 0.5",
    "torus": "major_radius = 0.05, minor_radius = 0.01",
    "paraboloid": "vertex_radius = 0.02",
    "cone": "half_angle = 0.5",
}


def ball(title="'a ball'", end=0.5, spin="0, 5, 0", interval=1e-3):
    return BALL.format(title=title, end=end, spin=spin, interval=interval)


@pytest.fixture
def output(run, tmp_path):
    """Run a scene (text or path): the path of its file."""

    def output_of(scene, *options):
        path = scene
        if isinstance(scene, str):
            path = tmp_path / "scene.nml"
            path.write_text(scene)
        done = run("run", path, "-q", "-o", "out.h5", "--force", *options)
        assert done.status == 0, done.err
        return tmp_path / "out.h5"

    return output_of


class Gltf:
    """A binary file of glTF, read by its specification."""

    def __init__(self, path):
        data = path.read_bytes()
        magic, version, size, length, kind = struct.unpack_from("<4sIII4s", data)
        assert (magic, version, size, kind) == (b"glTF", 2, len(data), b"JSON")
        self.head = json.loads(data[20 : 20 + length])
        more, kind = struct.unpack_from("<I4s", data, 20 + length)
        assert kind == b"BIN\0"
        assert length % 4 == more % 4 == 0
        self.binary = data[28 + length :]
        assert len(self.binary) == more == self.head["buffers"][0]["byteLength"]
        self.nodes = self.head["nodes"]

    def array(self, number):
        accessor = self.head["accessors"][number]
        view = self.head["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        kind = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        count = accessor["count"] * width
        values = np.frombuffer(self.binary, kind, count, view["byteOffset"]).reshape(-1, width)
        if "min" in accessor:
            assert values.min(0).tolist() == accessor["min"]
            assert values.max(0).tolist() == accessor["max"]
        return values

    def node(self, name, parent=None):
        """A body, or a surface of one."""
        children = self.nodes[0 if parent is None else self.node(parent)]["children"]
        return next(i for i in children if self.nodes[i]["name"] == name)

    def keys(self, node, path):
        """Times and values of a channel; those of the node if it has none."""
        for channel in self.head["animations"][0]["channels"]:
            if channel["target"] == {"node": node, "path": path}:
                sampler = self.head["animations"][0]["samplers"][channel["sampler"]]
                assert sampler["interpolation"] == "LINEAR"
                at, values = self.array(sampler["input"]), self.array(sampler["output"])
                assert (np.diff(at[:, 0]) > 0).all()
                return at[:, 0].astype(float), values.astype(float)
        return np.zeros(1), np.array([self.nodes[node][path]])

    def positions(self, node, times):
        at, values = self.keys(node, "translation")
        return np.stack([np.interp(times, at, x) for x in values.T], axis=1)

    def lengths(self, node):
        """Times and factors of length along z."""
        at, values = self.keys(node, "scale")
        assert (values[:, :2] == 1).all()
        return [(at, values[:, 2])]

    def attitudes(self, node, times):
        """As Slerp of the specification: w, x, y, z."""
        at, values = self.keys(node, "rotation")
        values = values[:, [3, 0, 1, 2]]
        assert np.abs(np.linalg.norm(values, axis=1) - 1).max() < 1e-6
        if len(at) == 1:
            return np.repeat(values, len(times), axis=0)
        # Neighbours of the same sign, so that also what interpolates numbers goes the short way.
        assert (np.sum(values[1:] * values[:-1], axis=1) > 0).all()
        i = np.clip(np.searchsorted(at, times, "right") - 1, 0, len(at) - 2)
        share = np.clip((times - at[i]) / (at[i + 1] - at[i]), 0, 1)[:, None]
        first, last = values[i], values[i + 1]
        angle = np.arccos(np.clip(np.sum(first * last, axis=1, keepdims=True), -1, 1))
        sine = np.where(angle > 1e-6, np.sin(angle), 1)
        blend = np.sin((1 - share) * angle) * first + np.sin(share * angle) * last
        return np.where(angle > 1e-6, blend / sine, first)

    def points(self, node):
        """Points, normals and triangles of a surface in the frame of its body."""
        surface = self.nodes[node]
        x, y, z, w = surface["rotation"]
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        parts = self.head["meshes"][surface["mesh"]]["primitives"]
        points = self.array(parts[0]["attributes"]["POSITION"]).astype(float)
        normals = self.array(parts[0]["attributes"]["NORMAL"]).astype(float)
        triangles = np.concatenate([self.array(part["indices"]).reshape(-1, 3) for part in parts])
        return points @ turn.T + surface["translation"], normals @ turn.T, triangles


def exported(run, path, *options):
    """The file of a run as glTF."""
    done = run("export", path, "--to", "gltf", "--force", *options)
    assert done.status == 0, done.err
    assert Path(done.out.strip()) == path.with_suffix(".glb")
    return Gltf(path.with_suffix(".glb"))


def check_motion(gltf, path, degrees=1.0, parts=1e-3):
    """All rows of a file against the animation."""
    with h5py.File(path) as file:
        scale = drawable.open_run(path, file).scale
        rows = file["trajectory"]
        time = rows["time"][()] - rows["time"][0]
        for i, name in enumerate(file["body/name"].asstr()[()]):
            node = gltf.node(name)
            off = np.linalg.norm(gltf.positions(node, time) - rows["position"][:, i], axis=1)
            assert off.max() <= parts * scale
            cosine = np.abs(np.sum(gltf.attitudes(node, time) * rows["quaternion"][:, i], axis=1))
            assert np.degrees(2 * np.arccos(np.minimum(cosine, 1))).max() <= degrees


def validate(*paths):
    """What Khronos' validator says of files: errors and warnings."""
    if not shutil.which("node") or not VALIDATOR.exists():
        pytest.skip("there is no gltf-validator")
    program = (
        "const v = require(process.argv[1]), fs = require('fs');"
        "(async () => { for (const f of process.argv.slice(2)) {"
        "const r = await v.validateBytes(new Uint8Array(fs.readFileSync(f)));"
        "console.log(JSON.stringify(r.issues)); } })();"
    )
    done = subprocess.run(
        ["node", "-e", program, VALIDATOR, *paths], capture_output=True, text=True, check=True
    )
    for line in done.stdout.splitlines():
        issues = json.loads(line)
        assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]
    assert len(done.stdout.splitlines()) == len(paths)


SCENES = sorted([*(ROOT / "inputs").glob("*.nml"), *(ROOT / "inputs/examples").glob("*.nml")])


@pytest.mark.sample(5)
@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_shipped_scenes(path, run, output, build_kind):
    """The poses of the animation are those of the rows, and the validator has nothing to say."""
    # The checked build is slow.
    file = output(path, "--set", f"scene.t_end={0.05 if build_kind == 'release' else 0.005}")
    gltf = exported(run, file)
    check_motion(gltf, file)
    with h5py.File(file) as data:
        columns = [data[f"surface/{key}"].asstr()[()] for key in ("name", "body")]
        for name, body in zip(*columns, strict=True):
            assert len(gltf.points(gltf.node(name, body))[2]) > 3
    validate(file.with_suffix(".glb"))


def test_every_row(run, output):
    """All rows are keys; the numbers are those of the rows in 32 bits."""
    file = output(ball(end=0.05))
    gltf = exported(run, file, "--all")
    check_motion(gltf, file, 0.05, 1e-6)
    assert len(gltf.keys(gltf.node("ball"), "translation")[0]) == 51
    thin = exported(run, file)
    assert len(thin.keys(thin.node("ball"), "translation")[0]) < 30


def test_fast_spin(run, output):
    """A body that makes several turns between two rows turns as often as it does."""
    file = output(ball(end=0.4, spin="0, 0, 1000", interval=0.02))
    for options in ([], ["--all"]):
        gltf = exported(run, file, *options)
        check_motion(gltf, file)
        at, values = gltf.keys(gltf.node("ball"), "rotation")
        # It falls freely at first.
        early = at < 0.1
        cosine = np.abs(np.sum(values[1:] * values[:-1], axis=1))
        turned = np.sum(2 * np.arccos(np.minimum(cosine, 1))[early[1:]])
        assert turned == pytest.approx(1000 * at[early][-1], rel=1e-3)
        assert np.degrees(2 * np.arccos(np.minimum(cosine, 1))).max() < 91
    validate(file.with_suffix(".glb"))


def test_springs(run, output):
    """Coils reach from point to point of springs, whatever these do, in glTF and VTK; where
    both are at one place there is one about it. Forces are those of the rows."""
    file = output(SPRINGS)
    gltf = exported(run, file)
    validate(file.with_suffix(".glb"))
    done = run("export", file, "--to", "vtk", "--all")
    assert done.status == 0, done.err
    vtk = Vtk(file.with_suffix(".vtkhdf"))
    lines, points = vtk.root["Lines"], vtk.root["Vertices"]
    at, ids = lines["Offsets"][()], lines["Connectivity"][()]
    cells = len(points["Offsets"]) - 1
    assert vtk.cells["kind"][: cells + len(at) - 1].tolist() == [4, 4, 4, 3, 3, 3]
    with h5py.File(file) as data:
        scale, rows, table = drawable.open_run(file, data).scale, data["trajectory"], data["spring"]
        names = table["name"].asstr()[()].tolist()
        assert (names, vtk.file["names/spring"].asstr()[()].tolist()) == (
            ["strut", "link", "mount"],
        ) * 2
        bodies, time = table["bodies"].asstr()[()], rows["time"][()]
        index = {name: i for i, name in enumerate(data["body/name"].asstr()[()])}
        for i, name in enumerate(names):
            ends = []
            for body, key in zip(bodies[i], ("first_point", "second_point"), strict=True):
                place = np.repeat(table[key][i][None], len(time), axis=0)
                if body != "ground":
                    turn = thinning.matrices(rows["quaternion"][:, index[body]])
                    place = rows["position"][:, index[body]] + np.einsum("kij,kj->ki", turn, place)
                ends.append(place)
            node = gltf.node(name)
            assert gltf.nodes[node]["extras"]["bodies"] == bodies[i].tolist()
            begin = gltf.positions(node, time)
            stretch = np.stack([np.interp(time, *x) for x in gltf.lengths(node)], axis=1)[:, 0]
            along = thinning.matrices(gltf.attitudes(node, time))[:, :, 2]
            coil = [begin, begin + stretch[:, None] * along]
            shown = [
                np.stack([vtk.at(k)[ids[at[i] + j]] for k in range(len(time))])
                for j in (0, at[i + 1] - at[i] - 1)
            ]
            for k in (0, 1):
                if name == "mount":
                    # About the middle, and not longer than it is wide.
                    middle = (ends[0] + ends[1]) / 2
                    assert np.linalg.norm(coil[k] - middle, axis=1).max() < 0.03 * scale
                    assert np.linalg.norm(shown[k] - middle, axis=1).max() < 0.03 * scale
                else:
                    assert np.linalg.norm(coil[k] - ends[k], axis=1).max() <= 1e-3 * scale
                    assert np.abs(shown[k] - ends[k]).max() < 1e-6
            # The mesh goes from the one end to the other.
            mesh = gltf.head["meshes"][gltf.nodes[node]["mesh"]]["primitives"][0]
            height = gltf.array(mesh["attributes"]["POSITION"])[:, 2]
            assert (height.min(), height.max()) == pytest.approx((0, 1), abs=0.02)
            held = points["Connectivity"][i]
            for k in (0, 50, 100):
                assert np.abs(vtk.at(k)[held] - ends[1][k]).max() < 1e-6
                force = rows["spring_force"][k, i]
                assert vtk.at(k, "force")[held] == pytest.approx(force, rel=1e-6, abs=1e-6)
        # That of the bushing stays upright.
        assert along[:, 2].min() > 0.9


def test_part_of_a_run(run, output, tmp_path):
    """Times count from the first row that is taken."""
    file = output(ball())
    gltf = exported(run, file, "--from", "0.2", "--until", "0.3")
    at = gltf.keys(gltf.node("ball"), "translation")[0]
    assert (at[0], at[-1]) == (0, pytest.approx(0.1, abs=1e-6))
    extras = gltf.head["asset"]["extras"]
    assert (extras["start"], extras["end"]) == (pytest.approx(0.2), pytest.approx(0.3))
    with h5py.File(file) as data:
        first = data["trajectory/position"][200, 0]
    assert gltf.nodes[gltf.node("ball")]["translation"] == pytest.approx(first.tolist(), abs=1e-7)
    for words in (["--from", "0.3", "--until", "0.2"], ["--from", "7"]):
        done = run("export", file, "--to", "gltf", "-o", "no.glb", *words)
        assert (done.status, (tmp_path / "no.glb").exists()) == (2, False)
        assert "0.3" in done.err or "0 s to 0.5 s" in done.err


def level(shape, sizes, points):
    """A function that is zero on a surface, in its frame, in parts of its size."""
    x, y, z = points.T
    if shape in ("sphere", "ellipsoid"):
        axes = sizes.get("semi_axes", sizes.get("radius"))
        return np.linalg.norm(points / axes, axis=1) - 1
    if shape == "torus":
        across = np.hypot(np.hypot(x, y) - sizes["major_radius"], z)
        return across / sizes["minor_radius"] - 1
    if shape == "cylinder":
        return np.hypot(x, y) / sizes["radius"] - 1
    if shape == "paraboloid":
        return (np.hypot(x, y) ** 2 / (2 * sizes["vertex_radius"]) - z) / sizes["vertex_radius"]
    if shape == "cone":
        return np.hypot(x, y) - z * np.tan(sizes["half_angle"])
    assert shape == "plane"
    return z


def test_every_shape(run, output):
    """No shape of the program is forgotten; points lie on the surfaces, and triangles turn their
    front where their normals point: out of the material."""
    words = run("help", "surface.shape").out.splitlines()[2]
    assert set(re.findall(r"\w+", words.replace("mandatory", ""))) == set(SIZES)
    assert set(meshes.SHAPES) | {"plane"} == set(SIZES)
    scene = "&scene t_end = 1e-3 /\n&material name = 'steel', young = 2e11, poisson = 0.3 /\n"
    for k, (shape, sizes) in enumerate(SIZES.items()):
        scene += f"&body name = 'b_{shape}', mass = 1, inertia = 3*1e-4, position = {k}, 0, 1 /\n"
        tail = f"shape = '{shape}', {sizes}, material = 'steel' /\n"
        scene += f"&surface name = '{shape}', body = 'b_{shape}', centre = 1e-3, 2e-3, 3e-3, {tail}"
        if shape != "plane":
            tail = "side = 'inside', " + tail
        scene += f"&surface name = '{shape}_in', body = 'ground', centre = {k}, 0, 0, {tail}"
    scene += "&output interval = 1e-3 /\n"
    file = output(scene)
    gltf = exported(run, file)
    with h5py.File(file) as data:
        table = data["surface"]
        for i, name in enumerate(table["name"].asstr()[()]):
            shape, axes = table["shape"].asstr()[i], table["axes"][i]
            sizes = {key: table[key][i] for key in surfaces.SIZES if key in table}
            sizes = {key: value for key, value in sizes.items() if np.isfinite(value).all()}
            body = table["body"].asstr()[i]
            points, normals, triangles = gltf.points(gltf.node(name, body))
            assert np.abs(np.linalg.norm(normals, axis=1) - 1).max() < 1e-5
            local = (points - table["centre"][i]) @ axes.T
            off = np.abs(level(shape, sizes, local))
            # Flat ends apart.
            assert np.mean(off < 1e-4) > 0.7
            corners = points[triangles]
            front = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            assert (np.sum(front * normals[triangles].mean(1), axis=1) > 0).all()
            # Out of the material.
            step = 1e-6 * np.abs(local).max()
            beyond = level(shape, sizes, local + step * normals @ axes.T)
            grows = beyond - level(shape, sizes, local)
            grows *= -1 if table["side"].asstr()[i] == "inside" else 1
            flat = (np.abs(normals @ axes[2]) > 1 - 1e-9) & (shape != "plane")
            apex = (np.linalg.norm(local, axis=1) < 1e-6) & (shape == "cone")
            assert (grows > 0)[(off < 1e-4) & ~flat & ~apex].all()
            assert flat.mean() < 0.6
    validate(file.with_suffix(".glb"))


def test_unknown_shape(run, output, tmp_path):
    """A shape of which there is no mesh is named; nothing is written."""
    file = output(ball(end=0.01))
    with h5py.File(file, "r+") as data:
        data["surface/shape"][0] = "heart"
    done = run("export", file, "--to", "gltf")
    assert (done.status, "'skin'" in done.err or "skin" in done.err) == (74, True)
    assert "heart" in done.err
    assert [path.name for path in tmp_path.iterdir() if "glb" in path.name] == []


def test_hostile_names(run, output):
    """Names and titles come back as they are."""
    title = "'" + HOSTILE.replace("'", "''").replace("\x1b", "") + "'"
    file = output(ball(title=title, end=0.01))
    gltf = exported(run, file)
    assert gltf.head["scenes"][0]["name"] == HOSTILE.replace("\x1b", "")
    validate(file.with_suffix(".glb"))


def test_upright(run, output):
    """What is up in the scene is y in glTF."""
    for gravity in ("0, 0, -9.81", "9.81, 0, 0", "0, 9.81, 0", "0, -9.81, 0"):
        gltf = exported(run, output(ball(end=0.01), "--set", f"scene.gravity={gravity}"))
        x, y, z, w = gltf.nodes[0]["rotation"]
        down = np.array([float(word) for word in gravity.split(",")]) / 9.81
        v = np.array([x, y, z])
        turned = down + 2 * np.cross(v, np.cross(v, down) + w * down)
        assert turned == pytest.approx([0, -1, 0], abs=1e-12)


def test_bad_input(run, output, tmp_path):
    """Messages, statuses, and nothing written."""
    file = output(ball(end=0.01))
    before = sorted(tmp_path.iterdir())
    (tmp_path / "text.h5").write_text("no file of HDF5")
    (tmp_path / "cut.h5").write_bytes(file.read_bytes()[:20000])
    (tmp_path / "old.glb").write_text("old")
    for words, status, said in (
        (["none.h5"], 74, "none.h5"),
        (["text.h5"], 74, "text.h5"),
        (["cut.h5"], 74, "cut.h5"),
        (["out.h5", "-o", "old.glb"], 74, "--force"),
        (["out.h5", "-o", "out.h5", "--force"], 2, "out.h5"),
        (["out.h5", "-o", "none/out.glb"], 74, "none/out.glb"),
        (["out.h5", "--columns", "time"], 2, "--columns"),
        (["out.h5", "--from", "x"], 2, "--from"),
        (["out.h5", "--csv"], 2, "two formats"),
    ):
        done = run("export", "--to", "gltf", *words)
        assert (done.status, done.out) == (status, ""), done.err
        assert said in done.err
        assert "Traceback" not in done.err
    for option in ("--from=1", "--until=1", "--all"):
        done = run("export", "out.h5", "--csv", option)
        assert (done.status, option.split("=")[0] in done.err) == (2, True)
    assert (tmp_path / "old.glb").read_text() == "old"
    extra = {tmp_path / name for name in ("text.h5", "cut.h5", "old.glb")}
    assert set(tmp_path.iterdir()) == set(before) | extra


def test_incomplete_run(run, output):
    """What is there is exported, with a warning; the ending tells the format."""
    file = output(ball(end=0.05))
    with h5py.File(file, "r+") as data:
        data.attrs["status"] = "interrupted"
    done = run("export", file, "-o", "so_far.glb")
    assert (done.status, done.out.strip()) == (0, "so_far.glb")
    assert "interrupted" in done.err
    assert "51 rows" in done.err


def test_tool_that_is_missing(executable, output, tmp_path):
    """A program without its tool says what is missing."""
    file = output(ball(end=0.01))
    alone = tmp_path / "alone" / "contensou"
    alone.parent.mkdir()
    shutil.copy2(executable, alone)
    done = subprocess.run(
        [alone, "export", file, "--to", "gltf"],
        capture_output=True,
        text=True,
        check=False,
        env={"PATH": str(alone.parent)},
    )
    assert done.returncode == 74
    assert "contensou-export" in done.stderr


class Vtk:
    """A file of VTKHDF, read by its specification."""

    def __init__(self, path):
        self.file = h5py.File(path)
        self.root = self.file["VTKHDF"]
        assert self.root.attrs["Type"] == b"PolyData"
        self.steps = self.root["Steps"]
        self.times = self.steps["Values"][()]
        self.size = self.root["NumberOfPoints"][0]
        self.cells = {name: data[()] for name, data in self.root["CellData"].items()}

    def at(self, k, name="Points"):
        """Points or vectors of a time."""
        if name == "Points":
            start = self.steps["PointOffsets"][k]
            return self.root[name][start : start + self.size].astype(float)
        start = self.steps[f"PointDataOffsets/{name}"][k]
        return self.root["PointData"][name][start : start + self.size].astype(float)

    def corners(self, kind):
        """Numbers of the points of the cells of a kind: 0 bodies, 1 contacts, 2 spots."""
        group = self.root["Vertices" if kind == 1 else "Polygons"]
        at, ids = group["Offsets"][()], group["Connectivity"][()]
        kinds = self.cells["kind"]
        first = 0 if kind == 1 else len(self.root["Vertices/Offsets"]) - 1
        chosen = np.flatnonzero(kinds[first : first + len(at) - 1] == kind)
        return [ids[at[i] : at[i + 1]] for i in chosen]


@pytest.fixture
def rolling(output):
    """A ball that bounces and slides."""
    return output(ball(end=0.3))


def test_vtk(run, rolling):
    """Bodies move as the rows tell, contacts have their forces, and spots their axes."""
    done = run("export", rolling, "--to", "vtk", "--all")
    assert (done.status, done.err) == (0, "")
    vtk = Vtk(rolling.with_suffix(".vtkhdf"))
    with h5py.File(rolling) as file:
        rows = file["trajectory"]
        assert vtk.times == pytest.approx(rows["time"][()])
        point = vtk.corners(1)[0]
        rim = vtk.corners(2)[0]
        skin = np.unique(np.concatenate(vtk.corners(0)[: np.sum(vtk.cells["number"] == 0) - 2]))
        skin = skin[np.abs(np.linalg.norm(vtk.at(0)[skin] - [0, 0, 0.12], axis=1) - 0.02) < 1e-6]
        assert len(skin) > 1000
        start = vtk.at(0)[skin] - rows["position"][0, 0]
        for k in [0, 100, int(np.argmax(rows["normal_force"][:, 0])), len(vtk.times) - 1]:
            points, force = vtk.at(k), vtk.at(k, "force")
            w, *v = rows["quaternion"][k, 0]
            turned = start + 2 * np.cross(v, np.cross(v, start) + w * start)
            assert np.abs(points[skin] - rows["position"][k, 0] - turned).max() < 1e-7
            normal = rows["normal_force"][k, 0]
            # The floor is the second surface: forces are drawn on the ball.
            expected = -normal * rows["contact_normal"][k, 0] - rows["friction_force"][k, 0]
            assert np.abs(force[point[0]] - expected).max() <= 1e-6 * max(normal, 1e-9)
            assert np.count_nonzero(np.abs(force).sum(1)) == (normal > 0)
            assert np.abs(points[point[0]] - rows["contact_point"][k, 0]).max() < 1e-7
            axes = np.linalg.norm(points[rim] - points[point[0]], axis=1)
            shown = rows["semi_axes"][k, 0] if normal > 0 else np.zeros(2)
            assert (axes.max(), axes.min()) == pytest.approx(tuple(shown), rel=1e-3, abs=1e-8)
            spot = vtk.at(k, "spot_offset")[rim]
            assert np.abs(spot - points[rim] + points[point[0]]).max() < 2e-8
        assert (rows["normal_force"][:, 0] > 0).any()
    names = {name: list(data.asstr()[()]) for name, data in vtk.file["names"].items()}
    assert names == {
        "body": ["ground", "ball"],
        "contact": ["bounce"],
        "spring": [],
        "surface": ["skin", "floor"],
    }


def test_vtk_frames(run, rolling):
    """As many rows as asked for, the first and the last among them."""
    assert run("export", rolling, "-o", "few.vtkhdf", "--frames", "7").status == 0
    vtk = Vtk(rolling.parent / "few.vtkhdf")
    assert (len(vtk.times), vtk.times[0], vtk.times[-1]) == (7, 0, pytest.approx(0.3))
    # What stands still is told once.
    assert vtk.steps["PointDataOffsets/force"][0] == vtk.steps["PointDataOffsets/force"][1] == 0
    done = run("export", rolling, "--to", "gltf", "--frames", "7")
    assert (done.status, "--frames" in done.err) == (2, True)


def test_vtk_of_hollows(run, output):
    """Of a bowl upside down there is an opening, of a bearing all that its balls touch."""
    file = output(ROOT / "inputs" / "bearing_6205.nml", "--set", "scene.t_end=2e-4")
    done = run("export", file, "--to", "vtk", "--frames", "3")
    assert done.status == 0, done.err
    vtk = Vtk(file.with_suffix(".vtkhdf"))
    with h5py.File(file) as data:
        assert set(vtk.cells["number"][vtk.cells["kind"] == 0]) == set(
            range(len(data["surface/name"]))
        )


def test_vtk_reads_it(run, rolling, tmp_path):
    """VTK itself reads the file at any of its times, and draws what is at it."""
    vtk = pytest.importorskip("vtk")
    assert run("export", rolling, "--to", "vtk", "--all").status == 0
    with h5py.File(rolling) as file:
        height = file["trajectory/position"][()][:, 0, 2]
        touch = int(np.argmax(file["trajectory/normal_force"][:, 0]))
    program = tmp_path / "draw.py"
    program.write_text(
        """
import sys, vtk
from vtk.util.numpy_support import vtk_to_numpy
reader = vtk.vtkHDFReader()
reader.SetFileName(sys.argv[1])
reader.UpdateInformation()
times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
window, renderer = vtk.vtkRenderWindow(), vtk.vtkRenderer()
window.SetOffScreenRendering(1)
window.SetSize(200, 200)
window.AddRenderer(renderer)
mapper, actor = vtk.vtkPolyDataMapper(), vtk.vtkActor()
mapper.SetInputConnection(reader.GetOutputPort())
mapper.SetScalarModeToUseCellFieldData()
mapper.SelectColorArray("colour")
mapper.SetColorModeToDirectScalars()
actor.SetMapper(mapper)
renderer.AddActor(actor)
camera = renderer.GetActiveCamera()
camera.SetPosition(0, -0.5, 0.1)
camera.SetFocalPoint(0, 0, 0.1)
camera.SetViewUp(0, 0, 1)
for time in times[0], times[int(sys.argv[2])], times[-1]:
    reader.UpdateTimeStep(time)
    data = reader.GetOutputDataObject(0)
    force = vtk_to_numpy(data.GetPointData().GetArray("force"))
    renderer.ResetCameraClippingRange()
    window.Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.Update()
    pixels = vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).reshape(200, 200, 3)
    blue = (pixels[..., 2].astype(int) > pixels[..., 0] + 30).nonzero()[0]
    print(len(times), data.GetNumberOfCells(), float(abs(force).max()), len(blue), blue.mean())
"""
    )
    done = subprocess.run(
        [sys.executable, program, rolling.with_suffix(".vtkhdf"), str(touch)],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    lines = [list(map(float, line.split())) for line in done.stdout.splitlines()]
    own = Vtk(rolling.with_suffix(".vtkhdf"))
    assert lines[1][2] > 1
    assert vtk.vtkVersion().GetVTKMajorVersion() >= 9
    for k, (steps, cells, force, blue, middle) in zip([0, touch, -1], lines, strict=True):
        assert (steps, cells) == (len(own.times), len(own.cells["kind"]))
        assert force == pytest.approx(np.abs(own.at(k % len(own.times), "force")).max())
        # The ball is drawn where it is.
        assert blue > 100
        scale = 200 / (2 * 0.5 * np.tan(np.radians(15)))
        assert middle == pytest.approx(100 + scale * (height[k] - 0.1), abs=4)
