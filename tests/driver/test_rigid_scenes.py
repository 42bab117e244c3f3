"""Random scenes of rigid contacts that act together: a few of each kind.

CONTENSOU_RIGID_SCENES says how many are tried, CONTENSOU_RIGID_SEED with which number they begin;
`tests/campaigns/rigid.py` tries as many as one likes and prints what it found.
"""

from __future__ import annotations

import os

import h5py
import pytest
from rigid_scenes import SCENES, against_hertz, attempt, beyond_compliance, campaign

# How many of each kind: with the release build, and with the checked one.
USUAL = {"random": (112, 28), "hostile": (60, 12), "impacts": (60, 12)}


@pytest.mark.parametrize("kind", SCENES)
def test_rigid_contacts_that_act_together_hold(executable, tmp_path, build_kind, kind):
    usual = USUAL[kind][build_kind != "release"]
    number = int(os.environ.get("CONTENSOU_RIGID_SCENES", usual))
    first = int(os.environ.get("CONTENSOU_RIGID_SEED", "0"))
    seeds = range(first, first + number)
    ends, messages, wrong, worst = campaign(executable, tmp_path, SCENES[kind], seeds)
    print(ends, *messages, worst, sep="\n")
    if wrong:
        pytest.fail(f"{len(wrong)} of {number}, in {tmp_path}\n" + "\n".join(wrong[:20]))
    assert len(messages) <= max(1, 0.01 * number), ends


def test_rigid_scenes_are_the_limit_of_compliant_ones(executable, tmp_path, build_kind):
    seeds = range(12 if build_kind == "release" else 2)
    found = {seed: against_hertz(executable, tmp_path, seed) for seed in seeds}
    found = {seed: apart for seed, apart in found.items() if apart}
    assert len(found) >= 0.7 * len(seeds)
    wrong = {seed: beyond_compliance(apart) for seed, apart in found.items()}
    assert {seed: text for seed, text in wrong.items() if text} == {}


def test_feet_that_ring_by_themselves_need_damping(executable, tmp_path):
    # Five feet below a centre of mass that is high slide with friction 0.39: the compliant ones
    # flutter, the more the stiffer they are, unless more damping holds them.
    soft, stiff = against_hertz(executable, tmp_path, 47, damping=1000.0)
    assert stiff[0] < 0.5 * soft[0] < 5e-5
    assert stiff[2] < 0.5 * soft[2] < 1e-3
    assert stiff[3] < 0.5 * soft[3] < 2e-3


@pytest.mark.parametrize(
    ("kind", "seed"),
    [("impacts", 120), ("random", 2177), ("random", 3660), ("random", 4166)],
)
def test_touches_do_not_pile_up(run, tmp_path, kind, seed):
    # A ball that creeps up to another one without a force, and a gap that opens less fast than the
    # errors of short steps close it, touched 1e6 and 4e8 times a second; a plate that stuck to
    # another one and began each time without friction, 1e7 times a second (4166).
    (tmp_path / "scene.nml").write_text(SCENES[kind](seed))
    done = run("run", "scene.nml", "-q")
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "out.h5") as file:
        assert len(file["events/time"]) < 400


@pytest.mark.parametrize("seed", [245, 676, 2356, 4104, 5000, 6796])
def test_what_rocks_under_strong_friction_comes_to_rest(executable, tmp_path, seed):
    # Feet touched in turn 1e7 times a second, at 1e-7 m/s and less, and the run was given up; in
    # stacks (245, 6796) one plate slid meanwhile.
    end, wrong, figures = attempt(executable, tmp_path, SCENES["random"](seed), patience=100)
    assert (end, wrong) == ("0", [])
    assert figures["balance"] < 1e-6


@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        # Rows within a step of explicit8 had velocities that were amplified rounding.
        ("hostile", 606),
        # Nothing held the gaps between bodies that fall alike; the errors of the integration.
        ("random", 2793),
        ("random", 2906),
        ("random", 3114),
        # Sticking friction in the rows did not agree with the accelerations, by 3e-3 of the weight.
        ("random", 3680),
        ("random", 5733),
        ("random", 7638),
        # The same by 2e-6: errors of more than ten steps add up.
        ("random", 6743),
        # Plates that stick were kicked to 1e-5 m/s by iterations with a Jacobian of earlier steps.
        ("random", 1757),
        ("random", 3464),
        ("random", 20294),
        # They were shaken to 5000 touches and slow for that, and to a jam.
        ("random", 385),
        ("random", 4977),
        # The impulses of impacts at once with friction that sticks were not found.
        ("hostile", 291),
        # They crept by a ten-thousandth of the way in each turn.
        ("hostile", 447),
        ("hostile", 575),
    ],
)
def test_scenes_that_did_not_end_well(executable, tmp_path, kind, seed):
    # Sanitizers are slow.
    end, wrong, figures = attempt(executable, tmp_path, SCENES[kind](seed), patience=100)
    assert (end, wrong) == ("0", [])
    assert figures["overlap over radius"] < 4e-7
