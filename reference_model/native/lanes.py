"""Several rows in one register: a number of each row, so that equations written for one row compute as many together.

A function compiled for numbers is compiled for `LANES` and `LANE_VECTORS` (vectors of the plane, as complex numbers) where it is called
with them. A comparison holds if it holds in every lane, so that code may branch where no lane decides otherwise: to refuse a state, for
instance. What a lane does alone, it does by `lane_of` and `with_lane`.
"""

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any, Final

import llvmlite.ir as ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_global, signature
from numba.extending import (
    infer_getattr,
    lower_getattr_generic,
    models,
    overload_method,
    register_model,
)

from quickreturn.reference_model.native.compilation import FAST
from quickreturn.reference_model.native.memory import LANES as COUNT
from quickreturn.reference_model.native.pointers import intrinsic

VECTOR: Final = ir.VectorType(ir.DoubleType(), COUNT)
_NUMBERS: Final = (types.Float, types.Integer)


class _Lanes(types.Type):
    """A number of each row."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes({COUNT})")

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        return Conversion.safe if isinstance(other, _NUMBERS) else None

    def unify(self, typingctx: Any, other: Any) -> Any:
        return self if isinstance(other, _NUMBERS) else None


class _LaneVectors(types.Type):
    """A vector of the plane, or a complex number, of each row."""

    def __init__(self) -> None:
        super().__init__(name=f"LaneVectors({COUNT})")

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        return Conversion.safe if isinstance(other, (_Lanes, types.Complex, *_NUMBERS)) else None

    def unify(self, typingctx: Any, other: Any) -> Any:
        return self if self.can_convert_from(typingctx, other) else None


LANES: Final = _Lanes()
LANE_VECTORS: Final = _LaneVectors()


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: _Lanes) -> None:
        super().__init__(dmm, fe_type, VECTOR)  # type: ignore[no-untyped-call]


@register_model(_LaneVectors)
class _LaneVectorsModel(models.StructModel):
    def __init__(self, dmm: Any, fe_type: _LaneVectors) -> None:
        super().__init__(dmm, fe_type, [("real", LANES), ("imag", LANES)])  # type: ignore[no-untyped-call]


def repeated(builder: Any, number: Any) -> Any:
    """The same number in all lanes."""
    first = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, ir.Constant(VECTOR, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), COUNT), [0] * COUNT))


def _vectors(context: Any, builder: Any, real: Any, imaginary: Any) -> Any:
    pair = cgutils.create_struct_proxy(LANE_VECTORS)(context, builder)
    pair.real, pair.imag = real, imaginary
    return pair._getvalue()


def _parts(context: Any, builder: Any, value: Any) -> tuple[Any, Any]:
    pair = cgutils.create_struct_proxy(LANE_VECTORS)(context, builder, value=value)
    return pair.real, pair.imag


@lower_cast(types.Float, LANES)
@lower_cast(types.Integer, LANES)
def _number_to_lanes(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    return repeated(builder, context.cast(builder, value, source, types.float64))


@lower_cast(types.Float, LANE_VECTORS)
@lower_cast(types.Integer, LANE_VECTORS)
@lower_cast(_Lanes, LANE_VECTORS)
def _real_to_vectors(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    return _vectors(context, builder, context.cast(builder, value, source, LANES), ir.Constant(VECTOR, [0.0] * COUNT))


@lower_cast(types.Complex, LANE_VECTORS)
def _complex_to_vectors(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    pair = context.make_complex(builder, source, value=value)
    return _vectors(context, builder, repeated(builder, pair.real), repeated(builder, pair.imag))


def _kind(*arguments: Any) -> Any:
    """The type of a sum or product; None without lanes, or with what is no number."""
    if not any(isinstance(each, (_Lanes, _LaneVectors)) for each in arguments):
        return None
    if not all(isinstance(each, (_Lanes, _LaneVectors, types.Complex, *_NUMBERS)) for each in arguments):
        return None
    return LANE_VECTORS if any(isinstance(each, (_LaneVectors, types.Complex)) for each in arguments) else LANES


def _typed(function: Any, rule: Callable[..., Any]) -> None:
    """Let `rule` give the signature of a function for types with lanes among them."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            return rule(*args) if not kws and _kind(*args) is not None else None

    infer_global(function)(Template)


def _same_kind(*arguments: Any) -> Any:
    return signature(*[_kind(*arguments)] * (1 + len(arguments)))


def _product(one: Any, other: Any) -> Any:
    """The factor of lanes alone stays what it is: a product of real numbers with a vector takes two multiplications, not four."""
    kinds = [LANES if isinstance(each, (_Lanes, *_NUMBERS)) else LANE_VECTORS for each in (one, other)]
    return signature(_kind(one, other), *kinds)


def _quotient(one: Any, other: Any) -> Any:
    return _product(one, other) if isinstance(other, (_Lanes, *_NUMBERS)) else None


def _square(base: Any, power: Any) -> Any:
    return signature(LANES, LANES, power) if isinstance(base, _Lanes) and getattr(power, "literal_value", None) == 2 else None


def _compared(one: Any, other: Any) -> Any:
    return signature(types.boolean, LANES, LANES) if _kind(one, other) == LANES else None


def _each(builder: Any, name: str, *values: Any) -> Any:
    """LLVM's own function of numbers, for each lane."""
    kind = ir.FunctionType(VECTOR, [VECTOR] * len(values))
    function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{COUNT}f64")
    return builder.call(function, values, fastmath=FAST)


def _arithmetic(instruction: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Code for a sum or difference of lanes, and of vectors."""

    def of_lanes(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return getattr(builder, instruction)(*arguments, flags=FAST)

    def of_vectors(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pairs = zip(*(_parts(context, builder, each) for each in arguments), strict=True)
        return _vectors(context, builder, *(getattr(builder, instruction)(*pair, flags=FAST) for pair in pairs))

    return of_lanes, of_vectors


def _by_a_number(instruction: str, *, first: bool) -> Callable[..., Any]:
    """Code for a vector times, or over, a number of each row; `first`: whether the vector is the first argument."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector, number = arguments if first else arguments[::-1]
        scaled = (getattr(builder, instruction)(part, number, flags=FAST) for part in _parts(context, builder, vector))
        return _vectors(context, builder, *scaled)

    return code


def _vector_product(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    (a, b), (c, d) = (_parts(context, builder, each) for each in arguments)

    def times(one: Any, other: Any) -> Any:
        return builder.fmul(one, other, flags=FAST)

    real = builder.fsub(times(a, c), times(b, d), flags=FAST)
    return _vectors(context, builder, real, builder.fadd(times(a, d), times(b, c), flags=FAST))


def _register_arithmetic() -> None:
    for both, instruction, rule in (
        ((operator.add, operator.iadd), "fadd", _same_kind),
        ((operator.sub, operator.isub), "fsub", _same_kind),
        ((operator.mul, operator.imul), "fmul", _product),
        ((operator.truediv, operator.itruediv), "fdiv", _quotient),
    ):
        of_lanes, of_vectors = _arithmetic(instruction)
        for function in both:
            _typed(function, rule)
            lower_builtin(function, LANES, LANES)(of_lanes)
            if rule is _same_kind:
                lower_builtin(function, LANE_VECTORS, LANE_VECTORS)(of_vectors)
            else:
                lower_builtin(function, LANE_VECTORS, LANES)(_by_a_number(instruction, first=True))
    for function in (operator.mul, operator.imul):
        lower_builtin(function, LANES, LANE_VECTORS)(_by_a_number("fmul", first=False))
        lower_builtin(function, LANE_VECTORS, LANE_VECTORS)(_vector_product)

    def negative(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fneg(arguments[0], flags=FAST)

    def negative_vector(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _vectors(context, builder, *(builder.fneg(part, flags=FAST) for part in _parts(context, builder, arguments[0])))

    _typed(operator.neg, _same_kind)
    lower_builtin(operator.neg, LANES)(negative)
    lower_builtin(operator.neg, LANE_VECTORS)(negative_vector)

    def square(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fmul(arguments[0], arguments[0], flags=FAST)

    for function in (operator.pow, operator.ipow):
        _typed(function, _square)
        lower_builtin(function, LANES, types.IntegerLiteral)(square)

    def of_each(name: str) -> Callable[..., Any]:
        return lambda context, builder, signature, arguments: _each(builder, name, *arguments)

    own: tuple[tuple[Any, str, int], ...] = (
        (math.sqrt, "sqrt", 1),
        (abs, "fabs", 1),
        (max, "maxnum", 2),
        (math.copysign, "copysign", 2),
    )
    for function, name, count in own:
        _typed(function, lambda *arguments: _same_kind(*arguments) if _kind(*arguments) == LANES else None)
        lower_builtin(function, *[LANES] * count)(of_each(name))

    def compare(symbol: str) -> Callable[..., Any]:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            held = builder.fcmp_ordered(symbol, *arguments)
            return builder.icmp_signed("==", builder.bitcast(held, ir.IntType(COUNT)), ir.Constant(ir.IntType(COUNT), -1))

        return code

    comparisons: Mapping[Any, str] = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">="}
    for function, symbol in comparisons.items():
        _typed(function, _compared)
        lower_builtin(function, LANES, LANES)(compare(symbol))

    def vector_of(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _vectors(context, builder, *arguments)

    _typed(complex, lambda *parts: signature(LANE_VECTORS, LANES, LANES) if len(parts) == 2 and _kind(*parts) == LANES else None)
    lower_builtin(complex, LANES, LANES)(vector_of)


_register_arithmetic()


@infer_getattr
class _LaneVectorsAttributes(AttributeTemplate):
    key = _LaneVectors

    def generic_resolve(self, vectors: _LaneVectors, name: str) -> Any:  # type: ignore[override]
        return LANES if name in ("real", "imag") else None


@lower_getattr_generic(_LaneVectors)
def _part(context: Any, builder: Any, kind: _LaneVectors, value: Any, name: str) -> Any:
    return _parts(context, builder, value)[("real", "imag").index(name)]


@overload_method(_LaneVectors, "conjugate", inline="always")
def _conjugate(vectors: Any) -> Any:
    def conjugate(vectors: Any) -> Any:
        return complex(vectors.real, -vectors.imag)

    return conjugate


@intrinsic
def lanes_of(typing: Any, number: Any) -> Any:
    """How many lanes there are: 1 for a number."""
    count = COUNT if isinstance(number, _Lanes) else 1
    return types.intp(number), lambda context, *_: context.get_constant(types.intp, count)


@intrinsic
def zeros_like(typing: Any, number: Any) -> Any:
    """As many zeros as there are lanes."""
    kind = LANES if isinstance(number, _Lanes) else types.float64
    return kind(number), lambda context, builder, *_: ir.Constant(context.get_value_type(kind), [0.0] * COUNT if kind == LANES else 0.0)


@intrinsic
def lane_of(typing: Any, number: Any, lane: Any) -> Any:
    """The number of a lane."""
    if not isinstance(number, _Lanes):
        return types.float64(types.float64, types.intp), lambda context, builder, signature, arguments: arguments[0]
    return types.float64(LANES, types.intp), lambda context, builder, signature, arguments: builder.extract_element(*arguments)


@intrinsic
def with_lane(typing: Any, numbers: Any, lane: Any, number: Any) -> Any:
    """The numbers of all lanes, but in one lane another number."""
    if not isinstance(numbers, _Lanes):
        return types.float64(types.float64, types.intp, types.float64), lambda context, builder, signature, arguments: arguments[2]

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        numbers, lane, number = arguments
        return builder.insert_element(numbers, number, lane)

    return LANES(LANES, types.intp, types.float64), code


@intrinsic
def where_within(typing: Any, x: Any, low: Any, high: Any, inside: Any, outside: Any) -> Any:
    """`inside` in lanes where low < x <= high, elsewhere `outside`."""
    vector = any(isinstance(each, _Lanes) for each in (x, low, high, inside, outside))

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        x, low, high, inside, outside = arguments
        here = builder.and_(builder.fcmp_ordered(">", x, low), builder.fcmp_ordered("<=", x, high))
        return builder.select(here, inside, outside)

    kind = LANES if vector else types.float64
    return kind(*[kind] * 5), code
