"""Rows of a table that is piecewise cubic, one for all lanes or another one for each."""

from typing import Any

import llvmlite.ir as ir
from numba import types
from numba.core import cgutils

from quickreturn.reference_model.native.compilation import FAST
from quickreturn.reference_model.native.lanes import LANES, VECTOR, repeated
from quickreturn.reference_model.native.memory import LANES as COUNT
from quickreturn.reference_model.native.pointers import intrinsic


def _transposed(builder: Any, rows: list[Any]) -> list[Any]:
    """The columns of as many rows as each has numbers. In each round, rows that are `apart` exchange every other group of that size."""
    apart = 1
    while apart < COUNT:
        own = [place for place in range(COUNT) if not place & apart]
        exchanged = list(rows)
        for low in own:
            one, other = rows[low], rows[low + apart]
            keep = [place if not place & apart else COUNT + place - apart for place in range(COUNT)]
            take = [place + apart if not place & apart else COUNT + place for place in range(COUNT)]
            for row, places in ((low, keep), (low + apart, take)):
                order = ir.Constant(ir.VectorType(ir.IntType(32), COUNT), places)
                exchanged[row] = builder.shuffle_vector(one, other, order)
        rows, apart = exchanged, 2 * apart
    return rows


@intrinsic
def write_cubics(typing: Any, coefficients: Any, interval: Any, offset: Any, row: Any) -> Any:
    """To `row`, whose length is a multiple of the lanes: ((c_0 offset + c_1) offset + c_2) offset + c_3 for each of its numbers.

    Args:
        typing: of the compiler.
        coefficients: c, shape (intervals, 4, numbers of a row).
        interval: whose coefficients count; another one in each lane.
        offset: from where the interval begins.
        row: of numbers, or of lanes.
    """
    lanes = COUNT if row.dtype == LANES else 1
    kind = LANES if lanes > 1 else types.float64

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word, number = ir.IntType(64), ir.DoubleType()
        tables, rows = context.make_array(signature.args[0])(context, builder, arguments[0]), context.make_array(signature.args[3])
        size = builder.extract_value(tables.shape, 2)
        written = builder.bitcast(rows(context, builder, arguments[3]).data, number.as_pointer())

        def of_lane(value: Any, lane: int) -> Any:
            return builder.extract_element(value, ir.Constant(ir.IntType(32), lane)) if lanes > 1 else value

        intervals = [builder.fptosi(of_lane(arguments[1], lane), word) for lane in range(lanes)]
        offsets = [repeated(builder, of_lane(arguments[2], lane)) for lane in range(lanes)]
        begins = [builder.gep(tables.data, [builder.mul(builder.mul(each, ir.Constant(word, 4)), size)]) for each in intervals]
        with cgutils.for_range_slice(builder, ir.Constant(word, 0), size, ir.Constant(word, COUNT), word) as (first, _):

            def load(begin: Any, power: int) -> Any:
                place = builder.add(builder.mul(ir.Constant(word, power), size), first)
                return builder.load(builder.bitcast(builder.gep(begin, [place]), VECTOR.as_pointer()), align=8)

            values = []
            for begin, away in zip(begins, offsets, strict=True):
                value = load(begin, 0)
                for power in range(1, 4):
                    value = builder.fadd(builder.fmul(value, away, flags=FAST), load(begin, power), flags=FAST)
                values.append(value)
            for place, value in enumerate(_transposed(builder, values) if lanes > 1 else values):
                here = builder.mul(builder.add(first, ir.Constant(word, place)), ir.Constant(word, lanes))
                builder.store(value, builder.bitcast(builder.gep(written, [here]), VECTOR.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(types.Array(types.float64, 3, "C"), kind, kind, types.Array(row.dtype, 1, "C")), code
