"""Natural frequencies with the crank held, as an engine gives them, checked before anybody believes them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engines.base import AnyEngine, EngineFailure
from engines.settings import Settings
from reference_model.mechanism import Mechanism

_SHOWN = 60  # characters of what an engine returned


def natural_frequencies(engine: AnyEngine, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> NDArray[np.float64]:
    """`Engine.natural_frequencies` in Hz, of shape (<= count,): finite, none negative, ascending.

    Raises:
        Refusal: as the engine raises it.
        EngineFailure: the engine returned something else; the cause says what.
    """
    found: Any = engine.natural_frequencies(mechanism, crank_angle, count, settings)
    wrong = _wrong(found)
    if wrong:
        shown = " ".join(str(found).split())
        cause = f"the engine returned natural frequencies {wrong}: {shown if len(shown) <= _SHOWN else f'{shown[:_SHOWN]}...'}"
        raise EngineFailure(0.0, cause, "report this to the author of the engine")
    return np.asarray(found, dtype=np.float64)[:count]


def _wrong(found: Any) -> str:
    """What is wrong with natural frequencies, as a clause; "" if nothing is."""
    try:
        values = np.asarray(found)
    except ValueError:  # lists of different lengths
        return "that are no list of numbers"
    if values.ndim != 1 or (values.size and values.dtype.kind not in "iuf"):
        return "that are no list of numbers"
    if not np.isfinite(values).all():
        return "that are not finite"
    if (values < 0.0).any():
        return "below zero"
    return "" if (np.diff(values.astype(np.float64)) >= 0.0).all() else "that do not ascend"
