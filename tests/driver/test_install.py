"""What `meson install` puts beside the program: manual pages, completion, plotting, submission."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from programs import captured

COMMANDS = ["new", "run", "check", "export", "sweep", "merge", "diff", "help", "version"]


@pytest.fixture(scope="module")
def prefix(executable, tmp_path_factory):
    """A folder into which the build of the program under test is installed."""
    folder = tmp_path_factory.mktemp("installed")
    command = ["meson", "install", "-C", executable.parents[1], "--no-rebuild", "--destdir", folder]
    if not (executable.parents[1] / "contensou.1").exists():
        pytest.skip("this build makes no manual pages: it has sanitizers")
    done = captured(command)
    assert done.returncode == 0, done.stdout + done.stderr
    (program,) = folder.rglob("bin/contensou")
    return program.parents[1]


def need(name):
    """Skip the test where a program is not there."""
    if shutil.which(name) is None:
        pytest.skip(f"there is no {name}")


@pytest.mark.parametrize("page", ["man1/contensou.1", "man5/contensou-scene.5"])
def test_manual_pages(page, prefix):
    """They are there, and groff and mandoc have nothing to complain about."""
    path = prefix / "share/man" / page
    checked = 0
    if shutil.which("groff"):
        done = captured(["groff", "-man", "-ww", "-Tutf8", str(path)])
        assert (done.returncode, done.stderr) == (0, "")
        checked += 1
    if shutil.which("mandoc"):
        done = captured(["mandoc", "-T", "lint", str(path)])
        # The pages have a version and no date: the same build makes the same bytes.
        assert [line for line in done.stdout.splitlines() if "missing date" not in line] == []
        checked += 1
    assert path.read_text().startswith(".TH CONTENSOU")
    if not checked:
        pytest.skip("there is neither groff nor mandoc")


def test_manual_pages_say_what_help_says(run, prefix):
    """All options of all commands, all keys of all groups."""
    plain = (prefix / "share/man/man1/contensou.1").read_text().replace("\\-", "-")
    for command in COMMANDS:
        assert f".SS contensou {command}" in plain
        for option in re.findall(r"^  (?:-\w, )?(--\w+)", run(command, "--help").out, re.MULTILINE):
            assert f"\\fB{option}\\fR" in plain
    plain = (prefix / "share/man/man5/contensou-scene.5").read_text()
    lines = run("help").out.splitlines()
    for group in (line[1 : line.index(":")] for line in lines if line.startswith("&")):
        assert f"\n.SH &{group}\n" in plain
    for key in (line.split()[0] for line in lines if line.startswith("    ")):
        assert f"\n.B {key}\n" in plain


CASES = [
    (["ex"], {"export"}),
    (["new", ""], {"ball", "tippe_top", "rattleback", "turntable", "billiards", "bearing"}),
    (["new", "b"], {"ball", "billiards", "bearing"}),
    (["run", "--st"], {"--strict"}),
    (["run", "s"], {"scene.nml", "second.nml"}),
    (["run", "scene.nml", "-o", "se"], {"second.nml"}),
    (["export", "a.h5", "--to", "c"], {"csv"}),
    (["export", "a.h5", "--to", "g"], {"gltf"}),
    (["eval", "h"], {"hertz"}),
    (["help", "mate"], {"material"}),
    (["help", "--completion", "z"], {"zsh"}),
]


@pytest.fixture
def folder(tmp_path):
    """A folder with some files."""
    for name in ["scene.nml", "second.nml", "a.h5"]:
        (tmp_path / name).touch()
    return tmp_path


@pytest.mark.parametrize(("words", "expected"), CASES)
def test_bash(words, expected, prefix, folder):
    """The completion of a real bash, asked as the shell asks on a tab."""
    need("bash")
    script = prefix / "share/bash-completion/completions/contensou.bash"
    program = (
        f'source "{script}"; complete -p contensou >/dev/null || exit 3; '
        'COMP_WORDS=(contensou "$@"); COMP_CWORD=$#; _contensou; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    done = captured(["bash", "--norc", "-c", program, "bash", *words], cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert set(done.stdout.split()) == expected


@pytest.mark.parametrize(("words", "expected"), CASES)
def test_fish(words, expected, prefix, folder):
    """The completion of a real fish."""
    need("fish")
    script = prefix / "share/fish/vendor_completions.d/contensou.fish"
    line = " ".join(["contensou", *words])
    environment = dict(os.environ, HOME=str(folder), XDG_CONFIG_HOME=str(folder / "c"))
    command = ["fish", "-N", "-c", f"source {script}; complete -C '{line}'"]
    done = captured(command, cwd=folder, env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    assert {line.split("\t")[0] for line in done.stdout.splitlines()} == expected


@pytest.mark.parametrize(("words", "expected"), CASES)
def test_zsh(words, expected, prefix, folder):
    """The completion of a real zsh, on a terminal of its own."""
    need("zsh")
    (folder / "rc").mkdir()
    (folder / "rc/.zshrc").write_text(
        f"fpath=({prefix}/share/zsh/site-functions $fpath)\n"
        "autoload -Uz compinit && compinit -u -D\n"
        "zmodload zsh/zpty\n"
        "PS1='' PROMPT2='' RPS1=''\n"
        "zstyle ':completion:*' list-colors ''\n"
        "null-line() { zle kill-whole-line }\n"
        "bindkey '^I' complete-word\n"
        "compadd() {\n"
        '   local -a hits; builtin compadd -O hits "$@"\n'
        "   (( $#hits )) && print -rl -- $hits >>$FOLDER/found\n"
        '   builtin compadd "$@"\n'
        "}\n"
    )
    line = " ".join(["contensou", *words])
    program = (
        "zmodload zsh/zpty; zpty z zsh -i; zpty -w z 'print rea''dy'; zpty -r z out '*ready*'; "
        f"zpty -n -w z $'{line}\\t'; for i in {{1..500}}; do "
        "[[ -s $FOLDER/found ]] && break; sleep 0.1; done; sleep 0.2; zpty -d z"
    )
    environment = dict(os.environ, ZDOTDIR=str(folder / "rc"), FOLDER=str(folder / "rc"))
    command = ["zsh", "-f", "-c", program]
    subprocess.run(command, cwd=folder, env=environment, check=False, timeout=120)
    found = folder / "rc/found"
    assert found.exists()
    hits = {hit.replace("\\", "") for hit in found.read_text().split()}
    assert expected <= hits
    assert all(hit.startswith(words[-1]) for hit in hits if hit not in expected)


def test_plotting(run, scene, prefix, tmp_path):
    """The installed program draws a run, with a Python of the user's."""
    assert run("run", scene.name, "-q").status == 0
    program = prefix / "bin/contensou-plot"
    assert os.access(program, os.X_OK)
    done = captured([sys.executable, program, "top.h5"], cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "top.png\n", "")
    assert (tmp_path / "top.png").read_bytes().startswith(b"\x89PNG")
    usage = captured([sys.executable, program, "--help"]).stdout
    assert usage.startswith("usage: contensou-plot ")
    assert not list(prefix.rglob("__pycache__"))


def test_plotting_says_what_it_needs(prefix, tmp_path):
    """Without h5py or matplotlib it names what is missing, and how to get it."""
    for tool, wanted in (("plot", "h5py matplotlib"), ("view", "h5py"), ("video", "h5py pillow")):
        command = [sys.executable, "-S", "-I", prefix / f"bin/contensou-{tool}", "top.h5"]
        done = captured(command, cwd=tmp_path)
        assert done.returncode == 2
        assert f"has no {wanted.replace(' ', ' and no ')}, which contensou-{tool}" in done.stderr
        assert f"{sys.executable} -m pip install {wanted} (" in done.stderr
        assert "Traceback" not in done.stderr


def test_viewing(run, scene, prefix, tmp_path):
    """The installed program writes the page of a run."""
    assert run("run", scene.name, "-q").status == 0
    program = prefix / "bin/contensou-view"
    assert os.access(program, os.X_OK)
    done = captured([sys.executable, program, "top.h5"], cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "top.html\n", "")
    assert (tmp_path / "top.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    usage = captured([sys.executable, program, "--help"]).stdout
    assert usage.startswith("usage: contensou-view ")


def test_exporting(run, scene, prefix, tmp_path):
    """The installed program finds its tool beside it, which takes the user's Python."""
    assert run("run", scene.name, "-q").status == 0
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    command = [prefix / "bin/contensou", "export", "top.h5", "--to", "gltf"]
    done = captured(command, cwd=tmp_path, env=os.environ | {"PATH": path})
    assert (done.returncode, done.stdout, done.stderr) == (0, "top.glb\n", "")
    assert (tmp_path / "top.glb").read_bytes().startswith(b"glTF")


def test_submission(scene, prefix, tmp_path):
    """The installed script finds the installed program, and the script of a task beside it."""
    (tmp_path / "s.nml").write_text(
        "&sweep scene = 'top.nml', output = 't.h5' /\n"
        "&parameter name = 'top.mass', values = 6e-3, 7e-3 /\n"
    )
    environment = {k: v for k, v in os.environ.items() if k != "CONTENSOU"}
    program = prefix / "bin/contensou-submit"
    command = [program, "--engine", "slurm", "--dry-run", "--shards", "2", "s.nml"]
    done = captured(command, cwd=tmp_path, env=environment)
    assert done.returncode == 0, done.stderr
    assert f"CONTENSOU={prefix}/bin/contensou sbatch " in done.stdout
    task = re.search(r"(\S+/sweep\.sh) 2 s\.nml", done.stdout)[1]
    assert os.access(task, os.X_OK)
    assert Path(task).is_relative_to(prefix)
    usage = captured([program, "--help"]).stdout
    assert "contensou-submit [OPTION...] SWEEP.nml" in usage
