"""The command line: words and options, help, models, check, --set, eval, progress."""

from __future__ import annotations

import csv
import io
import math
import re
import subprocess

import h5py
import pytest
from terminal import on_terminal

COMMANDS = ["run", "check", "models", "eval", "diff", "help"]
FRICTION = ["coulomb", "contensou_simplified", "pade11", "pade22", "contensou_exact"]
SPOT_MODELS = [name for name in FRICTION if name != "coulomb"]


# --- words and options -----------------------------------------------------------------------


def test_no_command(run):
    result = run()
    assert result.status == 2
    assert result.out == ""
    assert result.err.startswith("error: no command is given\nusage: contensou COMMAND")
    for command in COMMANDS:
        assert re.search(rf"^  {command} ", result.err, re.MULTILINE)


@pytest.mark.parametrize(
    ("word", "meant"),
    [("rn", "run"), ("chek", "check"), ("modles", "models"), ("evel", "eval"), ("RUN", "run")],
)
def test_unknown_command_with_a_near_one(word, meant, run):
    result = run(word)
    assert result.status == 2
    assert result.out == ""
    assert result.err == f"error: unknown command '{word}'; did you mean '{meant}'?\n"


@pytest.mark.parametrize("word", ["plot", "spot", "submit"])
def test_what_is_a_program_of_its_own(word, run):
    result = run(word, "ball.h5")
    assert (result.status, result.out) == (2, "")
    assert result.err == (
        f"error: unknown command '{word}'; contensou-{word} is a program of its own\n"
    )
    assert f"contensou-{word}" in run("--help").out


@pytest.mark.parametrize("word", ["frobnicate", "-x", "--set", ""])
def test_unknown_command(word, run):
    result = run(word)
    assert result.status == 2
    assert result.out == ""
    assert result.err.startswith(f"error: unknown command '{word}'\nusage: contensou COMMAND")


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["run", "top.nml", "--forse"], "--force"),
        (["run", "top.nml", "--outptu", "a.h5"], "--output"),
        (["run", "top.nml", "--sett", "a.b=1"], "--set"),
        (["run", "top.nml", "--qiet"], "--quiet"),
        (["eval", "wrench", "--modle", "pade11"], "--model"),
    ],
)
def test_unknown_option_with_a_near_one(words, meant, run, scene, tmp_path):
    result = run(*words)
    assert result.status == 2
    assert result.out == ""
    unknown = next(word for word in words if word.startswith("--"))
    assert result.err == f"error: unknown option '{unknown}'; did you mean '{meant}'?\n"
    assert [p.name for p in tmp_path.iterdir()] == [scene.name]


@pytest.mark.parametrize(
    "words",
    [
        ["run", "top.nml", "-z"],
        ["run", "top.nml", "--model", "pade11"],
        ["check", "top.nml", "-o", "a.h5"],
        ["check", "top.nml", "--force"],
        ["models", "--set", "a.b=1"],
        ["eval", "wrench", "--force"],
        ["help", "--zebra"],
        ["--version", "-q"],
    ],
)
def test_option_of_another_command(words, run, scene, tmp_path):
    result = run(*words)
    assert result.status == 2
    assert result.out == ""
    unknown = next(word for word in words[1:] if word.startswith("-"))
    assert result.err.startswith(f"error: unknown option '{unknown}'\nusage: contensou ")
    assert [p.name for p in tmp_path.iterdir()] == [scene.name]


@pytest.mark.parametrize(
    "words",
    [
        ["run", "top.nml", "--set"],
        ["run", "top.nml", "-o"],
        ["run", "top.nml", "--output"],
        ["check", "top.nml", "--set"],
        ["eval", "wrench", "--model"],
        ["eval", "wrench", "--delta"],
    ],
)
def test_value_of_an_option_missing(words, run, scene):
    result = run(*words)
    assert result.status == 2
    assert result.out == ""
    assert result.err.startswith(f"error: {words[-1]} needs a value\nusage: contensou {words[0]}")


@pytest.mark.parametrize(
    ("command", "what"), [("run", "scene"), ("check", "scene"), ("eval", "kernel")]
)
def test_operand_missing(command, what, run):
    result = run(command)
    assert result.status == 2
    assert result.out == ""
    assert result.err.startswith(f"error: {command} needs a {what}\nusage: contensou {command}")


@pytest.mark.parametrize(
    "words",
    [
        ["run", "top.nml", "more"],
        ["check", "top.nml", "more"],
        ["models", "hertz", "more"],
        ["help", "body", "more"],
        ["--version", "more"],
        ["eval", "wrench", "a.csv", "more"],
    ],
)
def test_one_operand_too_many(words, run, scene, tmp_path):
    result = run(*words)
    assert result.status == 2
    assert result.out == ""
    assert result.err.startswith("error: unexpected word 'more'\nusage: contensou ")
    assert [p.name for p in tmp_path.iterdir()] == [scene.name]


def test_operands_that_look_like_options(run, tmp_path, scene_text):
    (tmp_path / "--odd.nml").write_text(scene_text)
    result = run("check", "--", "--odd.nml")
    assert result.status == 0
    assert result.out.startswith("--odd.nml is in order\n")


def test_options_in_any_order_and_form(run, scene, tmp_path):
    for i, words in enumerate(
        [
            ["-q", "-o", "0.h5", "top.nml"],
            ["top.nml", "--quiet", "--output", "1.h5"],
            ["--output=2.h5", "top.nml", "--set=scene.t_end=0.01", "-q"],
        ]
    ):
        result = run("run", *words)
        assert result.status == 0, result.err
        assert result.err == ""
        assert (tmp_path / f"{i}.h5").is_file()


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("option", ["--help", "-h"])
def test_usage_of_a_command(command, option, run, tmp_path):
    result = run(command, option)
    assert result.status == 0
    assert result.err == ""
    assert result.out.startswith(f"usage: contensou {command}")
    assert not list(tmp_path.iterdir())
    options = {
        "run": ["--set", "-o", "--force", "-q"],
        "check": ["--set"],
        "eval": ["--model", "--delta", "N,a,b,f,vx,vy,w"],
    }
    for word in options.get(command, []):
        assert word in result.out


@pytest.mark.parametrize("option", ["--help", "-h"])
def test_usage_of_the_program(option, run):
    result = run(option)
    assert result.status == 0
    assert result.err == ""
    for command in [*COMMANDS, "--version"]:
        assert re.search(rf"^  {command}\b", result.out, re.MULTILINE), "a command is not named"


@pytest.mark.parametrize("word", ["--version", "-V", "version"])
def test_version(word, run):
    result = run(word)
    assert result.status == 0
    assert result.err == ""
    assert re.match(r"contensou \d+\.\d+\.\d+\n", result.out)
    for name in ("commit ", "SUNDIALS ", "HDF5 ", "GSL "):
        assert name in result.out
    lines = dict(line.split(maxsplit=1) for line in result.out.splitlines()[1:])
    assert re.fullmatch(r"[0-9a-f]{7,}(-dirty)?|unknown", lines["commit"])
    assert lines["compiler"].startswith("GCC version ")
    assert re.match(r"\w+, optimization \w", lines["build"])
    assert re.fullmatch(
        r"SUNDIALS \d+\.\d+\.\d+, HDF5 \d+\.\d+\.\d+, GSL \d+\.\d+(\.\d+)?", lines["libraries"]
    )
    for kind in ("trajectory", "sweep", "cost", "bench", "checkpoint"):
        assert re.search(rf"contensou-{kind} \d", lines["files"])


def test_version_tells_the_formats_that_are_written(run, scene, tmp_path):
    """Those of --version are those of the files."""
    assert run("run", scene.name, "-q").status == 0
    with h5py.File(tmp_path / "top.h5") as file:
        told = f"{file.attrs['filetype']} {file.attrs['filetype_version']}"
    assert told in run("--version").out


# --- help ------------------------------------------------------------------------------------


@pytest.fixture
def keys(run):
    """Groups of the help page, each with its keys and their short descriptions."""
    result = run("help")
    assert result.status == 0
    assert result.err == ""
    groups: dict[str, dict[str, str]] = {}
    for line in result.out.splitlines():
        if line.startswith("&"):
            groups[line[1 : line.index(":")]] = current = {}
        elif line.startswith("    "):
            name, short = line.split(maxsplit=1)
            current[name] = short
    return groups


def test_help_lists_all_groups(keys):
    expected = "scene material body surface contact integrator output bearing constants defaults"
    expected += " contacts stop cost spring sweep parameter value"
    assert list(keys) == expected.split()
    assert sum(len(group) for group in keys.values()) >= 40


def test_help_of_every_group(keys, run):
    for group, own in keys.items():
        result = run("help", group)
        assert result.status == 0
        assert result.out.startswith(f"&{group}: ")
        assert re.findall(rf"^{group}\.(\w+)$", result.out, re.MULTILINE) == list(own)


def test_help_of_every_key(keys, run, sample):
    for group, own in keys.items():
        for key, short in sample(own.items(), 3):
            result = run("help", f"{group}.{key}")
            assert result.status == 0
            assert result.err == ""
            title, explanation, domain = result.out.splitlines()
            assert title == f"{group}.{key}"
            assert len(explanation.strip()) > 3
            assert domain == f"    {short}"


def test_help_in_any_case(run):
    assert run("help", "Body.MASS").out == run("help", "body.mass").out


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        ("boddy", "a scene or sweep has no group 'boddy'; did you mean 'body'?"),
        ("zebra", "a scene or sweep has no group 'zebra'; contensou help lists them"),
        ("body.mas", "group 'body' has no key 'mas'; did you mean 'mass'?"),
        ("body.zebra", "group 'body' has no key 'zebra'; contensou help body lists them"),
        ("integratr.rtol", "a scene or sweep has no group 'integratr'; did you mean 'integrator'?"),
    ],
)
def test_help_of_something_unknown(topic, message, run):
    result = run("help", topic)
    assert result.status == 2
    assert result.out == ""
    assert result.err == f"error: {message}\n"


# --- models ----------------------------------------------------------------------------------


def models_of(text: str) -> dict[str, list[str]]:
    tables: dict[str, list[str]] = {}
    for line in text.splitlines():
        if not line.startswith(" "):
            tables[re.search(r"\((.*)\)", line)[1]] = names = []
        elif not line.startswith("   "):
            names.append(line.strip())
    return tables


def test_models_are_those_that_a_scene_admits(run, keys):
    result = run("models")
    assert result.status == 0
    assert result.err == ""
    tables = models_of(result.out)
    for key in ("normal", "damping", "friction", "rolling", "tangential", "creep", "spot"):
        admitted = keys["contact"][key].partition(",")[0].split(" | ")
        assert tables[f"contact.{key}"] == admitted
    assert tables["contact.friction"] == ["none", *FRICTION]
    assert tables["contact.surfaces"][0] == "sphere, plane"
    shapes = keys["surface"]["shape"].partition(",")[0].split(" | ")
    assert {shape for pair in tables["contact.surfaces"] for shape in pair.split(", ")} == set(
        shapes
    )
    assert len(tables["contact.surfaces"]) == 24


def test_every_model_by_its_name(run):
    for names in models_of(run("models").out).values():
        for name in names:
            result = run("models", name)
            assert result.status == 0
            assert f"\n  {name}\n      " in "\n" + result.out
            assert name in models_of(result.out)[next(iter(models_of(result.out)))]
            assert run("models", name.upper()).out == result.out


def test_models_name_their_keys_and_units(run):
    assert "damping_coefficient alpha [s/m]" in run("models", "hunt_crossley").out
    assert "regularization_velocity [m/s]" in run("models", "coulomb").out
    assert "reference: " in run("models", "contensou_exact").out


def test_laws_of_creep_tell_what_they_are(run):
    described = run("models", "strip").out
    assert described.startswith("law of creep (contact.creep)\n  strip\n      Carter's solution")
    assert "reference: D. J. Haines, E. Ollerton" in described


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("pade12", "there is no model 'pade12'; did you mean 'pade11'?"),
        ("herz", "there is no model 'herz'; did you mean 'hertz'?"),
        ("zebra", "there is no model 'zebra'; contensou models lists them"),
    ],
)
def test_unknown_model(name, message, run):
    result = run("models", name)
    assert result.status == 2
    assert result.out == ""
    assert result.err == f"error: {message}\n"


# --- check -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "contact", "unknowns"),
    [
        ([], "hunt_crossley, contensou_exact with drilling torque", 15),
        (
            ["contact.drilling=.false."],
            "hunt_crossley, contensou_exact without drilling torque",
            15,
        ),
        (["contact.friction=none"], "hunt_crossley", 14),
        (["contact.damping=none"], "contensou_exact with drilling torque", 14),
        (["contact.friction=none", "contact.damping=none"], "", 13),
        (
            ["contact.friction=coulomb", "contact.regularization_velocity=1e-3"],
            "hunt_crossley, coulomb, regularised",
            15,
        ),
        (
            ["contact.friction=pade22", "contact.regularization_velocity=1e-3"],
            "hunt_crossley, pade22 with drilling torque, regularised",
            15,
        ),
        (
            ["contact.damping=tsuji", "contact.damping_coefficient=0.1"],
            "tsuji, contensou_exact with drilling torque",
            15,
        ),
    ],
)
def test_check_names_the_effects(options, contact, unknowns, run, scene, tmp_path):
    words = [word for option in options for word in ("--set", option)]
    before = scene.read_bytes()
    result = run("check", scene.name, *words)
    assert result.status == 0, result.err
    assert result.err == ""
    effects = result.out.partition("effects\n")[2].partition("cost\n")[0].splitlines()
    full = "sphere on plane, hertz" + (f", {contact}" if contact else "")
    work = "".join(
        f", work of {name}"
        for name in ("friction", "damping")
        if f"contact.{name}=none" not in options
    )
    assert effects == [
        "  gravity    9.8100 m/s2",
        "  bodies     1, rigid and free",
        f"  contact    ball_floor: {full}",
        f"  contact    stem_floor: {full}",
        f"  unknowns   {unknowns}: 13 for each body{work}",
    ]
    assert [p.name for p in tmp_path.iterdir()] == [scene.name]
    assert scene.read_bytes() == before


def test_check_without_gravity_and_contacts(run, tmp_path, scene_text):
    text = re.sub(r"&contact.*?\n/\n", "", scene_text, flags=re.DOTALL)
    (tmp_path / "free.nml").write_text(text.replace("gravity = 0, 0, -9.81, ", ""))
    result = run("check", "free.nml")
    assert result.status == 0, result.err
    effects = result.out.partition("effects\n")[2].partition("cost\n")[0]
    assert "gravity" not in effects
    assert "contact    none" in effects
    assert "unknowns   13:" in effects
    assert "gravity = 0.0, 0.0, 0.0" in result.out


@pytest.mark.parametrize("method", ["cvode_bdf", "cvode_adams", "explicit8"])
def test_top_that_grazes_the_floor_without_gravity(method, run, scene):
    words = ["--set", "scene.gravity=0,0,0", "--set", f"integrator.method={method}"]
    words += ["--set", "scene.t_end=0.2"]
    result = run("check", scene.name, *words)
    assert "failed" not in result.out
    result = run("run", scene.name, *words)
    assert result.status == 0, result.err


def test_check_reports_the_cost(run, scene):
    result = run("check", scene.name)
    cost = result.out.partition("\ncost\n")[2].partition("\nsettings\n")[0]
    assert re.search(r"right-hand side +[\d.]+ ns", cost)
    assert re.search(r"whole run +about \S+ s of CPU", cost)
    assert re.search(r"output +21 rows, ", cost)
    assert float(re.search(r"right-hand side +(\S+) ns", cost)[1]) > 5


# --- --set -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("option", "group", "name", "key", "values"),
    [
        ("scene.t_end=0.01", "scene", None, "t_end", [0.01]),
        ("integrator.rtol=1e-6", "integrator", None, "rtol", [1e-6]),
        ("integrator.rtol = 1d-6", "integrator", None, "rtol", [1e-6]),
        ("top.mass=0.007", "body", "top", "mass", [0.007]),
        ("TOP.Mass=0.007", "body", "top", "mass", [0.007]),
        ("body.mass=0.007", "body", "top", "mass", [0.007]),
        ("body.top.mass=0.007", "body", "top", "mass", [0.007]),
        ("surface.ball.radius=0.014", "surface", "ball", "radius", [0.014]),
        ("ball.radius=0.014", "surface", "ball", "radius", [0.014]),
        ("wood.young=1e9", "material", "wood", "young", [1e9]),
        ("ball_floor.friction_coefficient=0.1", "contact", "ball_floor", None, [0.1]),
        ("top.spin=0,0,150", "body", "top", "spin", [0, 0, 150]),
        ("top.spin=0 0 150", "body", "top", "spin", [0, 0, 150]),
        ("top.inertia=3*1e-6", "body", "top", "inertia", [1e-6, 1e-6, 1e-6]),
        ("top.velocity=0.1,0,0", "body", "top", "velocity", [0.1, 0, 0]),
        ("stem_floor.friction=pade11", "contact", "stem_floor", "friction", ["pade11"]),
        ("stem_floor.friction='pade11'", "contact", "stem_floor", "friction", ["pade11"]),
        ('stem_floor.friction="pade11"', "contact", "stem_floor", "friction", ["pade11"]),
        ("stem_floor.friction=PADE11", "contact", "stem_floor", "friction", ["pade11"]),
        ("stem_floor.drilling=.false.", "contact", "stem_floor", "drilling", [False]),
        ("stem_floor.drilling=F", "contact", "stem_floor", "drilling", [False]),
        ("stem_floor.drilling=false", "contact", "stem_floor", "drilling", [False]),
        ("ball_floor.surfaces=floor,ball", "contact", "ball_floor", "surfaces", ["floor", "ball"]),
        ("ball_floor.surfaces='floor','ball'", "contact", "ball_floor", None, ["floor", "ball"]),
        ("scene.title=Hello world", "scene", None, "title", ["Hello world"]),
        ("scene.title='a = b, c'", "scene", None, "title", ["a = b, c"]),
        ("scene.title='it''s'", "scene", None, "title", ["it's"]),
        ("scene.title=''", "scene", None, "title", [""]),
        ("output.file=a/b.h5", "output", None, "file", ["a/b.h5"]),
    ],
)
def test_set(option, group, name, key, values, run, scene, settings):
    key = key or re.search(r"\.(\w+)=", option)[1]
    plain = settings(run("check", scene.name).out)
    result = run("check", scene.name, "--set", option)
    assert result.status == 0, result.err
    assert result.err == ""
    n_changed = 0
    for (_, before), (kind, after) in zip(plain, settings(result.out), strict=True):
        here = kind == group and name in (None, after.get("name", [None])[0])
        n_changed += here
        if here:
            assert after[key] == values
        for other in before.keys() - {"length_scale"}:
            if not (here and other == key):
                assert after[other] == before[other]
    assert n_changed == 1


def test_set_repeated_groups_all_at_once(run, scene, settings):
    result = run("check", scene.name, "--set", "contact.friction=pade22")
    assert result.status == 0
    contacts = [v for g, v in settings(result.out) if g == "contact"]
    assert [v["friction"] for v in contacts] == [["pade22"], ["pade22"]]


def test_set_last_one_counts(run, scene, settings):
    words = ["--set", "top.mass=1", "--set", "body.mass=2", "--set", "top.mass=3"]
    result = run("check", scene.name, *words)
    assert result.status == 0
    assert [v["mass"] for g, v in settings(result.out) if g == "body"] == [[3]]


def test_set_adds_the_groups_that_may_be_left_out(run, tmp_path, scene_text, settings):
    text = re.sub(r"&(integrator|output).*\n", "", scene_text)
    (tmp_path / "bare.nml").write_text(text)
    words = ["--set", "integrator.rtol=1e-5", "--set", "integrator.method=cvode_adams"]
    result = run("check", "bare.nml", *words, "--set", "output.interval=0.002")
    assert result.status == 0, result.err
    values = dict(settings(result.out))
    assert values["integrator"]["rtol"] == [1e-5]
    assert values["integrator"]["method"] == ["cvode_adams"]
    assert values["output"] == {"file": ["bare.h5"], "interval": [0.002]}


def test_set_mends_a_scene(run, tmp_path, scene_text):
    text = scene_text.replace("mass = 6.0e-3", "mass = -1.0").replace("t_end = 0.02", "")
    (tmp_path / "wrong.nml").write_text(text)
    assert run("check", "wrong.nml").status == 2
    result = run("check", "wrong.nml", "--set", "top.mass=6e-3", "--set", "scene.t_end=0.01")
    assert result.status == 0, result.err


@pytest.mark.parametrize(
    ("option", "message", "hint"),
    [
        ("top.mas=1", "unknown key 'mas' in group &body", "mass"),
        ("tip.mass=1", "the scene has no group or name 'tip'", "top.mass"),
        ("elephant.mass=1", "the scene has no group or name 'elephant'", "the name of a group"),
        ("integratr.rtol=1", "the scene has no group or name 'integratr'", "integrator.rtol"),
        ("integrator.zebra=1", "unknown key 'zebra' in group &integrator", "one of method, rtol"),
        ("a.b.c=1", "the scene has no group or name 'a.b'", "the name of a group"),
        ("contact.ball.radius=1", "the scene has no group or name 'contact.ball'", "name"),
        ("mass=1", "'mass' does not say what to set", "group.key or name.key, as top.mass"),
        ("t_end=1", "'t_end' does not say", "group.key or name.key, as scene.t_end"),
        ("ball.friction=none", "no group or name 'ball' with a key 'friction'", "ball_floor.fri"),
        ("xyz.rtol=1", "'xyz' with a key 'rtol'", "a group with that key: integrator.rtol"),
        ("constants.r=1", "the scene has no group &constants", "a group &constants in the scene"),
        (".mass=1", "'.mass' does not say what to set", "group.key or name.key"),
        ("top.=1", "'top.' does not say what to set", "group.key or name.key"),
        ("=1", "does not say what to set", "group.key or name.key"),
        ("top.mass", "'=' is missing", "--set group.key=value"),
        ("", "'=' is missing", "--set group.key=value"),
        ("top.mass=", "no value for 'mass' in group &body", "a number > 0.0 [kg]"),
        ("top.mass=-1", "'mass' is out of range", "a number > 0.0 [kg]"),
        ("top.mass=nan", "'mass' must be finite", "a number > 0.0 [kg]"),
        ("top.mass=heavy", "'mass' needs a number, this is a text", "a number > 0.0 [kg]"),
        ("top.mass='1'", "'mass' needs a number, this is a text", "a number > 0.0 [kg]"),
        ("top.mass=1e400", "'1e400' is too large for double precision", "a magnitude below"),
        ("top.mass=1,2", "too many values for 'mass'", "a number > 0.0 [kg]"),
        ("top.mass=1 /", "too many values for 'mass'", "a number > 0.0 [kg]"),
        ("top.spin=1,2", "'spin' has 2 of 3 values", "3 numbers [rad s-1]"),
        ("ball_floor.drilling=no", "'drilling' needs a logical", ".true. or .false."),
        ("ball_floor.friction=pade12", "unknown friction 'pade12'", "'pade11'"),
        ("ball_floor.friction=coulomb", "friction 'coulomb' needs", "regularization_velocity = "),
        ("ball_floor.surfaces=ball,flor", "there is no surface 'flor'", "'floor'"),
        ("ball_floor.surfaces=ball,'fl*'", "there is no surface 'fl*'", "&contacts takes patterns"),
        ("scene.title='open", "text is not closed in its line", "a closing '"),
    ],
)
def test_set_wrong(option, message, hint, run, scene, mistakes, tmp_path):
    result = run("run", scene.name, "--set", option)
    assert result.status == 2
    assert result.out == ""
    (mistake,) = mistakes(result.err)
    assert mistake.source == f"--set {option}"
    assert message in mistake.message
    assert hint in mistake.expected
    if mistake.excerpt:
        assert mistake.excerpt in option
    assert result.err.endswith("1 error in top.nml; nothing was run\n")
    assert [p.name for p in tmp_path.iterdir()] == [scene.name]


def test_set_wrong_for_several_groups_is_one_mistake(run, scene, mistakes):
    result = run("check", scene.name, "--set", "contact.friction=pade12")
    assert result.status == 2
    assert len(mistakes(result.err)) == 1


def test_set_group_that_the_scene_does_not_have(run, tmp_path, scene_text, mistakes):
    text = re.sub(r"&contact.*?\n/\n", "", scene_text, flags=re.DOTALL)
    (tmp_path / "free.nml").write_text(text)
    result = run("check", "free.nml", "--set", "contact.friction=none")
    assert result.status == 2
    (mistake,) = mistakes(result.err)
    assert mistake.message == "the scene has no group &contact"


def test_set_name_of_two_groups(run, tmp_path, scene_text, mistakes, settings):
    text = scene_text.replace("name = 'ball'", "name = 'top'").replace("'ball',", "'top',")
    (tmp_path / "same.nml").write_text(text)
    # Only the body has a mass, only the surface a radius; both have a name.
    result = run("check", "same.nml", "--set", "top.mass=0.007", "--set", "top.radius=0.014")
    assert result.status == 0, result.err
    result = run("check", "same.nml", "--set", "top.name=tip")
    assert result.status == 2
    (mistake,) = mistakes(result.err)
    assert "'top.name' is ambiguous" in mistake.message
    assert "body.top.name" in mistake.expected
    assert "surface.top.name" in mistake.expected


def test_set_and_file_mistakes_together(run, tmp_path, scene_text, mistakes):
    (tmp_path / "wrong.nml").write_text(scene_text.replace("angle =", "angel ="))
    words = ["--set", "top.mass=-1", "--set", "wood.poisson=3", "--set", "foo.x=1"]
    result = run("check", "wrong.nml", *words)
    sources = [m.source for m in mistakes(result.err)]
    expected = ["wrong.nml", "--set top.mass=-1", "--set wood.poisson=3", "--set foo.x=1"]
    assert set(sources) == set(expected)
    assert f"{len(sources)} errors in wrong.nml; nothing was run\n" in result.err


# --- eval ------------------------------------------------------------------------------------

HEADER = "N,a,b,f,vx,vy,w\n"
ROW = "1.0,1e-3,1e-3,0.3,0.1,0.02,10.0\n"


def table(text: str) -> tuple[list[str], list[list[str]]]:
    header, *rows = csv.reader(io.StringIO(text))
    return header, rows


def wrenches(result) -> list[list[float]]:
    """The last three columns of each row."""
    assert result.status == 0, result.err
    assert result.err == ""
    header, rows = table(result.out)
    assert header[-3:] == ["Fx", "Fy", "Tz"]
    return [[float(x) for x in row[-3:]] for row in rows]


def test_wrench_against_reference(run, reference):
    header, rows = table((reference / "wrench_dimensional.csv").read_text())
    circular = [row for row in rows if float(row[1]) == float(row[2])]
    assert len(circular) >= 8
    text = "\n".join(",".join(row) for row in [header, *circular]) + "\n"
    found = wrenches(run("eval", "wrench", input=text))
    for row, (fx, fy, torque) in zip(circular, found, strict=True):
        n, a, _, f = map(float, row[:4])
        expected = [float(x) for x in row[7:]]
        assert abs(fx - expected[0]) <= 1e-13 * f * n
        assert abs(fy - expected[1]) <= 1e-13 * f * n
        assert abs(torque - expected[2]) <= 1e-13 * f * n * a


def test_wrench_reads_a_file_as_the_standard_input(run, tmp_path):
    (tmp_path / "in.csv").write_text(HEADER + ROW)
    by_input = run("eval", "wrench", input=HEADER + ROW)
    assert by_input.status == 0
    assert run("eval", "wrench", "in.csv").out == by_input.out
    assert run("eval", "wrench", "-", input=HEADER + ROW).out == by_input.out
    assert run("eval", "WRENCH", "in.csv", "--model", "Contensou_Exact").out == by_input.out
    assert [p.name for p in tmp_path.iterdir()] == ["in.csv"]


@pytest.mark.parametrize("model", FRICTION)
def test_wrench_of_every_model(model, run):
    rows = [
        f"{n},{a},{a},{f},{vx},{vy},{w}"
        for n, a, f in [(1.0, 1e-3, 0.3), (1e4, 2e-2, 1.1), (1e-9, 1e-7, 1e-3)]
        for vx, vy in [(0.1, 0.02), (-3.0, 4.0), (0.0, -1e-9)]
        for w in [0.0, 10.0, -1e5]
    ]
    delta = ["--delta", "1e-12"] if model == "coulomb" else []
    text = HEADER + "\n".join(rows) + "\n"
    found = wrenches(run("eval", "wrench", "--model", model, *delta, input=text))
    for row, (fx, fy, torque) in zip(rows, found, strict=True):
        n, a, _, f, vx, vy, w = map(float, row.split(","))
        fn, v = f * n, math.hypot(vx, vy)
        assert math.hypot(fx, fy) <= fn * (1 + 1e-14)
        assert abs(torque) <= 3 * math.pi / 16 * fn * a * (1 + 1e-14)
        assert fx * vx + fy * vy + torque * w <= 0
        assert abs(fx * vy - fy * vx) <= 1e-14 * fn * v
        if w == 0 or model == "coulomb":
            assert fx == pytest.approx(-fn * vx / v, rel=1e-14)
            assert fy == pytest.approx(-fn * vy / v, rel=1e-14)
            assert torque == 0


@pytest.mark.parametrize("model", SPOT_MODELS)
def test_wrench_of_pure_spin_and_of_rest(model, run):
    text = HEADER + "2,1e-3,1e-3,0.5,0,0,7\n2,1e-3,1e-3,0.5,0,0,-7\n2,1e-3,1e-3,0.5,0,0,0\n"
    left, right, rest = wrenches(run("eval", "wrench", "--model", model, input=text))
    assert left[:2] == [0, 0]
    assert left[2] == pytest.approx(-3 * math.pi / 16 * 1e-3, rel=1e-14)
    assert right[2] == -left[2]
    assert rest == [0, 0, 0]


@pytest.mark.parametrize("model", FRICTION)
def test_wrench_regularised(model, run):
    # Far below delta the force is f N v/delta, far above it is f N.
    text = HEADER + "2,1e-3,1e-3,0.5,1e-6,0,0\n2,1e-3,1e-3,0.5,0,0,0\n2,1e-3,1e-3,0.5,10,0,0\n"
    words = ["--model", model, "--delta", "1e-2"]
    slow, rest, fast = wrenches(run("eval", "wrench", *words, input=text))
    assert slow[0] == pytest.approx(-1e-4, rel=1e-3)
    assert rest == [0, 0, 0]
    assert fast[0] == pytest.approx(-1, rel=1e-3)


def test_wrench_digits(run):
    result = run("eval", "wrench", input=HEADER + ROW)
    _, rows = table(result.out)
    for word in rows[0][-3:]:
        assert re.fullmatch(r"-?\d\.\d{16}E[+-]\d{2,3}", word)


def test_wrench_passes_columns_through(run):
    text = "case,w,vy,vx,f,b,a,N,note\n007, 10.0 ,0.02,.1,0.3,1D-3,1e-3,+1,größe und so\n\n"
    result = run("eval", "wrench", input=text)
    assert result.status == 0, result.err
    header, row = result.out.splitlines()
    assert header == "case,w,vy,vx,f,b,a,N,note,Fx,Fy,Tz"
    assert row.startswith("007, 10.0 ,0.02,.1,0.3,1D-3,1e-3,+1,größe und so,")
    assert wrenches(result) == wrenches(run("eval", "wrench", input=HEADER + ROW))


@pytest.mark.parametrize("end", ["\r\n", "\n"])
@pytest.mark.parametrize("last", [True, False])
def test_wrench_line_ends(end, last, run):
    text = (HEADER + ROW).replace("\n", end)
    result = run("eval", "wrench", input=text if last else text.removesuffix(end))
    assert result.status == 0, result.err
    assert result.out == run("eval", "wrench", input=HEADER + ROW).out


def test_wrench_of_a_spreadsheet_with_a_mark_of_its_encoding(run):
    result = run("eval", "wrench", input="\ufeff" + HEADER + ROW)
    assert result.status == 0, result.err


def test_wrench_header_alone(run):
    result = run("eval", "wrench", input=HEADER)
    assert result.status == 0
    assert result.out == HEADER.rstrip("\n") + ",Fx,Fy,Tz\n"


def test_wrench_of_many_rows(run):
    result = run("eval", "wrench", input=HEADER + ROW * 5000)
    assert len(set(map(tuple, wrenches(result)))) == 1
    assert result.out.count("\n") == 5001


@pytest.mark.parametrize("column", range(7))
def test_wrench_of_nan_is_nan(column, run):
    row = ROW.strip().split(",")
    row[column] = "NaN"
    if column in (1, 2):
        row[1] = row[2] = "NaN"
    result = run("eval", "wrench", input=HEADER + ",".join(row) + "\n" + ROW)
    bad, good = wrenches(result)
    assert any(map(math.isnan, bad))
    assert not any(map(math.isnan, good))


@pytest.mark.parametrize("text", ["", "\n", " \n\n"])
def test_wrench_of_an_empty_table(text, run, mistakes):
    result = run("eval", "wrench", input=text)
    assert result.status == 2
    assert result.out == ""
    (mistake,) = mistakes(result.err)
    assert mistake.source == "standard input"
    assert mistake.message == "the table is empty"
    assert mistake.expected == "a header with N,a,b,f,vx,vy,w"


@pytest.mark.parametrize(
    ("header", "column", "message"),
    [
        ("N,a,b,f,vx,vy", 1, "the header has no column w"),
        ("N,a,b,f,vx,omega,vy", 1, "the header has no column w"),
        ("N,a,b,f,VX,vy,w", 9, "the header has no column vx"),
        ("n,a,b,f,vx,vy,w", 1, "the header has no column N"),
        ("N,a,b,f,vx,vy,w,N", 17, "column N"),
        ("N;a;b;f;vx;vy;w", 1, "the header has no column"),
        ("# a comment", 1, "the header has no column"),
    ],
)
def test_wrench_header_wrong(header, column, message, run, mistakes):
    row = ",".join(["1"] * (header.count(",") + 1))
    result = run("eval", "wrench", input=f"{header}\n{row}\n")
    assert result.status == 2
    assert result.out == ""
    (mistake,) = mistakes(result.err)
    assert (mistake.source, mistake.line, mistake.column) == ("standard input", 1, column)
    assert message in mistake.message
    assert "N,a,b,f,vx,vy,w" in mistake.expected
    assert mistake.excerpt == header


@pytest.mark.parametrize(
    ("row", "column", "message", "hint"),
    [
        ("1,1e-3,1e-3,0.3,fast,0,10", 17, "'fast' is not a number", "vx = a number"),
        ("1,1e-3,1e-3,0.3,,0,10", 17, "'' is not a number", "vx = a number"),
        ("1,1e-3,1e-3,0.3,0.1,0,1e", 25, "'1e' is not a number", "w = a number"),
        ("1,1e-3,1e-3,0.3,0.1 m/s,0,10", 17, "'m/s' behind a number", "vx = 0.1 without a unit"),
        ("1,1e-3,1e-3,0.3,0.1,0,1e400", 23, "1e400", ""),
        ("1,1e-3,1e-3,0.3,0.1,0", 1, "6 values in a table of 7 columns", "7 values"),
        ("1,1e-3,1e-3,0.3,0.1,0,10,11", 1, "8 values in a table of 7 columns", "7 values"),
        ("-1,1e-3,1e-3,0.3,0.1,0,10", 1, "must not be negative", "numbers >= 0"),
        ("1,1e-3,1e-3,-0.3,0.1,0,10", 1, "must not be negative", "numbers >= 0"),
    ],
)
def test_wrench_row_wrong(row, column, message, hint, run, mistakes, tmp_path):
    (tmp_path / "in.csv").write_text(HEADER + ROW + "\n" + row + "\n" + ROW)
    column = row.index("1e", 20) + 1 if message.startswith(("'1e'", "1e400")) else column
    result = run("eval", "wrench", "in.csv")
    assert result.status == 2
    assert result.out == ""
    (mistake,) = mistakes(result.err)
    assert (mistake.source, mistake.line, mistake.column) == ("in.csv", 4, column)
    assert message in mistake.message
    assert hint in mistake.expected
    assert mistake.excerpt == row
    assert mistake.carets.index("^") == column - 1


def test_wrench_all_wrong_rows_at_once(run, mistakes):
    text = HEADER + "1,2,3\n" + ROW + "x,1,1,1,y,1,z\n-1,2,1,1,1,1,1\n"
    result = run("eval", "wrench", input=text)
    assert result.status == 2
    assert result.out == ""
    assert [m.line for m in mistakes(result.err)] == [2, 4, 4, 4, 5]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["wrnch"], "unknown kernel 'wrnch'"),
        (
            ["wrench", "--model", "pade12"],
            "unknown friction model 'pade12'; did you mean 'pade11'?",
        ),
        (["wrench", "--model", "zebra"], "unknown friction model 'zebra'"),
        (["wrench", "--model", "coulomb"], "friction model 'coulomb' needs --delta"),
        (["wrench", "--delta", "abc"], "--delta needs a velocity >= 0 [m/s], not 'abc'"),
        (["wrench", "--delta", "-1"], "--delta needs a velocity >= 0 [m/s], not '-1'"),
        (["wrench", "--delta=inf"], "--delta needs a velocity >= 0 [m/s], not 'inf'"),
        (["wrench", "--delta", "nan"], "--delta needs a velocity >= 0 [m/s], not 'nan'"),
    ],
)
def test_eval_wrong_words(words, message, run):
    result = run("eval", *words, input=HEADER + ROW)
    assert result.status == 2
    assert result.out == ""
    assert result.err.startswith(f"error: {message}")


def test_eval_model_none_is_refused_in_sense(run):
    result = run("eval", "wrench", "--model", "none", input=HEADER + ROW)
    assert result.status == 2
    assert "'none'" in result.err
    assert "did you mean 'none'" not in result.err


def test_eval_file_missing(run):
    result = run("eval", "wrench", "nowhere.csv")
    assert result.status == 74
    assert result.out == ""
    assert result.err.startswith("error: ")
    assert result.err.count("nowhere.csv") == 1


def test_eval_folder(run, tmp_path):
    result = run("eval", "wrench", tmp_path)
    assert result.status == 74
    assert "folder" in result.err


# --- a standard output that is full ----------------------------------------------------------


@pytest.mark.parametrize(
    "words",
    [
        ["help"],
        ["help", "body.mass"],
        ["models"],
        ["--version"],
        ["run", "--help"],
        ["check", "top.nml"],
        ["run", "top.nml"],
        ["eval", "wrench"],
    ],
    ids=" ".join,
)
def test_full_standard_output(words, executable, scene, tmp_path):
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [executable, *words],
            cwd=tmp_path,
            input=(HEADER + ROW).encode(),
            stdout=full,
            stderr=subprocess.PIPE,
            timeout=120,
            check=False,
        )
    assert done.returncode in (1, 74)
    assert b"error: cannot write to the standard output: No space left on device" in done.stderr
    if words[0] == "run" and "--help" not in words:
        assert (tmp_path / "top.h5").is_file()


# --- progress --------------------------------------------------------------------------------


def test_progress_in_plain_lines(run, scene):
    result = run("run", scene.name, "--set", "scene.t_end=0.5")
    assert result.status == 0, result.err
    percents = []
    for line in result.err.splitlines():
        match = re.fullmatch(r"contensou: (\d+) %, t = (\S+) s, \d+ (s|min|h \d+ min) left", line)
        assert match, line
        percents.append(int(match[1]))
        assert float(match[2]) >= 0.5 * percents[-1] / 100 * 0.999
    assert percents[:9] == [10, 20, 30, 40, 50, 60, 70, 80, 90]
    assert len(percents) <= 10
    assert "\x1b" not in result.err
    assert "\r" not in result.err


@pytest.mark.parametrize("option", ["-q", "--quiet"])
def test_nothing_is_printed_when_quiet(option, run, scene, tmp_path):
    result = run("run", scene.name, option, "--set", "scene.t_end=0.1")
    assert (result.status, result.out, result.err) == (0, "", "")
    with h5py.File(tmp_path / "top.h5") as file:
        assert len(file["trajectory/time"]) == 101


@pytest.mark.parametrize("columns", [80, 40, 0])
def test_bar_on_a_terminal(columns, executable, scene, tmp_path, build_kind):
    t_end = 2.0 if build_kind == "checked" else 6.0
    words = ["--set", f"scene.t_end={t_end}", "--set", "output.interval=0.01"]
    status, shown = on_terminal([executable, "run", scene.name, *words], tmp_path, columns)
    assert status == 0
    frames = [re.sub(r"\x1b\[K", "", frame) for frame in shown.split("\r")]
    assert frames[-1] == "", "the bar is not cleared at the end"
    bars = [frame for frame in frames if frame]
    assert bars, "there is no bar"
    percents = []
    for bar in bars:
        match = re.fullmatch(
            r"\[(#*)( *)\] (\d+) %, t = \S+ s, (?:\d+ s|\d+ min|\d+ h \d+ min) left", bar
        )
        assert match, bar
        share = int(match[3]) / 100
        width = len(match[1]) + len(match[2])
        assert abs(len(match[1]) - share * width) <= 1
        assert len(bar) <= (columns or 80)
        percents.append(int(match[3]))
    assert percents == sorted(percents)
    assert percents[-1] <= 100


def test_no_bar_on_a_terminal_when_quiet(executable, scene, tmp_path):
    status, shown = on_terminal([executable, "run", scene.name, "-q"], tmp_path, 80)
    assert status == 0
    assert shown == ""


def test_mistakes_on_a_terminal_are_plain(executable, scene, tmp_path):
    command = [executable, "run", scene.name, "--set", "top.mass=-1"]
    status, shown = on_terminal(command, tmp_path, 80)
    assert status == 2
    assert "'mass' is out of range" in shown
    assert "\x1b" not in shown
