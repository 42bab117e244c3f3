"""A run as one HTML file: its rows thinned out, its surfaces, and the page that draws them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, fields
from itertools import pairwise
from pathlib import Path

import h5py
import numpy as np

from . import thinning
from .pages import Package, library, page
from .results import ResultError, as_text, complete_rows, names, open_file, read_events

DRAWN_ANGLE = np.radians(1.0)
DRAWN_LENGTH = 1e-3  # parts of the size of the scene
DRAWN_FORCE = 0.02  # parts of the largest force, and the like of what a spot shows
QUANTIZED = 0.9  # what quantization leaves of the tolerances

# Bytes of keys before compression, and those for each body and contact of many.
BUDGET = 3_200_000
BUDGET_EACH = 24_000
BUDGET_MOST = 13_000_000

LOOSEST = 50.0  # times the tolerances, beyond which it is no motion any more

PORTION = 1 << 23  # numbers that are read at a time
STRETCH = 1 << 17  # rows of contacts
CHART_BUCKETS = 400
CHARTED = 6  # bodies or contacts of a chart
MOST_EVENTS = 20_000
SHAPES = ("sphere", "ellipsoid", "torus", "cylinder", "cone", "paraboloid", "plane")
TOUCHED = 500  # points of a shape that the page does not know
SIZES = ("radius", "semi_axes", "major_radius", "minor_radius", "half_angle", "vertex_radius")


@dataclass
class Body:
    """What is kept of the motion of a body."""

    at: np.ndarray  # rows of its positions
    position: np.ndarray
    turned_at: np.ndarray  # rows of its attitudes
    quaternion: np.ndarray
    turn: np.ndarray


@dataclass
class Contact:
    """What is kept of a contact."""

    at: np.ndarray
    closed: np.ndarray
    point: np.ndarray
    frame: np.ndarray
    values: np.ndarray


@dataclass
class Run:
    """A file that is being looked at."""

    file: h5py.File
    path: Path
    time: np.ndarray
    rows: int
    bodies: list[str]
    contacts: list[str]
    surfaces: list[dict] = field(default_factory=list)
    scale: float = 1.0

    def column(self, name: str) -> h5py.Dataset | None:
        """A column of the trajectory."""
        return self.file["trajectory"].get(name)

    def parts(self, count: int, each: int) -> list[slice]:
        """Slices of bodies or contacts whose columns fit into the memory."""
        step = max(1, PORTION // max(1, each * self.rows))
        return [slice(i, min(i + step, count)) for i in range(0, count, step)]


def open_run(path: Path, file: h5py.File) -> Run:
    """See that a file can be drawn, or say what it lacks."""
    kind = as_text(file.attrs.get("filetype", ""))
    if kind and kind != "contensou-trajectory":
        raise ResultError(f"{path} is a {kind}, not a run; scripts/plot draws it")
    if "trajectory/time" not in file or "body/name" not in file:
        raise ResultError(f"{path} is no output file of contensou")
    if "surface/shape" not in file:
        version = as_text(file.attrs.get("filetype_version", "")) or "without version"
        raise ResultError(
            f"{path} does not say what its bodies look like: contensou-trajectory {version}, "
            "1.5 or later is needed. Run the scene again; it is in /input/namelist"
        )
    time, rows = complete_rows(file["trajectory"])
    rows = min(
        [rows]
        + [
            len(data)
            for data in file["trajectory"].values()
            if data.ndim > 0 and data.dtype.kind == "f" and data.maxshape[0] is None
        ]
    )
    if rows < 1:
        raise ResultError(f"{path} holds no rows as yet")
    run = Run(file, path, time[:rows], rows, names(file["body/name"]), [])
    run.contacts = names(file["contact/name"]) if "contact/name" in file else []
    run.surfaces = read_surfaces(run)
    run.scale = scale_of(run)
    return run


def read_surfaces(run: Run) -> list[dict]:
    """The surfaces, with what the page needs to draw them."""
    group = run.file["surface"]
    table = {key: names(group[key]) for key in ("name", "body", "shape", "side", "material")}
    parts = names(group["solid_part"])
    lengths = group["solid_length"][()]
    found = []
    for i, name in enumerate(table["name"]):
        sizes = {}
        for key in SIZES:
            if key in group and np.isfinite(group[key][i]).all():
                sizes[key] = np.asarray(group[key][i]).tolist()
        body = table["body"][i]
        found.append(
            {
                "name": name,
                "body": run.bodies.index(body) if body in run.bodies else -1,
                "shape": table["shape"][i],
                "inside": table["side"][i] == "inside",
                "material": table["material"][i],
                "centre": group["centre"][i].tolist(),
                "axes": group["axes"][i].ravel().tolist(),
                "part": parts[i],
                "length": float(lengths[i]) if np.isfinite(lengths[i]) else 0,
                "sizes": sizes,
            }
        )
    return found


def reach(surface: dict) -> float:
    """How far a surface reaches from the origin of its body; 0 if it has no end [m]."""
    sizes = surface["sizes"]
    size = {
        "sphere": lambda: sizes["radius"],
        "ellipsoid": lambda: max(sizes["semi_axes"]),
        "torus": lambda: sizes["major_radius"] + sizes["minor_radius"],
        "cylinder": lambda: float(np.hypot(sizes["radius"], 0.5 * surface["length"])),
        "paraboloid": lambda: max(sizes["vertex_radius"], surface["length"]),
        "cone": lambda: surface["length"],
    }.get(surface["shape"], lambda: 0.0)()
    return float(np.linalg.norm(surface["centre"])) + size if size else 0.0


def scale_of(run: Run) -> float:
    """Size of the scene at its beginning [m]."""
    reaches = np.zeros(len(run.bodies))
    for surface in run.surfaces:
        if surface["body"] >= 0:
            reaches[surface["body"]] = max(reaches[surface["body"]], reach(surface))
    if not len(run.bodies):
        return 1.0
    start = run.column("position")[0]
    size = float(
        np.linalg.norm((start + reaches[:, None]).max(0) - (start - reaches[:, None]).min(0))
    )
    if not size > 0:
        ends = np.stack([start, run.column("position")[run.rows - 1]])
        size = float(np.linalg.norm(np.ptp(ends.reshape(-1, 3), axis=0)))
    return size if np.isfinite(size) and size > 0 else 1.0


# ---- Thinning ----------------------------------------------------------------------------------


def thin_bodies(run: Run, loose: float) -> list[Body]:
    """Keys of the motions of all bodies; tolerances are `loose` times the usual ones."""
    found = []
    for part in run.parts(len(run.bodies), 10):
        columns = [
            np.asarray(run.column(name)[: run.rows, part])
            for name in ("position", "quaternion", "angular_velocity")
        ]
        found += [
            thin_body(run, *(column[:, i] for column in columns), loose)
            for i in range(part.stop - part.start)
        ]
    return found


def thin_body(
    run: Run, position: np.ndarray, quaternion: np.ndarray, rate: np.ndarray, loose: float
) -> Body:
    """Keys of the motion of a body."""
    length, angle = (QUANTIZED * loose * x for x in (DRAWN_LENGTH * run.scale, DRAWN_ANGLE))
    turned = thinning.integral(run.time, rate)
    at = thinning.keys(run.rows, thinning.distance_error(run.time, position, length))
    turned_at = thinning.keys(run.rows, thinning.turn_error(run.time, quaternion, turned, angle))
    turn = np.zeros((len(turned_at), 3))
    turn[:-1] = np.diff(turned[turned_at], axis=0)
    return Body(at, position[at], turned_at, quaternion[turned_at], turn)


def thin_contacts(run: Run, loose: float) -> tuple[list[Contact], np.ndarray]:
    """Keys of the contacts, and the largest of each of their values, which are parts of it."""
    if run.column("contact_point") is None or not run.contacts:
        return [], np.ones(9)
    scales = np.zeros(9)
    parts = run.parts(len(run.contacts), 24)
    for part in parts:
        for rows in stretches(run):
            values = contact_values(run, rows, part)[0]
            scales = np.fmax(scales, np.fmax.reduce(np.abs(values), axis=(0, 1)))
    # A force and its friction, and the two components and axes, are drawn on one scale.
    for alike in ((0, 1, 2), (4, 5), (7, 8)):
        scales[list(alike)] = scales[list(alike)].max()
    scales = np.where(np.isfinite(scales) & (scales > 0), scales, 1.0)
    found: list[list[Contact]] = [[] for _ in run.contacts]
    for part in parts:
        for rows in stretches(run):
            values, point, frame = contact_values(run, rows, part)
            values /= scales
            for i in range(part.stop - part.start):
                one = (values[:, i], point[:, i], frame[:, i])
                found[part.start + i].append(thin_contact(run, rows, *one, loose))
    return [joined(pieces) for pieces in found], scales


def stretches(run: Run) -> list[slice]:
    """Slices of the rows of which each begins with the last row of the one before."""
    starts = range(0, max(1, run.rows - 1), STRETCH)
    return [slice(i, min(i + STRETCH, run.rows - 1) + 1) for i in starts]


def joined(pieces: list[Contact]) -> Contact:
    """The keys of a contact from those of stretches of rows that share their ends."""
    names = [item.name for item in fields(Contact)]
    columns = [
        [getattr(piece, name)[min(k, 1) :] for k, piece in enumerate(pieces)] for name in names
    ]
    return Contact(*(np.concatenate(column) for column in columns))


def contact_values(run: Run, rows: slice, part: slice) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values of contacts (rows, contacts, 9), their points and frames: normal force, friction force
    along the axes of the spot, its torque, slip along the axes, spin, semi-axes."""

    def column(name: str) -> np.ndarray:
        return np.asarray(run.column(name)[rows, part])

    normal, major = column("contact_normal"), column("major_direction")
    minor = np.cross(normal, major)
    force, slip = column("friction_force"), column("slip_velocity")
    values = np.empty((*normal.shape[:2], 9))
    values[..., 0] = column("normal_force")
    values[..., 1] = np.sum(force * major, axis=-1)
    values[..., 2] = np.sum(force * minor, axis=-1)
    values[..., 3] = column("friction_torque")
    values[..., 4] = np.sum(slip * major, axis=-1)
    values[..., 5] = np.sum(slip * minor, axis=-1)
    values[..., 6] = column("spin")
    values[..., 7:] = column("semi_axes")
    return values, column("contact_point"), np.stack([major, minor, normal], axis=-1)


def thin_contact(
    run: Run, rows: slice, values: np.ndarray, point: np.ndarray, frame: np.ndarray, loose: float
) -> Contact:
    """Keys of a contact: while it is closed, straight lines; none while it is open."""
    closed = (values[:, 0] > 0) & np.isfinite(point).all(axis=1) & np.isfinite(values).all(axis=1)
    values = np.where(closed[:, None], values, 0.0)
    point = np.where(closed[:, None], point, 0.0)
    flat = frame.reshape(len(frame), 9)[:, [0, 3, 6, 2, 5, 8]]
    flat = np.where(closed[:, None], flat, 0.0)
    tolerances = np.concatenate([np.full(3, DRAWN_LENGTH * run.scale / 2), np.full(6, 0.03)])
    tolerances = loose * QUANTIZED * np.concatenate([tolerances, np.full(9, DRAWN_FORCE)])
    error = thinning.line_error(
        run.time[rows], np.concatenate([point, flat, values], axis=1), tolerances
    )

    def of_states(first: np.ndarray, last: np.ndarray, at: np.ndarray) -> np.ndarray:
        same = (closed[first] == closed[last])[:, None] & (closed[at] == closed[first][:, None])
        return np.where(same, error(first, last, at), np.inf)

    kept = thinning.keys(len(values), of_states)
    upright = np.where(closed[kept, None, None], frame[kept], np.eye(3))
    quaternions = thinning.quaternions(upright)
    return Contact(kept + rows.start, closed[kept], point[kept], quaternions, values[kept])


def bytes_of(bodies: list[Body], contacts: list[Contact]) -> int:
    """Size of all keys."""
    size = sum(16 * len(body.at) + 24 * len(body.turned_at) for body in bodies)
    return size + sum(43 * len(contact.at) for contact in contacts)


def budget(run: Run) -> int:
    """What they may have."""
    return min(BUDGET_MOST, max(BUDGET, BUDGET_EACH * (len(run.bodies) + len(run.contacts))))


# ---- What the page gets ------------------------------------------------------------------------


def up_of(run: Run) -> np.ndarray:
    """Where it is up: against gravity, or z."""
    gravity = gravity_of(run)
    return -gravity / np.linalg.norm(gravity) if gravity.any() else np.array([0.0, 0.0, 1.0])


def pack_charts(run: Run, package: Package, buckets: int = CHART_BUCKETS) -> list[dict]:
    """The strips of a run with the numbers of their lines."""
    found = []
    for strip in charts_of(run, up_of(run)):
        lines = []
        for name, read in strip["lines"]:
            at, values = decimate(run.time, read(), buckets)
            if len(at) and np.ptp(values) > 0:
                lines.append(
                    {
                        "name": name,
                        "at": package.put(at - run.time[0], "f4"),
                        "values": package.put(values, "f4"),
                    }
                )
        if lines:
            found.append({**strip, "lines": lines})
    return found


def charts_of(run: Run, up: np.ndarray) -> list[dict]:
    """Strips of the quantities of the run: title, unit, and lines as functions that read them."""

    def plain(name: str, scale: float = 1.0):
        return lambda: scale * np.asarray(run.column(name)[: run.rows])

    def vector(name: str, i: int) -> np.ndarray:
        return np.asarray(run.column(name)[: run.rows, i])

    def axis(i: int) -> np.ndarray:
        w, x, y, z = vector("quaternion", i).T
        tilt = up[0] * 2 * (x * z + w * y) + up[1] * 2 * (y * z - w * x)
        tilt += up[2] * (1 - 2 * (x * x + y * y))
        return np.degrees(np.arccos(np.clip(tilt, -1, 1)))

    bodies = list(enumerate(run.bodies))
    if len(bodies) > CHARTED:
        ends = np.ptp(run.column("position")[:: max(1, run.rows // 50)], axis=0).max(axis=1)
        bodies = [pair for pair in bodies if ends[pair[0]] > 1e-6 * ends.max()][:CHARTED]
    contacts = list(enumerate(run.contacts))[:CHARTED]
    energies = ("kinetic", "potential", "elastic")
    works = ("work_friction", "work_damping", "work_applied")
    strips = [
        ("Energy", "J", [(name, plain(f"energy_{name}")) for name in energies]),
        ("Work", "J", [(name[5:], plain(name)) for name in works]),
        ("Height", "m", [(n, lambda i=i: vector("position", i) @ up) for i, n in bodies]),
        (
            "Inclination of the axis",
            "°",
            [(n, lambda i=i: axis(i)) for i, n in bodies if has_axis(run.file["body/inertia"][i])],
        ),
        (
            "Speed",
            "m/s",
            [(n, lambda i=i: np.linalg.norm(vector("velocity", i), axis=1)) for i, n in bodies],
        ),
        (
            "Angular velocity about the vertical",
            "rad/s",
            [(n, lambda i=i: vector("angular_velocity", i) @ up) for i, n in bodies],
        ),
        ("Normal force", "N", [(n, lambda i=i: vector("normal_force", i)) for i, n in contacts]),
        (
            "Slip velocity",
            "m/s",
            [
                (n, lambda i=i: np.linalg.norm(vector("slip_velocity", i), axis=1))
                for i, n in contacts
            ],
        ),
        ("Gap", "m", [(n, lambda i=i: vector("gap", i)) for i, n in contacts]),
    ]
    return [{"title": t, "unit": u, "lines": lines} for t, u, lines in strips if lines]


def has_axis(inertia: np.ndarray) -> bool:
    """Whether the first two principal moments alone are equal, or all differ: z is an axis then."""
    first, second, third = inertia
    return not np.isclose(first, third, rtol=1e-9) and not np.isclose(second, third, rtol=1e-9)


def decimate(time: np.ndarray, values: np.ndarray, buckets: int) -> tuple[np.ndarray, np.ndarray]:
    """A line that looks the same: of each bucket the least and the largest value, in order."""
    good = np.flatnonzero(np.isfinite(values))
    if len(good) <= 2 * buckets:
        return time[good], values[good]
    edges = np.linspace(0, len(good), buckets + 1).astype(int)
    kept = {int(good[0]), int(good[-1])}
    for first, last in pairwise(edges):
        part = values[good[first:last]]
        kept |= {int(good[first + part.argmin()]), int(good[first + part.argmax()])}
    rows = np.array(sorted(kept))
    return time[rows], values[rows]


def of_body(
    body: int, points: np.ndarray, position: np.ndarray, attitude: np.ndarray
) -> np.ndarray:
    """Points (rows, contacts, 3) as a body sees them."""
    if body < 0:
        return points
    turn = thinning.matrices(attitude[:, body])
    return np.einsum("tji,tcj->tci", turn, points - position[:, None, body])


def touched_of(run: Run, package: Package) -> list[dict]:
    """The surfaces as the page gets them; those of shapes that it does not know, such as those of
    extensions, with the points at which they were touched."""
    found = [dict(surface) for surface in run.surfaces]
    unknown = [surface for surface in found if surface["shape"] not in SHAPES]
    for surface in unknown:
        surface["touched"] = package.put(np.zeros(0), "f4")
    if not unknown or run.column("contact_point") is None or not run.contacts:
        return found
    pairs = np.asarray(run.file["contact/surfaces"].asstr()[()])
    rows = np.unique(np.linspace(0, run.rows - 1, 2 * TOUCHED).astype(int))
    point, position, attitude, force = (
        run.column(name)[rows]
        for name in ("contact_point", "position", "quaternion", "normal_force")
    )
    for surface in unknown:
        at = np.flatnonzero((pairs == surface["name"]).any(axis=1))
        x = of_body(surface["body"], point[:, at], position, attitude)
        x = x[(force[:, at] > 0) & np.isfinite(x).all(axis=-1)]
        surface["touched"] = package.put(x[:: 1 + len(x) // TOUCHED], "f4")
    return found


def bands_of(run: Run) -> None:
    """For grooves, the part of the tube that is touched: angles across it, in the surface."""
    if run.column("contact_point") is None or not run.contacts:
        return
    pairs = np.asarray(run.file["contact/surfaces"].asstr()[()])
    rows = np.unique(np.linspace(0, run.rows - 1, 40).astype(int))
    point, gap = run.column("contact_point")[rows], run.column("gap")[rows]
    position, attitude = run.column("position")[rows], run.column("quaternion")[rows]
    for surface in run.surfaces:
        if surface["shape"] != "torus" or not surface["inside"]:
            continue
        at = np.flatnonzero((pairs == surface["name"]).any(axis=1))
        near = np.isfinite(gap[:, at]) & (gap[:, at] < surface["sizes"]["minor_radius"])
        if not near.any():
            continue
        x = of_body(surface["body"], point[:, at], position, attitude)
        axes = np.array(surface["axes"]).reshape(3, 3)
        x = (x - np.array(surface["centre"])) @ axes.T
        across = np.hypot(x[..., 0], x[..., 1]) - surface["sizes"]["major_radius"]
        angles = np.arctan2(x[..., 2], across)[near]
        middle = np.angle(np.exp(1j * angles).mean())
        off = np.abs(np.angle(np.exp(1j * (angles - middle)))).max()
        if off < np.radians(80):
            surface["band"] = [float(middle), float(off + np.radians(35))]


def data_of(run: Run) -> str:
    """All that the page draws, packed."""
    loose = 1.0
    while True:
        bodies = thin_bodies(run, loose)
        contacts, scales = thin_contacts(run, loose)
        size = bytes_of(bodies, contacts)
        if size <= budget(run) or loose > LOOSEST:
            break
        loose *= max(1.5, min(8.0, size / budget(run)))
    bands_of(run)
    package = Package()
    start, end = float(run.time[0]), float(run.time[-1])
    tick = (end - start) / 4294967295 or 1.0

    def times(rows: np.ndarray) -> list:
        ticks = np.round((run.time[rows] - start) / tick).astype(np.int64)
        return package.put(np.diff(ticks, prepend=0), "u4")

    up = up_of(run)
    head = {
        "title": as_text(run.file.attrs.get("title", "")) or run.path.stem,
        "file": run.path.name,
        "program": as_text(run.file.attrs.get("program_version", "")),
        "status": as_text(run.file.attrs.get("status", "")),
        "start": start,
        "end": end,
        "tick": tick,
        "rows": run.rows,
        "scale": run.scale,
        "up": up.tolist(),
        "angle": float(np.degrees(DRAWN_ANGLE * loose)),
        "length": DRAWN_LENGTH * loose,
        "surfaces": touched_of(run, package),
        "forces": scales.tolist(),
        "drawn": bool(contacts) or not run.contacts,
        "scene": as_text(run.file["input/resolved"][()]) if "input/resolved" in run.file else "",
    }
    head["bodies"] = [
        {
            "name": name,
            "at": times(body.at),
            "position": package.put(body.position, "f4"),
            "turned_at": times(body.turned_at),
            "quaternion": package.put(np.round(32767 * body.quaternion), "i2"),
            "turn": package.put(body.turn, "f4"),
        }
        for name, body in zip(run.bodies, bodies, strict=True)
    ]
    sides = acted_on(run) if contacts else []
    head["contacts"] = [
        {
            "name": name,
            "on": sides[i],
            "at": times(contact.at),
            "closed": package.put(contact.closed, "u1"),
            "point": package.put(contact.point, "f4"),
            "frame": package.put(np.round(32767 * contact.frame), "i2"),
            "values": package.put(contact.values.astype("f2").view("u2"), "u2"),
        }
        for i, (name, contact) in enumerate(zip(run.contacts, contacts, strict=False))
    ]
    head["events"] = put_events(run, package)
    head["charts"] = pack_charts(run, package)
    return package.text(head)


def acted_on(run: Run) -> list[int]:
    """On which body the forces of each contact are drawn: 1 on that of B, -1 on that of A, where B
    is the ground."""
    ground = {surface["name"] for surface in run.surfaces if surface["body"] < 0}
    pairs = run.file["contact/surfaces"].asstr()[()].tolist()
    return [-1 if second in ground else 1 for _, second in pairs]


def put_events(run: Run, package: Package) -> dict:
    """The touches and lifts, the first of very many."""
    events = read_events(run.file, run.contacts, run.time[-1])
    more = max(0, len(events) - MOST_EVENTS)
    events = [event for event in events[:MOST_EVENTS] if event.contact in run.contacts]
    index = {name: i for i, name in enumerate(run.contacts)}
    return {
        "time": package.put(np.array([event.time for event in events], dtype=float), "f8"),
        "touch": package.put(np.array([event.kind == "touch" for event in events]), "u1"),
        "contact": package.put(
            np.array([index[event.contact] for event in events], dtype=int), "u4"
        ),
        "more": more,
    }


def gravity_of(run: Run) -> np.ndarray:
    """Acceleration of gravity as the scene gives it."""
    text = as_text(run.file["input/resolved"][()]) if "input/resolved" in run.file else ""
    found = re.search(r"(?im)^\s*gravity\s*=\s*([-+0-9.eEdD, ]+)", text)
    numbers = re.findall(r"[-+0-9.eE]+", found[1].replace("D", "E")) if found else []
    try:
        gravity = np.array([float(number) for number in numbers[:3]])
    except ValueError:
        return np.zeros(3)
    return gravity if len(gravity) == 3 else np.zeros(3)


# ---- The page ----------------------------------------------------------------------------------


def view(path: Path) -> str:
    """The page of a file."""
    with open_file(path) as file:
        return page("view", data_of(open_run(path, file)), [library()])
