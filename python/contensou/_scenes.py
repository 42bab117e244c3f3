"""Scenes and settings as the program reads them, from what Python has."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contensou import _arguments as arguments
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
        what = f"group &{group}"
        expected = "a dictionary of keys and values, or a list of such"
        several = [found] if isinstance(found, Mapping) else arguments.items(found, what, expected)
        for keys in several:
            if not isinstance(keys, Mapping):
                raise SceneError(f"{what}: expected {expected}, not {arguments.shown(keys)}", 2)
            lines.append(f"&{group}")
            for key, value in keys.items():
                if not isinstance(key, str) or not KEY.fullmatch(key):
                    raise SceneError(f"{what}: {key!r} is no name of a key", 2)
                lines.append(f"   {key} = {value_text(value, f'{group}.{key}')}")
            lines.append("/")
    return "\n".join([*lines, ""])


def value_text(value: Any, place: str = "") -> str:
    """A value as a namelist has it.

    >>> value_text([True, "a", 0.1])
    ".true., 'a', 0.1"
    """
    if isinstance(value, str):
        found = arguments.text(value, place or "a text")
        return str(found) if isinstance(value, Expression) else "'" + found.replace("'", "''") + "'"
    if isinstance(value, (bool, np.bool_)):
        return ".true." if value else ".false."
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        if not np.isfinite(value):
            raise SceneError(f"{place}: {value} is no number".removeprefix(": "), 2)
        return repr(float(value))
    if hasattr(value, "__array__"):
        value = np.asarray(value).tolist()
        if not isinstance(value, list):
            return value_text(value, place)
    if isinstance(value, (Mapping, bytes, bytearray)) or not isinstance(value, Iterable):
        kind = type(value).__name__
        expected = "expected numbers, texts, logicals, or sequences of them"
        said = f"{place}: a {kind} cannot stand in a scene; {expected}"
        raise SceneError(said.removeprefix(": "), 2)
    return ", ".join(value_text(item, place) for item in value)


def settings_texts(settings: Settings) -> list[str]:
    """Settings as texts after `--set`; a text value stands as it is.

    >>> settings_texts({"top.spin": (0, 0, 200), "contact.friction": "pade22"})
    ['top.spin=0, 0, 200', 'contact.friction=pade22']
    """
    if settings is None:
        return []
    if not isinstance(settings, Mapping):
        texts = arguments.items(
            settings, "settings", "a dictionary of values by path, or a list of texts PATH=VALUE"
        )
        if not all(isinstance(text, str) for text in texts):
            raise SceneError("settings: expected texts PATH=VALUE in the list", 2)
        return [arguments.text(text, "settings") for text in texts]
    found = []
    for path, value in settings.items():
        if not isinstance(path, str):
            raise SceneError(f"settings: {path!r} is no path such as 'body.mass'", 2)
        if isinstance(value, Mapping):
            key = next(iter(value), "key")
            said = f"a dict cannot stand in a scene; write '{path}.{key}' for a value of it"
            raise SceneError(f"settings: {path}: {said}", 2)
        text = arguments.text(value, path) if isinstance(value, str) else value_text(value, path)
        found.append(f"{arguments.text(path, 'settings')}={text}")
    return found


def is_text(scene: str) -> bool:
    """Whether this is the text of a scene, not the name of a file."""
    return "\n" in scene or scene.lstrip().startswith(("&", "!"))


def text_or_name(scene: Scene) -> tuple[str | None, str]:
    """The text of a scene, None if it is in a file, and the name under which it is told of."""
    if isinstance(scene, Mapping):
        return scene_text(scene), "scene.nml"
    if isinstance(scene, str) and is_text(scene):
        return arguments.text(scene, "scene"), "scene.nml"
    if not isinstance(scene, (str, os.PathLike)):
        raise SceneError(
            "scene: expected the name of a file, the text of a scene or a dictionary of its "
            f"groups, not {arguments.shown(scene)}",
            2,
        )
    return None, file_name(scene, "scene")


def file_name(path: str | os.PathLike[str], what: str) -> str:
    """The name of a file, which is UTF-8 as all names are."""
    name = os.fsdecode(path)
    if "\0" in name or arguments.surrogate(name):
        raise SceneError(f"{what}: {name!a} is no name of a file in UTF-8", 2)
    return name


def scene_file(scene: Scene, folder: Path) -> tuple[str, Path]:
    """The name of a file with the scene and the folder to see it from.

    What is no file as yet is written into the folder that is given.
    """
    text, name = text_or_name(scene)
    if text is None:
        return name, Path.cwd()
    (folder / name).write_text(text, encoding="utf-8")
    return name, folder
