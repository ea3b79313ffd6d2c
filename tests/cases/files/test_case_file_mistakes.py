"""What a case file may not be, each answered by one sentence."""

import os
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from quickreturn.cases.files.case import parse_case
from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.keys import SECTIONS
from tests.cases.files.scene_texts import SCENE, changed, message

#: What is written instead, and how the answer begins.
BAD = [
    # units and numbers
    ('length = "4 in"', 'length = "4,5 in"', 'crank.length: "4,5 in" has a comma in its number (the decimal sign is a point)'),
    ('length = "4 in"', 'length = "4 kg"', 'crank.length: "4 kg" is a mass (kg), but a length is needed'),
    ('length = "4 in"', "length = 4", "crank.length: 4 is a bare number"),
    ('length = "4 in"', 'length = ["4 in"]', 'crank.length: ["4 in"] is not a string'),
    ('length = "4 in"', 'length = "-4 in"', 'crank.length: "-4 in" is not positive; a length greater than zero is accepted'),
    ('length = "4 in"', 'length = "inf"', 'crank.length: "inf" cannot be read'),
    ('length = "4 in"', 'length = "\\u001b[31m4 in"', 'crank.length: "\\x1b[31m4 in" cannot be read; write one plain number'),
    ('initial_angle = "180 deg"', 'initial_angle = "180"', 'crank.initial_angle: "180" has no unit'),
    (
        'initial_speed = "16.617773 rad/s"',
        'initial_speed = "2.64 Hz"',
        'crank.initial_speed: "2.64 Hz" is a frequency (1/s), but an angular speed is needed',
    ),
    ('bending_stiffness = "2128.22 lbf*in^2"', 'bending_stiffness = "infinity"', 'follower.bending_stiffness: "infinity" cannot be read'),
    (
        'bending_stiffness = "2128.22 lbf*in^2"',
        'bending_stiffness = "0 N*m^2"',
        'follower.bending_stiffness: "0 N*m^2" is not positive; a bending stiffness greater than zero is accepted',
    ),
    (
        'damping = "2e-5 lbf*s/in^2"',
        'damping = "-2e-5 lbf*s/in^2"',
        'follower.damping: "-2e-5 lbf*s/in^2" is negative; a damping per length of zero or more is accepted',
    ),
    ('gravity = ["0 in/s^2", "-386 in/s^2"]', 'gravity = "-386 in/s^2"', 'mechanism.gravity: "-386 in/s^2" is not a list of 2 strings'),
    (
        'gravity = ["0 in/s^2", "-386 in/s^2"]',
        'gravity = ["0 in/s^2", "-386 in"]',
        'mechanism.gravity: "-386 in" is a length (m), but an acceleration is needed',
    ),
    # keys and sections
    (
        "pivot_distance",
        "pivot_distanse",
        'mechanism.pivot_distanse: "18 in" belongs to an unknown key; the nearest known one is mechanism.pivot_distance',
    ),
    ("[base]", "[bass]", "bass: { ... } is an unknown section; the nearest known one is base"),
    ("[base]", "[[base]]", "base: [{ ... }] is not a section; write [base] with its keys below"),
    ('title = "A scene"', 'titel = "A scene"', 'titel: "A scene" belongs to an unknown key; the nearest known one is title'),
    (
        'tags = ["test"]',
        'gravity = ["0 N/kg"]',
        'gravity: ["0 N/kg"] belongs to an unknown key; the nearest known one is mechanism.gravity',
    ),
    ('width = "1.5 in"\n', "", "follower.width: this key is missing"),
    (
        '[simulation]\nduration = "2 s"\noutput_step = "1 ms"\n',
        "",
        "[simulation]: this section is missing; its keys are duration, output_step",
    ),
    ('name = "scene"\n', "", "name: this key is missing"),
    (
        'name = "scene"',
        'name = "../scene"',
        'name: "../scene" is not a name; up to 64 letters from a to z, digits, points, hyphens and underscores',
    ),
    ('title = "A scene"', 'title = "A\\nB"', 'title: "A\\nB" is not a title; one line of up to 200 characters in quotes is accepted'),
    ('tags = ["test"]', 'tags = "test"', 'tags: "test" is not a list of tags'),
    # the crank's drive
    (
        'torque = "10 lbf*in"',
        'torque = "10 lbf*in"\nprescribed_speed = "16 rad/s"',
        'crank.prescribed_speed: "16 rad/s" conflicts with crank.torque; give either prescribed_speed alone',
    ),
    ('torque = "10 lbf*in"\n', "", "crank.torque: this key is missing"),
    (
        'torque = "10 lbf*in"\ndamping = "0.60176535 lbf*in*s/rad"\ninitial_angle = "180 deg"\ninitial_speed = "16.617773 rad/s"',
        'initial_angle = "180 deg"',
        "crank: nothing drives the crank; give either prescribed_speed alone",
    ),
    (
        'damping = "0.60176535 lbf*in*s/rad"\ninitial_angle = "180 deg"\ninitial_speed = "16.617773 rad/s"',
        'damping = "0 lbf*in*s/rad"\ninitial_angle = "180 deg"',
        'crank.initial_speed: is missing, and without damping there is no speed torque / damping; give one, such as "16 rad/s"',
    ),
    # what does not fit together
    (
        'length = "4 in"',
        'length = "18 in"',
        'crank.length: "18 in" cannot be: a crank as long as mechanism.pivot_distance (0.4572 m) brings the slider to',
    ),
    (
        'length = "4 in"',
        'length = "8 in"',
        'crank.length: "8 in" cannot be: the slider leaves the follower: pivot_distance + crank.length = 0.6604 m',
    ),
    (
        '"18.75 in"]',
        '"18.75 in", "20 in"]',
        'follower.strain_gauges: ["6.25 in", "12.5 in", "18.75 in", "20 in"] is not a list of 3 strings',
    ),
    (
        '"18.75 in"]',
        '"25.1 in"]',
        'follower.strain_gauges: ["6.25 in", "12.5 in", "25.1 in"] leaves the strain gauge at 0.63754 m outside the follower',
    ),
    (
        'joint_stiffness = "100 lbf/in"',
        'joint_stiffness = "inf"',
        'slider.joint_damping: "0.1 lbf*s/in" acts on a joint that gives way, and this one is rigid; give a finite',
    ),
    (
        'joint_stiffness = "100 lbf/in"',
        'joint_stiffness = "100 lbf/in"\nclearance = "0.2 mm"\npreload = "2 N"',
        'slider.clearance: "0.2 mm" conflicts with slider.preload (2 N); give one of them',
    ),
    (
        'joint_stiffness = "100 lbf/in"',
        'joint_stiffness = "100 lbf/in"\njoint_stiffness_plus = "10 kN/m"',
        'slider.joint_stiffness_plus: "10 kN/m" conflicts with slider.joint_stiffness (17512.7 N/m), which is that of both rollers',
    ),
    (
        'output_step = "1 ms"',
        'output_step = "3 ms"',
        'simulation.duration: "2 s" gives 666.667 output steps (duration 2 s, output step 0.003 s)',
    ),
    (
        'output_step = "1 ms"',
        'output_step = "3 s"',
        'simulation.duration: "2 s" gives 0.666667 output steps (duration 2 s, output step 3 s)',
    ),
    (
        'output_step = "1 ms"',
        'output_step = "1 ns"',
        'simulation.duration: "2 s" gives 2e+09 output steps (duration 2 s, output step 1e-09 s); at most 2 million are accepted',
    ),
    ('output_step = "1 ms"', 'output_step = "0 s"', 'simulation.output_step: "0 s" is not positive; a time greater than zero is accepted'),
    # TOML itself
    ('length = "4 in"', "length = " + "9" * 5000, "line 10 has 5009 characters; at most 1000 are accepted"),
    (
        'length = "4 in"',
        "a." * 490 + "b = 1",
        "crank.a: { ... } is an unknown section; known are length, mass, center_of_mass, inertia, initial_angle",
    ),
    ('length = "4 in"', "length = " + "[" * 900, "is nested too deeply; sections with strings and lists of strings are accepted"),
]


@pytest.mark.parametrize(("old", "new", "expected"), BAD, ids=lambda text: text[:50])
def test_each_mistake_has_its_sentence(old: str, new: str, expected: str) -> None:
    assert message(changed(old, new)).startswith(f"scene.toml: {expected}")


def test_a_torque_driven_crank_needs_inertia_of_its_own() -> None:
    light = changed('mass = "0.1 lbf*s^2/in"', 'mass = "0 kg"').replace('"4.0e-4 lbf*s^2*in"', '"0 kg*m^2"')
    assert parse_case(light, "scene.toml").mechanism.crank.inertia_about_pivot == 0.0  # the slider's mass is enough
    assert message(light.replace('mass = "0.01 lbf*s^2/in"', 'mass = "0 kg"')) == (
        'scene.toml: crank.inertia: "0 kg*m^2" leaves a torque-driven crank without inertia about its axis;'
        " give crank.inertia, or crank.mass and center_of_mass"
    )


MUST_BE_POSITIVE = """mechanism.pivot_distance crank.length follower.length follower.mass_per_length follower.bending_stiffness
    follower.thickness follower.width slider.joint_stiffness simulation.duration simulation.output_step"""
MAY_BE_ZERO = """crank.mass crank.inertia crank.damping base.inertia base.damping follower.damping tip.mass tip.inertia slider.mass
    slider.inertia slider.joint_damping"""
MAY_BE_NEGATIVE = "crank.center_of_mass crank.torque crank.initial_angle crank.initial_speed tip.center_of_mass"


@pytest.mark.parametrize("path", [*MUST_BE_POSITIVE.split(), *MAY_BE_ZERO.split(), *MAY_BE_NEGATIVE.split()])
def test_signs_are_accepted_where_they_make_sense(path: str) -> None:
    section, key = path.split(".")
    written = SCENE.split(f"[{section}]\n")[1].split(f'{key} = "')[1].split('"')[0]
    unit = written.split(" ")[1]
    zero, negative = {path: f"0 {unit}"}, {path: f"-1 {unit}"}
    if path in MUST_BE_POSITIVE:
        with pytest.raises(CaseError, match="is not positive"):
            parse_case(SCENE, "scene.toml", zero)
    else:
        parse_case(SCENE, "scene.toml", zero)
    if path in MAY_BE_NEGATIVE:
        parse_case(SCENE, "scene.toml", negative)
    else:
        with pytest.raises(CaseError, match=r"is not positive|is negative"):
            parse_case(SCENE, "scene.toml", negative)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[base]", "[base", 'line 19: "[base" is no valid TOML: '),
        ('width = "1.5 in"', "width = 1,5 in", 'line 28: "width = 1,5 in" is no valid TOML: '),
        ('width = "1.5 in"', "width = '1.5 in", 'line 28: "width = \'1.5 in" is no valid TOML: '),  # the parser looks for ' up to the end
        ('width = "1.5 in"', 'width = """1.5 in', 'line 28: "width = \\"\\"\\"1.5 in" is no valid TOML: '),
        ('output_step = "1 ms"', "output_step =", 'line 49: "output_step =" is no valid TOML: '),
        ('width = "1.5 in"', "width = “1.5 in”", 'line 28: "width = “1.5 in”" is no valid TOML: it has typographic quotes'),
        (
            'width = "1.5 in"',
            'width = "1.5 in"\nwidth = "2 in"',
            'line 29: "width = \\"2 in\\"" repeats an earlier key or section',
        ),
    ],
)
def test_broken_toml_is_told_with_its_line(old: str, new: str, told: str) -> None:
    answer = message(changed(old, new))
    assert answer.startswith(f"scene.toml: {told}")  # what follows are the parser's words, which may change with Python's version
    assert answer.endswith(('; write [section] or key = "number unit", such as length = "4 in"', "; give each of them once"))


@pytest.mark.parametrize("section", ["mechanism", "crank", "base", "follower", "tip", "simulation"])
def test_every_key_that_cannot_be_left_out_is_named_when_it_is(section: str) -> None:
    optional = {name for name, key in SECTIONS[section].items() if key.optional}
    start = SCENE.index(f"[{section}]\n") + len(section) + 3
    lines = SCENE[start:].split("\n\n")[0].splitlines()
    for line in lines:
        key = line.split(" ")[0]
        text = SCENE[:start] + SCENE[start:].replace(line + "\n", "", 1)
        if key in optional:
            parse_case(text, "scene.toml")
        else:
            assert message(text).startswith(f"scene.toml: {section}.{key}: this key is missing; write a")


def test_all_that_is_missing_is_named_in_one_sentence() -> None:
    lacking = (
        changed('initial_angle = "180 deg"\n', "").replace('damping = "2e-5 lbf*in*s/rad"\n', "").replace('output_step = "1 ms"\n', "")
    )
    assert message(lacking) == (
        "scene.toml: crank.initial_angle: this key is missing, and so are base.damping and simulation.output_step;"
        ' write an angle, such as "180 deg"'
    )
    without_base = lacking[: lacking.index("[base]")] + lacking[lacking.index("[follower]") :]
    assert "missing, and so are [base] and simulation.output_step; " in message(without_base)
    assert "[mechanism]: this section is missing, and so are [crank], [base], [follower] and [simulation]; " in message('name = "x"')
    assert "duration: this key is missing, and so is simulation.output_step; " in message(SCENE[: SCENE.index("duration")])


def test_files_that_are_no_case_files_are_refused(tmp_path: Path) -> None:
    def refused(path: Path | str) -> str:
        with pytest.raises(CaseError) as error:
            load_case(str(path))
        return str(error.value)

    latin, large, pipe = tmp_path / "latin.toml", tmp_path / "large.toml", tmp_path / "pipe.toml"
    latin.write_bytes(SCENE.replace("A scene", "Ein Gerät").encode("latin-1"))
    large.write_text("#" * 64_001)
    os.mkfifo(pipe)
    instead = "give the path of a case file or the name of a library case"
    assert refused(latin) == f"{latin}: is not in UTF-8 (line 2); save it as plain text in UTF-8"
    assert refused(large) == f"{large}: is larger than 64 kB; {instead}"
    assert refused(pipe) == f"{pipe}: is no regular file; {instead}"
    assert refused(tmp_path) == f"{tmp_path}: is no regular file; {instead}"
    assert refused(tmp_path / "no.toml") == f"{tmp_path}/no.toml: there is no such file; {instead}"
    assert re.fullmatch(rf"a\\x00/b: cannot be read \([^()]*embedded null [^()]*\); {re.escape(instead)}", refused("a\0/b"))
    assert refused("thesis24") == (
        '"thesis24": no case of the library has this name; the nearest one is thesis-24 (`quickreturn cases` lists all); or give a path'
    )


@given(st.text(max_size=300))
def test_any_text_is_either_a_case_or_refused(text: str) -> None:
    with pytest.raises(CaseError, match=r"^scene\.toml: "):
        parse_case(text, "scene.toml")


@given(st.integers(0, len(SCENE) - 1), st.integers(0, len(SCENE) - 1), st.sampled_from(["", '"', "=", "[", "0", "-", " ", "\n", "é", "\0"]))
def test_a_damaged_case_file_never_breaks_anything_else(place: int, other: int, inserted: str) -> None:
    first, last = sorted((place, other))
    try:
        case = parse_case(SCENE[:first] + inserted + SCENE[min(last, first + 3) :], "scene.toml")
    except CaseError as refused:
        told = str(refused)
    else:
        told = f"scene.toml: {case.name}"
    assert all(line.startswith("scene.toml: ") for line in told.split("\n"))


def test_all_mistakes_of_a_file_are_told_in_one_answer_in_its_order() -> None:
    text = changed('length = "4 in"', 'lenght = "4 in"').replace('"0.1 lbf*s^2/in"', '"0.1 m"').replace("1.5e-4 lbf*s^2*in", "-1 kg*m^2")
    text = text.replace('width = "1.5 in"\n', "").replace('title = "A scene"', "title = 7").replace('"25 in"', '"25"')
    told = message(text).split("\n")
    keys = ["crank.lenght", "title", "crank.mass", "base.inertia", "follower.length", "follower.width"]
    assert [line.split(": ")[1] for line in told] == keys
    assert "crank.length" in told[0]
    assert told[-1].endswith('follower.width: this key is missing; write a length, such as "2 in"'), "and not crank.length, which is meant"
    assert message(text.replace("titl", "tilt")).count("\n") == len(keys) - 1


def test_mistakes_in_overrides_are_told_together() -> None:
    with pytest.raises(CaseError) as refused:
        parse_case(SCENE, "scene.toml", {"crank.lenght": "4 in", "name": "x", "tip.mass": "heavy"})
    assert [(each.source, each.key) for each in (refused.value, *refused.value.further)] == [
        ("overrides", "crank.lenght"),
        ("overrides", "name"),
    ]
    with pytest.raises(CaseError) as refused:
        parse_case(SCENE, "scene.toml", {"crank.length": "4", "tip.mass": "heavy"})
    assert [(each.source, each.key) for each in (refused.value, *refused.value.further)] == [
        ("overrides", "crank.length"),
        ("overrides", "tip.mass"),
    ]


def test_what_does_not_fit_together_is_told_with_times_that_do_not() -> None:
    told = message(changed('length = "4 in"', 'length = "18 in"').replace('output_step = "1 ms"', 'output_step = "3 s"')).split("\n")
    assert [line.split(": ")[1] for line in told] == ["crank.length", "simulation.duration"]


def test_of_very_many_mistakes_ten_are_told() -> None:
    told = message("".join(f"key-{number} = 1\n" for number in range(20)) + SCENE).split("\n")
    assert len(told) == 11
    assert told[-1] == "scene.toml: 10 more mistakes; mend those above first"


# A follower alone: no crank, no slider, a base that is spun up.
