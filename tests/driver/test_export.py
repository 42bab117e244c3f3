"""`contensou export`: columns of output files as comma-separated values."""

from __future__ import annotations

import csv
import io
import re
import struct

import h5py
import numpy as np
import pytest


@pytest.fixture
def output(run, scene, tmp_path):
    """The output file of a short run of the Tippe-Top."""
    assert run("run", scene.name, "-q").status == 0
    return tmp_path / "top.h5"


@pytest.fixture
def table(run, scene, tmp_path):
    """The table of a sweep, one case of which has no valid scene."""
    (tmp_path / "s.nml").write_text(
        "&sweep scene = 'top.nml', output = 'table.h5' /\n"
        "&parameter name = 'scene.t_end', values = 0.001, 0.002 /\n"
        "&parameter name = 'top.position(3)', column = 'height', values = 0.02, 0.005 /\n"
    )
    assert run("sweep", "s.nml", "-q").status == 0
    return tmp_path / "table.h5"


def parsed(text):
    """Names, units and cells of a CSV text."""
    rows = list(csv.reader(io.StringIO(text, newline="")))
    heads = [re.fullmatch(r"(.*?)(?: \[(.*)\])?", head) for head in rows[0]]
    return [head[1] for head in heads], [head[2] for head in heads], rows[1:]


def bits(values):
    """The bits of doubles."""
    return [struct.pack("<d", value) for value in values]


def test_all_columns_read_back_to_the_same_bits(run, output):
    """Each number of the trajectory, under the name of its data set, body and component."""
    result = run("export", output.name, "--csv")
    assert (result.status, result.err) == (0, "")
    names, units, rows = parsed(result.out)
    assert names[0] == "time"
    assert len(set(names)) == len(names)
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    unit = dict(zip(names, units, strict=True))
    n = 0
    with h5py.File(output) as file:
        group = file["trajectory"]
        for name, data in group.items():
            if data.dtype.kind != "f":
                continue
            labels = [dim[0].asstr()[()] for dim in list(data.dims)[1:]] if data.ndim > 1 else []
            for place in np.ndindex(data.shape[1:]):
                words = [name, *(labels[k][i] for k, i in enumerate(place))]
                column = "_".join(words)
                assert bits(map(float, columns[column])) == bits(data[(slice(None), *place)])
                assert unit[column] == data.attrs["units"]
                n += 1
    assert n == len(names)


@pytest.mark.parametrize(
    ("words", "names"),
    [
        (["gap_stem_floor,time"], ["gap_stem_floor", "time"]),
        (["time", "position_top_z"], ["time", "position_top_z"]),
        (["position"], ["position_top_x", "position_top_y", "position_top_z"]),
        (["TIME , Position_*_Z"], ["time", "position_top_z"]),
        (["gap*"], ["gap_ball_floor", "gap_stem_floor"]),
        (["trajectory/time"], ["time"]),
        (["/trajectory/gap_????_floor"], ["gap_ball_floor", "gap_stem_floor"]),
        (["time,time,t*me"], ["time"]),
        (["events/time,events/kind"], ["time", "kind"]),
        (["contact/name,contact/surfaces"], ["name", "surfaces_A", "surfaces_B"]),
    ],
)
def test_chosen_columns(words, names, run, output):
    """Columns come in the order of the words, each once."""
    options = [option for word in words for option in ("--columns", word)]
    result = run("export", output.name, "--to", "csv", *options)
    assert result.err == ""
    assert parsed(result.out)[0] == names


def test_events_are_a_table_of_their_own(run, output):
    """Texts are cells as they are."""
    _, units, rows = parsed(run("export", output.name, "--csv", "-c", "events/*").out)
    assert units == ["s", None, None]
    with h5py.File(output) as file:
        events = file["events"]
        assert [float(row[0]) for row in rows] == list(events["time"])
        assert [row[1] for row in rows] == list(events["contact"].asstr())
        assert [row[2] for row in rows] == list(events["kind"].asstr())


def test_a_sweep(run, table):
    """Cases, with words for their status and messages, whose commas are quoted."""
    result = run("export", table.name, "--csv")
    assert (result.status, result.err) == (0, "")
    names, units, rows = parsed(result.out)
    assert names[:4] == ["case", "scene.t_end", "height", "status"]
    assert units[:4] == ["1", "s", "m", None]
    assert names[-1] == "message"
    assert [row[3] for row in rows] == ["complete", "invalid_scene"] * 2
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    with h5py.File(table) as file:
        assert list(columns["message"]) == list(file["message"].asstr())
        assert "," in columns["message"][1]
        assert bits(map(float, columns["height"])) == bits(file["parameters/height"])
        assert names[4:-1] == list(file["results"].attrs["columns"])
        fill = file["results/steps"].attrs["_FillValue"]
        steps = ["" if n == fill else str(n) for n in file["results/steps"]]
        assert list(columns["steps"]) == steps
        assert "" in steps


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--columns", "postion"], "has no column 'postion'; did you mean 'position'?"),
        (["--columns", "time,gap_stem_flor"], "did you mean 'gap_stem_floor'?"),
        (["--columns", "kind"], "did you mean 'events/kind'?"),
        (["--columns", "zebra"], "--list lists them"),
        (["--columns", "x*"], "no column of top.h5 matches 'x*'"),
        (["--columns", ","], "--columns needs names of columns"),
        (["--columns", "time,events/kind"], "are of different tables: trajectory/time has 21 rows"),
        (["--to", "cvs"], "unknown format 'cvs'; did you mean 'csv'?"),
    ],
)
def test_what_cannot_be_exported(words, message, run, output, tmp_path):
    """A mistake is told before anything is written."""
    result = run("export", output.name, "--csv", *words, "-o", "out.csv")
    assert result.status == 2
    assert result.out == ""
    assert message in result.err
    assert not (tmp_path / "out.csv").exists()


def test_the_format_is_needed(run, output):
    """It is told by an option, or by the name of the file."""
    result = run("export", output.name)
    assert result.status == 2
    assert result.err.startswith("error: export needs a format: --to csv")
    assert run("export", output.name, "-o", "out.csv").status == 0


def test_files_are_not_replaced(run, output, tmp_path):
    """Neither another file without --force, nor the input with it, under any name."""
    words = ["export", output.name, "--csv", "--columns", "time", "-o"]
    (tmp_path / "out.csv").write_text("mine")
    result = run(*words, "out.csv")
    assert result.status == 74
    assert result.err == (
        "error: out.csv exists; --force replaces it, -o FILE writes another one\n"
    )
    assert (tmp_path / "out.csv").read_text() == "mine"
    assert run(*words, "out.csv", "--force").status == 0
    assert (tmp_path / "out.csv").read_text() == run(*words[:-1]).out
    before = output.read_bytes()
    (tmp_path / "link").hardlink_to(output)
    for name in ["top.h5", "./top.h5", "link"]:
        assert run(*words, name, "--force").status == 2
    assert output.read_bytes() == before
    assert not list(tmp_path.glob("*.part*"))


def test_a_run_that_is_not_complete(run, scene, tmp_path):
    """The rows that there are, with a warning."""
    output = tmp_path / "top.h5"
    assert run("run", scene.name, "-q").status == 0
    with h5py.File(output, "r+") as file:
        file.attrs["status"] = "running"
        file["trajectory/gap"].resize(7, axis=0)
    result = run("export", "top.h5", "--csv", "--columns", "time")
    assert result.status == 0
    assert result.err == "warning: top.h5 is not complete (running); 7 rows\n"
    assert len(result.out.splitlines()) == 8


def test_damage_is_told(run, output, tmp_path):
    """A file with a wrong bit, a truncated one, one that is none."""
    good = output.read_bytes()
    for bad in [
        good[:5000] + bytes([good[5000] ^ 4]) + good[5001:],
        good[: len(good) // 2],
        b"time,position\n",
        b"",
    ]:
        output.write_bytes(bad)
        result = run("export", "top.h5", "--csv", "-o", "out.csv")
        assert result.status in (2, 74)
        assert result.err.startswith("error: ")
        assert "top.h5" in result.err
        assert not (tmp_path / "out.csv").exists()
    assert run("export", "none.h5", "--csv").err == (
        "error: cannot read none.h5: it does not exist\n"
    )


def test_list(run, output):
    """Names, units and meanings, of the table that is exported by default first."""
    lines = run("export", output.name, "--list").out.splitlines()
    assert lines[0] == "trajectory/time has 21 rows; these columns without --columns"
    assert lines[1].split() == ["time", "s", "time"]
    assert re.fullmatch(
        r"  position +m +position_top_x \.\. position_top_z +centre of mass", lines[2]
    )
    assert any(line.startswith("  events/kind ") for line in lines)
