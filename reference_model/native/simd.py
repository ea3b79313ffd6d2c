"""Arithmetic on four points at once, for the integrals along the beam, which the compiler does not vectorise by itself.

In a row of numbers the four take one register; in a row of lanes they take four times as many numbers as there are lanes.
"""

from typing import Any, Final

import llvmlite.ir as ir
from numba import types
from numba.core.imputils import lower_cast
from numba.core.typeconv.castgraph import Conversion
from numba.extending import models, register_model

from quickreturn.reference_model.native.compilation import FAST
from quickreturn.reference_model.native.lanes import LANES
from quickreturn.reference_model.native.memory import LANES as COUNT
from quickreturn.reference_model.native.pointers import intrinsic

_INDEX: Final = ir.IntType(32)


class _Four(types.Type):
    """Four points: of numbers, or of lanes."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        self.vector = ir.VectorType(ir.DoubleType(), 4 * lanes)
        super().__init__(name=f"Four({lanes})")

    def unify(self, typingctx: Any, other: Any) -> Any:
        return OF_LANES if isinstance(other, _Four) else None

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        return Conversion.safe if self.lanes > 1 and isinstance(other, _Four) else None


@register_model(_Four)
class _FourModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: _Four) -> None:
        super().__init__(dmm, fe_type, fe_type.vector)  # type: ignore[no-untyped-call]


FOUR: Final = _Four(1)
OF_LANES: Final = _Four(COUNT)


def _arranged(builder: Any, value: Any, places: list[int]) -> Any:
    """The numbers of a register at these places."""
    order = ir.Constant(ir.VectorType(_INDEX, len(places)), places)
    return builder.shuffle_vector(value, ir.Constant(value.type, ir.Undefined), order)


def _spread(builder: Any, number: Any, four: _Four) -> Any:
    """Code that gives all four points the same number, or the same lanes."""
    if isinstance(number.type, ir.VectorType):
        return _arranged(builder, number, [*range(four.lanes)] * 4)
    vector = builder.insert_element(ir.Constant(ir.VectorType(ir.DoubleType(), 4), ir.Undefined), number, ir.Constant(_INDEX, 0))
    return _arranged(builder, vector, [0] * 4 * four.lanes)


@lower_cast(_Four, _Four)
def _to_lanes(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    """The same numbers in all lanes."""
    return value if source == target else _arranged(builder, value, [point for point in range(4) for _ in range(COUNT)])


def _four_of(*kinds: Any) -> _Four:
    """The type of the result for arguments of these types."""
    return OF_LANES if any(kind in (LANES, OF_LANES) for kind in kinds) else FOUR


def _place(context: Any, builder: Any, kind: Any, array: Any, index: Any, four: _Four) -> Any:
    """Pointer to the four points of a one-dimensional array that begin at an index."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), four.vector.as_pointer())


@intrinsic
def spread(typing: Any, number: Any) -> Any:
    """Four times the same number."""
    four = _four_of(number)

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _spread(builder, arguments[0], four)

    return four(number if number == LANES else types.float64), code


@intrinsic
def load(typing: Any, array: Any, index: Any) -> Any:
    """The numbers of an array at four points that begin at an index."""
    four = _four_of(array.dtype)

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array, index = arguments
        return builder.load(_place(context, builder, signature.args[0], array, index, four), align=8)

    return four(types.Array(array.dtype, 1, "C"), types.intp), code


@intrinsic
def store(typing: Any, array: Any, index: Any, four: Any) -> Any:
    """Write the numbers of four points into an array, beginning at an index."""
    kind = _four_of(array.dtype)

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array, index, four = arguments
        builder.store(four, _place(context, builder, signature.args[0], array, index, kind), align=8)
        return context.get_dummy_value()

    return types.void(types.Array(array.dtype, 1, "C"), types.intp, kind), code


@intrinsic
def plus(typing: Any, sums: Any, number: Any, four: Any) -> Any:
    """Sums + number times four."""
    kind = _four_of(sums, number, four)

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        product = builder.fmul(_spread(builder, arguments[1], kind), arguments[2], flags=FAST)
        return builder.fadd(arguments[0], product, flags=FAST)

    return kind(kind, number if number == LANES else types.float64, kind), code


@intrinsic
def plus_product(typing: Any, sums: Any, one: Any, other: Any) -> Any:
    """Sums + one times other, number by number."""
    kind = _four_of(sums, one, other)

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fadd(arguments[0], builder.fmul(arguments[1], arguments[2], flags=FAST), flags=FAST)

    return kind(*[kind] * 3), code


@intrinsic
def total(typing: Any, four: Any) -> Any:
    """The sum over the four points."""
    lanes = four.lanes

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        if lanes == 1:
            points = [builder.extract_element(arguments[0], ir.Constant(_INDEX, k)) for k in range(4)]
        else:
            points = [_arranged(builder, arguments[0], [*range(k * lanes, (k + 1) * lanes)]) for k in range(4)]
        return builder.fadd(builder.fadd(points[0], points[1]), builder.fadd(points[2], points[3]))

    return (types.float64 if lanes == 1 else LANES)(four), code


@intrinsic
def few_registers(typing: Any, array: Any) -> Any:
    """Whether four points of an array take one register, so that sums of twelve points fit into those that there are."""
    few = array.dtype != LANES

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return ir.Constant(ir.IntType(1), few)

    return types.boolean(array), code
