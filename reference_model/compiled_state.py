"""The type by which compiled code knows a `State`, and how it finds the parts of one by address."""

from typing import Any, Final

from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, lower_getattr_generic, models, register_model

from quickreturn.reference_model.arrays import Array
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
    """The array of a part, see `State.of`. Where it begins and its size are sums of 1, n and m, so many times each."""
    state, slider = cgutils.create_struct_proxy(kind)(context, builder, value=value), kind.slider
    begin, size = {
        "q": ((0, 0, 0), (0, 0, 1)),
        "eta": ((1, 0, 0), (0, 1, 0)),
        "s": ((0, 0, 1), (slider, 0, 0)),
        "u": ((slider, 0, 1), (0, 0, 1)),
        "eta_rate": ((slider + 1, 0, 1), (0, 1, 0)),
        "work": ((slider, 0, 2), (1, -1, 1)),
    }[name]

    def total(times: tuple[int, int, int], word: int = 1) -> Any:
        one, n, m = (context.get_constant(types.intp, word * each) for each in times)
        return builder.add(one, builder.add(builder.mul(n, state.n), builder.mul(m, state.m)))

    return array_of(context, builder, _NUMBERS, builder.add(state.address, total(begin, 8)), [total(size)])


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
def state_of(y: Array, n: int) -> State:
    """The parts of a state vector without the slider's place."""
    return state_without_slider_at(y.ctypes.data, n, n + 1)
