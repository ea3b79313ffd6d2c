"""One sign, product or constant changed at a time in the source of the equations, run as plain Python: a mutant costs milliseconds.

What is changed: every sum and difference (a + b to a - b, and a - b to a + b; the left operand's sign where it is no sum itself), every
minus sign, every conjugate, every augmented += and -=, every assigned or returned product, every product (a * b to a / b), and every
floating-point constant (to half as much again).

What is left alone, by rule: index arithmetic (subscripts, `range`, comparisons, everything that evaluates to an int), the solution of
a linear system, and in `_locate` and `place_at` the gradient that only steers Newton's iteration to the root of the same equation.
"""

import ast
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from types import CodeType, FunctionType, ModuleType
from typing import Any, Protocol


@dataclass(frozen=True)
class Source:
    """The equations under test.

    Attributes:
        modules: in the order in which they import from each other.
        no_equations: functions that are left alone: linear algebra, index arithmetic, what another test holds.
        stand_ins: what replaces names of compiled code in plain Python.
        entry: the functions to call, from all that the modules define.
    """

    modules: tuple[ModuleType, ...]
    no_equations: frozenset[str]
    stand_ins: Mapping[str, Callable[..., Any]]
    entry: Callable[[Mapping[str, Any]], Any]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the modules."""
        return tuple(module.__name__ for module in self.modules)


#: Quantities that serve Newton's gradient alone, and where they are computed.
STEERING = frozenset({"_locate", "place_at"})
ITERATION_CONTROL = frozenset({"gradient", "slope", "g"})

PROBE = "_probe"


@dataclass(frozen=True)
class Site:
    """One place where the source can be changed."""

    module: str
    statement: int  # of the module, a function as a rule
    function: str
    number: int  # among the sites of the statement
    line: int
    flip: str  # the mutated code

    def __str__(self) -> str:
        return f"{self.module.rsplit('.', 1)[-1]}.{self.function}, line {self.line}: {self.flip}"


class _Marker(ast.NodeTransformer):
    """Visits the sites of one statement in a fixed order; flips one of them, or wraps each term in a probe of its type."""

    def __init__(self, source: Source, flip: int | None = None, probe: int | None = None) -> None:
        """`flip`: the number of a site; `probe`: that of the statement."""
        self.source, self.flip, self.probe = source, flip, probe
        self.sites: list[tuple[str, int, str]] = []
        self.function = ""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        if self.function or node.name in self.source.no_equations:
            return node
        self.function = node.name
        node.body = [self.visit(statement) for statement in node.body]
        self.function = ""
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        return node  # indices

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        return node  # tolerances and switches

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if isinstance(node.func, ast.Name) and node.func.id == "range":
            return node
        if not (isinstance(node.func, ast.Attribute) and node.func.attr == "conjugate"):
            return self.generic_visit(node)
        value = self.visit(node.func.value)
        if self._site(node, value):
            return value
        return ast.Call(ast.Attribute(self._seen(value), "conjugate", ast.Load()), [], [])

    def visit_Assign(self, node: ast.Assign) -> ast.AST:
        if self._controls_iteration(node.targets[0]):
            return node
        node.value = self._term(node.value)
        return node

    def visit_Return(self, node: ast.Return) -> ast.AST:
        if node.value is not None:
            node.value = self._term(node.value)
        return node

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST:
        if self._controls_iteration(node.target):
            return node
        node.value = self.visit(node.value)
        if not isinstance(node.op, (ast.Add, ast.Sub)):
            return node
        flipped = ast.AugAssign(node.target, ast.Sub() if isinstance(node.op, ast.Add) else ast.Add(), node.value)
        if self._site(node, flipped):
            return flipped
        node.value = self._seen(node.value)
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        node.left, node.right = self.visit(node.left), self.visit(node.right)
        if isinstance(node.op, ast.Mult):
            quotient = ast.BinOp(node.left, ast.Div(), node.right)
            if self._site(node, quotient):
                return quotient
            node.right = self._seen(node.right)
        if not isinstance(node.op, (ast.Add, ast.Sub)):
            return node
        left_is_sum = isinstance(node.left, ast.BinOp) and isinstance(node.left.op, (ast.Add, ast.Sub))
        left_is_minus = isinstance(node.left, ast.UnaryOp)
        if not (left_is_sum or left_is_minus):
            flipped_left = ast.BinOp(ast.UnaryOp(ast.USub(), node.left), node.op, node.right)
            if self._site(node, flipped_left):
                return flipped_left
            node.left = self._seen(node.left)
        flipped = ast.BinOp(node.left, ast.Sub() if isinstance(node.op, ast.Add) else ast.Add(), node.right)
        if self._site(node, flipped):
            return flipped
        node.right = self._seen(node.right)
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if not isinstance(node.value, float) or not node.value:
            return node
        changed = ast.Constant(1.5 * node.value)
        if self._site(node, changed):
            return changed
        return self._seen(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        operand = self.visit(node.operand)
        if not isinstance(node.op, ast.USub):
            return ast.UnaryOp(node.op, operand)
        if self._site(node, operand):
            return operand
        return ast.UnaryOp(node.op, self._seen(operand))

    def _term(self, value: ast.expr) -> ast.expr:
        """An assigned or returned value; a tuple's elements each."""
        if isinstance(value, ast.Tuple):
            return ast.Tuple([self._term(element) for element in value.elts], value.ctx)
        product = isinstance(value, ast.BinOp) and isinstance(value.op, (ast.Mult, ast.Div))
        visited = self.visit(value)
        if product:
            flipped = ast.UnaryOp(ast.USub(), visited)
            if self._site(value, flipped):
                return flipped
            return self._seen(visited)
        return visited

    def _controls_iteration(self, target: ast.expr) -> bool:
        return self.function in STEERING and isinstance(target, ast.Name) and target.id in ITERATION_CONTROL

    def _site(self, node: ast.stmt | ast.expr, flipped: ast.AST) -> bool:
        """Record a site; whether it is the one to flip."""
        text = ast.unparse(flipped) if self.flip is self.probe is None else ""
        self.sites.append((self.function, node.lineno, text))
        return len(self.sites) - 1 == self.flip

    def _seen(self, value: Any) -> Any:
        """A term, in a probe of the last site if terms are probed."""
        if self.probe is None:
            return value
        place = [ast.Constant(self.probe), ast.Constant(len(self.sites) - 1)]
        return ast.Call(ast.Name(PROBE, ast.Load()), [*place, value], [])


def plain(value: Any, *_: Any) -> Any:
    """What stands for a decorator, or for the way from an address to what lies there."""
    return value


@cache
def _statements(name: str) -> tuple[str, ...]:
    """Source of each statement of a module at its line, without imports from the package."""
    text = inspect.getsource(sys.modules[name])
    lines, found = text.splitlines(), []
    for statement in ast.parse(text).body:
        if not (isinstance(statement, ast.ImportFrom) and (statement.module or "").startswith("quickreturn.reference_model")):
            first = min([statement.lineno, *(each.lineno for each in getattr(statement, "decorator_list", ()))]) - 1
            found.append("\n" * first + "\n".join(lines[first : statement.end_lineno]))
    return tuple(found)


def _compiled(text: str, marker: _Marker | None = None) -> CodeType:
    tree = ast.parse(text)
    return compile(ast.fix_missing_locations(marker.visit(tree)) if marker else tree, "mutant", "exec")


@cache
def _unchanged(name: str) -> tuple[CodeType, ...]:
    return tuple(_compiled(text) for text in _statements(name))


def _execute(source: Source, codes: Mapping[str, Sequence[CodeType]], probes: Mapping[str, Callable[..., Any]] | None = None) -> Any:
    """The modules as plain Python, one after the other; what they define replaces what the next ones would import."""
    defined: dict[str, Any] = dict(source.stand_ins)
    for name in source.names:
        imported = {key: getattr(value, "py_func", value) for key, value in vars(sys.modules[name]).items() if not key.startswith("__")}
        space = imported | defined | {"__name__": name}
        if probes:
            space[PROBE] = probes[name]
        for code in codes.get(name) or _unchanged(name):
            exec(code, space)
        defined |= {key: value for key, value in space.items() if isinstance(value, FunctionType) and value.__module__ == name}
    return source.entry(defined)


def original(source: Source) -> Any:
    """The unchanged source as plain Python."""
    return _execute(source, {})


def mutant(source: Source, site: Site) -> Any:
    """The source with one change."""
    codes = list(_unchanged(site.module))
    codes[site.statement] = _compiled(_statements(site.module)[site.statement], _Marker(source, flip=site.number))
    return _execute(source, {site.module: codes})


def sites(source: Source, exercise: Callable[[Any], object]) -> tuple[list[Site], list[Site]]:
    """All sites whose terms are floating-point numbers, and those that `exercise` never evaluates.

    Args:
        source: the equations.
        exercise: evaluates the equations it is given at states that reach every branch.
    """
    kinds: dict[tuple[str, int, int], type] = {}

    def probe(name: str) -> Callable[[int, int, Any], Any]:
        def note(statement: int, number: int, value: Any) -> Any:
            kinds[name, statement, number] = type(value)
            return value

        return note

    probed = {
        name: [_compiled(text, _Marker(source, probe=number)) for number, text in enumerate(_statements(name))] for name in source.names
    }
    exercise(_execute(source, probed, {name: probe(name) for name in source.names}))
    every = [(site, kinds.get((site.module, site.statement, site.number))) for site in _all_sites(source)]
    return [site for site, kind in every if kind not in (int, None)], [site for site, kind in every if kind is None]


def _all_sites(source: Source) -> Iterator[Site]:
    for name in source.names:
        for statement, text in enumerate(_statements(name)):
            marker = _Marker(source)
            marker.visit(ast.parse(text))
            for number, (function, line, flip) in enumerate(marker.sites):
                yield Site(name, statement, function, number, line, flip)


class Check(Protocol):
    """A state and what is known of it."""

    def difference(self, functions: Any) -> float:
        """How far the functions are from what is known, infinite where they cannot be evaluated."""


@dataclass(frozen=True)
class Hunt:
    """Equations, and checks of which every mutant must miss one.

    Attributes:
        source: the equations.
        checks: makes the checks.
        tolerance: within which they hold.
        equivalent: function and flip of mutants that change nothing, and why.
        least: number of signs that the equations have at least, or the search for them is broken.
    """

    source: Source
    checks: Callable[[], tuple[Check, ...]]
    tolerance: float
    equivalent: Mapping[tuple[str, str], str]
    least: int

    @cached_property
    def sites(self) -> tuple[list[Site], list[Site]]:
        """See `sites`."""
        return sites(self.source, self.exercise)

    def exercise(self, functions: Any) -> list[float]:
        """The differences of all checks."""
        return [check.difference(functions) for check in self.checks()]

    def survivors(self, tried: Sequence[Site]) -> list[str]:
        """Of the mutants of these sites those that no check notices."""
        return [
            str(site)
            for site in tried
            if (site.function, site.flip) not in self.equivalent
            and all(check.difference(mutated) <= self.tolerance for mutated in [mutant(self.source, site)] for check in self.checks())
        ]
