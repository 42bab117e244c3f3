"""`contensou diff`: rules, words for what differs, events, damaged files, memory."""

from __future__ import annotations

import itertools
import os
import random
import re
import shutil
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

TEXT = h5py.string_dtype()
TIMES = 2000
MUTANTS = int(os.environ.get("CONTENSOU_MUTANTS", "150"))


def write(path, edit=None, *, n=TIMES, chunks=(512,), compression=None, libver=None):
    """A small file in the form of a run's output; `edit` changes it before it is closed."""
    options = {"compression": compression, "fletcher32": bool(compression)}
    with h5py.File(path, "w", libver=libver) as f:
        f.attrs["status"] = "complete"
        f.attrs["created"] = str(time.monotonic())
        f["provenance/host"] = str(path)
        f["input/command_line"] = f"run -o {path}"
        f["input/namelist"] = "&scene\n   t_end = 2.0\n/\n"
        f["input/resolved"] = f"&scene\n   t_end = 2.0\n/\n&output\n   file = '{path}'\n/\n"
        f["integrator/steps"] = np.int64(12345)
        f["integrator/cpu_output"] = time.monotonic()
        t = np.arange(n) * 1e-3
        series = {"chunks": chunks, "maxshape": (None,), **options}
        scale = f.create_dataset("trajectory/time", data=t, **series)
        scale.make_scale("time")
        scale.attrs["units"] = "s"
        for name, labels in {"body": ["top"], "xyz": ["x", "y", "z"]}.items():
            f[f"trajectory/{name}"] = np.array(labels, dtype=TEXT)
            f[f"trajectory/{name}"].make_scale(name)
        position = f.create_dataset(
            "trajectory/position",
            data=np.sin(t)[:, None, None] * np.array([1.0, 2.0, 3.0]),
            chunks=(*chunks, 1, 3),
            maxshape=(None, 1, 3),
            **options,
        )
        position.attrs["units"] = "m"
        for i, name in enumerate(("time", "body", "xyz")):
            position.dims[i].attach_scale(f[f"trajectory/{name}"])
        f.create_dataset("trajectory/energy", data=np.cos(t), **series).dims[0].attach_scale(scale)
        write_events(f, [(0.5 + 0.1 * i, "touch" if i % 2 == 0 else "lift", "a") for i in range(8)])
        if edit:
            edit(f)


def write_events(f, events):
    """Replace the events by those of a list of (time, kind, contact)."""
    if "events" in f:
        del f["events"]
    columns = list(zip(*events, strict=True)) or [[], [], []]
    f["events/time"] = np.array(columns[0], dtype=float)
    f["events/kind"] = np.array(columns[1], dtype=TEXT)
    f["events/contact"] = np.array(columns[2], dtype=TEXT)


@pytest.fixture
def diff(run, tmp_path):
    """Compare two files that are made here; `diff(edit_a, edit_b, *words, rules)`."""

    def diff_it(edit_a, edit_b, *words, rules=None):
        for name, edit in (("a.h5", edit_a), ("b.h5", edit_b)):
            write(tmp_path / name, edit)
        if rules is not None:
            (tmp_path / "rules").write_text(rules)
            words = (*words, "--rules", "rules")
        result = run("diff", "a.h5", "b.h5", *words)
        assert all(len(line) <= 100 for line in result.out.splitlines())
        assert result.err == "" or result.status == 2
        return result

    return diff_it


def paths(result):
    """Paths that a result is about."""
    return re.findall(r"^(/\S*)", result.out, re.MULTILINE)


def entry(result, path):
    """Columns and following lines of a path in the results."""
    found = re.search(rf"^{re.escape(path)}(?:\s+(.*))?\n((?:   .*\n)*)", result.out, re.MULTILINE)
    assert found, result.out
    return (found[1] or "").split(), found[2]


def setter(path, index, value, *, add=False):
    """An edit that sets a value."""

    def edit(f):
        f[path][index] = f[path][index] + value if add else value

    return edit


def replacer(path, data, **options):
    """An edit that replaces a data set."""

    def edit(f):
        if path in f:
            del f[path]
        f.create_dataset(path, data=data, **options)

    return edit


# ---- Same and different ------------------------------------------------------------------------


def test_same(diff):
    result = diff(None, None)
    assert (result.status, result.err) == (0, "")
    # /input/resolved differs in the name of the output file alone.
    assert re.fullmatch(r"same: 11 data sets, \d+ attributes, 4 ignored\n", result.out)


def test_worst_and_first(diff):
    def edit(f):
        f["trajectory/position"][700, 0, 1] += 1e-6
        f["trajectory/position"][1500, 0, 2] += 1e-3
        f["trajectory/position"][900, 0, 0] += 1e-7

    result = diff(None, edit)
    assert result.status == 1
    columns, lines = entry(result, "/trajectory/position")
    assert columns[0] == "1.000E-03"
    assert float(columns[1]) == pytest.approx(1e-3 / (3 * np.sin(1.5) + 1e-3), rel=1e-3)
    assert columns[2:] == ["3", str(3 * TIMES)]
    assert re.search(r"largest  t = 1\.5 s, body top, component z\n", lines)
    assert re.search(r"first    t = 0\.7 s, body top, component y\n", lines)
    assert " m in A, " in lines
    assert paths(result) == ["/trajectory/position"]
    assert result.out.endswith("different: 1 data set; 11 compared, 4 ignored\n")


def test_tolerances(diff):
    def edit(f):
        f["trajectory/position"][700, 0, 1] += 1e-6
        f["trajectory/position"][1500, 0, 2] += 1e-3

    result = diff(None, edit, rules="/trajectory/* 1e-5 0\n")
    columns, lines = entry(result, "/trajectory/position")
    assert result.status == 1
    assert columns[2] == "1"
    assert "first    the same" in lines
    result = diff(None, edit, rules="/trajectory/* 1.1e-3 0\n")
    assert result.status == 0
    assert entry(result, "/trajectory/position")[0][2] == "0"
    assert "1 within tolerance" in result.out
    assert diff(None, edit, rules="/trajectory/* 0 3.5e-4\n").status == 0
    assert diff(None, edit, rules="/trajectory/* 0 3e-4\n").status == 1
    assert diff(None, edit, rules="/trajectory/* 1 1\n/trajectory/pos* 0 0\n").status == 1
    assert diff(None, edit, rules="/trajectory/* 0 0\n*/position ignore\n").status == 0
    assert diff(None, edit, rules="* 1 1\n").status == 0


def test_quiet(diff):
    result = diff(None, setter("trajectory/energy", 3, 7.0), "-q")
    assert (result.status, result.out, result.err) == (1, "", "")


@pytest.mark.parametrize(
    ("a", "b", "status", "shown"),
    [
        (np.nan, np.nan, 0, None),
        (np.nan, 1.0, 1, "NaN"),
        (1.0, np.nan, 1, "NaN"),
        (np.inf, np.inf, 0, None),
        (np.inf, -np.inf, 1, "Infinity"),
        (np.inf, 1.0, 1, "Infinity"),
        (0.0, -0.0, 0, None),
        (1.0, np.nextafter(1.0, 2.0), 1, "2.220E-16"),
        (0.0, 5e-324, 1, "4.941E-324"),
        (1.7e308, -1.7e308, 1, "1.798E+308"),
    ],
)
@pytest.mark.parametrize("rules", [None, "* 1e-12 1e-12\n"])
def test_special_values(a, b, status, shown, rules, diff):
    result = diff(setter("trajectory/energy", 5, a), setter("trajectory/energy", 5, b), rules=rules)
    if rules and shown in ("2.220E-16", "4.941E-324"):
        status = 0
    assert result.status == status
    if shown:
        columns, lines = entry(result, "/trajectory/energy")
        assert columns[0] == shown
        assert "t = 5.0e-3 s" in lines


def test_nan_outranks_other_differences(diff):
    def edit(f):
        f["trajectory/energy"][5] = np.nan
        f["trajectory/energy"][2] = np.inf
        f["trajectory/energy"][1] = 5.0

    columns, lines = entry(diff(None, edit), "/trajectory/energy")
    assert columns == ["NaN", "NaN", "3", str(TIMES)]
    assert "1 not a number in one file only" in lines
    assert re.search(r"largest  t = 5\.0e-3 s", lines)
    assert re.search(r"first    t = 1\.0e-3 s", lines)


# ---- Structure ---------------------------------------------------------------------------------


def test_lengths_differ(diff):
    def edit(f):
        for name in ("time", "position", "energy"):
            f[f"trajectory/{name}"].resize(1900, axis=0)
        f["trajectory/energy"][1000] += 1.0

    result = diff(None, edit)
    assert result.status == 1
    for name in ("time", "position", "energy"):
        lines = entry(result, f"/trajectory/{name}")[1]
        assert "2000 times in A, 1900 times in B; the common part is compared" in lines
    assert entry(result, "/trajectory/energy")[0][2:] == ["1", "1900"]
    assert "differs" in entry(result, "/trajectory/time")[0]
    assert diff(None, edit, "--until", "0.9").status == 0
    assert diff(None, edit, "--until", "1.0").status == 1


def test_times_differ(diff):
    result = diff(None, setter("trajectory/time", 100, 1e-9, add=True))
    assert result.status == 1
    assert "note: the times of A and B differ; rows are compared by their number" in result.out


def test_until(diff):
    def edit(f):
        f["trajectory/energy"][1200] += 1.0
        f["events/time"][6] += 0.01
        f["integrator/steps"][()] = 5

    assert diff(None, edit, "--until", "1.0").status == 0
    assert diff(None, edit, "--until=1.2").status == 1
    result = diff(None, edit, "--until", "1.15")
    # The event at 1.1 s is that at 1.11 s.
    assert result.status == 1
    assert paths(result) == ["/events"]
    assert diff(None, edit, "--until", "soon").status == 2


def test_missing(diff):
    def edit(f):
        del f["trajectory/energy"]
        del f["input"]
        del f["provenance"]
        f["extra/deep/x"] = 1.0
        f["trajectory/position"].attrs["note"] = "n"
        del f["trajectory/time"].attrs["units"]

    result = diff(None, edit)
    assert result.status == 1
    assert entry(result, "/trajectory/energy")[0] == ["only", "in", "A"]
    assert "/input                              only in A: a group of 2 data sets" in result.out
    assert "/extra                              only in B: a group of 1 data set" in result.out
    assert "/trajectory/position@note           only in B" in result.out
    assert "/trajectory/time@units              only in A" in result.out
    assert "/provenance" not in result.out
    rules = "/trajectory/energy ignore\n/input/* ignore\n/extra/* ignore\n*@units ignore\n"
    assert diff(None, edit, rules=rules + "*@note ignore\n").status == 0


def test_attributes(diff):
    def edit(f):
        f.attrs["status"] = "interrupted"
        f.attrs["git_commit"] = "other"
        f["trajectory/time"].attrs["units"] = "ms"
        f["trajectory/time"].attrs["factor"] = 1.0 + 1e-9

    def edit_a(f):
        f["trajectory/time"].attrs["factor"] = 1.0

    result = diff(edit_a, edit)
    assert result.status == 1
    assert paths(result) == ["/@status", "/trajectory/time@factor", "/trajectory/time@units"]
    assert "'complete' in A" in entry(result, "/@status")[1]
    assert "'interrupted' in B" in entry(result, "/@status")[1]
    assert "'s' in A" in entry(result, "/trajectory/time@units")[1]
    rules = "/@status ignore\n/trajectory/time@units ignore\n/trajectory/* 0 1e-8\n"
    assert paths(diff(edit_a, edit, rules=rules)) == [
        "/trajectory/time@factor",
        "/trajectory/time@units",
    ]
    rules = "/trajectory/* 0 1e-8\n/@status ignore\n/trajectory/time@units ignore\n"
    assert diff(edit_a, edit, rules=rules).status == 0


@pytest.mark.parametrize(
    ("a", "b", "words"),
    [
        (np.float64([1, 2]), np.float32([1, 2]), "64-bit reals in A, 32-bit reals in B"),
        (np.float64([1, 2]), np.int32([1, 2]), "64-bit reals in A, 32-bit integers in B"),
        (np.uint16([1, 2]), np.int16([1, 2]), "unsigned 16-bit integers in A, 16-bit integers"),
        (np.float64([1, 2]), np.array(["1", "2"], dtype=TEXT), "64-bit reals in A, texts in B"),
        (np.float64([1, 2]), np.float64([[1, 2]]), "1 dimension in A, 2 dimensions in B"),
        (np.float64([1, 2]), np.float64(1), "1 dimension in A, a single value in B"),
        (np.float64([1, 2]), np.float64([]), "2 values in A, 0 values in B"),
        (np.ones((2, 3)), np.ones((2, 4)), "3 in dimension 2 in A, 4 in dimension 2 in B"),
        (np.float64(1), h5py.Empty("f8"), "a single value in A, no value in B"),
    ],
)
@pytest.mark.parametrize("swapped", [False, True])
def test_types_and_shapes(a, b, words, swapped, diff):
    if swapped:
        a, b = b, a
        words = re.sub(r"(.*) in A, (.*?)( in B)?$", r"\2 in A, \1", words)
    result = diff(replacer("x", a), replacer("x", b))
    assert result.status == 1
    columns, lines = entry(result, "/x")
    assert columns == ["differs"]
    assert words in lines


def test_type_differs_and_values_too(diff):
    result = diff(replacer("x", np.float64([1, 2])), replacer("x", np.int32([1, 3])))
    columns, lines = entry(result, "/x")
    assert columns == ["1.000E+00", "3.333E-01", "1", "2"]
    assert "64-bit reals in A, 32-bit integers in B" in lines


def test_byte_order_and_text_storage_do_not_matter(diff):
    def edit(kind, text):
        def edit_it(f):
            f["x"] = np.arange(5, dtype=kind)
            f["s"] = np.array(["ab", "c"], dtype=text)

        return edit_it

    assert diff(edit("<f8", TEXT), edit(">f8", "S7")).status == 0


@pytest.mark.parametrize(
    ("a", "b", "largest", "relative"),
    [
        (np.int64([1, 5]), np.int64([1, 8]), "3.000E+00", "3.750E-01"),
        (np.int64([2**62 + 1]), np.int64([2**62]), "1.000E+00", "2.168E-19"),
        (np.int64([-(2**63)]), np.int64([2**63 - 1]), "1.845E+19", "2.000E+00"),
        (np.uint64([2**64 - 1]), np.uint64([2**64 - 2]), "1.000E+00", "5.421E-20"),
        (np.uint64([2**64 - 1]), np.uint64([1]), "1.845E+19", "1.000E+00"),
        (np.int8([-1]), np.int8([1]), "2.000E+00", "2.000E+00"),
        (np.array([True]), np.array([False]), "1.000E+00", "1.000E+00"),
    ],
)
def test_integers(a, b, largest, relative, diff):
    result = diff(replacer("x", a), replacer("x", b))
    assert result.status == 1
    assert entry(result, "/x")[0][:2] == [largest, relative]
    assert diff(replacer("x", a), replacer("x", a)).status == 0


def test_unsigned_values_are_shown(diff):
    result = diff(replacer("x", np.uint64(2**64 - 1)), replacer("x", np.uint64(1)))
    assert "18446744073709551615 in A, 1 in B" in result.out


def test_counters_with_their_own_tolerance(diff):
    edit = setter("integrator/steps", (), 12400)
    assert diff(None, edit).status == 1
    assert diff(None, edit, rules="/integrator/* 0 0.01\n").status == 0
    assert diff(None, edit, rules="/integrator/* 50 0\n").status == 1
    assert diff(None, edit, rules="/integrator/* 50 1e-3\n").status == 0


def test_texts(diff):
    result = diff(None, replacer("input/namelist", "&scene\n   t_end = 3.0\n/\n"))
    assert result.status == 1
    lines = entry(result, "/input/namelist")[1]
    assert "line 2 '   t_end = 2.0' in A" in lines
    assert "line 2 '   t_end = 3.0' in B" in lines
    result = diff(None, replacer("input/resolved", "&scene\n   file = 'x'\n/\n"))
    assert result.status == 1
    assert "line 2 '   t_end = 2.0' in A" in entry(result, "/input/resolved")[1]


def test_other_classes(diff):
    pair = np.dtype([("a", "i4"), ("b", "f8")])
    a, b = (np.array([(1, 2.0), (3, x)], dtype=pair) for x in (4.0, 5.0))
    assert diff(replacer("c", a), replacer("c", a)).status == 0
    result = diff(replacer("c", a), replacer("c", b))
    assert result.status == 1
    assert entry(result, "/c")[0] == ["-", "-", "1", "2"]
    assert "first    index 1" in result.out
    z = np.array([1 + 2j])
    assert diff(replacer("z", z), replacer("z", z.conj())).status == 1
    ragged = np.array([np.arange(2.0), np.arange(3.0)], dtype=object)
    edit = replacer("v", ragged, dtype=h5py.vlen_dtype("f8"))
    result = diff(edit, edit)
    assert result.status == 2
    assert result.err == (
        "error: /v: sequences of variable length cannot be compared; a rule can ignore them\n"
    )
    assert diff(edit, edit, rules="/v ignore\n").status == 0


def test_links(diff):
    def edit(target):
        def edit_it(f):
            f["g/loop"] = f["g"] if "g" in f else f.create_group("g")
            f["soft"] = h5py.SoftLink(target)
            f["external"] = h5py.ExternalLink("other.h5", "/x")
            f["nothing"] = h5py.SoftLink("/nowhere")

        return edit_it

    assert diff(edit("/trajectory"), edit("/trajectory")).status == 0
    result = diff(edit("/trajectory"), edit("/events"))
    assert result.status == 1
    assert "/soft" in result.out
    assert "a link to /trajectory in A, a link to /events in B" in result.out
    result = diff(None, replacer("trajectory/body", np.float64(1)))
    assert result.status == 1
    result = diff(lambda f: f.create_group("x"), replacer("x", 1.0))
    assert "a group in A, a data set in B" in result.out


def test_case_dimension(diff):
    def edit(extra):
        def edit_it(f):
            f["case"] = np.arange(1, 101)
            f["case"].make_scale("case")
            f["result"] = np.arange(100.0) + extra * (np.arange(100) >= 16)
            f["result"].dims[0].attach_scale(f["case"])
            f["labelled"] = np.arange(100.0) + extra * (np.arange(100) == 17)
            f["labelled"].dims[0].label = "case"
            f["plain"] = np.arange(6.0).reshape(2, 3) + extra

        return edit_it

    result = diff(edit(0.0), edit(1e-3))
    assert "first    case 17\n" in entry(result, "/result")[1]
    assert "largest  case 17\n" in entry(result, "/labelled")[1]
    assert "index 0, index 0\n" in entry(result, "/plain")[1]


def test_storage_does_not_matter(run, tmp_path):
    write(tmp_path / "a.h5")
    write(tmp_path / "b.h5", chunks=(7,), compression="gzip")
    write(tmp_path / "c.h5", setter("trajectory/energy", 1234, 9.0), chunks=(97,), libver="v110")
    assert run("diff", "a.h5", "b.h5").status == 0
    for words in (("a.h5", "c.h5"), ("c.h5", "b.h5")):
        result = run("diff", *words)
        assert result.status == 1
        assert "t = 1.234 s" in entry(result, "/trajectory/energy")[1]


@pytest.mark.parametrize("chunks", [None, (1, 600), (600, 1), (50, 50), (700, 800)])
def test_first_is_first_in_the_order_of_indices(chunks, diff):
    a = np.arange(700.0 * 800).reshape(700, 800)
    b = a.copy()
    for place in ((5, 799), (6, 0), (300, 1), (699, 799)):
        b[place] += 1.0
    b[350, 400] += 2.0
    options = {"chunks": chunks, "compression": "gzip" if chunks else None}
    result = diff(replacer("x", a, **options), replacer("x", b))
    columns, lines = entry(result, "/x")
    assert columns[2:] == ["5", "560000"]
    assert "largest  index 350, index 400\n" in lines
    assert "first    index 5, index 799\n" in lines


# ---- Events ------------------------------------------------------------------------------------

EVENTS = [
    (0.1 * i, "touch" if i % 2 else "lift", name) for i in range(1, 21) for name in ("a", "b")
]


def events(change=None):
    """An edit that writes events, changed by a function of the list."""

    def edit(f):
        chosen = list(EVENTS)
        if change:
            change(chosen)
        write_events(f, chosen)

    return edit


def test_events_moved(diff):
    def move(chosen):
        chosen[10] = (chosen[10][0] + 1e-9, *chosen[10][1:])
        chosen[20] = (chosen[20][0] + 1e-6, *chosen[20][1:])

    result = diff(events(), events(move))
    assert result.status == 1
    columns, lines = entry(result, "/events")
    assert float(columns[0]) == pytest.approx(1e-6, rel=1e-3)
    assert columns[2:] == ["2", "40"]
    assert "shift    touch of a at t = 1.1 s\n" in lines
    assert "first    lift of a at t = 0.6 s\n" in lines
    assert (
        entry(diff(events(), events(move), rules="/events/time 1e-8 0\n"), "/events")[0][2] == "1"
    )
    assert diff(events(), events(move), rules="/events/time 1e-5 0\n").status == 0
    assert diff(events(), events(move), rules="/events/* ignore\n").status == 0
    assert diff(events(), events(move), rules="/events/time ignore\n").status == 0


def test_events_missing(diff):
    def remove(chosen):
        del chosen[12], chosen[13]

    result = diff(events(), events(remove))
    assert result.status == 1
    columns, lines = entry(result, "/events")
    assert columns == ["differs"]
    assert "count    40 events in A, 38 in B" in lines
    assert "missing  2 only in A, first touch of a at t = 0.7 s" in lines
    result = diff(events(remove), events())
    assert "missing  2 only in B, first touch of a at t = 0.7 s" in entry(result, "/events")[1]


def test_events_of_another_kind(diff):
    def change(chosen):
        chosen[4] = (chosen[4][0], "lift", "a")

    result = diff(events(), events(change))
    assert result.status == 1
    lines = entry(result, "/events")[1]
    assert "kind     1 of another kind, first touch of a at t = 0.3 s in A, lift in B" in lines


def test_no_events(diff):
    assert diff(events(list.clear), events(list.clear)).status == 0
    result = diff(events(), events(list.clear))
    assert "count    40 events in A, 0 in B" in entry(result, "/events")[1]


# ---- Use ---------------------------------------------------------------------------------------


def test_runs(run, scene):
    words = ("run", scene.name, "-q")
    assert run(*words, "-o", "one.h5").status == 0
    assert run(*words, "-o", "two.h5").status == 0
    assert run(*words, "-o", "three.h5", "--set", "integrator.rtol=1e-9").status == 0
    result = run("diff", "one.h5", "two.h5")
    assert (result.status, result.err) == (0, "")
    assert result.out.startswith("same: ")
    result = run("diff", "one.h5", "three.h5")
    assert result.status == 1
    assert "line" in entry(result, "/input/resolved")[1]
    assert "body top, component" in entry(result, "/trajectory/position")[1]
    assert "contact ball_floor" in entry(result, "/trajectory/normal_force")[1]


def test_bad_rules(diff):
    result = diff(None, None, rules="/a 0 0\n/b 1e-6\nb ignore\n")
    assert result.status == 2
    assert result.out == ""
    assert "rules:2:4: error: the relative tolerance is missing\n" in result.err
    assert "rules:3:1: error: no path begins with 'b'\n" in result.err
    assert result.err.count("  expected: ") == 2
    assert result.err.endswith("2 errors in rules; nothing was compared\n")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "error: diff needs a file\nusage: contensou diff"),
        (["a.h5"], "error: diff needs two files\nusage: contensou diff"),
        (["a.h5", "b.h5", "c.h5"], "error: unexpected word 'c.h5'"),
        (
            ["a.h5", "b.h5", "--rule", "x"],
            "error: unknown option '--rule'; did you mean '--rules'?",
        ),
        (["a.h5", "b.h5", "--rules"], "error: --rules needs a value"),
        (["a.h5", "b.h5", "--rules", "none"], "error: none cannot be read: it does not exist\n"),
        (["a.h5", "b.h5", "--until", "x"], "error: --until needs a time [s], not 'x'\n"),
        (["a.h5", "none.h5"], "error: cannot read none.h5: it does not exist\n"),
        (["a.h5", "."], "error: cannot read .: it is a folder\n"),
        (["a.h5", "/dev/null"], "error: cannot read /dev/null: it is not a regular file\n"),
        (["text", "a.h5"], "error: cannot read text: it is not an HDF5 file, or damaged\n"),
        (["empty", "a.h5"], "error: cannot read empty: it is not an HDF5 file, or damaged\n"),
    ],
)
def test_trouble(words, message, run, tmp_path):
    for name in ("a.h5", "b.h5"):
        write(tmp_path / name)
    (tmp_path / "text").write_text("no HDF5\n" * 100)
    (tmp_path / "empty").touch()
    result = run("diff", *words)
    assert result.status == 2
    assert result.out == ""
    assert result.err.startswith(message)


def test_usage_tells_the_built_in_rules(run):
    for words in (["diff", "--help"], ["help", "diff"]):
        result = run(*words)
        assert result.status == 0
        assert "/provenance/*           ignore" in result.out


def test_full_disk(executable, tmp_path):
    if not os.path.exists("/dev/full"):
        pytest.skip("there is no /dev/full here")
    write(tmp_path / "a.h5")
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [executable, "diff", "a.h5", "a.h5"],
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == "error: cannot write to the standard output: No space left on device\n"


def test_a_file_that_is_being_written(run, tmp_path):
    write(tmp_path / "a.h5")
    with h5py.File(tmp_path / "b.h5", "w"):
        result = run("diff", "a.h5", "b.h5")
    assert result.status == 2
    assert result.err == "error: cannot read b.h5: another program has it open\n"


def test_unfinished_file(run, scene, tmp_path):
    assert run("run", scene.name, "-q", "-o", "a.h5").status == 0
    shutil.copy(tmp_path / "a.h5", tmp_path / "b.h5.part")
    with h5py.File(tmp_path / "b.h5.part", "r+") as f:
        f.attrs["status"] = "interrupted"
        for item in f["trajectory"].values():
            if item.maxshape[0] is None:
                item.resize(11, axis=0)
    result = run("diff", "a.h5", "b.h5.part")
    assert result.status == 1
    assert "21 times in A, 11 times in B" in result.out
    (tmp_path / "rules").write_text("/@status ignore\n")
    result = run("diff", "a.h5", "b.h5.part", "--until", "0.01", "--rules", "rules")
    assert result.status == 0, result.out


# ---- The page ----------------------------------------------------------------------------------


def test_page(executable, root, inputs, tmp_path):
    """The commands of docs/diff.md, run one after the other, print what the page shows."""
    shutil.copy(inputs / "tippe_top.nml", tmp_path)
    page = (root / "docs" / "diff.md").read_text()
    number = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
    n_compared = 0
    for block in re.findall(r"^```\n(\$ .*?)^```$", page, re.MULTILINE | re.DOTALL):
        for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, shown = part.partition("\n")
            if command.startswith("cat "):
                (tmp_path / command.split()[1]).write_text(shown)
            done = subprocess.run(
                ["bash", "-c", command],
                cwd=tmp_path,
                env={**os.environ, "PATH": f"{executable.parent}{os.pathsep}{os.environ['PATH']}"},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                timeout=120,
                check=False,
            )
            found = done.stdout
            assert re.sub(r" +", " ", number.sub("0", found)) == re.sub(
                r" +", " ", number.sub("0", shown)
            ), f"{command}\n{found}"
            # Counts of steps depend on the build.
            found, shown = (re.sub(r"/integrator.*\n.*\n", "", text) for text in (found, shown))
            for x, y in zip(number.findall(found), number.findall(shown), strict=True):
                assert float(x) == pytest.approx(float(y), rel=0.02), f"{command}\n{found}"
                n_compared += 1
    assert n_compared > 20


# ---- Damaged and hostile files -----------------------------------------------------------------


def mutate(data, rng):
    """Damage some bytes."""
    way = rng.randrange(6)
    if way == 0:
        return data[: rng.randrange(len(data))]
    damaged = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 4, 16])):
        i = rng.randrange(len(data))
        if way == 1:
            piece = bytes([data[i] ^ (1 << rng.randrange(8))])
        elif way == 2:
            piece = rng.randbytes(1)
        elif way == 3:
            piece = b"\xff" * rng.choice([2, 4, 8])
        elif way == 4:
            width = rng.choice([1, 2, 4, 8])
            value = rng.choice([0, 1, 2**31, 2**40, 2**63, len(data), rng.randrange(len(data))])
            piece = (value % 256**width).to_bytes(width, "little")
        else:
            j = rng.randrange(len(data))
            piece = data[j : j + rng.choice([1, 8, 32, 128])]
        piece = piece[: len(data) - i]
        damaged[i : i + len(piece)] = piece
    return bytes(damaged)


def rich(f):
    """What the output of a run has not."""
    f["fixed"] = np.array([b"ab", b"cde"])
    f["pair"] = np.array([(1, 2.0)], dtype=[("a", "i4"), ("b", "f8")])
    f["flag"] = np.array([True, False])
    f["null"] = h5py.Empty("f8")
    f["soft"] = h5py.SoftLink("/fixed")
    f["many/loop"] = f["/"]
    for i in range(20):
        f["fixed"].attrs[f"a{i}"] = 1.5 * i
        f.create_group(f"many/g{i}")


@pytest.mark.parametrize("kind", ["plain", "compressed", "new"])
def test_damaged_files(kind, run, tmp_path):
    options = {
        "plain": {},
        "compressed": {"compression": "gzip", "chunks": (20,)},
        "new": {"libver": ("earliest", "v110"), "compression": "gzip", "chunks": (7,)},
    }[kind]
    write(tmp_path / "whole.h5", rich, n=100, **options)
    data = (tmp_path / "whole.h5").read_bytes()
    assert run("diff", "whole.h5", "whole.h5").status == 0
    rng = random.Random(f"20261121 {kind}")
    n_damaged = 0
    for i in range(MUTANTS // 3):
        (tmp_path / "damaged.h5").write_bytes(mutate(data, rng))
        names = ["whole.h5", "damaged.h5"][:: rng.choice([1, -1])]
        result = run("diff", *names, timeout=60)
        about = f"mutant {i}: {result}"
        assert result.status in (0, 1, 2), about
        assert (result.status == 2) == result.err.startswith("error: "), about
        assert "mistake in the program" not in result.err, about
        n_damaged += result.status != 0
    assert n_damaged > MUTANTS // 30


@pytest.mark.parametrize("size", [0, 1, 8, 100, 2000, -1000, -1])
def test_truncated(size, run, tmp_path):
    write(tmp_path / "a.h5")
    data = (tmp_path / "a.h5").read_bytes()
    (tmp_path / "b.h5").write_bytes(data[:size])
    result = run("diff", "a.h5", "b.h5")
    assert result.status == 2
    assert result.err.startswith("error: cannot read b.h5: ")


def measured(executable, folder, *words):
    """Run a comparison; its exit status, stderr, peak of memory [MiB] and CPU time [s]."""
    code = (
        "import resource, subprocess, sys\n"
        "p = subprocess.run(sys.argv[1:], capture_output=True, text=True, timeout=100)\n"
        "used = resource.getrusage(resource.RUSAGE_CHILDREN)\n"
        "print(p.returncode, used.ru_maxrss / 1024, used.ru_utime + used.ru_stime)\n"
        "print(p.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(executable), "diff", *words],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    head, _, err = done.stdout.partition("\n")
    status, peak, seconds = head.split()
    return int(status), err, float(peak), float(seconds)


def test_hostile_sizes(executable, sanitized, tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as f:
        f.create_dataset("x", shape=(2**50,), chunks=(1000,), dtype="f8")
    with h5py.File(tmp_path / "b.h5", "w") as f:
        f.create_dataset("x", shape=(1000, 2**20), chunks=(1, 2**20), dtype="f8", compression=9)
        f["x"][0] = 0.0
    with h5py.File(tmp_path / "c.h5", "w") as f:
        f.create_dataset("x", shape=(2**40,), chunks=(2**28,), dtype="f8", compression=1)
    with h5py.File(tmp_path / "d.h5", "w") as f:
        f.create_dataset("x", shape=(2**40,), chunks=(1000,), dtype=TEXT)
    message = "it claims more values than a file of this size can hold"
    for name, words in {
        "a.h5": message,
        "b.h5": message,
        "c.h5": "a compressed chunk has more than 128 MiB",
        "d.h5": message,
    }.items():
        status, err, peak, seconds = measured(executable, tmp_path, name, name)
        assert status == 2, name
        assert f"object /x: {words}" in err, name
        # Bounded, that is: other builds are several times slower.
        assert seconds < 60.0, name
        if not sanitized:
            assert peak < 200.0, name


def test_values_in_other_files_are_not_read(run, tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as f:
        f.create_dataset("x", shape=(10,), dtype="f8", external=[("/dev/zero", 0, 80)])
    result = run("diff", "a.h5", "a.h5")
    assert result.status == 2
    assert result.err == "error: cannot read a.h5, object /x: its values are in another file\n"


def test_deep_and_cyclic_groups(run, tmp_path):
    with h5py.File(tmp_path / "deep.h5", "w") as f:
        group = f
        for _ in range(500):
            group = group.create_group("g")
    result = run("diff", "deep.h5", "deep.h5")
    assert result.status == 2
    assert result.err.startswith("error: groups nested more than 100 deep are not compared: /g/g/g")
    # Each group holds the next one twice: 2**60 paths.
    with h5py.File(tmp_path / "wide.h5", "w") as f:
        groups = [f.create_group(f"g{i}") for i in range(60)]
        for one, two in itertools.pairwise(groups):
            one["left"] = two
            one["right"] = two
        groups[-1]["home"] = f["/"]
    result = run("diff", "wide.h5", "wide.h5", timeout=60)
    assert result.status == 2
    assert result.err == (
        "error: groups with more than 16 paths are not compared under all of them\n"
    )


def test_memory_does_not_grow(executable, sanitized, tmp_path):
    peaks = []
    for n in (100_000, 2_000_000):
        for name in ("a.h5", "b.h5"):
            write(tmp_path / name, n=n)
        status, err, peak, _ = measured(executable, tmp_path, "a.h5", "b.h5")
        assert (status, err) == (0, "\n")
        peaks.append(peak)
    if not sanitized:
        assert peaks[1] < peaks[0] + 16.0
        assert peaks[1] < 100.0
