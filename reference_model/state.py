"""The state vector of this project's own models, by name (DERIVATION.md, equation 5.8)."""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

#: Entries of `State.work`.
DISSIPATED, BY_DRIVE, BY_JOINT = range(3)


class State(NamedTuple):
    """The parts of a state vector (size,) with n shapes and m speeds, or of vectors (..., size), as views. Its rate has the same parts."""

    q: NDArray[Any]  # (..., m) coordinates: the crank's angle, the amplitudes, and with an open loop the follower's angle
    eta: NDArray[Any]  # (..., n) the amplitudes among them
    s: NDArray[Any]  # (..., 1) the slider's place along the follower, m; (..., 0) where the coordinates give it
    u: NDArray[Any]  # (..., m) speeds, the rates of the coordinates
    eta_rate: NDArray[Any]  # (..., n) those of the amplitudes
    work: NDArray[Any]  # (..., 2), with an open loop (..., 3) energy dissipated, work of the drive, work of the slider's joint, J

    @classmethod
    def of(cls, y: NDArray[Any], *, slider: bool = True) -> State:
        """The parts of vectors that hold the slider's place, or do not. Those of 0, 1, 2 ... are their places in a vector."""
        m, opened = divmod(y.shape[-1] - 2 - slider, 2)
        n, u = m - 1 - opened, m + slider
        parts = (0, m), (1, 1 + n), (m, u), (u, u + m), (u + 1, u + 1 + n), (u + m, y.shape[-1])
        return cls(*(y[..., begin:end] for begin, end in parts))
