"""What a case file may not be beyond the mistakes in every quantity and key (`tests/quickreturn/input`): each is named with its place."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import ENTRIES, case_names, load_case
from tests.cases.files.scene_texts import SCENE, changed, message, parse_case

LENGTH, ANGLE, STEP = 'length = "4 in"', 'initial_angle = "180 deg"', 'output_step = "1 ms"'
TORQUE, JOINT, GAUGES = 'torque = "10 lbf*in"', 'joint_stiffness = "100 lbf/in"', '"18.75 in"]'
DAMPING, START = 'damping = "0.60176535 lbf*in*s/rad"\n', 'initial_speed = "16.617773 rad/s"'
#: What stands in the file, what is written instead, the place that is named, and a word of what is accepted or wrong.
BAD = [
    ("[base]", "[[base]]", "base", "[base]"),
    ('tags = ["test"]', 'gravity = ["0 N/kg"]', "gravity", "mechanism.gravity"),
    ('[simulation]\nduration = "2 s"\noutput_step = "1 ms"\n', "", "[simulation]", "duration, output_step"),
    ('name = "scene"\n', "", "name", "missing"),
    ('name = "scene"', 'name = "../scene"', "name", "64 letters"),
    ('title = "A scene"', 'title = "A\\nB"', "title", "one line"),
    ('tags = ["test"]', 'tags = "test"', "tags", "list of tags"),
    # the crank's drive
    (TORQUE, f'{TORQUE}\nprescribed_speed = "16 rad/s"', "crank.prescribed_speed", "crank.torque"),
    (f"{TORQUE}\n", "", "crank.torque", "missing"),
    (f"{TORQUE}\n{DAMPING}{ANGLE}\n{START}", ANGLE, "crank", "prescribed_speed"),
    (f"{DAMPING}{ANGLE}\n{START}", f'damping = "0 lbf*in*s/rad"\n{ANGLE}', "crank.initial_speed", "torque / damping"),
    # what does not fit together
    (LENGTH, 'length = "18 in"', "crank.length", "mechanism.pivot_distance (0.4572 m)"),
    (LENGTH, 'length = "8 in"', "crank.length", "pivot_distance + crank.length = 0.6604 m"),
    (GAUGES, '"18.75 in", "20 in"]', "follower.strain_gauges", "3 strings"),
    (GAUGES, '"25.1 in"]', "follower.strain_gauges", "0.63754 m outside"),
    (JOINT, 'joint_stiffness = "inf"', "slider.joint_damping", "rigid"),
    (JOINT, f'{JOINT}\nclearance = "0.2 mm"\npreload = "2 N"', "slider.clearance", "slider.preload (2 N)"),
    (JOINT, f'{JOINT}\njoint_stiffness_plus = "10 kN/m"', "slider.joint_stiffness_plus", "slider.joint_stiffness (17512.7 N/m)"),
    (STEP, 'output_step = "3 ms"', "simulation.duration", "666.667 output steps"),
    (STEP, 'output_step = "1 ns"', "simulation.duration", "2 million"),
    # TOML itself
    (LENGTH, "length = " + "9" * 5000, "line 10 has 5009 characters; at most 1000 are accepted", ""),
    (LENGTH, "a." * 490 + "b = 1", "crank.a", "length, mass"),
    (LENGTH, "length = " + "[" * 900, "is nested too deeply; sections with strings and lists of strings are accepted", ""),
    ("[base]", "[base", "line 19", "[section]"),
    ('width = "1.5 in"', "width = 1,5 in", "line 28", "[section]"),
    ('width = "1.5 in"', "width = '1.5 in", "line 28", "[section]"),  # the parser looks for ' up to the end
    ('width = "1.5 in"', "width = “1.5 in”", "line 28", "typographic quotes"),
    ('width = "1.5 in"', 'width = "1.5 in"\nwidth = "2 in"', "line 29", "repeats an earlier key"),
]


@pytest.mark.parametrize(("old", "new", "place", "word"), BAD, ids=lambda text: text[:50])
def test_each_mistake_is_one_sentence_with_its_place(old: str, new: str, place: str, word: str) -> None:
    told = message(changed(old, new)).splitlines()[0]  # some break more than one rule
    assert told.startswith(f"scene.toml: {place}")
    assert word in told


def test_a_torque_driven_crank_needs_inertia_of_its_own() -> None:
    light = changed('mass = "0.1 lbf*s^2/in"', 'mass = "0 kg"').replace('"4.0e-4 lbf*s^2*in"', '"0 kg*m^2"')
    assert parse_case(light, "scene.toml").mechanism.crank.inertia_about_pivot == 0.0  # the slider's mass is enough
    assert message(light.replace('mass = "0.01 lbf*s^2/in"', 'mass = "0 kg"')).startswith('scene.toml: crank.inertia: "0 kg*m^2" ')


def test_all_that_is_missing_is_named_in_one_sentence() -> None:
    lacking = changed(f"{ANGLE}\n", "").replace('damping = "2e-5 lbf*in*s/rad"\n', "").replace(f"{STEP}\n", "")
    assert "initial_angle: this key is missing, and so are base.damping and simulation.output_step; " in message(lacking)
    without_base = lacking[: lacking.index("[base]")] + lacking[lacking.index("[follower]") :]
    assert "missing, and so are [base] and simulation.output_step; " in message(without_base)
    assert "[mechanism]: this section is missing, and so are [crank], [base], [follower] and [simulation]; " in message('name = "x"')


@given(st.integers(0, len(SCENE) - 1), st.integers(0, len(SCENE) - 1), st.sampled_from(["", '"', "=", "[", "0", "-", " ", "\n", "é", "\0"]))
def test_a_damaged_case_file_never_breaks_anything_else(place: int, other: int, inserted: str) -> None:
    first, last = sorted((place, other))
    told = "scene.toml: "
    try:
        parse_case(SCENE[:first] + inserted + SCENE[min(last, first + 3) :], "scene.toml")
    except CaseError as refused:
        told = str(refused)
    assert all(line.startswith("scene.toml: ") for line in told.split("\n"))


def test_all_mistakes_of_a_file_are_told_in_one_answer_in_its_order() -> None:
    text = changed(LENGTH, 'lenght = "4 in"').replace('"0.1 lbf*s^2/in"', '"0.1 m"').replace("1.5e-4 lbf*s^2*in", "-1 kg*m^2")
    text = text.replace('width = "1.5 in"\n', "").replace('title = "A scene"', "title = 7").replace('"25 in"', '"25"')
    told = message(text).split("\n")
    keys = ["crank.lenght", "title", "crank.mass", "base.inertia", "follower.length", "follower.width"]
    assert [line.split(": ")[1] for line in told] == keys, "and not crank.length, which is meant"
    times = message(changed(LENGTH, 'length = "18 in"').replace(STEP, 'output_step = "3 s"')).split("\n")
    assert [line.split(": ")[1] for line in times] == ["crank.length", "simulation.duration"]
    many = message("".join(f"key-{number} = 1\n" for number in range(20)) + SCENE).split("\n")
    assert (len(many), many[-1]) == (11, "scene.toml: 10 more mistakes; mend those above first")


@pytest.mark.parametrize("keys", [("crank.lenght", "name"), ("crank.length", "tip.mass")])
def test_mistakes_in_overrides_are_told_together(keys: tuple[str, str]) -> None:
    with pytest.raises(CaseError) as refused:
        parse_case(SCENE, "scene.toml", dict.fromkeys(keys, "heavy"))
    assert [(each.source, each.key) for each in (refused.value, *refused.value.further)] == [("overrides", key) for key in keys]


#: Young's modulus and density of what an arm may be made of, from common tables of materials.
MATERIALS = {
    "steel": ("210 GPa", "7850 kg/m^3"),
    "aluminium": ("70 GPa", "2700 kg/m^3"),
    "carbon fibre in epoxy": ("140 GPa", "1600 kg/m^3"),
    "pine along the grain": ("10 GPa", "500 kg/m^3"),
    "polycarbonate": ("2.3 GPa", "1200 kg/m^3"),
    "PTFE": ("0.5 GPa", "2200 kg/m^3"),
}


def notes(**overrides: str) -> tuple[str, ...]:
    return parse_case(SCENE, "scene.toml", {f"follower.{key}": value for key, value in overrides.items()}).notes


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"follower.length": "602.7 m"}, ("follower.length", "602.7 m")),
        ({"follower.thickness": "17 cm"}, ("follower.thickness", "0.17 m", "quarter")),
        ({"follower.thickness": "40 mm"}, ("follower.thickness", "0.04 m", "the width (0.0381 m)", "stiff side")),
        ({"follower.bending_stiffness": "0.021 N*m^2"}, ("follower.bending_stiffness", "207 MPa", "2713 kg/m^3", "steel 210 GPa")),
        ({"crank.center_of_mass": "76 m"}, ("crank.center_of_mass", "76 m", "pivot distance")),
        ({"tip.mass": "1.1 kg"}, ("tip.mass", "1.1 kg", "5.28 times", "0.208 kg")),  # 0.32818 kg/m x 0.635 m = 0.2084 kg
    ],
)
def test_values_that_can_hardly_be_meant_are_said_and_not_refused(overrides: dict[str, str], words: tuple[str, ...]) -> None:
    assert parse_case(SCENE, "scene.toml").notes == ()
    found = parse_case(SCENE, "scene.toml", overrides).notes
    assert any(all(word in note for word in words) for note in found), found


@pytest.mark.parametrize("material", MATERIALS)
def test_materials_that_there_are_raise_no_doubt(material: str) -> None:
    modulus, density = MATERIALS[material]
    assert notes(elastic_modulus=modulus, density=density) == ()


@pytest.mark.parametrize("material", ["steel", "aluminium", "carbon fibre in epoxy", "pine along the grain"])
def test_megapascals_for_gigapascals_are_doubted_for_every_stiff_material(material: str) -> None:
    modulus, density = MATERIALS[material]
    (note,) = notes(elastic_modulus=modulus.replace("GPa", "MPa"), density=density)
    assert f"a modulus of {modulus.replace('GPa', 'MPa')} " in note


def test_values_of_the_library_are_meant_and_changed_ones_may_be_doubted() -> None:
    published = {note for entry in ENTRIES.values() for note in entry.notes()}
    for name in case_names():
        assert set(load_case(name).notes) <= published, name
    assert load_case("shaper-cutting", {"crank.length": "100 mm"}).notes == ()  # 40 mm over 12 mm, as it is in the library
    (note,) = load_case("shaper-cutting", {"follower.thickness": "50 mm"}).notes
    assert note.startswith("follower.thickness is 0.05 m")
    changed = load_case("thesis-24", {"tip.mass": "3 kg"})
    assert changed.notes[:-1] == load_case("thesis-24").notes
    assert changed.notes[-1].startswith("tip.mass is 3 kg")
