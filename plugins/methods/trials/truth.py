"""The truth of a scene: the solution that defines errors, and the solutions that confirm it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.registry import engine
from quickreturn.engines.relative import rms
from quickreturn.engines.settings import Settings
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.trials.methods import Method
from quickreturn.plugins.methods.trials.trial import Trial, run_of, trial_of

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
class Truth:
    """The solution that defines errors; `sizes`: RMS of each column of `engines.error_parts.ESTIMATED`, SI."""

    engine: str
    settings: dict[str, Any]
    sizes: dict[str, float]

    @classmethod
    def of(cls, case: Case, trajectory: Trajectory) -> "Truth":
        """The truth of a case, from its trajectory."""
        return cls(TRUTH[0], _settings(*TRUTH, case).as_dict(), {column: rms(trajectory[column]) for column in ESTIMATED})


def truth_of(case: Case) -> Trajectory:
    """The solution that defines errors. Raises EngineFailure or Refusal if it cannot be computed."""
    return run_of(engine(TRUTH[0]), case, _settings(*TRUTH, case)).trajectory


def confirmation_of(case: Case, truth: Trajectory, name: str = CONFIRMING_ONE) -> Trial:
    """The trial of an engine in `CONFIRMING`: its errors are its differences from `truth`, its status says why there are none."""
    ladder = tuple(_settings(name, texts, case) for texts in CONFIRMING[name])
    for plan in Method(name, engine(name), ladder).plans(case):
        trial = trial_of(plan, truth)
        if confirms(trial) or (trial.completed and trial.error is None):
            break
    return trial


def confirms(trial: Trial) -> bool:
    """Whether a trial's tip deflection agrees with the truth to `CONFIRMED`."""
    return trial.error is not None and trial.error <= CONFIRMED


def _settings(name: str, texts: Mapping[str, str], case: Case) -> Settings:
    """The engine's settings for an accuracy of 1e-4, with some replaced."""
    return engine(name).settings_for(1e-4, case.mechanism).with_texts(dict(texts))
