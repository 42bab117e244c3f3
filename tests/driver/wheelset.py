"""The linear theory of a conical wheelset on round rails, for comparison with runs.

Unknowns are the lateral displacement y (to the left), the roll phi about the direction of travel
and the yaw psi, and their rates. The wheels touch the rails elastically; creep forces are those of
the linear theory, with what the static spin of the cones makes, how it changes with the load, and
how the direction of rolling turns. All of it is written for the left wheel: the right one is its
mirror image, and both act alike on these unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class Wheelset:
    """Lengths in m, masses in kg, forces in N."""

    slope: float
    gauge: float  # half of the distance of the points of contact
    radius: float  # of the wheels there
    head: float  # radius of the heads of the rails
    mass: float
    inertia: float  # across the axle
    axle_inertia: float
    box: float  # distance of an axle box from the middle
    stiffness: float  # of an axle box, along and across
    load: float  # normal force of a wheel
    overlap: float
    # Force or torque over v/V and w/V: 11, 22, 23, 33; and the force along the spot that spin gets
    # as rolling leaves its axis, by the angle: 23 on a circle.
    creep: tuple[float, float, float, float, float]
    # Relative change of 23 with the radius of the wheel at the same load.
    larger: float

    def klingel(self):
        """Wavelength where nothing slips and the rails do not yield [m]."""
        cosine = 1 / np.hypot(1, self.slope)
        wave = self.slope / (self.radius * self.gauge)
        return 2 * np.pi / np.sqrt(wave * (1 + self.slope * self.head * cosine / self.gauge))

    def matrix(self, speed):
        """Of the rates of (y, phi, psi, y', phi', psi')."""
        slope, s, r, head = self.slope, self.gauge, self.radius, self.head
        angle = np.arctan(slope)
        sine, cosine = np.sin(angle), np.cos(angle)
        f11, f22, f23, f33, f13 = self.creep
        load, stiffness = self.load, 1.5 * self.load / self.overlap
        turning = speed / r
        spin = -turning * sine
        y, phi, psi, y_rate, phi_rate, psi_rate = np.eye(6)
        # Static forces: creep force along the tangent, all of it along y and z, torque.
        force, torque = -f23 * spin / speed, -f33 * spin / speed
        force_y = -load * sine + force * cosine
        force_z = load * cosine + force * sine
        overlap = y * sine - phi * (s * cosine - r * sine)
        more = stiffness * overlap
        # The point of contact, from the middle of the axle, and the velocities there.
        point_x = -(s - slope * r) * psi
        point_y = -y - head * cosine * phi + 0.5 * sine * overlap
        point_z = -head * sine * phi - 0.5 * cosine * overlap
        along = turning * (point_z - s * phi) - s * psi_rate
        across = cosine * (y_rate + r * phi_rate - speed * psi) + sine * (
            s * phi_rate - slope * speed * psi
        )
        turned = -(head * phi_rate + 0.5 * across) / speed
        rolling = -(s - slope * r) * psi_rate - 0.5 * along
        spin_creep = (cosine * psi_rate - spin * rolling / speed) / speed
        # What creep and load make of the forces.
        # The spot turns, too, as the cone turns against the rail.
        bent = cosine / r
        spot = bent / (bent - 1 / head) * psi
        lean = f23 * turned - (f23 - f13) * (turned - spot)
        force_x = -f11 * along / speed + lean * spin / speed
        grown = more / load + self.larger * (s * phi - point_z) / r
        tangent = -f22 * across / speed - f23 * spin_creep - f23 * spin / speed * grown
        drill = f23 * across / speed - f33 * spin_creep - 4 / 3 * f33 * spin / speed * more / load
        d_y = -sine * more - cosine * load * phi + cosine * tangent - sine * force * phi
        d_z = cosine * more - sine * load * phi + sine * tangent + cosine * force * phi
        roll = s * d_z + point_y * force_z + r * d_y - point_z * force_y
        yaw = point_x * force_y - s * force_x + cosine * drill - sine * torque * phi
        matrix = np.zeros((6, 6))
        matrix[:3, 3:] = np.eye(3)
        matrix[3] = (2 * d_y - 2 * self.stiffness * y) / self.mass
        gyroscopic = self.axle_inertia * turning
        matrix[4] = (2 * roll + gyroscopic * psi_rate) / self.inertia
        held = 2 * self.stiffness * self.box**2 * psi
        matrix[5] = (2 * yaw - held - gyroscopic * phi_rate) / self.inertia
        return matrix

    def hunting(self, speed):
        """The slowest oscillation: growth + i frequency [1/s]."""
        values = np.linalg.eigvals(self.matrix(speed))
        values = values[values.imag > 0]
        return values[np.argmin(abs(values))]


def oscillation(time, values, guess):
    """Growth + i frequency of what oscillates, by least squares, and what is left."""
    time, values = time - time[0], values / abs(values).max()
    at = np.array([guess.real, guess.imag])

    def waves(at):
        grown, phase = np.exp(at[0] * time), at[1] * time
        return np.array([grown * np.cos(phase), grown * np.sin(phase)]).T

    for _ in range(30):
        basis = waves(at)
        weights = np.linalg.lstsq(basis, values, rcond=None)[0]
        first, second = basis @ weights, basis @ [weights[1], -weights[0]]
        slopes = np.column_stack([time * first, time * second, basis])
        at = at + np.linalg.lstsq(slopes, values - first, rcond=None)[0][:2]
    left = values - waves(at) @ np.linalg.lstsq(waves(at), values, rcond=None)[0]
    return complex(*at), abs(left).max()
