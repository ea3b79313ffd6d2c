import math
import string
import subprocess
import sys
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from quickreturn.cases import units
from quickreturn.cases.units import COMMON_UNITS, Dimension, QuantityError, parse_quantity, unit_of_pint

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

# Each would mean something else, or be evaluated, without the grammar.
REFUSED = [
    ("4,5 in", "has a comma in its number (the decimal sign is a point)"),
    ("1,000.5 in", "has a comma in its number (the decimal sign is a point)"),
    ("4", "has no unit"),
    ("4 ", "begins or ends with white space"),
    (" 4 in", "begins or ends with white space"),
    ("4 in\n", "begins or ends with white space"),
    ("4  in", "has more than one space between number and unit"),
    ("4in", "has no space between number and unit"),
    ("4\tin", "has white space other than one plain space after its number"),
    ("", "is empty"),
    ("in", "does not begin with a number"),
    ("four in", "does not begin with a number"),
    ("2*3 in", "has arithmetic in its number (give the result)"),
    ("9**9**9 in", "has arithmetic in its number (give the result)"),
    ("1_000 in", "does not begin with a plain decimal number"),
    ("0x10 in", "does not begin with a plain decimal number"),
    ("٣ in", "has other digits than 0 to 9"),
    ("nan in", "is not a number"),
    ("-NaN in", "is not a number"),
    ("inf", "is infinite"),
    ("-Infinity in", "is infinite"),
    ("1e999 in", "is out of range"),
    ("1e999999999999 in", "is out of range"),
    ("1e-320 in", "is out of range"),
    ("1e-999999999999 in", "is out of range"),
    ("4 m^9999999", 'has the unreadable unit "m^9999999" (names joined by * and /, whole exponents from -9 to 9 as in in^2)'),
    ("4 m^0.5", 'has the unreadable unit "m^0.5" (names joined by * and /, whole exponents from -9 to 9 as in in^2)'),
    ("4 m**2**9", 'has the unreadable unit "m**2**9" (names joined by * and /, whole exponents from -9 to 9 as in in^2)'),
    ("4 (m)", 'has the unreadable unit "(m)" (names joined by * and /, whole exponents from -9 to 9 as in in^2)'),
    ("4 m*", 'has the unreadable unit "m*" (names joined by * and /, whole exponents from -9 to 9 as in in^2)'),
    ("4 m 2", 'has the unreadable unit "m 2" (names joined by * and /, whole exponents from -9 to 9 as in in^2)'),
    ("4 2*m", 'has the unreadable unit "2*m" (names joined by * and /, whole exponents from -9 to 9 as in in^2)'),
    ("4 m²", 'has the unknown unit "m²" (perhaps meant as "m^2", an area (m^2), but a length is needed)'),
    ("4 m2", 'has the unknown unit "m2" (perhaps meant as "m^2", an area (m^2), but a length is needed)'),
    ("4 furlongs_per_fortnight", 'has the unknown unit "furlongs_per_fortnight"'),
    ("4 percent*in", 'has the unknown unit "percent"'),
    ("4 degC", 'has the unknown unit "degC"'),
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


@pytest.mark.parametrize(("text", "problem"), REFUSED)
def test_what_is_no_plain_length_is_refused_and_named(text: str, problem: str) -> None:
    with pytest.raises(QuantityError) as refused:
        parse_quantity(text, units.LENGTH)
    assert refused.value.problem == problem


@pytest.mark.parametrize(
    ("text", "dimension", "problem"),
    [
        ("180 in/in", units.ANGLE, "is a pure number (1), but an angle is needed"),
        (
            "1 lb*s^2/in",
            units.MASS,
            'is a quantity in kg*s^2/m (perhaps meant as "lbf*s^2/in"), but a mass is needed',
        ),
        ("1 N*m*s*rad", units.ROTARY_DAMPING, "is a quantity in kg*m^2*rad/s, but a rotary damping is needed"),
        ("1 Nm", units.TORQUE, 'is a quantity in m/kg (perhaps meant as "N*m"), but a torque is needed'),
        ("480 MPA", units.ELASTIC_MODULUS, 'has the unknown unit "MPA" (perhaps meant as "MPa")'),
        ("2 KN", units.FORCE, 'has the unknown unit "KN" (perhaps meant as "kN")'),
        ("1 lbm", units.MASS, 'has the unknown unit "lbm" (perhaps meant as "lb")'),
        ("1 lbm*in^2", units.MOMENT_OF_INERTIA, 'has the unknown unit "lbm" (perhaps meant as "lb*in^2")'),
        ("1 Ns/m", units.DAMPING, 'has the unknown unit "Ns" (perhaps meant as "N*s/m")'),
        ("1 Ns", units.DAMPING, 'has the unknown unit "Ns" (perhaps meant as "N*s", a quantity in kg*m/s, but a damping is needed)'),
        ("1 Nms/rad", units.ROTARY_DAMPING, 'is a quantity in m/kg/rad (perhaps meant as "N*m*s/rad"), but a rotary damping is needed'),
        ("1 in-lb", units.TORQUE, 'has the unreadable unit "in-lb" (perhaps meant as "in*lbf")'),
        ("1 inlb", units.TORQUE, 'has the unknown unit "inlb" (perhaps meant as "in*lbf")'),
        ("1 kgm^2", units.MOMENT_OF_INERTIA, 'has the unknown unit "kgm" (perhaps meant as "kg*m^2")'),
        ("1 N·m", units.TORQUE, 'has the unreadable unit "N·m" (perhaps meant as "N*m")'),
        ("1 N m", units.TORQUE, 'has the unreadable unit "N m" (perhaps meant as "N*m")'),
        ("1 N*m2", units.BENDING_STIFFNESS, 'has the unknown unit "m2" (perhaps meant as "N*m^2")'),
        ("160 RPM", units.ANGULAR_SPEED, 'has the unknown unit "RPM" (perhaps meant as "rpm")'),
        ("180 °", units.ANGLE, 'has the unreadable unit "°" (perhaps meant as "deg")'),
        ("1 N*m/rad", units.TORQUE, "is a quantity in kg*m^2/s^2/rad, but a torque is needed"),
    ],
)
def test_radians_and_pounds_are_kept_apart(text: str, dimension: Dimension, problem: str) -> None:
    with pytest.raises(QuantityError) as refused:
        parse_quantity(text, dimension)
    assert refused.value.problem == problem


@pytest.mark.parametrize(
    ("text", "told", "rpm"),
    [
        ("90 1/min", 'has the unreadable unit "1/min"', "90"),
        ("-90 1/min", 'has the unreadable unit "1/min"', "-90"),
        ("90 /min", 'has the unreadable unit "/min"', "90"),
        ("90 min^-1", "is a frequency (1/s)", "90"),
        ("90 rev/min", 'has the unknown unit "rev"', "90"),
        ("90 U/min", 'has the unknown unit "U"', "90"),
        ("90 r/min", 'has the unknown unit "r"', "90"),
        ("90 revolutions per minute", "has the unreadable unit", "90"),
        ("1.5 rev/s", 'has the unknown unit "rev"', "90"),
        ("2.64 Hz", "is a frequency (1/s)", "158.4"),
        ("1.5e-3 kHz", "is a frequency (1/s)", "90"),
    ],
)
def test_turns_in_a_time_are_answered_with_their_value_in_rpm(text: str, told: str, rpm: str) -> None:
    with pytest.raises(QuantityError) as refused:
        parse_quantity(text, units.ANGULAR_SPEED)
    assert told in refused.value.problem
    assert f'(perhaps meant as "{rpm} rpm")' in refused.value.problem


@pytest.mark.parametrize("unit", ["1/s", "s^-1", "s**-1", "/s", "1/sec"])
def test_a_plain_rate_may_be_radians_or_turns(unit: str) -> None:
    with pytest.raises(QuantityError) as refused:
        parse_quantity(f"16.6 {unit}", units.ANGULAR_SPEED)
    assert '(perhaps meant as "996 rpm" or "16.6 rad/s")' in refused.value.problem


@pytest.mark.parametrize("text", ["90 1/m", "90 rev", "1e400 Hz", "90 Hz^2", "90 1/min/s", "90 rad"])
def test_what_is_no_frequency_is_not_called_turns(text: str) -> None:
    with pytest.raises(QuantityError) as refused:
        parse_quantity(text, units.ANGULAR_SPEED)
    assert "rpm" not in refused.value.problem


@pytest.mark.parametrize("dimension", [units.TIME, units.STIFFNESS, units.ANGLE])
def test_only_an_angular_speed_is_answered_with_rpm(dimension: Dimension) -> None:
    with pytest.raises(QuantityError) as refused:
        parse_quantity("90 1/min", dimension)
    assert "rpm" not in str(refused.value)


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


@given(st.decimals(min_value="-1e6", max_value="1e6", places=6))
def test_inches_and_metres_of_the_same_length_agree(inches: Decimal) -> None:
    in_metres = inches * Decimal("0.0254")
    # the same double: both are rounded once, from the same decimal number
    assert parse_quantity(f"{inches:f} in", units.LENGTH) == parse_quantity(f"{in_metres:f} m", units.LENGTH)


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


@given(
    st.from_regex(r"[1-9]\.[0-9]e-?[0-9]{1,2}", fullmatch=True),
    st.from_regex(r"[a-zµ_]{1,6}([*/][a-z]{1,4}){0,3}(\^-?[1-9])?", fullmatch=True),
)
def test_any_unit_is_either_read_or_refused_with_a_sentence(number: str, unit: str) -> None:
    answer = read_or_refused(f"{number} {unit}", units.MASS)
    assert answer if isinstance(answer, str) else math.isfinite(answer)


def test_every_unit_that_pint_knows_is_either_read_or_refused() -> None:
    names = list(units._registry())
    assert len(names) > 500
    assert all(read_or_refused(f"1 {name}", units.MASS) for name in names)


@pytest.mark.parametrize("name", COMMON_UNITS)
def test_the_commonest_units_are_what_pint_has(name: str) -> None:
    factor, exponents = COMMON_UNITS[name]
    assert unit_of_pint(name) == (Decimal(factor), exponents)


def test_a_run_of_the_thesis_does_without_pint() -> None:
    code = "import sys; from quickreturn.cases.case_file import load_case; load_case('thesis-24'); print('pint' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
