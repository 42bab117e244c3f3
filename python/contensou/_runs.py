"""Whole runs, by the program of this package, into memory."""

from __future__ import annotations

import contextlib
import io
import os
import re
import signal
import subprocess
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import xarray

from contensou._errors import SceneWarning, error_of
from contensou._prefix import PROGRAM
from contensou._scenes import Scene, Settings, scene_file, settings_texts

# A folder in memory, where the system has one, spares the disk.
MEMORY = Path("/dev/shm")

# How long a program that is interrupted may take to end [s].
PATIENCE = 10.0


def run(scene: Scene, settings: Settings = None) -> xarray.Dataset:
    """Simulate a scene to its end.

    Parameters
    ----------
    scene
        Name of a scene file, text of a scene, or dictionary of its groups.
    settings
        Values that differ, by path: `{"top.spin": (0, 0, 200)}`, or texts as after `--set`.

    Returns
    -------
    xarray.Dataset
        The group `trajectory` of the file that `contensou run` writes, bit for bit, in memory:
        `time` [s], `position` (time, body, xyz) [m], `quaternion` (time, body, wxyz),
        `normal_force` (time, contact) [N] and so on; each variable has its `units`.

    Raises
    ------
    SceneError, FileError, SimulationError
        With the text that the program shows. Warnings are given as `SceneWarning`.

    Examples
    --------
    >>> spun = run("tippe_top.nml", {"top.spin": (0, 0, 200), "scene.t_end": 0.01})
    >>> dict(spun.sizes)
    {'time': 11, 'body': 1, 'xyz': 3, 'wxyz': 4, 'contact': 2, 'axis': 2}
    >>> spun.position.attrs["units"]
    'm'
    """
    return dataset(image(scene, settings), "trajectory")


def run_tree(scene: Scene, settings: Settings = None) -> xarray.DataTree:
    """Simulate a scene to its end, and return all groups of the file.

    As `run`, with `trajectory`, `events`, `summary`, `body`, `contact`, `input` and the others;
    the attributes of the root tell version and status.

    >>> tree = run_tree("tippe_top.nml", {"scene.t_end": 0.01})
    >>> tree.attrs["status"]
    'complete'
    >>> int(tree["summary"].rows)
    11
    """
    data = image(scene, settings)
    with warnings.catch_warnings():
        # Texts of no length are no matter.
        warnings.simplefilter("ignore", UserWarning)
        tree = xarray.open_datatree(io.BytesIO(data), engine="h5netcdf", decode_timedelta=False)
    with tree:
        tree.load()
    for node in tree.subtree:
        node.encoding[IMAGE] = data
    return tree


# Under this name data carry the file that they are from, for pages and pictures.
IMAGE = "contensou_file"


def dataset(data: bytes, group: str) -> xarray.Dataset:
    """A group of a file, in memory."""
    with xarray.open_dataset(
        io.BytesIO(data), group=group, engine="h5netcdf", decode_timedelta=False
    ) as opened:
        opened.load()
    opened.encoding[IMAGE] = data
    return opened


def image(scene: Scene, settings: Settings = None) -> bytes:
    """The bytes of the file of a run."""
    words = [word for text in settings_texts(settings) for word in ("--set", text)]
    with folder_of_its_own() as folder:
        name, place = scene_file(scene, folder)
        file = folder / "run.h5"
        call("run", name, *words, "-q", "-o", str(file), folder=place)
        return file.read_bytes()


@contextlib.contextmanager
def folder_of_its_own() -> Iterator[Path]:
    """A folder for files of a moment, in memory if that can be had."""
    where = MEMORY if MEMORY.is_dir() and os.access(MEMORY, os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix=f"contensou-{os.getpid()}-", dir=where) as name:
        yield Path(name)


def call(*words: str, folder: Path, watch: Callable[[float, str], object] | None = None) -> str:
    """What the program prints; an error, or warnings, in words. An interrupt ends it, too.

    `watch` is told about progress: the share that is done, and a line about it.
    """
    # In a session of its own the program gets no signal but ours.
    with (
        tempfile.TemporaryFile() as out,
        subprocess.Popen(
            [PROGRAM, *words],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="backslashreplace",
            start_new_session=True,
        ) as process,
    ):
        try:
            assert process.stderr is not None
            said = [line for line in process.stderr if not is_progress(line, watch)]
            process.wait()
        except BaseException:
            end(process)
            raise
        out.seek(0)
        text = out.read().decode(errors="backslashreplace")
    problem = "".join(said).strip()
    if process.returncode != 0:
        raise error_of(process.returncode, problem or text)
    if problem:
        warnings.warn(problem, SceneWarning, stacklevel=4)
    return text


PROGRESS = re.compile(r"contensou: (?:(\d+) %, )?(.* cases.*)")


def is_progress(line: str, watch: Callable[[float, str], object] | None) -> bool:
    """Whether a line is about progress, which is passed on."""
    found = PROGRESS.fullmatch(line.rstrip())
    if found and watch:
        watch(int(found[1] or 0) / 100, found[2])
    return bool(found)


def end(process: subprocess.Popen[str]) -> None:
    """End the program, gently at first."""
    process.send_signal(signal.SIGINT)
    try:
        process.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
