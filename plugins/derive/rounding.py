"""How far roundings alone change the outputs of a CasADi function: each operation is rounded at random, several times over.

Where forces cancel, as in an equilibrium, an output is the rounding of the forces; the output's own size says nothing. This is the scale
against which two evaluations of one function agree (stochastic arithmetic; J. Vignes, Mathematics and Computers in Simulation 35, 1993).
"""

from collections.abc import Callable
from typing import Any, Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy import special

Array = NDArray[np.float64]

#: Number of evaluations.
SAMPLES: Final = 16
_ONE: Final = {
    "assign": lambda a: a, "neg": np.negative, "inv": lambda a: 1.0 / a, "sq": np.square, "twice": lambda a: 2.0 * a,
    "not": lambda a: 1.0 * (a == 0.0), "sign": np.sign, "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos,
    "atan": np.arctan, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "asinh": np.arcsinh, "acosh": np.arccosh, "atanh": np.arctanh,
    "exp": np.exp, "log": np.log, "sqrt": np.sqrt, "fabs": np.abs, "floor": np.floor, "ceil": np.ceil, "erf": special.erf,
    "log1p": np.log1p, "expm1": np.expm1,
}  # fmt: skip
_TWO: Final = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "lt": lambda a, b: 1.0 * (a < b),
    "le": lambda a, b: 1.0 * (a <= b),
    "eq": lambda a, b: 1.0 * (a == b), "ne": lambda a, b: 1.0 * (a != b), "and": np.multiply,
    "if_else_zero": lambda a, b: np.where(a != 0.0, b, 0.0), "constpow": np.power, "fmin": np.fmin, "fmax": np.fmax, "atan2": np.arctan2,
    "pow": np.power, "fmod": np.fmod, "copysign": np.copysign, "hypot": np.hypot,
}  # fmt: skip
#: CasADi's number of an operation -> the function.
_OPERATIONS: Final[dict[int, Callable[..., Any]]] = {getattr(ca, f"OP_{name.upper()}"): each for name, each in (_ONE | _TWO).items()}


def rounding(function: Any, x: Array) -> Array:
    """The spread of each output of a function of one dense vector at x, over evaluations that round differently."""
    random, unit = np.random.default_rng(0), np.finfo(float).eps
    values: dict[int, Array] = {}
    spread = np.zeros(function.numel_out())
    with np.errstate(all="ignore"):
        for k in range(function.n_instructions()):
            operation, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
            if operation == ca.OP_OUTPUT:
                spread[outputs[1]] = np.ptp(values[inputs[0]])
            elif operation == ca.OP_INPUT:
                values[outputs[0]] = np.full(SAMPLES, x[inputs[1]])
            elif operation == ca.OP_CONST:
                values[outputs[0]] = np.full(SAMPLES, function.instruction_constant(k))
            else:
                value = _OPERATIONS[operation](*(values[i] for i in inputs))
                values[outputs[0]] = value * (1.0 + unit * random.uniform(-1.0, 1.0, SAMPLES))
    return spread
