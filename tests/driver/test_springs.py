"""Springs between bodies: closed forms, balances, what a scene says and what is refused."""

from __future__ import annotations

import math

import h5py
import numpy as np
import pytest

TWO = """\
&scene gravity = 0, 0, -9.81, t_end = 2.0 /
&body name = 'a', mass = 2.0, inertia = 0.02, 0.03, 0.04, position = 0.1, 0.2, 0.3,
   axis = 1, 2, 3, angle = 0.4, spin = 1, 2, 0.5, velocity = 0.1, 0, 0.3 /
&body name = 'b', mass = 1.0, inertia = 0.01, 0.01, 0.015, position = 0.5, 0, 0,
   spin = -1, 2, 0.5 /
&spring name = 'hang', bodies = 'ground', 'a', kind = 'axial', first_point = 0, 0, 1,
   second_point = 0.05, 0, 0.1, stiffness = 400.0, damping = 2.0 /
&spring name = 'bush', bodies = 'a', 'b', second_point = -0.2, 0, 0, preload = 1, 0, 5,
   stiffness = 1000, 2000, 500, rotational_stiffness = 1, 2, 3, damping = 1, 2, 3,
   rotational_damping = 0.01, axis = 0, 1, 1, angle = 0.3 /
&integrator rtol = 1e-10 /
"""
ONE = """\
&scene t_end = 1.0 /
&body name = 'a', mass = 2.0, inertia = 0.02, 0.03, 0.04, {body} /
&spring name = 's', bodies = 'ground', 'a', {spring} /
&integrator method = 'explicit8', rtol = 1e-12 /
"""


@pytest.mark.parametrize(("method", "bound"), [("explicit8", 1e-13), ("cvode_bdf", 1e-9)])
def test_the_balance_closes(method, bound, simulate):
    found = simulate(TWO, f"integrator.method={method}").columns
    energy = sum(found[f"energy_{kind}"] for kind in ("kinetic", "potential", "elastic"))
    assert found["work_damping"][-1] > 0.1
    assert np.abs(energy + found["work_damping"] - energy[0]).max() < bound * abs(energy[0])
    assert np.abs(found["energy_error"]).max() < bound * abs(energy[0])
    # They turn by radians, and both springs work.
    assert np.ptp(found["energy_springs"]) > 0.1
    assert found["energy_springs"] == pytest.approx(found["energy_elastic"], rel=1e-14)
    assert found["spring_force"].shape == (1001, 2, 3)
    assert np.abs(found["spring_torque"][:, 0]).max() == 0


def test_methods_agree_and_momentum_is_conserved(simulate):
    free = TWO.replace("gravity = 0, 0, -9.81, ", "").replace(
        "'ground', 'a', kind", "'b', 'a', kind"
    )
    runs = [
        simulate(free, f"integrator.method={method}").columns
        for method in ("explicit8", "cvode_bdf")
    ]
    assert runs[0]["position"] == pytest.approx(runs[1]["position"], abs=1e-7)
    found = runs[0]
    mass = np.array([2.0, 1.0])
    inertia = np.array([[0.02, 0.03, 0.04], [0.01, 0.01, 0.015]])
    linear = np.einsum("b,tbi->ti", mass, found["velocity"])
    angular = np.einsum("b,tbi->ti", mass, np.cross(found["position"], found["velocity"]))
    for body in range(2):
        w, x, y, z = found["quaternion"][:, body].T
        norm = w * w + x * x + y * y + z * z
        rotation = (
            np.array(
                [
                    [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
                    [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
                    [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
                ]
            )
            / norm
        )
        spin = np.einsum("ijt,ti->tj", rotation, found["angular_velocity"][:, body])
        angular += np.einsum("ijt,tj->ti", rotation, spin * inertia[body])
    assert linear == pytest.approx(np.broadcast_to(linear[0], linear.shape), abs=1e-12)
    assert angular == pytest.approx(np.broadcast_to(angular[0], angular.shape), abs=1e-11)


def test_a_damped_oscillator(simulate):
    body = "velocity = 0, 0.3, 0"
    spring = "stiffness = 200.0, 300.0, 100.0, damping = 4.0"
    found = simulate(ONE.format(body=body, spring=spring)).columns
    decay, square = 4.0 / 4.0, 300.0 / 2.0
    w = math.sqrt(square - decay**2)
    t = found["time"]
    y = 0.3 / w * np.exp(-decay * t) * np.sin(w * t)
    assert found["position"][:, 0, 1] == pytest.approx(y, abs=1e-9)
    speed = 0.3 * np.exp(-decay * t) * (np.cos(w * t) - decay / w * np.sin(w * t))
    assert found["spring_force"][:, 0, 1] == pytest.approx(-300.0 * y - 4.0 * speed, abs=1e-7)


def test_a_torsional_oscillator_and_a_drag(simulate):
    body = "spin = 0, 0, 8.0"
    found = simulate(ONE.format(body=body, spring="rotational_stiffness = 1, 2, 3")).columns
    w = math.sqrt(3.0 / 0.04)
    angle = 8.0 / w * np.sin(w * found["time"])
    assert angle.max() > 0.9
    turned = 2 * np.arctan2(found["quaternion"][:, 0, 3], found["quaternion"][:, 0, 0])
    assert turned == pytest.approx(angle, abs=1e-9)
    assert found["spring_torque"][:, 0, 2] == pytest.approx(-3.0 * angle, abs=1e-8)
    found = simulate(ONE.format(body=body, spring="rotational_damping = 0, 0, 0.2")).columns
    spin = 8.0 * np.exp(-0.2 / 0.04 * found["time"])
    assert found["angular_velocity"][:, 0, 2] == pytest.approx(spin, abs=1e-9)
    assert found["work_damping"] == pytest.approx(0.02 * (64.0 - spin**2), abs=1e-9)


def test_a_spring_between_two_points(simulate):
    # Along its line an oscillator about the length.
    body = "position = 0, 0, -1.1"
    spring = "kind = 'axial', stiffness = 50.0, length = 1.0"
    found = simulate(ONE.format(body=body, spring=spring)).columns
    z = -1.0 - 0.1 * np.cos(5.0 * found["time"])
    assert found["position"][:, 0, 2] == pytest.approx(z, abs=1e-10)
    assert found["energy_springs"] == pytest.approx(25.0 * (z + 1.0) ** 2, abs=1e-10)


def test_what_follows_is_written_and_gives_the_same_run(simulate, tmp_path):
    first = simulate(TWO).columns
    with h5py.File(tmp_path / "out.h5") as file:
        resolved = file["input/resolved"][()].decode()
        assert [n.decode() for n in file["spring/name"]] == ["hang", "bush"]
        bodies = [[n.decode().strip() for n in pair] for pair in file["spring/bodies"]]
        assert bodies == [["ground", "a"], ["a", "b"]]
    for key in ("length = ", "first_point = ", "relaxed_quaternion = "):
        assert key in resolved
    again = simulate(resolved).columns
    # The axes of a bushing are fixed by numbers, its relaxed attitude among them.
    for name in ("position", "spring_force"):
        assert again[name] == pytest.approx(first[name], abs=1e-12), name


def test_points_of_a_solid_have_the_origin_of_its_surfaces(simulate):
    text = """\
&scene gravity = 0, 0, -9.81, t_end = 0.1 /
&material name = 'steel', young = 2e11, poisson = 0.3 /
&body name = 'a', density = 7800, position = 0, 0, 0 /
&surface name = 'a', body = 'a', shape = 'sphere', centre = {c}, radius = 0.05, material = 'steel' /
&spring name = 's', bodies = 'ground', 'a', first_point = 0.1, 0, 0, second_point = {p},
   stiffness = 1e4 /
"""
    there = simulate(text.format(c="0.2, 0, 0", p="0.3, 0, 0")).columns
    here = simulate(text.format(c="0, 0, 0", p="0.1, 0, 0")).columns
    assert there["position"] == pytest.approx(here["position"], abs=1e-14)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("bodies = 'a', 'a', stiffness = 1", "joins a body to itself"),
        ("bodies = 'ground', 'ground', stiffness = 1", "joins a body to itself"),
        ("bodies = 'ground', 'wall', stiffness = 1", "neither of its bodies yields"),
        ("bodies = 'ground', 'a'", "does nothing"),
        ("bodies = 'ground', 'a', stiffness = 1, 2", "has two values"),
        ("bodies = 'ground', 'a', stiffness = -1, damping = 1", "stiffness"),
        ("bodies = 'ground', 'a', stiffness = 1, length = 1", "no meaning for a bushing"),
        ("bodies = 'ground', 'a', kind = 'axial', stiffness = 1", "coincide"),
        (
            "bodies = 'ground', 'a', kind = 'axial', stiffness = 1, 2, 3, second_point = 1, 0, 0",
            "several values",
        ),
        (
            "bodies = 'ground', 'a', kind = 'axial', stiffness = 1, preload = 1, 0, 0,"
            " second_point = 1, 0, 0",
            "'preload' has no meaning",
        ),
        ("bodies = 'ground', 'b', stiffness = 1", "there is no body 'b'"),
    ],
)
def test_mistakes(keys, message, run, mistakes, tmp_path):
    (tmp_path / "s.nml").write_text(
        "&scene t_end = 1 /\n&body name = 'a', mass = 1, inertia = 3*1.0 /\n"
        f"&body name = 'wall', motion = 'fixed' /\n&spring name = 's', {keys} /\n"
    )
    result = run("run", "s.nml")
    assert result.status == 2
    (mistake,) = mistakes(result.err)
    assert mistake.line == 4
    assert message in mistake.message
    assert mistake.expected
    assert not (tmp_path / "s.h5").exists()
