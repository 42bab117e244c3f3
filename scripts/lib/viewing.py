"""A run as one HTML file: its rows thinned out, its surfaces, and the page that draws them."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from . import memory, springing, thinning
from .charting import pack_charts
from .drawable import Run, columns_of_bodies, open_run, up_of
from .pages import Package, library, page
from .results import as_text, open_file, read_events
from .surfaces import touched_of

DRAWN_ANGLE = np.radians(1.0)
DRAWN_LENGTH = 1e-3  # parts of the size of the scene
DRAWN_FORCE = 0.02  # parts of the largest force, and the like of what a spot shows
QUANTIZED = 0.9  # what quantization leaves of the tolerances

# Bytes of keys before compression, and those for each body and contact of many.
BUDGET = 3_200_000
BUDGET_EACH = 24_000
BUDGET_MOST = 13_000_000

LOOSEST = 50.0  # times the tolerances, beyond which it is no motion any more

VALUES = 9  # of a contact that is closed; see contact_values

STRETCH = 1 << 17  # rows of contacts
MOST_EVENTS = 20_000


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


# ---- Thinning ----------------------------------------------------------------------------------


def thin_bodies(run: Run, loose: float) -> list[Body]:
    """Keys of the motions of all bodies; tolerances are `loose` times the usual ones."""
    return [
        thin_body(run, *columns, loose) for columns in columns_of_bodies(run, slice(0, run.rows))
    ]


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
    """Keys of the contacts, and the largest of each of their values, which are parts of it, but for
    those of memories, which are."""
    if run.column("contact_point") is None or not run.contacts:
        return [], np.ones(VALUES)
    scales = np.zeros(VALUES)
    parts = run.parts(len(run.contacts), 24)
    for part in parts:
        for rows in stretches(run):
            values = contact_values(run, rows, part)[0]
            scales = np.fmax(scales, np.fmax.reduce(np.abs(values), axis=(0, 1)))
    memories = memory.of_contacts(run)
    # A force and its friction, and the two components and axes, are drawn on one scale.
    for alike in ((0, 1, 2), (4, 5), (7, 8)):
        scales[list(alike)] = scales[list(alike)].max()
    scales = np.where(np.isfinite(scales) & (scales > 0), scales, 1.0)
    found: list[list[Contact]] = [[] for _ in run.contacts]
    for part in parts:
        for rows in stretches(run):
            values, point, frame = contact_values(run, rows, part)
            parted = values / scales
            for i in range(part.stop - part.start):
                kept = memories.get(part.start + i)
                more = memory.columns(
                    run.file["trajectory"], rows, part.start + i, values[:, i], frame[:, i], kept
                )
                one = (np.concatenate([parted[:, i], more], axis=1), point[:, i], frame[:, i])
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
    values = np.empty((*normal.shape[:2], VALUES))
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
    tolerances = (
        loose * QUANTIZED * np.concatenate([tolerances, np.full(values.shape[1], DRAWN_FORCE)])
    )
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
    return size + sum((25 + 2 * contact.values.shape[1]) * len(contact.at) for contact in contacts)


def budget(run: Run) -> int:
    """What they may have."""
    return min(BUDGET_MOST, max(BUDGET, BUDGET_EACH * (len(run.bodies) + len(run.contacts))))


# ---- What the page gets ------------------------------------------------------------------------


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
    memories = {i: {"memory": vars(kept)} for i, kept in memory.of_contacts(run).items()}
    head["contacts"] = [
        {
            "name": name,
            "on": sides[i],
            "at": times(contact.at),
            "closed": package.put(contact.closed, "u1"),
            "point": package.put(contact.point, "f4"),
            "frame": package.put(np.round(32767 * contact.frame), "i2"),
            "values": package.put(contact.values.astype("f2").view("u2"), "u2"),
            **memories.get(i, {}),
        }
        for i, (name, contact) in enumerate(zip(run.contacts, contacts, strict=False))
    ]
    head["springs"] = springing.pack(run, package, times)
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


# ---- The page ----------------------------------------------------------------------------------


def view(path: Path) -> str:
    """The page of a file."""
    with open_file(path) as file:
        return page("view", data_of(open_run(path, file)), [library()])
