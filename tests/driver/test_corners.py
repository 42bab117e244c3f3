"""What no other test of the driver comes by: parts of a scene that are seldom put together."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

ROLLING = (
    "&scene gravity = 0, 0, -9.81, t_end = 0.5 /\n"
    "&material name = 'wood', young = 9.1e9, poisson = 0.3 /\n"
    "&body name = 'ball', mass = 0.05, inertia = 3*8.0e-6, position = 0, 0, 0.0199994,\n"
    "   velocity = 0.5, 0, 0, spin = 0, 25.0, 0 /\n"
    "&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.02, material = 'wood' /\n"
    "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'wood' /\n"
    "&contact name = 'touch', surfaces = 'floor', 'skin', damping = 'hunt_crossley',\n"
    "   damping_coefficient = 100, friction = 'contensou_exact', friction_coefficient = 0.3 {} /\n"
    "&output file = 'out.h5' /\n"
)


def test_rolling_resistance_slows_a_ball(run, tmp_path):
    # Rolling without sliding under the torque m g l: deceleration g l/(r (1 + I/(m r^2))).
    keys = ", rolling = 'constant', rolling_coefficient = 1e-4, rolling_regularization = 1e-3"
    (tmp_path / "scene.nml").write_text(ROLLING.format(keys))
    result = run("run", "scene.nml", "-q")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "out.h5") as file:
        time = file["trajectory/time"][:]
        speed = file["trajectory/velocity"][:, 0, 0]
    late = time > 0.1
    slope = np.polyfit(time[late], speed[late], 1)[0]
    assert slope == pytest.approx(-9.81 * 1e-4 / 0.02 / 1.4, rel=0.01)


@pytest.mark.parametrize(
    "keys", [", rolling_coefficient = 1e-4", ", rolling_regularization = 1e-3"]
)
def test_rolling_keys_without_rolling(run, tmp_path, mistakes, keys):
    (tmp_path / "scene.nml").write_text(ROLLING.format(keys))
    result = run("check", "scene.nml")
    assert result.status == 2
    assert any("without 'rolling'" in m.message for m in mistakes(result.err))


def test_no_free_body(run, tmp_path, mistakes):
    text = ROLLING.format("").replace("name = 'ball',", "name = 'ball', motion = 'prescribed',", 1)
    (tmp_path / "scene.nml").write_text(text)
    result = run("check", "scene.nml")
    assert result.status == 2
    assert any("neither of its bodies is free" in m.message for m in mistakes(result.err))


@pytest.mark.parametrize("normal", ["hertz", "vilke"])
def test_energy_of_changing_curvatures(run, root, tmp_path, normal):
    # An egg that rocks: the elastic energy depends on the curvatures, and forces come of that.
    result = run(
        "run",
        root / "tests" / "hard" / "egg.nml",
        "-q",
        *("-o", tmp_path / "egg.h5"),
        *("--set", f"contact.normal = '{normal}'"),
        *("--set", "skin.semi_axes = 0.02, 0.012, 0.01"),
        *("--set", "contact.restitution = 1.0"),
        *("--set", "contact.friction_coefficient = 0.0"),
        *("--set", "body.spin = 3.0, 40.0, 20.0"),
        *("--set", "body.position = 0, 0, 0.0105"),
        *("--set", "scene.t_end = 0.05"),
    )
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "egg.h5") as file:
        group = file["trajectory"]
        total = sum(group[f"energy_{kind}"][:] for kind in ("kinetic", "potential", "elastic"))
        assert (group["gap"][:, 0] < 0).any()
    assert np.abs(total - total[0]).max() <= 1e-7 * total[0]
