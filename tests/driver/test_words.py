"""Messages that say what would be right, warnings, and what a run tells at its end."""

from __future__ import annotations

import os
import re

import h5py
import pytest

BALL = """\
&scene gravity = 0, 0, -9.81, t_end = 0.4 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', mass = 0.0327, inertia = 3*1.31e-6, position = 0, 0, 0.51, spin = 0, 50.0, 0 /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 0.01, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'steel' /
&contact name = 'ball_floor', surfaces = 'ball', 'floor', damping = 'hunt_crossley', restitution = 0.8,
         friction = 'contensou_exact', friction_coefficient = 0.2 /
&output file = 'ball.h5', interval = 1.0e-3 /
"""  # noqa: E501
WARNING = re.compile(r"ball\.nml:(\d+):\d+: warning: (.*)")


@pytest.fixture
def check(run, tmp_path):
    """Check the ball with some words in place of others; what came of it."""

    def check_it(*changes, words=(), command="check"):
        text = BALL
        for old, new in changes:
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        (tmp_path / "ball.nml").write_text(text)
        return run(command, "ball.nml", *words)

    return check_it


def test_a_scene_is_no_sweep(check, run, mistakes, inputs):
    """One mistake, and not one for each group."""
    done = check(command="sweep")
    assert done.status == 2
    (mistake,) = mistakes(done.err)
    assert mistake.message == "this is a scene, not a sweep"
    assert "contensou run ball.nml" in done.err
    sweep = inputs / "sweeps" / "impact_angle.nml"
    done = run("run", sweep, "-o", "out.h5")
    assert done.status == 2
    (mistake,) = mistakes(done.err)
    assert mistake.message == "this is a sweep, not a scene"
    assert f"contensou sweep {sweep}" in done.err


# --- 9: the nearest real key --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("ball.mas", "body.ball.mass"),
        ("ball.radus", "surface.ball.radius"),
        ("ball.postion(3)", "body.ball.position"),
        ("ball.agle", "body.ball.angle or surface.ball.angle"),
        ("ball.zzz", "one of name, motion, mass, "),
    ],
)
def test_a_misspelt_key_of_a_name_that_two_have(check, mistakes, path, expected):
    done = check(words=("--set", f"{path}=1"))
    assert done.status == 2
    (mistake,) = mistakes(done.err)
    key = path.partition(".")[2].partition("(")[0]
    assert mistake.message == f"unknown key '{key}' of 'ball', &body and &surface"
    assert mistake.expected.startswith(expected)


@pytest.mark.parametrize(
    ("group", "key", "expected"),
    [
        ("body", "radius", "'radius' in &surface or &defaults, or radius_of_gyration"),
        ("body", "young", "'young' in &material"),
        ("surface", "t_end", "'t_end' in &scene"),
        ("body", "gravty", "'gravity' in &scene"),
        ("surface", "mas", "'mass' in &body"),
        ("body", "stifness", "'stiffness' in &spring"),
        ("body", "zzzzzzzz", "one of name, motion, mass, "),
    ],
)
def test_a_key_in_the_wrong_group(check, mistakes, group, key, expected):
    done = check((f"&{group} name = 'ball',", f"&{group} name = 'ball', {key} = 1,"))
    assert done.status == 2
    (mistake,) = mistakes(done.err)
    assert mistake.message == f"unknown key '{key}' in group &{group}"
    assert mistake.expected.startswith(expected)


# --- 10: numbers --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "message", "expected"),
    [
        ("mass", "1 kg", "'kg' behind a number: values are plain numbers in SI units", "1 without"),
        ("mass", "32.7 g", "'g' behind a number", "0.0327 without a unit, which is in kg"),
        ("mass", "32.7g", "'g' behind a number", "0.0327 without a unit, which is in kg"),
        ("mass", "'0.0327 kg'", "'kg' behind a number", "0.0327 without a unit"),
        ("mass", "0.0327 'kg'", "'kg' behind a number", "0.0327 without a unit"),
        ("mass", "0.0327 [kg]", "'[kg]' behind a number", "0.0327 without a unit"),
        ("mass", "\u22121", "'\u22121' has a Unicode minus (U+2212)", "-1, with the minus of a"),
        ("mass", "\u20131", "has a dash (U+2013)", "-1, with the minus of a keyboard"),
        ("mass", "\u00a00.03", "has a no-break space (U+00A0)", "0.03, with plain blanks"),
        ("mass", "0.03\u00a0kg", "has a no-break space", "0.03 without a unit, which is in kg"),
        ("mass", "0,0327", "a comma separates values", "a decimal point in 0.0327"),
        ("mass", "3,27e-2", "a comma separates values", "a decimal point in its place"),
        ("mass", "'0,0327'", "'0,0327' has a decimal comma", "0.0327"),
        ("young", "210 GPa", "'GPa' behind a number", "2.1e11 without a unit, which is in Pa"),
        ("young", "210 zorks", "'zorks' behind a number", "210"),
        ("radius", "10 mm", "'mm' behind a number", "0.01 without a unit, which is in m"),
        ("t_end", "400 ms", "'ms' behind a number", "0.4 without a unit, which is in s"),
        ("restitution", "0,8", "a comma separates values", "a decimal point in 0.8"),
        ("gravity", "0, 0, -9,81", "a comma separates values", "a decimal point in -9.81"),
        ("gravity", "0, 0, -9.81 m/s2", "'m/s2' behind a number", "-9.81 without a unit"),
        ("mass", "2^3", "'2^3': '^' is no operator", "** for a power"),
        ("gravity", "0,0,-9,81", "a comma separates values", "a decimal point in -9.81"),
        ("gravity", "0, 0, -9.81 m s-2", "'m s-2' behind a number", "which is in m/s2"),
        ("mass", "5 degrees", "'degrees' behind a number", "5 deg, or the number in rad"),
        ("mass", "0.5 turn", "'turn' behind a number", "180.0 deg, or the number in rad"),
        ("mass", "2\u00d73", "has a multiplication sign (U+00D7)", "2*3, with the '*' of a key"),
        ("mass", "0\uff0c03", "has a full-width comma (U+FF0C)", "0,03, with the ',' of a key"),
        ("mass", "\uff10.0327", "has a full-width digit (U+FF10)", "0.0327, with the '0' of a"),
        ("radius", "10 deg", "'deg' behind a number: 'radius' is no angle", "a number > 0.0 [m]"),
        ("spin", "0, 50 deg/s, 0", "'deg/s': there are no units", "deg alone, which is in rad/s"),
        ("spin", "0, 3000 rpm, 0", "'rpm' behind a number", "314.159265359 without a unit"),
    ],
)
def test_what_is_no_number_is_named(check, mistakes, key, value, message, expected):
    old = re.search(rf"\b{key} = [^=]*?(?=,\s+\w+ =| /)", BALL)[0]
    done = check((old, f"{key} = {value}"))
    assert done.status == 2
    (mistake,) = mistakes(done.err)
    assert message in mistake.message
    assert expected in mistake.expected


def test_the_same_in_options_and_tables(check, run, mistakes, tmp_path):
    done = check(words=("--set", "ball.mass=32.7 g"))
    assert mistakes(done.err)[0].expected == "0.0327 without a unit, which is in kg"
    done = check(words=("--set", "ball.position(3)=0,01"))
    assert "one value; a decimal point in 0.01, if that is meant" in done.err
    done = check(words=("--set", "ball.mass=1 /"))
    assert "too many values for 'mass'" in mistakes(done.err)[0].message
    done = check(words=("--checkpoint", "5 s"), command="run")
    assert done.status == 2
    assert "'s' behind a number" in done.err
    done = run("eval", "hertz", input="A,B,Estar,delta\n1,1,2 GPa,1e-6\n")
    assert "'GPa' behind a number" in done.err
    (tmp_path / "named.nml").write_text("&constants r = 10 mm / " + BALL)
    found = mistakes(run("check", "named.nml").err)[0]
    assert found.message == "'mm' behind a number: values are plain numbers in SI units"
    assert (found.line, found.column, found.expected[:20]) == (1, 19, "0.01 without a unit,")


def test_a_dash_is_a_pipe_or_refused(check, run, tmp_path):
    """`-o -` writes text to stdout; a file of HDF5 cannot be a pipe."""
    done = check(words=("-o", "-"), command="run")
    assert done.status == 74
    assert "./- is a file" in done.err
    assert check(words=("-q",), command="run").status == 0
    done = run("export", "ball.h5", "--csv", "-c", "time", "-o", "-")
    assert done.out.startswith("time [s]\n0.0\n")
    assert not (tmp_path / "-").exists()


# --- 11: limits, folders, keys that differ ------------------------------------------------------


def test_limits_are_told(check, mistakes):
    done = check(("mass = 0.0327", "mass = 1e200"))
    (mistake,) = mistakes(done.err)
    assert mistake.message.endswith("magnitudes from 1.0E-40 to 1.0E+40")
    done = check(("spin = 0, 50.0, 0", "quaternion = 0, 0, 0, 0"))
    (mistake,) = mistakes(done.err)
    assert mistake.expected.endswith("of any norm but zero, components of 1e-40 to 1e40")


@pytest.mark.parametrize(
    ("name", "trouble"),
    [
        ("none/ball.h5", "its folder none does not exist"),
        ("file/ball.h5", "its folder file is a file, not a folder"),
        ("closed/ball.h5", "its folder closed is not writable"),
    ],
)
def test_which_trouble_a_folder_is(check, tmp_path, name, trouble):
    (tmp_path / "file").touch()
    (tmp_path / "closed").mkdir()
    (tmp_path / "closed").chmod(0o555)
    if name.startswith("closed") and os.access(tmp_path / "closed", os.W_OK):
        pytest.skip("this user may write everywhere")
    done = check(words=("-o", name), command="run")
    assert (done.status, done.out) == (74, "")
    assert done.err == f"error: cannot write {name}: {trouble}\n"


SWEEP = """\
&sweep scene = 'ball.nml', output = 'table.h5', sampling = 'latin_hypercube', cases = 2, seed = 1 /
&parameter name = 'ball.mass', first = 0.03, last = 0.04 /
"""


def test_the_key_that_tells_two_sweeps_apart(run, tmp_path):
    (tmp_path / "ball.nml").write_text(BALL)
    (tmp_path / "sweep.nml").write_text(SWEEP)
    assert run("sweep", "sweep.nml", "-q").status == 0
    for change, difference in (
        (("--set", "scene.t_end=0.3"), "scene.t_end is 0.4 in it and 0.3 here"),
        (("--set", "sweep.seed=2"), "sweep.seed is 1.0 in it and 2.0 here"),
        ((), "parameter.last is 0.04 in it and 0.05 here"),
    ):
        if not change:
            (tmp_path / "sweep.nml").write_text(SWEEP.replace("0.04", "0.05"))
        for command in ("sweep", "merge"):
            done = run(command, "sweep.nml", *change)
            assert done.status == 74
            assert "table.h5 exists and is of another sweep: " in done.err
            assert difference in done.err, done.err
    (tmp_path / "sweep.nml").write_text(SWEEP)
    assert run("sweep", "sweep.nml", "-q", "--force", "--shard", "1/2").status == 0
    words = ("--shard", "2/2", "--set", "scene.t_end=0.3")
    assert run("sweep", "sweep.nml", "-q", "--force", *words).status == 0
    done = run("merge", "table_shard_1_of_2.h5", "table_shard_2_of_2.h5", "-o", "both.h5")
    assert done.status == 2
    assert "different sweeps: scene.t_end is 0.3 in it and 0.4 here" in done.err or (
        "different sweeps: scene.t_end is 0.4 in it and 0.3 here" in done.err
    )


# --- 12: what to do about an overlap ------------------------------------------------------------

SOCKET = "shape = 'sphere', radius = 0.6, centre = 0, 0, 0.5, side = 'inside'"


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            [("normal = 0, 0, 1", "normal = 0, 0, -1")],
            "the normal of surface 'floor' turned round, normal = 0.0, 0.0, 1.0: then the gap is "
            "0.5000 m",
        ),
        (
            [("shape = 'plane', normal = 0, 0, 1", SOCKET.replace(", side = 'inside'", ""))],
            "side = 'inside' of surface 'floor': then the gap is 0.5800 m",
        ),
        (
            [
                ("shape = 'plane', normal = 0, 0, 1", SOCKET),
                ("position = 0, 0, 0.51", "position = 0, 0, 2.0"),
            ],
            "surface 'floor' without side = 'inside': then the gap is 0.8900 m",
        ),
        (
            [("position = 0, 0, 0.51", "position = 0, 0, 0.005")],
            "body 'ball' moved by 0.005000 m along 0.0, 0.0, 1.0, where they just touch: "
            "position = 0.0, 0.0, 0.01",
        ),
    ],
)
def test_what_helps_against_an_overlap(check, mistakes, tmp_path, changes, expected):
    done = check(*changes)
    assert done.status == 2
    (mistake,) = mistakes(done.err)
    assert "overlap by 0." in mistake.message or "E-03 m at the beginning" in mistake.message
    assert not re.search(r"\d\.\d{8}", mistake.message)
    assert mistake.expected.endswith(expected)
    # The advice is right.
    text = (tmp_path / "ball.nml").read_text()
    if "turned round" in expected:
        text = text.replace("0, 0, -1", "0.0, 0.0, 1.0")
    elif "position" in expected:
        text = text.replace("0, 0, 0.005", "0.0, 0.0, 0.01")
    elif "without" in expected:
        text = text.replace(", side = 'inside'", "")
    else:
        text = text.replace("centre = 0, 0, 0.5", "centre = 0, 0, 0.5, side = 'inside'")
    assert check((BALL, text)).status == 0


def test_the_advice_for_a_rigid_contact(check, mistakes):
    rigid = ("damping = 'hunt_crossley'", "normal = 'rigid'")
    done = check(rigid, ("0, 0, 0.51", "0, 0, 0.0099"))
    (mistake,) = mistakes(done.err)
    assert "body 'ball' moved by 1.000E-04 m along 0.0, 0.0, 1.0" in mistake.expected
    assert check(rigid, ("0, 0, 0.51", "0.0, 0.0, 0.01")).status == 0


# --- 13: warnings -------------------------------------------------------------------------------

WALL = "&surface name = 'wall', body = 'ground', shape = 'plane', material = 'steel' /"
WARNED = [
    (
        [("&output", f"{WALL}\n&output")],
        8,
        "surface 'wall' is in no contact",
    ),
    (
        [
            ("gravity = 0, 0, -9.81, ", ""),
            ("&output", "&body name = 'b', mass = 1, inertia = 3*1 /\n&output"),
        ],
        8,
        "nothing acts on body 'b'",
    ),
    (
        [("3*1.31e-6", "3*1")],
        3,
        "the moment of inertia of body 'ball' of 1.000 kg m2 is",
    ),
    (
        [("restitution = 0.8", "damping_coefficient = 1e9")],
        6,
        "contact 'ball_floor' is overdamped",
    ),
    ([("coefficient = 0.2", "coefficient = 2.1")], 7, "a friction coefficient of 2.1 is larger"),
    (
        [("'contensou_exact'", "'coulomb', regularization_velocity = 1")],
        7,
        "a regularization_velocity of 1.0 m/s is not small",
    ),
]


@pytest.mark.parametrize(("changes", "line", "message"), WARNED)
def test_warnings(check, tmp_path, changes, line, message):
    for command in ("check", "run"):
        words = ("--force", "-q") if command == "run" else ()
        done = check(*changes, words=words, command=command)
        assert done.status == 0, done.err
        found = WARNING.findall(done.err)
        assert [int(at) for at, _ in found] == [line]
        assert found[0][1].startswith(message)
    (tmp_path / "ball.h5").unlink()
    for command in ("check", "run"):
        done = check(*changes, words=("--strict",), command=command)
        assert (done.status, done.out) == (2, "")
        assert WARNING.findall(done.err) == found
        assert done.err.endswith(
            "error: 1 warning in ball.nml, and --strict allows none; nothing was run\n"
        )
    assert not (tmp_path / "ball.h5").exists()


def test_what_is_no_reason_for_a_warning(check):
    for changes in (
        [],
        [("coefficient = 0.2", "coefficient = 2")],
        [("3*1.31e-6", "3*3.2e-6")],
        [("restitution = 0.8", "damping_coefficient = 1e3")],
        [("'contensou_exact'", "'coulomb', regularization_velocity = 0.3")],
        # A load moves what is at rest: how fast is not known.
        [
            ("gravity = 0, 0, -9.81, ", ""),
            ("spin = 0, 50.0, 0", "applied_force = 1, 0, 0"),
            ("'contensou_exact'", "'coulomb', regularization_velocity = 0.3"),
        ],
    ):
        done = check(*changes, words=("--strict",))
        assert (done.status, done.err) == (0, "")


def test_warnings_of_a_sweep_are_told_once(run, tmp_path):
    (tmp_path / "ball.nml").write_text(BALL.replace("coefficient = 0.2", "coefficient = 3"))
    (tmp_path / "sweep.nml").write_text(SWEEP)
    for command in ("check", "sweep"):
        done = run(command, "sweep.nml")
        assert done.status == 0
        assert len(WARNING.findall(done.err)) == 1
    assert run("sweep", "sweep.nml", "--strict", "--force").status == 2


def test_the_shipped_scenes_have_no_warnings(run, inputs):
    # The disc has inertia that its spot cannot tip, far more than one of its size.
    for path in sorted(set(inputs.glob("*.nml")) - {inputs / "sliding_disc.nml"}):
        done = run("check", path, "--strict")
        assert (done.status, done.err) == (0, ""), path


@pytest.mark.parametrize("pair", ["'ball', 'floor'", "'floor', 'ball'"])
def test_two_contacts_of_a_pair_are_an_error(check, mistakes, pair):
    done = check(("&output", f"&contact name = 'again', surfaces = {pair} /\n&output"))
    assert done.status == 2
    (mistake,) = mistakes(done.err)
    assert mistake.line == 8
    assert "are those of contact 'ball_floor', too: their forces would add up" in mistake.message
    assert mistake.expected == "one contact for a pair of surfaces"


def test_a_pair_of_two_groups_of_contacts(check, mistakes):
    pairs = "".join(
        f"&contacts surfaces = 'ball', {other}, damping = 'none', friction = 'none' /\n"
        for other in ("'flo*'", "'*'")
    )
    done = check(("'ball_floor', surfaces = 'ball', 'floor'", "'x', surfaces = 'ball', 'roof'"),
        ("&output", f"&surface name = 'roof', body = 'ground', shape = 'plane', "
        f"material = 'steel' /\n{pairs}&output"))  # fmt: skip
    assert done.status == 2
    (mistake,) = mistakes(done.err)
    assert "surfaces 'ball' and 'floor' are a pair of the group &contacts in line" in (
        mistake.message
    )


# --- 14: the summary ----------------------------------------------------------------------------


def test_the_summary_tells_where_bodies_are(check, tmp_path):
    done = check(command="run")
    assert done.status == 0, done.err
    number = r"(-?[\d.E+-]+)"
    three = rf"\({number}, {number}, {number}\)"
    found = re.search(rf"^  body       ball: at {three} m, velocity {three} m/s$", done.out, re.M)
    assert found, done.out
    with h5py.File(tmp_path / "ball.h5") as file:
        last = [*file["trajectory/position"][-1, 0], *file["trajectory/velocity"][-1, 0]]
        spins = file["trajectory/angular_velocity"][[0, -1], 0].ravel()
    assert [float(x) for x in found.groups()] == pytest.approx(last, rel=1e-5, abs=1e-12)
    # No axis of a ball differs from others: it is told how it turns.
    found = re.search(rf"^ +ball: angular velocity {three} -> {three} rad/s$", done.out, re.M)
    assert found, done.out
    assert [float(x) for x in found.groups()] == pytest.approx(spins, rel=1e-5, abs=1e-12)


def test_the_summary_of_a_bearing_is_short(run, inputs):
    done = run("run", inputs / "bearing_6205.nml", "-o", "b.h5", "--set", "scene.t_end=1e-5")
    assert done.status == 0, done.err
    contacts = [line for line in done.out.splitlines() if "torus" in line]
    assert [line[13:] for line in contacts] == [
        f"bearing_{ring}_1..9: torus (inside) on sphere, hertz, hunt_crossley, "
        "contensou_exact with drilling torque, regularised"
        for ring in ("inner", "outer")
    ]
    assert "  bodies     bearing_ball_1..9: x " in done.out
    assert len(done.out.splitlines()) <= 16


@pytest.mark.parametrize("command", ["run", "sweep", "merge"])
def test_quiet_says_nothing_unless_something_is_wrong(run, tmp_path, command):
    (tmp_path / "ball.nml").write_text(BALL)
    (tmp_path / "sweep.nml").write_text(SWEEP)
    if command == "merge":
        assert run("sweep", "sweep.nml", "-q", "--shard", "1/1").status == 0
    name = "ball.nml" if command == "run" else "sweep.nml"
    done = run(command, name, "-q")
    assert (done.status, done.out, done.err) == (0, "", "")
    if command != "run":
        # It is there already.
        done = run(command, name, "-q")
        assert (done.status, done.out, done.err) == (0, "", "")
    done = run(command, name, "-q", "-o", "none/x.h5")
    assert (done.status, done.out) == (74, "")
    assert "its folder none does not exist" in done.err


def test_quiet_of_cost(run, tmp_path):
    """The table is in the files; only the answer that was asked for is printed."""
    (tmp_path / "ball.nml").write_text(BALL)
    few = [
        "--set",
        "cost.rtol=1e-6",
        "--set",
        "cost.methods='explicit8'",
        "--set",
        "cost.repeats=1",
    ]
    done = run("cost", "ball.nml", "-q", "--csv", "a.csv", *few)
    assert (done.status, done.out, done.err) == (0, "", "")
    assert len((tmp_path / "a.csv").read_text().splitlines()) > 1
    done = run("cost", "ball.nml", "-q", "--error", "1e3", *few)
    assert (done.status, done.err) == (0, "")
    assert done.out.startswith("cheapest for an error of 1000.0: ")
    done = run("cost", "ball.nml", "-q", *few)
    assert (done.status, done.out) == (2, "")
    assert "-o FILE or --csv FILE" in done.err


def test_quiet_tells_of_cases_that_failed(run, tmp_path):
    (tmp_path / "ball.nml").write_text(BALL)
    (tmp_path / "sweep.nml").write_text(
        "&sweep scene = 'ball.nml' /\n&parameter name = 'ball.position(3)', values = 0.5, -1 /\n"
    )
    done = run("sweep", "sweep.nml", "-q")
    assert "1 invalid" in done.out + done.err


# --- 18: words ----------------------------------------------------------------------------------


def test_one_is_one(run, tmp_path):
    (tmp_path / "ball.nml").write_text(BALL)
    (tmp_path / "sweep.nml").write_text(
        "&sweep scene = 'ball.nml' /\n&parameter name = 'ball.mass', values = 0.03 /\n"
    )
    done = run("sweep", "sweep.nml", "--shard", "1/2")
    assert done.err == "error: 1 case cannot be divided among 2 shards\n"
    texts = ""
    for words in (("--shard", "1/1"), ("-j", "1"), ()):
        done = run("sweep", "sweep.nml", *words)
        assert done.status == 0, done.err
        texts += done.out + done.err
    texts += run("merge", "sweep.nml", "--force").out
    texts += run("check", "sweep.nml").out
    done = run("run", "ball.nml", "--set", "scene.t_end=1e-3", "--set", "output.interval=1")
    texts += done.out + done.err
    assert not re.search(r"\b1 (cases|shards|threads|tables|touches|steps|rows)\b", texts), texts


def test_a_scene_is_nothing_to_merge(run, tmp_path):
    (tmp_path / "ball.nml").write_text(BALL)
    for words in ((), ("-o", "table.h5")):
        done = run("merge", "ball.nml", *words)
        assert done.status == 2
        assert "ball.nml is a scene: merge joins the tables of shards of a sweep" in done.err


def test_a_sweep_that_is_not_there_is_not_merged(run):
    done = run("merge", "sweep.nml")
    assert (done.status, done.out) == (74, "")
    assert done.err == "error: cannot read sweep.nml: it does not exist\n"


def test_a_run_that_failed(run, tmp_path):
    # Too soft for its impact.
    (tmp_path / "ball.nml").write_text(BALL.replace("2.1e11", "1e4"))
    assert run("run", "ball.nml", "-q").status == 1
    done = run("run", "ball.nml", "-q")
    assert done.status != 0
    assert "of a run that failed" in done.err
    assert "was failed" not in done.err


def test_help_of_a_key_alone(run):
    done = run("help", "mass")
    assert done.status == 0
    assert done.out.startswith("body.mass\n")
    done = run("help", "restitution")
    assert [line for line in done.out.splitlines() if line.endswith(".restitution")] == [
        "contact.restitution", "contacts.restitution", "defaults.restitution", "bearing.restitution"
    ]  # fmt: skip
    assert run("help", "maas").status == 2


@pytest.mark.parametrize(("topic", "usage"), [("sweep", "SWEEP"), ("cost", "SCENE")])
def test_help_of_a_group_that_is_a_command_too(run, topic, usage):
    out = run("help", topic).out
    assert out.startswith(f"&{topic}: ")
    assert f"usage: contensou {topic} {usage}" in out
    assert run(topic, "--help").out.strip() in out
