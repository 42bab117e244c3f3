"""Random scenes of rigid contacts that act together, as many as one likes.

    python tests/campaigns/rigid.py EXECUTABLE KIND FIRST NUMBER [JOBS]

tries NUMBER scenes of a KIND (`random`, `hostile`, `impacts`; see tests/driver/rigid_scenes.py)
from the number FIRST on, JOBS (2) at a time, and prints how they ended, which ended with a message
or with something wrong, and the largest of what must be small. CONTENSOU_RIGID_FOLDER names a
folder in which scenes that did not end well stay. The KINDs `feet`, `dumb-bell`, `block` and
`stack` compare with compliant contacts what follows the last impact
(tests/driver/compliant_scenes.py), and `hertz` does so with NUMBER scenes of each of these.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "driver"))
from compliant_scenes import KINDS, against_hertz, beyond_compliance
from rigid_scenes import SCENES, campaign


def compare(executable, folder, kind, seeds):
    """Compare rigid scenes with compliant ones, and print how far they are apart."""
    apart = {seed: against_hertz(executable, folder, seed, kind) for seed in seeds}
    known = {seed: found for seed, found in apart.items() if found}
    print(f"{kind}: {len(known)} of {len(apart)} stand on their feet in the end")
    for seed, found in known.items():
        if wrong := beyond_compliance(found):
            print(f"scene {seed}: {', '.join(wrong)}")
    figures = [found for found in known.values() if not beyond_compliance(found)]
    print(f"{len(figures)} obey; of these median, 90 %, 99 %, largest")
    for name, over in (
        ("overlap", None),
        ("centres", "overlap"),
        ("feet", "overlap"),
        ("velocities", "overlap"),
        ("feet_velocities", "overlap"),
        ("forces", None),
    ):
        for which, stiffer in enumerate(("", ", eight times as stiff")):
            values = np.array([getattr(found[which], name) for found in figures])
            if over:
                values = values / [getattr(found[which], over) for found in figures]
            parts = ", ".join(f"{x:.2g}" for x in np.quantile(values, (0.5, 0.9, 0.99, 1.0)))
            print(f"  {name}{' over ' + over if over else ''}{stiffer}: {parts}")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        folder = os.environ.get("CONTENSOU_RIGID_FOLDER", folder)
        executable, kind = os.path.abspath(sys.argv[1]), sys.argv[2]
        seeds = range(int(sys.argv[3]), int(sys.argv[3]) + int(sys.argv[4]))
        jobs = int(sys.argv[5]) if len(sys.argv) > 5 else 2
        if kind == "hertz" or kind in KINDS:
            for one in KINDS if kind == "hertz" else [kind]:
                compare(executable, folder, one, seeds)
            sys.exit()
        ends, messages, wrong, worst = campaign(executable, folder, SCENES[kind], seeds, jobs)
    for end, times in ends.most_common():
        print(f"{times:6d}  {end}")
    print("\n".join(messages[:100] + wrong[:100]))
    for name, (value, seed) in worst.items():
        print(f"largest {name}: {value:.2g} (scene {seed})")
