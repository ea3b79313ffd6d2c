"""Tuples of constants and arrays by their address, and compiled functions too.

Numba hands a tuple over member by member, some two hundred numbers for the models here, and makes a callee's machine code part of every
caller's, to be optimised there again. The equations of motion therefore know parameters and workspace by address alone, and their
callers know the equations by address: they are compiled once, whoever calls them.
"""

import math
from typing import Any, Final

import llvmlite.ir as ir
import numba
import numpy as np
from numba import extending, types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, lower_getattr_generic, models, register_model
from numba.np.arrayobj import make_array, populate_array
from numpy.typing import NDArray

from quickreturn.reference_model.machine.compilation import compiled

Array = NDArray[np.float64]

intrinsic: Any = extending.intrinsic  # its type hints count the compiler's own argument

#: What a member of a tuple may be annotated with, and its compiled type.
MEMBERS: Final[dict[str, Any]] = {
    "float": types.float64,
    "int": types.int64,
    "bool": types.boolean,
    "Vector": types.Array(types.float64, 1, "C"),
    "ComplexVector": types.Array(types.complex128, 1, "C"),
    "Matrix": types.Array(types.float64, 2, "C"),
    "Cube": types.Array(types.float64, 3, "C"),
}

#: Arrays by their number of dimensions, C-contiguous: the names that `MEMBERS` knows.
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


@lower_getattr_generic(At)
def _load_member(context: Any, builder: Any, at: At, address: Any, name: str) -> Any:
    """Load a member, number by number, each as one that does not change."""
    pointee = context.get_value_type(at.pointee)
    index = at.pointee.fields.index(name)
    tuple_pointer = builder.bitcast(address, pointee.as_pointer())

    def load(place: Any, kind: Any) -> Any:
        if isinstance(kind, ir.BaseStructType | ir.ArrayType):
            members = kind.elements if isinstance(kind, ir.BaseStructType) else [kind.element] * kind.count
            whole = ir.Constant(kind, ir.Undefined)
            for position, member in enumerate(members):
                part = load(cgutils.gep_inbounds(builder, place, 0, position), member)
                whole = builder.insert_value(whole, part, position)
            return whole
        loaded = builder.load(place)
        loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
        return loaded

    member = cgutils.gep_inbounds(builder, tuple_pointer, 0, index)
    if isinstance(at.pointee.types[index], types.BaseNamedTuple):
        return builder.bitcast(member, ir.IntType(8).as_pointer())
    found = load(member, pointee.elements[index])
    if isinstance(at.pointee.types[index], types.Array):  # Python owns it: compiled code has no part in counting its references
        for owner in (0, 1):
            found = builder.insert_value(found, cgutils.get_null_value(pointee.elements[index].elements[owner]), owner)
    return found


def reader(pointee: types.NamedTuple) -> Any:
    """A compiled function from the address (an integer) of a tuple of this type to what its members are read from."""

    @intrinsic
    def at(typing: Any, address: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], ir.IntType(8).as_pointer())

        return At(pointee)(types.uintp), code

    return at


@intrinsic
def store_tuple(typing: Any, value: Any, address: Any) -> Any:
    """Lay a tuple down at an address."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = context.get_value_type(signature.args[0])
        builder.store(arguments[0], builder.inttoptr(arguments[1], kind.as_pointer()))
        return context.get_dummy_value()

    return types.void(value, types.uintp), code


@intrinsic
def size_of_tuple(typing: Any, value: Any) -> Any:
    """Bytes that `store_tuple` writes."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.get_constant(types.intp, context.get_abi_sizeof(context.get_value_type(signature.args[0])))

    return types.intp(value), code


@intrinsic
def numbers_at(typing: Any, address: Any, size: Any) -> Any:
    """The `size` numbers at an address, as an array."""
    kind = MEMBERS["Vector"]

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = make_array(kind)(context, builder)
        width = context.get_constant(types.intp, 8)
        data = builder.inttoptr(arguments[0], array.data.type)
        populate_array(array, data=data, shape=[arguments[1]], strides=[width], itemsize=width, meminfo=None)
        return array._getvalue()

    return kind(types.uintp, types.intp), code


@intrinsic
def call_equations(typing: Any, function: Any, parameters: Any, workspace: Any, state: Any, rate: Any, row: Any) -> Any:
    """Call the equations of motion (`equations.kernel`), with all arguments by address; a `row` of 0 asks for no observables."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = context.get_value_type(types.uintp)
        kind = ir.FunctionType(context.get_value_type(types.int64), [word] * 5)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.int64(*[types.uintp] * 6), code


@compiled
def _size(value: Any) -> int:
    return size_of_tuple(value)


@compiled
def _store(value: Any, address: int) -> None:
    store_tuple(value, address)


def on_lines(shape: tuple[int, ...]) -> Array:
    """Zeros that begin with a line (64 bytes) of the memory's cache: four numbers of one register then lie in one line.

    Elsewhere half of all fours lie across two, which costs integrals a third to a half of their time.
    """
    memory = np.zeros(math.prod(shape) + 7)
    first = -memory.ctypes.data % 64 // 8
    return memory[first : first + math.prod(shape)].reshape(shape)


class Placed:
    """A tuple of constants and arrays where compiled code finds it; its arrays stay alive with it.

    Args:
        value: the tuple.
        kind: its compiled type.

    Attributes:
        address: of its members in memory.

    Raises:
        TypeError: a member is not what its annotation says.
    """

    def __init__(self, value: Any, kind: types.NamedTuple) -> None:
        found = numba.typeof(value)
        if found != kind:  # compiled code would read numbers that are not there
            wrong = [name for name, a, b in zip(value._fields, found.types, kind.types, strict=True) if a != b]
            raise TypeError(f"not as annotated: {', '.join(wrong)} of {type(value).__name__}")
        self.value = value
        self._memory = np.empty(_size(value) + 64, dtype=np.uint8)
        self.address = int(self._memory.ctypes.data + 63) // 64 * 64
        _store(value, self.address)
