"""Numbers are shown in the units of the question: those of the case's file, or of a set that was asked for."""

import random
import re

import pint
import pytest

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.keys import PATHS
from quickreturn.cases.files.shown import METRIC, SETS, Unit, Units, units_of
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.words import MINUS, TIED, quantity
from tests.cases.files.scene_texts import parse_case
from tests.quickreturn.scene_file import SCENE

#: SI units in which numbers are declared anywhere.
DECLARED = sorted(
    {each.unit.replace(" ", "*") for declared in (COLUMNS.values(), PATHS.values(), MEASURES.values()) for each in declared} | {"W"}
)
PINT = pint.UnitRegistry()


def in_pint(unit: str) -> pint.Quantity:
    """One of a unit, read by pint alone."""
    return PINT.Quantity(1.0, PINT.parse_units({"1": "dimensionless"}.get(unit, unit.replace("^", "**"))))


def small(**overrides: str) -> Case:
    return parse_case(SCENE, "small.toml", {key.replace("__", "."): value for key, value in overrides.items()})


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("si", DECLARED)
def test_a_shown_number_times_its_unit_is_the_number_in_si(name: str, si: str) -> None:
    chance, unit = random.Random(f"{name} {si}"), Units(SETS[name]).of(si)
    for _ in range(20):
        value = chance.choice((-1.0, 1.0)) * 10.0 ** chance.uniform(-6.0, 9.0)
        digits, _, written = unit.text(value, ".6g").partition(" ")
        assert float(digits) * in_pint(written or "1").to(in_pint(si).units).magnitude == pytest.approx(value, rel=6e-6)
        page = quantity(value, unit).partition(TIED)[0].replace(MINUS, "-")
        if not re.search("[·⁻⁰¹²³⁴⁵⁶⁷⁸⁹]", page):
            places = len(page.partition(".")[2])
            assert abs(float(page) - value * in_pint(si).to(in_pint(unit.name).units).magnitude) <= 0.51 * 10.0**-places


def test_the_unit_that_a_file_uses_most_decides() -> None:
    assert small().units.of("m") == Unit("mm", 1e-3)
    cm = small(mechanism__pivot_distance="45.72 cm", crank__length="10.16 cm", crank__center_of_mass="7.62 cm", follower__length="63.5 cm")
    assert cm.units.of("m") == Unit("mm", 1e-3)  # six of ten
    mixed = {"follower__thickness": "0.3175 cm", "follower__width": "3.81 cm"}
    assert parse_case(SCENE.replace(" mm", " cm"), "cm.toml").units.of("m") == Unit("cm", 1e-2)
    assert small(**mixed).units.of("m") == Unit("mm", 1e-3)
    assert parse_case(SCENE.replace("1.13 N*m", "1130 N*mm"), "torque.toml").units.of("N m").name == "N*mm"


def test_the_unit_of_length_decides_what_a_file_does_not_name() -> None:
    inches = parse_case(SCENE.replace(" mm", " in"), "inches.toml")
    shown = {si: inches.units.of(si).name for si in ("m", "Pa", "m/s^2", "N", "J", "W", "rad/s", "rad", "Hz", "s")}
    assert list(shown.values()) == ["in", "psi", "in/s^2", "lbf", "lbf*in", "hp", "rpm", "deg", "Hz", "s"]
    assert inches.units.of("N*m").name == "N*m"  # which the file names
    shown = {si: small().units.of(si).name for si in ("Pa", "m/s^2", "N", "J", "W", "rad/s", "rad")}
    assert list(shown.values()) == ["MPa", "m/s^2", "N", "J", "W", "rpm", "deg"]


def test_material_and_gravity_do_not_decide_but_a_strength_does() -> None:
    earth = small(mechanism__gravity='["0 g0", "-1 g0"]', follower__elastic_modulus="207 GPa", follower__density="2713 kg/m^3")
    assert (earth.units.of("m/s^2").name, earth.units.of("Pa").name) == ("m/s^2", "MPa")
    assert small(follower__yield_strength="35 ksi").units.of("Pa") == Unit("ksi", pytest.approx(6.894757e6, rel=1e-6))


def test_speeds_keep_the_unit_of_the_question() -> None:
    for given in ("rpm", "deg/s", "rad/s", "turn/s"):
        assert small(crank__initial_speed=f"16 {given}").units.of("rad/s").name == given


def test_the_library_is_shown_in_millimetres_with_the_speeds_of_its_files() -> None:
    for name, speed in (("thesis-24", "rad/s"), ("example", "rpm")):
        units = load_case(name).units
        assert [units.of(si).name for si in ("m", "Pa", "N", "m/s^2", "rad/s")] == ["mm", "MPa", "N", "m/s^2", speed]


def test_a_set_overrides_the_file_and_changes_nothing_else() -> None:
    case = small()
    inch = case.in_units("inch")
    assert (inch.units.of("m").name, inch) == ("in", case)
    assert inch.with_({"crank.length": "90 mm"}).units.of("m").name == "in"
    assert case.in_units("si").units == Units({})
    with pytest.raises(CaseError, match="accepted are si, mm, inch"):
        case.in_units("feet")
    assert units_of({}, of_library=False) == METRIC


def test_a_format_keeps_its_digits_in_another_unit() -> None:
    inch = Units(SETS["inch"])
    assert [METRIC.form(si, ".1f") for si in ("m", "Pa", "m/s^2", "rad/s")] == [".1f", ".1f", ".1f", ".0f"]
    assert [inch.form(si, ".1f") for si in ("m", "Pa", "m/s^2", "N")] == [".2f", ".0f", ".0f", ".2f"]
    assert (inch.form("m", ".3g"), inch.form("m", "+.1f"), inch.form("J", "")) == (".3g", "+.2f", "")
