"""Shipped scenes as FMUs in FMPy, at full length: co-simulation and model exchange.

    python tests/campaigns/exchange.py [VERSION [SCENE ...]]

writes each scene as an FMU of FMI VERSION (3), simulates it with FMPy and holds it against
`contensou run`: in co-simulation all bodies at all rows, bit for bit where host and run name the
same time; in model exchange, integrated by FMPy's CVODE, where they are at the rows, within 1e-3
of the longest way of a body along an axis. Exit status 1 if something is wrong. CONTENSOU names
the executable.

FMPy's CVODE takes at most 500 steps from one output to the next, so the outputs of stiff scenes
have to be as near to each other as `INTERVALS` says.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import fmpy
import h5py
import numpy as np

INPUTS = Path(__file__).resolve().parents[2] / "inputs"

# Time from one output to the next in model exchange [s]; where none is given, that of rows.
INTERVALS = {
    "break_shot": 2e-5,
    "rattleback": 2e-4,
}

# Relative tolerance of FMPy's CVODE, and that of scenes that multiply an error.
TOLERANCE = 1e-8
TOLERANCES = {"rattleback": 1e-10}


def columns(bodies):
    """Names of the outputs that say where bodies are and how they turn."""
    return [
        f"{body}.{kind}.{axis}"
        for kind in ("position", "angular_velocity")
        for body in bodies
        for axis in "xyz"
    ]


def simulated(executable, version, scene, folder):
    """Figures of a scene, and what is wrong."""
    subprocess.run([executable, "run", scene, "-q", "-o", folder / "run.h5", "--force"], check=True)
    subprocess.run(
        [executable, "fmu", scene, "-o", folder / "scene.fmu", "--fmi", version, "--force"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    with h5py.File(folder / "run.h5") as file:
        rows = file["trajectory"]
        bodies = [name.decode() for name in file["body/name"]]
        times = rows["time"][()]
        place = rows["position"][()].reshape(len(times), -1)
        spin = rows["angular_velocity"][()].reshape(len(times), -1)
    written = np.hstack([place, spin])
    end = times[-1]
    distance = times[1]
    wrong = []

    result = fmpy.simulate_fmu(
        str(folder / "scene.fmu"),
        fmi_type="CoSimulation",
        stop_time=end,
        output_interval=distance,
        output=columns(bodies),
    )
    same = np.isin(result["time"], times)
    found = np.array([result[name][same] for name in columns(bodies)]).T
    bits = found.tobytes() == written[np.isin(times, result["time"])].tobytes()
    if not bits or same.sum() < 10:
        wrong.append("co-simulation has other bits")

    began = time.process_time()
    interval = INTERVALS.get(scene.stem, distance)
    result = fmpy.simulate_fmu(
        str(folder / "scene.fmu"),
        fmi_type="ModelExchange",
        stop_time=end,
        output_interval=interval,
        relative_tolerance=TOLERANCES.get(scene.stem, TOLERANCE),
        output=columns(bodies),
    )
    spent = time.process_time() - began
    # With a row before and one after each event.
    rows = result[np.minimum(np.searchsorted(result["time"], times - 1e-12), len(result) - 1)]
    found = np.array([rows[name] for name in columns(bodies)]).T
    apart = np.abs(found - written)[:, : place.shape[1]].max()
    way = np.abs(place - place[0]).max()
    if apart > 1e-3 * way + 1e-9:
        wrong.append("model exchange moves otherwise")
    return (len(times), int(same.sum()), len(result), interval, spent, way, apart), wrong


def main():
    """Simulate the scenes and print a line for each."""
    executable = os.environ["CONTENSOU"]
    version, *names = sys.argv[1:] or ["3"]
    scenes = sorted([*INPUTS.glob("*.nml"), *INPUTS.glob("examples/*.nml")])
    failed = 0
    print(f"{'scene':21}  rows   same  outputs  interval [s]  CPU [s]  way [m]  apart [m]")
    for scene in scenes:
        if names and scene.stem not in names:
            continue
        with tempfile.TemporaryDirectory() as folder:
            try:
                figures, wrong = simulated(executable, version, scene, Path(folder))
            except Exception as trouble:
                print(f"{scene.stem:21} {trouble}", flush=True)
                failed += 1
                continue
        print(
            f"{scene.stem:21} {figures[0]:5d}  {figures[1]:5d} {figures[2]:8d}  "
            + "  ".join(f"{value:.1e}" for value in figures[3:]),
            *wrong,
            flush=True,
        )
        failed += bool(wrong)
    print(f"{failed} wrong")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
