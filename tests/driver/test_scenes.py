"""Reading of scenes: broken ones with their messages, legal syntax, and two other readers."""

from __future__ import annotations

import os
import random
import re
import subprocess
import unicodedata
from pathlib import Path

import f90nml
import pytest
from programs import captured

BROKEN = sorted((Path(__file__).parent / "broken").glob("*.nml"))

PLAIN = """\
&scene title = 'It''s a marble', gravity = 0, 0, -9.81, t_end = 0.01 /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body
   name = 'marble'
   mass = 0.02
   inertia = 1.0e-6, 1.0e-6, 1.0e-6
   position = 0, 0, 0.012
   velocity = 0.5, 0, -0.125
/
&surface name = 'ball', body = 'marble', shape = 'sphere', radius = 0.01, material = 'wood' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'wood' /
&contact
   name = 'ball_floor'
   surfaces = 'ball', 'floor'
   friction = 'contensou_exact', friction_coefficient = 0.3
   drilling = .true.
/
&output file = 'marble.h5', interval = 1.0e-3 /
"""


# --- broken scenes ---------------------------------------------------------------------------


def expectations(lines: list[str]) -> list[tuple[int, int, str, str]]:
    """What the leading comment lines of a broken scene say: line, column, message, hint.

    `! expect: LINE:COLUMN: MESSAGE` or `! expect: file: MESSAGE`, each followed by `! hint: TEXT`.
    """
    found = []
    for line in lines:
        if line.startswith("! expect: "):
            place, _, message = line.removeprefix("! expect: ").partition(": ")
            row, _, column = ("0:0" if place == "file" else place).partition(":")
            found.append([int(row), int(column), message, ""])
        elif line.startswith("! hint: "):
            found[-1][3] = line.removeprefix("! hint: ")
        else:
            break
    return [tuple(item) for item in found]


def assert_points_at(mistake, line: str) -> None:
    """The excerpt shows the line, or a part of it, and the caret stands under the column."""
    shown, caret = mistake.excerpt, mistake.carets.index("^")
    if shown == line:
        blanks = "".join("\t" if c == "\t" else " " for c in line[: mistake.column - 1])
        assert mistake.carets[:caret] == blanks
        return
    assert len(line) > 80, "a short line is shown as it is"
    cut_left, cut_right = shown.startswith("..."), shown.endswith("...")
    assert cut_left or cut_right
    inner = shown[3 * cut_left : len(shown) - 3 * cut_right]
    assert len(inner) <= 100
    start = mistake.column - 1 - (caret - 3 * cut_left)
    assert line[start : start + len(inner)] == inner
    assert (start > 0) == cut_left
    assert (start + len(inner) < len(line)) == cut_right


@pytest.mark.parametrize("command", ["run", "check"])
@pytest.mark.parametrize("path", BROKEN, ids=lambda path: path.stem)
def test_broken_scene(path, command, run, mistakes, tmp_path):
    data = path.read_bytes()
    (tmp_path / path.name).write_bytes(data)
    lines = [line.removesuffix("\r") for line in data.decode().split("\n")]
    expected = expectations(lines)
    assert expected, "the scene does not say what it expects"

    result = run(command, path.name)

    assert result.status == 2
    assert result.out == ""
    assert sorted(p.name for p in tmp_path.iterdir()) == [path.name]
    assert (tmp_path / path.name).read_bytes() == data
    found = mistakes(result.err)
    assert [
        (m.line, m.column, m.message[: len(e[2])]) for m, e in zip(found, expected, strict=False)
    ] == [e[:3] for e in expected], result.err
    for mistake, (_, _, message, hint) in zip(found, expected, strict=False):
        assert mistake.source == path.name
        assert message in mistake.message
        assert hint
        assert hint in mistake.expected
        if mistake.line:
            assert_points_at(mistake, lines[mistake.line - 1])
    assert len(found) == len(expected), result.err
    count = "1 error" if len(expected) == 1 else f"{len(expected)} errors"
    assert result.err.endswith(f"\n{count} in {path.name}; nothing was run\n")


def test_broken_scenes_are_many():
    assert len(BROKEN) >= 45


def test_the_name_of_the_file_is_shown_as_given(run, tmp_path):
    (tmp_path / "deep er").mkdir()
    (tmp_path / "deep er" / "größe.nml").write_text(PLAIN.replace("mass =", "mas ="))
    plain = "deep er/größe.nml"
    for name in (plain, f"./deep er/../{plain}", tmp_path / plain):
        result = run("check", name)
        assert result.status == 2
        assert f"{name}:5:4: error: unknown key 'mas'" in result.err


def test_very_many_mistakes_are_counted_not_all_shown(run, tmp_path, mistakes):
    (tmp_path / "many.nml").write_text(PLAIN + "&zebra /\n" * 300)
    result = run("check", "many.nml")
    assert result.status == 2
    assert 20 <= len(mistakes(result.err)) <= 100
    assert re.search(r"^\.\.\. and \d+ more errors$", result.err, re.MULTILINE)
    assert "\n300 errors in many.nml" in result.err


# --- legal syntax ----------------------------------------------------------------------------


def variant(name: str) -> str | bytes:
    """The plain scene, written in another way."""
    text = PLAIN
    match name:
        case "subscripts":
            text = text.replace(
                "position = 0, 0, 0.012", "position(1) = 0, position(3) = 0.012\n   position(2) = 0"
            )
            text = text.replace("'ball', 'floor'\n", "'ball'\n   surfaces(2) = 'floor'\n")
            text = text.replace("surfaces = 'ball'\n", "surfaces(1) = 'ball'\n")
        case "ranges":
            text = text.replace(
                "position = 0, 0, 0.012", "position(1:2) = 0, 0, position(3:) = 0.012"
            )
            text = text.replace("velocity = 0.5", "velocity(:) = 0.5")
            text = text.replace("inertia = 1.0e-6,", "inertia(:2) = 1.0e-6,")
            text = text.replace("1.0e-6, 1.0e-6\n", "1.0e-6, inertia(3:3) = 1.0e-6\n")
        case "blanks_before_subscripts":
            text = text.replace("position = 0, 0, 0.012", "position ( 1 : 3 )  =  0 0 0.012")
        case "repeat_counts":
            text = text.replace("1.0e-6, 1.0e-6, 1.0e-6", "3*1.0e-6")
            text = text.replace("position = 0, 0,", "position = 2*0")
            text = text.replace("drilling = .true.", "drilling = 1*.true.")
        case "one_line":
            text = " ".join(text.split("\n"))
        case "line_per_word":
            text = re.sub(r"(?<!It''s)(?<!a) (?!a marble)", "\n", text)
        case "blanks_for_commas":
            text = re.sub(r"(?<=[\d']), (?=[-\d'])", "   ", text)
        case "trailing_commas":
            text = re.sub(r"(?<=[\d'])\n", ",\n", text)
        case "comments":
            text = text.replace("&body", "! &body mass = 17 /\n\n!\n&body")
            text = text.replace("\n", ' ! it\'s "a" comment, mass = 1 / &body\n')
        case "double_quotes":
            text = text.replace("'It''s a marble'", '"It\'s a marble"')
            text = re.sub(r"'(\w+)'", r'"\1"', text)
        case "crlf":
            return text.replace("\n", "\r\n").encode()
        case "no_last_newline":
            text = text.rstrip("\n")
        case "crlf_no_last_newline":
            return text.rstrip("\n").replace("\n", "\r\n").encode()
        case "tabs":
            text = re.sub(r"(?<!s)(?<!a) (?!a marble)", "\t", text)
        case "upper_case":
            text = re.sub(r"\b[a-z_]+(?= =)|&[a-z]+", lambda m: m[0].upper(), text)
        case "upper_case_references":
            for word in ("body = 'marble'", "material = 'wood'", "'ball', 'floor'", "'sphere'"):
                text = text.replace(word, word.upper())
            text = text.replace("'contensou_exact'", "'Contensou_Exact'")
            text = text.replace("'ground'", "'GROUND'")
        case "exponents":
            text = text.replace("1.0e-6, 1.0e-6, 1.0e-6", "1.0d-6, 1D-6, .1E-5")
            text = text.replace("young = 9.1e9", "young = +9100.e+6")
            text = text.replace("mass = 0.02", "mass = 2-2")
            text = text.replace("interval = 1.0e-3", "interval = 1.0D-3")
        case "amp_end":
            text = text.replace("\n/\n", "\n&end\n")
        case "utf8_mark":
            return b"\xef\xbb\xbf" + text.encode()
        case "text_between_groups_in_comments":
            text = "! title\n\n\n" + text.replace("/\n", "/ ! end\n\n   ! next\n")
        case "order_of_groups":
            groups = re.findall(r"&.*?/\n", text, re.DOTALL)
            text = "".join(groups[::-1])
        case "blanks_in_texts":
            text = text.replace("'wood'", "'  wood '")
        case _:
            raise ValueError(name)
    return text


VARIANTS = [
    "subscripts",
    "ranges",
    "blanks_before_subscripts",
    "repeat_counts",
    "one_line",
    "line_per_word",
    "blanks_for_commas",
    "trailing_commas",
    "comments",
    "double_quotes",
    "crlf",
    "no_last_newline",
    "crlf_no_last_newline",
    "tabs",
    "upper_case",
    "exponents",
    "amp_end",
    "utf8_mark",
    "text_between_groups_in_comments",
    "blanks_in_texts",
]


@pytest.fixture
def resolve(run, settings, tmp_path):
    """Settings that `check` resolves from the text of a scene."""

    def resolve_it(text: str | bytes, *options):
        data = text if isinstance(text, bytes) else text.encode()
        (tmp_path / "scene.nml").write_bytes(data)
        result = run("check", "scene.nml", *options)
        assert result.status == 0, result.err
        assert result.err == ""
        return settings(result.out)

    return resolve_it


@pytest.mark.parametrize("name", VARIANTS)
def test_another_way_to_write_the_same(name, resolve):
    text = variant(name)
    assert text not in (PLAIN, PLAIN.encode())
    assert resolve(text) == resolve(PLAIN)


def test_plain_form_is_resolved_with_its_values(resolve):
    groups = resolve(PLAIN)
    assert [name for name, _ in groups] == [
        "scene",
        "material",
        "body",
        "surface",
        "surface",
        "contact",
        "output",
        "integrator",
    ]
    values = dict(groups)
    assert values["scene"] == {
        "title": ["It's a marble"],
        "gravity": [0, 0, -9.81],
        "t_end": [0.01],
    }
    assert values["body"]["inertia"] == [1e-6, 1e-6, 1e-6]
    assert values["body"]["velocity"] == [0.5, 0, -0.125]
    assert values["body"]["spin"] == [0, 0, 0]
    assert values["contact"]["surfaces"] == ["ball", "floor"]
    assert values["contact"]["drilling"] == [True]
    assert values["contact"]["damping"] == ["none"]
    assert values["output"] == {"file": ["marble.h5"], "interval": [1e-3]}
    assert values["integrator"]["method"] == ["cvode_bdf"]
    assert values["integrator"]["length_scale"][0] > 0


def test_references_and_choices_in_any_case(resolve):
    groups = resolve(variant("upper_case_references"))
    plain = resolve(PLAIN)
    assert [(g, sorted(v)) for g, v in groups] == [(g, sorted(v)) for g, v in plain]
    values = dict(groups)
    assert values["contact"]["friction"] == ["contensou_exact"]
    assert values["surface"]["shape"] == ["plane"]
    assert values["integrator"] == dict(plain)["integrator"]


def test_groups_in_any_order(resolve):
    assert sorted(resolve(variant("order_of_groups")), key=repr) == sorted(resolve(PLAIN), key=repr)


@pytest.mark.parametrize("word", [".true.", ".TRUE.", "T", "t", ".t", ".T.", "true", "True"])
def test_true(word, resolve):
    groups = resolve(PLAIN.replace("drilling = .true.", f"drilling = {word}"))
    assert dict(groups)["contact"]["drilling"] == [True]


@pytest.mark.parametrize("word", [".false.", ".FALSE.", "F", "f", ".f", ".F.", "false", "FALSE"])
def test_false(word, resolve):
    groups = resolve(PLAIN.replace("drilling = .true.", f"drilling = {word}"))
    assert dict(groups)["contact"]["drilling"] == [False]


@pytest.mark.parametrize(
    ("written", "title"),
    [
        ("'don''t'", "don't"),
        ('"don\'t"', "don't"),
        ('"say ""so"""', 'say "so"'),
        ("'say \"so\"'", 'say "so"'),
        ("''''", "'"),
        ("''", ""),
        ("'a ! b / c & d = e, f'", "a ! b / c & d = e, f"),
        ("'Männchen № 雪'", "Männchen № 雪"),
        ("'" + "long " * 60 + "'", ("long " * 60).strip()),
    ],
)
def test_texts(written, title, resolve):
    groups = resolve(PLAIN.replace("'It''s a marble'", written))
    assert dict(groups)["scene"]["title"] == [title]


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("1", 1.0),
        ("1.", 1.0),
        (".5", 0.5),
        ("+1.5", 1.5),
        ("1e3", 1e3),
        ("1.5E+03", 1.5e3),
        ("1.5d-3", 1.5e-3),
        ("0.1", 0.1),
        ("1.2345678901234567e-39", 1.2345678901234567e-39),
        ("9.7976931348623157e39", 9.7976931348623157e39),
        ("0.30000000000000004", 0.30000000000000004),
        ("9007199254740993", 9007199254740992.0),
        ("0" * 500 + "1." + "0" * 500, 1.0),
    ],
)
def test_numbers_are_read_exactly(written, value, resolve):
    text = PLAIN.replace("velocity =", f"quaternion = {written}, 1, 1, 1, velocity =")
    groups = resolve(text)
    assert dict(groups)["body"]["quaternion"][0] == value


def test_models_named_none_keep_the_other_keys_out(resolve):
    # So that `--set contact.friction=none` works on any scene.
    groups = resolve(
        PLAIN.replace("friction = 'contensou_exact'", "friction = 'none'").replace(
            "drilling =", "damping = 'none', damping_coefficient = 1.0, drilling ="
        )
    )
    contact = dict(groups)["contact"]
    assert contact["friction"] == ["none"]
    assert contact["damping"] == ["none"]


def test_defaults_of_groups_left_out(resolve):
    text = PLAIN.replace("&output file = 'marble.h5', interval = 1.0e-3 /\n", "")
    values = dict(resolve(text))
    assert values["output"] == {"file": ["scene.h5"], "interval": [1e-5]}
    assert values["integrator"]["rtol"] == [1e-8]


# --- other readers ---------------------------------------------------------------------------


@pytest.fixture(scope="session")
def fortran_reader(tmp_path_factory):
    """A program that reads a scene with the namelist input of the compiler."""
    folder = tmp_path_factory.mktemp("reader")
    source = Path(__file__).with_name("read_namelist.f90")
    program = folder / "read_namelist"
    subprocess.run(
        [os.environ.get("FC", "gfortran"), "-std=f2018", "-o", program, source],
        cwd=folder,
        check=True,
        timeout=120,
    )
    return program


def read_with_fortran(program: Path, scene: Path) -> list[tuple[str, dict[str, list]]]:
    done = captured([program, scene], timeout=60)
    assert done.returncode == 0, done.stdout
    groups: dict[tuple[str, str], dict[str, list]] = {}
    for line in done.stdout.splitlines():
        group, index, key, values = line.split(maxsplit=3)
        words = re.findall(r"'(?:[^']|'(?! |$))*'|\S+", values)
        groups.setdefault((group, index), {})[key] = [
            word[1:-1]
            if word[0] == "'"
            else word == ".true."
            if word.startswith((".t", ".f"))
            else None
            if word == "-"
            else float(word)
            for word in words
        ]
    return [(group, values) for (group, _), values in groups.items()]


def shipped(inputs: Path) -> list[Path]:
    scenes = sorted(inputs.glob("*.nml"))
    assert len(scenes) >= 4
    return scenes


def of_group(groups, name):
    return [values for group, values in groups if group == name]


def n_assignments(scene):
    """Number of assignments in a scene, those of truth values and of a bearing aside."""
    text = re.sub(r"'[^'\n]*'|\"[^\"\n]*\"", "''", scene.read_text(encoding="utf-8"))
    text = re.sub(r"!.*", "", text)
    return len(re.findall(r"=(?! *[.](?:true|false)[.])", re.sub(r"&bearing\b[^/]*/", "", text)))


def test_shipped_scenes_read_by_the_compiler(inputs, run, settings, fortran_reader):
    for scene in shipped(inputs):
        ours = settings(run("check", scene).out)
        theirs = read_with_fortran(fortran_reader, scene)
        n_given = 0
        # What a bearing stands for is a test of its own.
        for group in {name for name, _ in theirs} - {"bearing"}:
            assert len(of_group(ours, group)) == len(of_group(theirs, group))
            for mine, other in zip(of_group(ours, group), of_group(theirs, group), strict=True):
                given = {key: values for key, values in other.items() if values != [None]}
                assert {key: mine[key] for key in given} == given
                # A truth value that is not given has a value, too.
                n_given += sum(not isinstance(values[0], bool) for values in given.values())
        assert n_given == n_assignments(scene)


def test_the_reader_of_the_compiler_knows_all_keys(inputs, run, fortran_reader, tmp_path):
    stop = tmp_path / "stop.nml"
    stop.write_text(
        "&stop when = 'rest' /\n&output contact_geometry = .false., rolling = .true. /\n"
        "&spring name = 's' /\n"
    )
    known = {
        (group, key)
        for scene in [*shipped(inputs), stop]
        for group, values in read_with_fortran(fortran_reader, scene)
        for key in values
    }
    listed, group = set(), ""
    for line in run("help").out.splitlines():
        if line.startswith("&"):
            group = line[1 : line.index(":")]
        elif line.startswith("    "):
            listed.add((group, line.split()[0]))
    # No shipped scene has a group &cost; a sweep is no scene; what saves typing is taken
    # before keys are looked at.
    others = {"cost", "constants", "defaults", "contacts", "sweep", "parameter", "value"}
    assert known == {(group, key) for group, key in listed if group not in others}


def test_shipped_scenes_read_by_f90nml(inputs, run, settings):
    for scene in shipped(inputs):
        ours = settings(run("check", scene).out)
        n_given = 0
        theirs = list(f90nml.read(scene).items())
        for group in {name for name, _ in theirs} - {"bearing"}:
            pairs = zip(of_group(ours, group), of_group(theirs, group), strict=True)
            for mine, other in pairs:
                for key, values in other.items():
                    assert mine[key] == (values if isinstance(values, list) else [values])
                    n_given += not isinstance(values, bool)
        assert n_given == n_assignments(scene)


def test_resolved_settings_are_a_scene_themselves(inputs, run, settings, tmp_path):
    for scene in shipped(inputs):
        out = run("check", scene).out
        (tmp_path / "again.nml").write_text(out.partition("\nsettings\n")[2])
        again = run("check", "again.nml")
        assert again.status == 0, again.err
        assert settings(again.out) == settings(out)


def test_a_resolved_angular_velocity_is_given_once(run, settings, tmp_path):
    text = PLAIN.replace("velocity = 0.5, 0, -0.125", "angular_velocity = 0, 3.0, 4.0")
    (tmp_path / "plain.nml").write_text(text)
    out = run("check", "plain.nml").out
    (tmp_path / "again.nml").write_text(out.partition("\nsettings\n")[2])
    again = run("check", "again.nml")
    assert again.status == 0, again.err
    assert settings(again.out) == settings(out)
    assert "angular_velocity = 0.0, 3.0, 4.0" in out
    assert "   spin = " not in out


# --- files that are no scenes ----------------------------------------------------------------


@pytest.mark.parametrize("command", ["run", "check"])
def test_file_missing(command, run, tmp_path):
    result = run(command, "nowhere.nml")
    assert result.status == 74
    assert result.err == "error: nowhere.nml cannot be read: it does not exist\n"
    assert result.out == ""
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", ["run", "check"])
def test_folder(command, run, tmp_path):
    (tmp_path / "folder.nml").mkdir()
    result = run(command, "folder.nml")
    assert result.status == 74
    assert result.err == "error: folder.nml cannot be read: it is a folder\n"
    assert [p.name for p in tmp_path.iterdir()] == ["folder.nml"]


@pytest.mark.parametrize(
    "content", [b"", b"\n", b"! only a comment", b"\r\n\t \r\n", b"\xef\xbb\xbf"]
)
def test_empty_file(content, run, mistakes, tmp_path):
    (tmp_path / "empty.nml").write_bytes(content)
    result = run("run", "empty.nml")
    assert result.status == 2
    assert "there is no group &scene" in [m.message for m in mistakes(result.err)]
    assert "in empty.nml; nothing was run" in result.err


def test_binary_file(run, tmp_path, executable):
    (tmp_path / "binary.nml").write_bytes(executable.read_bytes()[:100000])
    result = run("check", "binary.nml")
    assert result.status == 2
    assert result.err == "error: binary.nml is not a text file: it contains zero bytes\n"


@pytest.mark.parametrize("seed", range(8))
def test_random_bytes(seed, run, tmp_path):
    source = random.Random(seed)
    data = bytes(source.choice(range(1, 256)) for _ in range(4000))
    (tmp_path / "random.nml").write_bytes(data)
    result = run("check", "random.nml")
    assert result.status == 2
    assert "in random.nml; nothing was run" in result.err
    strange = [c for c in result.err if unicodedata.category(c) == "Cc" and c not in "\n\t"]
    assert not strange, "control characters reach the terminal"
    assert len(result.err) < 60000


@pytest.mark.parametrize("seed", range(8))
def test_a_scene_with_a_piece_missing_ends_orderly(seed, run, tmp_path):
    source = random.Random(seed)
    for _ in range(4):
        start = source.randrange(len(PLAIN))
        cut = PLAIN[:start] + PLAIN[start + source.randrange(1, 60) :]
        (tmp_path / "cut.nml").write_text(cut)
        result = run("check", "cut.nml")
        assert result.status in (0, 2), result.err
        if result.status == 2:
            assert re.search(r"\n\d+ errors? in cut.nml; nothing was run\n$", result.err)


def test_very_large_file(run, tmp_path):
    (tmp_path / "large.nml").write_bytes(b"! a comment that fills the file\n" * 650000)
    result = run("check", "large.nml")
    assert result.status == 74
    assert result.err == "error: large.nml is too large to be a scene: more than 16 MiB\n"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_file_that_may_not_be_read(run, tmp_path):
    (tmp_path / "secret.nml").write_text(PLAIN)
    (tmp_path / "secret.nml").chmod(0)
    result = run("check", "secret.nml")
    assert result.status == 74
    assert "error: secret.nml cannot be read: " in result.err
