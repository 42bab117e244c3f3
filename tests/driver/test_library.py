"""The installed library: the programs of docs/library.md, built outside of the tree and run.

The static library is that of the release build under test, installed to a folder of the tests; the
shared one comes from a build of its own without optimization.
"""

from __future__ import annotations

import math
import os
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(fortran|c)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
COMMANDS = dict(zip(("fortran", "c"), re.findall(r"^\$ (.*) && \./", PAGE, re.M), strict=True))
SUFFIXES = {"fortran": "f90", "c": "c"}
STRICT = {
    "fortran": "-std=f2018 -Wall -Wextra -Wimplicit-interface -Wno-unused-dummy-argument -Werror",
    "c": "-std=c11 -Wall -Wextra -pedantic -Werror",
}
MOST_LINES = {"fortran": 15, "c": 40}
SETTINGS = re.compile(r'"((?:scene|output)\.[^"]*)"')
NUMBER = re.compile(r"-?\d+\.\d+")


def called(words, folder, env=None, **more):
    """What a command that must succeed leaves."""
    done = captured(words, cwd=folder, env=env, timeout=600, **more)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done


def program_of(language: str) -> str:
    """The program of a language on the page: the text that can be run."""
    (text,) = (
        text
        for kind, text in BLOCKS
        if kind == language and re.search(r"^program |int main\(", text, re.MULTILINE)
    )
    return text


@pytest.fixture(scope="module", params=["static", "shared"])
def installed(request, executable, build_kind, tmp_path_factory):
    """A folder below which a library is installed, and the environment that finds it."""
    if build_kind != "release":
        pytest.skip("with the release build only")
    folder = tmp_path_factory.mktemp(request.param)
    build = executable.parents[1]
    if request.param == "shared":
        build = folder / "build"
        options = ("--buildtype=debug", "-Doptimization=0", "-Ddebug=false", "-Dtests=false")
        called(["meson", "setup", "-Ddefault_library=shared", *options, build, ROOT], folder)
        called(["ninja", "-C", build], folder)
    folder = folder / "installed"
    called(["meson", "install", "-C", build, "--no-rebuild", "--destdir", folder], build)
    (described,) = folder.rglob("pkgconfig/contensou.pc")
    prefix = re.search(r"^prefix=(.*)$", described.read_text(), re.MULTILINE)[1]
    described.write_text(
        described.read_text().replace(f"prefix={prefix}", f"prefix={folder}{prefix}", 1)
    )
    environment = {
        **os.environ,
        "PKG_CONFIG_PATH": str(described.parent),
        "LD_LIBRARY_PATH": str(described.parents[1]),
    }
    return folder, environment


@pytest.fixture
def built(installed, tmp_path):
    """Build a program of the page, outside of the tree, with its scene beside it."""

    def build_it(language, text):
        (tmp_path / f"tippe_top.{SUFFIXES[language]}").write_text(text)
        shutil.copy(ROOT / "inputs" / "tippe_top.nml", tmp_path)
        command = COMMANDS[language] + " " + STRICT[language]
        called(["bash", "-c", command], tmp_path, installed[1])
        return tmp_path / "tippe_top"

    return build_it


def test_one_module_and_one_header_are_installed(installed):
    folder, _ = installed
    (module,) = folder.rglob("*.mod")
    version = called(["gfortran", "-dumpversion"], folder).stdout.split(".")[0].strip()
    assert module.parts[-3:] == ("contensou", f"gfortran-{version}", "contensou.mod")
    assert [header.name for header in folder.rglob("include/contensou/*.h")] == ["contensou.h"]


def functions_of_the_header() -> set[str]:
    """Names of the functions that the header declares and the library has."""
    text = (ROOT / "include" / "contensou.h").read_text(encoding="utf-8")
    text = re.sub(r"/\*.*?\*/|typedef int .*?;", "", text, flags=re.DOTALL)
    inline = "contensou_simulation_from_text"
    return set(re.findall(r"\b(contensou_\w+)\(", text)) - {inline}


def test_symbols(installed):
    """All have the prefix of the project; the shared library shows of C what the header has."""
    folder, _ = installed
    (library,) = (path for path in folder.rglob("libcontensou.*") if not path.is_symlink())
    dynamic = [] if library.suffix == ".a" else ["-D"]
    words = ["nm", "-g", "--defined-only", *dynamic, library]
    lines = [line.split() for line in called(words, folder).stdout.splitlines()]
    names = {line[-1] for line in lines if len(line) == 3}
    assert not {name for name in names if not re.match(r"(__)?contensou_", name)}
    of_c = {name for name in names if name.startswith("contensou_")}
    assert functions_of_the_header() <= of_c
    assert len(functions_of_the_header()) > 60
    if dynamic:
        assert of_c == functions_of_the_header()
        assert library.name == "libcontensou.so.0.1.0"
        assert "libcontensou.so.0]" in called(["readelf", "-d", library], folder).stdout


def test_pkg_config(installed, tmp_path):
    """The shared library asks for nothing else; the static one for all that it is made of."""
    folder, environment = installed
    shared = bool(list(folder.rglob("libcontensou.so")))
    libs = called(["pkg-config", "--libs", "contensou"], folder, environment).stdout
    assert ("sundials_cvode" in libs) is not shared
    assert ("-lgsl" in libs.split()) is not shared
    whole = called(["pkg-config", "--libs", "--static", "contensou"], folder, environment).stdout
    assert {"-lcontensou", "-lgsl", "-lgfortran"} <= set(whole.split())
    assert "sundials_cvode" in whole
    called(["pkg-config", "--exists", "contensou >= 0.1, contensou < 0.2"], folder, environment)
    (tmp_path / "tippe_top.c").write_text(program_of("c"))
    static = "" if shared else "--static"
    build = f"gcc tippe_top.c -o tippe_top $(pkg-config --cflags --libs {static} contensou)"
    called(["bash", "-c", build], tmp_path, environment)
    shutil.copy(ROOT / "inputs" / "tippe_top.nml", tmp_path)
    assert "6 rows" in called([tmp_path / "tippe_top"], tmp_path, environment).stdout


CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(spinning C)
find_package(contensou {version} REQUIRED)
add_executable(tippe_top tippe_top.c)
target_link_libraries(tippe_top contensou::contensou contensou::{kind})
"""


def test_cmake(installed, tmp_path):
    """The program of the page, built by CMake, from where the library lies now."""
    if shutil.which("cmake") is None:
        pytest.skip("there is no cmake")
    folder, _ = installed
    kind = "shared" if list(folder.rglob("libcontensou.so")) else "static"
    (config,) = folder.rglob("contensou-config.cmake")
    (tmp_path / "tippe_top.c").write_text(program_of("c"))
    shutil.copy(ROOT / "inputs" / "tippe_top.nml", tmp_path)
    project = tmp_path / "CMakeLists.txt"
    setup = ["cmake", "-S", tmp_path, "-B", tmp_path / "build", f"-Dcontensou_DIR={config.parent}"]
    for version in ("0.2", "1.0", "0.1.7"):
        project.write_text(CMAKE.format(version=version, kind=kind))
        refused = captured([*setup], cwd=tmp_path)
        assert refused.returncode != 0
        assert "version: 0.1.0" in refused.stderr
    for version in ("0.1", "0.1.0", ""):
        project.write_text(CMAKE.format(version=version, kind=kind))
        called(setup, tmp_path)
    called(["cmake", "--build", tmp_path / "build"], tmp_path)
    done = called([tmp_path / "build" / "tippe_top"], tmp_path)
    assert "6 rows" in done.stdout


@pytest.mark.parametrize("version", ["2", "3"])
def test_an_fmu_is_compiled_from_its_sources(version, installed, run, tmp_path):
    """What the page says makes a binary with the outputs of ours."""
    fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
    scene = ROOT / "inputs" / "tippe_top.nml"
    path = tmp_path / "top.fmu"
    assert run("fmu", scene, "-o", path, "--fmi", version).status == 0
    results = {"ours": fmpy.simulate_fmu(str(path), stop_time=0.1, fmi_type="CoSimulation")}
    folder = Path(fmpy.extract(str(path), tmp_path / "content"))
    (binary,) = folder.glob("binaries/*/top.so")
    binary.unlink()
    page = (ROOT / "docs" / "fmu.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^\$ (gcc -shared .*\\\n.*)$", page, re.MULTILINE)
    command = command.replace("fmu3.c", f"fmu{version}.c").replace("NAME.so", str(binary))
    command += " -std=c11 -Wall -Wextra -Werror"
    called(["bash", "-c", command], folder / "sources", installed[1])
    program = (
        "import fmpy, numpy, sys; numpy.save('theirs.npy', "
        "fmpy.simulate_fmu(sys.argv[1], stop_time=0.1, fmi_type='CoSimulation'))"
    )
    called([sys.executable, "-c", program, folder], tmp_path, installed[1])
    results["theirs"] = np.load(tmp_path / "theirs.npy")
    if list(installed[0].rglob("libcontensou.so")):
        # This library is compiled without optimization.
        for name in ("top.position.z", "ball_floor.normal_force"):
            ours, theirs = (results[whose][name] for whose in ("ours", "theirs"))
            np.testing.assert_allclose(theirs, ours, rtol=1e-5, atol=1e-9)
    else:
        assert results["theirs"].tobytes() == results["ours"].tobytes()


def test_the_names_of_the_module_are_those_of_the_page():
    """Names of the facade are few, and the page explains each."""
    source = (ROOT / "src" / "contensou.f90").read_text(encoding="utf-8").replace("&\n", " ")
    lists = re.findall(r"^ *use \w+, only : (.*)$", source, re.MULTILINE)
    names = {name.strip() for names in lists for name in names.split(",")}
    assert 20 <= len(names) <= 40
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("|")]
    words = re.findall(r"`([^`]*)`", " ".join(rows))
    explained = set(re.findall(r"\w+", " ".join(words)))
    assert not names - explained


@pytest.mark.parametrize("language", SUFFIXES)
def test_program_of_the_page(language, installed, built, run, tmp_path):
    """It prints the rows of `contensou run`, and nothing else is printed."""
    text = program_of(language)
    assert text.count("\n") <= MOST_LINES[language]
    done = called([built(language, text)], tmp_path, installed[1])
    assert done.stderr == ""
    *rows, last = done.stdout.splitlines()
    assert [row.split()[0] for row in rows] == [f"0.{i}00" for i in range(6)]
    changes = ("--set", "scene.t_end=0.5", "--set", "output.interval=0.1")
    result = run("run", "tippe_top.nml", "-q", "-o", "top.h5", *changes)
    assert result.status == 0, result.err
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "top.h5") as file:
        position = file["trajectory/position"][:, 0, :]
    for row, expected in zip(rows, position, strict=True):
        for shown, x in zip(NUMBER.findall(row)[1:], expected, strict=True):
            assert float(shown) == pytest.approx(x, abs=1e-6)
    numbers = [float(x) for x in NUMBER.findall(last)]
    assert numbers[0] == 0.5
    if language == "fortran":
        assert numbers[1:4] == pytest.approx(position[-1], abs=1e-5)
        assert math.hypot(*numbers[4:8]) == pytest.approx(1.0, abs=1e-2)
    else:
        assert last.startswith("6 rows; ")
        assert numbers[1] == pytest.approx(position[-1][2], abs=1e-6)


@pytest.mark.parametrize("language", SUFFIXES)
def test_an_error_reaches_the_program_with_its_text(language, installed, built, run, tmp_path):
    """The text is that of the command line, and only the program itself prints it."""
    text = program_of(language).replace("scene.t_end", "scene.t_ned")
    quiet = text.replace("error stop error%message", "stop 2, quiet=.true.")
    quiet = re.sub(r"fprintf\(stderr, .*\);", "", quiet)
    assert quiet != text
    changes = [word for setting in SETTINGS.findall(text) for word in ("--set", setting.rstrip())]
    result = run("run", "tippe_top.nml", *changes, cwd=ROOT / "inputs")
    assert result.status == 2
    assert "unknown key 't_ned'" in result.err
    for program, shown in ((text, result.err), (quiet, "")):
        done = captured(
            [built(language, program)],
            cwd=tmp_path,
            env=installed[1],
            timeout=60,
        )
        assert done.returncode != 0
        assert done.stdout == ""
        assert done.stderr.removeprefix("ERROR STOP ").partition("\nError termination")[
            0
        ].strip() == (shown.strip())


def test_the_observer_of_the_page(installed, built, tmp_path):
    """The module of the page counts what the events of the file are."""
    (module,) = (text for kind, text in BLOCKS if kind == "fortran" and "module counting" in text)
    program = """\
program count_touches
   use contensou
   use counting
   implicit none(type, external)
   type(simulation_type) :: top
   type(scene_file_type) :: file
   type(counter_type) :: counter
   type(error_type), allocatable :: error
   call read_scene("tippe_top.nml", file, error, ["scene.t_end = 1.8"])
   if (.not. allocated(error)) call new_simulation(file, top, error)
   if (.not. allocated(error)) call simulate(top, counter, error)
   if (allocated(error)) error stop error%message
   print "(i0)", counter%touches
end program count_touches
"""
    done = called([built("fortran", module + program)], tmp_path, installed[1])
    assert int(done.stdout) >= 3


KERNELS = """\
program kernels
   use contensou
   use rolling, only : rolling_force
   implicit none(type, external)
   type(spot_shape_type) :: shape
   real(wp) :: force(3), moment(2), jacobian(5, 5), flat(3), slopes(3, 3)
   type(spring_spot_type) :: spring
   type(hertz_type) :: contact
   type(hertz_spot_type) :: spot
   real(wp), dimension(2) :: k, e, b, d, dk, de
   integer :: i
   shape = spot_shape_type(0.5_wp)
   print "(*(es25.16))", kalker_coefficients(0.5_wp, 0.3_wp, 0.0_wp)
   spring = spring_spot_type(shape, 2.0e-3_wp, 0.0_wp, 8.0e10_wp, 0.3_wp)
   print "(*(es25.16))", spring%stiffness
   call friction_wrench(shape, slip_type(0.1_wp, 0.2_wp, 0.3_wp), &
      bend_type([1.0e-4_wp, 0.0_wp, 0.0_wp], [10.0_wp, 20.0_wp]), 1.0e-10_wp, force, moment)
   print "(*(es25.16))", force, moment
   call friction_wrench(shape, slip_type(0.1_wp, 0.2_wp, 0.3_wp), &
      bend_type([1.0e-4_wp, 0.0_wp, 0.0_wp], [10.0_wp, 20.0_wp]), 1.0e-10_wp, force, moment, &
      jacobian)
   print "(*(es25.16))", force, moment
   call rolling_force("linear", creep_spot_type(shape, 0.3_wp, 8.0e10_wp, 0.3_wp), &
      passing_type(load=1.0e3_wp, a=2.0e-3_wp, vx=1.0e-4_wp, vy=2.0e-4_wp, cx=1.0_wp), force)
   print "(*(es25.16))", force
   call friction_wrench(shape, slip_type(0.1_wp, 0.2_wp, 0.3_wp), .true., force)
   call friction_wrench(shape, slip_type(0.1_wp, 0.2_wp, 0.3_wp), flat, slopes)
   print "(*(es25.16))", force, flat
   call complete_elliptic([0.25_wp, 0.5_wp], k, e, b, d, dk, de)
   print "(*(es25.16))", k(1), e(1), b(1), d(1), dk(1), de(1)
   call complete_elliptic(0.25_wp, k(1), e(1))
   print "(*(es25.16))", k(1), e(1)
   contact = hertz_type(50.0_wp, 120.0_wp, 1.15e11_wp)
   print "(*(es25.16))", contact%force(1.0e-6_wp)
   associate (formulas => vilke_models())
      do i = 1, size(formulas)
         call formulas(i)%kernel(50.0_wp, 120.0_wp, 1.15e11_wp, 1.0e-6_wp, spot)
         print "(*(es25.16))", spot%force
      end do
   end associate
end program kernels
"""


def test_the_kernels_of_the_module(installed, built, run, tmp_path):
    """Coefficients, stiffness, curved spot and laws of creep, as `contensou eval` has them."""
    (law,) = (text for kind, text in BLOCKS if "subroutine rolling_force" in text)
    module = f"module rolling\nimplicit none(type, external)\ncontains\n{law}end module rolling\n"
    done = called([built("fortran", module + KERNELS)], tmp_path, installed[1])
    found = [[float(x) for x in line.split()] for line in done.stdout.splitlines()]

    def evaluated(kernel, names, row, *more):
        done = run("eval", kernel, *more, input=f"{names}\n{row}\n")
        assert done.status == 0, done.err
        values = dict(zip(*(line.split(",") for line in done.out.splitlines()), strict=True))
        return [float(x) for name, x in values.items() if name not in names.split(",")]

    close = {"rel": 1e-13, "abs": 1e-18}
    assert found[0] == pytest.approx(evaluated("kalker", "a_over_b,nu,chi", "0.5,0.3,0"), **close)
    stiffness = evaluated("tangential_stiffness", "a,b,G,nu", "2e-3,1e-3,8e10,0.3")
    assert found[1] == pytest.approx(stiffness, **close)
    assert found[2] == pytest.approx(found[3], rel=1e-8)
    # In units of f N and f N a; the height a^2 L/2, the moment turned from q to the axes.
    curved = evaluated(
        "curved_wrench",
        "N,a,b,f,Lxx,Lxy,Lyy,vx,vy,w,wx,wy",
        "1,2e-3,1e-3,1,50,0,0,0.1,0.2,150,-20,10",
    )
    assert found[2][:2] == pytest.approx(curved[:2], rel=1e-8)
    assert 2e-3 * found[2][2] == pytest.approx(curved[2], rel=1e-8)
    names = "N,a,b,f,G,nu,vx,vy,w,cx,cy"
    creep = evaluated(
        "creep", names, "1e3,2e-3,1e-3,0.3,8e10,0.3,1e-4,2e-4,0,1,0", "--model", "linear"
    )
    assert found[4] == pytest.approx(creep, **close)
    flat = evaluated("wrench", "N,a,b,f,vx,vy,w", "1,2e-3,1e-3,1,0.1,0.2,150")
    assert found[5][:3] == pytest.approx(found[5][3:], rel=1e-13)
    assert [*found[5][:2], 2e-3 * found[5][2]] == pytest.approx(flat[:3], rel=1e-13)
    elliptic = evaluated("elliptic", "c1", "0.25")
    assert found[6] == pytest.approx(elliptic, **close)
    assert found[7] == pytest.approx(found[6][:2], rel=1e-15)
    force = evaluated("hertz", "A,B,Estar,delta", "50,120,1.15e11,1e-6")[4]
    assert found[8] == pytest.approx([force], **close)
    stiffness = 4 / 3 * 1.15e11 * math.sqrt(0.5 / math.sqrt(50 * 120))
    for vilke in found[9:12]:
        assert vilke == pytest.approx([stiffness * 1e-9], rel=1e-14)


def test_the_header_is_plain_c_and_c_plus_plus(installed, tmp_path):
    folder, _ = installed
    (header,) = folder.rglob("include/contensou/contensou.h")
    for language, compiler in (("c", "gcc"), ("c++", "g++")):
        if shutil.which(compiler) is None:
            pytest.skip(f"there is no {compiler}")
        words = [compiler, "-x", language, "-Wall", "-Wextra", "-pedantic", "-Werror"]
        called([*words, "-fsyntax-only", header], tmp_path)
