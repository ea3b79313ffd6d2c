"""Natural frequencies of an engine with the crank held, checked."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.base import AnyEngine, EngineFailure
from quickreturn.engines.one_thread import on_one_thread
from quickreturn.engines.settings import Settings
from quickreturn.reference_model.mechanism import Mechanism

_QUOTED = 60  # characters of an engine's answer that a message quotes


@on_one_thread
def natural_frequencies(engine: AnyEngine, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> NDArray[np.float64]:
    """`Engine.natural_frequencies` in Hz, of shape (<= count,): finite, none negative, ascending.

    Raises:
        Refusal: as the engine raises it.
        EngineFailure: the engine returned something else; the cause says what.
    """
    answer: Any = engine.natural_frequencies(mechanism, crank_angle, count, settings)
    try:
        values = np.asarray(answer)
    except ValueError:  # lists of different lengths
        values = np.empty((0, 0))
    wrong = ""
    if values.ndim != 1 or (values.size and values.dtype.kind not in "iuf"):
        wrong = "that are no list of numbers"
    elif not np.isfinite(values).all():
        wrong = "that are not finite"
    elif (values < 0.0).any():
        wrong = "below zero"
    elif (np.diff(values.astype(np.float64)) < 0.0).any():
        wrong = "that do not ascend"
    if wrong:
        shown = " ".join(str(answer).split())
        cause = f"the engine returned natural frequencies {wrong}: {shown if len(shown) <= _QUOTED else f'{shown[:_QUOTED]}...'}"
        raise EngineFailure(0.0, cause, "report this to the author of the engine")
    return np.asarray(values, dtype=np.float64)[:count]
