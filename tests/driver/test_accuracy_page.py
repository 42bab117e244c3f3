"""docs/accuracy.md holds the pictures and the tables that scripts/lib/figures_accuracy.py makes."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import h5py
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
pytest.importorskip("matplotlib")

from lib import explicit_libraries, figures_accuracy, work_precision  # noqa: E402

PAGE = (ROOT / "docs" / "accuracy.md").read_text(encoding="utf-8")
TABLES = figures_accuracy.tables_of(PAGE)


def cells(line: str) -> list[str]:
    """The cells of a row."""
    return [cell.strip() for cell in line.strip("|").split("|")]


def first_column(lines: list[str]) -> list[str]:
    """What stands on the left below the head."""
    return [cells(line)[0] for line in lines[2:]]


def test_the_page_has_every_table_and_no_other():
    assert list(TABLES) == figures_accuracy.table_names()
    for name, lines in TABLES.items():
        assert len(lines) >= 3, name
        assert {len(cells(line)) for line in lines} == {len(cells(lines[0]))}, name
        assert set(cells(lines[1])) == {"---"}, name


@pytest.mark.parametrize("scene", figures_accuracy.SCENES, ids=lambda scene: scene.name)
def test_the_tables_are_of_the_script_s_form(scene, run, tmp_path, build_kind):
    """A shorter study of the scene gives tables with the same heads and rows."""
    if build_kind != "release":
        pytest.skip("what a script makes of a table is the same with each build")
    with_shorter = [
        *scene.settings,
        "scene.t_end=2e-5",
        "cost.samples=2",
        "cost.repeats=1",
        "cost.reference_rtol=1e-11",
    ]
    words = [word for setting in with_shorter for word in ("--set", setting)]
    result = run("cost", ROOT / "inputs" / scene.file, "-q", "-o", "study.h5", *words)
    assert result.status == 0, result.err
    study = work_precision.read(tmp_path / "study.h5")
    with h5py.File(tmp_path / "study.h5") as file:
        made = {
            "runs": figures_accuracy.runs_table(study),
            "models": figures_accuracy.models_table(file),
            "cheapest": figures_accuracy.cheapest_table(study),
        }
    for kind, lines in made.items():
        shown = TABLES[f"{scene.name}_{kind}"]
        assert shown[:2] == lines[:2]
        assert first_column(shown) == first_column(lines)
    number = r"\d\.\de[-+]\d\d in [\d.e-]+ s"
    for line in TABLES[f"{scene.name}_runs"][2:]:
        for cell in cells(line)[1:]:
            assert re.fullmatch(rf"{number}|given up", cell), cell


def test_the_jacobian_table_has_every_scene():
    shown = first_column(TABLES["jacobian"])
    assert shown == [*sorted(path.stem for path in (ROOT / "inputs").glob("*.nml")), "all"]
    lines = TABLES["jacobian"][2:]
    counts = [[cells(line)[i] for i in (2, 3, 4, 5, 6, 8, 9)] for line in lines]
    rows = [list(map(int, row)) for row in counts]
    assert [sum(column) for column in zip(*rows[:-1], strict=True)] == rows[-1]
    for line, (steps, ours, jacobians, *differences) in zip(lines, rows, strict=True):
        assert 0 < jacobians < steps <= ours, line
        for i, (other_steps, other) in ((7, differences[:2]), (10, differences[2:])):
            assert float(cells(line)[i]) == pytest.approx(other / ours, abs=0.006), line
            assert ours < other, line
            assert other_steps < other, line


def test_the_table_of_libraries_has_every_method_and_bound():
    names = [*explicit_libraries.METHODS.values(), explicit_libraries.WHOLE_RUN_NAME]
    rows = [cells(line) for line in TABLES["explicit_libraries"][2:]]
    bounds = [f"{bound:.0e}" for bound in explicit_libraries.BOUNDS]
    assert [row[:2] for row in rows] == [[bound, name] for bound in bounds for name in names]
    bare = {row[0]: float(row[6]) for row in rows if row[1] == names[0]}
    for bound, _, rtol, error, steps, right_hand_sides, cpu, ratio in rows:
        assert 0.0 < float(error) <= float(bound)
        assert 0.0 < float(rtol) <= 1e-5
        assert 12 * int(steps) < int(right_hand_sides)
        # Both times and the ratio are rounded.
        assert float(ratio) == pytest.approx(float(cpu) / bare[bound], rel=3e-3, abs=1e-2)


def test_the_page_shows_the_pictures():
    shown = re.findall(r"!\[[^]]*\]\((accuracy_\w+\.png)\)", PAGE)
    assert shown == [f"accuracy_{scene.name}.png" for scene in figures_accuracy.SCENES]
    for name in shown:
        picture = (ROOT / "docs" / name).read_bytes()
        assert picture.startswith(b"\x89PNG")
        assert len(picture) < 250_000, name


def test_new_tables_replace_the_old_ones_and_nothing_else():
    new = {"jacobian": ["| a |", "|---|", "| 1 |"]}
    page = figures_accuracy.with_tables(PAGE, new)
    assert figures_accuracy.tables_of(page) == {**TABLES, **new}
    assert figures_accuracy.with_tables(page, TABLES) == PAGE
