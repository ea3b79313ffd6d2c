"""Values that can be but are hardly meant: which are doubted, and which ordinary machines are not."""

import pytest

from quickreturn.cases.files.case import parse_case
from quickreturn.cases.library import ENTRIES, case_names, load_case
from tests.cases.files.scene_texts import SCENE

#: Young's modulus and density of what an arm may be made of, from common tables of materials.
MATERIALS = {
    "steel": ("210 GPa", "7850 kg/m^3"),
    "aluminium": ("70 GPa", "2700 kg/m^3"),
    "magnesium": ("45 GPa", "1740 kg/m^3"),
    "lead": ("16 GPa", "11340 kg/m^3"),
    "carbon fibre in epoxy": ("140 GPa", "1600 kg/m^3"),
    "glass fibre in epoxy": ("20 GPa", "1900 kg/m^3"),
    "pine along the grain": ("10 GPa", "500 kg/m^3"),
    "acetal": ("3 GPa", "1410 kg/m^3"),
    "polycarbonate": ("2.3 GPa", "1200 kg/m^3"),
    "PTFE": ("0.5 GPa", "2200 kg/m^3"),
    "diamond": ("1100 GPa", "3500 kg/m^3"),
}


def notes(**overrides: str) -> tuple[str, ...]:
    return parse_case(SCENE, "scene.toml", {f"follower.{key}": value for key, value in overrides.items()}).notes


#: From 1 m below P to the end of the arm, 0.635 m long, which swings by asin(4 / 18) about 180 deg: sqrt(0.635^2 + 1 +- 2 0.635 4 / 18) m.
BELOW = {"spring.anchor": '["18 in", "-1 m"]', "spring.stiffness": "0 N/m", "spring.stop_stiffness": "2 N/mm"}


@pytest.mark.parametrize(
    ("stop", "words"),
    [
        ({"longest": "0.9 m"}, "spring.longest is 0.9 m, and the spring is 1.059 to 1.298 m long over the turn: the stop never lets go"),
        ({"shortest": "1.4 m"}, "spring.shortest is 1.4 m, and the spring is 1.059 to 1.298 m long over the turn: the stop never lets go"),
        ({"longest": "1.1 m"}, ""),
        ({"shortest": "1.2 m"}, ""),
    ],
)
def test_a_stop_that_never_lets_go_is_doubted(stop: dict[str, str], words: str) -> None:
    found = parse_case(SCENE, "scene.toml", BELOW | {f"spring.{key}": value for key, value in stop.items()}).notes
    assert [note.startswith(words) for note in found] == [True] * bool(words)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"follower.length": "602.7 m"}, ("follower.length", "602.7 m")),
        ({"follower.thickness": "17 cm"}, ("follower.thickness", "0.17 m", "quarter")),
        ({"follower.thickness": "40 mm"}, ("follower.thickness", "0.04 m", "the width (0.0381 m)", "stiff side")),
        ({"follower.width": "3 mm"}, ("follower.thickness", "0.003175 m", "the width (0.003 m)")),
        ({"follower.mass_per_length": "300 kg/m"}, ("follower.mass_per_length", "(or density)")),
        ({"follower.bending_stiffness": "2e6 N*m^2"}, ("follower.bending_stiffness", "(or elastic_modulus)", "steel")),
        ({"follower.bending_stiffness": "0.021 N*m^2"}, ("follower.bending_stiffness", "207 MPa", "2713 kg/m^3", "steel 210 GPa")),
        ({"crank.initial_speed": "40000 rpm"}, ("crank", "40000 rpm")),
        ({"crank.center_of_mass": "76 m"}, ("crank.center_of_mass", "76 m", "pivot distance")),
        ({"tip.center_of_mass": "12 m"}, ("tip.center_of_mass", "12 m", "length")),
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


@pytest.mark.parametrize("material", ["steel", "aluminium", "magnesium", "lead", "carbon fibre in epoxy", "pine along the grain"])
def test_megapascals_for_gigapascals_are_doubted_for_every_stiff_material(material: str) -> None:
    modulus, density = MATERIALS[material]
    (note,) = notes(elastic_modulus=modulus.replace("GPa", "MPa"), density=density)
    assert f"a modulus of {modulus.replace('GPa', 'MPa')} " in note


def test_a_metal_as_soft_as_a_plastic_is_doubted_by_its_density() -> None:
    (note,) = notes(elastic_modulus="2.1 GPa", density="7850 kg/m^3")
    assert "2.1 GPa" in note
    assert "7850 kg/m^3" in note


def test_a_slider_may_carry_a_heavy_tool_up_to_five_arms() -> None:
    assert parse_case(SCENE, "scene.toml", {"tip.mass": "1 kg"}).notes == ()  # 4.8 times 0.2084 kg


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
