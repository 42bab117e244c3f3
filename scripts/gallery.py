"""Draw the gallery: a still of each shipped scene by the page that shows it, and docs/gallery.md.

The poster is the counterpart of figure 9 of Kosenko and Aleksandrov (2009), the animated top:
several positions of one run side by side.
"""

from __future__ import annotations

import argparse
import os
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from lib import browser, labels, program, thinning, viewing
from lib.browser import frame, show
from lib.results import ResultError

ROOT = Path(__file__).resolve().parents[1]
INPUTS = ROOT / "inputs"
PAGES = ROOT / "results" / "gallery"
STILLS = ROOT / "docs" / "gallery"
TEXT = ROOT / "docs" / "gallery.md"

WIDTH, HEIGHT = 720, 450
QUALITY = 82
POSTER = "tippe_top"
POSTER_ANGLES = (None, 45, 90, 125, None)  # inclinations of the axis [deg], between begin and end
SLACK = 12  # how far from them [deg]
ASIDE = np.array(
    [-np.cos(0.9 - 0.4), -np.sin(0.9 - 0.4)]
)  # where the camera has its left, and near


@dataclass(frozen=True)
class Still:
    """How a scene is shown: when, by which camera, nearer by so much, and a sentence."""

    time: float
    camera: str
    nearer: float
    text: str


# By their paths below inputs.
SCENES = {
    "tippe_top": Still(
        1.19,
        "follow",
        1.3,
        "A Tippe-Top turns over: it spins on the ball, and friction raises its centre of mass "
        "until it spins on the stem.",
    ),
    "tippe_top_pade11": Still(
        1.19, "follow", 1.3, "The same top with the Padé model of the first order of its friction."
    ),
    "tippe_top_pade22": Still(
        1.19, "follow", 1.3, "The same top with the Padé model of the second order."
    ),
    "tippe_top_rigid": Still(
        1.19, "follow", 1.3, "The same top with contacts as constraints in place of elastic ones."
    ),
    "tippe_top_simplified": Still(
        1.19, "follow", 1.3, "The same top with the simplified model of its friction."
    ),
    "rattleback": Still(
        2.6, "follow", 2.2, "A celt that is spun the wrong way rattles, stops and turns back."
    ),
    "ellipsoid_egg": Still(
        0.9, "follow", 1.2, "A spinning egg rises until it stands on its end, with a few jumps."
    ),
    "bouncing_ball": Still(
        0.45, "fit", 3.0, "A steel ball falls on a steel floor and bounces lower and lower."
    ),
    "bowling": Still(
        1.0, "follow", 1.6, "A bowling ball slides, gains topspin from friction, and rolls."
    ),
    "sliding_ball": Still(
        0.05, "follow", 2.2, "A rubber ball whose spin about the vertical lets it slide for longer."
    ),
    "sliding_disc": Still(
        0.1, "follow", 1.2, "Sliding and spinning on a spot, which stop at the same instant."
    ),
    "spinning_ball": Still(
        0.1, "follow", 1.2, "A ball that spins on the spot until drilling friction has stopped it."
    ),
    "bearing_6205": Still(
        0.03, "orbit", 2.0, "A ball bearing of the size 6205 under preload and a radial load."
    ),
    "bearing_paper": Still(
        0.03, "orbit", 2.0, "The ball bearing of the paper of Kosenko and Aleksandrov."
    ),
    "examples/bearing_6205_rolling": Still(
        0.03, "orbit", 2.0, "The bearing of the size 6205 with balls that roll by a law of creep."
    ),
    "examples/bearing_pair": Still(
        0.005,
        "orbit",
        3.2,
        "Two angular contact bearings back to back on a shaft that tilts under its load.",
    ),
    "examples/bowling_hook": Still(
        2.0, "follow", 1.6, "A bowling ball with side spin hooks to the end of the lane."
    ),
    "examples/break_shot": Still(
        0.35, "fit", 3.0, "A cue ball of 8 m/s breaks fifteen billiard balls."
    ),
    "examples/cattaneo": Still(
        0.005,
        "follow",
        0.9,
        "A ball that a carriage pulls to and fro: its spot slips from the rim.",
    ),
    "examples/dish": Still(0.2, "fit", 0.7, "A ball of rubber rocks in a dish until it sticks."),
    "examples/euler_disc": Still(
        0.3, "follow", 1.2, "A steel disc spins down on a mirror, Euler's disc."
    ),
    "examples/incline": Still(
        0.5, "follow", 1.2, "A stool on an incline that holds it: its spots stick."
    ),
    "examples/oblique_impact": Still(
        4e-6,
        "follow",
        1.2,
        "A ball of alumina hits glass obliquely; its spot sticks, slips and springs back.",
    ),
    "examples/rolling_bend": Still(
        2.0, "follow", 1.6, "A rubber ball that spins about the vertical rolls round a bend."
    ),
    "examples/wheelset": Still(2.4, "follow", 2.2, "A railway wheelset hunts between its rails."),
}


def main() -> int:
    """Read the command line and draw what is wanted."""
    parser = argparse.ArgumentParser(
        prog="scripts/gallery", description="Draws docs/gallery.md from fresh runs."
    )
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names of scenes; default all")
    parser.add_argument("--reuse", action="store_true", help="take runs that are there")
    options = parser.parse_args()
    paths = {Path(scene).name: scene for scene in SCENES}
    unknown = [name for name in options.scenes if name not in paths]
    if unknown:
        print(f"error: no scene {labels.shown(unknown[0])} in the gallery", file=sys.stderr)
        return 2
    for folder in (PAGES, STILLS):
        folder.mkdir(parents=True, exist_ok=True)
    window = browser.Browser(WIDTH, HEIGHT)
    try:
        for name in options.scenes or paths:
            draw(window, paths[name], reuse=options.reuse)
            print(name, flush=True)
    except ResultError as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 1
    finally:
        window.close()
    TEXT.write_text(text(), encoding="utf-8")
    return 0


def draw(window: browser.Browser, scene: str, *, reuse: bool) -> None:
    """The run, the page and the still of a scene."""
    name = Path(scene).name
    output, page = PAGES / f"{name}.h5", PAGES / f"{name}.html"
    if not (reuse and output.exists()):
        program.call("run", INPUTS / f"{scene}.nml", "-o", output, "--force", "-q")
    page.write_text(viewing.view(output), encoding="utf-8")
    still = SCENES[scene]
    show(window, page, still.camera, still.nearer)
    save(frame(window, still.time), STILLS / f"{name}.jpg")
    if name == POSTER:
        save(poster(window, output), STILLS / "poster.jpg")


def save(picture: Image.Image, path: Path) -> None:
    """Write a picture that is whole or not there."""
    part = path.with_suffix(".part")
    picture.save(part, "JPEG", quality=QUALITY, optimize=True)
    os.replace(part, path)


def poster(window: browser.Browser, output: Path) -> Image.Image:
    """Positions of the top on its way over, side by side."""
    with h5py.File(output) as file:
        time = file["trajectory/time"][()]
        turn = thinning.matrices(file["trajectory/quaternion"][:, 0])
    angle = np.degrees(np.arccos(np.clip(turn[:, 2, 2], -1, 1)))
    # Of the times at about an inclination the one when the stem is seen from the side.
    seen = turn[:, :2, 2] @ ASIDE
    times = [time[0] if not k else time[-1] for k in range(len(POSTER_ANGLES))]
    for k, wanted in enumerate(POSTER_ANGLES):
        if wanted:
            near = np.abs(angle - wanted) < SLACK
            times[k] = time[np.flatnonzero(near)[np.argmax(seen[near])]]
    wide, high = int(0.62 * HEIGHT), int(0.8 * HEIGHT)
    whole = Image.new("RGB", (wide * len(times), high))
    font = ImageFont.load_default(20)
    for k, when in enumerate(times):
        one = frame(window, float(when))
        left, top = (one.width - wide) // 2, (one.height - high) // 2
        whole.paste(one.crop((left, top, left + wide, top + high)), (k * wide, 0))
        ImageDraw.Draw(whole).text((k * wide + 12, 10), f"{when:.2f} s", "#20262e", font)
    return whole


def text() -> str:
    """The page of the gallery."""
    parts = [
        "# Gallery\n\n"
        + wrapped(
            "Each scene of [inputs](../inputs), drawn by its own page of [view.md](view.md). "
            "`scripts/gallery` runs them all, writes these stills and this text, and leaves the "
            "pages, one HTML file for each scene, in `results/gallery`: they open in a browser, "
            "play, and can be turned. The links to them lead somewhere once it has run."
        )
        + "\n![Five positions of the Tippe-Top](gallery/poster.jpg)\n\n"
        + wrapped(
            "Five positions of the Tippe-Top, the counterpart of figure 9 of Kosenko and "
            "Aleksandrov (2009), the animated top."
        )
    ]
    for scene, still in SCENES.items():
        name = Path(scene).name
        parts.append(
            f"\n## {name}\n\n![{name} at {still.time:g} s](gallery/{name}.jpg)\n\n"
            + wrapped(
                f"{still.text} Scene [{name}.nml](../inputs/{scene}.nml), at {still.time:g} s; "
                f'page <a href="../results/gallery/{name}.html">{name}.html</a>.'
            )
        )
    return "".join(parts)


def wrapped(words: str) -> str:
    """Lines of at most 100 characters."""
    return "\n".join(textwrap.wrap(words, 100, break_on_hyphens=False)) + "\n"


if __name__ == "__main__":
    sys.exit(main())
