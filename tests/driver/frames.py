"""CPU time that a frame of pages takes in a browser that draws with the processor.

    .venv/bin/python tests/driver/frames.py PAGE.html...

One line for each page: milliseconds of CPU a frame, of all processes of the browser together, and
frames a second while the run is played.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))

from lib import browser

FRAMES = 60
PLAY = """new Promise(done => { const c = contensou; c.seek(c.head.start);
c.state.speed = (c.head.end - c.head.start) / 30; c.play(true);
(function go() { if (c.drawn.frames < %d) requestAnimationFrame(go); else { c.play(false);
const gl = c.renderer.getContext(); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE,
new Uint8Array(4)); done(c.drawn.frames); } })(); })"""


def cpu_time(root: int) -> float:
    """CPU time of a process and all below it [s]."""
    parents, times = {}, {}
    for name in os.listdir("/proc"):
        if not name.isdigit():
            continue
        try:
            words = Path(f"/proc/{name}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        parents[int(name)] = int(words[1])
        times[int(name)] = (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
    todo, total = [root], 0.0
    while todo:
        process = todo.pop()
        total += times.get(process, 0.0)
        todo += [child for child, parent in parents.items() if parent == process]
    return total


def main() -> None:
    """Measure the pages of the command line."""
    program = browser.Browser()
    for page in map(Path, sys.argv[1:]):
        program.open(page.resolve())
        program.wait("contensou.settled()")
        # The first frames compile what draws.
        first = program.value(PLAY % program.value("contensou.drawn.frames + 10"))
        before, start = cpu_time(program.process.pid), time.monotonic()
        count = program.value(PLAY % (first + FRAMES)) - first
        spent, took = cpu_time(program.process.pid) - before, time.monotonic() - start
        print(f"{page.stem:24s} {1e3 * spent / count:6.1f} ms {count / took:6.1f} frames/s")
    program.close()


if __name__ == "__main__":
    main()
