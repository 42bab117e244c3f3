"""Arguments of functions, checked: a `SceneError` names the argument and says what it should be."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contensou._errors import SceneError


def text(value: object, what: str) -> str:
    """A text that can be encoded."""
    if not isinstance(value, str):
        raise SceneError(f"{what}: expected a text, not {shown(value)}", 2)
    for character, name in (("\0", "a zero byte"), (surrogate(value), "a lone surrogate")):
        if character and character in value:
            raise SceneError(f"{what}: {name} in {shown(value)}, which no file can hold", 2)
    return value


def surrogate(value: str) -> str:
    """The first half of a character, which is none, in a text; "" if there is none."""
    return next((c for c in value if "\ud800" <= c <= "\udfff"), "")


def names(value: object, what: str) -> list[str]:
    """Names in a list, or one alone."""
    if isinstance(value, str):
        return [text(value, what)]
    return [text(item, what) for item in items(value, what, "a list of names")]


def items(value: Any, what: str, expected: str) -> list[Any]:
    """What there is in something that can be gone through, but for texts and bytes."""
    try:
        if isinstance(value, (str, bytes, bytearray)):
            raise TypeError
        return list(value)
    except TypeError:
        raise SceneError(f"{what}: expected {expected}, not {shown(value)}", 2) from None


def number(value: object, what: str) -> float:
    """One number; that of a kernel may be no number."""
    found = numbers(value, what)
    if found.size != 1:
        raise SceneError(f"{what}: expected one number, not {shown(value)}", 2)
    return float(found.ravel()[0])


def whole(value: Any, what: str) -> int:
    """A whole number."""
    try:
        return operator.index(value)
    except TypeError:
        raise SceneError(f"{what}: expected a whole number, not {shown(value)}", 2) from None


def numbers(value: ArrayLike | object, what: str) -> np.ndarray:
    """Real numbers in the shape that they have."""
    try:
        found = np.asarray(value)
        real = found.dtype.kind in "biuf" or (
            found.dtype.kind == "O" and all(isinstance(item, Real) for item in found.flat)
        )
        if real:
            return found.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):
        pass
    raise SceneError(f"{what}: expected real numbers, not {shown(value)}", 2)


def size(value: object) -> int:
    """How many values a scene gets of a value, which may be a sequence of sequences."""
    if hasattr(value, "shape"):
        return math.prod(value.shape)
    if isinstance(value, Iterable) and not isinstance(value, str):
        return sum(map(size, value))
    return 1


def shown(value: object, longest: int = 60) -> str:
    """A value as Python writes it, cut if it is long."""
    said = ascii(value) if isinstance(value, str) else repr(value)
    return said if len(said) <= longest else f"{said[:longest]}..."
