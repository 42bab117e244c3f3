"""Conditions of a scene that end a run: when, with every method and kind of contact, everywhere."""

from __future__ import annotations

import math
import re
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest

METHODS = ("explicit8", "cvode_bdf", "cvode_adams", "auto")
KINDS = {
    "rigid": "normal = 'rigid', restitution = 0.5",
    "compliant": "damping = 'hunt_crossley', restitution = 0.5",
}
G = 9.81
DROP = 0.1

BALL = """\
&scene gravity = 0, 0, -9.81, t_end = 2 /
&material name = 'm', young = 2e9, poisson = 0.3 /
&body name = 'ball', mass = 0.03, inertia = 3*1.2e-6, position = 0, 0, 0.11, spin = {spin} /
&surface name = 's', body = 'ball', shape = 'sphere', radius = 0.01, material = 'm' /
&surface name = 'f', body = 'ground', shape = 'plane', material = 'm' /
&contact name = 'k', surfaces = 's', 'f', {contact}, friction = 'contensou_exact',
         friction_coefficient = 0.3 /
&integrator method = '{method}' /
&output file = 'out.h5', interval = 0.01 /
&stop {stop} /
"""

TOUCH = math.sqrt(2 * DROP / G)

# Spin, condition, when it is met [s] and how right that is: the tolerance of the run, or, after an
# impact, what that takes with a compliant contact.
CONDITIONS = {
    "touch": ("0, 0, 0", "when = 'touch'", TOUCH, 1e-6),
    "lift": ("0, 0, 0", "when = 'lift', contact = 'k'", TOUCH, 5e-3),
    "speed": ("0, 0, 0", "when = 'speed', speed = 1.0", 1.0 / G, 1e-6),
    "position": ("0, 0, 0", "when = 'position', position = 0.06", math.sqrt(0.1 / G), 1e-6),
    "position down": (
        "0, 0, 0",
        "when = 'position', position = -0.06, direction = 0, 0, -7, crossing = 'rising'",
        math.sqrt(0.1 / G),
        1e-6,
    ),
    "angle": ("0, 10, 0", "when = 'angle', angle = 0.5", 0.05, 1e-6),
    "angle of x": (
        "0, 10, 0",
        "when = 'angle', axis = 1, 0, 0, direction = 3, 0, 0, angle = 0.5",
        0.05,
        1e-6,
    ),
    "spin": (
        "0, 20, 0",
        "when = 'spin', angular_velocity = 19.9, crossing = 'falling'",
        TOUCH,
        5e-3,
    ),
    "late speed": ("0, 0, 0", "when = 'speed', speed = 1.0, crossing = 'falling'", TOUCH, 5e-3),
    "rest": ("0, 0, 0", "when = 'rest', duration = 0.2", 3 * TOUCH + 0.2, 2e-2),
}


def ended(folder, name="out.h5"):
    """The last time of a complete run, the condition that ended it, and the whole file's data."""
    with h5py.File(folder / name) as f:
        assert f.attrs["status"] == "complete"
        t = f["trajectory/time"][:]
        assert f["summary/time"][()] == t[-1]
        assert (np.diff(t) > 0).all()
        by = f.attrs.get("stopped_by")
        number = f["summary/stop"][()]
        return t[-1], by, number, {k: f["trajectory"][k][-1] for k in ("position", "velocity")}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("method", METHODS)
def test_every_condition_with_every_method(run, tmp_path, kind, method):
    for name, (spin, stop, when, right) in CONDITIONS.items():
        text = BALL.format(spin=spin, stop=stop, contact=KINDS[kind], method=method)
        (tmp_path / "ball.nml").write_text(text)
        done = run("run", "ball.nml", "--force")
        assert done.status == 0, (name, done.err)
        word = re.match(r"when = '(\w+)'", stop)[1]
        assert re.search(rf"^  stopped    by '{word}': ", done.out, re.MULTILINE), (name, done.out)
        t, by, number, last = ended(tmp_path)
        assert (by, number) == (word, 1), name
        assert t == pytest.approx(when, rel=right), name
        # The last row is at the condition, not behind it.
        if name == "speed":
            assert np.linalg.norm(last["velocity"]) == pytest.approx(1.0, rel=1e-9)
        if name.startswith("position"):
            assert last["position"][0, 2] == pytest.approx(0.06, rel=1e-9)


def test_a_run_without_condition_met_goes_to_its_end(run, tmp_path):
    text = BALL.format(
        spin="0, 0, 0", stop="when = 'speed', speed = 10", contact=KINDS["rigid"], method="auto"
    )
    (tmp_path / "ball.nml").write_text(text)
    done = run("run", "ball.nml")
    assert done.status == 0, done.err
    assert "stopped" not in done.out
    t, by, number, _ = ended(tmp_path)
    assert (t, by, number) == (2.0, None, 0)
    # The rows are those of a run without conditions, bit for bit.
    (tmp_path / "plain.nml").write_text(re.sub(r"&stop .*\n", "", text))
    assert run("run", "plain.nml", "-o", "plain.h5", "-q").status == 0
    with h5py.File(tmp_path / "out.h5") as a, h5py.File(tmp_path / "plain.h5") as b:
        for key in ("position", "velocity", "quaternion"):
            assert (a["trajectory"][key][:] == b["trajectory"][key][:]).all()


def test_the_first_of_several_conditions_ends_the_run(run, tmp_path):
    text = BALL.format(
        spin="0, 0, 0",
        stop="name = 'late', when = 'touch' /\n&stop name = 'early', when = 'speed', speed = 1",
        contact=KINDS["rigid"],
        method="auto",
    )
    (tmp_path / "ball.nml").write_text(text)
    done = run("run", "ball.nml")
    assert done.status == 0, done.err
    assert "  stopped    by 'early': speed of ball is 1.0 m/s\n" in done.out
    t, by, number, _ = ended(tmp_path)
    assert (by, number) == ("early", 2)
    assert t == pytest.approx(1 / G, rel=1e-8)


COIN = """\
&scene gravity = 0, 0, -9.81, t_end = 2 /
&material name = 'm', young = 2e9, poisson = 0.3 /
&body name = 'coin', mass = 0.01, inertia = 6e-7, 6e-7, 1.1e-6, position = 0, 0, {z!r},
      axis = 0, 1, 0, angle = {tilt!r} /
&surface name = 'rim', body = 'coin', shape = 'torus', major_radius = 0.01, minor_radius = 1e-3,
         material = 'm' /
&surface name = 'table', body = 'ground', shape = 'plane', material = 'm' /
&contact name = 'k', surfaces = 'rim', 'table', {contact}, friction = 'coulomb',
         friction_coefficient = 0.3, regularization_velocity = 0.01 /
&integrator method = '{method}' /
&output file = 'out.h5', interval = 0.001 /
"""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("method", METHODS)
def test_a_coin_that_comes_to_lie_flat(run, tmp_path, kind, method):
    tilt = 0.2
    text = COIN.format(
        z=0.01 * math.sin(tilt) + 1e-3, tilt=tilt, contact=KINDS[kind], method=method
    )
    (tmp_path / "coin.nml").write_text(text)
    done = run("run", "coin.nml", "-q")
    assert done.status == 1
    # A method may give up where the surfaces only nearly conform; those of a rigid contact do then.
    if kind == "rigid" or "the surfaces conform" in done.err:
        assert "the surfaces conform" in done.err
        assert "when = 'conforming'" in done.err
    (tmp_path / "coin.nml").write_text(text + "&stop when = 'conforming' /\n")
    done = run("run", "coin.nml", "--force")
    assert done.status == 0, done.err
    assert "  stopped    by 'conforming': the surfaces of k conform\n" in done.out
    t, by, number, last = ended(tmp_path)
    assert (by, number) == ("conforming", 1)
    assert 0.0 < t < 2.0
    assert last["position"][0, 2] == pytest.approx(1e-3, abs=2e-4)


def test_a_run_that_is_resumed_ends_as_one_that_is_not(run, executable, tmp_path, slow_build):
    # It is at rest long before it ends, and is interrupted again and again meanwhile.
    step = 2e-4 if slow_build else 4e-5
    text = BALL.format(
        spin="0, 0, 0",
        stop="when = 'rest', duration = 1.2",
        contact=KINDS["rigid"],
        method="explicit8",
    ).replace("'explicit8'", f"'explicit8', max_step = {step}")
    (tmp_path / "ball.nml").write_text(text)
    assert run("run", "ball.nml", "-o", "whole.h5", "-q").status == 0
    lives = 0
    for _ in range(50):
        words = [executable, "run", "ball.nml", "-q", "--resume", "--checkpoint=0.01"]
        process = subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE)
        before = checkpoint_of(tmp_path)
        while lives < 4 and process.poll() is None and checkpoint_of(tmp_path) == before:
            time.sleep(0.001)
        if lives < 4:
            process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=60)
        lives += 1
        if process.returncode == 0:
            break
        assert process.returncode in {75, -signal.SIGTERM}, err
    t, by, number, _ = ended(tmp_path)
    whole = ended(tmp_path, "whole.h5")
    assert t == pytest.approx(whole[0], rel=1e-9)
    assert (by, number) == whole[1:3] == ("rest", 1)
    assert lives > 1
    # Once more: it is complete, and nothing is done.
    assert run("run", "ball.nml", "--resume", "-q").status == 0


def checkpoint_of(folder):
    """What tells one checkpoint from the next one."""
    try:
        return (folder / "out.h5.part.checkpoint").stat().st_ino
    except FileNotFoundError:
        return None


@pytest.mark.parametrize("kind", KINDS)
def test_a_sweep_tells_which_condition_ended_each_case(run, tmp_path, kind):
    text = BALL.format(
        spin="0, 0, 0",
        stop="when = 'touch' /\n&stop name = 'fast', when = 'speed', speed = 1.2",
        contact=KINDS[kind],
        method="auto",
    )
    (tmp_path / "ball.nml").write_text(text.replace("t_end = 2", "t_end = 0.2"))
    (tmp_path / "sweep.nml").write_text(
        "&sweep scene = 'ball.nml', output = 'table.h5', keep = 'time', 'stop' /\n"
        "&parameter name = 'ball.position(3)', values = 0.03, 0.11, 0.05, 0.5 /\n"
        "&parameter name = 'fast.speed', values = 1.2, 5.0 /\n"
    )
    done = run("sweep", "sweep.nml")
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "table.h5") as f:
        stop = f["results/stop"][:]
        assert f["results/stop"].attrs["long_name"].endswith(", 1 for touch, 2 for fast")
        when = f["results/time"][:]
    assert sorted(stop) == [0, 1, 1, 1, 1, 1, 2, 2]
    assert when[stop == 2] == pytest.approx(1.2 / G, rel=1e-8)
    assert when[stop == 0] == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("stop", "message", "expected"),
    [
        ("when = 'rset'", "unknown when 'rset'", "'rest'"),
        ("body = 'ball'", "'when' is missing in group &stop", "rest"),
        ("when = 'angle'", "'angle' is missing", "angle = a number"),
        ("when = 'angle', angle = 4", "'angle' is out of range", "3.14"),
        ("when = 'angle', angle = 1, axis = 0, 0, 0", "'axis' is a zero vector", "any length"),
        ("when = 'touch', speed = 1", "'speed' has no meaning for when = 'touch'", "contact"),
        ("when = 'touch', contact = 'l'", "there is no contact 'l'", "&contact"),
        ("when = 'rest', body = 'ground'", "the ground never moves", "the name of a body"),
        ("when = 'speed', body = 'bal', speed = 1", "there is no body 'bal'", "'ball'"),
        ("when = 'speed', speed = -1", "'speed' is out of range", "> 0"),
        ("when = 'rest', duration = -1", "'duration' is out of range", ">= 0"),
    ],
)
def test_what_a_condition_cannot_be(run, mistakes, tmp_path, stop, message, expected):
    text = BALL.format(spin="0, 0, 0", stop=stop, contact=KINDS["rigid"], method="auto")
    (tmp_path / "ball.nml").write_text(text)
    done = run("check", "ball.nml")
    assert done.status == 2, done.out
    (mistake,) = mistakes(done.err)
    assert mistake.line == 10
    assert message in mistake.message
    assert expected in mistake.expected


def test_a_condition_without_body_where_there_are_two(run, mistakes, tmp_path):
    text = BALL.format(
        spin="0, 0, 0", stop="when = 'speed', speed = 1", contact=KINDS["rigid"], method="auto"
    )
    text += "&body name = 'other', mass = 1, inertia = 3*1e-5, position = 1, 0, 0 /\n"
    (tmp_path / "ball.nml").write_text(text)
    done = run("check", "ball.nml")
    assert done.status == 2
    (mistake,) = mistakes(done.err)
    assert "'body' is missing in group &stop with when = 'speed'" in mistake.message


def test_conditions_are_set_like_all_else(run, tmp_path):
    text = BALL.format(
        spin="0, 0, 0", stop="when = 'speed', speed = 1", contact=KINDS["rigid"], method="auto"
    )
    (tmp_path / "ball.nml").write_text(text)
    assert run("run", "ball.nml", "-q", "--set", "stop.speed=0.5").status == 0
    t, by, _, _ = ended(tmp_path)
    assert by == "speed"
    assert t == pytest.approx(0.5 / G, rel=1e-8)
    done = run("check", "ball.nml", "--expand")
    (tmp_path / "again.nml").write_text(done.out)
    assert run("run", "again.nml", "-q", "-o", "again.h5").status == 0
    assert ended(tmp_path, "again.h5")[0] == pytest.approx(1 / G, rel=1e-8)
