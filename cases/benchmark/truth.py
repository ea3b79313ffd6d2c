"""The truth of a scene: the solution that defines errors, and the solutions that confirm it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from quickreturn.cases.case import Case
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.one_run import CompletedRun, run_once
from quickreturn.engines.registry import engine
from quickreturn.engines.relative import relative_error, rms
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory

#: Engine and settings of the truth. In run 24 it differs from nine modes by 2e-5 of the tip deflection; fewer modes have larger errors.
TRUTH: Final = ("reference", {"modes": "13", "tolerance": "1e-10", "added_inertia": "false"})
#: Engines that confirm it, with settings from coarse to fine: they share no coordinate, joint or integrator with the truth. The finer chain
#: is used if the first does not agree: for a follower that bends to two thirds of its length 60 links are 1e-3 off.
CONFIRMING: Final[Mapping[str, tuple[dict[str, str], ...]]] = {
    "mujoco": ({"links": "60", "armature": "0"}, {"links": "160"}),
    "exudyn": ({"elements": "32", "step": "5e-5", "newton_tolerance": "1e-6"},),
}
#: The faster confirming engine, for uses where one is enough.
CONFIRMING_ONE: Final = "mujoco"
#: Largest difference (relative, in the tip deflection) between truth and confirming solution with which the truth counts as confirmed.
#: Measured in run 24: 3e-5 by mujoco, 6e-5 by exudyn.
CONFIRMED: Final = 2e-4


@dataclass(frozen=True)
class Converged:
    """The solution that defines errors; `sizes`: RMS of each column of `engines.error_parts.ESTIMATED`, SI."""

    engine: str
    settings: dict[str, Any]
    sizes: dict[str, float]


@dataclass(frozen=True)
class Confirmation:
    """A second solution of the scene: its difference in each column, relative to the first one, or the reason why there is none."""

    engine: str
    settings: dict[str, Any]
    differences: dict[str, float | None] = field(default_factory=dict)
    failure: str = ""

    @property
    def confirms(self) -> bool:
        """Whether the tip deflection of both solutions agrees to `CONFIRMED`."""
        difference = self.differences.get("tip_deflection")
        return difference is not None and difference <= CONFIRMED


def truth_of(case: Case) -> Trajectory:
    """The solution that defines errors. Raises EngineFailure or Refusal if it cannot be computed."""
    return run_of(engine(TRUTH[0]), case, _settings(*TRUTH, case)).trajectory


def converged(case: Case, truth: Trajectory) -> Converged:
    """The truth of a case, with its sizes."""
    return Converged(TRUTH[0], _settings(*TRUTH, case).as_dict(), {column: rms(truth[column]) for column in ESTIMATED})


def confirmation_of(case: Case, truth: Trajectory, name: str = CONFIRMING_ONE) -> Confirmation:
    """How far the solution of an engine in `CONFIRMING` differs from `truth`, or why there is none."""
    confirmation = Confirmation(name, {}, failure="no settings")
    for texts in CONFIRMING[name]:
        settings = _settings(name, texts, case)
        try:
            confirmation = Confirmation(name, settings.as_dict(), errors_of(run_of(engine(name), case, settings).trajectory, truth))
        except (EngineFailure, Refusal) as failure:
            confirmation = Confirmation(name, settings.as_dict(), failure=str(failure))
            continue
        if confirmation.confirms or confirmation.differences["tip_deflection"] is None:
            break
    return confirmation


def run_of(chosen: AnyEngine, case: Case, settings: Settings) -> CompletedRun:
    """One run of a case from its standard start, over its duration and output step. Raises as `run_once`."""
    return run_once(chosen, case.mechanism, standard_start(case.mechanism), case.duration, case.output_step, settings)


def errors_of(columns: Trajectory | Mapping[str, Any], truth: Trajectory) -> dict[str, float | None]:
    """Relative error of each column of `engines.error_parts.ESTIMATED`; None if the truth is zero throughout."""
    errors = {column: relative_error(columns[column], truth[column]) for column in ESTIMATED}
    return {column: error if math.isfinite(error) else None for column, error in errors.items()}


def _settings(name: str, texts: Mapping[str, str], case: Case) -> Settings:
    """The engine's settings for an accuracy of 1e-4, with some replaced."""
    return engine(name).settings_for(1e-4, case.mechanism).with_texts(dict(texts))
