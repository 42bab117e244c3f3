"""The output file: its content, and that the tools of the trade open it."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import h5netcdf
import h5py
import netCDF4
import numpy as np
import pytest
import xarray
from programs import captured

ROOT = Path(__file__).resolve().parents[2]


def columns_of_the_manual(of_all_scenes=False):
    """The columns that docs/output.md tells of: dimensions (scales of the same group) and units."""
    columns = {}
    for line in (ROOT / "docs" / "output.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("| `/trajectory/"):
            names, dims, units, text = [cell.strip() for cell in line.split("|")[1:5]]
            if of_all_scenes and "only in files of scenes" in text:
                continue
            for name in re.findall(r"`(?:/trajectory/)?(\w+)`", names):
                columns[name] = (tuple(dims.split(", ")[1:]), units)
    return columns


# Data sets of the format with their dimensions and units; None stands for text, which has none.
COLUMNS = columns_of_the_manual()
ASKED_FOR = [name for name in COLUMNS if name.startswith("rolling_") or name.endswith("_creepage")]
TRAJECTORY = {
    name: row
    for name, row in columns_of_the_manual(of_all_scenes=True).items()
    if name not in ASKED_FOR
}
FIXED = {
    "/body/mass": (("name",), "kg"),
    "/body/inertia": (("name", "xyz"), "kg m2"),
    "/material/young": (("name",), "Pa"),
    "/material/poisson": (("name",), "1"),
    "/surface/body": (("name",), None),
    "/surface/shape": (("name",), None),
    "/surface/side": (("name",), None),
    "/surface/material": (("name",), None),
    "/surface/centre": (("name", "xyz"), "m"),
    "/surface/axes": (("name", "axis", "xyz"), "1"),
    "/surface/solid_part": (("name",), None),
    "/surface/solid_length": (("name",), "m"),
    "/contact/surfaces": (("name", "side"), None),
    "/contact/normal": (("name",), None),
    "/contact/damping": (("name",), None),
    "/contact/friction": (("name",), None),
    "/events/kind": (("time",), None),
    "/events/contact": (("time",), None),
    "/summary/position": (("body", "xyz"), "m"),
    "/summary/velocity": (("body", "xyz"), "m s-1"),
    "/summary/angular_velocity": (("body", "xyz"), "rad s-1"),
    "/summary/quaternion": (("body", "wxyz"), "1"),
}
SCALARS = {
    "/integrator/steps": "1",
    "/integrator/right_hand_sides": "1",
    "/integrator/jacobians": "1",
    "/integrator/error_test_failures": "1",
    "/integrator/convergence_failures": "1",
    "/integrator/last_step": "s",
    "/summary/time": "s",
    "/summary/rows": "1",
    "/summary/touches": "1",
    "/summary/lifts": "1",
    "/summary/energy_initial": "J",
    "/summary/energy_error": "J",
    "/summary/energy_error_relative": "1",
    "/summary/work_friction": "J",
    "/summary/work_damping": "J",
    "/summary/work_applied": "J",
    "/summary/steps": "1",
    "/summary/right_hand_sides": "1",
    "/summary/cpu_s": "s",
    "/provenance/wall_s": "s",
    "/provenance/cpu_s": "s",
    "/input/namelist": None,
    "/input/resolved": None,
    "/input/command_line": None,
    "/provenance/compiler": None,
    "/provenance/flags": None,
    "/provenance/host": None,
}
SCALES = {
    "/body/name": None,
    "/body/xyz": None,
    "/material/name": None,
    "/surface/name": None,
    "/surface/xyz": None,
    "/surface/axis": None,
    "/contact/name": None,
    "/contact/side": None,
    "/trajectory/body": None,
    "/trajectory/contact": None,
    "/trajectory/xyz": None,
    "/trajectory/wxyz": None,
    "/trajectory/axis": None,
    "/trajectory/time": "s",
    "/events/time": "s",
    "/summary/body": None,
    "/summary/xyz": None,
    "/summary/wxyz": None,
}

TWO_BODIES = """\
&scene title = 'Zwei Kugeln, µm', gravity = 0, 0, -9.81, t_end = 0.05 /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body name = 'falling', mass = 0.05, inertia = 3*8.0e-6, position = 0, 0, 0.021 /
&body name = 'resting_ball', mass = 0.05, inertia = 3*8.0e-6, position = 1, 0, 0.02 /
&surface name = 'one', body = 'falling', shape = 'sphere', radius = 0.02, material = 'wood' /
&surface name = 'two', body = 'resting_ball', shape = 'sphere', radius = 0.02, material = 'wood' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'wood' /
&contact name = 'first', surfaces = 'one', 'floor', damping = 'viscous', damping_coefficient = 1e4 /
&contact name = 'second', surfaces = 'floor', 'two', damping = 'tsuji', restitution = 0.5,
   friction = 'coulomb', friction_coefficient = 0.2, regularization_velocity = 1e-3 /
&output file = 'two.h5', interval = 1e-3 /
"""
NO_CONTACT = """\
&scene t_end = 0.01 /
&body name = 'stone', mass = 0.3, inertia = 1.0e-4, 2.0e-4, 2.8e-4, velocity = 3, -2, 5,
   spin = 1, 2, 3 /
&output file = 'free.h5', interval = 1e-3 /
"""


@pytest.fixture
def output(run, scene, tmp_path):
    """The file of a complete run of the short Tippe-Top."""
    result = run("run", scene)
    assert result.status == 0, result.err
    return tmp_path / "top.h5"


@pytest.fixture
def output_of(run, tmp_path):
    """Run a scene given as text; the path of its output file."""

    def output_of_it(text, *options):
        path = tmp_path / "scene.nml"
        path.write_text(text, newline="")
        result = run("run", path, "-o", "out.h5", "--force", *options)
        assert result.status == 0, result.err
        return tmp_path / "out.h5"

    return output_of_it


def datasets(file):
    """All data sets of a file by their absolute path."""
    found = {}
    file.visititems(
        lambda name, item: (
            found.update({f"/{name}": item}) if isinstance(item, h5py.Dataset) else None
        )
    )
    return found


def scale_names(dataset):
    """Absolute paths of the scales of a data set, one for each dimension."""
    for dimension in dataset.dims:
        assert len(dimension) == 1, f"{dataset.name} has {len(dimension)} scales on a dimension"
    return [dimension[0].name for dimension in dataset.dims]


def contents(path):
    """What comparisons look at: each data set outside /provenance, CPU seconds excepted."""
    with h5py.File(path) as file:
        return {
            name: (item.asstr()[()] if h5py.check_string_dtype(item.dtype) else item[()])
            for name, item in datasets(file).items()
            if not name.startswith("/provenance/") and "cpu" not in name.rsplit("/", 1)[1]
        }


def assert_same_bits(one, two, names):
    for name in names:
        first, second = np.asarray(one[name]), np.asarray(two[name])
        assert first.dtype == second.dtype, name
        assert first.shape == second.shape, name
        if first.dtype == np.float64:
            first, second = first.view(np.int64), second.view(np.int64)
        assert (first == second).all(), name


# ---- Content -----------------------------------------------------------------------------------


def check_structure(path, rows, bodies, contacts):
    """Every data set of the format, with shape, units, description and scales."""
    sizes = {"body": len(bodies), "contact": len(contacts), "xyz": 3, "wxyz": 4, "axis": 2}
    with h5py.File(path) as file:
        found = datasets(file)
        for name, item in found.items():
            long_name = item.attrs["long_name"]
            assert isinstance(long_name, str), name
            assert long_name, name
            if text := h5py.check_string_dtype(item.dtype):
                assert text.encoding == "utf-8", name
                assert text.length is None, name  # variable length
                assert "units" not in item.attrs, name
            else:
                assert isinstance(item.attrs["units"], str), name
        for name, (dims, units) in TRAJECTORY.items():
            item = found[f"/trajectory/{name}"]
            assert item.dtype == np.dtype("<f8"), name
            assert item.shape == (rows, *(sizes[dim] for dim in dims)), name
            assert item.attrs["units"] == units, name
            if name != "time":
                scales = [f"/trajectory/{dim}" for dim in ("time", *dims)]
                assert scale_names(item) == scales, name
        for name, (dims, units) in FIXED.items():
            item = found[name]
            assert item.attrs.get("units") == units, name
            group = name.rsplit("/", 1)[0]
            assert scale_names(item) == [f"{group}/{dim}" for dim in dims], name
            for size, scale in zip(item.shape, dims, strict=True):
                assert size == len(found[f"{group}/{scale}"]), name
        for name, units in SCALARS.items():
            assert found[name].shape == (), name
            assert found[name].attrs.get("units") == units, name
        for name, units in SCALES.items():
            assert h5py.h5ds.is_scale(found[name].id), name
            assert found[name].attrs.get("units") == units, name
        for name in ("/body/name", "/trajectory/body", "/summary/body"):
            assert list(found[name].asstr()) == list(bodies)
        for name in ("/contact/name", "/trajectory/contact"):
            assert list(found[name].asstr()) == list(contacts)
        assert list(found["/trajectory/xyz"].asstr()) == ["x", "y", "z"]
        assert list(found["/trajectory/wxyz"].asstr()) == ["w", "x", "y", "z"]
        assert list(found["/trajectory/axis"].asstr()) == ["major", "minor"]
        assert list(found["/contact/side"].asstr()) == ["A", "B"]
        # Nothing is here that the tables above, and so the format's description, do not name.
        known = {f"/trajectory/{name}" for name in TRAJECTORY} | FIXED.keys()
        known |= SCALARS.keys() | SCALES.keys()
        if len(found["/surface/name"]):
            assert scale_names(found["/surface/radius"]) == ["/surface/name"]
            assert found["/surface/radius"].attrs["units"] == "m"
            known.add("/surface/radius")
        known |= {"/integrator/method", "/integrator/method_since"}
        assert file["/integrator/method"].shape == file["/integrator/method_since"].shape == (1,)
        others = {name for name in found.keys() - known if not name.startswith("/provenance/")}
        assert {name for name in others if "cpu" not in name} == set()
        for name, attribute in check_attributes(file).items():
            assert isinstance(attribute, str), name


def check_attributes(file):
    """The attributes of the root, all text."""
    attributes = dict(file.attrs)
    assert attributes["filetype"] == "contensou-trajectory"
    assert re.fullmatch(r"\d+\.\d+", attributes["filetype_version"])
    assert re.fullmatch(r"\d+\.\d+\.\d+", attributes["program_version"])
    assert attributes["git_commit"]
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", attributes["created"])
    assert attributes["status"] == "complete"
    return attributes


def test_every_data_set_of_the_format(output):
    check_structure(output, 21, ["top"], ["ball_floor", "stem_floor"])
    with h5py.File(output) as file:
        assert file.attrs["title"] == "Tippe-Top"
        assert list(file["/body/mass"]) == [6.0e-3]
        assert file["/body/inertia"][()].tolist() == [[8.0e-7, 8.0e-7, 7.0e-7]]
        surfaces = file["/contact/surfaces"].asstr()[()].tolist()
        assert surfaces == [["ball", "floor"], ["stem", "floor"]]
        assert file["/contact/friction"].asstr()[()].tolist() == ["contensou_exact"] * 2
        assert file["/contact/damping"].asstr()[()].tolist() == ["hunt_crossley"] * 2
        assert file["/contact/normal"].asstr()[()].tolist() == ["hertz"] * 2


def test_scales_name_the_dimensions_that_have_them(output):
    with h5py.File(output) as file:
        found = datasets(file)
        expected = {}
        for name, item in found.items():
            for i, dimension in enumerate(item.dims):
                for scale in dimension.values():
                    assert h5py.h5ds.is_attached(item.id, scale.id, i), f"{name}, {scale.name}"
                    expected.setdefault(scale.name, []).append((name, i))
        assert len(expected["/trajectory/time"]) == len(TRAJECTORY) - 1
        for name, item in found.items():
            uses = item.attrs.get("REFERENCE_LIST", ())
            listed = [(file[dataset].name, int(i)) for dataset, i in uses]
            assert sorted(listed) == sorted(expected.get(name, [])), name


def test_columns_of_a_driven_scene_are_those_of_the_manual(run, tmp_path):
    path = tmp_path / "bearing.h5"
    scene = ROOT / "inputs" / "bearing_6205.nml"
    short = ("--set", "scene.t_end=1e-6", "--set", "output.rolling=.true.")
    assert run("run", str(scene), "-q", "-o", str(path), *short).status == 0
    with h5py.File(path) as file:
        group = file["trajectory"]
        scales = {"body", "contact", "xyz", "wxyz", "axis"}
        # It has neither springs nor curved spots.
        others = {"spring_force", "spring_torque", "spot_moment"}
        assert group.keys() - scales == COLUMNS.keys() - others
        for name, (dims, units) in COLUMNS.items():
            if name in others:
                continue
            assert group[name].attrs["units"] == units, name
            scales = [f"/trajectory/{dim}" for dim in ("time", *dims)]
            assert name == "time" or scale_names(group[name]) == scales, name


def test_what_rolls(run, tmp_path):
    """A ball slides, then rolls: its creepages are those of its slip and the mean of the speeds."""
    path = tmp_path / "bowling.h5"
    scene = ROOT / "inputs" / "bowling.nml"
    assert (
        run("run", str(scene), "-q", "-o", str(path), "--set", "output.rolling=.true.").status == 0
    )
    with h5py.File(path) as file:
        assert len(ASKED_FOR) == 4
        rows = {name: file["trajectory"][name][:] for name in file["trajectory"]}
    slip, rolling = rows["slip_velocity"][:, 0], rows["rolling_velocity"][:, 0]
    # A is the ball: the material of the lane passes with -V, that of the ball with the slip less.
    speed = rows["velocity"][:, 0, 0]
    np.testing.assert_allclose(rolling[:, 0], -(speed + 0.5 * slip[:, 0]), rtol=1e-9)
    assert abs(rolling[:, 1:]).max() == 0.0
    creepage = -slip[:, 0] / rolling[:, 0]
    np.testing.assert_allclose(rows["longitudinal_creepage"][:, 0], creepage, rtol=1e-12)
    assert rows["longitudinal_creepage"][0, 0] == pytest.approx(-2.0)
    assert not rows["longitudinal_creepage"][-1, 0]
    assert abs(rows["lateral_creepage"]).max() == abs(rows["spin_creepage"]).max() == 0.0


def test_creepages_of_what_is_at_rest(run, tmp_path):
    path = tmp_path / "spinning.h5"
    scene = ROOT / "inputs" / "spinning_ball.nml"
    values = ("scene.t_end=1e-3", "output.rolling=.true.", "ball.velocity=0.0, 0.0, 0.0")
    options = [word for value in values for word in ("--set", value)]
    assert run("run", str(scene), "-q", "-o", str(path), *options).status == 0
    with h5py.File(path) as file:
        rows = file["trajectory"]
        assert abs(rows["rolling_velocity"][:]).max() == 0.0
        assert np.isnan(rows["spin_creepage"][:]).all()


def test_cpu_seconds_by_effect(output):
    with h5py.File(output) as file:
        assert [name for name in file["/integrator"] if "cpu" in name]


def test_several_bodies(output_of):
    path = output_of(TWO_BODIES)
    check_structure(path, 51, ["falling", "resting_ball"], ["first", "second"])
    with h5py.File(path) as file:
        assert file.attrs["title"] == "Zwei Kugeln, µm"
        kinds = file["/events/kind"].asstr()[()]
        assert set(kinds) <= {"touch", "lift"}
        assert kinds[0] == "touch"
        assert file["/events/contact"].asstr()[0] == "first"
        assert (np.diff(file["/events/time"]) >= 0.0).all()
        assert file["/summary/touches"][()] == (kinds == "touch").sum()
        assert file["/summary/lifts"][()] == (kinds == "lift").sum()
        assert file["/contact/surfaces"].asstr()[1].tolist() == ["floor", "two"]
        assert file["/contact/friction"].asstr()[()].tolist() == ["none", "coulomb"]
    with xarray.open_dataset(path, group="trajectory", engine="h5netcdf") as data:
        falling = data.position.sel(body="falling", xyz="z")
        resting = data.position.sel(body="resting_ball", xyz="z")
        assert float(falling[0]) == 0.021
        assert float(resting[0]) == 0.02
        assert float(data.position.sel(body="resting_ball", xyz="x")[-1]) == pytest.approx(1.0)


def test_no_contacts(output_of):
    path = output_of(NO_CONTACT)
    check_structure(path, 11, ["stone"], [])
    with h5py.File(path) as file:
        assert file["/trajectory/gap"].shape == (11, 0)
        assert file["/events/time"].shape == (0,)
        assert not file["/trajectory/energy_elastic"][()].any()
    for engine in ("h5netcdf", "netcdf4"):
        with xarray.open_dataset(path, group="trajectory", engine=engine) as data:
            assert data.sizes["contact"] == 0
            assert float(data.velocity.sel(body="stone", xyz="y")[5]) == pytest.approx(-2.0)


def test_no_events(output_of, scene_text):
    path = output_of(
        scene_text.replace("t_end = 0.02", "t_end = 2e-3").replace("0.0120149", "0.0220149")
    )
    with h5py.File(path) as file:
        for name in ("time", "kind", "contact"):
            assert file[f"/events/{name}"].shape == (0,)
        assert file["/summary/touches"][()] == 0
    for engine in ("h5netcdf", "netcdf4"):
        with xarray.open_dataset(path, group="events", engine=engine) as data:
            assert data.sizes["time"] == 0


def test_summary_is_the_last_row(output):
    with h5py.File(output) as file:
        summary, rows = file["summary"], file["trajectory"]
        for name in ("position", "velocity", "angular_velocity", "quaternion"):
            np.testing.assert_allclose(summary[name][()], rows[name][-1], rtol=1e-9, atol=1e-12)
        assert summary["time"][()] == rows["time"][-1] == 0.02
        assert summary["rows"][()] == len(rows["time"])
        assert summary["energy_error"][()] == np.abs(rows["energy_error"][()]).max()
        assert summary["work_friction"][()] == rows["work_friction"][-1]
        assert summary["steps"][()] == file["/integrator/steps"][()] > 10
        assert file["/integrator/last_step"][()] > 0.0
        assert file["/integrator/right_hand_sides"][()] > file["/integrator/steps"][()]


def test_rows_agree_with_each_other(output):
    with h5py.File(output) as file:
        rows = {name: file["trajectory"][name][()] for name in TRAJECTORY}
    closed = rows["gap"] < 0.0
    assert closed[-1, 0]
    assert not closed[:, 1].any()
    for name in ("normal_force", "friction_torque", "spin"):
        assert not rows[name][~closed].any(), name
    for name in ("friction_force", "slip_velocity", "semi_axes"):
        assert not rows[name][~closed].any(), name
    # The floor is body B, below the ball: forces are those on the floor, in its plane.
    assert (rows["normal_force"][closed] >= 0.0).all()
    assert np.abs(rows["friction_force"][..., 2]).max() <= 1e-15
    assert (rows["semi_axes"][closed][:, 0] == rows["semi_axes"][closed][:, 1]).all()
    # z of the lowest point of the ball.
    w, x, y, z = rows["quaternion"][:, 0].T
    centre = rows["position"][:, 0, 2] + 3e-3 * (1.0 - 2.0 * (x * x + y * y))
    np.testing.assert_allclose(rows["gap"][:, 0], centre - 0.015, rtol=0, atol=1e-16)
    np.testing.assert_allclose(w * w + x * x + y * y + z * z, 1.0, rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("t_end", "interval", "times"),
    [
        (0.01, 0.003, [0.0, 0.003, 0.006, 0.009, 0.01]),
        (0.01, 0.005, [0.0, 0.005, 0.01]),
        (0.01, 0.01, [0.0, 0.01]),
        (0.01, 1.0, [0.0, 0.01]),
        (0.3e-2, 0.1e-2, [0.0, 0.1e-2, 0.2e-2, 0.3e-2]),
    ],
)
def test_rows_are_at_multiples_of_the_interval_and_at_the_end(output_of, t_end, interval, times):
    path = output_of(
        NO_CONTACT, "--set", f"scene.t_end={t_end}", "--set", f"output.interval={interval}"
    )
    with h5py.File(path) as file:
        np.testing.assert_allclose(file["/trajectory/time"][()], times, rtol=1e-15)


def test_many_rows_fill_several_chunks(output_of):
    # Chunks hold 512 rows: none, one, and many, full or not.
    for rows in (511, 512, 513, 1500):
        path = output_of(NO_CONTACT, "--set", f"output.interval={0.01 / (rows - 1)!r}")
        with h5py.File(path) as file:
            time = file["/trajectory/time"][()]
            assert len(time) == rows
            np.testing.assert_allclose(time, np.linspace(0.0, 0.01, rows), rtol=0, atol=1e-15)
            velocity = file["/trajectory/velocity"]
            assert velocity.shape == (rows, 1, 3)
            np.testing.assert_allclose(velocity[:, 0, 0], 3.0)
            assert velocity.maxshape[0] is None
            assert velocity.chunks[0] >= 256


@pytest.mark.parametrize("rows", [2, 3, 5, 12, 721, 4097])
def test_chunks_are_those_that_hdf5_writes(output_of, tmp_path, scene_text, rows):
    """Bytes and checksums of whole chunks and of the last one, which is not."""
    path = output_of(scene_text, "--set", f"output.interval={0.02 / (rows - 1)!r}")
    with h5py.File(path) as file, h5py.File(tmp_path / "hdf5.h5", "w") as other:
        columns = [data for data in file["/trajectory"].values() if data.chunks]
        assert len(columns) == len(TRAJECTORY)
        for data in columns:
            assert data.fletcher32, data.name
            assert data.shape[0] == rows
            copy = other.create_dataset(
                data.name,
                data=data[()],
                maxshape=(None, *data.shape[1:]),
                chunks=data.chunks,
                fletcher32=True,
            )
            for start in range(0, rows, data.chunks[0]):
                place = (start, *(0 for _ in data.shape[1:]))
                found = data.id.read_direct_chunk(place)
                assert found == copy.id.read_direct_chunk(place), data.name
        assert max(data.shape[0] / data.chunks[0] for data in columns) > (1 if rows > 4096 else 0)


@pytest.mark.parametrize("wall", ["0", "0.002"])
def test_rows_that_were_flushed_in_parts(output_of, tmp_path, scene_text, wall):
    """Each flush ends a chunk early, and the rows after it complete it."""
    options = ("--set", "output.interval=1.0e-6", "--set", "scene.t_end=0.006")
    expected = contents(output_of(scene_text, *options))
    found = contents(output_of(scene_text, *options, "--checkpoint", wall))
    names = [name for name in expected if name.startswith(("/trajectory/", "/events/"))]
    assert len(expected["/trajectory/time"]) == 6001
    assert_same_bits(expected, found, [name for name in names if expected[name].dtype == float])


# ---- Programs ----------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_xarray_selects_by_label(output, engine):
    with xarray.open_dataset(output, group="trajectory", engine=engine) as data:
        for scale in ("body", "contact", "xyz", "wxyz", "axis"):
            assert all(isinstance(label, str) for label in data[scale].values), scale
        height = data.position.sel(body="top", xyz="z")
        assert height.dims == ("time",)
        assert height.attrs["units"] == "m"
        assert float(height[0]) == 0.0120149875041659
        gap = data.gap.sel(contact="stem_floor")
        assert float(gap[0]) == pytest.approx(0.0229350541, rel=1e-8)
        assert float(data.semi_axes.sel(contact="ball_floor", axis="minor")[-1]) > 0.0
        assert data.quaternion.sel(wxyz="w").sizes == {"time": 21, "body": 1}
        assert float(data.energy_kinetic.sel(time=0.01, method="nearest")) > 0.0
    with xarray.open_dataset(output, group="events", engine=engine) as data:
        assert {"kind", "contact", "time"} <= data.variables.keys()
        assert data.kind.dims == ("time",)
        assert all(isinstance(label, str) for label in data.kind.values)
    with xarray.open_dataset(output, group="body", engine=engine) as data:
        assert float(data.inertia.sel(name="top", xyz="z")) == 7.0e-7
    with xarray.open_dataset(output, group="contact", engine=engine) as data:
        assert data.surfaces.sel(name="stem_floor", side="A").item() == "stem"
    with xarray.open_dataset(output, group="summary", engine=engine) as data:
        assert float(data.time) == 0.02
    with xarray.open_dataset(output, engine=engine) as data:
        assert data.attrs["status"] == "complete"


def test_xarray_opens_all_groups_at_once(output):
    with xarray.open_datatree(output, engine="h5netcdf") as tree:
        assert {"trajectory", "events", "body", "contact", "integrator", "summary", "input"} <= set(
            tree.children
        )
        assert tree["trajectory"].gap.sel(contact="ball_floor").size == 21


def test_netcdf4(output):
    with netCDF4.Dataset(output) as data:
        assert data.status == "complete"
        group = data["trajectory"]
        assert group.dimensions["time"].isunlimited()
        for name, (dims, units) in TRAJECTORY.items():
            assert group[name].dimensions == ("time", *dims), name
            assert group[name].units == units, name
        assert list(group["contact"][:]) == ["ball_floor", "stem_floor"]
        assert group["gap"][0, 0] == pytest.approx(0.0, abs=1e-15)
        assert str(data["input"]["namelist"][...]).startswith("&scene")
        assert data["events"]["kind"].dimensions == ("time",)


def test_h5netcdf(output):
    with h5netcdf.File(output) as data:
        assert data["trajectory"]["position"].dimensions == ("time", "body", "xyz")


def test_h5dump(output):
    if shutil.which("h5dump") is None:
        pytest.skip("there is no h5dump")
    done = captured(["h5dump", str(output)])
    assert done.returncode == 0
    assert done.stderr == ""
    assert 'DATASET "semi_axes"' in done.stdout
    assert '"contensou-trajectory"' in done.stdout
    assert '"ball_floor"' in done.stdout


def test_nexus_finds_what_to_plot(output):
    with h5py.File(output) as file:
        assert file.attrs["NX_class"] == "NXroot"
        group = file[file.attrs["default"]]
        assert group.attrs["NX_class"] == "NXdata"
        signal = group[group.attrs["signal"]]
        axes = np.atleast_1d(group.attrs["axes"])
        assert len(axes) == signal.ndim
        for axis, size in zip(axes, signal.shape, strict=True):
            assert len(group[axis]) == size
            assert group[axis].dtype == np.float64
        for name in np.atleast_1d(group.attrs["auxiliary_signals"]):
            assert group[name].shape == signal.shape


# ---- Input and repetition ----------------------------------------------------------------------


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text,
        lambda text: text.rstrip("\n"),
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text + "\n\n! Ende, µ und ω\n\t\n",
    ],
    ids=["plain", "no last newline", "carriage returns", "comments"],
)
def test_the_namelist_is_the_exact_text(output_of, scene_text, change):
    text = change(scene_text)
    with h5py.File(output_of(text)) as file:
        assert file["/input/namelist"].asstr()[()] == text


def test_the_command_line_is_kept(run, scene, tmp_path):
    result = run("run", scene, "-o", "other name.h5", "--set", "integrator.rtol=1e-6", "-q")
    assert result.status == 0
    with h5py.File(tmp_path / "other name.h5") as file:
        command = file["/input/command_line"].asstr()[()]
    assert command.startswith("contensou run ")
    assert str(scene) in command
    assert "--set integrator.rtol=1e-6" in command
    assert re.search(r"-o ['\"]other name\.h5['\"]", command)


@pytest.mark.parametrize("method", ["cvode_bdf", "cvode_adams", "explicit8"])
@pytest.mark.parametrize("text", [None, TWO_BODIES, NO_CONTACT], ids=["top", "two bodies", "free"])
def test_the_same_input_gives_the_same_bits(run, tmp_path, scene_text, text, method):
    (tmp_path / "scene.nml").write_text(text or scene_text)
    options = ("--set", f"integrator.method = '{method}'")
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        result = run("run", "../scene.nml", "-o", "out.h5", *options, cwd=tmp_path / name)
        assert result.status == 0, result.err
    one, two = contents(tmp_path / "one" / "out.h5"), contents(tmp_path / "two" / "out.h5")
    assert one.keys() == two.keys()
    assert_same_bits(one, two, one.keys())


@pytest.mark.parametrize("text", [None, TWO_BODIES, NO_CONTACT], ids=["top", "two bodies", "free"])
def test_the_resolved_input_gives_the_same_run(run, tmp_path, scene_text, text):
    (tmp_path / "scene.nml").write_text(text or scene_text)
    first = run("run", "scene.nml", "-o", "one.h5", "--set", "integrator.rtol=1e-7")
    assert first.status == 0, first.err
    one = contents(tmp_path / "one.h5")
    (tmp_path / "resolved.nml").write_text(str(one["/input/resolved"]))
    second = run("run", "resolved.nml", "-o", "two.h5")
    assert second.status == 0, second.err
    two = contents(tmp_path / "two.h5")
    names = [name for name in one if not name.startswith("/input/")]
    assert_same_bits(one, two, names)
    # What is resolved once is resolved for good.
    resolved = str(one["/input/resolved"]).replace("one.h5", "two.h5")
    assert str(two["/input/resolved"]) == resolved


def test_the_resolved_input_names_the_defaults(output_of):
    text = re.sub(r", interval = \S+", "", NO_CONTACT)
    with h5py.File(output_of(text)) as file:
        resolved = file["/input/resolved"].asstr()[()]
    for key in (
        "gravity = 0.0, 0.0, 0.0",
        "method = 'cvode_bdf'",
        "rtol = 1.0e-8",
        "position = 0.0",
    ):
        assert key in resolved
    assert re.search(r"interval = (1\.0e-5|0\.00001)", resolved)
    assert "length_scale" in resolved


# ---- Names -------------------------------------------------------------------------------------


def test_the_output_of_the_scene_is_relative_to_the_current_folder(run, scene, tmp_path):
    here = tmp_path / "elsewhere"
    here.mkdir()
    assert run("run", scene, cwd=here).status == 0
    assert (here / "top.h5").is_file()
    assert not (tmp_path / "top.h5").exists()
    assert sorted(path.name for path in here.iterdir()) == ["top.h5"]


def test_the_name_comes_from_the_scene_file_by_default(run, scene_text, tmp_path):
    folder, here = tmp_path / "scenes", tmp_path / "here"
    folder.mkdir()
    here.mkdir()
    (folder / "spin.case-1.nml").write_text(scene_text.replace("file = 'top.h5', ", ""))
    assert run("run", "../scenes/spin.case-1.nml", cwd=here).status == 0
    assert [path.name for path in here.iterdir()] == ["spin.case-1.h5"]


def test_the_option_wins_over_the_scene(run, scene, tmp_path):
    (tmp_path / "sub").mkdir()
    result = run("run", scene, "-o", "sub/other.h5")
    assert result.status == 0
    assert (tmp_path / "sub" / "other.h5").is_file()
    assert not (tmp_path / "top.h5").exists()
    assert "sub/other.h5" in result.out


def test_an_existing_file_is_not_touched(run, scene, tmp_path):
    path = tmp_path / "top.h5"
    path.write_bytes(b"years of work")
    before = path.stat()
    result = run("run", scene)
    assert result.status == 74
    assert result.out == ""
    assert "top.h5" in result.err
    assert "--force" in result.err
    after = path.stat()
    assert path.read_bytes() == b"years of work"
    assert (after.st_mtime_ns, after.st_ino) == (before.st_mtime_ns, before.st_ino)
    assert not (tmp_path / "top.h5.part").exists()

    result = run("run", scene, "--force")
    assert result.status == 0, result.err
    with h5py.File(path) as file:
        assert file.attrs["status"] == "complete"


def test_a_forced_run_leaves_the_old_file_until_it_is_complete(run, scene, output):
    before = output.read_bytes()
    # Pressed into the floor the ball is thrown against it too fast in the end.
    result = run("run", scene, "--force", "--set", "wood.young=1e4", "--set", "top.velocity=0,0,-3")
    assert result.status == 1
    assert output.read_bytes() == before
