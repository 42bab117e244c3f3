"""The Tippe-Top in SciPy, which integrates the equations of motion of Contensou.

    python3 scipy_top.py [tippe_top.nml]

SciPy gets derivatives, and the gap of the stem as an event. It has no contact of its own: the times
are beside those of our own integrator.
"""

import sys
import time

from scipy.integrate import solve_ivp

import contensou

TOLERANCE = 1e-8


def in_scipy(scene):
    """Time of the first touch of the stem, evaluations, and CPU time [s]."""
    top = contensou.Simulation(scene)
    stem = top.contacts.index("stem_floor")

    def gap(t, y):
        return top.indicators(t, y)[stem]

    gap.terminal, gap.direction = True, -1
    begun = time.process_time()
    found = solve_ivp(
        top.derivative,
        (0, top.end),
        top.state,
        method="DOP853",
        rtol=TOLERANCE,
        atol=1e-12,
        events=gap,
    )
    return found.t_events[0][0], found.nfev, time.process_time() - begun


def alone(scene):
    """The same by the integrator of the scene."""
    top = contensou.Simulation(scene)
    begun = time.process_time()
    event = top.advance_to_event()
    return event.time, time.process_time() - begun


def main():
    """Print the first touch of the stem, here and there, and what it costs."""
    scene = sys.argv[1] if len(sys.argv) > 1 else "tippe_top.nml"
    touch, evaluations, cpu = in_scipy(scene)
    expected, own_cpu = alone(scene)
    print(f"first touch {touch:.9f} s, our own run {expected:.9f} s")
    print(f"CPU {cpu:.2f} s of {evaluations} evaluations, our own run {own_cpu:.2f} s")


if __name__ == "__main__":
    main()
