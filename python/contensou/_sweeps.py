"""Sweeps: a scene run many times with other values, on all cores."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import xarray

from contensou import _arguments as arguments
from contensou._errors import SceneError
from contensou._runs import IMAGE, call, folder_of_its_own
from contensou._scenes import Scene, Settings, scene_file, scene_text, settings_texts

#: Is told the share of the cases that are done, 0 to 1, and a line about it.
Watcher = Callable[[float, str], object]


def sweep(
    scene: Scene,
    parameters: Mapping[str | tuple[str, ...], Any],
    settings: Settings = None,
    *,
    sampling: str = "grid",
    keep: Iterable[str] = ("summary", "events"),
    values: Iterable[Mapping[str, Any]] = (),
    jobs: int | None = None,
    progress: bool | Watcher = False,
    **options: Any,
) -> xarray.Dataset:
    """Run a scene with all values of some parameters.

    Parameters
    ----------
    scene
        Name of a scene file, text of a scene, or dictionary of its groups.
    parameters
        By path, such as `"top.spin(3)"`, or by several paths that get the same value: a list of
        values, or a dictionary with the keys `first`, `last`, `count`, `vary` and `column` of the
        group &parameter of a sweep file.
    settings
        Values that hold for all cases, by path.
    sampling
        "grid", "latin_hypercube" or "sobol"; the last two need `cases=`.
    keep
        Which results: "summary", "events", "final_state", "nothing", or names of results.
    values
        More results, each a dictionary with the keys of the group &value: `name`, `dataset`, `of`,
        `component`, `time` [s].
    jobs
        Threads; all cores if not given.
    progress
        Whether to show how far it is, on sys.stderr, or what is told.
    **options
        More keys of the group &sweep: `cases`, `seed`, `time_limit` [s].

    Returns
    -------
    xarray.Dataset
        Parameters are coordinates, results variables, with `units`. For a grid each parameter is a
        dimension; otherwise there is the dimension `case`. `status` is 0 for a case that is
        complete, `message` says why another one is not.

    Examples
    --------
    >>> table = sweep("tippe_top.nml", {"top.spin(3)": [150, 180], "top.angle": [0.1, 0.2, 0.3]},
    ...               {"scene.t_end": 0.01})
    >>> table.energy_error.dims
    ('top.spin(3)', 'top.angle')
    >>> int(table.status.max())
    0
    """
    groups = groups_of(parameters)
    counts = [count_of(group) for group in groups] if sampling == "grid" else []
    wanted = arguments.items(values, "values", "a list of dictionaries of keys of the group &value")
    with folder_of_its_own() as folder:
        name, place = scene_file(scene, folder)
        head: dict[str, Any] = {
            "scene": str(place / name),
            "output": "sweep.h5",
            "sampling": sampling,
        }
        head |= {"keep": arguments.names(keep, "keep"), **options}
        if texts := settings_texts(settings):
            head["set"] = texts
        text = scene_text({"sweep": head, "parameter": groups, "value": wanted})
        (folder / "sweep.nml").write_text(text, encoding="utf-8")
        words = ["-j", str(arguments.whole(jobs, "jobs"))] if jobs is not None else []
        watcher = watcher_of(progress)
        call("sweep", "sweep.nml", *words, folder=folder, watch=watcher)
        data = (folder / "sweep.h5").read_bytes()
    return table_of(data, counts)


def groups_of(parameters: Mapping[str | tuple[str, ...], Any]) -> list[dict[str, Any]]:
    """The groups &parameter."""
    if not isinstance(parameters, Mapping):
        shown = arguments.shown(parameters)
        raise SceneError(f"parameters: expected a dictionary of values by path, not {shown}", 2)
    groups = []
    for path, found in parameters.items():
        if isinstance(found, Mapping):
            keys = dict(found)
        else:
            expected = (
                "a list of values, or a dictionary such as {'first': 0, 'last': 1, 'count': 3}"
            )
            keys = {"values": arguments.items(found, f"parameter {path!r}", expected)}
        groups.append({"name": path, **keys})
    return groups


def count_of(group: Mapping[str, Any]) -> int:
    """How many values a parameter has."""
    if "values" in group:
        return arguments.size(group["values"])
    # Without a count the program says that it is missing.
    return arguments.whole(group.get("count", 0), f"count of parameter {group['name']!r}")


def table_of(data: bytes, counts: list[int]) -> xarray.Dataset:
    """The table of a sweep, over its parameters if their counts are given."""

    def part(group: str | None) -> xarray.Dataset:
        with xarray.open_dataset(
            io.BytesIO(data), group=group, engine="h5netcdf", decode_timedelta=False
        ) as opened:
            return opened.load()

    whole = part(None)
    parameters, results = part("parameters"), part("results")
    if not counts:
        table = whole.merge(results.drop_attrs(deep=False)).assign_coords(parameters.data_vars)
    else:
        names = [str(name) for name in np.atleast_1d(parameters.attrs["columns"])]
        table = xarray.Dataset(attrs=whole.attrs)
        for name, index in zip(names, np.indices(counts).reshape(len(counts), -1), strict=True):
            column = parameters[name]
            first = [int(np.flatnonzero(index == i)[0]) for i in range(index.max() + 1)]
            table = table.assign_coords({name: (name, column.values[first], column.attrs)})
        columns = {"case": whole.case, **whole.data_vars, **results.data_vars}
        for label, column in columns.items():
            table[label] = (names, column.values.reshape(counts), column.attrs)
    table.encoding[IMAGE] = data
    return table


def watcher_of(progress: bool | Watcher) -> Watcher | None:
    """What is told how far a sweep is."""
    if callable(progress):
        return progress
    return show if progress else None


def show(share: float, line: str) -> None:
    """A bar on sys.stderr."""
    done = round(30 * share)
    end = "\n" if share >= 1 else ""
    sys.stderr.write(f"\r[{'#' * done}{'.' * (30 - done)}] {line}\x1b[K{end}")
    sys.stderr.flush()
