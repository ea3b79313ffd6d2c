import math
import string
import subprocess
import sys
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from quickreturn.cases.files import units
from quickreturn.cases.files.units import COMMON_UNITS, Dimension, QuantityError, parse_quantity, unit_of_pint

# SI values of the definitions: 1 in = 0.0254 m, 1 lbf = 0.45359237 kg x 9.80665 m/s^2, worked out by hand in decimals.
KNOWN = [
    ("4 in", units.LENGTH, 0.1016),
    ("0.125 in", units.LENGTH, 0.003175),
    ("25.4 mm", units.LENGTH, 0.0254),
    ("1e3 um", units.LENGTH, 1e-3),
    ("1 ft", units.LENGTH, 0.3048),
    ("1 lbf*s^2/in", units.MASS, 4.4482216152605 / 0.0254),
    ("1 lbf*s**2/in", units.MASS, 4.4482216152605 / 0.0254),
    ("1 lb", units.MASS, 0.45359237),
    ("10 lbf*in", units.TORQUE, 44.482216152605 * 0.0254),
    ("1 lbf*in*s/rad", units.ROTARY_DAMPING, 4.4482216152605 * 0.0254),
    ("1 lbf*in*s", units.ROTARY_DAMPING, 4.4482216152605 * 0.0254),
    ("180 deg", units.ANGLE, math.pi),
    ("-1.5 rad", units.ANGLE, -1.5),
    ("60 rpm", units.ANGULAR_SPEED, 2.0 * math.pi),
    ("360 deg/s", units.ANGULAR_SPEED, 2.0 * math.pi),
    ("1 ms", units.TIME, 1e-3),
    ("386.0885826771654 in/s^2", units.ACCELERATION, 9.80665),
    ("2128.22 lbf*in^2", units.BENDING_STIFFNESS, 2128.22 * 4.4482216152605 * 0.0254**2),
    ("1 s^-2*m", units.ACCELERATION, 1.0),
    ("+.5e+1 N/m", units.STIFFNESS, 5.0),
    ("2. kN/m", units.STIFFNESS, 2000.0),
    ("0 kg", units.MASS, 0.0),
    ("-0.0e9 m/s^2", units.ACCELERATION, 0.0),
]

COMMA = "has a comma in its number (the decimal sign is a point)"
RULE = " (names joined by * and /, whole exponents from -9 to 9 as in in^2)"
# Each would mean something else, or be evaluated, without the grammar.
REFUSED = [
    ("4,5 in", COMMA),
    ("1,000.5 in", COMMA),
    ("4", "has no unit"),
    *((text, "cannot be read") for text in ("4 ", " 4 in", "4 in\n", "4  in", "4in", "4\tin", "", "in", "four in")),
    *(
        (text, "cannot be read")
        for text in ("2*3 in", "9**9**9 in", "1_000 in", "0x10 in", "٣ in", "nan in", "-NaN in", "inf", "-Infinity in")
    ),
    *((text, "is out of range") for text in ("1e999 in", "1e999999999999 in", "1e-320 in", "1e-999999999999 in")),
    *((f"4 {unit}", f'has the unreadable unit "{unit}"{RULE}') for unit in ("m^9999999", "m^0.5", "m**2**9", "(m)", "m*", "m 2", "2*m")),
    *((f"4 {unit}", f'has the unknown unit "{unit}"') for unit in ("m²", "m2", "furlongs_per_fortnight", "degC")),
    ("4 percent*in", 'has the unknown unit "percent"'),
    ("4 kg", "is a mass (kg), but a length is needed"),
    ("4 m^2", "is an area (m^2), but a length is needed"),
    ("4 in*rad", "is a quantity in m*rad, but a length is needed"),
    ("4 in/in", "is a pure number (1), but a length is needed"),
    ("4 " + "m*" * 60 + "m", "is longer than 100 characters"),
]


@pytest.mark.parametrize(("text", "dimension", "expected"), KNOWN)
def test_units_have_their_defined_values(text: str, dimension: Dimension, expected: float) -> None:
    # 1e-15: the expected values above are products of a few rounded doubles, at most 4 roundings of 1.1e-16 each
    assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-15, abs=0.0)


@pytest.mark.parametrize(
    ("text", "dimension", "problem"),
    [
        *((text, units.LENGTH, problem) for text, problem in REFUSED),
        ("180 in/in", units.ANGLE, "is a pure number (1), but an angle is needed"),
        ("1 lb*s^2/in", units.MASS, "is a quantity in kg*s^2/m, but a mass is needed"),
        ("1 N*m*s*rad", units.ROTARY_DAMPING, "is a quantity in kg*m^2*rad/s, but a rotary damping is needed"),
        ("1 N*m/rad", units.TORQUE, "is a quantity in kg*m^2/s^2/rad, but a torque is needed"),
        ("2.64 Hz", units.ANGULAR_SPEED, "is a frequency (1/s), but an angular speed is needed"),
        ("90 min^-1", units.ANGULAR_SPEED, "is a frequency (1/s), but an angular speed is needed"),
        ("480 MPA", units.ELASTIC_MODULUS, 'has the unknown unit "MPA"'),
        ("2 %", units.PURE, "is not a pure number"),
    ],
)
def test_what_is_no_plain_quantity_is_refused_and_named(text: str, dimension: Dimension, problem: str) -> None:
    with pytest.raises(QuantityError) as refused:
        parse_quantity(text, dimension)
    assert refused.value.problem == problem


def test_rigid_is_written_inf_without_a_unit_and_only_where_accepted() -> None:
    assert parse_quantity("inf", units.STIFFNESS, infinity_accepted=True) == math.inf
    for text in ("inf N/m", "+inf", "-inf", "Inf", "infinity", "1e400 N/m"):
        with pytest.raises(QuantityError):
            parse_quantity(text, units.STIFFNESS, infinity_accepted=True)


finite = st.floats(min_value=1e-50, max_value=1e50) | st.floats(min_value=-1e50, max_value=-1e-50) | st.just(0.0)


@given(finite)
def test_numbers_survive_the_grammar_exactly(number: float) -> None:
    assert parse_quantity(f"{number!r} m", units.LENGTH) == number
    assert parse_quantity(f"{number:.17e} m", units.LENGTH) == number


def read_or_refused(text: str, dimension: Dimension) -> float | str:
    """The value, or the sentence that refuses it; anything else is an error."""
    try:
        return parse_quantity(text, dimension)
    except QuantityError as refused:
        return str(refused)


@given(st.text(alphabet=string.printable + "°µ²Ω,;٣", max_size=40))
def test_any_text_is_either_read_or_refused_with_a_sentence(text: str) -> None:
    answer = read_or_refused(text, units.LENGTH)
    assert answer if isinstance(answer, str) else math.isfinite(answer)


@pytest.mark.parametrize("name", COMMON_UNITS)
def test_the_commonest_units_are_what_pint_has(name: str) -> None:
    factor, exponents = COMMON_UNITS[name]
    assert unit_of_pint(name) == (Decimal(factor), exponents)


def test_a_run_of_the_thesis_does_without_pint() -> None:
    code = "import sys; from quickreturn.cases.library import load_case; load_case('thesis-24'); print('pint' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
