"""Where two surfaces are closest, by dense sampling of one of them and descent.

Written for the tests of spots, from the shapes alone; nothing of the program is used.
"""

from __future__ import annotations

import numpy as np


def rotation(quaternion):
    w, x, y, z = np.asarray(quaternion) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def frame(axis):
    """Columns: two tangents and the axis."""
    axis = np.array(axis, float) / np.linalg.norm(axis)
    side = np.cross(axis, [1, 0, 0] if abs(axis[0]) < 0.9 else [0, 1, 0])
    side /= np.linalg.norm(side)
    return np.stack([side, np.cross(axis, side), axis], 1)


class Ellipsoid:
    """Points of an ellipsoid by unit vectors."""

    def __init__(self, axes, n=6000):
        self.axes = np.array(axes)
        self.size = self.axes.max()
        i = np.arange(n) + 0.5
        z = 1 - 2 * i / n
        turn = np.pi * (1 + 5**0.5) * i
        flat = np.sqrt(1 - z * z)
        self.grid = np.stack([flat * np.cos(turn), flat * np.sin(turn), z], -1)
        self.near = 3.0 * np.sqrt(4 * np.pi / n)

    def points(self, u):
        return self.axes * u

    def move(self, u, step):
        tangents = np.linalg.svd(u[None])[2][1:]
        x = u + step @ tangents
        return x / np.linalg.norm(x, axis=-1, keepdims=True)

    def parameters(self, p):
        u = p / self.axes
        return u / np.linalg.norm(u)

    def starts(self, distance, limit):
        order = np.argsort(distance)
        order = order[distance[order] < limit + 0.03 * self.size]
        u = self.grid[order]
        return [
            u[k]
            for k in range(len(u))
            if k == 0 or np.linalg.norm(u[:k] - u[k], axis=1).min() > self.near
        ]


class Torus:
    """Points of a torus by two angles."""

    def __init__(self, major, minor, shape=(480, 32)):
        self.major, self.minor, self.shape = major, minor, shape
        self.size = major + minor
        u, v = np.meshgrid(*(np.arange(n) * 2 * np.pi / n for n in shape), indexing="ij")
        self.grid = np.stack([u.ravel(), v.ravel()], -1)

    def points(self, u):
        rho = self.major + self.minor * np.cos(u[..., 1])
        return np.stack(
            [rho * np.cos(u[..., 0]), rho * np.sin(u[..., 0]), self.minor * np.sin(u[..., 1])], -1
        )

    def move(self, u, step):
        return u + step

    def parameters(self, p):
        u = np.arctan2(p[1], p[0])
        return np.array([u, np.arctan2(p[2], np.hypot(p[0], p[1]) - self.major)])

    def starts(self, distance, limit):
        x = distance.reshape(self.shape)
        lowest = x < limit + 0.01 * self.size
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                if i or j:
                    lowest &= x <= np.roll(x, (i, j), (0, 1))
        return list(self.grid[lowest.ravel()])


def to_cylinder(radius, inside=False):
    """Distance of points from a cylinder about the third axis."""

    def distance(p):
        gap = np.hypot(p[..., 0], p[..., 1]) - radius
        return -gap if inside else gap

    return distance


def to_torus(major, minor, inside=False):
    """Distance of points from a torus about the third axis."""

    def distance(p):
        gap = np.hypot(np.hypot(p[..., 0], p[..., 1]) - major, p[..., 2]) - minor
        return -gap if inside else gap

    return distance


def to_sphere(radius, inside=False):
    """Distance of points from a sphere."""

    def distance(p):
        gap = np.linalg.norm(p, axis=-1) - radius
        return -gap if inside else gap

    return distance


def to_cone(half_angle):
    """Distance of points in a funnel, its apex the origin, from its wall."""
    c, s = np.cos(half_angle), np.sin(half_angle)
    return lambda p: p[..., 2] * s - np.hypot(p[..., 0], p[..., 1]) * c


def to_paraboloid(radius):
    """Distance of points in a dish from its wall, by Newton's method from above."""

    def distance(p):
        q = np.hypot(p[..., 0], p[..., 1])
        linear = 2 * radius * (radius - p[..., 2])
        rho = np.maximum(q, 0) + np.sqrt(np.maximum(-linear, 0)) + radius
        rho = rho + (2 * radius**2 * q) ** (1 / 3)
        for _ in range(60):
            rho = rho - (rho**3 + linear * rho - 2 * radius**2 * q) / (3 * rho**2 + linear)
        height = rho**2 / (2 * radius)
        outside = q**2 > 2 * radius * p[..., 2]
        return np.hypot(rho - q, height - p[..., 2]) * np.where(outside, -1, 1)

    return distance


def to_ellipsoid(axes):
    """Distance of points in a hollow ellipsoid from its wall, by bisection."""
    axes = np.array(axes)

    def distance(p):
        low = np.full(p.shape[:-1], -(axes.min() ** 2))
        high = np.linalg.norm(axes * p, axis=-1)
        for _ in range(70):
            t = 0.5 * (low + high)
            beyond = np.sum((axes * p / (t[..., None] + axes**2)) ** 2, axis=-1) > 1
            low, high = np.where(beyond, t, low), np.where(beyond, high, t)
        t = 0.5 * (low + high)
        return -t * np.linalg.norm(p / (t[..., None] + axes**2), axis=-1)

    return distance


def gaps(*scene):
    """Gaps at the places of `places`, in ascending order."""
    return [gap for gap, _ in places(*scene)]


def places(surface, distance, position, quaternion, axes, limit, near=()):
    """All places where the distance is smallest and below a limit: gap, and point at rest.

    The surface sits on the body at `position`, `quaternion`; the other one is at rest at the
    origin, its frame has the columns `axes`. Those `near` given points are found even if they are
    about to vanish and narrower than the samples are apart.
    """
    turn = rotation(quaternion)

    def value(u):
        return distance((surface.points(u) @ turn.T + position) @ axes)

    found = []
    starts = [surface.parameters((point - position) @ turn) for point in near]
    for u in [*surface.starts(value(surface.grid), limit), *starts]:
        gap, end, smallest = descend(surface, value, u)
        if not smallest or gap >= limit:
            continue
        point = turn @ surface.points(end) + position
        if all(np.linalg.norm(point - other) > 1e-3 * surface.size for _, other in found):
            found.append((gap, point))
    return sorted(found, key=lambda place: place[0])


def descend(surface, value, u):
    """Newton's method downhill, with differences: gap, parameters, whether it is a minimum."""
    h = 2e-4
    stencil = np.array(
        [[0, 0], [h, 0], [-h, 0], [0, h], [0, -h], [h, h], [-h, -h], [h, -h], [-h, h]]
    )
    here = value(u)
    for _ in range(200):
        x = value(surface.move(u, stencil))
        slope = np.array([x[1] - x[2], x[3] - x[4]]) / (2 * h)
        mixed = (x[5] + x[6] - x[7] - x[8]) / 4
        second = np.array([[x[1] + x[2] - 2 * x[0], mixed], [mixed, x[3] + x[4] - 2 * x[0]]]) / h**2
        low, vectors = np.linalg.eigh(second)
        step = -vectors @ ((vectors.T @ slope) / np.maximum(abs(low), 1e-5 * surface.size))
        step *= min(1.0, 0.1 / max(np.linalg.norm(step), 1e-300))
        while value(surface.move(u, step)) > here and np.linalg.norm(step) >= 1e-10:
            step = step / 2
        if np.linalg.norm(step) < 1e-8:
            return float(here), u, low[0] > 1e-7 * surface.size
        u = surface.move(u, step)
        here = value(u)
    return float(here), u, False
