"""Kernels of the program, for spots that an option describes."""

from __future__ import annotations

import csv
import io

import numpy as np

from . import program
from .results import UsageError


def described(
    words: str, names: tuple[str, ...], positive: tuple[str, ...], texts: tuple[str, ...] = ()
) -> dict:
    """What an option such as a=1e-3,b=5e-4,model=pade22 says: numbers, and texts; b is a if it is
    not given."""
    found: dict = {}
    known = (*names, *texts)
    for word in words.split(","):
        key, equals, value = (part.strip() for part in word.partition("="))
        if not equals or key not in known:
            raise UsageError(f"'{word}': expected {', '.join(f'{name}=' for name in known)}")
        if key in texts:
            found[key] = value
            continue
        try:
            found[key] = float(value)
        except ValueError:
            found[key] = np.nan
        if not np.isfinite(found[key]) or (key in positive and found[key] <= 0):
            kind = "a positive number" if key in positive else "a number"
            raise UsageError(f"'{word}': expected {kind}")
    if "a" not in found:
        raise UsageError("the semi-axis a= [m] of the spot is missing")
    found.setdefault("b", found["a"])
    return found


def evaluated(
    kernel: str, inputs: tuple[str, ...], rows: list, outputs: tuple[str, ...], *options: object
) -> np.ndarray:
    """Outputs of a kernel for rows of inputs, a row for each."""
    text = io.StringIO()
    csv.writer(text).writerows([inputs, *rows])
    answer = program.call("eval", kernel, *options, text=text.getvalue(), executable=program.find())
    head, *lines = csv.reader(io.StringIO(answer))
    places = [head.index(name) for name in outputs]
    return np.array([[float(line[place]) for place in places] for line in lines])
