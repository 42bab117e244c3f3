"""`contensou bearing`, and the picture of `contensou-plot --loads`."""

from __future__ import annotations

import math
import re
import subprocess
import sys

import h5py
import numpy as np
import pytest
from conftest import ROOT
from result import read

sys.path.insert(0, str(ROOT / "scripts"))
from lib import loads


def run_scene(executable, path, scene, *sets, t_end=1e-3):
    words = [word for text in (*sets, f"scene.t_end={t_end}") for word in ("--set", text)]
    subprocess.run([executable, "run", scene, "-q", "-o", path, *words], check=True, timeout=200)
    return path


@pytest.fixture(scope="module")
def result(executable, tmp_path_factory):
    """A short run with curved spots."""
    path = tmp_path_factory.mktemp("bearing") / "b.h5"
    scene = ROOT / "inputs" / "bearing_6205.nml"
    return run_scene(executable, path, scene, "bearing.spot=curved", "bearing.spot_error=1e-5")


def rows_of(text):
    """Lines of balls: number, arc and numbers, None for a dash."""
    lines = re.findall(r"^ +(\d+)( upper| lower|) +((?:[\d.-]+ +){7}[\d.-]+)$", text, re.MULTILINE)
    return [
        (int(ball), arc.strip(), [None if x == "-" else float(x) for x in values.split()])
        for ball, arc, values in lines
    ]


def moments_of(text):
    """Friction moments by cause [N mm]."""
    found = re.findall(r"^  (\S.*?) {2,}(-?[\d.]+)$", text, re.MULTILINE)
    return {cause: float(value) for cause, value in found}


def test_table(result, run):
    done = run("bearing", result, "--rating", 14800)
    assert done.status == 0, done.err
    rows = read(result).columns
    time = rows["time"]
    first = int(0.5 * len(time))

    def mean(values):
        return np.trapezoid(values[first:], time[first:], axis=0) / (time[-1] - time[first])

    printed = rows_of(done.out)
    assert [ball for ball, _, _ in printed] == list(range(1, 10))
    values = np.array([values for _, _, values in printed])
    carried = [mean(rows["normal_force"][:, at]) for at in (slice(0, 9), slice(9, 18))]
    assert values[:, 0] == pytest.approx(carried[0], abs=0.06)
    assert values[:, 1] == pytest.approx(carried[1], abs=0.06)
    normal = np.degrees(np.arcsin(rows["contact_normal"][first:, :9, 2])).mean(axis=0)
    assert values[:, 2] == pytest.approx(normal, abs=0.03)
    stress = mean(1.5 * rows["normal_force"] / (np.pi * rows["semi_axes"].prod(axis=-1))) * 1e-6
    assert values[:, 4] == pytest.approx(stress[:9], abs=0.6)
    # The causes are the torque of the drive, but for the energy of the motion that changes.
    parts = moments_of(done.out)
    whole = parts["whole"]
    causes = list(parts)[: list(parts).index("whole")]
    assert sum(parts[cause] for cause in causes) == pytest.approx(whole, abs=1e-3)
    drive = 1e3 * mean(rows["drive_torque"][:, 0, 2])
    assert whole == pytest.approx(drive, rel=0.1)
    assert parts["curvature, inner race"] > 0.5
    # Quasi-static estimates: those with all pivoting on one race stand between 5 and 6 N mm.
    assert 3.0 < parts["no pivoting"] < 3.1
    assert 5.0 < parts["all pivoting on the inner race"] < 6.0
    assert 5.0 < parts["all pivoting on the outer race"] < 6.0
    shared = parts["pivoting shared where least is lost"]
    assert parts["no pivoting"] < shared < parts["all pivoting on the inner race"]
    assert shared == pytest.approx(whole, rel=0.05)
    speed = [float(x) for x in re.findall(r"ring (-?[\d.]+)|axis ([\d.]+)", done.out)[0] if x]
    assert speed == pytest.approx([188.5])
    cage, epicyclic = map(float, re.search(r"axis ([\d.]+), epicyclic ([\d.]+)", done.out).groups())
    assert cage == pytest.approx(epicyclic, rel=5e-3)
    # The life by its formulas, the inner ring turning against the load.
    life = float(re.search(r"deg: (\S+) million", done.out)[1])
    pitch = 2 * np.linalg.norm(rows["position"][first:, 2:, :2], axis=-1).mean()
    gamma = 7.938e-3 / pitch
    q = 1.044 * ((1 - gamma) / (1 + gamma)) ** 1.72 * (0.52 / 0.53 * 0.06 / 0.04) ** 0.41
    rating = [14800 / 9 / c * (1 + q**e) ** 0.3 for c, e in ((0.407, 10 / 3), (0.389, -10 / 3))]
    load = [np.mean(x**e) ** (1 / e) for x, e in zip(carried, (3, 10 / 3), strict=True)]
    wanted = sum((p / c) ** (10 / 3) for p, c in zip(load, rating, strict=True)) ** -0.9
    assert life == pytest.approx(wanted, rel=2e-3)
    angled = run("bearing", result, "--rating", 14800, "--nominal-angle", 30)
    assert float(re.search(r"deg: (\S+) million", angled.out)[1]) > 1.2 * life


@pytest.mark.release_only("a figure that a run proves")
def test_a_drag_is_no_friction_of_the_bearing(executable, run, tmp_path):
    text = (ROOT / "inputs" / "bearing_6205.nml").read_text(encoding="utf-8")
    drag = "&spring name = 'drag', bodies = 'ground', 'bearing_inner', rotational_damping = 0.1 /\n"
    tables = []
    for name, more in (("with", drag), ("without", "")):
        (tmp_path / f"{name}.nml").write_text(text + more)
        path = run_scene(executable, tmp_path / f"{name}.h5", tmp_path / f"{name}.nml")
        done = run("bearing", path)
        assert done.status == 0, done.err
        tables.append(moments_of(done.out))
    # It loses 0.1 N m s a turn with the speed of the ring, which the damping of the contacts hides
    # in.
    assert "damping" not in tables[0]
    whole = tables[1].pop("whole") - tables[1].pop("damping")
    assert tables[0].pop("whole") == pytest.approx(whole, rel=1e-3, abs=1e-3)
    assert tables[0] == pytest.approx(tables[1], rel=1e-2, abs=1e-3)


def test_picture(result, tmp_path):
    picture = tmp_path / "loads.png"
    words = [sys.executable, ROOT / "scripts" / "plot.py", result, "--loads", "-o", picture]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert picture.stat().st_size > 10000
    other = tmp_path / "other.h5"
    with h5py.File(result) as whole, h5py.File(other, "w") as file:
        for name, value in whole.attrs.items():
            if name == "title":
                file.attrs[name] = value
        for name in ("body", "trajectory"):
            whole.copy(name, file)
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "plot.py", other, "--loads", "-o", picture],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "&bearing" in done.stderr


def test_picture_has_the_loads_where_the_balls_carry_them():
    # Nine balls go on by 100 degrees through a load that does not.
    time = np.cumsum(np.random.default_rng(1).uniform(0.5, 1.5, 400))
    angles = 2 * np.pi * np.arange(9) / 9 + np.radians(0.25) * time[:, None]
    places, means = loads.by_place(np.angle(np.exp(1j * angles)), 5 + np.cos(angles), time, 9)
    assert len(places) == 73
    assert means == pytest.approx(5 + np.cos(places), abs=2e-3)
    assert (places[-1], means[-1]) == (places[0], means[0])
    # Where they stand there are as many places as balls.
    still = np.repeat(angles[:1], 3, axis=0)
    places, means = loads.by_place(still, 5 + np.cos(still), time[:3], 9)
    assert len(places) == 10
    assert means == pytest.approx(5 + np.cos(places), abs=1e-12)


def test_a_pair_on_one_shaft_and_four_points(executable, run, tmp_path):
    pair = run_scene(
        executable, tmp_path / "p.h5", ROOT / "inputs" / "examples" / "bearing_pair.nml", t_end=2e-3
    )
    done = run("bearing", pair, "--rating", 14800)
    assert done.status == 0, done.err
    left, right = done.out.split("bearing right")
    assert "bearing left: 13 balls" in left
    for text, sign in ((left, 1), (right, -1)):
        rows = rows_of(text)
        assert len(rows) == 13
        assert all(sign * values[2] > 15 for _, _, values in rows if values[2] is not None)
        assert "nominal contact angle 25.0" in text
        # What is lost in the whole scene is not laid to one of its bearings.
        assert "damping" not in text
        assert moments_of(text)["whole"] > 0
    (tmp_path / "f.nml").write_text(FOUR.format(keys="axial_load = 2000"))
    four = run_scene(executable, tmp_path / "f.h5", tmp_path / "f.nml", t_end=4e-4)
    rows = rows_of(run("bearing", four).out)
    assert [(ball, arc) for ball, arc, _ in rows[:2]] == [(1, "upper"), (1, "lower")]
    for _, arc, values in rows:
        carries = values[0] if arc == "lower" else values[1]
        rests = values[1] if arc == "lower" else values[0]
        assert carries == pytest.approx(2000 / 12 / math.sin(math.radians(36.43)), rel=0.02)
        assert rests == 0


FOUR = """\
&scene t_end = 0.01 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&bearing name = 'b', ball_count = 12, ball_diameter = 10e-3, pitch_diameter = 60e-3,
   inner_groove_ratio = 0.52, outer_groove_ratio = 0.53, material = 'steel', ball_density = 7850,
   ring_mass = 1.0, ring_motion = 'rotor', ring_inertia = 1e-3, 2e-3, four_point = .true.,
   contact_angle = 0.61, inner_speed = 100, initial_state = 'rolling', {keys},
   friction = 'contensou_exact', friction_coefficient = 0.05, regularization_velocity = 1e-4,
   damping = 'hunt_crossley', damping_coefficient = 20 /
&integrator method = 'cvode_bdf', rtol = 1e-8 /
&output interval = 2e-5 /
"""


def test_a_pair_without_preload_begins(executable, tmp_path):
    """Balls that just touch are no stream of touches and lifts at the rounding of their places."""
    text = (
        (ROOT / "inputs" / "examples" / "bearing_pair.nml")
        .read_text()
        .replace("   preload = 200.0\n", "")
    )
    (tmp_path / "p.nml").write_text(text)
    path = run_scene(executable, tmp_path / "p.h5", tmp_path / "p.nml", t_end=1e-4)
    assert len(read(path).columns["time"]) == 2


def test_what_is_no_bearing(executable, result, run, tmp_path):
    assert run("bearing", tmp_path / "none.h5").status == 74
    for option, value in (("--part", 2), ("--part", 0), ("--nominal-angle", 90)):
        done = run("bearing", result, option, value)
        assert done.status == 2
        assert f"{option} needs" in done.err
    lost = tmp_path / "lost.h5"
    lost.write_bytes(result.read_bytes())
    with h5py.File(lost, "a") as file:
        file["trajectory/normal_force"][-1, 0] = np.nan
    done = run("bearing", lost)
    assert (done.status, done.out) == (74, "")
    assert "/trajectory/normal_force has values that are no numbers" in done.err
    other = run_scene(executable, tmp_path / "o.h5", ROOT / "inputs" / "sliding_ball.nml")
    done = run("bearing", other)
    assert done.status == 2
    assert "&bearing" in done.err
