"""The table of a sweep as one HTML file: its cases as points that one can ask."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import h5py
import numpy as np

from . import charting, drawable, tables
from .pages import Package, page
from .results import ResultError, as_text, keyword_values, names, open_file

MOST_CASES = 60_000
MOST_NUMBERS = 600_000
MOST_TRAJECTORIES = 24
QUOTED = r"(?:'(?:[^']|'')*'|\"(?:[^\"]|\"\")*\")"


def view(path: Path) -> str:
    """The page of a table."""
    with open_file(path) as file:
        for name in ("parameters", "results", "status", "case"):
            if name not in file:
                raise ResultError(f"{path} says that it is a contensou-sweep, but has no /{name}")
    sweep = tables.read(path)
    with open_file(path) as file:
        return page("sweep", data_of(path, sweep, file))


def data_of(path: Path, sweep: tables.Sweep, file: h5py.File) -> str:
    """What the page gets."""
    package = Package()
    total = len(sweep.status)
    columns = {**sweep.parameters, **sweep.results}
    most = max(1, min(MOST_CASES, MOST_NUMBERS // max(1, len(columns))))
    kept = np.arange(0, total, -(-total // most))
    number = np.asarray(file["case"][()])
    text = as_text(file["input/sweep"][()]) if "input/sweep" in file else ""
    messages = names(file["message"]) if "message" in file else [""] * total
    head = {
        "title": sweep.title,
        "file": path.name,
        "program": sweep.version,
        "cases": total,
        "total": sweep.total,
        "number": package.put(number[kept], "f8"),
        "status": package.put(sweep.status[kept], "u1"),
        "meanings": [sweep.meanings.get(i, "") for i in range(max(sweep.meanings, default=0) + 1)],
        "messages": {str(k): messages[i] for k, i in enumerate(kept) if messages[i]},
        "parameters": [put(package, column, kept, True) for column in sweep.parameters.values()],
        "results": [put(package, column, kept, False) for column in sweep.results.values()],
        "colour": first_result(sweep, text),
        "command": ["contensou", "run", *base_of(text, file)],
        "about": text,
        "scene": as_text(file["input/resolved"][()]) if "input/resolved" in file else "",
    }
    head["trajectories"] = trajectories(path, text, number, package)
    return package.text(head)


def put(package: Package, column: tables.Column, kept: np.ndarray, exact: bool) -> dict:
    """A column: numbers, or the places of words in a list; parameters to their last bit."""
    values = column.values[kept]
    said = {"name": column.name, "unit": column.unit, "meaning": column.meaning}
    if column.is_text:
        words = list(dict.fromkeys(values))
        index = {word: i for i, word in enumerate(words)}
        places = np.array([index[value] for value in values], dtype=float)
        return {**said, "words": words, "values": package.put(places, "f4")}
    values = values.astype(float)
    logarithmic = bool(tables.is_logarithmic(values))
    kind = "f8" if exact or column.values.dtype.kind in "iu" else "f4"
    return {**said, "log": logarithmic, "values": package.put(values, kind)}


def first_result(sweep: tables.Sweep, text: str) -> int:
    """The result that is drawn first, of those that differ between cases: a first touch that few
    cases have tells most, then what the sweep asks for by name."""
    asked = set(keyword_values(text, "name"))

    def rank(name: str) -> tuple[bool, int, bool]:
        values = sweep.results[name].values
        if values.dtype.kind not in "fiu":
            return len(set(values)) > 1, 0, name in asked
        good = values[np.isfinite(values)]
        lacking = len(values) - len(good) if name.startswith("first_touch") else 0
        return len(good) > 0 and bool(np.ptp(good) > 0), lacking, name in asked

    found = list(sweep.results)
    return found.index(max(found, key=rank)) if found else -1


def base_of(text: str, file: h5py.File) -> list[str]:
    """Words of the command that all cases have: the scene, and what is set for all."""
    plain = without_comments(text)
    words = [next(iter(keyword_values(text, "scene")), "SCENE.nml")]
    group = re.search(r"(?is)&sweep\b(.*?)(?:^|\s)/\s*$", plain + "\n", re.MULTILINE)
    listed = re.search(
        rf"(?is)(?<!\w)set\s*=\s*({QUOTED}(?:\s*,?\s*{QUOTED})*)", group[1] if group else ""
    )
    for value in re.findall(QUOTED, listed[1]) if listed else []:
        words += ["--set", value[1:-1].replace(2 * value[0], value[0])]
    given = as_text(file["input/command_line"][()]) if "input/command_line" in file else ""
    try:
        given = shlex.split(given)
    except ValueError:
        return words
    for i, word in enumerate(given):
        value = word[6:] if word.startswith("--set=") else ""
        if word == "--set" and i + 1 < len(given):
            value = given[i + 1]
        if value and not value.replace(" ", "").lower().startswith("sweep."):
            words += ["--set", value]
    return words


def without_comments(text: str) -> str:
    """A namelist without what stands behind exclamation marks."""
    return re.sub(r"^((?:[^'\"!\n]|'[^'\n]*'|\"[^\"\n]*\")*)!.*", r"\1", text, flags=re.MULTILINE)


def trajectories(path: Path, text: str, number: np.ndarray, package: Package) -> list[dict]:
    """The charts of the cases whose whole runs were kept, and still lie beside the table."""
    found = []
    pattern = re.compile(re.escape(path.stem) + r"_case_(\d+)" + re.escape(path.suffix))
    files = sorted(
        (int(match[1]), file)
        for file in path.parent.iterdir()
        if (match := pattern.fullmatch(file.name))
    )
    of_table = set(number.tolist())
    for case, file in files:
        if case not in of_table or len(found) == MOST_TRAJECTORIES:
            continue
        try:
            with open_file(file) as data:
                run = drawable.open_run(file, data)
                strips = charting.pack_charts(run, package, buckets=120)
        except (ResultError, OSError, KeyError):
            continue
        found.append(
            {"case": case, "file": file.name, "end": float(run.time[-1]), "charts": strips}
        )
    return found
