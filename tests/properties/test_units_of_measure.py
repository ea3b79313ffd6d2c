"""One scene written in inches and pounds and in SI: the same numbers, and the same motion."""

import dataclasses
import math
from decimal import Context, Decimal
from typing import Any

import pytest

from quickreturn.cases.files import units
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.keys import dimension_of
from quickreturn.cases.files.units import Dimension
from quickreturn.reference_model.scene_values import values_of
from tests.cases.files.scene_texts import parse_case
from tests.properties.law import for_all
from tests.strategies import Scene, scenes

EXACT = Context(prec=60)
INCH, POUND = Decimal("0.0254"), Decimal("4.4482216152605")
BLOB = EXACT.divide(POUND, INCH)  # kg, of lbf s²/in
DEGREE = EXACT.divide(Decimal("3.14159265358979323846264338327950288419716939937511"), Decimal(180))  # DLMF, section 3.12
ONE = Decimal(1)

#: How a dimension is written in inches and pounds, and what one of it is in SI.
CUSTOMARY: dict[Dimension, tuple[str, Decimal]] = {
    units.LENGTH: ("in", INCH),
    units.MASS: ("lbf*s^2/in", BLOB),
    units.TIME: ("ms", Decimal("0.001")),
    units.ANGLE: ("deg", DEGREE),
    units.ANGULAR_SPEED: ("rpm", EXACT.multiply(DEGREE, Decimal(6))),
    units.ACCELERATION: ("in/s^2", INCH),
    units.TORQUE: ("lbf*in", EXACT.multiply(POUND, INCH)),
    units.MOMENT_OF_INERTIA: ("lbf*s^2*in", EXACT.multiply(POUND, INCH)),
    units.ROTARY_DAMPING: ("lbf*in*s/rad", EXACT.multiply(POUND, INCH)),
    units.MASS_PER_LENGTH: ("lbf*s^2/in^2", EXACT.divide(BLOB, INCH)),
    units.BENDING_STIFFNESS: ("lbf*in^2", EXACT.multiply(POUND, EXACT.multiply(INCH, INCH))),
    units.DAMPING_PER_LENGTH: ("lbf*s/in^2", EXACT.divide(BLOB, INCH)),
    units.STIFFNESS: ("lbf/in", BLOB),
    units.DAMPING: ("lbf*s/in", BLOB),
    units.FORCE: ("lbf", POUND),
    units.VELOCITY: ("in/s", INCH),
    units.CONTACT_DAMPING: ("s/in", EXACT.divide(ONE, INCH)),
}


def written(scene: Scene, digits: int | None) -> str:
    """The scene as a case file in inches and pounds, each number of eight digits; or the same in SI, rounded to `digits` digits."""
    lines = ['name = "scene"']
    for section, values in values_of(scene.mechanism).items():
        lines.append(f"[{section}]")
        for name, value in values.items():
            dimension = dimension_of(f"{section}.{name}")
            texts = [f'"{_quantity(each, dimension, digits)}"' for each in (value if isinstance(value, tuple) else (value,))]
            lines.append(f"{name} = [{', '.join(texts)}]" if isinstance(value, tuple) else f"{name} = {texts[0]}")
    step = Context(prec=8).create_decimal_from_float(1e3 * scene.output_step)
    lines.append("[simulation]")
    for name, time in (("duration", EXACT.multiply(step, Decimal(scene.rows))), ("output_step", step)):
        lines.append(f'{name} = "{_text(time, units.TIME, digits)}"')
    return "\n".join(lines)


def _quantity(value: float, dimension: Dimension, digits: int | None) -> str:
    if math.isinf(value):
        return "inf"
    if dimension is units.PURE:
        return str(Context(prec=8).create_decimal_from_float(value))
    _, size = CUSTOMARY[dimension]
    return _text(Context(prec=8).divide(Decimal(value), size), dimension, digits)


def _text(number: Decimal, dimension: Dimension, digits: int | None) -> str:
    unit, size = CUSTOMARY[dimension]
    if digits is None:
        return f"{number} {unit}"
    return f"{Context(prec=digits).plus(EXACT.multiply(number, size))} {dimension.si_unit}"


def numbers_of(part: Any) -> list[float]:
    """All numbers of a scene, in order."""
    if dataclasses.is_dataclass(part):
        return [number for field in dataclasses.fields(part) for number in numbers_of(getattr(part, field.name))]
    if isinstance(part, tuple):
        return [number for each in part for number in numbers_of(each)]
    return [] if part is None else [part]


def parsed(scene: Scene, digits: int | None) -> Case:
    return parse_case(written(scene, digits), "scene.toml")


@for_all(few=10, many=200, scene=scenes(turning_slider=True) | scenes(compliant=True))
def test_inches_and_si_are_the_same_numbers(scene: Scene) -> None:
    customary = parsed(scene, None)
    # 40 digits leave no doubt about the nearest double
    assert parsed(scene, 40).mechanism == customary.mechanism
    # 16 digits: half a unit of the last one is at most 5e-16, the nearest double adds half of 2.2e-16 to either
    assert numbers_of(parsed(scene, 16).mechanism) == pytest.approx(numbers_of(customary.mechanism), rel=1e-15, abs=0.0)
    # what was read is the scene, not something that both texts have in common: eight digits were written
    assert numbers_of(customary.mechanism) == pytest.approx(numbers_of(scene.mechanism), rel=1e-7, abs=0.0)
