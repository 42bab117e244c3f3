"""Draw a spot as figures of papers have it: pressure, slip lines, direction of traction, the centre
about which it slips, and, for a shift of an elastic contact, the zone that sticks.

Force and torque are those of `contensou eval`.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Ellipse

from lib import bristles, labels, style
from lib.kernels import described, evaluated
from lib.results import STATUS_FILE, ResultError, UsageError, check_output

NEEDED = ("a", "f", "N")
SLIP = ("vx", "vy", "w")
SHIFT = ("dx", "dy")
PASSING = ("cx", "cy")
ELASTIC = ("G", "nu")
POSITIVE = ("a", "b", "f", "N", "G")
ARROWS = 9  # across the spot
LINES = 9


def main(name: str = "scripts/spot") -> int:
    """Read the command line, draw, and print the name of the picture."""
    parser = argparse.ArgumentParser(
        prog=name,
        description="Draws an elliptic spot and prints the name of the picture. Its motion is a "
        "slip vx, vy [m/s] with a spin w [rad/s] of B against A; that while material passes the "
        "spot, as it rolls, with cx, cy [m/s]; or a first shift dx, dy [m] of an elastic contact "
        "that stuck. The latter two have a shear modulus G [Pa] and Poisson's ratio nu.",
    )
    parser.add_argument(
        "spot", help="a=1e-3,b=5e-4,f=0.3,N=10,vx=0.1,vy=0,w=100 (b is a if not given)"
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("spot.png"), help="spot.png")
    options = parser.parse_args()
    try:
        spot = read(options.spot)
        check_output(None, options.output, force=True, what="picture")
        draw(spot, wrench(spot), options.output)
    except ResultError as problem:
        print(f"error: {labels.shown(str(problem))}", file=sys.stderr)
        return problem.status
    except (OSError, ValueError) as problem:
        print(f"error: {options.output} cannot be written: {problem}", file=sys.stderr)
        return STATUS_FILE
    print(labels.shown(str(options.output)))
    return 0


def read(words: str) -> dict[str, float]:
    """The spot that an option describes."""
    spot = described(words, (*NEEDED, "b", *SLIP, *SHIFT, *PASSING, *ELASTIC), POSITIVE)
    for key in NEEDED:
        if key not in spot:
            raise UsageError(f"{key}= of the spot is missing")
    shifted, rolls = (any(key in spot for key in keys) for keys in (SHIFT, PASSING))
    if shifted or rolls or any(key in spot for key in ELASTIC):
        lacking = [key for key in ELASTIC if key not in spot]
        if lacking:
            raise UsageError(f"{lacking[0]}= is missing, which a shift or a rolling spot needs")
        if shifted and (rolls or any(key in spot for key in SLIP)):
            raise UsageError("a spot slips by vx, vy, w or is shifted by dx, dy, not both")
        if not (shifted or rolls):
            raise UsageError("G= and nu= are for a shift dx, dy or a rolling spot cx, cy")
    motion = SHIFT if shifted else SLIP
    if rolls:
        for key in PASSING:
            spot.setdefault(key, 0.0)
        if not any(spot[key] for key in PASSING):
            raise UsageError("nothing passes the spot: cx, cy are 0")
    for key in motion:
        spot.setdefault(key, 0.0)
    if not any(spot[key] for key in motion):
        raise UsageError(f"the spot does not move: {', '.join(motion)} are 0")
    return spot


def wrench(spot: dict[str, float]) -> np.ndarray:
    """Force and torque of friction, by the program."""
    kernel, inputs = "wrench", ("N", "a", "b", "f", *SLIP)
    if "cx" in spot:
        kernel, inputs = "creep", ("N", "a", "b", "f", *ELASTIC, *SLIP, *PASSING)
    elif "dx" in spot:
        kernel, inputs = "tangential", ("N", "a", "b", "f", *ELASTIC, *SHIFT, "twist")
    options = ("--layers", 128) if "dx" in spot else ()
    row = [spot.get(key, 0.0) for key in inputs]
    return evaluated(kernel, inputs, [row], ("Fx", "Fy", "Tz"), *options)[0]


def sticking(spot: dict[str, float], force: np.ndarray) -> float:
    """Size of the zone that sticks in parts of the spot (Cattaneo, Mindlin); 0 if none does."""
    if "dx" not in spot:
        return 0.0
    share = np.hypot(*force[:2]) / (spot["f"] * spot["N"])
    return float(np.cbrt(1 - share)) if share < 1 - 1e-9 else 0.0


def slip(
    spot: dict[str, float], force: np.ndarray, x: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Directions into which the points slip, of any length: of a shift, against its force."""
    if "dx" in spot:
        return np.full_like(x, -force[0]), np.full_like(y, -force[1])
    return spot["vx"] - spot["w"] * y, spot["vy"] + spot["w"] * x


def draw(spot: dict[str, float], force: np.ndarray, output: Path) -> None:
    """The picture."""
    a, b = spot["a"], spot["b"]
    unit, scale = ("mm", 1e3) if max(a, b) > 1e-4 else ("µm", 1e6)
    peak = 1.5 * spot["N"] / (np.pi * a * b)
    wide = 1.15 * max(a, b)
    axis = np.linspace(-wide, wide, 401)
    x, y = np.meshgrid(axis, axis)
    inside = 1 - (x / a) ** 2 - (y / b) ** 2
    pressure = np.where(inside > 0, peak * np.sqrt(np.maximum(inside, 0)), np.nan)
    figure, frame = plt.subplots(figsize=(6.4, 5.4), layout="constrained")
    shown = frame.pcolormesh(
        scale * axis, scale * axis, 1e-6 * pressure, cmap="YlOrRd", shading="nearest", vmin=0
    )
    figure.colorbar(shown, label="pressure [MPa]")
    rim = Ellipse((0, 0), 2 * scale * a, 2 * scale * b, fill=False, color="black", lw=1.2)
    frame.add_patch(rim)
    # Slip lines are where a stream function is the same: circles about the centre, or lines.
    vx, vy = slip(spot, force, x, y)
    if spot.get("w"):
        stream = np.hypot(x + spot["vy"] / spot["w"], y - spot["vx"] / spot["w"])
    else:
        stream = x * vy - y * vx
    stick = sticking(spot, force)
    slips = (inside > 0) & (1 - inside > stick**2)
    rolling = bristles.field(spot, force) if "cx" in spot else None
    if rolling:
        sticks = (inside > 0) & rolling(x / a, y / b)[2]
        slips &= ~sticks
    stream = np.where(slips, stream, np.nan)
    frame.contour(
        scale * axis,
        scale * axis,
        stream,
        LINES,
        colors="#2f5f9e",
        linewidths=0.7,
        linestyles="solid",
    )
    steps = np.linspace(-1, 1, 2 * ARROWS + 1)[1::2]
    px, py = (values.ravel() for values in np.meshgrid(a * steps, b * steps))
    within = 1 - (px / a) ** 2 - (py / b) ** 2
    keep = within > 0.02
    px, py, within = px[keep], py[keep], within[keep]
    vx, vy = slip(spot, force, px, py)
    size = np.hypot(vx, vy)
    # What slips has f p against the slip; what sticks has less, by the inner ellipse.
    traction = np.sqrt(within)
    if stick > 0:
        inner = 1 - ((px / a) ** 2 + (py / b) ** 2) / stick**2
        traction = traction - stick * np.sqrt(np.maximum(inner, 0))
    good = size > 1e-12 * size.max()
    tx, ty = (-v / np.where(good, size, 1) * traction for v in (vx, vy))
    if rolling:
        tx, ty, _ = rolling(px / a, py / b)
        good = np.hypot(tx, ty) > 0
    frame.quiver(
        scale * px[good],
        scale * py[good],
        tx[good],
        ty[good],
        color="#1c2733",
        scale=1.1 * ARROWS * 1.6,
        width=0.005,
        pivot="tail",
    )
    words = [f"$F_x$ = {force[0]:.4g} N, $F_y$ = {force[1]:.4g} N, $T_z$ = {force[2]:.4g} N m"]
    if spot.get("w") and not rolling:
        centre = np.array([-spot["vy"], spot["vx"]]) / spot["w"]
        if np.abs(centre).max() < wide:
            frame.plot(*(scale * centre), "o", color="#1f8f4d", ms=8, mec="white")
        where = ", ".join(f"{scale * value:.3g}" for value in centre)
        words.append(f"centre of rotation at ({where}) {unit}")
    if rolling and sticks.any():
        zone = np.where(sticks, 1.0, 0.0)
        frame.contour(scale * axis, scale * axis, zone, [0.5], colors="#1f8f4d", linewidths=1.2)
        plt.rcParams["hatch.color"] = "#1f8f4d"
        frame.contourf(scale * axis, scale * axis, zone, [0.5, 2], colors="none", hatches=["//"])
        words.append(f"sticks in {sticks.sum() / (inside > 0).sum():.3g} of the spot")
    if stick > 0:
        zone = Ellipse(
            (0, 0),
            2 * scale * a * stick,
            2 * scale * b * stick,
            fill=False,
            hatch="//",
            color="#1f8f4d",
            lw=1.2,
            gid="stick",
        )
        frame.add_patch(zone)
        words.append(f"sticks within {stick:.3g} of the spot")
    frame.set_title("\n".join(words), fontsize=10)
    frame.set(aspect="equal", xlabel=f"$x$ [{unit}]", ylabel=f"$y$ [{unit}]")
    style.save(figure, output, dpi=150, bbox_inches=None)


if __name__ == "__main__":
    sys.exit(main())
