"""Sections against the integral over their outline and the tables of the trade; what cannot be."""

import math

import numpy as np
import pytest

from quickreturn.cases.files.errors import CaseError
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.follower import section_of
from tests.cases.files.scene_texts import SCENE, parse_case

MM = 1e-3
SECTIONS = {
    "rectangle": {"thickness": 12 * MM, "width": 40 * MM},
    "rectangular tube": {"thickness": 40 * MM, "width": 25 * MM, "wall": 2.5 * MM},
    "I section": {"thickness": 80 * MM, "width": 46 * MM, "flange": 5.2 * MM, "web": 3.8 * MM},
    "round": {"diameter": 22 * MM},
    "tube": {"diameter": 20 * MM, "wall": 2 * MM},
}


def box(depth: float, breadth: float, to: float = 0.0) -> np.ndarray:
    """Corners of a rectangle, counter-clockwise, (y, z) with y in the plane of bending; `to`: of its centre along z."""
    return np.array(
        [[-depth / 2, to - breadth / 2], [depth / 2, to - breadth / 2], [depth / 2, to + breadth / 2], [-depth / 2, to + breadth / 2]]
    )


def circle(diameter: float) -> np.ndarray:
    turn = np.linspace(0.0, 2.0 * np.pi, 20000, endpoint=False)
    return diameter / 2.0 * np.column_stack([np.cos(turn), np.sin(turn)])


def outlines(name: str) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Outlines of what a section has and of what it lacks, as one would draw it."""
    d = SECTIONS[name]
    if name in ("round", "tube"):
        return [circle(d["diameter"])], [circle(d["diameter"] - 2.0 * d["wall"])] if "wall" in d else []
    outer, t, w = [box(d["thickness"], d["width"])], d["thickness"], d["width"]
    if "wall" in d:
        return outer, [box(t - 2.0 * d["wall"], w - 2.0 * d["wall"])]
    if "web" in d:
        each, height = (w - d["web"]) / 2.0, t - 2.0 * d["flange"]
        return outer, [box(height, each, side * (w - each) / 2.0) for side in (-1.0, 1.0)]
    return outer, []


def integrals(outline: np.ndarray) -> tuple[float, float]:
    """Area and second moment about z by Green's theorem around a polygon."""
    (y0, z0), (y1, z1) = outline.T, np.roll(outline, -1, axis=0).T
    cross = y0 * z1 - y1 * z0
    return abs(cross.sum()) / 2.0, abs((cross * (y0**2 + y0 * y1 + y1**2)).sum()) / 12.0


@pytest.mark.parametrize("name", SECTIONS)
def test_area_second_moment_and_surface_are_those_of_the_outline(name: str) -> None:
    section, (has, lacks) = section_of(**SECTIONS[name]), outlines(name)
    area, moment = np.sum([integrals(each) for each in has], axis=0) - (
        np.sum([integrals(each) for each in lacks], axis=0) if lacks else 0.0
    )
    assert section.name == name
    assert section.area() == pytest.approx(area, rel=1e-7)  # the polygon of 20,000 sides has 1.6e-8 less than the circle
    assert section.second_moment() == pytest.approx(moment, rel=1e-7)
    assert section.extreme_fibre == pytest.approx(max(np.abs(each[:, 0]).max() for each in has))
    assert section.area(7850.0) == pytest.approx(7850.0 * area, rel=1e-7)
    assert section.second_moment(210e9) == pytest.approx(210e9 * moment, rel=1e-7)
    assert section.axial_stiffness(3.0) == pytest.approx(3.0 * area / moment, rel=1e-7)


def test_standard_sections_have_the_values_of_the_tables() -> None:
    """IPE 80 (EN 10365: 7.64 cm2, 80.1 cm4), whose fillets of 5 mm count in the table; tube 20 x 2 (1.13 cm2, 0.464 cm4); a round of 22."""
    i_section, tube, solid = (section_of(**SECTIONS[name]) for name in ("I section", "tube", "round"))
    radius = 5.0  # mm; a fillet is a square less a quarter of a circle, its centre 0.2234 r from the sides
    fillets = 4.0 * (1.0 - math.pi / 4.0) * radius**2
    lever = 80.0 / 2.0 - 5.2 - 0.2234 * radius
    assert i_section.area() * 1e6 + fillets == pytest.approx(764.0, abs=0.5)
    assert i_section.second_moment() * 1e12 + fillets * lever**2 == pytest.approx(801.4e3, abs=300.0)
    assert (tube.area() * 1e4, tube.second_moment() * 1e8) == (pytest.approx(1.13, abs=5e-3), pytest.approx(0.464, abs=5e-4))
    assert (solid.area() * 1e4, solid.second_moment() * 1e8) == (pytest.approx(3.80, abs=5e-3), pytest.approx(1.15, abs=5e-3))


def text_with(name: str) -> str:
    """The scene of the tests, its arm of steel with another section."""
    dimensions = "".join(f'{key} = "{value / MM:.9g} mm"\n' for key, value in SECTIONS[name].items())
    text = SCENE.replace('thickness = "0.125 in"\nwidth = "1.5 in"\n', dimensions)
    text = text.replace('mass_per_length = "4.75987e-5 lbf*s^2/in^2"', 'density = "7850 kg/m^3"')
    return text.replace('bending_stiffness = "2128.22 lbf*in^2"', 'elastic_modulus = "210 GPa"')


@pytest.mark.parametrize("name", SECTIONS)
def test_a_case_file_gives_a_section_by_its_dimensions(name: str) -> None:
    """With the material they give stiffness and mass, with these they give material and extreme fibre; the file reads back the same."""
    case, section = parse_case(text_with(name), "scene.toml"), section_of(**SECTIONS[name])
    follower = case.scene.follower
    assert follower.section.name == name
    assert follower.bending_stiffness == pytest.approx(210e9 * section.second_moment())
    assert follower.mass_per_length == pytest.approx(7850.0 * section.area())
    assert (follower.elastic_modulus, follower.density) == (pytest.approx(210e9), pytest.approx(7850.0))
    assert parse_case(case.to_toml(), "copy.toml").scene == case.scene
    given = SCENE.replace('thickness = "0.125 in"\nwidth = "1.5 in"\n', text_with(name).partition('210 GPa"\n')[2].partition("damping")[0])
    by_numbers = parse_case(given, "scene.toml").scene.follower
    assert (by_numbers.extreme_fibre, by_numbers.section.area()) == (follower.extreme_fibre, follower.section.area())
    assert by_numbers.bending_stiffness == parse_case(SCENE, "scene.toml").scene.follower.bending_stiffness


def test_another_section_by_a_change_replaces_the_one_of_the_file() -> None:
    names = {
        "rectangular tube": {"follower.wall": "1 mm"},
        "tube": {"follower.diameter": "20 mm", "follower.wall": "1 mm"},
        "I section": {"follower.thickness": "60 mm", "follower.flange": "1 mm", "follower.web": "1 mm"},
    }
    for name, changes in names.items():
        assert parse_case(SCENE, "scene.toml", changes).scene.follower.section.name == name
    from_tube = parse_case(text_with("tube"), "scene.toml", {"follower.thickness": "20 mm", "follower.width": "30 mm"})
    assert from_tube.scene.follower.section.name == "rectangular tube"
    with pytest.raises(CaseError, match=r"follower\.thickness: .*needs follower\.width as well; give both, or follower\.diameter alone"):
        parse_case(text_with("tube"), "scene.toml", {"follower.thickness": "20 mm"})


@pytest.mark.parametrize(
    ("name", "key", "value", "words"),
    [
        ("tube", "wall", 10, "twice the wall (0.02 m) must be less than follower.diameter (0.02 m); give less than 0.01 m"),
        ("rectangular tube", "wall", 13, "twice the wall (0.026 m) must be less than follower.width (0.025 m); give less than 0.0125 m"),
        ("I section", "web", 50, "the web (0.05 m) must be less than follower.width (0.046 m)"),
        ("I section", "flange", 40, "twice the flange (0.08 m) must be less than follower.thickness (0.08 m)"),
        ("rectangle", "flange", 2, "give follower.web as well"),
        ("round", "width", 2, "conflicts with follower.width; give one of them"),
        ("I section", "wall", 2, "conflicts with follower.flange; give one of them"),
    ],
)
def test_dimensions_that_cannot_be_are_refused(name: str, key: str, value: int, words: str) -> None:
    text = "\n".join(line for line in text_with(name).split("\n") if not line.startswith(f"{key} ="))
    with pytest.raises(CaseError, match=r"^scene\.toml: follower\.") as caught:
        parse_case(text.replace("[follower]", f'[follower]\n{key} = "{value} mm"'), "scene.toml")
    assert words in str(caught.value)


def test_a_section_in_python_needs_its_dimensions_too() -> None:
    with pytest.raises(ImpossibleMechanism, match=r"follower.thickness or width is missing; give both, or diameter"):
        section_of(thickness=1.0)
