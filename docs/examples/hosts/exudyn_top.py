"""The Tippe-Top in Exudyn, which integrates; a user function of a connector gives our contacts.

    python3 exudyn_top.py [tippe_top.nml]

Its method is Runge-Kutta of order 4 with equal steps on a rotation vector. The same top on contacts
of Exudyn, spheres with the stiffness of Hertz and Coulomb's law, shows what they cost.
"""

import sys
import time

import exudyn as exu
import exudyn.itemInterface as items  # noqa: N813
import exudyn.rigidBodyUtilities as rigid  # noqa: N813
import numpy as np

import contensou

STEP = 1e-4
SPHERES = ((0.003, 0.015), (0.016, 0.005))  # height of the centre on the axis, radius [m]
STIFFNESS = 4 / 3 * 9.1e9 / (1 - 0.3**2) / 2  # of Hertz, without the root of the radius [Pa]
FLOOR = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
READ = [getattr(exu.OutputVariableType, name) for name in
        ("Position", "RotationMatrix", "Velocity", "AngularVelocityLocal")]  # fmt: skip


class Host:
    """The top in Exudyn, with our contacts or with those of Exudyn."""

    def __init__(self, top, ours):
        self.top, start = top, top.body("top")
        self.steps, self.gap, self.touch = 0, 1.0, None
        self.mbs = exu.SystemContainer().AddSystem()
        attitude = rigid.EulerParameters2RotationMatrix(start.quaternion)
        ground = self.mbs.CreateGround()
        body = self.mbs.CreateRigidBody(
            inertia=rigid.RigidBodyInertia(6e-3, np.diag([8e-7, 8e-7, 7e-7])),
            nodeType=exu.NodeType.RotationRotationVector,
            referencePosition=start.position, referenceRotationMatrix=attitude,
            initialAngularVelocity=attitude @ start.angular_velocity, gravity=[0, 0, -9.81],
        )  # fmt: skip
        self.node = self.mbs.GetObject(body)["nodeNumber"]
        if ours:
            marker = [
                self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=i)) for i in (ground, body)
            ]
            self.mbs.AddObject(items.ObjectConnectorRigidBodySpringDamper(
                markerNumbers=marker, springForceTorqueUserFunction=self.wrench))  # fmt: skip
            self.mbs.SetPostStepUserFunction(self.look)
            return
        for height, radius in SPHERES:
            self.mbs.CreateSphereQuadContact(
                itemNumbers=[body, ground], localPosition0=[0, 0, height], sphereRadius=radius,
                quadPoints=FLOOR, includeEdges=0, dynamicFriction=0.3,
                contactStiffness=STIFFNESS * radius**0.5, contactStiffnessExponent=1.5,
            )  # fmt: skip

    def move(self):
        """Tell Contensou of the motion; the attitude as a matrix."""
        position, matrix, *rates = (self.mbs.GetNodeOutput(self.node, what) for what in READ)
        matrix = matrix.reshape(3, 3)
        self.top.set_body("top", position, rigid.RotationMatrix2EulerParameters(matrix), *rates)
        return matrix

    def wrench(self, mbs, t, *_):
        """Force and torque of the connector, as they act on its first marker, the ground."""
        matrix = self.move()
        load = self.top.load("top")
        return np.concatenate([-load.force, -matrix @ load.torque])

    def look(self, mbs, t):
        """Where the stem is after a step; its first touch, by interpolation, ends the motion."""
        self.move()
        before, self.gap = self.gap, self.top.indicators()[1]
        self.steps += 1
        if self.gap <= 0:
            self.touch = t + STEP * self.gap / (before - self.gap)
        return self.gap > 0

    def run(self, end):
        """Integrate; the CPU time [s]."""
        self.mbs.Assemble()
        settings = exu.SimulationSettings()
        settings.timeIntegration.endTime = end
        settings.timeIntegration.numberOfSteps = round(end / STEP)
        settings.solution.file.write = False
        begun = time.process_time()
        self.mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44, showHints=False)
        return time.process_time() - begun


if __name__ == "__main__":
    top = contensou.Simulation(sys.argv[1] if len(sys.argv) > 1 else "tippe_top.nml")
    expected = top.copy().advance_to_event().time
    its_cpu = Host(top, ours=False).run(2000 * STEP) / 2000
    host = Host(top, ours=True)
    cpu = host.run(2.0) / host.steps
    print(f"first touch {host.touch:.9f} s, our own run {expected:.9f} s")
    print(f"CPU {cpu * 1e6:.1f} us a step, with contacts of Exudyn {its_cpu * 1e6:.1f} us")
