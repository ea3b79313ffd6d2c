"""The parts of a state vector, in Python and in compiled code."""

import numpy as np
import pytest

from quickreturn.reference_model.compiled_state import state_at, state_without_slider_at
from quickreturn.reference_model.native.compilation import compiled
from quickreturn.reference_model.state import State
from tests.reference_model.motion.beam_states import Array


@compiled
def _begin_and_size(y: Array, n: int, m: int, slider: bool, found: Array) -> None:
    """To `found`: where the parts begin, and their sizes."""
    if slider:
        state = state_at(y.ctypes.data, n, m)
        for k, part in enumerate((state.q, state.eta, state.s, state.u, state.eta_rate, state.work)):
            found[k, 0], found[k, 1] = len(part), part.ctypes.data - y.ctypes.data
    else:
        other = state_without_slider_at(y.ctypes.data, n, m)
        for k, part in enumerate((other.q, other.eta, other.s, other.u, other.eta_rate, other.work)):
            found[k, 0], found[k, 1] = len(part), part.ctypes.data - y.ctypes.data


@pytest.mark.parametrize("n", [0, 1, 4])
@pytest.mark.parametrize("kind", ["closed", "open", "without slider"])
def test_compiled_code_finds_the_parts_where_python_does(n: int, kind: str) -> None:
    m, slider = n + 1 + (kind == "open"), kind != "without slider"
    y, found = np.arange(2.0 * m + 2 + slider + (kind == "open")), np.empty((6, 2))
    _begin_and_size(y, n, m, slider, found)
    parts = State.of(y, slider=slider)
    for (size, begin), part in zip(found, parts, strict=True):
        assert size == len(part)
        assert size == 0 or begin == part.ctypes.data - y.ctypes.data
    assert np.concatenate([parts.q, parts.s, parts.u, parts.work]).tolist() == y.tolist()
    assert (parts.eta.tolist(), parts.eta_rate.tolist()) == (parts.q[1 : n + 1].tolist(), parts.u[1 : n + 1].tolist())
