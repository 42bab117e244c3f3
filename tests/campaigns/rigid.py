"""Random scenes of rigid contacts that act together, as many as one likes.

    python tests/campaigns/rigid.py EXECUTABLE KIND FIRST NUMBER [JOBS]

tries NUMBER scenes of a KIND (`random`, `hostile`, `impacts`; see tests/driver/rigid_scenes.py)
from the number FIRST on, JOBS (2) at a time, and prints how they ended, which ended with a message
or with something wrong, and the largest of what must be small. CONTENSOU_RIGID_FOLDER names a
folder in which scenes that did not end well stay. The KIND `hertz` compares with compliant contacts
what follows the last impact.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "driver"))
from rigid_scenes import SCENES, against_hertz, beyond_compliance, campaign


def compare(executable, folder, seeds):
    """Compare rigid scenes with compliant ones, and print how far they are apart."""
    apart = {seed: against_hertz(executable, folder, seed) for seed in seeds}
    known = {seed: found for seed, found in apart.items() if found}
    print(f"{len(known)} of {len(apart)} rest or slide on three feet at least in the end")
    for seed, found in known.items():
        if wrong := beyond_compliance(found):
            print(f"scene {seed}: {', '.join(wrong)}")
    for k, name in enumerate(
        ("distance over overlap", "", "velocities [m/s]", "forces over weight")
    ):
        if name:
            largest = [
                max(found[i][k] / (found[i][1] if k == 0 else 1) for found in known.values())
                for i in (0, 1)
            ]
            print(f"largest {name}: {largest[0]:.2g}, eight times as stiff {largest[1]:.2g}")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        folder = os.environ.get("CONTENSOU_RIGID_FOLDER", folder)
        executable, kind = os.path.abspath(sys.argv[1]), sys.argv[2]
        seeds = range(int(sys.argv[3]), int(sys.argv[3]) + int(sys.argv[4]))
        jobs = int(sys.argv[5]) if len(sys.argv) > 5 else 2
        if kind == "hertz":
            sys.exit(compare(executable, folder, seeds))
        ends, messages, wrong, worst = campaign(executable, folder, SCENES[kind], seeds, jobs)
    for end, times in ends.most_common():
        print(f"{times:6d}  {end}")
    print("\n".join(messages[:100] + wrong[:100]))
    for name, (value, seed) in worst.items():
        print(f"largest {name}: {value:.2g} (scene {seed})")
