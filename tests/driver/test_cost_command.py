"""`contensou cost`, the method `auto`, and `run --profile`."""

from __future__ import annotations

import csv
import itertools
import re
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest
from programs import captured

KINDS = ("position", "angle", "velocity", "angular_velocity")
MEASURES = ("end", "largest", "rms")
SMALL = ("--set", "cost.rtol=1e-5,1e-8", "--set", "cost.methods='explicit8','cvode_bdf'")


def text(value) -> str:
    """A text of HDF5."""
    return (value.decode() if isinstance(value, bytes) else str(value)).strip()


@pytest.fixture(scope="module")
def study(executable, scene_text, tmp_path_factory):
    """Folder of a small study: top.nml, cost.h5, cost.csv, and what was printed."""
    folder = tmp_path_factory.mktemp("cost")
    (folder / "top.nml").write_text(scene_text)
    command = [executable, "cost", "top.nml", "-o", "cost.h5", "--csv", "cost.csv", *SMALL]
    command += ["--set", "cost.repeats=1", "--set", "cost.samples=20", "--error", "1"]
    done = captured(command, cwd=folder)
    assert done.returncode == 0, done.stderr
    (folder / "out.txt").write_text(done.stdout)
    return folder


def test_csv_is_hdf5(study):
    """Both files hold the same numbers."""
    rows = list(csv.DictReader((study / "cost.csv").open()))
    with h5py.File(study / "cost.h5") as file:
        assert text(file.attrs["filetype"]) == "contensou-cost"
        runs = file["run"]
        assert len(rows) == len(runs["label"]) == 4 * 2 * 2
        for name in runs:
            if name == "label":
                continue
            for row, value in zip(rows, runs[name][()], strict=True):
                if runs[name].dtype.kind == "f":
                    assert runs[name].attrs["units"] is not None
                    cell = float(row[name]) if row[name] else np.nan
                    assert cell == value or (np.isnan(cell) and np.isnan(value))
                else:
                    key = {"status": "status"}.get(name, name)
                    assert row[key] == text(value)
    assert not list(study.glob("*.part"))


def test_table_width(study):
    """What is printed fits into 100 columns."""
    lines = (study / "out.txt").read_text().splitlines()
    assert max(map(len, lines)) <= 100


def test_errors_are_those_of_runs(study, run, tmp_path):
    """Errors recomputed from trajectories that `run` writes."""

    def trajectory(friction, method, rtol):
        name = f"{friction}_{method}_{rtol}.h5"
        result = run(
            "run", study / "top.nml", "-q", "--force", "-o", name,
            "--set", f"contact.friction='{friction}'", "--set", f"integrator.method='{method}'",
            "--set", f"integrator.rtol={rtol}",
        )  # fmt: skip
        assert result.status == 0, result.err
        return name

    def read(name):
        with h5py.File(tmp_path / name) as file:
            return {k: file["trajectory"][k][:, 0] for k in ("position", "quaternion", "velocity")}

    with h5py.File(study / "cost.h5") as file:
        runs = {name: data[()] for name, data in file["run"].items()}
        scale = dict(zip(map(text, file["quantity/name"]), file["quantity/scale"][()], strict=True))
        model_error = dict(zip(map(text, file["model/name"]), file["model/error"], strict=True))
    for model in ("contensou_exact", "contensou_simplified"):
        exact = trajectory("contensou_exact", "explicit8", 1e-12)
        own = trajectory(model, "explicit8", 1e-12)
        other = trajectory(model, "cvode_bdf", 1e-5)
        a, b, c = read(other), read(exact), read(own)
        row = next(
            i
            for i in range(len(runs["cpu"]))
            if text(runs["model"][i]) == model
            and text(runs["method"][i]) == "cvode_bdf"
            and runs["rtol"][i] == 1e-5
        )
        for prefix, reference in (("error", b), ("numerical", c)):
            for kind in ("position", "velocity"):
                distance = np.linalg.norm(a[kind] - reference[kind], axis=1)
                expected = {
                    "end": distance[-1],
                    "largest": distance.max(),
                    "rms": np.sqrt((distance[1:] ** 2).mean()),
                }
                for measure, value in expected.items():
                    found = runs[f"{prefix}_{kind}_{measure}"][row]
                    assert found == pytest.approx(value, rel=1e-3, abs=1e-12)
            angle = 2 * np.arccos(
                np.minimum(1, np.abs(np.sum(a["quaternion"] * reference["quaternion"], axis=1)))
            )
            found = runs[f"{prefix}_angle_largest"][row]
            assert found == pytest.approx(angle.max(), rel=1e-2, abs=1e-7)
        distance = np.linalg.norm(c["position"] - b["position"], axis=1).max()
        assert distance / scale["position"] <= model_error[model] * (1 + 1e-6) + 1e-12
    assert scale["velocity"] == pytest.approx(np.linalg.norm(b["velocity"], axis=1).max(), rel=1e-5)


def test_errors_of_event_times_are_those_of_runs(run, inputs, tmp_path):
    """A ball that bounces: each event against the same of the reference."""
    scene = inputs / "bouncing_ball.nml"
    short = ("--set", "skin_floor.restitution=0.5", "--set", "cost.repeats=1")
    done = run("cost", scene, "-o", "c.h5", "--csv", "c.csv", "-q", *short, *SMALL)
    assert done.status == 0, done.err

    def times(method, rtol):
        result = run(
            "run", scene, "-q", "--force", "-o", "r.h5", *short[:2],
            "--set", f"integrator.method='{method}'", "--set", f"integrator.rtol={rtol}",
        )  # fmt: skip
        assert result.status == 0, result.err
        with h5py.File(tmp_path / "r.h5") as file:
            return file["events/time"][()]

    exact = times("explicit8", 1e-12)
    rows = list(csv.DictReader((tmp_path / "c.csv").open()))
    assert len(rows) == 4
    for row in rows:
        own = times(row["method"], row["rtol"])
        assert len(own) == float(row["events"]) > 15
        expected = np.abs(own - exact).max()
        assert float(row["error_events"]) == pytest.approx(expected, rel=1e-2, abs=1e-12)
        assert expected < 1e-4


def test_bodies_that_a_drive_turns_and_springs_count(run, inputs, tmp_path):
    """Spindles on springs: distances and the balance are those of the rows of the runs."""
    scene = inputs / "examples/cattaneo.nml"

    def rows(name, *words):
        words = ("run", scene, "-q", "-o", name, *words, "--set", "integrator.method='explicit8'")
        assert run(*words, "--set", "scene.t_end=0.02").status == 0
        with h5py.File(tmp_path / name) as file:
            return {key: data[()] for key, data in file["trajectory"].items()}

    done = run(
        "cost", scene, "--csv", "c.csv", "-q", "--set", "scene.t_end=0.02", "--set",
        "cost.layers=12", "--set", "cost.methods='explicit8','auto'", "--set", "cost.rtol=1e-5",
        "--set", "cost.repeats=1", "--set", "cost.samples=200",
    )  # fmt: skip
    assert done.status == 0, done.err
    table = list(csv.DictReader((tmp_path / "c.csv").open()))
    found = next(row for row in table if row["method"] == "explicit8")
    own = rows("own.h5", "--set", "integrator.rtol=1e-5")
    reference = rows("reference.h5", "--set", "integrator.rtol=1e-12")
    for kind in ("position", "velocity"):
        error = np.linalg.norm(own[kind] - reference[kind], axis=2).max()
        assert error > 1e-12
        assert float(found[f"numerical_{kind}_largest"]) == pytest.approx(error, rel=1e-2)
    balance = np.abs(own["energy_error"]).max()
    assert float(found["energy_residual"]) == pytest.approx(balance, rel=1e-3)
    # What the spot rings with is known though both bodies turn with drives.
    done = run("run", scene, "-o", "auto.h5", "--set", "integrator.method='auto'")
    assert done.status == 0, done.err
    figures = r"frequency (\S+) rad/s, damping ratio (\S+), tangential frequency (\S+) rad/s"
    chosen = re.search(figures, done.out)
    assert 1e3 < float(chosen[1]) < 1e4
    assert 0.01 < float(chosen[2]) < 1
    assert 1e3 < float(chosen[3]) < 1e4


def test_scaled_error_and_pareto_front(study):
    """The one error of a run, the front and the cheapest choice, recomputed."""
    with h5py.File(study / "cost.h5") as file:
        runs = {name: data[()] for name, data in file["run"].items()}
        names = list(map(text, file["quantity/name"]))
        scale = dict(zip(names, file["quantity/scale"][()], strict=True))
        counts = dict(zip(names, file["quantity/counts"][()], strict=True))
        agreement = file["model/agreement"][0]
    kinds = [kind for kind in KINDS if counts[kind]]
    assert kinds == ["position", "angle", "velocity"]
    for prefix, column in (("error", "error"), ("numerical", "error_numerical")):
        expected = np.max([runs[f"{prefix}_{k}_largest"] / scale[k] for k in kinds], axis=0)
        np.testing.assert_allclose(runs[column], expected, rtol=1e-14)
    bound = np.maximum(runs["error"], agreement)
    np.testing.assert_array_equal(bound, runs["error_bound"])
    cpu = runs["cpu"]
    front = [
        not any(
            cpu[j] <= cpu[i]
            and bound[j] <= bound[i]
            and (cpu[j] < cpu[i] or bound[j] < bound[i] or j < i)
            for j in range(len(cpu))
            if j != i
        )
        for i in range(len(cpu))
    ]
    assert front == list(runs["pareto"] > 0)
    best = np.argmin(np.where(bound <= 1, cpu, np.inf))
    said = (study / "out.txt").read_text().splitlines()[-2]
    assert said.startswith("cheapest for an error of 1.0: ")
    assert f"{text(runs['model'][best])}, {text(runs['method'][best])} at rtol" in said


def test_true_errors(executable, reference, inputs, tmp_path, build_kind):
    """What is called an error of 1e-7 is one against trajectories from elsewhere, too."""
    if build_kind != "release":
        pytest.skip("a run of 0.5 s of simulated time for the release build")
    end = 0.5
    command = [executable, "cost", inputs / "tippe_top.nml", "-q", "-o", "c.h5"]
    for setting in (
        f"scene.t_end={end}",
        "cost.friction='contensou_exact'",
        "cost.methods='explicit8'",
        "cost.rtol=1e-6,1e-9",
        "cost.repeats=1",
    ):
        command += ["--set", setting]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    with h5py.File(tmp_path / "c.h5") as file:
        claimed = file["run/error_position_largest"][()]
    table = np.genfromtxt(reference / "tippe_top_exact.csv", delimiter=",", names=True)
    table = table[table["t"] <= end]
    for rtol, claim in zip((1e-6, 1e-9), claimed, strict=True):
        command = [executable, "run", inputs / "tippe_top.nml", "-q", "-o", "r.h5", "--force"]
        for setting in (
            f"scene.t_end={end}",
            "output.interval=0.01",
            "integrator.method='explicit8'",
            f"integrator.rtol={rtol}",
        ):
            command += ["--set", setting]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
        with h5py.File(tmp_path / "r.h5") as file:
            z = file["trajectory/position"][:, 0, 2]
        # The table has 12 digits of z.
        assert np.abs(z - table["z"]).max() <= claim + 1e-12


def test_a_body_that_stays_in_its_place(run, inputs, tmp_path):
    """A ball that spins in its place moves by rounding errors, with which nothing is compared."""
    scales = {"length_scale": 2e-6, "velocity_scale": 3e-3, "angular_velocity_scale": 2.0}
    words = ["cost", inputs / "spinning_ball.nml", "-o", "cost.h5", "-q", "--error", "1e-4"]
    for key, value in scales.items():
        words += ["--set", f"integrator.{key}={value}"]
    words += ["--set", "cost.rtol=1e-4,1e-8", "--set", "cost.methods='explicit8','cvode_bdf'"]
    words += ["--set", "cost.friction='contensou_exact'", "--set", "scene.t_end=0.05"]
    result = run(*words)
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "cost.h5") as file:
        names = map(text, file["quantity/name"])
        scale = dict(zip(names, file["quantity/scale"][()], strict=True))
        error, rtol = file["run/error"][()], file["run/rtol"][()]
    assert scale["position"] == scales["length_scale"]
    assert scale["velocity"] == scales["velocity_scale"]
    assert scale["angular_velocity"] > scales["angular_velocity_scale"]
    assert np.nanmax(error[rtol < 1e-6]) < 1e-4
    assert np.nanmax(error) < 0.1


def test_the_check_of_a_body_that_comes_to_rest(run, inputs, tmp_path):
    """A second method checks the motion up to the rest, which is for cvode_bdf alone."""
    result = run(
        "cost", inputs / "spinning_ball.nml", "-o", "cost.h5", "--set", "cost.rtol=1e-6",
        "--set", "cost.friction='contensou_exact'", "--set", "cost.methods='auto'",
    )  # fmt: skip
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "cost.h5") as file:
        model = {name: data[0] for name, data in file["model"].items()}
    assert text(model["reference_method"]) == "cvode_bdf"
    assert text(model["check_method"]) == "auto"
    assert model["check_rtol"] == model["reference_rtol"] == 1e-12
    # I w/(f N a 3 pi/16) until it rests, of 1.8 s: the torque of pure drilling is constant.
    rest = 8.0e-6 * 20.0 / (0.3 * 0.05 * 9.81 * 1.3289e-3 * 3 * np.pi / 16)
    assert model["check_explicit_share"] == pytest.approx(rest / 1.8, abs=0.005)
    assert model["agreement"] < 1e-8
    assert "cvode_bdf at 1.0e-12; auto, explicit8 for 77 % of the time, agrees to" in result.out


def test_unreachable_error(run, scene):
    """An error that no run reaches is said to be out of reach."""
    result = run(
        "cost", scene, "--error", "1e-30", "--set", "cost.methods='explicit8'",
        "--set", "cost.friction='contensou_exact'", "--set", "cost.repeats=1",
    )  # fmt: skip
    assert result.status == 1
    assert "no run has an error of 1.0e-30 or less" in result.err
    assert "unresolved" in result.err
    assert "references" in result.out


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("cost.rtol=1e-4,1", "'rtol' is out of range"),
        ("cost.methods='auto','auto'", "stands twice"),
        ("cost.methods='rk4'", "unknown methods"),
        ("cost.samples=1.5", "must be whole"),
        ("cost.reference_rtol=1e-9", "not tighter"),
        ("cost.quantities='size'", "unknown quantities"),
        ("cost.toll=1", "unknown key 'toll'"),
        ("cost.friction='coulomb'", "regularization_velocity"),
    ],
)
def test_broken_groups(run, scene, setting, message):
    """Mistakes in &cost are named, by `check` as well where the scene is not needed."""
    result = run("cost", scene, "--set", setting)
    assert result.status == 2
    assert message in result.err
    if "coulomb" not in setting:
        assert run("check", scene, "--set", setting).status == 2


def test_group_changes_no_run(run, scene, tmp_path, scene_text):
    """A run does not look at &cost."""
    (tmp_path / "with.nml").write_text(scene_text + "&cost rtol = 1e-3, 1e-5 /\n")
    for name in ("top", "with"):
        assert run("run", f"{name}.nml", "-q", "-o", f"{name}.h5").status == 0
    with h5py.File(tmp_path / "top.h5") as a, h5py.File(tmp_path / "with.h5") as b:
        np.testing.assert_array_equal(a["trajectory/position"][()], b["trajectory/position"][()])
        assert b"&cost" in b["input/resolved"][()]
        assert b"&cost" not in a["input/resolved"][()]


def test_existing_files_stay(run, scene, tmp_path):
    """Nothing is overwritten unless --force says so."""
    for option in ("-o", "--csv"):
        (tmp_path / "old").write_text("mine")
        result = run("cost", scene, option, "old")
        assert result.status == 74
        assert (tmp_path / "old").read_text() == "mine"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interruption(executable, inputs, tmp_path, number):
    """A signal ends the study with status 75 and without a file."""
    command = [executable, "cost", inputs / "tippe_top.nml", "-o", "c.h5", "--csv", "c.csv"]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    time.sleep(0.5)
    process.send_signal(number)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 75
    assert "interrupted" in said
    assert not list(tmp_path.iterdir())


def test_failing_runs_are_rows(run, scene, tmp_path):
    """A combination that fails or takes too long is a row with its message."""
    result = run(
        "cost", scene, "-q", "--csv", "c.csv", "--set", "contact.damping_coefficient=1e7",
        "--set", "cost.friction='contensou_exact'", "--set", "cost.repeats=1",
        "--set", "cost.rtol=1e-6", "--set", "cost.reference_rtol=1e-8",
        "--set", "cost.cpu_limit=1e-3", "--set", "scene.t_end=0.002",
    )  # fmt: skip
    assert result.status == 0, result.err
    rows = list(csv.DictReader((tmp_path / "c.csv").open()))
    assert len(rows) == 4
    for row in rows:
        assert row["status"] in ("done", "failed", "too_slow")
        assert (row["status"] == "done") == (row["message"] == "")
        assert (row["status"] == "done") == (row["error"] != "")


def scenes(folder):
    """All shipped scenes."""
    return sorted(folder.glob("*.nml"))


@pytest.mark.parametrize("scene", ["tippe_top", "bouncing_ball", "spinning_ball"])
def test_auto_adds_no_work(run, inputs, tmp_path, scene):
    """Where `auto` stays with one method, it takes the right-hand sides of that method."""
    words = ("run", inputs / f"{scene}.nml", "-q", "--force", "--set", "output.interval=0.1",
             "--set", "scene.t_end=1", "-o")  # fmt: skip
    assert run(*words, "auto.h5", "--set", "integrator.method='auto'").status == 0
    with h5py.File(tmp_path / "auto.h5") as file:
        methods = list(map(text, file["integrator/method"]))
        work = int(file["integrator/right_hand_sides"][()])
    assert len(methods) == 1
    assert run(*words, "own.h5", "--set", f"integrator.method='{methods[0]}'").status == 0
    with h5py.File(tmp_path / "own.h5") as file:
        own = int(file["integrator/right_hand_sides"][()])
    assert own <= work <= own + 50


def test_auto_changes_with_stiffness(run, scene, tmp_path):
    """With strong damping `auto` goes over to the implicit method, and the file says so."""
    options = ("--set", "integrator.method='auto'", "-o", "a.h5", "--force")
    light = run("run", scene, *options, "--set", "contact.damping_coefficient=0.2")
    assert "auto       explicit8, because contact ball_floor decays no faster" in light.out
    with h5py.File(tmp_path / "a.h5") as file:
        assert list(map(text, file["integrator/method"])) == ["explicit8"]
        assert list(file["integrator/method_since"]) == [0.0]
        assert "explicit8" in text(file["integrator/choice"][()])
    strong = run("run", scene, *options, "--set", "contact.damping_coefficient=1e5")
    assert "auto       cvode_bdf, because" in strong.out
    middle = run(
        "run", scene, *options, "--set", "contact.damping_coefficient=1e3", "--set",
        "scene.t_end=3",
    )  # fmt: skip
    assert "cvode_bdf since t = " in middle.out
    with h5py.File(tmp_path / "a.h5") as file:
        methods = list(map(text, file["integrator/method"]))
        since = file["integrator/method_since"][()]
    assert methods[:2] == ["explicit8", "cvode_bdf"]
    assert all(a != b for a, b in itertools.pairwise(methods))
    assert (np.diff(since) > 0).all()
    assert "auto             explicit8" in run("check", scene, *options[:2]).out


# What a shipped scene with a tangential model begins with, and a figure that says why.
CHOICES = {
    "cattaneo": "tangential frequency 4.0E+03 rad/s; 36",
    "dish": "tangential frequency 9.5E+02 rad/s; 22",
    "incline": "tangential frequency 1.0E+04 rad/s; 36",
    "oblique_impact": "friction 1.1E+02 1/s; 21",
    "bearing_6205_rolling": "friction 5.6E+05 1/s; 146",
    "bowling_hook": "friction 5.7E-01 1/s; 15",
    "euler_disc": "friction 8.7E+01 1/s; 15",
    "rolling_bend": "friction 2.6E+02 1/s; 15",
    "wheelset": "friction 7.7E+02 1/s; 29",
}


def test_all_scenes_with_a_tangential_model_have_a_choice(inputs):
    found = [
        path.stem for path in scenes(inputs / "examples") if "tangential = " in path.read_text()
    ]
    assert found == sorted(CHOICES)


@pytest.mark.parametrize("scene", CHOICES)
def test_auto_begins_with_what_rings(run, inputs, scene):
    """What sticks by tangential elasticity rings, and does not decay as regularised friction."""
    path = inputs / "examples" / f"{scene}.nml"
    told = run("check", path, "--set", "integrator.method='auto'").out
    assert re.search(r"auto +explicit8, because contact \w+ decays no faster than it rings", told)
    assert CHOICES[scene] in told


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("scene", "methods"),
    [
        ("oblique_impact", ["explicit8"]),
        ("cattaneo", ["explicit8"]),
        ("incline", ["explicit8", "cvode_bdf"]),
        ("dish", ["explicit8", "cvode_bdf"]),
    ],
)
def test_auto_is_as_quick_with_memory_as_the_better_method(
    run, inputs, tmp_path, slow_build, scene, methods
):
    """It follows what rings with explicit8, and what rests with cvode_bdf."""
    if slow_build and scene == "dish":
        pytest.skip("a hundred thousand steps")
    steps = {}
    for method in ("explicit8", "cvode_bdf", "auto"):
        done = run("run", inputs / "examples" / f"{scene}.nml", "-q", "-o", f"{method}.h5",
                   "--set", f"integrator.method='{method}'", timeout=600)  # fmt: skip
        assert done.status == 0, done.err
        with h5py.File(tmp_path / f"{method}.h5") as file:
            steps[method] = int(file["integrator/steps"][()])
            used = list(map(text, file["integrator/method"]))
    assert used[:2] == methods
    assert steps["auto"] <= min(steps["explicit8"], steps["cvode_bdf"])


def test_auto_begins_with_cvode_bdf_where_rolling_carries_strain_away(run, tmp_path):
    """A ball of steel at 10 m/s takes ten times as many steps of explicit8."""
    (tmp_path / "fast.nml").write_text(FAST)
    told = run("check", "fast.nml").out
    assert "cvode_bdf, because contact spot decays far faster than anything turns or rings" in told
    assert "creep 1.5E+06 1/s" in told
    slow = run(
        "check", "fast.nml", "--set", "ball.velocity=1,0,0", "--set", "ball.spin=0,100,0"
    ).out
    assert "explicit8, because contact spot decays not much faster than it rings" in slow
    still = run("check", "fast.nml", "--set", "ball.velocity=0,0,0", "--set", "ball.spin=0,0,0")
    assert "explicit8, because contact spot decays no faster than it rings" in still.out
    slides = run("check", "fast.nml", "--set", "ball.spin=0,0,0").out
    assert "explicit8" in slides
    assert "tangential frequency" not in slides


FAST = """
&scene gravity = 0.5, 0, -9.81, t_end = 0.2 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', density = 7800, position = 0, 0, 0.01, place = 'touch',
   velocity = 10, 0, 0, spin = 0, 1000, 0 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.01, material = 'steel' /
&surface name = 'table', body = 'ground', shape = 'plane', material = 'steel' /
&contact name = 'spot', surfaces = 'table', 'skin', damping = 'hunt_crossley',
   damping_coefficient = 100, friction = 'contensou_exact', friction_coefficient = 0.3,
   tangential = 'elastic', creep = 'table' /
&integrator method = 'auto', rtol = 1e-7 /
"""


def test_profile(run, scene, tmp_path):
    """Shares add up to 1, effects that a scene lacks take no time, and nothing moves by it."""
    settings = ("--set", "scene.t_end=0.5")
    result = run("run", scene, "--profile", *settings)
    assert result.status == 0
    assert "CPU time   by effect" in result.out
    assert run("run", scene, "-q", "-o", "plain.h5", *settings).status == 0
    with h5py.File(tmp_path / "top.h5") as file, h5py.File(tmp_path / "plain.h5") as plain:
        names = list(map(text, file["integrator/effect"]))
        seconds = dict(zip(names, file["integrator/cpu_by_effect"][()], strict=True))
        share = file["integrator/cpu_share"][()]
        assert "effect" not in plain["integrator"]
        for name in ("position", "quaternion"):
            np.testing.assert_array_equal(
                file["trajectory"][name][()], plain["trajectory"][name][()]
            )
    assert share.sum() == pytest.approx(1, abs=1e-12)
    assert seconds["rolling"] == 0
    for name in ("geometry", "normal_force", "ellipse", "friction", "damping", "bodies"):
        assert seconds[name] > 0, name
    result = run("run", scene, "-q", "--profile", "-o", "f.h5", "--set", "contact.friction='none'",
                 *settings)  # fmt: skip
    with h5py.File(tmp_path / "f.h5") as file:
        seconds = dict(zip(names, file["integrator/cpu_by_effect"][()], strict=True))
    assert seconds["friction"] == seconds["ellipse"] == 0


def test_profile_of_a_spot_that_changes(run, inputs, tmp_path):
    """An ellipsoid that sticks, with rolling resistance and without damping."""
    result = run(
        "run", inputs / "ellipsoid_egg.nml", "-q", "--profile", "-o", "egg.h5",
        *itertools.chain.from_iterable(("--set", word) for word in (
            "scene.t_end=0.2", "contact.damping='none'", "contact.rolling='constant'",
            "contact.rolling_coefficient=1e-5", "contact.rolling_regularization=1.0",
            "contact.tangential=elastic")),
    )  # fmt: skip
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "egg.h5") as file:
        names = list(map(text, file["integrator/effect"]))
        seconds = dict(zip(names, file["integrator/cpu_by_effect"][()], strict=True))
    for name in ("geometry", "normal_force", "ellipse", "friction", "rolling", "bodies"):
        assert seconds[name] > 0, name
    assert seconds["damping"] == 0
    # The first right-hand side takes dozens of times as long, and stood for 4,096: nothing was left
    # for CVODE, whose time is nearly all.
    assert seconds["integrator"] > 0.2 * sum(seconds.values())


def test_layers_of_contacts_that_remember(run, tmp_path):
    """The ladder of tangential elasticity: a row for each number of layers, the spring first."""
    scene = tmp_path / "ball.nml"
    scene.write_text(
        """
&scene title = 'oblique impact' t_end = 1e-4 /
&material name = 'steel' young = 2.1e11 poisson = 0.3 /
&body name = 'ball' mass = 5.105088e-4 inertia = 3*1.276272e-9
   position = 0, 0, 0.0025 velocity = 0.01, 0, -0.02 /
&surface name = 'skin' body = 'ball' material = 'steel' shape = 'sphere' radius = 0.0025 /
&surface name = 'floor' body = 'ground' material = 'steel' shape = 'plane' normal = 0, 0, 1 /
&contact name = 'c' surfaces = 'floor', 'skin' friction = 'contensou_exact'
   friction_coefficient = 0.3 tangential = 'elastic' /
&cost methods = 'explicit8' rtol = 1e-6 reference_rtol = 1e-8 samples = 20 repeats = 1
   quantities = 'velocity', 'angular_velocity' /
"""
    )
    done = run("cost", scene, "--csv", "cost.csv", timeout=300)
    assert done.status == 0, done.err
    rows = {row["model"]: row for row in csv.DictReader((tmp_path / "cost.csv").open())}
    assert list(rows) == [f"contensou_exact+{name}" for name in LADDER]
    errors = [float(row["error_velocity_end"]) for row in rows.values()]
    assert errors[0] > 10 * errors[2]
    assert errors[1] > errors[3]
    few = run("cost", scene, "--csv", "few.csv", "--set", "cost.layers=1,128", timeout=300)
    assert few.status == 0, few.err
    models = [row["model"] for row in csv.DictReader((tmp_path / "few.csv").open())]
    assert sorted(models) == ["contensou_exact+elastic_1", "contensou_exact+elastic_128"]


LADDER = ("spring", "elastic_6", "elastic_12", "elastic_24")


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("cost.layers=10", "cost.layers: no contact of the scene has tangential elasticity"),
        ("cost.layers=5,5", "5 stands twice in 'layers'"),
        ("cost.layers=129", "layers"),
        ("cost.layers=-1", "layers"),
    ],
)
def test_layers_that_are_none(run, scene, setting, message):
    done = run("cost", scene, "--set", setting)
    assert done.status != 0
    assert message in done.err
