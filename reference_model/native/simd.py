"""Arithmetic on four numbers in one register, for the integrals along the beam, which the compiler does not vectorise by itself."""

from typing import Any

import llvmlite.ir as ir
from numba import types
from numba.extending import models, register_model

from quickreturn.reference_model.native.pointers import MEMBERS, intrinsic

_VECTOR = ir.VectorType(ir.DoubleType(), 4)
_FAST = ("reassoc", "contract", "nsz", "arcp")


class _Four(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Four")


FOUR = _Four()


@register_model(_Four)
class _FourModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: _Four) -> None:
        super().__init__(dmm, fe_type, _VECTOR)  # type: ignore[no-untyped-call]


def _place(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    """Pointer to the four numbers of a one-dimensional array that begin at an index."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _VECTOR.as_pointer())


def _spread(builder: Any, number: Any) -> Any:
    """Code that puts one number into all four places of a register."""
    vector = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(vector, ir.Constant(_VECTOR, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), 4), [0] * 4))


@intrinsic
def spread(typing: Any, number: Any) -> Any:
    """Four times the same number."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _spread(builder, arguments[0])

    return FOUR(types.float64), code


@intrinsic
def load(typing: Any, array: Any, index: Any) -> Any:
    """The four numbers of an array that begin at an index."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_place(context, builder, signature.args[0], *arguments), align=8)

    return FOUR(MEMBERS["Vector"], types.intp), code


@intrinsic
def store(typing: Any, array: Any, index: Any, four: Any) -> Any:
    """Write four numbers into an array, beginning at an index."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[2], _place(context, builder, signature.args[0], *arguments[:2]), align=8)
        return context.get_dummy_value()

    return types.void(MEMBERS["Vector"], types.intp, FOUR), code


@intrinsic
def plus(typing: Any, sums: Any, number: Any, four: Any) -> Any:
    """Sums + number times four."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        product = builder.fmul(_spread(builder, arguments[1]), arguments[2], flags=_FAST)
        return builder.fadd(arguments[0], product, flags=_FAST)

    return FOUR(FOUR, types.float64, FOUR), code


@intrinsic
def plus_product(typing: Any, sums: Any, one: Any, other: Any) -> Any:
    """Sums + one times other, number by number."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fadd(arguments[0], builder.fmul(arguments[1], arguments[2], flags=_FAST), flags=_FAST)

    return FOUR(FOUR, FOUR, FOUR), code


@intrinsic
def total(typing: Any, four: Any) -> Any:
    """The sum of four numbers."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        numbers = [builder.extract_element(arguments[0], ir.Constant(ir.IntType(32), k)) for k in range(4)]
        return builder.fadd(builder.fadd(numbers[0], numbers[1]), builder.fadd(numbers[2], numbers[3]))

    return types.float64(FOUR), code
