"""A run as one binary file of glTF 2 with its animation in it.

Bodies are nodes that move, their surfaces nodes below them. Between two keys programs turn a body
the shorter way and evenly, so that keys are close enough that this is the way it went.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import numpy as np

from . import meshes, springing, thinning
from .drawable import Run, columns_of_bodies, gravity_of
from .results import ResultError, as_text
from .viewing import DRAWN_ANGLE, DRAWN_LENGTH

STEP = np.pi / 2  # how far a body turns between two keys, at most
MOST_KEYS = 20_000_000  # of a body
CHUNK = 1 << 20  # numbers of the file that are turned into bytes at a time

FLOAT, UNSIGNED = 5126, 5125
VERTICES, INDICES = 34962, 34963


@dataclass
class Buffer:
    """The numbers of the file, each array at a multiple of four bytes."""

    arrays: list[np.ndarray] = field(default_factory=list)
    length: int = 0
    views: list[dict] = field(default_factory=list)
    accessors: list[dict] = field(default_factory=list)

    def put(self, values: np.ndarray, kind: str, target: int = 0, *, bounds: bool = False) -> int:
        """Append an array; the number of its accessor."""
        whole = kind == "SCALAR" and values.dtype.kind in "iu"
        data = np.ascontiguousarray(values, dtype="<u4" if whole else "<f4")
        view = {"buffer": 0, "byteOffset": self.length, "byteLength": data.nbytes}
        if target:
            view["target"] = target
        accessor = {
            "bufferView": len(self.views),
            "componentType": UNSIGNED if whole else FLOAT,
            "count": len(data),
            "type": kind,
        }
        if bounds:
            flat = data.reshape(len(data), -1)
            accessor |= {"min": flat.min(0).tolist(), "max": flat.max(0).tolist()}
        self.views.append(view)
        self.accessors.append(accessor)
        self.arrays.append(data)
        self.length += data.nbytes
        return len(self.accessors) - 1


@dataclass
class Motion:
    """Keys of a body: times from the beginning, in 32 bits, and what there is at them."""

    moved_at: np.ndarray
    position: np.ndarray
    turned_at: np.ndarray
    quaternion: np.ndarray  # w, x, y, z; neighbours of the same sign


@dataclass
class Coil:
    """Keys of a coil: where it begins, how it is turned, and how long it is."""

    name: str
    kind: str
    bodies: list[str]
    at: np.ndarray
    begin: np.ndarray
    quaternion: np.ndarray
    length: np.ndarray


def write(run: Run, rows: slice, file: object, *, every_row: bool) -> None:
    """Write rows of a run into a binary file."""
    time = run.time[rows]
    buffer = Buffer()
    springs = springing.read(run)
    held = sorted({body for spring in springs for body in spring.bodies if body >= 0})
    motions, poses, low, high = [], {}, np.full(3, np.inf), np.full(3, -np.inf)
    for i, (position, quaternion, rate) in enumerate(columns_of_bodies(run, rows)):
        motions.append(motion_of(run, time, position, quaternion, rate, every_row=every_row))
        if i in held:
            poses[i] = (position.copy(), quaternion.copy())
        low, high = np.minimum(low, position.min(0)), np.maximum(high, position.max(0))
    if not motions:
        low, high = np.zeros(3), np.zeros(3)
    coils = [coil_of(run, time, spring, poses, every_row=every_row) for spring in springs]
    head = head_of(run, time, motions, coils, meshes.placed(run, (low, high)), buffer)
    text = json.dumps(head, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + (8 + buffer.length if buffer.length else 0)
    if size >= 1 << 32:
        raise ResultError(
            f"{run.path} would be {size / 2**30:.1f} GiB of glTF, which can have 4: choose a part "
            "with --from and --until" + (", or leave --all out" if every_row else "")
        )

    def words(*numbers: int) -> bytes:
        return np.array(numbers, dtype="<u4").tobytes()

    file.write(b"glTF" + words(2, size, len(text)) + b"JSON" + text)
    if buffer.length:
        file.write(words(buffer.length) + b"BIN\0")
        for array in buffer.arrays:
            flat = array.reshape(-1)
            for start in range(0, len(flat), CHUNK):
                file.write(flat[start : start + CHUNK].tobytes())


# ---- The motion --------------------------------------------------------------------------------


def motion_of(
    run: Run,
    time: np.ndarray,
    position: np.ndarray,
    quaternion: np.ndarray,
    rate: np.ndarray,
    *,
    every_row: bool,
) -> Motion:
    """Keys of the motion of a body: of its rows those that it takes, and more where it makes much
    of a turn between two."""
    quaternion = quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)
    turned = thinning.integral(time, rate)
    at, fine = refined(run, time, turned)
    all_at = np.arange(len(time))
    if every_row:
        moved = all_at
        kept = np.arange(len(at))
    else:
        # What times in 32 bits leave of it, and numbers in 32 bits.
        length, angle = 0.95 * DRAWN_LENGTH * run.scale, 0.95 * DRAWN_ANGLE
        moved = thinning.keys(len(time), thinning.distance_error(time, position, length))
        poses = attitudes(time, quaternion, turned, fine)
        error = thinning.turn_error(fine, poses, np.zeros((len(fine), 3)), angle)
        way = np.stack([np.interp(fine, time, turned[:, k]) for k in range(3)], axis=1)

        def near(first: np.ndarray, last: np.ndarray, at: np.ndarray) -> np.ndarray:
            short = np.linalg.norm(way[last] - way[first], axis=1) < STEP * (1 + 1e-6)
            return np.where(short[:, None], error(first, last, at), np.inf)

        kept = thinning.keys(len(fine), near)
    moved_at = ticks(time, time[moved])
    turned_at = ticks(time, fine[kept])
    # Poses at the times that the file can tell.
    shown = np.clip(time[0] + moved_at.astype(float), time[0], time[-1])
    places = np.stack([np.interp(shown, time, position[:, k]) for k in range(3)], axis=1)
    shown = np.clip(time[0] + turned_at.astype(float), time[0], time[-1])
    poses = attitudes(time, quaternion, turned, shown)
    signs = np.where(np.sum(poses[1:] * poses[:-1], axis=1) < 0, -1.0, 1.0)
    poses[1:] *= np.cumprod(signs)[:, None]
    return Motion(moved_at, places, turned_at, poses)


def coil_of(
    run: Run,
    time: np.ndarray,
    spring: springing.Spring,
    poses: dict[int, tuple[np.ndarray, np.ndarray]],
    *,
    every_row: bool,
) -> Coil:
    """Keys of the coil of a spring, of whose bodies there are positions and attitudes."""
    first, second = springing.ends(spring, poses, len(time))
    begin, way = springing.axis(first, second, springing.WIDTH * run.scale)
    length = np.linalg.norm(way, axis=1, keepdims=True)
    unit, end = way / length, begin + way
    tolerance = 0.95 * DRAWN_LENGTH * run.scale

    def error(from_: np.ndarray, to: np.ndarray, at: np.ndarray) -> np.ndarray:
        share = thinning.shares(time, from_, to, at)[..., None]
        start = begin[from_][:, None] * (1 - share) + begin[to][:, None] * share
        long = length[from_][:, None] * (1 - share) + length[to][:, None] * share
        cosine = np.sum(unit[from_] * unit[to], axis=1)
        angle = np.arccos(np.clip(cosine, -1, 1))[:, None, None]
        sine = np.where(angle > 1e-6, np.sin(angle), 1.0)
        weights = [np.where(angle > 1e-6, np.sin(x * angle) / sine, x) for x in (1 - share, share)]
        along = weights[0] * unit[from_][:, None] + weights[1] * unit[to][:, None]
        off = np.maximum(
            np.linalg.norm(start - begin[at], axis=-1),
            np.linalg.norm(start + long * along - end[at], axis=-1),
        )
        return np.where(angle[..., 0] < STEP, off / tolerance, np.inf)

    kept = np.arange(len(time)) if every_row else thinning.keys(len(time), error)
    at, chosen = np.unique((time[kept] - time[0]).astype(np.float32), return_index=True)
    kept = kept[chosen]
    names = [run.bodies[body] if body >= 0 else "ground" for body in spring.bodies]
    turned = springing.frames(way[kept])
    return Coil(spring.name, spring.kind, names, at, begin[kept], turned, length[kept, 0])


def refined(run: Run, time: np.ndarray, turned: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times of the rows, and such between them that no two are more than `STEP` apart; of each the
    row that it follows."""
    steps = np.linalg.norm(np.diff(turned, axis=0), axis=1)
    counts = np.maximum(np.ceil(steps / STEP), 1).astype(int)
    if counts.sum() > MOST_KEYS:
        raise ResultError(
            f"a body of {run.path} makes {steps.sum() / (2 * np.pi):.3g} turns, which glTF cannot "
            "tell: choose a part of them with --from and --until"
        )
    at = np.repeat(np.arange(len(counts)), counts)
    first = np.cumsum(counts) - counts
    share = (np.arange(len(at)) - first[at]) / counts[at]
    fine = time[at] + share * (time[at + 1] - time[at]) if len(at) else time[:0]
    return np.append(at, len(time) - 1), np.append(fine, time[-1])


def attitudes(
    time: np.ndarray, quaternion: np.ndarray, turned: np.ndarray, when: np.ndarray
) -> np.ndarray:
    """Attitudes at any times: between two rows as the angular velocity tells."""
    if len(time) < 2:
        return np.repeat(quaternion[:1], len(when), axis=0)
    at = np.clip(np.searchsorted(time, when, side="right") - 1, 0, len(time) - 2)
    share = ((when - time[at]) / (time[at + 1] - time[at]))[:, None]
    poses = thinning.between(quaternion[at], quaternion[at + 1], turned[at + 1] - turned[at], share)
    return poses / np.linalg.norm(poses, axis=1, keepdims=True)


def ticks(time: np.ndarray, when: np.ndarray) -> np.ndarray:
    """Times from the beginning in 32 bits, of which no two are the same."""
    return np.unique((when - time[0]).astype(np.float32))


# ---- The head ----------------------------------------------------------------------------------


def head_of(
    run: Run,
    time: np.ndarray,
    motions: list[Motion],
    coils: list[Coil],
    surfaces: list[meshes.Placed],
    buffer: Buffer,
) -> dict:
    """What the file says of its numbers."""
    gravity = gravity_of(run)
    up = -gravity / np.linalg.norm(gravity) if gravity.any() else np.array([0.0, 0.0, 1.0])
    title = as_text(run.file.attrs.get("title", "")) or run.path.stem
    nodes: list[dict] = [{"name": title, "rotation": to_gltf(upright(up))}]
    ground = {"name": "ground"}
    bodies = [
        {
            "name": name,
            "translation": motion.position[0].astype(np.float32).tolist(),
            "rotation": to_gltf(motion.quaternion[0]),
        }
        for name, motion in zip(run.bodies, motions, strict=True)
    ]
    children = list(range(1, 1 + len(bodies)))
    nodes += bodies
    if any(surface.body < 0 for surface in surfaces):
        children.append(len(nodes))
        nodes.append(ground)
    kinds = Kinds(buffer)
    first_coil = len(nodes)
    for coil in coils:
        children.append(len(nodes))
        nodes.append(
            {
                "name": coil.name,
                "mesh": kinds.mesh(springing.placed(coil.name, run.scale, coil.length[0])),
                "translation": coil.begin[0].astype(np.float32).tolist(),
                "rotation": to_gltf(coil.quaternion[0]),
                "scale": [1.0, 1.0, float(np.float32(coil.length[0]))],
                "extras": {"spring": coil.kind, "bodies": coil.bodies},
            }
        )
    if children:
        nodes[0]["children"] = children
    for surface in surfaces:
        owner = ground if surface.body < 0 else bodies[surface.body]
        owner.setdefault("children", []).append(len(nodes))
        nodes.append(
            {
                "name": surface.name,
                "mesh": kinds.mesh(surface),
                "translation": surface.centre.tolist(),
                "rotation": to_gltf(thinning.quaternions(surface.axes.T[None])[0]),
                "extras": {
                    "shape": surface.shape,
                    "side": "inside" if surface.inside else "outside",
                    "material": surface.material,
                },
            }
        )
    head = {
        "asset": {
            "version": "2.0",
            "generator": f"contensou {as_text(run.file.attrs.get('program_version', ''))}".strip(),
            "extras": {"source": run.path.name, "start": float(time[0]), "end": float(time[-1])},
        },
        "scene": 0,
        "scenes": [{"name": title, "nodes": [0]}],
        "nodes": nodes,
    }
    animation = animation_of(motions, coils, first_coil, buffer)
    if animation["channels"]:
        head["animations"] = [animation]
    if kinds.meshes:
        head |= {"meshes": kinds.meshes, "materials": kinds.materials}
    if buffer.length:
        head |= {
            "accessors": buffer.accessors,
            "bufferViews": buffer.views,
            "buffers": [{"byteLength": buffer.length}],
        }
    return head


def animation_of(motions: list[Motion], coils: list[Coil], first_coil: int, buffer: Buffer) -> dict:
    """Channels of the bodies that move, and of the springs, whose nodes are the last ones."""
    animation = {"name": "motion", "channels": [], "samplers": []}
    inputs: dict[bytes, int] = {}

    def put(node: int, path: str, at: np.ndarray, values: np.ndarray, kind: str) -> None:
        if len(at) < 2 or (values == values[0]).all():
            return
        key = at.tobytes()
        if key not in inputs:
            inputs[key] = buffer.put(at, "SCALAR", bounds=True)
        number = len(animation["samplers"])
        animation["channels"].append({"sampler": number, "target": {"node": node, "path": path}})
        animation["samplers"].append(
            {
                "input": inputs[key],
                "output": buffer.put(values, kind),
                "interpolation": "LINEAR",
            }
        )

    for i, motion in enumerate(motions, start=1):
        put(i, "translation", motion.moved_at, motion.position, "VEC3")
        put(i, "rotation", motion.turned_at, motion.quaternion[:, [1, 2, 3, 0]], "VEC4")
    for i, coil in enumerate(coils, start=first_coil):
        put(i, "translation", coil.at, coil.begin, "VEC3")
        put(i, "rotation", coil.at, coil.quaternion[:, [1, 2, 3, 0]], "VEC4")
        scale = np.ones((len(coil.at), 3))
        scale[:, 2] = coil.length
        put(i, "scale", coil.at, scale, "VEC3")
    return animation


class Kinds:
    """Meshes and materials, each once."""

    def __init__(self, buffer: Buffer) -> None:
        self.buffer = buffer
        self.meshes: list[dict] = []
        self.materials: list[dict] = []
        self.known_meshes: dict[tuple, int] = {}
        self.known_materials: dict[tuple, int] = {}
        self.known_points: dict[int, tuple[dict, list[int]]] = {}

    def mesh(self, surface: meshes.Placed) -> int:
        """The mesh of a surface in its colours."""
        both = [self.material(surface, k) for k in (0, 1)]
        key = (id(surface.mesh), *both)
        if key not in self.known_meshes:
            attributes, indices = self.points(surface.mesh)
            primitives = [
                {"attributes": attributes, "indices": indices[k], "material": both[k]}
                for k in (0, 1)
                if indices[k] >= 0
            ]
            self.known_meshes[key] = len(self.meshes)
            self.meshes.append({"name": surface.name, "primitives": primitives})
        return self.known_meshes[key]

    def points(self, mesh: meshes.Mesh) -> tuple[dict, list[int]]:
        """Accessors of the points and of the triangles of each colour."""
        if id(mesh) not in self.known_points:
            attributes = {
                "POSITION": self.buffer.put(mesh.points, "VEC3", VERTICES, bounds=True),
                "NORMAL": self.buffer.put(mesh.normals, "VEC3", VERTICES),
            }
            indices = [
                self.buffer.put(part.ravel(), "SCALAR", INDICES) if len(part) else -1
                for part in mesh.triangles
            ]
            self.known_points[id(mesh)] = (attributes, indices)
        return self.known_points[id(mesh)]

    def material(self, surface: meshes.Placed, k: int) -> int:
        """One of the two colours of a surface; it has the name of its material."""
        both_sides = surface.shape == "plane"
        key = (surface.material, surface.colours[k], both_sides)
        if key not in self.known_materials:
            rough = {
                "baseColorFactor": [*(linear(x) for x in surface.colours[k]), 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 0.6,
            }
            self.known_materials[key] = len(self.materials)
            self.materials.append(
                {
                    "name": surface.material,
                    "pbrMetallicRoughness": rough,
                    "doubleSided": both_sides,
                }
            )
        return self.known_materials[key]


def linear(value: int) -> float:
    """A share of light from a byte of sRGB."""
    share = value / 255
    return share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4


def to_gltf(quaternion: np.ndarray) -> list[float]:
    """A unit quaternion w, x, y, z as glTF has it."""
    unit = quaternion / np.linalg.norm(quaternion)
    return unit[[1, 2, 3, 0]].tolist()


def upright(up: np.ndarray) -> np.ndarray:
    """The rotation that turns a direction to that of glTF's y."""
    y = np.array([0.0, 1.0, 0.0])
    if up @ y < -1 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    return meshes.unit(np.concatenate([[1 + up @ y], np.cross(up, y)]))
