"""The type by which compiled code knows a `State`, and how it finds the parts of one by address."""

from typing import Any, Final

import llvmlite.ir as ir
import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, lower_getattr_generic, models, register_model
from numpy.typing import NDArray

from quickreturn.reference_model.native.compilation import inlined
from quickreturn.reference_model.native.pointers import MEMBERS, array_of, intrinsic
from quickreturn.reference_model.state import State

_NUMBERS: Final = MEMBERS["Vector"]


class _StateAt(types.Type):
    """A state vector in memory: its address, n and m. Its parts are arrays, made where they are used, so that calls pass three words."""

    def __init__(self, slider: int) -> None:
        self.slider = slider  # number of places of the slider in it
        super().__init__(name=f"StateAt({slider})")


@register_model(_StateAt)
class _StateModel(models.StructModel):
    def __init__(self, dmm: Any, fe_type: _StateAt) -> None:
        super().__init__(dmm, fe_type, [("address", types.uintp), ("n", types.intp), ("m", types.intp)])  # type: ignore[no-untyped-call]


@infer_getattr
class _StateAttributes(AttributeTemplate):
    key = _StateAt

    def generic_resolve(self, state: _StateAt, name: str) -> Any:  # type: ignore[override]
        return _NUMBERS if name in State._fields else None


@lower_getattr_generic(_StateAt)
def _part(context: Any, builder: Any, kind: _StateAt, value: Any, name: str) -> Any:
    """The array of a part, see `State.of`."""
    state = cgutils.create_struct_proxy(kind)(context, builder, value=value)

    def number(value: int) -> Any:
        return ir.Constant(ir.IntType(64), value)

    n, m = state.n, state.m
    u = builder.add(m, number(kind.slider))
    opened = builder.zext(builder.icmp_signed(">", m, builder.add(n, number(1))), ir.IntType(64))
    begin, size = {
        "q": (number(0), m),
        "eta": (number(1), n),
        "s": (m, number(kind.slider)),
        "u": (u, m),
        "eta_rate": (builder.add(u, number(1)), n),
        "work": (builder.add(u, m), builder.add(number(2), opened)),
    }[name]
    return array_of(context, builder, _NUMBERS, builder.add(state.address, builder.mul(begin, number(8))), [size])


def _reader(kind: _StateAt) -> Any:
    """A compiled function from the address of a state vector, its number of shapes n, and its number of speeds m, to its parts."""

    @intrinsic
    def at(typing: Any, address: Any, n: Any, m: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            state = cgutils.create_struct_proxy(kind)(context, builder)
            state.address, state.n, state.m = arguments
            return state._getvalue()

        return kind(types.uintp, types.intp, types.intp), code

    return at


#: States with the slider's place in them, and without.
state_at, state_without_slider_at = map(_reader, (_StateAt(1), _StateAt(0)))


@inlined
def state_of(y: NDArray[np.float64], n: int) -> State:
    """The parts of a state vector without the slider's place."""
    return state_without_slider_at(y.ctypes.data, n, n + 1)
