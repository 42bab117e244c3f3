"""`contensou bench kernels`: files, rungs, errors, and the bars of a release build."""

from __future__ import annotations

import csv
import io
import math
import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import h5py
import pytest
import xarray
from programs import captured

COLUMNS = [
    "kernel",
    "case",
    "rung",
    "quantity",
    "error_unit",
    "error_max",
    "error_median",
    "checked",
    "misses",
    "ns",
    "ns_chain",
    "log_ratio",
    "log_ratio_chain",
]
SPOTS = [
    f"{shape}_{place}"
    for shape in ("circle", "k0.3", "k0.05")
    for place in ("inside", "rim", "outside")
]
CASES = {
    "elliptic": ["even", "wide", "near_circle"],
    "elliptic_ke": ["even", "wide", "near_circle"],
    "hertz": ["full", "slender"],
    "wrench": SPOTS,
    "wrench_jacobian": SPOTS,
    "curved_wrench": ["groove"],
    "creep": ["no_spin", "spin", "oblique"],
    "creep_jacobian": ["no_spin", "spin", "oblique"],
    "tangential": ["shift", "shift_k0.5", "twist", "twist_k0.5"],
}
QUANTITIES = {
    "elliptic": ["K", "E", "B", "D", "dKdc", "dEdc"],
    "elliptic_ke": ["K", "E"],
    "hertz": ["c1", "a", "b", "N", "p0"],
    "wrench": ["F", "T", "T_relative"],
    "wrench_jacobian": ["F", "T", "T_relative", "J"],
    "curved_wrench": ["F", "T", "T_relative"],
    "creep": ["F", "T"],
    "creep_jacobian": ["F", "T"],
    "tangential": ["F", "T"],
}
RUNGS = {
    "elliptic": {"tables", "theta", "agm", "gsl"},
    "elliptic_ke": {"tables", "gsl"},
    "hertz": {
        "tables",
        "newton",
        "brewe_hamrock",
        "greenwood",
        "newton_agm",
        "newton_gsl",
        "tables_fixed",
        "vilke_chord",
        "vilke_power",
        "vilke_exact",
    },
    "wrench": {"coulomb", "contensou_simplified", "pade11", "pade22", "contensou_exact"},
    "wrench_jacobian": {"contensou_simplified", "contensou_exact"},
    "curved_wrench": {
        *("within_1e-10", "within_1e-6", "within_1e-4"),
        *("mapped", "slender", "product", "flat"),
    },
    "creep": {
        *("sliding", "linear", "strip", "polach", "fastsim", "brush", "table"),
        *("boundary_elements_8", "boundary_elements_16", "boundary_elements"),
    },
    "creep_jacobian": {"sliding", "table"},
    "tangential": {"spring", "layers_1", "layers_6", "layers_12", "layers_24"},
}
# Only where Boost is there.
BASELINES = {
    "elliptic": {"boost"},
    "elliptic_ke": {"boost"},
}
ALL = {(kernel, case) for kernel, cases in CASES.items() for case in cases}


@dataclass(frozen=True)
class Bench:
    """What one quick measurement left."""

    folder: Path
    out: str
    err: str
    text: str  # of the CSV
    rows: dict[tuple[str, str, str, str], dict[str, str]]  # by kernel, case, rung, quantity

    def errors(self, kernel, rung, quantity, case="", column="error_max") -> list[float]:
        """Errors of a quantity in all cases whose name contains a text."""
        found = [
            float(row[column])
            for key, row in self.rows.items()
            if (key[0], key[2], key[3]) == (kernel, rung, quantity) and case in key[1]
        ]
        assert found
        return found


@pytest.fixture(scope="module")
def bench(executable, tmp_path_factory) -> Bench:
    """A quick measurement with files."""
    folder = tmp_path_factory.mktemp("bench")
    done = captured(
        [str(executable), "bench", "kernels", "--quick", "-o", "out"],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    text = (folder / "out.csv").read_text(encoding="ascii")
    rows = {}
    for row in csv.DictReader(io.StringIO(text)):
        key = tuple(row[name] for name in COLUMNS[:4])
        assert key not in rows
        rows[key] = row
    return Bench(folder, done.stdout, done.stderr, text, rows)


# --- what is there ---------------------------------------------------------------------------


def test_files(bench):
    assert sorted(path.name for path in bench.folder.iterdir()) == ["out.csv", "out.h5"]
    assert bench.err == ""
    assert bench.text.splitlines()[0].split(",") == COLUMNS


def test_every_rung_of_every_kernel_is_there(bench):
    assert {key[:2] for key in bench.rows} == ALL
    for kernel, case in ALL:
        here = [key for key in bench.rows if key[:2] == (kernel, case)]
        rungs = {key[2] for key in here}
        assert rungs >= RUNGS[kernel]
        assert rungs <= RUNGS[kernel] | BASELINES.get(kernel, set())
        for rung in rungs:
            assert [key[3] for key in here if key[2] == rung] == QUANTITIES[kernel]


def test_rungs_are_those_of_eval_and_models(bench, run):
    table = run("models").out.partition("\nfriction")[2].partition("\nrolling")[0]
    friction = re.findall(r"^  (\w+)$", table, re.MULTILINE)
    assert set(friction) - {"none"} == RUNGS["wrench"]
    table = run("models").out.partition("\nlaw of creep")[2].partition("\ncurvature")[0]
    laws = set(re.findall(r"^  (\w+)$", table, re.MULTILINE))
    assert "boundary_elements" in laws
    assert {re.sub(r"_\d+$", "", rung) for rung in RUNGS["creep"]} == laws
    usage = run("eval", "--help").out
    for rung in RUNGS["elliptic"] | RUNGS["wrench"] | {"newton", "brewe_hamrock", "greenwood"}:
        assert rung in usage


def test_boost_is_named_where_it_is_there(bench):
    found = {key[2] for key in bench.rows}
    assert ("boost" in found) == bool(re.search(r"^with Boost\.Math \d+\.\d+;", bench.out, re.M))


def test_table_shows_every_rung(bench):
    for kernel in CASES:
        block = re.search(rf"^{kernel}: .*\n(?:.+\n)*", bench.out, re.MULTILINE)[0]
        lines = [line.split()[0] for line in block.splitlines() if re.match(r"   \w", line)]
        expected = [
            key[2] for key in bench.rows if key[0] == kernel and key[3] == QUANTITIES[kernel][0]
        ]
        assert lines == expected
    assert max(map(len, bench.out.splitlines())) <= 125
    assert "*" not in bench.out.replace("E*", "")


def test_units(bench):
    for key, row in bench.rows.items():
        absolute = any(word in key[0] for word in ("wrench", "creep", "tangential"))
        assert row["error_unit"] == ("1" if absolute else "ulp")


def test_times_are_times(bench):
    for key, row in bench.rows.items():
        most = 1e11 if key[2].startswith("boundary_elements") else 1e7
        for column in ("ns", "ns_chain", "log_ratio", "log_ratio_chain"):
            assert 1e-3 < float(row[column]) < most
    log = re.search(r"one log\(\) takes (\S+) ns in throughput and (\S+) ns in a chain", bench.out)
    for row in bench.rows.values():
        ratio = float(row["ns"]) / float(row["log_ratio"])
        assert ratio == pytest.approx(float(log[1]), rel=6e-3)
        ratio = float(row["ns_chain"]) / float(row["log_ratio_chain"])
        assert ratio == pytest.approx(float(log[2]), rel=6e-3)


# --- HDF5 ------------------------------------------------------------------------------------


def test_root_of_the_hdf5_file(bench):
    with h5py.File(bench.folder / "out.h5") as file:
        assert file.attrs["filetype"] == "contensou-bench"
        assert file.attrs["filetype_version"] == "1.0"
        assert file.attrs["status"] == "complete"
        assert re.fullmatch(r"\d+\.\d+\.\d+", file.attrs["program_version"])
        assert f"contensou {file.attrs['program_version']}, " in bench.out
        assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", file.attrs["created"])
        assert set(file) == {"provenance", "log", "bar", *CASES}
        assert set(file["provenance"]) == {"compiler", "flags", "hdf5", "boost", "host"}


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
@pytest.mark.parametrize("kernel", CASES)
def test_csv_and_hdf5_agree(bench, kernel, engine):
    with xarray.open_dataset(bench.folder / "out.h5", group=kernel, engine=engine) as data:
        assert list(data["case"].values) == CASES[kernel]
        assert list(data["quantity"].values) == QUANTITIES[kernel]
        assert data["error_max"].dims == ("case", "rung", "quantity")
        keys = [key for key in bench.rows if key[0] == kernel]
        assert len(keys) == data["error_max"].size
        for key in keys:
            _, case, rung, quantity = key
            row = bench.rows[key]
            here = data.sel(case=case, rung=rung)
            assert here["checked"] == int(row["checked"])
            for column in ("misses", "ns", "ns_chain", "log_ratio", "log_ratio_chain"):
                assert here[column] == float(row[column])
            for column in ("error_max", "error_median"):
                value = here[column].sel(quantity=quantity).item()
                assert value == float(row[column]) or (math.isnan(value) and row[column] == "NaN")


def test_units_and_names_in_the_hdf5_file(bench):
    with h5py.File(bench.folder / "out.h5") as file:
        for group in file.values():
            for name, data in group.items():
                assert data.attrs["long_name"]
                if data.dtype.kind == "f":
                    assert data.attrs["units"] == ("ns" if name in ("ns", "ns_chain") else "1")
                if data.ndim and not data.is_scale:
                    assert all(len(dimension) == 1 for dimension in data.dims), data.name
        for kernel in CASES:
            assert file[kernel].attrs["signal"] == "ns"
            assert list(file[kernel].attrs["axes"]) == ["case", "rung"]


def test_bars(bench):
    lines = bench.out.partition("what is to be achieved")[2].splitlines()[1:]
    shown = [
        re.fullmatch(r"  (.{46}) +(\S+)  ([<>]=) +(\S+)  (met|MISSED)", line) for line in lines
    ]
    assert len(shown) >= 21
    with xarray.open_dataset(bench.folder / "out.h5", group="bar", engine="h5netcdf") as bars:
        assert [match[1].strip() for match in shown] == list(bars["name"].values)
        for i, match in enumerate(shown):
            bar = bars.isel(name=i)
            measured, limit = bar["measured"].item(), bar["limit"].item()
            assert float(match[2]) == pytest.approx(measured, rel=0.06)
            assert float(match[4]) == pytest.approx(limit, rel=0.01)
            assert (match[3] == ">=") == bool(bar["at_least"])
            assert (match[5] == "met") == bool(bar["met"])
            met = measured >= limit if bar["at_least"] else measured <= limit
            assert met == bool(bar["met"])
        # Errors do not depend on the machine.
        for name, error, limit in [
            ("K, E, B, D: error [ulp]", ("elliptic", "tables", "KEBD"), 2.5),
            ("dK/dc, dE/dc: error [ulp]", ("elliptic", "tables", ("dKdc", "dEdc")), 3.0),
            ("Hertz, N, c1: error [ulp]", ("hertz", "tables", ("N", "c1")), 6.0),
            ("Hertz, a, b: error [ulp]", ("hertz", "tables", "ab"), 2.5),
            ("Hertz, p0: error [ulp]", ("hertz", "tables", ("p0",)), 4.0),
            ("exact wrench: error [f N, f N a]", ("wrench", "contensou_exact", "FT"), 5e-15),
        ]:
            bar = bars.sel(name=name)
            kernel, rung, quantities = error
            worst = max(max(bench.errors(kernel, rung, quantity)) for quantity in quantities)
            assert bar["measured"] == worst
            assert bar["limit"] == limit
            assert bar["met"]


# --- errors ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kernel", "rung", "quantities", "budget"),
    [
        ("elliptic", "tables", "KEBD", 2.5),
        ("elliptic", "tables", ["dKdc", "dEdc"], 3.0),
        ("elliptic_ke", "tables", "KE", 2.5),
        ("hertz", "tables", ["N", "c1"], 6.0),
        ("hertz", "tables", "ab", 2.5),
        ("hertz", "tables", ["p0"], 4.0),
        ("hertz", "tables_fixed", ["c1", "a", "b", "N", "p0"], 8.0),
        ("hertz", "newton", ["c1", "a", "b", "N", "p0"], 10.0),
        ("wrench", "contensou_exact", "FT", 5e-15),
        ("wrench", "contensou_exact", ["T_relative"], 1e-12),
        ("wrench_jacobian", "contensou_exact", "FT", 5e-15),
        ("wrench_jacobian", "contensou_exact", ["J"], 1e-13),
        ("curved_wrench", "within_1e-10", "FT", 1e-10),
        ("curved_wrench", "within_1e-6", "FT", 1e-5),
    ],
)
def test_exact_rungs_keep_their_budget(bench, kernel, rung, quantities, budget):
    for quantity in quantities:
        assert max(bench.errors(kernel, rung, quantity)) <= budget
        medians = bench.errors(kernel, rung, quantity, column="error_median")
        assert 0 <= max(medians) <= budget / 2
    for key, row in bench.rows.items():
        if (key[0], key[2]) == (kernel, rung):
            assert row["misses"] == "0"


def test_other_rungs_fail_where_the_pages_say(bench):
    # theta is good in the middle only, B of agm cancels, brewe_hamrock is a fit to A/B >= 0.01.
    assert max(bench.errors("elliptic", "theta", "K", "even", "error_median")) < 10
    assert max(bench.errors("elliptic", "theta", "K", "wide", "error_median")) > 1e14
    assert max(bench.errors("elliptic", "agm", "K")) < 5
    assert 30 < max(bench.errors("elliptic", "agm", "B", "wide")) < 2000
    assert 1e13 < max(bench.errors("hertz", "brewe_hamrock", "N", "full", "error_median")) < 3e14
    # The torque along the minor axis of the simplified model.
    assert max(bench.errors("wrench", "contensou_simplified", "T_relative", "k0.3")) > 0.5
    for model in ("contensou_simplified", "pade11", "pade22"):
        assert 0.01 < max(bench.errors("wrench", model, "F", "circle")) < 0.5
    assert max(bench.errors("wrench", "coulomb", "T")) < 0.6


def test_arguments_without_a_result_are_counted(bench):
    row = bench.rows["hertz", "slender", "vilke_chord", "N"]
    assert row["misses"] == row["checked"]
    assert row["error_max"] == row["error_median"] == "NaN"
    assert re.search(r"^   vilke_chord +(- +){6}100 % ", bench.out, re.MULTILINE)
    row = bench.rows["hertz", "full", "vilke_chord", "N"]
    assert 0 < int(row["misses"]) < int(row["checked"])


@pytest.mark.release_only("takes half a minute, and runs what test_files does")
def test_errors_are_the_same_in_each_run(bench, run):
    result = run("bench", "kernels", "--quick")
    assert result.status == 0
    pattern = re.compile(r"^  .* error .*?(\S+)  <=", re.MULTILINE)
    assert pattern.findall(result.out) == pattern.findall(bench.out)
    assert len(pattern.findall(result.out)) == 11


# --- files and usage -------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["out", "out.h5", "out.csv"])
@pytest.mark.parametrize("existing", ["out.csv", "out.h5"])
def test_existing_file_is_kept(run, tmp_path, name, existing):
    (tmp_path / existing).write_text("mine")
    result = run("bench", "kernels", "--quick", "-o", name)
    assert result.status == 74
    assert result.out == ""
    expected = f"error: {existing} exists; --force replaces it, -o FILE writes another one\n"
    assert result.err == expected
    assert [path.name for path in tmp_path.iterdir()] == [existing]
    assert (tmp_path / existing).read_text() == "mine"


@pytest.mark.release_only("takes half a minute, and runs what test_files does")
def test_force_replaces_files(run, tmp_path):
    others = ["out.csv.part", "out.h5.part"]
    for name in ("out.csv", "out.h5", *others):
        (tmp_path / name).write_text("mine")
    result = run("bench", "kernels", "--quick", "--force", "--output=out.h5")
    assert result.status == 0, result.err
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        ["out.csv", "out.h5", *others]
    )
    assert all((tmp_path / name).read_text() == "mine" for name in others)
    assert (tmp_path / "out.csv").read_text().startswith("kernel,")
    with h5py.File(tmp_path / "out.h5") as file:
        assert file.attrs["filetype"] == "contensou-bench"


def test_folder_that_is_missing(run, tmp_path):
    result = run("bench", "kernels", "-o", "missing/out")
    assert result.status == 74
    assert result.out == ""
    assert result.err == "error: cannot write missing/out.csv: its folder missing does not exist\n"
    (tmp_path / "out.h5").mkdir()
    result = run("bench", "kernels", "-o", "out")
    assert result.status == 74
    assert result.err == "error: the output file out.h5 is a folder\n"


@pytest.mark.release_only("takes half a minute, and runs what test_files does")
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_files_are_there_though_the_output_is_full(executable, tmp_path):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [str(executable), "bench", "kernels", "--quick", "-o", "out"],
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            env=os.environ,
            timeout=300,
            check=False,
        )
    assert done.returncode == 74
    assert done.stderr.startswith(b"error: cannot write to the standard output")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.csv", "out.h5"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "error: bench needs a benchmark\nusage: contensou bench kernels"),
        (["kernel"], "error: unknown benchmark 'kernel'; did you mean 'kernels'?\n"),
        (["zebra"], "error: unknown benchmark 'zebra'; possible is kernels\n"),
        (["kernels", "more"], "error: unexpected word 'more'\nusage: contensou bench"),
        (["kernels", "--quik"], "error: unknown option '--quik'; did you mean '--quick'?\n"),
        (["kernels", "--quick=1"], "error: unknown option '--quick=1'"),
        (["kernels", "-q"], "error: unknown option '-q'\nusage: contensou bench"),
        (["kernels", "--model", "agm"], "error: unknown option '--model'\nusage: contensou bench"),
        (["kernels", "-o"], "error: -o needs a value\nusage: contensou bench"),
        (["kernels", "-o", ""], "error: -o needs the name of a file\n"),
    ],
)
def test_bad_usage(words, message, run, tmp_path):
    result = run("bench", *words)
    assert result.status == 2
    assert result.out == ""
    assert result.err.startswith(message)
    assert not list(tmp_path.iterdir())


def test_quick_belongs_to_bench_alone(run, scene):
    result = run("run", scene.name, "--quick")
    assert result.status == 2
    assert result.err.startswith("error: unknown option '--quick'")


def test_usage(run):
    result = run("bench", "--help")
    assert result.status == 0
    for word in ("-o NAME", "--force", "--quick"):
        assert word in result.out
    assert run("help", "bench").out == result.out
    assert re.search(r"^  bench kernels ", run("--help").out, re.MULTILINE)


def test_errors_of_creep(bench):
    assert max(bench.errors("creep", "table", "F")) <= 0.1
    assert max(bench.errors("creep", "table", "F", "no_spin")) <= 0.01
    assert max(bench.errors("creep", "brush", "F")) <= 0.2
    assert max(bench.errors("creep", "linear", "F")) > 0.5
    assert 1e-3 < max(bench.errors("creep", "boundary_elements_16", "F")) <= 0.02
    assert max(bench.errors("creep", "boundary_elements_16", "T")) <= 0.02
    assert 5e-3 < max(bench.errors("creep", "boundary_elements_8", "F")) <= 0.06
    assert max(bench.errors("creep", "boundary_elements_8", "T")) <= 0.05
    assert bench.errors("creep", "table", "F") == pytest.approx(
        bench.errors("creep_jacobian", "table", "F"), abs=1e-12
    )


def test_reference_of_creep_has_a_time_and_no_error(bench):
    rows = [row for key, row in bench.rows.items() if key[2] == "boundary_elements"]
    assert len(rows) == 6
    for row in rows:
        assert row["error_max"] == row["error_median"] == "NaN"
        assert row["misses"] == "0"
        assert row["ns_chain"] == row["ns"]
    # More elements take longer: some 250 times in all, so that no stall of the machine hides it.
    fewer = [row for key, row in bench.rows.items() if key[2] == "boundary_elements_8"]
    assert all(row["ns_chain"] == row["ns"] for row in fewer)
    assert sum(float(row["ns"]) for row in rows) > sum(float(row["ns"]) for row in fewer)
    shown = re.findall(r"^   boundary_elements +reference +reference +0 ", bench.out, re.MULTILINE)
    assert len(shown) == 3
