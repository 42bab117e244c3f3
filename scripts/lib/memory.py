"""Friction with a memory: which contacts of a run have it, and what there is to see of it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .results import as_text

if TYPE_CHECKING:
    import h5py

    from .drawable import Run

# Columns that tell it, and what the page gets of each row: the share of the spot that sticks, or
# the direction of slip along the axes, with the spin times sqrt(a b), and that of the material
# that passes.
TOLD_BY = {"elastic": "stuck_share", "rolling": "rolling_velocity"}
WIDTHS = {"elastic": 1, "rolling": 5}


@dataclass(frozen=True)
class Memory:
    """What a contact remembers."""

    kind: str
    width: int
    coefficient: float


def of_contacts(run: Run) -> dict[int, Memory]:
    """The contacts of a run, by their numbers, with a memory that its rows tell of."""
    text = as_text(run.file["input/resolved"][()]) if "input/resolved" in run.file else ""
    found = {}
    for group in re.findall(r"(?ims)^\s*&contact\s*$(.*?)^\s*/\s*$", text):
        keys = dict(re.findall(r"(?im)^\s*(\w+)\s*=\s*(.*?)\s*$", group))
        kind = keys.get("tangential", "").strip("'")
        kind = "elastic" if kind == "spring" else kind
        if kind not in TOLD_BY or run.column(TOLD_BY[kind]) is None:
            continue
        name = keys.get("name", "")[1:-1].replace("''", "'")
        if name in run.contacts:
            found[run.contacts.index(name)] = Memory(
                kind, WIDTHS[kind], float(keys["friction_coefficient"])
            )
    return found


def columns(
    rows: h5py.Group,
    part: slice,
    contact: int,
    values: np.ndarray,
    frame: np.ndarray,
    kept: Memory | None,
) -> np.ndarray:
    """What there is to see of the memory of a contact (rows, width), of `values` of its rows."""
    if kept is None:
        return np.zeros((len(values), 0))
    told = np.asarray(rows[TOLD_BY[kept.kind]][part, contact])
    if kept.kind == "elastic":
        return np.clip(np.nan_to_num(told), 0, 1)[:, None]
    axes = np.nan_to_num(frame[:, :, :2])
    slip = values[:, 4:7] * np.stack(
        [np.ones(len(values))] * 2 + [np.sqrt(values[:, 7] * values[:, 8])], axis=1
    )
    return np.concatenate([directions(slip), directions(np.einsum("ti,tij->tj", told, axes))], 1)


def directions(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length 1, or 0 where there is none."""
    vectors = np.nan_to_num(vectors)
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, size, out=np.zeros_like(vectors), where=size > 0)
