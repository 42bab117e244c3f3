"""Pages and pictures of runs and sweeps, for notebooks and files."""

from __future__ import annotations

import contextlib
import html
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray

from contensou import _arguments as arguments
from contensou._errors import FileError, SceneError
from contensou._runs import IMAGE, folder_of_its_own, image
from contensou._scenes import Scene, Settings, file_name, is_text
from contensou._tools import tool

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: What can be drawn: what `run`, `run_tree` or `sweep` gave, an HDF5 file, or a scene to be run.
Drawable = xarray.Dataset | xarray.DataTree | Scene

SIGNATURE = b"\x89HDF\r\n\x1a\n"


class Page:
    """One HTML page that needs nothing else; a notebook shows it."""

    def __init__(self, text: str, height: int = 640) -> None:
        #: The whole page.
        self.html = text
        #: Its height in a notebook, in pixels.
        self.height = height

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file, which a browser opens."""
        name = file_name(path, "path")
        try:
            Path(name).write_text(self.html, encoding="utf-8")
        except OSError as problem:
            raise FileError(f"{name} cannot be written: {problem.strerror}", 74) from None

    def _repr_html_(self) -> str:
        """The page in a frame of its own."""
        return (
            f'<iframe style="width: 100%; height: {self.height}px; border: 0" '
            f'sandbox="allow-scripts allow-downloads" srcdoc="{html.escape(self.html)}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<contensou.Page of {len(self.html)} bytes; save(path) writes it>"


def view(what: Drawable, settings: Settings = None, *, height: int = 640) -> Page:
    """The page that shows a run in three dimensions, or the cases of a sweep.

    Parameters
    ----------
    what
        What `run`, `run_tree` or `sweep` gave, the name of an HDF5 file, or a scene to be run.
    settings
        Values that differ, for a scene.
    height
        Height in a notebook, in pixels.

    Examples
    --------
    >>> page = view("tippe_top.nml", {"scene.t_end": 0.01})
    >>> page.html.startswith("<!doctype html>")
    True
    """
    with file_of(what, settings) as (path, is_sweep):
        return Page(tool("sweeping" if is_sweep else "viewing").view(path), height)


def plot(
    what: Drawable,
    settings: Settings = None,
    *,
    result: Sequence[str] | None = None,
    over: Sequence[str] | None = None,
    kind: str | None = None,
    where: Mapping[str, Any] | None = None,
) -> Figure:
    """The picture that `contensou-plot` draws, as a figure of Matplotlib.

    Parameters
    ----------
    what, settings
        As for `view`.
    result, over, kind, where
        For the table of a sweep: names of results, of one or two parameters, "lines", "map" or
        "scatter", and the values at which other parameters are held. What is not given is chosen by
        the data.
    """
    try:
        import matplotlib as mpl
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError(
            f"contensou.plot needs matplotlib: {sys.executable} -m pip install matplotlib"
        ) from None
    kinds = tool("sweeps").KINDS
    if kind is not None and kind not in kinds:
        raise SceneError(f"kind: expected one of {', '.join(kinds)}, not {kind!r}", 2)
    if where is not None and not isinstance(where, Mapping):
        shown = arguments.shown(where)
        raise SceneError(f"where: expected a dictionary of values by parameter, not {shown}", 2)
    parameters = arguments.names(over, "over") if over is not None else None
    if parameters and (len(parameters) > 2 or len(set(parameters)) < len(parameters)):
        raise SceneError(f"over: expected one or two different parameters, not {over!r}", 2)
    chosen = tool("sweeps").Wishes(
        arguments.names(result, "result") if result is not None else None,
        parameters,
        kind,
        {name: str(value) for name, value in (where or {}).items()},
    )
    with file_of(what, settings) as (path, _), mpl.rc_context():
        try:
            figure: Figure = tool("drawing").draw_file(path, chosen)
        except tool("results").ResultError as problem:
            raise SceneError(str(problem).replace(f"{path} ", "the data "), 2) from None
        # A notebook would show it twice.
        plt.close(figure)
        return figure


@contextlib.contextmanager
def file_of(what: Drawable, settings: Settings) -> Iterator[tuple[Path, bool]]:
    """A file with what is to be drawn, and whether it is the table of a sweep."""
    if isinstance(what, (xarray.Dataset, xarray.DataTree)):
        data = what.encoding.get(IMAGE)
        if data is None:
            raise SceneError(
                "these data do not know the run that they are from: give what contensou.run gave",
                2,
            )
    elif isinstance(what, (str, os.PathLike)) and not (isinstance(what, str) and is_text(what)):
        try:
            data = Path(file_name(what, "file")).read_bytes()
        except OSError as problem:
            raise FileError(f"{what} cannot be read: {problem.strerror}", 74) from None
    else:
        data = b""
    if not data.startswith(SIGNATURE):
        data = image(what, settings)
    elif settings is not None:
        raise SceneError("settings are for a scene; this has been run", 2)
    with folder_of_its_own() as folder:
        path = folder / "run.h5"
        path.write_bytes(data)
        yield path, bool(tool("tables").is_sweep(path))
