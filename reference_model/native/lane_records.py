"""Records and arrays in memory whose numbers are of each row, see `lanes`."""

import math
from typing import Any, Final

import llvmlite.ir as ir
import numpy as np
from numba import types
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, lower_getattr_generic, lower_setattr_generic, models, register_model

from quickreturn.reference_model.native.lanes import LANE_VECTORS, LANES
from quickreturn.reference_model.native.memory import LANES as COUNT
from quickreturn.reference_model.native.pointers import array_of, intrinsic


class LaneRecord(types.Type):
    """A record in memory whose numbers are of each row. An array in it is read as an array; whole numbers are those of all rows.

    Args:
        record: its numpy type for one row.
    """

    def __init__(self, record: np.dtype[Any]) -> None:
        self.places: dict[str, tuple[int, Any, int]] = {}  # name -> first word, type, length of an array (0 for none)
        words = 0
        for name in record.names or ():
            kinds = {"f": LANES, "c": LANE_VECTORS, "i": types.int64}
            length = math.prod(record[name].shape) if record[name].shape else 0
            self.places[name] = words, kinds[record[name].base.kind], length
            words += COUNT * record[name].itemsize // 8
        self.words = words
        super().__init__(name=f"LaneRecord({COUNT}, {record.descr})")


@register_model(LaneRecord)
class _LaneRecordModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: LaneRecord) -> None:
        super().__init__(dmm, fe_type, ir.IntType(8).as_pointer())  # type: ignore[no-untyped-call]


@infer_getattr
class _LaneRecordAttributes(AttributeTemplate):
    key = LaneRecord

    def generic_resolve(self, record: LaneRecord, name: str) -> Any:  # type: ignore[override]
        if name not in record.places:
            return None
        _, kind, length = record.places[name]
        return types.Array(kind, 1, "C") if length else kind


def _place(builder: Any, record: LaneRecord, address: Any, name: str) -> Any:
    return builder.gep(address, [ir.Constant(ir.IntType(64), 8 * record.places[name][0])], inbounds=True)


@lower_getattr_generic(LaneRecord)
def _read(context: Any, builder: Any, record: LaneRecord, address: Any, name: str) -> Any:
    _, kind, length = record.places[name]
    place = _place(builder, record, address, name)
    if length:
        number = builder.ptrtoint(place, ir.IntType(64))
        return array_of(context, builder, types.Array(kind, 1, "C"), number, [context.get_constant(types.intp, length)])
    return context.unpack_value(builder, kind, builder.bitcast(place, context.get_data_type(kind).as_pointer()))


@lower_setattr_generic(LaneRecord)
def _write(context: Any, builder: Any, sig: Any, arguments: Any, name: str) -> None:
    record = sig.args[0]
    kind = record.places[name][1]
    place = _place(builder, record, arguments[0], name)
    value = context.cast(builder, arguments[1], sig.args[1], kind)
    context.pack_value(builder, kind, value, builder.bitcast(place, context.get_data_type(kind).as_pointer()))


def record_at(record: LaneRecord) -> Any:
    """A compiled function from an address to the record there."""

    @intrinsic
    def at(typing: Any, address: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], ir.IntType(8).as_pointer())

        return record(types.uintp), code

    return at


#: Annotation of a tuple's member -> its compiled type, see `pointers.MEMBERS`.
MEMBERS_IN_LANES: Final[dict[str, Any]] = {
    "Vector": types.Array(LANES, 1, "C"),
    "ComplexVector": types.Array(LANE_VECTORS, 1, "C"),
    "Matrix": types.Array(LANES, 2, "C"),
}
