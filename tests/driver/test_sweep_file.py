"""Sweep files: what they may say, mistakes in them, `check`, `help`, the table, `merge`."""

from __future__ import annotations

import re

import h5py
import numpy as np
import pytest

# A ball that slides on a floor: a case takes less than a millisecond.
BALL = """\
&scene title = 'Ball', gravity = 0, 0, -9.81, t_end = 2e-3 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', mass = 0.0327, inertia = 3*1.308e-6, position = 0, 0, 0.0101,
   velocity = 0.5, 0, -0.2 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 1.0e-2, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'steel' /
&contact name = 'touch', surfaces = 'skin', 'floor', friction = 'pade11',
   friction_coefficient = 0.3 /
&integrator method = 'explicit8', rtol = 1e-6 /
&output file = 'ball.h5', interval = 1e-3 /
"""


@pytest.fixture
def ball(tmp_path):
    """Write the scene and a sweep over it; `ball(text, name) -> path of the sweep file`."""

    def write(text, name="sweep.nml"):
        (tmp_path / "ball.nml").write_text(BALL)
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


def rows(path):
    """All columns of a table: {group/name: values}, and status and messages."""
    with h5py.File(path) as file:
        columns = {"case": file["case"][:], "status": file["status"][:]}
        columns["message"] = file["message"].asstr()[:]
        for group in ("parameters", "results"):
            for name, data in file[group].items():
                text = h5py.check_string_dtype(data.dtype)
                columns[f"{group}/{name}"] = data.asstr()[:] if text else data[:]
    return columns


def same(a, b):
    """Whether two tables have the same bits in every column."""
    assert a.keys() == b.keys()
    return all(
        x.tobytes() == y.tobytes() if x.dtype != object else list(x) == list(y)
        for x, y in ((a[key], b[key]) for key in a)
    )


def value_of(text, word):
    """The word after one that begins a line."""
    return re.search(rf"^{word}\s+(\S+)", text, re.MULTILINE)[1]


# ---- Samplings -----------------------------------------------------------------------------------


def test_grid(run, ball, tmp_path):
    sweep = ball("""\
&sweep scene = 'ball.nml' /
&parameter name = 'touch.friction', values = 'coulomb', 'pade22', column = 'model' /
&parameter name = 'ball.position(3)', first = 0.0101, last = 0.0107, count = 4 /
&parameter name = 'integrator.rtol', vary = 'log', first = 1e-8, last = 1e-4, count = 3 /
""")
    result = run("sweep", sweep.name, "--set", "touch.regularization_velocity=1e-3")
    assert result.status == 0, result.err
    table = rows(tmp_path / "sweep.h5")
    assert list(table["case"]) == list(range(1, 25))
    assert list(table["parameters/model"]) == ["coulomb"] * 12 + ["pade22"] * 12
    heights = np.repeat(np.linspace(0.0101, 0.0107, 4), 3)
    np.testing.assert_allclose(
        table["parameters/ball.position(3)"], np.tile(heights, 2), rtol=1e-14
    )
    np.testing.assert_allclose(
        table["parameters/integrator.rtol"], np.tile([1e-8, 1e-6, 1e-4], 8), rtol=1e-13
    )
    assert table["parameters/integrator.rtol"][[0, 2]].tolist() == [1e-8, 1e-4]
    assert (table["status"] == 0).all()


def test_whole_numbers(run, ball, tmp_path):
    ball("""\
&sweep scene = 'ball.nml', output = 'table.h5' /
&parameter name = 'integrator.jacobian_steps', first = 2, last = 12, count = 6 /
""")
    result = run("sweep", "sweep.nml")
    assert result.status == 0, result.err
    found = rows(tmp_path / "table.h5")["parameters/integrator.jacobian_steps"]
    assert list(found) == [2, 4, 6, 8, 10, 12]


def test_latin_hypercube(run, ball, tmp_path):
    sweep = ball("""\
&sweep scene = 'ball.nml', sampling = 'latin_hypercube', cases = 50, seed = 4, keep = 'steps' /
&parameter name = 'ball.velocity(1)', first = -1, last = 1 /
&parameter name = 'touch.friction_coefficient', vary = 'log', first = 1e-3, last = 1 /
&parameter name = 'touch.friction', values = 'pade11', 'pade22' /
""")
    assert run("sweep", sweep.name).status == 0
    table = rows(tmp_path / "sweep.h5")
    velocity = (table["parameters/ball.velocity(1)"] + 1) / 2
    friction = np.log10(table["parameters/touch.friction_coefficient"]) / 3 + 1
    for unit in (velocity, friction):
        assert sorted(np.floor(unit * 50).astype(int)) == list(range(50))
        assert list(unit) != sorted(unit)
    models = list(table["parameters/touch.friction"])
    assert models.count("pade11") == models.count("pade22") == 25

    other = run("sweep", sweep.name, "--set", "sweep.seed=5", "-o", "other.h5")
    assert other.status == 0
    assert not same(table, rows(tmp_path / "other.h5"))


def test_sobol(run, ball, tmp_path):
    sweep = ball("""\
&sweep scene = 'ball.nml', sampling = 'sobol', cases = 6, keep = 'steps' /
&parameter name = 'ball.velocity(1)', first = 0, last = 1 /
&parameter name = 'ball.velocity(2)', first = 0, last = 1 /
""")
    run("sweep", sweep.name)
    table = rows(tmp_path / "sweep.h5")
    points = np.array([table[f"parameters/ball.velocity({i})"] for i in (1, 2)])
    known = [(0.5, 0.5), (0.75, 0.25), (0.25, 0.75), (0.375, 0.375), (0.875, 0.875), (0.625, 0.125)]
    assert points.T.tolist() == [list(point) for point in known]

    assert run("sweep", sweep.name, "--set", "sweep.seed=9", "-o", "moved.h5").status == 0
    table = rows(tmp_path / "moved.h5")
    moved = np.array([table[f"parameters/ball.velocity({i})"] for i in (1, 2)])
    shift = (moved - points) % 1
    assert np.ptp(shift, axis=1).max() < 1e-12
    assert shift[0, 0] > 1e-6


def test_table_of_cases(run, ball, tmp_path):
    """CSV, HDF5 and the table of another sweep give the same rows."""
    header = (
        "&sweep scene = 'ball.nml', sampling = 'file', table = '{}', keep = 'steps', 'time' /\n"
    )
    tied = "&parameter name = 'ball.velocity(1)', 'ball.velocity(2)', column = 'v' /\n"
    speeds = [0.1, 0.25, 1.0]
    models = ["pade11", "pade22", "contensou_exact"]
    drilling = ["true", ".false.", "T"]
    lines = [f'{v}, "{m}", {d}' for v, m, d in zip(speeds, models, drilling, strict=True)]
    (tmp_path / "points.csv").write_text(
        "v,touch.friction,touch.drilling\r\n\n" + "\r\n".join(lines) + "\r\n"
    )
    assert run("sweep", ball(header.format("points.csv") + tied, "csv.nml").name).status == 0
    with h5py.File(tmp_path / "points.h5", "w") as file:
        file["v"] = speeds
        file["touch.friction"] = np.array(models, dtype=h5py.string_dtype())
        file["touch.drilling"] = np.array([b".true.", b"F", b"true"])
    assert run("sweep", ball(header.format("points.h5") + tied, "hdf5.nml").name).status == 0
    assert run("sweep", ball(header.format("csv.h5") + tied, "again.nml").name).status == 0
    table = rows(tmp_path / "csv.h5")
    assert table["parameters/v"].tolist() == speeds
    assert list(table["parameters/touch.friction"]) == models
    assert list(table["parameters/touch.drilling"]) == [".true.", ".false.", ".true."]
    assert same(table, rows(tmp_path / "hdf5.h5"))
    assert same(table, rows(tmp_path / "again.h5"))


@pytest.mark.parametrize(
    ("csv", "line", "column", "message"),
    [
        ("ball.mas\n1\n", 1, 1, "unknown key 'mas' in group &body"),
        ("ball.mass,bal.angle\n1,2\n", 1, 11, "no group or name 'bal'"),
        ("ball.mass\n1\n-2\n", 3, 1, "'mass' is out of range"),
        ("ball.mass\n1\nx\n", 3, 1, "'mass' needs a number"),
        ("ball.mass\n1\n\nnan\n", 4, 1, "'mass' must be finite"),
        ("ball.mass,touch.friction\n1,pad11\n", 2, 3, "unknown friction 'pad11'"),
        ("ball.mass,touch.friction\n1\n", 2, 1, "1 value in a table with 2 columns"),
        ("ball.mass,ball.mass\n1,2\n", 1, 11, "'ball.mass' is given by two parameters"),
        ("touch.drilling\nmaybe\n", 2, 1, "'drilling' needs a logical"),
        ("floor.material\niron\n", 2, 1, "there is no material 'iron'"),
    ],
)
def test_mistakes_in_a_table(run, ball, tmp_path, mistakes, csv, line, column, message):
    (tmp_path / "points.csv").write_text(csv)
    sweep = ball("&sweep scene = 'ball.nml', sampling = 'file', table = 'points.csv' /\n")
    result = run("check", sweep.name)
    assert result.status == 2
    found = mistakes(result.err)
    assert len(found) == 1, result.err
    assert (found[0].source, found[0].line, found[0].column) == ("points.csv", line, column)
    assert message in found[0].message


@pytest.mark.parametrize("csv", ["", "\n\n", "ball.mass\n", "ball.mass\n\n\n"])
def test_a_table_without_rows(run, ball, tmp_path, mistakes, csv):
    (tmp_path / "points.csv").write_text(csv)
    sweep = ball("&sweep scene = 'ball.nml', sampling = 'file', table = 'points.csv' /\n")
    result = run("check", sweep.name)
    assert result.status == 2
    assert mistakes(result.err)[0].line == 1


def test_a_long_table(run, ball, tmp_path):
    sweep = ball("&sweep scene = 'ball.nml', sampling = 'file', table = 'points.csv' /\n")
    (tmp_path / "points.csv").write_text("ball.mass\n" + "0.5\n" * 5000)
    assert value_of(run("check", sweep.name).out, "cases") == "5000"


def test_mistakes_in_hdf5(run, ball, tmp_path, mistakes):
    sweep = ball("&sweep scene = 'ball.nml', sampling = 'file', table = 'points.h5' /\n")
    path = tmp_path / "points.h5"

    def message(**columns):
        with h5py.File(path, "w") as file:
            file.attrs["nothing"] = 1
            for name, values in columns.items():
                file[name.replace("_", ".")] = values
        result = run("check", sweep.name)
        assert result.status == 2
        found = mistakes(result.err)
        assert len(found) == 1, result.err
        return found[0].message

    assert "points.h5 has no one-dimensional datasets" in message()
    text = message(ball_mass=[1.0, 2.0], touch_friction=[b"pade11"])
    assert "the columns are not equally long" in text
    assert "row 2 of ball.mass: 'mass' is out of range" in message(ball_mass=[1.0, -2.0])
    path.write_bytes(path.read_bytes()[:900])
    result = run("check", sweep.name)
    assert result.status == 2
    assert "points.h5" in result.err


# ---- Results -------------------------------------------------------------------------------------


def test_results_that_are_kept(run, ball, tmp_path):
    def names(keep, extra=""):
        sweep = ball(
            f"&sweep scene = 'ball.nml', {keep} /\n&parameter name = 'ball.mass', values = 1 /\n"
            + extra
        )
        assert run("sweep", sweep.name, "--force").status == 0
        with h5py.File(tmp_path / "sweep.h5") as file:
            return [str(name) for name in file["results"].attrs["columns"]]

    scalars = names("keep = 'summary'")
    assert "cpu_s" not in scalars
    events = names("keep = 'events'")
    assert events == [
        f"{name}_touch"
        for name in ("first_touch", "last_touch", "first_lift", "last_lift", "touches", "lifts")
    ]
    assert names("") == scalars + events
    state = names("keep = 'final_state'")
    assert state[:3] == ["position_ball_x", "position_ball_y", "position_ball_z"]
    assert len(state) == 13
    assert names("keep = 'Steps', 'position', 'first_touch'") == [
        "steps",
        "first_touch_touch",
        *state[:3],
    ]
    value = "&value name = 'z', dataset = 'position', component = 3, time = 1e-3 /\n"
    assert names("keep = 'nothing'", value) == ["z"]

    # All scalars of /summary but the CPU time.
    assert run("run", "ball.nml").status == 0
    with h5py.File(tmp_path / "ball.h5") as file:
        single = {name for name, data in file["summary"].items() if data.shape == ()}
    assert set(scalars) == single - {"cpu_s"}


# ---- The table -----------------------------------------------------------------------------------

GRID = """\
&sweep scene = 'ball.nml', output = 'table.h5' /
&parameter name = 'touch.friction_coefficient', values = 0.1, 0.2, 0.3, column = 'mu' /
&parameter name = 'ball.position(3)', values = 0.0101, 0.001, 0.0102, column = 'height' /
&parameter name = 'touch.friction', values = 'pade11', 'pade22', column = 'model' /
"""


def test_table(run, ball, tmp_path):
    """Units, descriptions, status and messages; a ball within the floor is a row, too."""
    assert run("sweep", ball(GRID).name).status == 0
    with h5py.File(tmp_path / "table.h5") as file:
        assert file.attrs["filetype"] == "contensou-sweep"
        assert file.attrs["status"] == "complete"
        assert file.attrs["case_count"] == 18
        assert file.attrs["cases"] == "1:18"
        assert file["parameters/height"].attrs["units"] == "m"
        assert file["parameters/height"].attrs["long_name"] == "ball.position(3)"
        assert "units" not in file["parameters/model"].attrs
        assert file["results/energy_initial"].attrs["units"] == "J"
        assert file["results/steps"].dtype == np.int64
        assert file["results/steps"].attrs["_FillValue"] == -1
        assert file["status"].dtype == np.int8
        assert file["status"].attrs["flag_meanings"].split()[2] == "invalid_scene"
        assert list(file["status"].attrs["flag_values"]) == [0, 1, 2, 3, 4]
        for group in ("parameters", "results"):
            for name, data in file[group].items():
                assert data.shape == (18,), name
                assert data.dims[0][0] == file["case"], name
        assert file["input/sweep"].asstr()[()] == GRID
        assert file["input/scene"].asstr()[()] == BALL
        assert "&integrator" in file["input/resolved"].asstr()[()]
        assert file["input/command_line"].asstr()[()].endswith("sweep sweep.nml")
    table = rows(tmp_path / "table.h5")
    bad = table["parameters/height"] < 0.01
    assert bad.sum() == 6
    assert (table["status"] == np.where(bad, 2, 0)).all()
    assert all("overlap" in text for text in table["message"][bad])
    assert all(text == "" for text in table["message"][~bad])
    assert (np.isnan(table["results/energy_initial"]) == bad).all()
    assert ((table["results/steps"] == -1) == bad).all()


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_readers(run, ball, tmp_path, engine):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf" if engine == "h5netcdf" else "netCDF4")
    pytest.importorskip("pandas")
    assert run("sweep", ball(GRID).name).status == 0
    parts = [
        xarray.open_dataset(tmp_path / "table.h5", group=group, engine=engine)
        for group in (None, "parameters", "results")
    ]
    table = xarray.merge(parts)
    assert list(table.case.values) == list(range(1, 19))
    assert table.mu.attrs["units"] == "1"
    # Counts that are not known are NaN.
    assert np.isnan(table.steps.values[table.status.values == 2]).all()
    assert (table.steps.values[table.status.values == 0] > 0).all()
    frame = table.to_dataframe()
    assert frame[frame.status == 0].groupby("model").steps.count().tolist() == [6, 6]


def test_size(run, ball, tmp_path, build_kind):
    """Twenty columns take less than 200 bytes a case; one column is read alone."""
    sweep = ball("""\
&sweep scene = 'ball.nml', keep = 'summary', 'events', set = 'scene.t_end = 1e-5' /
&parameter name = 'ball.velocity(1)', first = 0, last = 1, count = 200 /
&parameter name = 'ball.velocity(2)', first = 0, last = 1, count = 100 /
""")
    assert run("sweep", sweep.name, timeout=300).status == 0
    table = tmp_path / "sweep.h5"
    with h5py.File(table) as file:
        assert len(file["parameters"]) + len(file["results"]) == 20
    assert table.stat().st_size < 200 * 20000


# ---- Mistakes ------------------------------------------------------------------------------------


def test_all_mistakes_at_once(run, ball, mistakes):
    sweep = ball("""\
&sweep
   scene = 'ball.nml', sampling = 'gird'
   set = 'scene.t_nd = 2', 'integrator.rtol = 7'
   keep = 'sumary', 'events'
   trajectories = 0, 1.5
   time_limt = 3
/
&parameter name = 'contact.friction_coeficient', vary = 'log', first = 0, last = 5, count = 2.5 /
&parameter name = 'bal.mass', first = 1, last = 2, count = 2 /
&parametre name = 'ball.mass', values = 1 /
""")
    result = run("check", sweep.name)
    assert result.status == 2
    assert result.out == ""
    found = mistakes(result.err)
    assert [(m.line, m.column) for m in found] == [
        (2, 35),
        (3, 10),
        (3, 28),
        (4, 11),
        (5, 19),
        (5, 22),
        (6, 4),
        (8, 19),
        (8, 72),
        (8, 93),
        (9, 19),
        (10, 1),
    ]
    nearest = {m.column if m.line == 3 else m.line: m.expected for m in found}
    assert nearest[10] in ("t_end", "&parameter")
    assert nearest[2].startswith("'grid'")
    assert nearest[4] == "'summary'"
    assert nearest[6] == "time_limit"
    assert found[7].expected == "contact.friction_coefficient"
    assert found[10].expected == "ball.mass"
    assert found[11].expected == "&parameter"
    assert "12 errors in sweep.nml; nothing was run" in result.err


HEAD = "&sweep scene = 'ball.nml' /\n"
MASS = "&parameter name = 'ball.mass', values = 1, 2 /\n"


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        (MASS, 0, 0, "there is no group &sweep"),
        (HEAD, 1, 1, "there is no group &parameter"),
        (HEAD + HEAD + MASS, 2, 1, "group &sweep given twice"),
        ("&sweep scene = 'bal.nml' /\n" + MASS, 1, 16, "does not exist"),
        ("&sweep /\n" + MASS, 1, 1, "'scene' is missing"),
        (HEAD + MASS + MASS, 3, 19, "'ball.mass' is given by two parameters"),
        (
            HEAD + MASS + "&parameter name = 'body.mass', values = 2 /\n",
            3,
            19,
            "sets what another parameter sets",
        ),
        (
            "&sweep scene = 'ball.nml', set = 'ball.mass = 3' /\n" + MASS,
            1,
            34,
            "is set for all cases, and a parameter varies it",
        ),
        (HEAD + "&parameter name = 'ball.mass', values = 1, -2 /\n", 2, 44, "out of range"),
        (HEAD + "&parameter name = 'ball.mass', values = 1, 'a' /\n", 2, 44, "needs a number"),
        (HEAD + "&parameter name = 'ball.position', values = 1 /\n", 2, 19, "has 3 values"),
        (HEAD + "&parameter name = 'ball.position(4)', values = 1 /\n", 2, 19, "out of range"),
        (HEAD + "&parameter name = 'ball.axis(1)', values = 1 /\n", 2, 19, "does not give"),
        (HEAD + "&parameter name = 'ball.name', values = 'x' /\n", 2, 19, "cannot vary"),
        (
            HEAD + "&parameter name = 'ball.mass', first = 1, last = 2 /\n",
            2,
            1,
            "'count' is missing",
        ),
        (
            HEAD + "&parameter name = 'ball.mass', first = 1, count = 2 /\n",
            2,
            1,
            "'last' is missing",
        ),
        (
            HEAD + "&parameter name = 'ball.mass', vary = 'list' /\n",
            2,
            32,
            "'values' is missing",
        ),
        (
            HEAD + "&parameter name = 'ball.mass', vary = 'log', values = 1 /\n",
            2,
            46,
            "'values' has no meaning",
        ),
        (
            HEAD
            + "&parameter name = 'ball.angle', vary = 'log', first = -1, last = 1, count = 3 /\n",
            2,
            55,
            "must be positive",
        ),
        (
            HEAD + "&parameter name='ball.mass', vary='log', first=-1, last=1, count=3 /\n",
            2,
            48,
            "'mass' is out of range",
        ),
        (
            HEAD + "&parameter name='ball.mass', vary='log', first=1, last=0, count=3 /\n",
            2,
            56,
            "'mass' is out of range",
        ),
        (
            HEAD + "&parameter name = 'touch.friction', first = 1, last = 2, count = 2 /\n",
            2,
            19,
            "are no numbers",
        ),
        (
            HEAD + "&parameter name = 'touch.friction', values = 'pade33' /\n",
            2,
            46,
            "unknown friction 'pade33'",
        ),
        (
            HEAD + "&parameter name = 'ball.mass', 'touch.friction_coefficient', values = 1 /\n",
            2,
            32,
            "their units are",
        ),
        (
            HEAD + "&parameter name = 'ball.mass', values = 1, column = 'steps' /\n",
            2,
            53,
            "a parameter and a result",
        ),
        (
            HEAD + "&parameter name = 'ball.mass', values = 1, column = 'a/b' /\n",
            2,
            53,
            "cannot be the name of a column",
        ),
        ("&sweep scene = 'ball.nml', cases = 7 /\n" + MASS, 1, 28, "'cases' has no meaning"),
        ("&sweep scene = 'ball.nml', trajectories = 3 /\n" + MASS, 1, 43, "there is no case 3"),
        (
            "&sweep scene = 'ball.nml', sampling = 'sobol' /\n" + MASS,
            1,
            1,
            "'cases' is missing",
        ),
        (
            "&sweep scene = 'ball.nml', sampling = 'sobol', cases = 0 /\n" + MASS,
            1,
            56,
            "'cases' is out of range",
        ),
        ("&sweep scene = 'ball.nml', keep = 'cpu_s' /\n" + MASS, 1, 35, "cannot be kept"),
        ("&sweep scene = 'ball.nml', time_limit = 0 /\n" + MASS, 1, 41, "out of range"),
        ("&sweep scene = 'ball.nml', keep = 'nothing' /\n" + MASS, 1, 28, "nothing is kept"),
        (
            HEAD + MASS + "&value name = 'v', dataset = 'position', time = 0 /\n",
            3,
            1,
            "'component' is missing",
        ),
        (
            HEAD + MASS + "&value name = 'v', dataset = 'gap', of = 'tuch', time = 0 /\n",
            3,
            42,
            "there is no contact 'tuch'",
        ),
        (
            HEAD + MASS + "&value name = 'v', dataset = 'gap', time = 1 /\n",
            3,
            44,
            "beyond the end of the runs",
        ),
        (
            HEAD + MASS + "&value name = 'steps', dataset = 'gap', time = 0 /\n",
            3,
            15,
            "two results have the name 'steps'",
        ),
        (HEAD + MASS + "&quux a = 1 /\n", 3, 1, "unknown group &quux in a sweep"),
        (
            HEAD + "&parameter name = 'ball.mass', values = 1, values = 2 /\n",
            2,
            44,
            "'values' given twice in group &parameter",
        ),
        (
            HEAD + "&parameter name(2) = 'ball.mass', values = 1 /\n",
            2,
            12,
            "'name' takes no subscript",
        ),
        (
            HEAD + "&parameter name = 'ball.mass', values = /\n",
            2,
            32,
            "no value for 'values' in group &parameter",
        ),
        (
            "&sweep scene = 'ball.nml', cases = 3, 4, sampling = 'sobol' /\n" + MASS,
            1,
            39,
            "too many values for 'cases' in group &sweep",
        ),
        (
            HEAD + "&parameter name = 'ball.mass', 'ball.spin(1)',, values = 1 /\n",
            2,
            47,
            "a value of 'name' is missing in group &parameter",
        ),
        (
            "&sweep scene = 'ball.nml', seed = 'a', cases = 3, sampling='sobol' /\n" + MASS,
            1,
            35,
            "'seed' needs a number",
        ),
        (
            "&sweep scene = 'ball.nml', time_limit = nan /\n" + MASS,
            1,
            41,
            "'time_limit' must be finite",
        ),
        (
            "&sweep scene = 'ball.nml', seed = 1.5, cases = 3, sampling='sobol' /\n" + MASS,
            1,
            35,
            "'seed' must be whole",
        ),
        (
            HEAD + "&parameter name = 'ball.mass', values = inf /\n",
            2,
            41,
            "'values' must be finite",
        ),
        (
            "&sweep scene = 'ball.nml', sampling = 3 /\n" + MASS,
            1,
            39,
            "'sampling' needs a text in quotes",
        ),
        ("&sweep scene = 'ball.nml', output = '' /\n" + MASS, 1, 37, "'output' is empty"),
        (
            "&sweep scene = 'ball.nml', sampling = 'qqqqqqqqqq' /\n" + MASS,
            1,
            39,
            "unknown sampling 'qqqqqqqqqq'",
        ),
        (
            "&sweep scene = 'ball.nml', output = 'sweep.nml' /\n" + MASS,
            1,
            28,
            "the table would replace the sweep file",
        ),
        (
            "&sweep scene = 'ball.nml', sampling = 'file' /\n",
            1,
            1,
            "'table' is missing for sampling = 'file'",
        ),
        (
            HEAD
            + "&parameter name='ball.mass', first=1, last=2, count=2000000000 /\n"
            + "&parameter name='ball.spin(1)', first=1, last=2, count=2000000000 /\n",
            1,
            1,
            "the grid has 4.0e18 cases",
        ),
        (
            HEAD + "&parameter name='ball.mass', first=2, last=2, count=3 /\n",
            2,
            44,
            "'last' is the same as 'first'",
        ),
        (
            HEAD + "&parameter name='ball.mass', column='status', values=1 /\n",
            2,
            37,
            "'status' cannot be the name of a column",
        ),
        (
            "&sweep scene = 'ball.nml', keep='qqqqqqqqqqqqqqqqq' /\n" + MASS,
            1,
            33,
            "unknown result 'qqqqqqqqqqqqqqqqq'",
        ),
        (
            HEAD + MASS + "&value name = 'v', dataset='drive_force', component=1, time=0 /\n",
            3,
            28,
            "no body of the scene is driven",
        ),
        (
            HEAD + MASS + "&value name = 'v', dataset='gap', component=1, time=0 /\n",
            3,
            35,
            "'component' has no meaning for gap, which is a scalar",
        ),
        (
            HEAD + MASS + "&value name = 'v', dataset='position', component=4, time=0 /\n",
            3,
            50,
            "'component' is out of range",
        ),
        (
            HEAD + MASS + "&value name = 'v', dataset='energy_kinetic', of='ball', time=0 /\n",
            3,
            46,
            "'of' has no meaning for energy_kinetic, which belongs to the whole scene",
        ),
        (
            HEAD + MASS + "&value name = 'v', dataset='gap', of='qqqqqqqqqqqqq', time=0 /\n",
            3,
            38,
            "there is no contact 'qqqqqqqqqqqqq'",
        ),
        (
            HEAD + "&parameter name='ball.qqqqqqqqqqqqqqqqqqqqq', values=1 /\n",
            2,
            17,
            "unknown key 'qqqqqqqqqqqqqqqqqqqqq' in group &body",
        ),
        (
            HEAD + "&parameter name='floor.material', values='qqqqqqqqqqqqq' /\n",
            2,
            42,
            "there is no material 'qqqqqqqqqqqqq'",
        ),
        (
            "&sweep scene = 'ball.nml', sampling='sobol', cases=4294967296 /\n" + MASS,
            1,
            46,
            "a Sobol sequence has less than 2^30 points",
        ),
        (
            "&sweep scene = 'ball.nml', sampling = 'file', table='.' /\n",
            1,
            53,
            ". cannot be read: it is a folder",
        ),
        (
            "&sweep scene = 'ball.nml', sampling = 'file', table='no.csv' /\n",
            1,
            53,
            "no.csv cannot be read: it does not exist",
        ),
        (
            HEAD + "&parameter name='integrator.jacobian_steps', first=1, last=12, count=3 /\n",
            2,
            52,
            "is a whole number, and what is between 'first' and 'last' is not",
        ),
        (
            "&sweep scene = 'ball.nml', sampling='sobol', cases=4 /\n"
            "&parameter name='integrator.jacobian_steps', first=1, last=9 /\n",
            2,
            52,
            "is a whole number, and what is between 'first' and 'last' is not",
        ),
    ],
)
def test_mistake(run, ball, mistakes, text, line, column, message):
    result = run("sweep", ball(text).name)
    assert result.status == 2
    found = mistakes(result.err)
    assert len(found) == 1, result.err
    assert message in found[0].message
    assert (found[0].line, found[0].column) == (line, column)


def test_log_of_two_wrong_ends(run, ball, mistakes):
    """Each end is told once, whether its key or the logarithm does not take it."""
    sweep = ball(
        HEAD
        + "&parameter name='ball.mass', vary='log', first=-1, last=0, count=3 /\n"
        + "&parameter name='ball.angle', vary='log', first=0, last=-1, count=3 /\n"
    )
    found = mistakes(run("check", sweep.name).err)
    assert [(m.line, m.column) for m in found] == [(2, 48), (2, 57), (3, 49), (3, 57)]
    assert ["must be positive" in m.message for m in found] == [False, False, True, True]


def test_mistakes_of_the_base_scene(run, ball, tmp_path, mistakes):
    """They are shown with their own places, beside those of the sweep file."""
    sweep = ball(HEAD + "&parameter name = 'ball.mass', valus = 1 /\n")
    (tmp_path / "ball.nml").write_text(BALL.replace("poisson = 0.3", "poisson = 3"))
    found = mistakes(run("check", sweep.name).err)
    assert [(m.source, m.line) for m in found] == [("sweep.nml", 2), ("ball.nml", 2)]
    result = run("check", sweep.name, "--set", "steel.poisson=0.2")
    assert [m.source for m in mistakes(result.err)] == ["sweep.nml"]


# ---- check and help ------------------------------------------------------------------------------


def test_check(run, ball, tmp_path, build_kind):
    """What it says is for scripts, too, and the estimate is near the truth."""
    count = 40 if build_kind == "release" else 2
    sweep = ball(f"""\
&sweep scene = 'ball.nml', set = 'scene.t_end = 0.05', output = 'x.h5' /
&parameter name = 'ball.velocity(1)', first = 0, last = 1, count = {count} /
&parameter name = 'touch.friction_coefficient', first = 0.1, last = 0.5, count = 25 /
""")
    result = run("check", sweep.name)
    assert result.status == 0, result.err
    assert value_of(result.out, "cases") == str(25 * count)
    assert value_of(result.out, "shards") == "1"
    assert re.search(r"^  output +x\.h5$", result.out, re.MULTILINE)
    assert len(re.findall(r"^ *output", result.out, re.MULTILINE)) == 1
    assert list(tmp_path.glob("*.h5*")) == []
    # `scripts/bench forecast` holds this against what the sweep takes.
    assert 0 < float(value_of(result.out, "cpu_hours")) < 1


def test_check_suggests_shards(run, ball):
    """Half an hour each, and not more than cases."""
    text = """\
&sweep scene = 'ball.nml', set = 'scene.t_end = 0.05' /
&parameter name = 'ball.velocity(1)', first = 0, last = 1, count = {} /
&parameter name = 'touch.friction_coefficient', first = 0.1, last = 0.5, count = 100000 /
"""
    out = run("check", ball(text.format(1000)).name).out
    hours, shards = float(value_of(out, "cpu_hours")), int(value_of(out, "shards"))
    assert value_of(out, "cases") == str(10**8)
    assert 10 / 60 < hours / shards < 1
    result = run("check", ball("&sweep scene = 'ball.nml' /\n" + MASS).name)
    assert value_of(result.out, "shards") == "1"


def test_help(run):
    out = run("help").out
    assert "&sweep" in out
    assert "&parameter" in out
    assert "&value" in out
    out = run("help", "sweep").out
    for key in ("scene", "sampling", "cases", "seed", "table", "set", "keep", "time_limit"):
        assert f"sweep.{key}\n" in out
    assert "usage: contensou sweep SWEEP" in out
    assert "latin_hypercube" in run("help", "sweep.sampling").out
    assert "did you mean 'count'?" in run("help", "parameter.cont").err
    assert run("help", "parameter.count").status == 0


# ---- merge ---------------------------------------------------------------------------------------

MANY = """\
&sweep scene = 'ball.nml', output = 'table.h5' /
&parameter name = 'touch.friction_coefficient', first = 0.1, last = 0.5, count = 5 /
&parameter name = 'ball.position(3)', values = 0.0101, 0.001, 0.0102 /
&parameter name = 'touch.friction', values = 'pade11', 'pade22' /
"""


@pytest.fixture
def shards(run, ball):
    """Four shards of a sweep of 30 cases, and its table as whole.h5."""
    sweep = ball(MANY)
    for k in range(1, 5):
        assert run("sweep", sweep.name, "--shard", f"{k}/4").status == 0
    assert run("sweep", sweep.name, "-o", "whole.h5").status == 0
    return sweep.name


def test_merge_of_a_sweep(run, shards, tmp_path):
    result = run("merge", shards)
    assert result.status == 0, result.err
    assert "30" in result.out
    assert same(rows(tmp_path / "table.h5"), rows(tmp_path / "whole.h5"))
    with h5py.File(tmp_path / "table.h5") as a, h5py.File(tmp_path / "whole.h5") as b:
        ours = {"created"}
        assert {k: v for k, v in a.attrs.items() if k not in ours} == {
            k: v for k, v in b.attrs.items() if k not in ours
        }
        for name in ("sweep", "scene", "resolved"):
            assert a[f"input/{name}"][()] == b[f"input/{name}"][()]
        assert list(a["results"].attrs["columns"]) == list(b["results"].attrs["columns"])
    again = run("merge", shards)
    assert again.status == 0
    assert "complete" in again.out


def test_merge_of_files(run, shards, tmp_path):
    names = [f"table_shard_{k}_of_4.h5" for k in (3, 1, 4, 2)]
    assert run("merge", *names).status == 2
    assert run("merge", *names, "-o", "joined.h5").status == 0
    assert same(rows(tmp_path / "joined.h5"), rows(tmp_path / "whole.h5"))
    # A case that is there twice is there once.
    assert run("merge", *names, "whole.h5", names[0], "-o", "joined.h5", "--force").status == 0
    assert same(rows(tmp_path / "joined.h5"), rows(tmp_path / "whole.h5"))


def test_merge_lists_what_is_missing(run, shards, tmp_path):
    for k in (2, 4):
        (tmp_path / f"table_shard_{k}_of_4.h5").unlink()
    result = run("merge", shards)
    assert result.status == 1
    assert "14 of 30 cases are missing" in result.err or "15 of 30" in result.err
    ranges = re.search(r"--cases (\S+)", result.err)[1]
    assert not (tmp_path / "table.h5").exists()

    partial = run("merge", shards, "--partial", "-o", "some.h5")
    # Shards of the name that the sweep has, though the table gets another one.
    assert partial.status == 1, partial.err
    whole = rows(tmp_path / "whole.h5")
    some = rows(tmp_path / "some.h5")
    missing = {n for part in ranges.split(",") for n in span(part)}
    assert set(some["case"]) == set(whole["case"]) - missing
    chosen = np.isin(whole["case"], some["case"])
    assert same({key: value[chosen] for key, value in whole.items()}, some)

    assert run("sweep", shards, "--cases", ranges).status == 0
    assert run("merge", shards).status == 0
    assert same(rows(tmp_path / "table.h5"), whole)


def span(text):
    """Cases of a range such as 3:7."""
    first, _, last = text.partition(":")
    return range(int(first), int(last or first) + 1)


def test_merge_refuses_what_does_not_belong_together(run, shards, ball, tmp_path):
    other = ball(MANY.replace("first = 0.1", "first = 0.2"), "other.nml")
    assert run("sweep", other.name, "-o", "other.h5").status == 0
    result = run("merge", "table_shard_1_of_4.h5", "other.h5", "-o", "x.h5")
    assert result.status == 2
    assert "cannot be joined" in result.err
    assert run("run", "ball.nml").status == 0
    result = run("merge", "table_shard_1_of_4.h5", "ball.h5", "-o", "x.h5")
    assert result.status == 2
    assert "ball.h5 is not the table of a sweep" in result.err
    assert run("merge", "no.h5", "-o", "x.h5").status == 74
    # The sweep file has changed since.
    ball(MANY.replace("first = 0.1", "first = 0.2"))
    result = run("merge", shards)
    assert result.status == 2
    assert "of another sweep" in result.err
    assert not list(tmp_path.glob("x.h5*"))


def test_merge_replaces_nothing_unasked(run, shards, tmp_path):
    (tmp_path / "table.h5").write_text("mine")
    result = run("merge", shards)
    assert result.status == 74
    assert "--force" in result.err
    assert (tmp_path / "table.h5").read_text() == "mine"
    assert run("merge", shards, "--force").status == 0
    assert same(rows(tmp_path / "table.h5"), rows(tmp_path / "whole.h5"))


def test_elements_by_set(run, scene, settings):
    """`--set` takes one value of several; the others stay, or are the default."""

    def body(*words):
        result = run("check", scene.name, *[w for word in words for w in ("--set", word)])
        assert result.status == 0, result.err
        return dict(settings(result.out))

    assert body("top.position(3)=0.0130")["body"]["position"] == [0, 0, 0.0130]
    assert body("top.spin(1)=2", "top.spin(2)=3")["body"]["spin"] == [2, 3, 180]
    assert body("floor.centre(2)=3")["surface"]["centre"] == [0, 3, 0]
    for wrong in ("top.position(4)=1", "top.position(0)=1", "top.position(1)=1,2", "top.mass()=1"):
        assert run("check", scene.name, "--set", wrong).status == 2, wrong


def test_bearings(run, tmp_path, inputs):
    """Parameters of a bearing and of its parts; each case has the scene that a run has."""
    (tmp_path / "bearing.nml").write_text((inputs / "bearing_6205.nml").read_text())
    name = re.search(r"&bearing\s+name = '(\w+)'", (tmp_path / "bearing.nml").read_text())[1]
    (tmp_path / "sweep.nml").write_text(f"""\
&sweep scene = 'bearing.nml', set = 'scene.t_end = 1e-5', 'output.interval = 1e-5',
   keep = 'energy_initial', 'position', trajectories = 2 /
&parameter name = '{name}.pitch_diameter', values = 0.039, 0.0391 /
""")
    result = run("sweep", "sweep.nml", timeout=300)
    assert result.status == 0, result.err
    table = rows(tmp_path / "sweep.h5")
    assert (table["status"] == 0).all(), table["message"]
    assert table["results/energy_initial"][0] != table["results/energy_initial"][1]
    with h5py.File(tmp_path / "sweep_case_2.h5") as file:
        assert file["summary/energy_initial"][()] == table["results/energy_initial"][1]
        body = file["summary/body"].asstr()[3]
        assert file["summary/position"][3, 0] == table[f"results/position_{body}_x"][1]
    (tmp_path / "sweep.nml").write_text(f"""\
&sweep scene = 'bearing.nml' /
&parameter name = '{name}.ball_count', values = 8, 9 /
""")
    result = run("check", "sweep.nml")
    assert result.status == 2
    assert "changes which bodies there are" in result.err
