"""The equations of a small system in LaTeX, simplified by sympy."""

import operator
from collections.abc import Callable

import casadi as ca
import sympy as sp

from quickreturn.plugins.derive.equations import Equations
from quickreturn.plugins.derive.machine_code import OPERATIONS
from quickreturn.plugins.derive.system import System, column
from quickreturn.plugins.derive.units import DescriptionError

#: Largest number of CasADi's instructions: with more the equations are unreadable, and sympy takes minutes.
_LONGEST = 1500
#: Largest denominator of a number that is written as a fraction; other numbers are decimals.
_LARGEST_DENOMINATOR = 16


def lines_of(system: System) -> list[str]:
    """A line for each equation of a system, see `quickreturn.derive.latex`."""
    e, n = Equations(system, "multipliers"), len(system.coordinates)
    a, force = e.a, column(*(loop.force for loop in system.loops))
    balance = column(e.M[:n, :n] @ a, e.Q[:n] + e.C[:, :n].T @ force, e.gap)
    names = [(system.time, "t"), *((symbol, _written(name)) for name, (symbol, _, _) in system.parameters.items())]
    for c in system.coordinates:
        names += [(symbol, form % _written(c.name)) for symbol, form in ((c.q, "%s"), (c.v, r"\dot{%s}"), (c.a, r"\ddot{%s}"))]
    names += [(each, _written(each.name())) for each in ca.vertsplit(force)]
    symbols = [sp.Symbol(name, real=True) for _, name in names]
    function = ca.Function("equations", [ca.vertcat(*(symbol for symbol, _ in names))], [ca.densify(balance)])
    if function.n_instructions() > _LONGEST:
        raise DescriptionError(
            f"the equations of {system.name!r} take {function.n_instructions()} instructions; LaTeX is for {_LONGEST} at most"
        )
    equations = [sp.simplify(each) for each in _translated(function, symbols)]
    accelerations = [symbols[k] for k, (_, name) in enumerate(names) if name.startswith(r"\ddot")]
    left, right = [sp.collect(sp.expand(each), accelerations) for each in equations[:n]], equations[n : 2 * n]
    lines = [f"{sp.latex(one)} &= {sp.latex(other)}" for one, other in zip(left, right, strict=True)]
    return [*lines, *(f"{sp.latex(gap)} &= 0" for gap in equations[2 * n :])]


def _written(name: str) -> str:
    """Greek and single letters as sympy writes them, words upright."""
    written = sp.latex(sp.Symbol(name))
    return written if "\\" in written or len(name.split("_")[0]) == 1 else rf"\mathrm{{{name.replace('_', ' ').replace(' ', '~')}}}"


def _translated(function: ca.Function, symbols: list[sp.Symbol]) -> list[sp.Expr]:
    """A CasADi function's outputs in sympy, by its list of instructions."""
    functions: dict[str, Callable[..., sp.Expr]] = {name: getattr(operator, name) for name in ("add", "sub", "mul", "neg", "pow")}
    functions |= {name: getattr(sp, name) for name in ("sin", "cos", "tan", "sqrt", "exp", "tanh", "atan", "atan2")}
    functions |= {"div": operator.truediv, "constpow": operator.pow, "assign": operator.pos}
    functions |= {"sq": lambda a: a**2, "twice": lambda a: 2 * a, "inv": lambda a: 1 / a}
    translations = {getattr(ca, f"OP_{name.upper()}"): each for name, each in functions.items()}
    values: dict[int, sp.Expr] = {}
    outputs = [sp.Integer(0)] * function.numel_out()
    for k in range(function.n_instructions()):
        operation, inputs, out = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            outputs[out[1]] = values[inputs[0]]
        elif operation == ca.OP_INPUT:
            values[out[0]] = symbols[inputs[1]]
        elif operation == ca.OP_CONST:
            value = function.instruction_constant(k)
            exact = sp.nsimplify(value, rational=True)
            values[out[0]] = exact if exact.q <= _LARGEST_DENOMINATOR else sp.Float(value)
        elif operation in translations:
            values[out[0]] = translations[operation](*(values[i] for i in inputs))
        else:
            raise DescriptionError(f"CasADi's operation {OPERATIONS[operation]!r} has no LaTeX here")
    return outputs
