"""An output file in memory: what the tests of mechanics look at."""

from __future__ import annotations

from dataclasses import dataclass, field

import h5py
import numpy as np


@dataclass
class Run:
    """What a run wrote: columns of the trajectory, events, properties of bodies, summary."""

    columns: dict[str, np.ndarray] = field(repr=False)
    events: list[tuple[float, str, str]] = field(repr=False)
    summary: dict[str, object] = field(repr=False)
    mass: np.ndarray = field(repr=False)
    inertia: np.ndarray = field(repr=False)
    steps: int
    err: str = field(default="", repr=False)

    def __getattr__(self, name):
        try:
            return self.columns[name]
        except KeyError:
            raise AttributeError(name) from None

    def rotation(self, body=0):
        """Rotation matrices, body to inertial frame, one for each row."""
        w, x, y, z = self.columns["quaternion"][:, body].T
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        ).transpose(2, 0, 1)

    def axis(self, body=0):
        """The z axis of a body."""
        return self.rotation(body)[:, :, 2]

    def theta(self, body=0):
        """Angle between the z axis of a body and the vertical."""
        axis = self.axis(body)
        return np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])

    def body_rates(self, body=0):
        """Angular velocity in body axes."""
        return np.einsum("tji,tj->ti", self.rotation(body), self.angular_velocity[:, body])

    def angular_momentum(self, body=0):
        """Angular momentum about the centre of mass, inertial frame."""
        inner = self.inertia[body] * self.body_rates(body)
        return np.einsum("tij,tj->ti", self.rotation(body), inner)

    def times(self, kind, contact=None):
        """Times of touch or lift, of one contact or of all."""
        return np.array([t for t, k, c in self.events if k == kind and contact in (None, c)])

    def mechanical(self):
        """Energy without what was lost or supplied."""
        return self.energy_kinetic + self.energy_potential + self.energy_elastic

    def energy(self):
        """Sum of the energies and of the work that was lost, less what was supplied."""
        return self.mechanical() + self.work_friction + self.work_damping - self.work_applied

    def residual(self):
        """Largest deviation of the energy balance, over the initial energy.

        Where energy is supplied, over the largest of that, the kinetic and the initial energy.
        """
        energy = self.energy()
        scale = abs(energy[0])
        if self.work_applied.any():
            scale = max(scale, self.energy_kinetic.max(), np.abs(self.work_applied).max())
        return np.abs(energy - energy[0]).max() / scale


def read(path, err=""):
    """Read an output file."""
    with h5py.File(path) as file:
        columns = {
            name: item[()]
            for name, item in file["trajectory"].items()
            if item.dtype == np.float64  # labels are text
        }
        times = file["events/time"][()]
        kinds = file["events/kind"].asstr()[()]
        contacts = file["events/contact"].asstr()[()]
        summary = {name: item[()] for name, item in file["summary"].items()}
        mass, inertia = file["body/mass"][()], file["body/inertia"][()]
        steps = int(file["integrator/steps"][()])
    events = [(float(t), str(k), str(c)) for t, k, c in zip(times, kinds, contacts, strict=True)]
    return Run(columns, events, summary, mass, inertia, steps, err)
