"""Natural frequencies with the crank held."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from quickreturn.cases.case import Case
from quickreturn.cases.jobs.display import compilation_told
from quickreturn.catalogue import AnyCase, one_case
from quickreturn.engines import progress
from quickreturn.engines.settings import as_texts
from quickreturn.solution import found_engine

if TYPE_CHECKING:
    import pandas as pd

    from quickreturn.engines.base import AnyEngine


@dataclass(frozen=True)
class Modes:
    """Natural frequencies, Hz, ascending, at a crank angle (rad), with case, engine and settings."""

    case: str
    crank_angle: float
    engine: str
    version: str
    settings: dict[str, Any]
    frequencies: list[float]


def modes(
    case: AnyCase,
    engine: "str | AnyEngine" = "reference",
    crank_angle: float | Sequence[float] = 0.0,
    *,
    count: int = 4,
    settings: Mapping[str, Any] | None = None,
    quiet: bool = False,
) -> "pd.DataFrame":
    """Natural frequencies in Hz, a row for each crank angle: follower straight, at rest, no gravity, undamped.

    Args:
        case: a name, a path or a `Case`.
        engine: a name or an engine.
        crank_angle: at which the crank is held, degrees; one or several.
        count: how many at most; there are fewer columns if the model has fewer.
        settings: of the engine, by name; None: those for its default accuracy.
        quiet: as of `simulate`.

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError: an invalid argument, or a scene that the engine cannot model.
        EngineFailure: the engine failed, or returned something other than natural frequencies.
        ValueError: an invalid crank angle or count.
    """
    import numpy as np
    import pandas as pd

    given = np.atleast_1d(np.asarray(crank_angle))
    if given.dtype.kind not in "iuf" or not np.all(np.isfinite(given)):
        raise ValueError(f"crank_angle={crank_angle!r}: degrees are needed, a number or several")
    if not (isinstance(count, int) and count > 0):
        raise ValueError(f"count={count!r}: a whole number from 1 on is needed")
    angles = given.tolist()
    scene, texts = one_case(case), as_texts(settings or {})
    with compilation_told(quiet):
        found = frozen_crank(scene, engine, [math.radians(angle) for angle in angles], count, texts)
    table = pd.DataFrame([each.frequencies for each in found], index=pd.Index(angles, name="crank angle [deg]"))
    table.columns = pd.Index([f"mode {number} [Hz]" for number in range(1, table.shape[1] + 1)])
    table.attrs.update(case=found[0].case, engine=found[0].engine, version=found[0].version, settings=found[0].settings)
    return table


def frozen_crank(
    case: Case, engine: "str | AnyEngine", crank_angles: Sequence[float], count: int, settings: Mapping[str, str]
) -> list[Modes]:
    """As `modes`, with crank angles in rad and settings as texts."""
    from quickreturn.engines.frozen_crank import natural_frequencies

    chosen = found_engine(engine)
    chosen.check(case.mechanism)
    used = chosen.settings_for(chosen.default_accuracy, case.mechanism).with_texts(dict(settings))
    version, shown = chosen.version(), used.as_dict()

    def at(angle: float) -> list[float]:
        found = [float(frequency) for frequency in natural_frequencies(chosen, case.mechanism, angle, count, used)]
        progress.tell(phase="natural frequencies")
        return found

    progress.tell(engine=chosen.name, phase=progress.COMPILING if chosen.compiles else "natural frequencies")
    return [Modes(case.name, angle, chosen.name, version, shown, at(angle)) for angle in crank_angles]
