"""Natural frequencies with the crank held."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from quickreturn.cases.jobs.display import compilation_announced
from quickreturn.cases.solving import frequencies_job
from quickreturn.catalogue import AnyCase, one_case
from quickreturn.engine_choice import engine_given
from quickreturn.engines.settings import as_texts
from quickreturn.solution import answered, engine_from, opened_store

if TYPE_CHECKING:
    import pandas as pd

    from quickreturn.engine_choice import AnyEngineOrTable


def modes(
    case: AnyCase,
    engine: "AnyEngineOrTable" = "reference",
    crank_angle: float | Sequence[float] = 0.0,
    *,
    count: int = 4,
    settings: Mapping[str, Any] | None = None,
    store: bool = True,
    quiet: bool = False,
) -> "pd.DataFrame":
    """Natural frequencies in Hz, a row for each crank angle: follower straight, at rest, no gravity, undamped.

    Args:
        case: a name, a path or a `Case`.
        engine: a name, the path of a file that declares one, or an engine.
        crank_angle: angle at which the crank is held, degrees; one or several.
        count: largest number of frequencies; there are fewer columns if the model has fewer.
        settings: of the engine, by name; None: those for its default accuracy.
        store: False: compute them anew, and store nothing.
        quiet: whether messages on standard error are left out while code is compiled.

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError: an invalid argument, or a scene that the engine cannot model.
        EngineFailure: the engine failed, or returned something other than natural frequencies.
        ValueError: an invalid crank angle or count.
    """
    import pandas as pd

    given = np.atleast_1d(np.asarray(crank_angle))
    if given.dtype.kind not in "iuf" or not np.all(np.isfinite(given)):
        raise ValueError(f"crank_angle={crank_angle!r}: degrees are needed, a number or several")
    if not (isinstance(count, int) and count > 0):
        raise ValueError(f"count={count!r}: a whole number from 1 on is needed")
    angles = given.tolist()
    engine = engine_given(engine)
    scene, chosen, texts = one_case(case), engine_from(engine), as_texts(settings or {})
    job = frequencies_job(chosen.name, scene.mechanism, engine, [math.radians(angle) for angle in angles], count, texts)
    with compilation_announced(quiet):
        answer, _ = answered(job, opened_store() if store else None)
    table = pd.DataFrame(answer.values, index=pd.Index(angles, name="crank angle [deg]"))
    table.columns = pd.Index([f"mode {number} [Hz]" for number in range(1, table.shape[1] + 1)])
    table.attrs.update(case=scene.name, engine=chosen.name, version=answer.version, settings=answer.settings)
    return table
