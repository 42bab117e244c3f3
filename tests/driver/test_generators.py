"""The tables of coefficients in the sources are those that their scripts compute.

A script finds the table from its own place, so that a copy of it in another folder leaves the
project alone. The tables do not depend on the build; the longer work is done for the release alone.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from programs import captured


@dataclass(frozen=True)
class Generator:
    """A script in a folder of its own, and the place of its table there."""

    script: Path
    table: Path

    def run(self, *words) -> subprocess.CompletedProcess:
        """Run the script."""
        return captured(
            [sys.executable, str(self.script), *map(str, words)],
            timeout=600,
        )


@pytest.fixture
def generator(root, tmp_path):
    """Function from the names of a script and its table to a copy of both."""

    def copy(script: str, table: str) -> Generator:
        copied = Generator(tmp_path / script, tmp_path / table)
        for path in (script, table):
            (tmp_path / path).parent.mkdir(parents=True)
            shutil.copyfile(root / path, tmp_path / path)
        return copied

    return copy


@pytest.fixture
def elliptic(generator):
    """The generator of the tables of the elliptic integrals."""
    return generator("scripts/generate_elliptic.py", "src/special/elliptic_tables.f90")


@pytest.fixture
def hertz(generator):
    """The generator of the tables of the Hertz contact."""
    return generator("scripts/generate_hertz.py", "src/contact/hertz_tables.f90")


@pytest.fixture
def slender(generator):
    """The generator of the table of the chords of a slender spot."""
    return generator("scripts/generate_slender.py", "src/contact/wrench_slender_values.f90")


@pytest.fixture
def strip(generator):
    """The generator of the table of the theory of strips."""
    return generator("scripts/generate_strip.py", "src/contact/creep/strip_values.f90")


@pytest.fixture
def circle(generator):
    """The generator of the table of sliding of circular spots."""
    return generator("scripts/generate_circle.py", "src/contact/tangential/circle_values.f90")


@pytest.fixture
def ellipse(generator):
    """The generator of the table of sliding of elliptic spots."""
    return generator("scripts/generate_ellipse.py", "src/contact/tangential/ellipse_values.f90")


@pytest.fixture
def limit(generator):
    """The generator of the limits of shells, about."""
    return generator("scripts/generate_limit.py", "src/contact/tangential/limit_values.f90")


def change_digits(table: Path) -> None:
    """Change the last digit of some number in each line of the table."""
    text = table.read_text(encoding="utf-8")
    changed = re.sub(
        r"(\.\d*)(\d)((?:[eE][-+]?\d+)?_wp,? &)$",
        lambda m: f"{m[1]}{(int(m[2]) + 5) % 10}{m[3]}",
        text,
        flags=re.MULTILINE,
    )
    assert changed != text
    table.write_text(changed, encoding="utf-8")


def test_elliptic_tables_are_what_is_generated(elliptic):
    checked_in = elliptic.table.read_bytes()
    elliptic.table.unlink()
    done = elliptic.run()
    assert done.returncode == 0, done.stderr
    assert elliptic.table.read_bytes() == checked_in


def test_elliptic_tables_are_checked(elliptic):
    change_digits(elliptic.table)
    done = elliptic.run("--check")
    assert done.returncode == 1
    assert "differs" in done.stdout + done.stderr


def test_table_of_slender_spots_is_what_is_generated(slender):
    text = slender.table.read_text(encoding="utf-8")
    for seed in (1, 2):
        done = slender.run("--check", "--seed", seed)
        assert done.returncode == 0, done.stdout + done.stderr
    # The last digit is that of the linear algebra at hand.
    done = slender.run()
    assert done.returncode == 0, done.stderr
    number = re.compile(r"-?\d+\.\d+(?=_wp)")
    written = slender.table.read_text(encoding="utf-8")
    assert number.sub("", written) == number.sub("", text)
    slender.table.write_text(re.sub(r"\d(\d{4}_wp)", r"7\1", text, count=3), encoding="utf-8")
    done = slender.run("--check")
    assert done.returncode == 1
    assert "differs" in done.stdout


def test_hertz_tables_are_what_is_generated(hertz, build_kind):
    if build_kind != "release":
        done = hertz.run("--check", "--segments", 10)
        assert done.returncode == 0, done.stdout + done.stderr
        return
    checked_in = hertz.table.read_bytes()
    hertz.table.unlink()
    done = hertz.run()
    assert done.returncode == 0, done.stderr
    assert hertz.table.read_bytes() == checked_in


def test_hertz_tables_are_checked(hertz):
    done = hertz.run("--check", "--segments", 3, "--seed", 2)
    assert done.returncode == 0, done.stdout + done.stderr
    change_digits(hertz.table)
    done = hertz.run("--check", "--segments", 3, "--seed", 2)
    assert done.returncode == 1
    assert "differs" in done.stdout + done.stderr


def test_table_of_strips_is_what_is_generated(strip):
    checked_in = strip.table.read_bytes()
    strip.table.unlink()
    done = strip.run()
    assert done.returncode == 0, done.stderr
    assert strip.table.read_bytes() == checked_in


def test_table_of_strips_is_checked(strip):
    done = strip.run("--check")
    assert done.returncode == 0, done.stdout + done.stderr
    change_digits(strip.table)
    done = strip.run("--check")
    assert done.returncode == 1
    assert "differs" in done.stdout + done.stderr


def test_table_of_circles_is_what_is_generated(circle):
    checked_in = circle.table.read_bytes()
    circle.table.unlink()
    done = circle.run()
    assert done.returncode == 0, done.stderr
    assert circle.table.read_bytes() == checked_in


def test_table_of_circles_is_checked(circle):
    done = circle.run("--check")
    assert done.returncode == 0, done.stdout + done.stderr
    change_digits(circle.table)
    done = circle.run("--check")
    assert done.returncode == 1
    assert "differs" in done.stdout + done.stderr


def test_table_of_ellipses_is_what_is_generated(ellipse):
    checked_in = ellipse.table.read_bytes()
    ellipse.table.unlink()
    done = ellipse.run()
    assert done.returncode == 0, done.stderr
    assert ellipse.table.read_bytes() == checked_in


def test_table_of_ellipses_is_checked(ellipse, build_kind):
    if build_kind == "release":
        done = ellipse.run("--check")
        assert done.returncode == 0, done.stdout + done.stderr
    change_digits(ellipse.table)
    done = ellipse.run("--check")
    assert done.returncode == 1
    assert "differs" in done.stdout + done.stderr


def test_limits_of_shells_are_what_is_generated(limit):
    text = limit.table.read_text(encoding="utf-8")
    done = limit.run("--check")
    assert done.returncode == 0, done.stdout + done.stderr
    limit.table.write_text(re.sub(r"\d(\d_wp)", r"7\1", text, count=3), encoding="utf-8")
    done = limit.run("--check")
    assert done.returncode == 1
    assert "differs" in done.stdout
