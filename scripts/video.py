"""Write a film of a run, or the pictures of one, by the page that shows it.

The page is drawn by Chromium without a window; the film is put together by ffmpeg.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from lib import browser, drawable, labels, viewing
from lib.results import (
    ResultError,
    UsageError,
    check_output,
    damage_told,
    default_output,
    open_file,
)

MOST_FRAMES = 20_000


def main(program: str = "scripts/video") -> int:
    """Read the command line and write the film."""
    parser = argparse.ArgumentParser(
        prog=program,
        description="Writes a film of a run (NAME.mp4, by ffmpeg), or its frames as PNG into a "
        "folder, and prints its name.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="output file (HDF5, also .part)")
    parser.add_argument("-o", "--output", type=Path, help="film (.mp4) or a new folder of frames")
    parser.add_argument("--from", type=float, dest="start", metavar="T", help="begin at [s]")
    parser.add_argument("--until", type=float, dest="end", metavar="T", help="end at [s]")
    parser.add_argument("--rate", type=float, default=30, metavar="R", help="frames a second (30)")
    parser.add_argument("--speed", type=float, default=1, metavar="S", help="times real time (1)")
    parser.add_argument("--size", default="1280x720", metavar="WxH", help="pixels, even numbers")
    parser.add_argument("--camera", choices=["orbit", "follow", "ride", "fit"], default="follow")
    parser.add_argument("--nearer", type=float, default=1, metavar="X", help="so many times (1)")
    parser.add_argument("--turn", type=float, default=0, metavar="DEG", help="about the vertical")
    parser.add_argument("--force", action="store_true", help="replace an existing film")
    options = parser.parse_args()
    output = options.output or default_output(options.file, ".mp4")
    try:
        film(options, output)
    except ResultError as problem:
        print(f"error: {labels.shown(str(problem))}", file=sys.stderr)
        return problem.status
    print(labels.shown(str(output)))
    return 0


def film(options: argparse.Namespace, output: Path) -> None:
    """Draw the frames and put them together."""
    found = re.fullmatch(r"(\d{2,4})x(\d{2,4})", options.size)
    if not found or int(found[1]) % 2 or int(found[2]) % 2:
        raise UsageError(f"--size {options.size}: expected even numbers of pixels, as 1280x720")
    if not (options.rate > 0 and options.speed > 0 and options.nearer > 0):
        raise UsageError("--rate, --speed and --nearer need to be > 0")
    moving = output.suffix == ".mp4"
    if moving:
        check_output(options.file, output, force=options.force)
    elif os.path.lexists(output):
        raise ResultError(f"{output} exists; frames need a new folder")
    if moving and not shutil.which("ffmpeg"):
        raise UsageError("there is no ffmpeg; -o FOLDER writes the frames")
    if browser.PROGRAM is None:
        raise UsageError("there is no Chromium, which draws the frames")
    with damage_told(options.file), open_file(options.file) as file:
        run = drawable.open_run(options.file, file)
        start = run.time[0] if options.start is None else options.start
        end = run.time[-1] if options.end is None else options.end
        if not run.time[0] <= start <= end <= run.time[-1]:
            raise UsageError(
                f"{options.file} has {run.time[0]:g} s to {run.time[-1]:g} s, not {start:g} s "
                f"until {end:g} s"
            )
    count = int((end - start) / options.speed * options.rate + 1e-6) + 1
    if count > MOST_FRAMES:
        raise UsageError(f"{count} frames are too many: --speed or --from and --until help")
    with tempfile.TemporaryDirectory(dir=output.parent, prefix=f"{output.name}.part-") as folder:
        frames = Path(folder) / "frames"
        frames.mkdir()
        page = Path(folder) / "page.html"
        page.write_text(viewing.view(options.file), encoding="utf-8")
        window = browser.Browser(int(found[1]), int(found[2]))
        try:
            browser.show(window, page.resolve(), options.camera, options.nearer)
            if options.turn:
                x, y = int(found[1]) / 2, int(found[2]) / 2
                window.drag((x, y), (x - options.turn * 3.14159265 / 180 / 0.007, y))
            for k in range(count):
                when = start + k * options.speed / options.rate
                browser.frame(window, when).save(frames / f"{k:05d}.png")
        finally:
            window.close()
        if not moving:
            os.replace(frames, output)
            return
        made = Path(folder) / "film.mp4"
        done = subprocess.run(
            [
                "ffmpeg",
                "-loglevel",
                "error",
                "-framerate",
                str(options.rate),
                "-i",
                frames / "%05d.png",
                "-pix_fmt",
                "yuv420p",
                "-movflags",
                "+faststart",
                made,
            ],
            capture_output=True,
            text=True,
            check=False,
            stdin=subprocess.DEVNULL,
        )
        if done.returncode:
            raise ResultError(f"ffmpeg failed: {done.stderr.strip()[-300:]}")
        os.replace(made, output)


if __name__ == "__main__":
    sys.exit(main())
