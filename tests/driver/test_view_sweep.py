"""Pages that show the table of a sweep: a point that is clicked tells its row and its command."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from lib import browser, sweeping  # noqa: E402

needs_browser = pytest.mark.skipif(browser.PROGRAM is None, reason="there is no Chromium")

HOSTILE = "</script><script>window.struck=1</script><img src=x onerror='struck=1'>"
SCENE = """\
&scene title = {title}, gravity = 0, 0, -9.81, t_end = 0.2 /
&material name = 'rubber', young = 1e7, poisson = 0.4 /
&body name = 'ball', mass = 0.05, inertia = 3*8e-6, position = 0, 0, 0.03, spin = 0, 5, 0 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.02, material = 'rubber' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'rubber' /
&contact name = 'bounce', surfaces = 'skin', 'floor', damping = 'hunt_crossley',
   restitution = 0.8, impact_velocity = 1, friction = 'coulomb', friction_coefficient = 0.3,
   regularization_velocity = 1e-3 /
&output interval = 1e-2 /
"""
SWEEP = """\
&sweep scene = 'ball.nml', trajectories = 2, 10, ! the "set = 'no'" of a comment
   set = 'scene.t_end = 0.15', "integrator.rtol = 1e-7" /
&parameter name = 'ball.mass', vary = 'log', first = 0.01, last = 1, count = 3, column = 'mass' /
&parameter name = 'bounce.friction', values = 'coulomb', 'pade22', column = 'law' /
&parameter name = 'ball.position(3)', values = -0.5, 0.03, column = 'height' /
"""


@pytest.fixture
def table(run, tmp_path):
    """A table of twelve cases, of which six are no valid scenes, beside two whole runs."""
    (tmp_path / "ball.nml").write_text(SCENE.format(title="'" + HOSTILE.replace("'", "''") + "'"))
    (tmp_path / "mass.nml").write_text(SWEEP)
    done = run("sweep", "mass.nml", "-q", "-j", "1", "--set", "bounce.restitution=0.7")
    assert (tmp_path / "mass.h5").exists(), done.err
    return tmp_path / "mass.h5"


def write(table):
    """The page of a table, by the command."""
    done = subprocess.run(
        [ROOT / "scripts" / "view", table.name],
        cwd=table.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return table.with_suffix(".html")


@needs_browser
def test_a_point_tells_its_row_and_its_command(run, table, tmp_path):
    page = write(table)
    text = page.read_text()
    assert "struck" not in text
    assert len(text) < 1e5
    program = browser.Browser()
    try:
        program.open(page)
        assert program.value("document.getElementById('title').textContent") == HOSTILE
        # Across and up are chosen as a user would, so that each case has a place of its own.
        for name, column in (("x", "case"), ("y", "mass")):
            program.value(
                f"(s => {{ s.value = [...s.options].find(o => o.text === '{column}').value;"
                f"s.dispatchEvent(new Event('change')); }})(document.getElementById('{name}'))"
            )
        corner = program.value(
            "(r => [r.x, r.y])(document.getElementById('points').getBoundingClientRect())"
        )
        places = np.array(program.value("[...contensou.places()]")).reshape(-1, 2)
        places += np.array(corner)
        with h5py.File(table) as file:
            status, cases = file["status"][()], file["case"][()]
            columns = {**file["parameters"], **file["results"]}
            columns = {
                name: data.asstr()[()] if data.dtype.kind == "O" else data[()]
                for name, data in columns.items()
            }
            messages = file["message"].asstr()[()]
        assert set(status) >= {0, 2}
        for i, place in enumerate(places):
            program.drag(tuple(place), tuple(place))
            said = program.value(
                "['case', 'said', 'command'].map(id => document.getElementById(id).textContent)"
            )
            assert said[0] == f"Case {cases[i]}"
            assert said[1].startswith(("complete", "failed", "invalid scene")[status[i]])
            assert messages[i] in said[1]
            row = dict(
                program.value(
                    "[...document.querySelectorAll('dt')].map(t => [t.textContent,"
                    "t.nextSibling.textContent])"
                )
            )
            for name, values in columns.items():
                shown = row[name.replace("_", " ")]
                if isinstance(values[i], str):
                    assert shown == values[i]
                elif np.isnan(values[i]):
                    assert shown == "none"
                else:
                    assert float(shown.split()[0]) == pytest.approx(values[i], rel=1e-6)
            if cases[i] in (2, 9, 10):
                words = shlex.split(said[2])
                assert words[0] == "contensou"
                done = run(*words[1:], "-q")
                assert done.status == status[i], done.err
                if not status[i]:
                    same = run("diff", words[-1], table.name.replace(".h5", f"_case_{cases[i]}.h5"))
                    assert same.status == 0, same.out
        # Keys go on to the next case, and a small picture to the case that it shows.
        program.value("contensou.choose(0)")
        program.value("document.getElementById('points').focus()")
        program.key("ArrowRight")
        assert program.value("contensou.state.at") == 1
        program.click("#many button")
        assert program.value("contensou.state.at") == 1  # case 2
        light = program.picture()[5, 5].sum()
        program.click("#theme")
        assert light - program.picture()[5, 5].sum() > 300
        assert program.value("window.struck ?? 0") == 0
        assert program.value("document.images.length") == 0
        assert program.complaints == []
        assert program.asked == [page.as_uri()]
    finally:
        program.close()


def test_many_cases_become_few(tmp_path, table, monkeypatch):
    monkeypatch.setattr(sweeping, "MOST_CASES", 5)
    page = sweeping.view(table)
    assert len(page) < 1e5
    assert re.search(r'id="data">[^<]+<', page)


def test_tables_that_cannot_be_shown(table):
    data = bytearray(table.read_bytes())
    data[len(data) // 2] ^= 4
    (table.parent / "broken.h5").write_bytes(data)
    done = subprocess.run(
        [ROOT / "scripts" / "view", "broken.h5"],
        cwd=table.parent, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 74
    assert done.stderr.startswith("error: broken.h5 is damaged")
    assert not (table.parent / "broken.html").exists()
    assert done.stdout == ""


@needs_browser
def test_what_is_drawn_first(run, tmp_path):
    """A result that differs, and of those what the sweep asks for; words colour it. A click on
    cases at one place tells one after the other."""
    (tmp_path / "ball.nml").write_text(SCENE.format(title="'ball'"))
    (tmp_path / "laws.nml").write_text(
        "&sweep scene = 'ball.nml' /\n"
        "&parameter name = 'bounce.friction', values = 'none', 'coulomb', column = 'law' /\n"
        "&parameter name = 'ball.mass', values = 0.02, 0.05, 0.1, column = 'mass' /\n"
        "&value name = 'late_spin', dataset = 'angular_velocity', of = 'ball', component = 2, "
        "time = 0.2 /\n"
    )
    done = run("sweep", "laws.nml", "-q", "-j", "1")
    assert done.status == 0, done.err
    program = browser.Browser()
    try:
        program.open(write(tmp_path / "laws.h5"))
        chosen = "['x', 'y', 'c'].map(id => document.getElementById(id).selectedOptions[0].text)"
        assert program.value(chosen) == ["mass", "late_spin", "law"]
        program.value(
            "(s => { s.value = document.getElementById('x').value;"
            "s.dispatchEvent(new Event('change')); })(document.getElementById('y'))"
        )
        corner = program.value(
            "(r => [r.x, r.y])(document.getElementById('points').getBoundingClientRect())"
        )
        places = np.array(program.value("[...contensou.places()]")).reshape(-1, 2)
        together = np.flatnonzero(np.linalg.norm(places - places[0], axis=1) < 1)
        assert len(together) == 2
        place = tuple(places[0] + np.array(corner))
        said = []
        for _ in range(3):
            program.drag(place, place)
            said.append(program.value("contensou.state.at"))
        assert said[0] == said[2] != said[1]
        assert set(said) == set(together.tolist())
        assert program.complaints == []
    finally:
        program.close()
