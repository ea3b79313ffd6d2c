"""Machine code against the interpreter, operation by operation, and against numpy."""

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from quickreturn.derive import DescriptionError, Model, System, vector
from quickreturn.plugins.derive.machine_code import MachineCode
from quickreturn.plugins.derive.tests import published as of

ONE = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "sinh": np.sinh, "cosh": np.cosh,
    "tanh": np.tanh, "asinh": np.arcsinh, "atanh": np.arctanh, "exp": np.exp, "log": np.log, "sqrt": np.sqrt, "fabs": np.abs,
    "floor": np.floor, "ceil": np.ceil, "sign": np.sign, "log1p": np.log1p, "expm1": np.expm1,
}  # fmt: skip
TWO = {
    "fmin": np.minimum,
    "fmax": np.maximum,
    "atan2": np.arctan2,
    "power": np.power,
    "fmod": np.fmod,
    "copysign": np.copysign,
    "hypot": np.hypot,
}


@pytest.mark.parametrize("name", ONE)
@pytest.mark.parametrize("value", [0.37, -0.61, 0.0])
def test_functions_of_one_number(name: str, value: float) -> None:
    value = value if value > 0 or name not in ("log", "sqrt") else 0.5
    x = ca.SX.sym("x")
    found = MachineCode(x, getattr(ca, name)(x), [name])(np.array([value]))
    np.testing.assert_allclose(found, ONE[name](value), rtol=4e-16, atol=1e-300)


@pytest.mark.parametrize("name", TWO)
def test_functions_of_two_numbers(name: str) -> None:
    x = ca.SX.sym("x", 2)
    expression = x[0] ** x[1] if name == "power" else getattr(ca, name)(x[0], x[1])
    for values in ([0.4, 1.7], [2.5, -0.3]):
        np.testing.assert_allclose(MachineCode(x, expression, [name])(np.array(values)), TWO[name](*values), rtol=4e-16)


def test_arithmetic_and_conditions() -> None:
    x = ca.SX.sym("x", 3)
    a, b, c = x[0], x[1], x[2]
    branches = [
        ca.if_else(a < b, c, -c),
        ca.if_else(ca.logic_and(a <= b, c != 0), 1 / c, a / b),
        ca.if_else(ca.logic_not(a == b), 2 * a, a**2),
    ]
    code = MachineCode(x, ca.vertcat(a + b - c, a * b / c, (a + b) ** 3, *branches), list("abcdef"))
    for values in ([1.0, 2.0, 3.0], [2.0, 1.0, -0.5], [1.5, 1.5, 4.0]):
        found, (a_, b_, c_) = code(np.array(values)), values
        expected = [
            a_ + b_ - c_,
            a_ * b_ / c_,
            (a_ + b_) ** 3,
            c_ if a_ < b_ else -c_,
            1 / c_ if a_ <= b_ else a_ / b_,
            2 * a_ if a_ != b_ else a_**2,
        ]
        np.testing.assert_allclose(found, expected, rtol=1e-15)


@pytest.mark.parametrize("mechanism", [of.andrews_squeezer, of.two_link_arm], ids=lambda each: each.__name__)
def test_the_rates_of_a_mechanism_are_those_of_the_interpreter(mechanism: Callable[[], of.Published]) -> None:
    described = mechanism()
    model = Model(described.system)
    y, p = model.start(described.start), model.values(None)
    found, expected = model.rates(0.0, y, p), np.array(model._rates.interpreter(model.input(0.0, y, p))).ravel()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.max(np.abs(expected)))


def test_what_is_no_number_is_named() -> None:
    system = System("spring")
    p = system.constants(mass=(1.0, "kg"), pull=(1.0, "N"), length=(1.0, "m"))
    x = system.coordinate("x", "m")
    system.body("weight", p.mass, vector(x, 0))
    system.load("spring", x, p.pull * ca.sqrt(x / p.length))
    model = Model(system)
    model.check(model.start({"x": 1.0}), model.values(None))
    with pytest.raises(DescriptionError, match=r"^rate of x_rate is nan at the start; look for a root of a negative number"):
        model.check(model.start({"x": -1.0}), model.values(None))
    with pytest.raises(DescriptionError, match="not translated to machine code"):
        MachineCode(x, ca.erfinv(x), ["one", "two"])
