"""The Tippe-Top in MuJoCo, which integrates; a passive-force callback gives our contacts.

    python3 mujoco_top.py [tippe_top.nml]

The velocities of a free joint are those of our state: of the centre of mass in the inertial frame,
and angular ones in the axes of the body. Its method is Runge-Kutta of order 4 with equal steps. The
same top with the contacts of MuJoCo shows what they cost.
"""

import sys
import time

import mujoco

import contensou

STEP = 1e-4

MODEL = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -9.81" integrator="RK4"/>
  <worldbody>
    <geom type="plane" size="1 1 1" contype="{contacts}" conaffinity="{contacts}"/>
    <body><freejoint/>
      <inertial pos="0 0 0" mass="6e-3" diaginertia="8e-7 8e-7 7e-7"/>
      <geom type="sphere" size="0.015" pos="0 0 0.003" friction="0.3 1e-6 0" condim="4"
            contype="{contacts}" conaffinity="{contacts}"/>
      <geom type="sphere" size="0.005" pos="0 0 0.016" friction="0.3 1e-6 0" condim="4"
            contype="{contacts}" conaffinity="{contacts}"/>
    </body>
  </worldbody>
</mujoco>
"""


def begin(top, contacts):
    """A model of MuJoCo with or without contacts, and its data at the beginning of the scene."""
    model = mujoco.MjModel.from_xml_string(MODEL.format(step=STEP, contacts=int(contacts)))
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = top.state[:7], top.state[7:13]
    return model, data


def in_mujoco(top):
    """Time of the first touch of the stem, steps, and CPU time [s]."""
    model, data = begin(top, contacts=False)
    stem = top.contacts.index("stem_floor")

    def move():
        top.set_body("top", data.qpos[:3], data.qpos[3:], data.qvel[:3], data.qvel[3:])

    def passive(model, data):
        move()
        load = top.load("top")
        data.qfrc_passive[:3] += load.force
        data.qfrc_passive[3:] += load.torque

    begun, gap, steps = time.process_time(), 1.0, 0
    mujoco.set_mjcb_passive(passive)
    try:
        while gap > 0 and data.time < top.end:
            mujoco.mj_step(model, data)
            move()
            before, gap = gap, top.indicators()[stem]
            steps += 1
    finally:
        mujoco.set_mjcb_passive(None)
    return data.time + STEP * gap / (before - gap), steps, time.process_time() - begun


def with_its_contacts(top, steps):
    """CPU time of as many steps with the contacts of MuJoCo [s]."""
    model, data = begin(top, contacts=True)
    begun = time.process_time()
    for _ in range(steps):
        mujoco.mj_step(model, data)
    return time.process_time() - begun


def main():
    """Print the first touch of the stem, here and there, and what it costs."""
    top = contensou.Simulation(sys.argv[1] if len(sys.argv) > 1 else "tippe_top.nml")
    expected = top.copy().advance_to_event().time
    own_cpu = with_its_contacts(top, 2000) / 2000
    touch, steps, cpu = in_mujoco(top)
    print(f"first touch {touch:.9f} s, our own run {expected:.9f} s")
    print(f"CPU {cpu / steps * 1e6:.1f} us a step, with contacts of MuJoCo {own_cpu * 1e6:.1f} us")


if __name__ == "__main__":
    main()
