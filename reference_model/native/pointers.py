"""Passes tuples of constants and arrays, and compiled functions, to compiled code by their address.

Numba passes a tuple member by member, some two hundred numbers for the models here, and compiles a callee again into every caller. The
equations of motion therefore receive parameters and workspace by address, and their callers have the address of the equations, which are
compiled only once.
"""

import functools
import sys
from typing import Any, Final

import llvmlite.ir as ir
import numba
import numpy as np
from numba import extending, types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, lower_getattr_generic, models, register_model

from quickreturn.reference_model.native.memory import KINDS, annotations_of

intrinsic: Any = extending.intrinsic  # its type hints count the compiler's own argument

_NUMBERS: Final = {float: types.float64, int: types.int64, bool: types.boolean, complex: types.complex128}
#: Annotation of a tuple's member -> its compiled type.
MEMBERS: Final[dict[str, Any]] = {
    name: types.Array(_NUMBERS[kind], dimensions, "C") if dimensions else _NUMBERS[kind] for name, (dimensions, kind) in KINDS.items()
}


def _tuple_type(named_tuple: Any, **records: np.dtype[Any]) -> Any:
    """The compiled type of a `NamedTuple` class."""
    kinds: dict[str, Any] = {name: numba.from_dtype(record) for name, record in records.items()}
    for name, annotation in annotations_of(named_tuple).items():
        if name not in records:
            kinds[name] = MEMBERS.get(annotation) or _tuple_type(vars(sys.modules[named_tuple.__module__])[annotation])
    return types.NamedTuple([kinds[name] for name in named_tuple._fields], named_tuple)


class At(types.Type):
    """The place of a tuple in memory; its members are read as attributes, and never change while compiled code reads them."""

    def __init__(self, pointee: Any) -> None:
        self.pointee = pointee
        super().__init__(name=f"At({pointee.name})")


register_model(At)(models.OpaqueModel)


@infer_getattr
class _AtAttributes(AttributeTemplate):
    key = At

    def generic_resolve(self, at: At, name: str) -> Any:  # type: ignore[override]
        if name not in at.pointee.fields:
            return None
        member = at.pointee.types[at.pointee.fields.index(name)]
        return At(member) if isinstance(member, types.BaseNamedTuple) else member


def _words(kind: Any) -> int:
    """Words of eight bytes for a member: an array takes its address and its shape, a record its address, a tuple what its members take."""
    if isinstance(kind, types.NamedTuple):
        return sum(map(_words, kind.types))
    return 1 + kind.ndim if isinstance(kind, types.Array) else 1


@lower_getattr_generic(At)
def _load_member(context: Any, builder: Any, at: At, address: Any, name: str) -> Any:
    """Code that loads a member word by word; the compiler may assume that no word changes."""
    index = at.pointee.fields.index(name)
    kind, first = at.pointee.types[index], sum(map(_words, at.pointee.types[:index]))

    def place(word: int) -> Any:
        return builder.gep(address, [ir.Constant(ir.IntType(64), 8 * word)], inbounds=True)

    def load(word: int, kind: Any) -> Any:
        loaded = builder.load(builder.bitcast(place(word), kind.as_pointer()))
        loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
        return loaded

    if isinstance(kind, types.BaseNamedTuple):
        return place(first)
    if kind == types.boolean:
        return builder.trunc(load(first, ir.IntType(64)), ir.IntType(1))
    if not isinstance(kind, types.Array):
        return load(first, context.get_value_type(kind))
    word = context.get_value_type(types.intp)
    shape = [load(first + 1 + axis, word) for axis in range(kind.ndim)]
    return _array(context, builder, kind, load(first, context.get_data_type(kind.dtype).as_pointer()), shape)


def _array(context: Any, builder: Any, kind: Any, data: Any, shape: list[Any]) -> Any:
    """An array of Python's memory: compiled code has no part in counting its references."""
    array = context.make_array(kind)(context, builder)
    strides = [context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))]
    for size in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], size))
    array.data, array.itemsize, array.nitems = data, strides[-1], functools.reduce(builder.mul, shape)
    array.shape, array.strides = cgutils.pack_array(builder, shape), cgutils.pack_array(builder, strides)
    return array._getvalue()


def array_of(context: Any, builder: Any, kind: Any, address: Any, shape: list[Any]) -> Any:
    """The array of a shape that begins at an address (an integer)."""
    return _array(context, builder, kind, builder.inttoptr(address, context.get_data_type(kind.dtype).as_pointer()), shape)


def reader(named_tuple: Any, **records: np.dtype[Any]) -> Any:
    """A compiled function that takes the address (an integer) of a tuple, and returns an `At` to read its members from.

    Args:
        named_tuple: its class, whose members are annotated with a name of `KINDS`, or with a class like it.
        records: types of members that are records, by the member's name.
    """
    pointee = _tuple_type(named_tuple, **records)

    @intrinsic
    def at(typing: Any, address: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], ir.IntType(8).as_pointer())

        return At(pointee)(types.uintp), code

    return at


def array_at(content: Any, dimensions: int = 1) -> Any:
    """A compiled function from an address and a shape to the array, of one or two dimensions, that is there."""
    kind = types.Array(content, dimensions, "C")

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return array_of(context, builder, kind, arguments[0], list(arguments[1:]))

    if dimensions == 1:
        return intrinsic(lambda typing, address, size: (kind(types.uintp, types.intp), code))
    return intrinsic(lambda typing, address, rows, columns: (kind(types.uintp, types.intp, types.intp), code))


numbers_at, matrix_at = array_at(types.float64), array_at(types.float64, 2)


@intrinsic
def call_equations(typing: Any, function: Any, parameters: Any, workspace: Any, state: Any, rate: Any) -> Any:
    """Call the equations of motion (`motion.equations.kernel`); all arguments are addresses."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = context.get_value_type(types.uintp)
        kind = ir.FunctionType(context.get_value_type(types.int64), [word] * 4)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.int64(*[types.uintp] * 5), code
