"""A scene of as many bodies as one likes, for what it costs to read and check it."""

from __future__ import annotations


def many_balls(number: int) -> list[str]:
    """Lines of a scene of balls in a grid, each with contacts with the floor and two neighbours."""
    row = int(number**0.5)
    lines = [
        "&scene gravity = 0, 0, -9.81, t_end = 1e-3 /",
        "&material name = 'steel', young = 2.1e11, poisson = 0.3 /",
        "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /",
    ]
    for i in range(number):
        place = f"{0.021 * (i % row)}, {0.021 * (i // row)}, 0.0101"
        lines += [
            f"&body name = 'b_{i}', mass = 0.0327, inertia = 3*1.31e-6, position = {place} /",
            f"&surface name = 's_{i}', body = 'b_{i}', shape = 'sphere', radius = 0.01, "
            "material = 'steel' /",
            f"&contact name = 'f_{i}', surfaces = 's_{i}', 'floor', "
            "friction = 'contensou_exact', friction_coefficient = 0.2 /",
        ]
        lines += [
            f"&contact name = 'c_{i}_{step}', surfaces = 's_{i}', 's_{(i + step) % number}', "
            "damping = 'hunt_crossley', restitution = 0.8 /"
            for step in (1, row)
        ]
    return lines
