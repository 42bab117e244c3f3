"""Write a run of contensou as a file of other programs that draw bodies.

`contensou export FILE.h5 --to gltf` calls it.
"""

from __future__ import annotations

import argparse
import contextlib
import signal
import sys
from pathlib import Path
from typing import BinaryIO

import numpy as np

from lib import drawable, gltf, labels, vtkhdf
from lib.results import (
    STATUS_FILE,
    ResultError,
    UsageError,
    as_text,
    check_output,
    damage_told,
    default_output,
    open_file,
    whole_file,
)

ENDINGS = {"gltf": ".glb", "vtk": ".vtkhdf"}


def main(name: str = "scripts/export") -> int:
    """Read the command line and write the file."""
    parser = argparse.ArgumentParser(
        prog=name,
        description="Writes a run as a file of programs that draw bodies, and prints its name. "
        "`contensou export` calls it; docs/export.md tells what is in the files.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="output file (HDF5, also .part)")
    parser.add_argument("--to", choices=ENDINGS, required=True, help="format")
    parser.add_argument("-o", "--output", type=Path, help="default beside FILE, as .glb or .vtkhdf")
    parser.add_argument("--from", type=float, dest="start", metavar="T", help="begin at [s]")
    parser.add_argument("--until", type=float, dest="end", metavar="T", help="end at [s]")
    parser.add_argument("--all", action="store_true", dest="every_row", help="leave no row out")
    parser.add_argument("--frames", type=int, metavar="N", help="vtk: so many rows, evenly spread")
    parser.add_argument("--force", action="store_true", help="replace an existing file")
    options = parser.parse_args()
    # A file that is not complete goes with what ends this.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    output = options.output or default_output(options.file, ENDINGS[options.to])
    try:
        if options.frames and options.to != "vtk":
            raise UsageError("--frames is for vtk; gltf leaves rows out by itself")
        check_output(options.file, output, force=options.force)
        export(options, output)
    except ResultError as problem:
        print(f"error: {labels.shown(str(problem))}", file=sys.stderr)
        return problem.status
    except OSError as problem:
        reason = problem.strerror or problem
        print(f"error: {labels.shown(str(output))} cannot be written: {reason}", file=sys.stderr)
        return STATUS_FILE
    print(labels.shown(str(output)))
    return 0


def export(options: argparse.Namespace, output: Path) -> None:
    """Write the whole file under another name, and then rename it."""
    with contextlib.ExitStack() as opened:
        with damage_told(options.file):
            file = opened.enter_context(open_file(options.file))
            run = drawable.open_run(options.file, file)
            rows = rows_between(run, options.start, options.end)
        if run_is_short(run):
            print(
                f"warning: {labels.shown(str(options.file))} is not complete "
                f"({status_of(run)}); {run.rows} rows",
                file=sys.stderr,
            )
        with whole_file(output) as place, place.open("w+b") as target:
            write(run, rows, target, options)


def write(run: drawable.Run, rows: slice, target: BinaryIO, options: argparse.Namespace) -> None:
    """Write one of the formats."""
    if options.to == "gltf":
        gltf.write(run, rows, target, every_row=options.every_row)
        return
    frames = options.frames or vtkhdf.FRAMES
    count = rows.stop - rows.start
    if options.every_row:
        frames = count
    elif count > frames and not options.frames:
        print(f"{frames} of {count} rows; --frames or --all take more", file=sys.stderr)
    vtkhdf.write(run, rows, target, frames=frames)


def status_of(run: drawable.Run) -> str:
    """What the file says of itself."""
    return as_text(run.file.attrs.get("status", ""))


def run_is_short(run: drawable.Run) -> bool:
    """Whether the run has not reached its end."""
    return status_of(run) not in ("", "complete")


def rows_between(run: drawable.Run, start: float | None, end: float | None) -> slice:
    """The rows from a time until another."""
    first, last = run.time[0], run.time[-1]
    start, end = first if start is None else start, last if end is None else end
    slack = 1e-9 * max(abs(first), abs(last))
    rows = slice(
        int(np.searchsorted(run.time, start - slack)),
        int(np.searchsorted(run.time, end + slack, side="right")),
    )
    if rows.start >= rows.stop:
        raise UsageError(
            f"{run.path} has no rows from {start:g} s until {end:g} s; it has {first:g} s to "
            f"{last:g} s"
        )
    return rows


if __name__ == "__main__":
    sys.exit(main())
