"""Passes tuples of constants and arrays, and compiled functions, to compiled code by their address.

Numba passes a tuple member by member, some two hundred numbers for the models here, and compiles a callee again into every caller. The
equations of motion therefore receive parameters and workspace by address, and their callers have the address of the equations, which are
compiled only once.
"""

import math
from typing import Any, Final

import llvmlite.ir as ir
import numpy as np
from numba import extending, types
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, lower_getattr_generic, models, register_model
from numba.np.arrayobj import make_array, populate_array
from numba.np.numpy_support import as_dtype
from numpy.typing import NDArray

Array = NDArray[np.float64]

intrinsic: Any = extending.intrinsic  # its type hints count the compiler's own argument

#: Annotation of a tuple's member -> its compiled type.
MEMBERS: Final[dict[str, Any]] = {
    "float": types.float64,
    "int": types.int64,
    "bool": types.boolean,
    "Vector": types.Array(types.float64, 1, "C"),
    "ComplexVector": types.Array(types.complex128, 1, "C"),
    "Matrix": types.Array(types.float64, 2, "C"),
    "Cube": types.Array(types.float64, 3, "C"),
}

#: Names of `MEMBERS` for C-contiguous arrays of one, two and three dimensions.
Vector = NDArray[np.float64]
ComplexVector = NDArray[np.complex128]
Matrix = NDArray[np.float64]
Cube = NDArray[np.float64]


def tuple_type(named_tuple: Any, **nested: types.Type) -> types.NamedTuple:
    """The compiled type of a `NamedTuple` class.

    Args:
        named_tuple: members are annotated, as text, with names of `MEMBERS`.
        nested: types of members that are tuples or records themselves, by the member's name.
    """
    annotations = {name: getattr(text, "__forward_arg__", text) for name, text in named_tuple.__annotations__.items()}
    return types.NamedTuple([nested.get(name) or MEMBERS[annotations[name]] for name in named_tuple._fields], named_tuple)


class At(types.Type):
    """The place of a tuple in memory; its members are read as attributes, and never change while compiled code reads them."""

    def __init__(self, pointee: types.BaseNamedTuple) -> None:
        self.pointee: Any = pointee
        super().__init__(name=f"At({pointee.name})")


@register_model(At)
class _AtModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: At) -> None:
        super().__init__(dmm, fe_type, ir.IntType(8).as_pointer())  # type: ignore[no-untyped-call]


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
    array = make_array(kind)(context, builder)  # Python owns it: compiled code has no part in counting its references
    word = context.get_value_type(types.intp)
    shape = [load(first + 1 + axis, word) for axis in range(kind.ndim)]
    strides = [context.get_constant(types.intp, kind.dtype.bitwidth // 8)]
    for size in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], size))
    populate_array(array, data=load(first, array.data.type), shape=shape, strides=strides, itemsize=strides[-1], meminfo=None)
    return array._getvalue()


def reader(pointee: types.NamedTuple) -> Any:
    """A compiled function that takes the address (an integer) of a tuple of this type, and returns an `At` to read its members from."""

    @intrinsic
    def at(typing: Any, address: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], ir.IntType(8).as_pointer())

        return At(pointee)(types.uintp), code

    return at


@intrinsic
def numbers_at(typing: Any, address: Any, size: Any) -> Any:
    """The `size` numbers at an address, as an array without a copy."""
    kind = MEMBERS["Vector"]

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = make_array(kind)(context, builder)
        width = context.get_constant(types.intp, 8)
        data = builder.inttoptr(arguments[0], array.data.type)
        populate_array(array, data=data, shape=[arguments[1]], strides=[width], itemsize=width, meminfo=None)
        return array._getvalue()

    return kind(types.uintp, types.intp), code


@intrinsic
def call_equations(typing: Any, function: Any, parameters: Any, workspace: Any, state: Any, rate: Any, with_forces: Any) -> Any:
    """Call the equations of motion (`motion.equations.kernel`); all but `with_forces` are addresses."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = context.get_value_type(types.uintp)
        kind = ir.FunctionType(context.get_value_type(types.int64), [word] * 5)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.int64(*[types.uintp] * 6), code


def on_lines(shape: tuple[int, ...]) -> Array:
    """An array of zeros that begins at a cache line (64 bytes), so that the four numbers of one register lie in one line.

    Otherwise half of all groups of four lie across two lines, which costs the integrals a third to a half of their time.
    """
    memory = np.zeros(math.prod(shape) + 7)
    first = -memory.ctypes.data % 64 // 8
    return memory[first : first + math.prod(shape)].reshape(shape)


class Placed:
    """A tuple of constants and arrays laid out in memory for compiled code; the object keeps the arrays alive.

    Args:
        value: the tuple.
        kind: its compiled type.

    Attributes:
        address: of its memory.

    Raises:
        TypeError: a member is not what its annotation says.
    """

    def __init__(self, value: Any, kind: types.NamedTuple) -> None:
        self.value = value
        self._memory = on_lines((_words(kind),))
        self.address = int(self._memory.ctypes.data)
        _lay(value, kind, self._memory)


def _lay(value: Any, kind: Any, words: Array) -> None:
    """Write the members of a tuple into its words."""
    if value._fields != kind.fields:
        raise TypeError(f"{type(value).__name__} has not the members of {kind.name}")
    whole, first = words.view(np.int64), 0
    for name, member, expected in zip(value._fields, value, kind.types, strict=True):
        last = first + _words(expected)
        if isinstance(expected, types.BaseNamedTuple):
            _lay(member, expected, words[first:last])
        elif not _is(member, expected):  # compiled code would read numbers that are not there
            raise TypeError(f"not as annotated: {name} of {type(value).__name__}")
        elif isinstance(expected, types.Array):
            whole[first:last] = member.ctypes.data, *member.shape
        elif isinstance(expected, types.Record):
            whole[first] = member.__array_interface__["data"][0]
        else:
            (words if expected == types.float64 else whole)[first] = member
        first = last


def _is(member: Any, kind: Any) -> bool:
    """Whether a member is of its compiled type."""
    if isinstance(kind, types.Array):
        if not isinstance(member, np.ndarray):
            return False
        return member.flags.carray and member.ndim == kind.ndim and member.dtype == as_dtype(kind.dtype)
    if isinstance(kind, types.Record):
        return isinstance(member, np.record) and member.dtype == as_dtype(kind)
    return isinstance(member, {types.float64: float, types.int64: int, types.boolean: bool}[kind])
