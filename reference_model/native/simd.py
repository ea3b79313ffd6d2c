"""Arithmetic on four numbers in one register, for the integrals along the beam, which the compiler does not vectorise by itself."""

from typing import Any, Final

import llvmlite.ir as ir
from numba import types
from numba.extending import models, register_model

from quickreturn.reference_model.native.compilation import FAST
from quickreturn.reference_model.native.pointers import intrinsic

_VECTOR: Final = ir.VectorType(ir.DoubleType(), 4)
_INDEX: Final = ir.IntType(32)
_NUMBERS: Final = types.Array(types.float64, 1, "C")


class _Four(types.Type):
    """Four numbers."""

    def __init__(self) -> None:
        super().__init__(name="Four")


FOUR: Final = _Four()


@register_model(_Four)
class _FourModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: _Four) -> None:
        super().__init__(dmm, fe_type, _VECTOR)  # type: ignore[no-untyped-call]


def _spread(builder: Any, number: Any) -> Any:
    undefined = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(undefined, number, ir.Constant(_INDEX, 0))
    return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(_INDEX, 4), [0] * 4))


def _place(context: Any, builder: Any, array: Any, index: Any) -> Any:
    data = context.make_array(_NUMBERS)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _VECTOR.as_pointer())


@intrinsic
def spread(typing: Any, number: Any) -> Any:
    """Four times the same number."""
    return FOUR(types.float64), lambda context, builder, signature, arguments: _spread(builder, arguments[0])


@intrinsic
def load(typing: Any, array: Any, index: Any) -> Any:
    """The four numbers of an array that begin at an index."""
    return FOUR(_NUMBERS, types.intp), lambda context, builder, signature, arguments: builder.load(
        _place(context, builder, *arguments), align=8
    )


@intrinsic
def store(typing: Any, array: Any, index: Any, four: Any) -> Any:
    """Write four numbers into an array, beginning at an index."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[2], _place(context, builder, *arguments[:2]), align=8)
        return context.get_dummy_value()

    return types.void(_NUMBERS, types.intp, FOUR), code


@intrinsic
def plus(typing: Any, sums: Any, one: Any, other: Any) -> Any:
    """Sums + one times other, number by number; `one` may be a single number."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        factor = arguments[1] if one == FOUR else _spread(builder, arguments[1])
        return builder.fadd(arguments[0], builder.fmul(factor, arguments[2], flags=FAST), flags=FAST)

    return FOUR(FOUR, FOUR if one == FOUR else types.float64, FOUR), code


@intrinsic
def total(typing: Any, four: Any) -> Any:
    """The sum of the four."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        a, b, c, d = (builder.extract_element(arguments[0], ir.Constant(_INDEX, k)) for k in range(4))
        return builder.fadd(builder.fadd(a, b), builder.fadd(c, d))

    return types.float64(FOUR), code
