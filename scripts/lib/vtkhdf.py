"""A run as one VTKHDF file, PolyData with many times: bodies as meshes, contacts as points with
their forces, spots as ellipses, springs as coils.

Cells are told once, points and forces for each time, where they are not those of the time before.
The file is written time by time.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

import h5py
import numpy as np

from . import meshes, springing, thinning
from .drawable import PORTION, Run, gravity_of
from .results import ResultError, as_text
from .viewing import acted_on

FRAMES = 500  # times, if not told
RIM = 32  # corners of a spot
CEILING = -0.3  # of hollows what faces down is left out

# Kinds of cells.
BODY, CONTACT, SPOT, SPRING, HOLD = 0, 1, 2, 3, 4

# The kinds of cells of PolyData, in the order in which they have columns.
GROUPS = ("Vertices", "Lines", "Polygons", "Strips")

# What points have: of contacts, the first one also of springs, zero elsewhere. The last one is of
# the rims of spots.
VECTORS = ("force", "normal_force", "friction_force", "slip_velocity", "spot_offset")


class Series:
    """Values of points at each time; what is as before is not written again."""

    def __init__(self, group: h5py.Group, name: str, points: int) -> None:
        self.data = group.create_dataset(
            name,
            (0, 3),
            maxshape=(None, 3),
            dtype="<f4",
            chunks=(max(points, 1), 3),
            compression="gzip",
            compression_opts=2,
            shuffle=True,
        )
        self.offsets: list[int] = []
        self.last: np.ndarray | None = None

    def put(self, values: np.ndarray) -> None:
        """The values of the next time."""
        values = values.astype(np.float32)
        at = len(self.data)
        if self.last is not None and np.array_equal(values, self.last):
            self.offsets.append(self.offsets[-1])
            return
        self.data.resize(at + len(values), axis=0)
        self.data[at:] = values
        self.offsets.append(at)
        self.last = values


def write(run: Run, rows: slice, target: BinaryIO, *, frames: int) -> None:
    """Write rows of a run, so many of them, evenly spread, into a binary file."""
    count = rows.stop - rows.start
    at = rows.start + np.unique(np.linspace(0, count - 1, min(frames, count)).round().astype(int))
    scene = Scene(run, at)
    with h5py.File(target, "w") as file:
        root = file.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = np.array([2, 0], dtype="<i8")
        root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", 8))
        steps = root.create_group("Steps")
        points = Series(root, "Points", scene.size)
        data = root.create_group("PointData")
        vectors = [Series(data, name, scene.size) for name in VECTORS]
        for points_now, vectors_now in scene.frames():
            points.put(points_now)
            for series, values in zip(vectors, vectors_now, strict=True):
                series.put(values)
        root["NumberOfPoints"] = np.array([scene.size], dtype="<i8")
        values = scene.cells(root)
        steps.attrs["NSteps"] = np.int64(len(at))
        steps["Values"] = run.time[at]
        steps["PartOffsets"] = np.zeros(len(at), dtype="<i8")
        steps["NumberOfParts"] = np.ones(len(at), dtype="<i8")
        steps["PointOffsets"] = np.array(points.offsets, dtype="<i8")
        for name in ("CellOffsets", "ConnectivityIdOffsets"):
            steps[name] = np.zeros((len(at), len(GROUPS)), dtype="<i8")
        for name, series in zip(VECTORS, vectors, strict=True):
            steps[f"PointDataOffsets/{name}"] = np.array(series.offsets, dtype="<i8")
        for name in values:
            steps[f"CellDataOffsets/{name}"] = np.zeros(len(at), dtype="<i8")
        # The names that cells have numbers of.
        texts = h5py.string_dtype("utf-8")
        file["names/body"] = np.array(["ground", *run.bodies], dtype=texts)
        file["names/contact"] = np.array(run.contacts, dtype=texts)
        file["names/spring"] = np.array([s.name for s in scene.springs], dtype=texts)
        file["names/surface"] = np.array([s["name"] for s in run.surfaces], dtype=texts)
        file.attrs["title"] = as_text(run.file.attrs.get("title", ""))


class Scene:
    """What is drawn: meshes of the surfaces, a point for each contact, and the rim of its spot, a
    coil for each spring, and a point where it holds body B."""

    def __init__(self, run: Run, at: np.ndarray) -> None:
        self.run, self.at = run, at
        known = run.column("contact_point") is not None
        self.contacts = len(run.contacts) if known else 0
        self.sides = acted_on(run) if self.contacts else []
        first = at[0]
        start = np.asarray(run.column("position")[first])
        low, high = start.min(0, initial=np.inf), start.max(0, initial=-np.inf)
        for rows in self.blocks():
            position = self.read("position", rows)
            low, high = (
                np.minimum(low, position.min((0, 1))),
                np.maximum(high, position.max((0, 1))),
            )
        if not len(run.bodies):
            low, high = np.zeros(3), np.zeros(3)
        self.surfaces = meshes.placed(run, (low, high))
        gravity = gravity_of(run)
        up = -gravity / np.linalg.norm(gravity) if gravity.any() else np.array([0.0, 0.0, 1.0])
        attitude = thinning.matrices(np.asarray(run.column("quaternion")[first]))
        self.local, self.triangles = [], []
        shift = 0
        for i, surface in enumerate(self.surfaces):
            points = surface.centre + surface.to_body(surface.mesh.points)
            parts = [part.copy() for part in surface.mesh.triangles]
            if surface.inside and "band" not in run.surfaces[i]:
                turn = np.eye(3) if surface.body < 0 else attitude[surface.body]
                height = surface.to_body(surface.mesh.normals) @ turn.T @ up
                parts = [part[height[part].mean(axis=1) > CEILING] for part in parts]
            self.local.append((surface.body, points))
            self.triangles.append([part + shift for part in parts])
            shift += len(points)
        self.of_bodies = shift
        self.springs = springing.read(run)
        self.coil = springing.coil(springing.WIDTH * run.scale)
        self.of_springs = shift + self.contacts * (1 + RIM)
        self.size = self.of_springs + len(self.springs) * (len(self.coil) + 1)
        self.polygons = sum(len(p) for pair in self.triangles for p in pair) + self.contacts
        rim = 2 * np.pi * np.arange(RIM) / RIM
        self.rim = np.stack([np.cos(rim), np.sin(rim)], axis=1)
        self.last = np.zeros((self.contacts, 3)) + (start.mean(0) if len(start) else 0.0)

    def cells(self, root: h5py.Group) -> list[str]:
        """Write the cells, first points, then coils, triangles and the ellipses of the spots, and
        what they have: the names of that."""
        connectivity, sizes, found = [], [], []

        def add(kind: int, body: int, number: int, colour: tuple, many: int) -> None:
            found.append(np.tile([kind, body, number, *colour], (many, 1)))

        red = (0xD4, 0x3A, 0x3A)
        for k in range(self.contacts):
            add(CONTACT, -1, k, red, 1)
        for kind in (HOLD, SPRING):
            for k in range(len(self.springs)):
                add(kind, -1, k, springing.COLOUR, 1)
        for i, (surface, pair) in enumerate(zip(self.surfaces, self.triangles, strict=True)):
            for part, colour in zip(pair, surface.colours, strict=True):
                connectivity.append(part.ravel())
                sizes.append(np.full(len(part), 3))
                add(BODY, surface.body + 1, i, colour, len(part))
        connectivity.append(self.of_bodies + self.contacts + np.arange(self.contacts * RIM))
        sizes.append(np.full(self.contacts, RIM))
        for k in range(self.contacts):
            add(SPOT, -1, k, red, 1)
        none = np.zeros(0, dtype=int)
        all_cells = {name: (none, none) for name in GROUPS}
        vertices = self.of_bodies + np.arange(self.contacts)
        coils = self.of_springs + np.arange(len(self.springs) * len(self.coil))
        held = self.of_springs + len(coils) + np.arange(len(self.springs))
        vertices = np.concatenate([vertices, held])
        all_cells["Vertices"] = (vertices, np.ones(len(vertices), dtype=int))
        all_cells["Lines"] = (coils, np.full(len(self.springs), len(self.coil)))
        all_cells["Polygons"] = (np.concatenate(connectivity), np.concatenate(sizes))
        for name, (ids, counts) in all_cells.items():
            group = root.create_group(name)
            group["NumberOfCells"] = np.array([len(counts)], dtype="<i8")
            group["NumberOfConnectivityIds"] = np.array([len(ids)], dtype="<i8")
            group["Connectivity"] = ids.astype("<i8")
            group["Offsets"] = np.concatenate([[0], np.cumsum(counts)]).astype("<i8")
        table = np.concatenate(found) if found else np.zeros((0, 6), dtype=int)
        data = root.create_group("CellData")
        data["kind"] = table[:, 0].astype("<i4")
        data["body"] = table[:, 1].astype("<i4")
        data["number"] = table[:, 2].astype("<i4")
        data["colour"] = table[:, 3:].astype("u1")
        return list(data)

    def blocks(self) -> Iterator[np.ndarray]:
        """The rows that are drawn, some at a time."""
        wide = max(1, 10 * len(self.run.bodies) + 24 * self.contacts)
        step = max(1, PORTION // wide)
        block: list[int] = []
        for row in self.at:
            if block and row - block[0] >= step:
                yield np.array(block)
                block = []
            block.append(int(row))
        yield np.array(block)

    def read(self, name: str, rows: np.ndarray) -> np.ndarray:
        """Rows of a column."""
        block = np.asarray(self.run.column(name)[rows[0] : rows[-1] + 1])
        return block[rows - rows[0]].astype(float)

    def frames(self) -> Iterator[tuple[np.ndarray, list[np.ndarray]]]:
        """The points of each time, and their vectors."""
        for rows in self.blocks():
            position, attitude = self.read("position", rows), self.read("quaternion", rows)
            if not (np.isfinite(position).all() and np.isfinite(attitude).all()):
                raise ResultError(f"{self.run.path} has positions or attitudes that are no numbers")
            columns = {}
            if self.contacts:
                columns = {
                    name: self.read(name, rows)
                    for name in (
                        "contact_point",
                        "contact_normal",
                        "major_direction",
                        "normal_force",
                        "friction_force",
                        "slip_velocity",
                        "semi_axes",
                    )
                }
            coils = self.coils(position, attitude)
            pulls = self.read("spring_force", rows) if self.springs else np.zeros((len(rows), 0, 3))
            for k in range(len(rows)):
                points, vectors = self.frame(
                    position[k],
                    thinning.matrices(attitude[k]),
                    {name: values[k] for name, values in columns.items()},
                )
                points[self.of_springs :] = coils[k]
                vectors[0][self.size - len(self.springs) :] = pulls[k]
                yield points, vectors

    def coils(self, position: np.ndarray, attitude: np.ndarray) -> np.ndarray:
        """Points of the coils of all springs, and those where they hold their bodies B, at the
        poses of some times (times, points, 3)."""
        found, held = [], []
        for spring in self.springs:
            poses = {i: (position[:, i], attitude[:, i]) for i in spring.bodies if i >= 0}
            first, second = springing.ends(spring, poses, len(position))
            begin, way = springing.axis(first, second, springing.WIDTH * self.run.scale)
            turn = thinning.matrices(springing.frames(way))
            stretched = np.repeat(self.coil[None], len(way), axis=0)
            stretched[..., 2] *= np.linalg.norm(way, axis=1)[:, None]
            found.append(begin[:, None] + np.einsum("kij,kpj->kpi", turn, stretched))
            held.append(second[:, None])
        return np.concatenate([np.zeros((len(position), 0, 3)), *found, *held], axis=1)

    def frame(
        self, position: np.ndarray, turn: np.ndarray, contact: dict[str, np.ndarray]
    ) -> tuple[np.ndarray, list[np.ndarray]]:
        """The points of a time but for springs, and their vectors."""
        points = np.zeros((self.size, 3))
        vectors = [np.zeros((self.size, 3), dtype=np.float32) for _ in VECTORS]
        start = 0
        for body, local in self.local:
            end = start + len(local)
            points[start:end] = local if body < 0 else local @ turn[body].T + position[body]
            start = end
        if not self.contacts:
            return points, vectors
        force = np.nan_to_num(contact["normal_force"])
        closed = force > 0
        known = np.isfinite(contact["contact_point"]).all(axis=1)
        # A contact that has no place stays where it was, without a force.
        self.last[known] = contact["contact_point"][known]
        shown = slice(start, start + self.contacts)
        points[shown] = self.last
        sides = np.array(self.sides)[:, None]
        normal = np.nan_to_num(contact["contact_normal"])
        major = np.nan_to_num(contact["major_direction"])
        rub = np.where(closed[:, None], np.nan_to_num(contact["friction_force"]), 0.0)
        pull = force[:, None] * normal
        slip = np.where(closed[:, None], np.nan_to_num(contact["slip_velocity"]), 0.0)
        for vector, values in zip(
            vectors, (sides * (pull + rub), sides * pull, sides * rub, slip), strict=False
        ):
            vector[shown] = values
        axes = np.where(closed[:, None], np.nan_to_num(contact["semi_axes"]), 0.0)
        minor = np.cross(normal, major)
        spans = np.stack([axes[:, :1] * major, axes[:, 1:] * minor], axis=1)
        offsets = np.einsum("rk,ckx->crx", self.rim, spans)
        rims = slice(start + self.contacts, self.of_springs)
        points[rims] = (self.last[:, None] + offsets).reshape(-1, 3)
        vectors[-1][rims] = offsets.reshape(-1, 3)
        return points, vectors
