"""`contensou new`: commented scenes to begin with."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

FOLDER = Path(__file__).resolve().parents[2] / "drivers" / "templates"
TEMPLATES = sorted(path.stem for path in FOLDER.glob("*.nml"))

# A run of these to their end takes too long for a test.
SHORTER = {"rattleback": 0.2, "billiards": 0.16, "bearing": 0.002, "tippe_top": 0.5}


def test_the_list_is_in_the_help(run):
    """Every file of the folder is a template, told with its first line."""
    text = run("new", "--help").out
    for name in TEMPLATES:
        first = (FOLDER / f"{name}.nml").read_text().splitlines()[0]
        assert first.startswith("! ")
        assert re.search(rf"^    {name} +{re.escape(first[2:-1])}$", text, re.MULTILINE)
    assert len(TEMPLATES) >= 5
    assert set(TEMPLATES) >= {"tippe_top", "ball", "bearing"}


@pytest.mark.parametrize("name", TEMPLATES)
def test_templates_are_right_and_run(name, run, tmp_path):
    """Each is what the folder holds, has nothing to warn of, and runs."""
    assert run("new", name, "-o", "s.nml").out == ""
    text = (tmp_path / "s.nml").read_text()
    assert text == (FOLDER / f"{name}.nml").read_text()
    assert run("new", name).out == text
    result = run("check", "--strict", "s.nml")
    assert (result.status, result.err) == (0, "")
    shorter = ["--set", f"scene.t_end={SHORTER[name]}"] if name in SHORTER else []
    result = run("run", "--strict", "-q", "s.nml", *shorter)
    assert (result.status, result.out, result.err) == (0, "", "")
    with h5py.File(tmp_path / f"{name}.h5") as file:
        assert file.attrs["status"] == "complete"
        energy = file["trajectory/energy_kinetic"][:] + file["trajectory/work_friction"][:]
        assert np.abs(file["trajectory/energy_error"][:]).max() < 1e-5 * energy.max()


@pytest.mark.parametrize("name", TEMPLATES)
def test_templates_teach(name, run):
    """Units and commands are told, every command that a comment names is one, lines fit."""
    text = run("new", name).out
    assert all(len(line) <= 100 for line in text.splitlines())
    comments = "\n".join(line[line.index("!") :] for line in text.splitlines() if "!" in line)
    for word in re.findall(r"contensou (\w+)", comments):
        assert run(word, "--help").status == 0
    assert "contensou run FILE" in comments
    assert re.search(r"\bin m\b", comments)
    for option in re.findall(r"--set (\S+=\S+)", comments):
        assert run("check", f"{FOLDER}/{name}.nml", "--set", option).status == 0


def test_the_ball_on_the_turntable_goes_round(run, tmp_path):
    """The circle that the comment tells of: its radius stays, its period is 7/2 of the plate's."""
    run("new", "turntable", "-o", "s.nml")
    assert run("run", "s.nml", "-q", "--set", "scene.t_end=4", "-o", "t.h5").status == 0
    with h5py.File(tmp_path / "t.h5") as file:
        time = file["trajectory/time"][:]
        x, y = file["trajectory/position"][:, 1, :2].T
    assert np.allclose(np.hypot(x, y), 0.3, rtol=2e-3)
    assert np.allclose(np.unwrap(np.arctan2(y, x)), 2 / 7 * 3 * time, atol=1e-2)


def test_without_a_name_it_is_the_ball(run):
    """The first of the list."""
    assert run("new").out == run("new", "ball").out


def test_files_are_kept(run, tmp_path):
    """An existing file is replaced with --force only."""
    path = tmp_path / "s.nml"
    path.write_text("mine")
    result = run("new", "ball", "-o", "s.nml")
    assert result.status == 74
    assert "s.nml exists; --force replaces it" in result.err
    assert path.read_text() == "mine"
    assert run("new", "ball", "-o", "s.nml", "--force").status == 0
    assert path.read_text() == run("new", "ball").out
    assert [p.name for p in tmp_path.iterdir()] == ["s.nml"]


@pytest.mark.parametrize(
    ("word", "message"),
    [("tippetop", "did you mean 'tippe_top'?"), ("zebra", "there is no template 'zebra', only")],
)
def test_unknown_template(word, message, run):
    """The nearest one, or all."""
    result = run("new", word)
    assert (result.status, result.out) == (2, "")
    assert message in result.err
    assert ("bearing" in result.err) == (word == "zebra")
