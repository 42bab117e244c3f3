"""Scenes and settings as the program reads them, from what Python has."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contensou._errors import SceneError

NAME = re.compile(r"[A-Za-z]\w*")
KEY = re.compile(r"[A-Za-z]\w*(\(\s*\d+\s*\))?")

#: The name of a scene file, the text of a scene, or its groups.
Scene = str | os.PathLike[str] | Mapping[str, Any]

#: Values by path, as after `--set`, or texts PATH=VALUE.
Settings = Mapping[str, Any] | Iterable[str] | None


class Expression(str):
    """A text that stands in a scene as it is, not as a text in quotes: `Expression("30 deg")`."""

    __slots__ = ()


def scene_text(groups: Mapping[str, Any]) -> str:
    """The text of a scene.

    Parameters
    ----------
    groups
        Values by key, by group. A group that occurs several times is a list of such. Values are
        numbers, texts, logicals and (nested) sequences or arrays of them; an `Expression` is
        written as it is.

    Examples
    --------
    >>> print(scene_text({"scene": {"t_end": 2, "gravity": (0, 0, -9.81)},
    ...                   "body": [{"name": "a", "mass": 1e-3}, {"name": "it's"}],
    ...                   "material": {"young": Expression("210*10**9")}}))
    &scene
       t_end = 2
       gravity = 0, 0, -9.81
    /
    &body
       name = 'a'
       mass = 0.001
    /
    &body
       name = 'it''s'
    /
    &material
       young = 210*10**9
    /
    <BLANKLINE>
    """
    lines = []
    for group, found in groups.items():
        if not isinstance(group, str) or not NAME.fullmatch(group):
            raise SceneError(f"{group!r} is no name of a group", 2)
        for keys in [found] if isinstance(found, Mapping) else found:
            if not isinstance(keys, Mapping):
                raise SceneError(f"group &{group}: expected a dictionary or a list of such", 2)
            lines.append(f"&{group}")
            for key, value in keys.items():
                if not isinstance(key, str) or not KEY.fullmatch(key):
                    raise SceneError(f"group &{group}: {key!r} is no name of a key", 2)
                lines.append(f"   {key} = {value_text(value, f'{group}.{key}')}")
            lines.append("/")
    return "\n".join([*lines, ""])


def value_text(value: Any, place: str = "") -> str:
    """A value as a namelist has it.

    >>> value_text([True, "a", 0.1])
    ".true., 'a', 0.1"
    """
    if isinstance(value, Expression):
        return str(value)
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, (bool, np.bool_)):
        return ".true." if value else ".false."
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        if not np.isfinite(value):
            raise SceneError(f"{place}: {value} is no number".removeprefix(": "), 2)
        return repr(float(value))
    if isinstance(value, np.ndarray):
        value = value.tolist()
        if not isinstance(value, list):
            return value_text(value, place)
    if isinstance(value, (Mapping, bytes)) or not isinstance(value, Iterable):
        kind = type(value).__name__
        raise SceneError(f"{place}: a {kind} cannot stand in a scene".removeprefix(": "), 2)
    return ", ".join(value_text(item, place) for item in value)


def settings_texts(settings: Settings) -> list[str]:
    """Settings as texts after `--set`; a text value stands as it is.

    >>> settings_texts({"top.spin": (0, 0, 200), "contact.friction": "pade22"})
    ['top.spin=0, 0, 200', 'contact.friction=pade22']
    """
    if settings is None:
        return []
    if isinstance(settings, str):
        raise SceneError("settings: expected a dictionary or a list of texts, not a text", 2)
    if not isinstance(settings, Mapping):
        texts = list(settings)
        if not all(isinstance(text, str) for text in texts):
            raise SceneError("settings: expected texts PATH=VALUE", 2)
        return texts
    found = []
    for path, value in settings.items():
        if not isinstance(path, str):
            raise SceneError(f"settings: {path!r} is no path such as 'body.mass'", 2)
        text = value if isinstance(value, str) else value_text(value, path)
        found.append(f"{path}={text}")
    return found


def is_text(scene: str) -> bool:
    """Whether this is the text of a scene, not the name of a file."""
    return "\n" in scene or scene.lstrip().startswith(("&", "!"))


def scene_file(scene: Scene, folder: Path) -> tuple[str, Path]:
    """The name of a file with the scene and the folder to see it from.

    What is no file as yet is written into the folder that is given.
    """
    if isinstance(scene, Mapping):
        text = scene_text(scene)
    elif isinstance(scene, str) and is_text(scene):
        text = scene
    else:
        return os.fspath(scene), Path.cwd()
    (folder / "scene.nml").write_text(text, encoding="utf-8")
    return "scene.nml", folder
