"""Random scenes of rigid contacts that act together: a few of each kind.

CONTENSOU_RIGID_SCENES says how many are tried, CONTENSOU_RIGID_SEED with which number they begin,
CONTENSOU_RIGID_LIMITS how many are compared with compliant contacts;
`tests/campaigns/rigid.py` tries as many as one likes and prints what it found.
"""

from __future__ import annotations

import os
import re

import h5py
import numpy as np
import pytest
from compliant_scenes import against_hertz, beyond_compliance, not_less
from rigid_scenes import SCENES, attempt, campaign

# How many of each kind: with the release build, and with the checked one.
USUAL = {"random": (112, 16), "hostile": (60, 12), "impacts": (60, 12)}


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


# How many of each kind are compared with compliant ones: with the release build, and the checked
# one; and those that flutter by themselves unless more damping holds them.
COMPARED = {"feet": (200, 2), "dumb-bell": (67, 2), "block": (67, 1), "stack": (66, 1)}
RINGING = {"feet": {47}, "block": {2, 47}, "stack": {30, 34}}


@pytest.mark.sample(2)
@pytest.mark.parametrize("kind", COMPARED)
def test_rigid_scenes_are_the_limit_of_compliant_ones(executable, tmp_path, build_kind, kind):
    usual = COMPARED[kind][build_kind != "release"]
    number = int(os.environ.get("CONTENSOU_RIGID_LIMITS", usual))
    seeds = set(range(number)) - RINGING.get(kind, set())
    found = {seed: against_hertz(executable, tmp_path, seed, kind) for seed in seeds}
    found = {seed: apart for seed, apart in found.items() if apart}
    assert len(found) >= 0.95 * len(seeds)
    wrong = {seed: beyond_compliance(apart) for seed, apart in found.items()}
    if kind == "feet":
        # Where nothing stops or rolls these, too, shrink from one instant to the same one.
        for seed, apart in found.items():
            wrong[seed] += not_less(apart, ("velocities", "forces"), 1e-6)
    assert {seed: text for seed, text in wrong.items() if text} == {}
    # The centre lies lower by the overlaps and by nothing else.
    lower = np.array([apart[1].centres / apart[1].overlap for apart in found.values()])
    assert lower.max() < 1.01
    # A median of the checked build's one or two scenes would say nothing.
    if len(lower) > 10:
        assert np.median(lower) > 0.8


def test_feet_that_ring_by_themselves_need_damping(executable, tmp_path):
    # Five feet below a centre of mass that is high slide with friction 0.39: the compliant ones
    # flutter, the more the stiffer they are, unless more damping holds them.
    soft, stiff = against_hertz(executable, tmp_path, 47, damping=1000.0)
    assert stiff.centres < 0.5 * soft.centres < 5e-5
    assert stiff.velocities < 0.5 * soft.velocities < 1e-3
    assert stiff.forces < 0.5 * soft.forces < 2e-3


@pytest.mark.sample(1)
@pytest.mark.parametrize(("kind", "seed"), [("block", 2), ("block", 47), ("stack", 30)])
def test_what_rings_by_itself_obeys_with_damping(executable, tmp_path, kind, seed):
    assert beyond_compliance(against_hertz(executable, tmp_path, seed, kind, damping=1000.0)) == []


@pytest.mark.release_only("a limit of many steps")
def test_a_stack_that_rings_has_the_same_limit(executable, tmp_path):
    # Three plates that slide and turn: the places obey with any damping, the velocities follow.
    soft, stiff = against_hertz(
        executable, tmp_path, 34, "stack", youngs=(1e9, 6.4e10), damping=1000.0
    )
    assert soft.feet < 3 * soft.overlap
    assert stiff.feet < 3 * stiff.overlap
    assert stiff.feet_velocities < 0.1 * soft.feet_velocities < 1e-4


@pytest.mark.sample(2)
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


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", [245, 4419, 5091])
def test_what_seems_to_close_after_it_opened_is_no_step(run, tmp_path, seed):
    # An interpolant let gaps that had just opened fall below their thresholds, 2500 times within a
    # step, each of which `auto` took for a step, so that it went on with explicit8 where friction
    # sticks: 30417 steps and more.
    (tmp_path / "scene.nml").write_text(SCENES["random"](seed))
    done = run("run", "scene.nml", "-q")
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "out.h5") as file:
        assert file["integrator/steps"][()] < 3000


def test_what_seems_to_close_after_it_opened_costs_little(run, tmp_path):
    # To find the 5000 events within steps took 76 % of the time.
    text = SCENES["random"](4419).replace("'auto'", "'cvode_bdf'")
    (tmp_path / "scene.nml").write_text(text)
    done = run("run", "scene.nml", "-q", "--profile")
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "out.h5") as file:
        names = list(file["integrator/effect"][()])
        assert file["integrator/cpu_share"][names.index(b"events")] < 0.4


def test_a_method_that_was_left_gets_no_more_steps_each_time(run, tmp_path):
    # In bursts of touches `auto` went back to explicit8, for twice as many steps each time, though
    # friction stuck: 125548 steps; cvode_bdf alone takes 9033.
    (tmp_path / "scene.nml").write_text(SCENES["random"](7915))
    done = run("run", "scene.nml", "-q")
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "out.h5") as file:
        assert file["integrator/steps"][()] < 25000


@pytest.mark.sample(2)
@pytest.mark.parametrize("seed", [245, 676, 2356, 4104, 5000, 6796])
def test_what_rocks_under_strong_friction_comes_to_rest(executable, tmp_path, seed):
    # Feet touched in turn 1e7 times a second, at 1e-7 m/s and less, and the run was given up; in
    # stacks (245, 6796) one plate slid meanwhile.
    end, wrong, figures = attempt(executable, tmp_path, SCENES["random"](seed), patience=100)
    assert (end, wrong) == ("0", [])
    assert figures["balance"] < 1e-6


@pytest.mark.sample(4)
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


def test_a_force_that_is_decided_once_is_found_once(executable, tmp_path):
    """A negative force was right for the decision and a pull for the check of the step."""
    text = re.sub(r"method *= *'\w+'", "method = 'auto'", SCENES["random"](70777))
    assert "method = 'auto'" in text
    end, wrong, figures = attempt(executable, tmp_path, text, patience=100)
    assert (end, wrong) == ("0", [])
    assert figures["overlap over radius"] < 4e-7
