"""The tables of sweeps, looked at: scripts/plot, and the ways of reading that the page names."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import h5py
import matplotlib as mpl
import numpy as np
import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

mpl.use("Agg")

from lib import sweeps  # noqa: E402
from lib.results import ResultError  # noqa: E402

PAGE = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")

# A ball that falls and bounces: some milliseconds for each run.
SCENE = """\
&scene title = 'a falling ball', gravity = 0, 0, -9.81, t_end = 0.2 /
&material name = 'rubber', young = 1.0e8, poisson = 0.3 /
&body name = 'ball', mass = 0.0327, inertia = 3*1.31e-6, position = 0, 0, 0.02, spin = 0, 50.0, 0 /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 0.01, material = 'rubber' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'rubber' /
&contact name = 'ball_floor', surfaces = 'ball', 'floor', damping = 'hunt_crossley',
         restitution = 0.6, friction = 'contensou_exact', friction_coefficient = 0.2,
         regularization_velocity = 0.1 /
&integrator method = 'explicit8', rtol = 1e-6 /
&output file = 'ball.h5', interval = 0.01 /
"""

HEIGHT = (
    "&parameter name = 'ball.position(3)', column = 'height',"
    " first = {0}, last = {1}, count = {2} /\n"
)
COEFFICIENT = (
    "&parameter name = 'ball_floor.friction_coefficient', column = 'friction_coefficient',"
    " vary = 'log', first = {0}, last = {1}, count = {2} /\n"
)
MODEL = (
    "&parameter name = 'ball_floor.friction', column = 'model',"
    " values = 'contensou_exact', 'pade22' /\n"
)
ONE = "keep = 'first_touch'"


@pytest.fixture
def table(run, tmp_path):
    """Run a sweep of these parameters, and return its table."""

    def make(*parameters: str, more: str = ONE) -> Path:
        (tmp_path / "ball.nml").write_text(SCENE)
        head = f"&sweep scene = 'ball.nml', output = 'sweep.h5', {more} /\n"
        (tmp_path / "sweep.nml").write_text(head + "".join(parameters))
        done = run("sweep", "sweep.nml", "-j", 2, "--force", "-q")
        assert done.status == 0, done.err
        return tmp_path / "sweep.h5"

    return make


def draw(path: Path, **wishes: object) -> tuple[list, str]:
    """The panels of a picture, without those of the colours, and all its texts."""
    figure = sweeps.draw(path, sweeps.Wishes(**wishes))
    texts = [text.get_text() for text in figure.findobj(mpl.text.Text)]
    return figure.axes, "\n".join(texts)


def test_one_parameter_is_a_line(table):
    path = table(HEIGHT.format(0.02, 0.05, 7))
    (axes,), texts = draw(path)
    (line,) = axes.get_lines()
    with h5py.File(path) as file:
        assert np.array_equal(line.get_xdata(), file["parameters/height"][()])
        assert np.array_equal(line.get_ydata(), file["results/first_touch_ball_floor"][()])
    # The fall takes sqrt(2 h/g).
    expected = np.sqrt(2 * (line.get_xdata() - 0.01) / 9.81)
    assert np.allclose(line.get_ydata(), expected, rtol=1e-6)
    assert "a falling ball" in texts
    assert "7 cases" in texts
    assert axes.get_xlabel() == "height [m]"
    assert axes.get_ylabel() == "first touch ball floor [s]"


def test_few_values_of_a_second_parameter_are_lines(table):
    path = table(MODEL, HEIGHT.format(0.02, 0.05, 5))
    (axes,), _ = draw(path)
    assert [line.get_label() for line in axes.get_lines()] == ["contensou_exact", "pade22"]
    assert axes.get_xlabel() == "height [m]"


def test_a_grid_is_a_map(table):
    path = table(HEIGHT.format(0.02, 0.05, 7), COEFFICIENT.format(0.01, 1.0, 9))
    axes, texts = draw(path)
    (mesh,) = axes[0].collections
    values = np.ma.filled(mesh.get_array(), np.nan)
    with h5py.File(path) as file:
        column = file["results/first_touch_ball_floor"][()]
    # The first parameter is across, the second, whose values are even in the logarithm, up.
    assert np.array_equal(values, column.reshape(7, 9).T)
    assert (axes[0].get_xlabel(), axes[0].get_ylabel()) == ("height [m]", "friction coefficient")
    assert (axes[0].get_xscale(), axes[0].get_yscale()) == ("linear", "log")
    assert "first touch ball floor [s]" in texts


def test_points_at_random_are_points(table):
    more = "sampling = 'latin_hypercube', cases = 40, seed = 3, " + ONE
    parameters = [
        HEIGHT.replace(", count = {2}", "").format(0.02, 0.05),
        COEFFICIENT.replace(", count = {2}", "").format(0.01, 1.0),
    ]
    path = table(*parameters, more=more)
    axes, _ = draw(path)
    assert sum(len(points.get_offsets()) for points in axes[0].collections) == 40
    assert axes[0].get_yscale() == "log"
    # Over one of them, too.
    axes, _ = draw(path, over=["height"])
    assert axes[0].get_ylabel() == "first touch ball floor [s]"
    assert sum(len(points.get_offsets()) for points in axes[0].collections) == 40


def test_what_failed_and_what_has_no_value_is_marked(table):
    # A ball below the floor is no scene; from too high it does not come down in time.
    for kind in ("map", "scatter", "lines"):
        path = table(HEIGHT.format(-0.02, 0.38, 5), COEFFICIENT.format(0.1, 1.0, 6))
        with h5py.File(path) as file:
            status = file["status"][()]
            touch = file["results/first_touch_ball_floor"][()]
        failed, never = np.count_nonzero(status), np.count_nonzero((status == 0) & np.isnan(touch))
        assert failed >= 6
        assert never >= 6
        _, texts = draw(path, kind=kind)
        assert f"no touch: {never} cases" in texts
        shown = [int(n) for n in re.findall(r"^(?:failed|invalid scene): (\d+) case", texts, re.M)]
        assert sum(shown) == failed
        assert "30 cases" in texts


def test_what_is_asked_for_is_drawn(table):
    path = table(
        HEIGHT.format(0.02, 0.05, 4),
        COEFFICIENT.format(0.1, 1.0, 8),
        MODEL,
        more="keep = 'summary', 'events'",
    )
    axes, texts = draw(
        path,
        results=["work_friction", "touches_ball_floor"],
        over=["friction_coefficient", "height"],
        where={"model": "PADE22"},
    )
    assert len([a for a in axes if a.get_xlabel() == "friction coefficient"]) == 2
    assert "model pade22" in texts
    assert "32 cases" in texts
    for wishes, words in (
        ({"results": ["work"]}, "there is no result 'work'; possible are .*work_friction"),
        ({"over": ["heigth"]}, "there is no parameter 'heigth'; possible are .*height"),
        ({"over": ["height"], "kind": "map"}, "a map needs two parameters"),
        ({"where": {"model": "coulomb"}}, "model is never 'coulomb'; possible are contensou_exact"),
        ({"where": {"height": "low"}}, "height is a number, and 'low' is none"),
    ):
        with pytest.raises(ResultError, match=words):
            draw(path, **wishes)


def plot(*arguments: object, cwd: Path) -> subprocess.CompletedProcess:
    """Run the script itself."""
    return captured(
        [sys.executable, str(ROOT / "scripts" / "plot.py"), *map(str, arguments)],
        cwd=cwd,
        timeout=300,
    )


def test_the_script_draws_and_tells_what_is_wrong(table, tmp_path, scene, run):
    path = table(HEIGHT.format(0.02, 0.05, 7))
    done = plot(path.name, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "sweep.png\n"), done.stderr
    assert (tmp_path / "sweep.png").stat().st_size > 10_000
    done = plot(path.name, "--over", "tilt", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr == "error: there is no parameter 'tilt'; possible are height\n"
    assert plot(path.name, "--where", "tilt", cwd=tmp_path).returncode == 2
    # These options are for tables of sweeps.
    assert run("run", scene, "-q").status == 0
    done = plot("top.h5", "--over", "tilt", cwd=tmp_path)
    assert done.returncode == 2
    assert "no table of a sweep" in done.stderr


@pytest.mark.parametrize("library", ["xarray", "pandas"])
def test_the_page_reads_a_table(table, tmp_path, library):
    text = next(
        body
        for body in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
        if re.search(rf"import.*{library}", body)
    )
    # Three lines, but for the imports.
    assert len([line for line in text.splitlines() if line and "import" not in line]) <= 3
    table(
        COEFFICIENT.format(0.1, 1.0, 3),
        HEIGHT.replace("'height'", "'tilt'").format(0.02, 0.05, 4),
    )
    text = text.replace("stem_floor", "ball_floor")
    text += "print(t, t.first_touch_ball_floor.min())\n"
    # Cases have their numbers, from 1, in both.
    flat = text.replace('.set_index(case=["friction_coefficient", "tilt"]).unstack("case")', "")
    flat = flat.replace("t.first_touch_ball_floor.plot()", "")
    numbers = "t.case.values" if library == "xarray" else "t.index.values"
    done = captured([sys.executable, "-c", f"{flat}print(*{numbers})"], cwd=tmp_path, timeout=300)
    assert [int(word) for word in done.stdout.splitlines()[-1].split()] == list(range(1, 13))
    done = captured(
        [sys.executable, "-c", text],
        cwd=tmp_path,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert "friction_coefficient" in done.stdout
    assert f"{np.sqrt(0.02 / 9.81):.5g}"[:6] in done.stdout
