"""What a file says to draw a run, against geometry done here: surfaces, contact points, normals and
the axes of spots."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
GEOMETRY = ("contact_point", "contact_normal", "major_direction")

SHAPES = """\
&scene gravity = 0, 0, -9.81, t_end = 2e-3 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&material name = 'soft', young = 1e7, poisson = 0.4 /
&body name = 'bowl', density = 1000, solid_part = 'lower_half', place = 'touch' /
&surface name = 'bowl_hull', body = 'bowl', shape = 'sphere', radius = 0.03, material = 'soft' /
&body name = 'rod', density = 1000, solid = 'rod_skin', solid_length = 0.2, position = 1, 0, 0.5 /
&surface name = 'rod_skin', body = 'rod', shape = 'cylinder', radius = 0.01, material = 'steel' /
&surface name = 'axle', body = 'rod', shape = 'cylinder', radius = 0.002, direction = 1, 2, 2,
   material = 'steel' /
&body name = 'ball', mass = 0.1, inertia = 3*1e-5, position = 0, 1, 0.0499 /
&surface name = 'ball_skin', body = 'ball', shape = 'sphere', radius = 0.01, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /
&surface name = 'bore', body = 'ground', shape = 'torus', major_radius = 1, minor_radius = 0.05,
   centre = 0, 0, 0.09, side = 'inside', material = 'steel' /
&surface name = 'funnel', body = 'ground', shape = 'cone', half_angle = 0.5, centre = 5, 0, 0,
   side = 'inside', material = 'steel' /
&surface name = 'dish', body = 'ground', shape = 'paraboloid', vertex_radius = 0.2,
   centre = 9, 0, 0, side = 'inside', material = 'soft' /
&contact name = 'bowl_floor', surfaces = 'bowl_hull', 'floor' /
&contact name = 'ball_bore', surfaces = 'ball_skin', 'bore' /
&output interval = 1e-4 /
"""


def rotation(quaternion):
    """Rotation matrix of a quaternion w, x, y, z."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


class Place:
    """A surface of a file at a row: points into its frame, and its implicit function."""

    def __init__(self, file, name, row):
        surface = file["surface"]
        at = list(surface["name"].asstr()).index(name)
        self.shape = surface["shape"].asstr()[at]
        self.sign = -1 if surface["side"].asstr()[at] == "inside" else 1
        self.size = {
            key: surface[key][at]
            for key in ("radius", "semi_axes", "major_radius", "minor_radius")
            if key in surface
        }
        axes, centre = surface["axes"][at].T, surface["centre"][at]
        body = surface["body"].asstr()[at]
        if body != "ground":
            number = list(file["body/name"].asstr()).index(body)
            turn = rotation(file["trajectory/quaternion"][row, number])
            axes = turn @ axes
            centre = file["trajectory/position"][row, number] + turn @ centre
        self.axes, self.centre = axes, centre

    def level(self, point):
        """A function that is zero on the surface and grows out of the material."""
        x, y, z = self.axes.T @ (point - self.centre)
        if self.shape == "sphere":
            value = np.sqrt(x * x + y * y + z * z) - self.size["radius"]
        elif self.shape == "plane":
            value = z
        elif self.shape == "ellipsoid":
            value = np.sqrt(np.sum((np.array([x, y, z]) / self.size["semi_axes"]) ** 2)) - 1
        else:
            assert self.shape == "torus"
            value = np.hypot(np.hypot(x, y) - self.size["major_radius"], z)
            value -= self.size["minor_radius"]
        return self.sign * value

    def slope(self, point):
        """Gradient and second derivatives of it, by differences."""
        h = 1e-5
        unit = h * np.eye(3)
        first = np.array([self.level(point + u) - self.level(point - u) for u in unit]) / (2 * h)
        second = np.array(
            [
                [
                    self.level(point + u + v)
                    - self.level(point + u - v)
                    - self.level(point - u + v)
                    + self.level(point - u - v)
                    for v in unit
                ]
                for u in unit
            ]
        )
        return first, second / (4 * h * h)

    def bend(self, point):
        """Derivative of the unit normal, and that normal."""
        first, second = self.slope(point)
        length = np.linalg.norm(first)
        return second / length, first / length


def check_contact(file, contact, row):
    """Point, normal and directions of a contact that is closed, from the two surfaces alone."""
    rows = file["trajectory"]
    names = list(file["contact/name"].asstr())
    at = names.index(contact)
    first, second = (
        Place(file, name, row) for name in file["contact/surfaces"].asstr()[at].tolist()
    )
    point, normal, major = (rows[name][row, at] for name in GEOMETRY)
    gap = rows["gap"][row, at]
    assert abs(np.linalg.norm(normal) - 1) < 1e-12
    assert abs(np.linalg.norm(major) - 1) < 1e-12
    assert abs(normal @ major) < 1e-12
    bend_a, normal_a = first.bend(point)
    bend_b, normal_b = second.bend(point)
    # The point lies between the two surfaces, whose normals are opposite there.
    for place in (first, second):
        slope = np.linalg.norm(place.slope(point)[0])
        assert abs(place.level(point) / slope) <= abs(gap) * 1.01 + 1e-9
    assert normal == pytest.approx(normal_a, abs=1e-5)
    assert normal == pytest.approx(-normal_b, abs=1e-5)
    # The spot is long where the surfaces come apart slowest.
    minor = np.cross(normal, major)
    apart = bend_a + bend_b
    along, across = major @ apart @ major, minor @ apart @ minor
    mixed = major @ apart @ minor
    assert along <= across * (1 + 1e-3)
    if across > along * 1.01:
        assert abs(mixed) < 1e-3 * (across - along)
    a, b = rows["semi_axes"][row, at]
    if gap < 0:
        assert a >= b > 0


@pytest.mark.parametrize("scene", ["tippe_top", "rattleback", "bearing_6205", "ellipsoid_egg"])
def test_contacts_of_shipped_scenes(run, tmp_path, scene):
    done = run(
        *("run", ROOT / "inputs" / f"{scene}.nml", "-q", "-o", "out.h5"),
        *("--set", "scene.t_end=2e-2", "--set", "output.interval=2e-3"),
    )
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "out.h5") as file:
        closed = file["trajectory/gap"][()] < 0
        assert closed.any()
        for row, at in np.argwhere(closed)[::7]:
            check_contact(file, file["contact/name"].asstr()[int(at)], int(row))


def test_open_contacts_have_a_place(run, tmp_path):
    done = run(
        "run", ROOT / "inputs" / "bouncing_ball.nml", "-q", "-o", "out.h5", "--set", "scene.t_end=1"
    )
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "out.h5") as file:
        rows = file["trajectory"]
        gap = rows["gap"][:, 0]
        assert gap.max() > 0
        for row in (int(gap.argmax()), 1):
            place = Place(file, file["contact/surfaces"].asstr()[0, 0], row)
            other = Place(file, file["contact/surfaces"].asstr()[0, 1], row)
            point = rows["contact_point"][row, 0]
            flat = other if other.shape == "plane" else place
            assert min(abs(place.level(point)), abs(other.level(point))) < 1e-9
            assert abs(flat.level(point)) == pytest.approx(abs(gap[row]), abs=1e-9)


def test_sizes_sides_and_solids(run, tmp_path):
    (tmp_path / "scene.nml").write_text(SHAPES)
    done = run("run", "scene.nml", "-q", "-o", "out.h5")
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "out.h5") as file:
        surface = file["surface"]
        names = list(surface["name"].asstr())
        at = names.index
        units = {"radius": "m", "major_radius": "m", "minor_radius": "m", "half_angle": "rad"}
        units["vertex_radius"] = "m"
        for key, unit in units.items():
            assert surface[key].attrs["units"] == unit
        assert surface["radius"][at("rod_skin")] == 0.01
        assert np.isnan(surface["radius"][at("floor")])
        assert np.isnan(surface["radius"][at("bore")])
        bore = [surface[key][at("bore")] for key in ("major_radius", "minor_radius")]
        assert bore == [1, 0.05]
        assert surface["half_angle"][at("funnel")] == 0.5
        assert surface["vertex_radius"][at("dish")] == 0.2
        sides = dict(zip(names, surface["side"].asstr(), strict=True))
        assert [name for name, side in sides.items() if side == "inside"] == names[5:]
        bodies = surface["body"].asstr()[:].tolist()
        assert bodies == ["bowl", "rod", "rod", "ball", *4 * ["ground"]]
        assert surface["material"].asstr()[:].tolist()[:2] == ["soft", "steel"]
        assert file["material/young"][()].tolist() == [2.1e11, 1e7]
        assert file["material/poisson"][()].tolist() == [0.3, 0.4]
        # The half ball hangs below its centre, which lies 3/8 of its radius above its own.
        assert surface["solid_part"].asstr()[:].tolist() == ["lower_half", "whole", *6 * [""]]
        assert surface["centre"][at("bowl_hull")] == pytest.approx([0, 0, 3 / 8 * 0.03])
        assert surface["solid_length"][at("rod_skin")] == 0.2
        assert np.isnan(np.delete(surface["solid_length"][()], at("rod_skin"))).all()
        axes = surface["axes"][at("axle")]
        assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-14)
        assert axes[2] == pytest.approx(np.array([1, 2, 2]) / 3)
        assert surface["centre"][at("dish")].tolist() == [9, 0, 0]


def test_rows_without_geometry(run, tmp_path, scene):
    (tmp_path / "with").mkdir()
    (tmp_path / "without").mkdir()
    off = ("--set", "output.contact_geometry = .false.")
    sizes = []
    for folder, options in (("with", ()), ("without", off)):
        done = run("run", scene, "-q", *options, cwd=tmp_path / folder)
        assert done.status == 0, done.err
        told = run("check", scene, "--set", "output.interval = 1e-6", *options)
        assert told.status == 0, told.err
        sizes.append(float(re.search(r"output +20001 rows, ([\d.]+) MB", told.out)[1]))
    # Nine numbers of eight bytes for each of the two contacts.
    assert sizes[0] - sizes[1] == pytest.approx(20001 * 2 * 72 / 1e6, abs=0.11)
    with (
        h5py.File(tmp_path / "with" / "top.h5") as full,
        h5py.File(tmp_path / "without" / "top.h5") as less,
    ):
        assert full["trajectory"].keys() - less["trajectory"].keys() == set(GEOMETRY)
        assert less["surface"].keys() == full["surface"].keys()
        for name in less["trajectory"]:
            one, two = full["trajectory"][name][()], less["trajectory"][name][()]
            assert one.tobytes() == two.tobytes() or one.dtype == object, name


def test_spots_without_a_place_have_none(run, tmp_path):
    scene = """\
&scene t_end = 1e-3 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ring', mass = 0.1, inertia = 3*1e-5, position = 0, 0, 0.03 /
&surface name = 'tube', body = 'ring', shape = 'torus', major_radius = 0.02, minor_radius = 0.005,
   direction = 1, 0, 0, material = 'steel' /
&body name = 'egg', mass = 0.1, inertia = 3*1e-5, position = 0, 0, 0.2 /
&surface name = 'skin', body = 'egg', shape = 'ellipsoid', semi_axes = 0.03, 0.02, 0.01,
   material = 'steel' /
&contact name = 'meet', surfaces = 'tube', 'skin' /
&output interval = 1e-4 /
"""
    (tmp_path / "scene.nml").write_text(scene)
    done = run("run", "scene.nml", "-q", "-o", "out.h5")
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "out.h5") as file:
        lost = np.isnan(file["trajectory/gap"][()])
        assert lost.any()
        for name in GEOMETRY:
            assert (np.isnan(file["trajectory"][name][()]).all(axis=2) == lost).all(), name
