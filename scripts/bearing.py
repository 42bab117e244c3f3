"""Print what an engineer reads of the run of a ball bearing: loads, angles and stress by ball,
pivoting, speed of the cage, friction moment by cause; and draw the loads around the ring.

All values are means over the last rows of a result file.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

CAUSES = ("pivoting", "sliding", "curvature")


def words(data) -> list[str]:
    """Names of a data set."""
    return [name.decode() for name in data[:]]


class Bearing:
    """The contacts of the balls of a bearing with its rings, averaged over rows."""

    def __init__(self, file: h5py.File, name: str, part: float):
        rows = file["trajectory"]
        first = min(int((1 - part) * len(rows["time"])), len(rows["time"]) - 1)
        self.bodies = words(file["body/name"])
        contacts = words(file["contact/name"])
        self.count = sum(c.startswith(f"{name}_inner_") for c in contacts)
        inner, outer = (self.bodies.index(f"{name}_{ring}") for ring in ("inner", "outer"))
        balls = [self.bodies.index(f"{name}_ball_{i}") for i in range(1, self.count + 1)]
        position, turning = rows["position"][first:], rows["angular_velocity"][first:]
        driven = max((inner, outer), key=lambda i: np.linalg.norm(turning[:, i].mean(axis=0)))
        axis = turning[:, driven].mean(axis=0)
        self.speed = np.linalg.norm(axis)
        if self.speed <= 0:
            raise ValueError("no ring turns")
        axis = axis / self.speed
        self.ring_speeds = [(turning[:, i] @ axis).mean() for i in (inner, outer)]
        centre = position[:, outer].mean(axis=0)
        self.table = {}
        self.loss = {}
        for ring, body in (("inner", inner), ("outer", outer)):
            of = [contacts.index(f"{name}_{ring}_{i}") for i in range(1, self.count + 1)]

            def of_ring(key, of=of):
                return rows[key][first:][:, of]

            load, spin = of_ring("normal_force"), of_ring("spin")
            normal, axes = of_ring("contact_normal"), of_ring("semi_axes")
            relative = turning[:, balls] - turning[:, [body]]
            tangential = relative - (relative * normal).sum(-1, keepdims=True) * normal
            area = np.pi * axes.prod(axis=-1)
            self.table[ring] = {
                "load": load.mean(axis=0),
                "angle": np.degrees(np.arcsin(np.clip(abs(normal @ axis), 0, 1))).mean(axis=0),
                "stress": np.divide(1.5 * load, area, out=np.zeros_like(load), where=area > 0).mean(
                    axis=0
                ),
                "pivoting": (abs(spin) / np.linalg.norm(tangential, axis=-1)).mean(axis=0),
            }
            slip = of_ring("slip_velocity")
            self.loss[ring] = {
                "pivoting": -(of_ring("friction_torque") * spin).sum(axis=1).mean(),
                "sliding": -(of_ring("friction_force") * slip).sum(axis=(1, 2)).mean(),
                "curvature": 0.0,
            }
            if "spot_moment" in rows:
                moment = of_ring("spot_moment")
                self.loss[ring]["curvature"] = -(moment * relative).sum(axis=(1, 2)).mean()
        arm = position[:, balls] - centre
        arm = arm - (arm @ axis)[..., None] * axis
        around = (np.cross(arm, rows["velocity"][first:][:, balls]) @ axis) / (arm**2).sum(-1)
        self.cage = around.mean()
        radius = np.linalg.norm(arm, axis=-1).mean()
        self.pitch_radius = radius
        ball = self.ball_radius(file, name)
        angle = np.radians(self.table["inner"]["angle"].mean())
        ratio = ball * np.cos(angle) / radius
        low, high = self.ring_speeds
        self.epicyclic = 0.5 * (low * (1 - ratio) + high * (1 + ratio))
        self.places = np.degrees(np.arctan2(arm[-1][:, 1], arm[-1][:, 0]))
        time = rows["time"][first:]
        self.work = {
            key: (rows[f"work_{key}"][-1] - rows[f"work_{key}"][first])
            / max(time[-1] - time[0], 1e-300)
            for key in ("friction", "damping", "applied")
            if f"work_{key}" in rows
        }

    def life(self, file: h5py.File, name: str, rating: float) -> float:
        """Basic reference life of ISO/TS 16281 [10^6 revolutions], the inner ring turning against
        the load, of a basic dynamic load rating [N]."""
        surfaces = file["surface"]
        of = words(surfaces["body"])
        grooves = [surfaces["minor_radius"][of.index(f"{name}_{r}")] for r in ("inner", "outer")]
        ball = self.ball_radius(file, name)
        angle = np.radians(self.table["inner"]["angle"].mean())
        gamma = ball * np.cos(angle) / self.pitch_radius
        play = grooves[0] / grooves[1] * (grooves[1] - ball) / (grooves[0] - ball)
        base = 1.044 * ((1 - gamma) / (1 + gamma)) ** 1.72 * play**0.41
        capacity = rating / (self.count * np.cos(angle) ** 0.7)
        inner = capacity / 0.407 * (1 + base ** (10 / 3)) ** 0.3
        outer = capacity / 0.389 * (1 + base ** (-10 / 3)) ** 0.3
        on_inner = np.mean(self.table["inner"]["load"] ** 3) ** (1 / 3)
        on_outer = np.mean(self.table["outer"]["load"] ** (10 / 3)) ** 0.3
        return ((on_inner / inner) ** (10 / 3) + (on_outer / outer) ** (10 / 3)) ** -0.9

    @staticmethod
    def ball_radius(file: h5py.File, name: str) -> float:
        """Radius of a ball [m]."""
        surfaces = file["surface"]
        of = words(surfaces["body"]).index(f"{name}_ball_1")
        return float(surfaces["radius"][of])

    def moments(self) -> list[tuple[str, float]]:
        """Friction moment by cause, over the speed of the ring [N m]."""
        parts = []
        for cause in CAUSES:
            for ring in ("inner", "outer"):
                parts.append((f"{cause}, {ring} race", self.loss[ring][cause] / self.speed))
        if "friction" in self.work:
            rest = self.work["friction"] / self.speed - sum(value for _, value in parts)
            parts.append(("cage, rolling resistance", rest))
        if "damping" in self.work:
            parts.append(("damping", self.work["damping"] / self.speed))
        return parts


def report(name: str, bearing: Bearing) -> str:
    """The table."""
    lines = [f"bearing {name}: {bearing.count} balls"]
    lines.append(
        "ball      load [N]        angle [deg]     stress [GPa]     spin/roll"
        "\n       inner    outer   inner  outer   inner  outer   inner   outer"
    )
    inner, outer = bearing.table["inner"], bearing.table["outer"]
    for i in range(bearing.count):
        lines.append(
            f"{i + 1:4} {inner['load'][i]:7.1f}  {outer['load'][i]:7.1f}"
            f"  {inner['angle'][i]:6.2f} {outer['angle'][i]:6.2f}"
            f"  {inner['stress'][i] / 1e9:6.3f} {outer['stress'][i] / 1e9:6.3f}"
            f"  {inner['pivoting'][i]:7.4f} {outer['pivoting'][i]:7.4f}"
        )
    lines.append(f"cage speed  {bearing.cage:.4f} rad/s, epicyclic {bearing.epicyclic:.4f} rad/s")
    lines.append("friction moment by cause [N mm]")
    parts = bearing.moments()
    lines += [f"  {cause:26} {1e3 * value:8.4f}" for cause, value in parts]
    lines.append(f"  {'whole':26} {1e3 * sum(value for _, value in parts):8.4f}")
    return "\n".join(lines)


def draw(bearing: Bearing, output: Path) -> None:
    """Loads around the ring."""
    figure, axes = plt.subplots(subplot_kw={"projection": "polar"})
    for ring in ("inner", "outer"):
        order = np.argsort(bearing.places)
        order = np.append(order, order[0])
        axes.plot(
            np.radians(bearing.places[order]), bearing.table[ring]["load"][order], "o-", label=ring
        )
    axes.set_title("load of the balls [N]")
    axes.legend(loc="lower right")
    figure.savefig(output, dpi=150)
    plt.close(figure)


def main() -> int:
    """Read the command line, print the tables, draw."""
    parser = argparse.ArgumentParser(
        prog="scripts/bearing",
        description="Prints loads, contact angles, stress and spin to roll ratio by ball, the "
        "speed of the cage and the friction moment by cause, for each bearing of a result file.",
    )
    parser.add_argument("file", type=Path, help="result of contensou run")
    parser.add_argument(
        "--part", type=float, default=0.5, help="part of the run that counts, its end (0.5)"
    )
    parser.add_argument("--rating", type=float, help="basic dynamic load rating C [N], for life")
    parser.add_argument("-o", "--output", type=Path, help="draw the loads around the ring")
    arguments = parser.parse_args()
    try:
        with h5py.File(arguments.file) as file:
            names = [
                name.removesuffix("_ball_1")
                for name in words(file["body/name"])
                if name.endswith("_ball_1")
            ]
            if not names:
                raise ValueError("it has no bearing")
            if not 0 < arguments.part <= 1:
                raise ValueError("--part needs a number from 0 to 1")
            for name in names:
                bearing = Bearing(file, name, arguments.part)
                print(report(name, bearing))
                if arguments.rating:
                    life = bearing.life(file, name, arguments.rating)
                    print(f"basic reference life  {life:.4g} million revolutions (ISO/TS 16281)")
            if arguments.output:
                draw(bearing, arguments.output)
                print(arguments.output)
    except (OSError, KeyError, ValueError) as trouble:
        print(f"error: {arguments.file}: {trouble}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
