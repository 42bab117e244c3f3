"""Turn one run of contensou, or the table of a sweep, into one HTML file that shows it.

The file opens in a browser, from a folder or a mail, without a network.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from lib import labels, limit_surface, sweeping, tables, viewing
from lib.results import STATUS_FILE, ResultError, check_output, damage_told, whole_file


def main(name: str = "scripts/view") -> int:
    """Read the command line, write the page, and print its name."""
    parser = argparse.ArgumentParser(
        prog=name,
        description="Writes one HTML file that shows a run in three dimensions, or the cases of a "
        "sweep as points that one can ask, and prints its name.",
    )
    parser.add_argument(
        "file", type=Path, metavar="FILE", nargs="?", help="output file (HDF5; of a run also .part)"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="HTML", help="page; default beside FILE, as .html"
    )
    parser.add_argument(
        "--limit-surface",
        metavar="a=..,b=..,f=..,N=..",
        help="in place of a file: all forces and torques of friction that a spot with the "
        "semi-axes a and b [m] can take, in three dimensions; also model=",
    )
    options = parser.parse_args()
    if (options.file is None) == (options.limit_surface is None):
        parser.error("expected either FILE or --limit-surface")
    page = options.output or default_page(options.file or Path("limit_surface.h5"))
    try:
        check_output(options.file, page, force=True, what="page")
        text = page_of(options.file) if options.file else limit_surface.view(options.limit_surface)
        with whole_file(page) as place:
            place.write_text(text, encoding="utf-8")
    except ResultError as problem:
        print(f"error: {labels.shown(str(problem))}", file=sys.stderr)
        return problem.status
    except OSError as problem:
        print(
            f"error: {labels.shown(str(page))} cannot be written: {problem.strerror}",
            file=sys.stderr,
        )
        return STATUS_FILE
    print(labels.shown(str(page)))
    return 0


def page_of(file: Path) -> str:
    """The page of a file; an error in words, however damaged it is."""
    with damage_told(file):
        return sweeping.view(file) if tables.is_sweep(file) else viewing.view(file)


def default_page(file: Path) -> Path:
    """Beside the file and of its name: run.h5 and run.h5.part both give run.html."""
    stem = file.with_suffix("") if file.suffix == ".part" else file
    return stem.with_suffix(".html")


if __name__ == "__main__":
    sys.exit(main())
