"""Pictures of runs: what moves is drawn, noise is not, and many bodies are summarised."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

mpl.use("Agg")

from lib import drawing, motion, style  # noqa: E402
from lib.results import Result  # noqa: E402


def readme_ball() -> str:
    """The scene in the README."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return text.split("```fortran\n", 1)[1].split("```", 1)[0]


@pytest.fixture
def drawn(run, tmp_path):
    """Run a scene and draw it: panels by title, as lists of axes."""
    figures = []

    def draw(scene: str, *more: str) -> dict[str, list]:
        (tmp_path / "scene.nml").write_text(scene)
        result = run("run", "scene.nml", "-q", "-o", "out.h5", "--force", *more, cwd=tmp_path)
        assert result.status == 0, result.err
        figure = drawing.draw(Result(tmp_path / "out.h5"))
        figures.append(figure)
        panels = {}
        for axes in figure.axes:
            panels.setdefault(axes.get_title("left") or axes.get_title(), []).append(axes)
        return panels

    yield draw
    for figure in figures:
        plt.close(figure)


def lines(axes) -> dict[str, np.ndarray]:
    """The curves of a panel by their labels."""
    return {
        line.get_label(): np.asarray(line.get_ydata(), dtype=float)
        for line in axes.get_lines()
        if len(line.get_ydata()) > 2
    }


def test_what_moves_is_drawn(drawn):
    """The ball of the README spins down about y, falls along z, and leaves along x."""
    panels = drawn(readme_ball(), "--set", "scene.t_end=0.5")
    (spin,) = panels["Angular velocity"]
    assert list(lines(spin)) == ["y"]
    rate = lines(spin)["y"]
    assert rate[0] == 50.0
    assert 13.0 < rate[-1] < 16.0
    assert spin.get_ylabel() == "ω [rad/s]"
    (position,) = panels["Position of the centre of mass"]
    assert list(lines(position)) == ["x", "z"]
    assert position.get_ylabel() == "x, z [mm]"
    assert np.ptp(lines(position)["z"]) > 400.0
    (speed,) = panels["Speed of the centre of mass"]
    assert 3.0 < lines(speed)["ball"].max() < 3.2
    # A ball has no axis whose inclination could be told.
    assert not any("Inclination" in title for title in panels)
    (path,) = panels["Path, seen from the side"]
    assert (path.get_xlabel(), path.get_ylabel()) == ("x [mm]", "z [mm]")


def test_names_are_drawn_as_they_stand(drawn, tmp_path):
    """Formulas, controls, characters without a glyph and long names are names all the same."""
    wild = "_b$\\frac{1$ \x1b[2J \u7403 " + 300 * "n"
    panels = drawn(
        readme_ball()
        .replace("'bouncing ball'", "'costs $5 or $6^{, \x1b[31m'")
        .replace("name = 'ball_floor'", f"name = '{wild}'"),
        "--set", "scene.t_end=0.5",
    )  # fmt: skip
    (gap,) = panels["Contact indicators"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        style.save(gap.figure, tmp_path / "out.png")
    (legend,) = [text.get_text() for text in gap.get_legend().get_texts()][:1]
    assert r"b\$\frac{1\$ \x1b[2J" in legend
    assert len(legend) < 80


def test_energies_are_changes(drawn):
    """All terms begin at zero, and their sum stays there."""
    panels = drawn(readme_ball(), "--set", "scene.t_end=0.5")
    (energy,) = panels["Energy balance"]
    curves = lines(energy)
    assert all(values[0] == 0.0 for values in curves.values())
    total = next(values for label, values in curves.items() if label.startswith("sum"))
    assert np.abs(total).max() < 1e-5 * max(np.abs(values).max() for values in curves.values())


def test_work_supplied_is_drawn(drawn):
    """The balance of a driven body closes with the work supplied, which has a curve."""
    scene = """\
&scene title = 'driven', t_end = 0.01 /
&material name = 'm', young = 1e9, poisson = 0.3 /
&body name = 'ball', mass = 0.1, inertia = 3*1e-5, position = 0, 0, 0.00999 /
&body name = 'table', motion = 'prescribed', velocity = 1, 0, 0 /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 0.01, material = 'm' /
&surface name = 'top', body = 'table', shape = 'plane', normal = 0, 0, 1, material = 'm' /
&contact name = 'c', surfaces = 'ball', 'top', friction = 'contensou_exact',
         friction_coefficient = 0.3 /
&output interval = 1e-4 /
"""
    (energy,) = drawn(scene)["Energy balance"]
    curves = lines(energy)
    assert any(label.startswith("less work supplied") for label in curves)
    total = next(values for label, values in curves.items() if label.startswith("sum"))
    assert np.abs(total).max() < 1e-4 * max(np.abs(values).max() for values in curves.values())


def test_noise_does_not_fill_a_panel(drawn):
    """A top that stands upright but for rounding has no panel of its inclination, and a panel is
    not spread over a billionth of what it shows."""
    figure, axes = plt.subplots()
    noise = 5.0 + 1e-9 * np.sin(np.arange(100.0))
    axes.plot(noise)
    style.hold_scale(axes, 5.0)
    low, high = axes.get_ylim()
    assert high - low > 0.1
    plt.close(figure)
    values = np.zeros((50, 1, 3))
    values[:, 0, 0] = np.linspace(0, 1, 50)
    values[:, 0, 1] = 1e-9 * np.cos(np.arange(50.0))
    assert motion.moving(values).tolist() == [[True, False, False]]
    assert motion.moving(0.0 * values).tolist() == [[False, False, False]]


def test_many_bodies_are_summarised(drawn):
    """Twelve falling balls and a cart: a band for what is alike, a line for what is not."""
    scene = "&scene title = 'rain', gravity = 0, 0, -9.81, t_end = 0.1 /\n"
    scene += "&body name = 'cart', mass = 1, inertia = 3*1, velocity = 1, 0, 0 /\n"
    scene += "".join(
        f"&body name = 'drop_{i}', mass = 1, inertia = 3*1, position = {i}, 0, {i} /\n"
        for i in range(1, 13)
    )
    panels = drawn(scene + "&output interval = 0.01 /\n")
    height = panels["Position of the centre of mass"][-1]
    assert height.get_ylabel().startswith("z")
    assert set(lines(height)) == {"cart", "drop_* (12), median"}
    assert len(height.collections) == 1
    assert motion.groups(["a", "b"]) == [("a", [0]), ("b", [1])]
    assert motion.groups([f"n{i}" for i in range(9)]) == [("n* (9)", list(range(9)))]
    unlike = [letter * 3 for letter in "abcdefghij"]
    assert motion.groups(unlike) == [("all 10", list(range(10)))]


@pytest.mark.parametrize(
    ("span", "labels"),
    [((0.5, 0.9), {"0.6", "0.8"}), ((0.01, 100.0), {"0.01", "0.1", "1", "10", "100"})],
)
def test_logarithmic_axes_have_plain_numbers(span, labels):
    """0.6 and not 6 x 10^-1; powers of ten where zeros get many."""
    figure, axes = plt.subplots()
    axes.plot(span, span)
    style.log_scale(axes.yaxis)
    axes.set_ylim(*span)
    figure.canvas.draw()
    ticks = axes.yaxis.get_major_ticks() + axes.yaxis.get_minor_ticks()
    shown = {tick.label1.get_text() for tick in ticks} - {""}
    assert labels <= shown
    assert not any("10^" in label for label in shown)
    axes.set_ylim(1e-9, 1.0)
    figure.canvas.draw()
    shown = {tick.label1.get_text() for tick in axes.yaxis.get_major_ticks()}
    assert any("10^{-8}" in label or "10^{-6}" in label for label in shown)
    plt.close(figure)
