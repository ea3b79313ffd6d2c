"""The solution of a scene that defines errors, and a second formulation that confirms it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from quickreturn.cases.files.case import Case
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.one_run import CompletedRun, run_once
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import REQUIRED, Trajectory
from quickreturn.plugins.methods.row import LEVELS, TIP, Row, errors_of

#: Engine and settings of the truth. In run 24 it differs from nine modes by 2e-5 of the tip deflection; fewer modes have larger errors.
TRUTH: Final = ("reference", {"modes": "13", "tolerance": "1e-10", "slowed_to": "0"})
#: Engines that confirm it, with settings from coarse to fine: they share no coordinate, joint or integrator with the truth. The finer chain
#: is used if the first does not agree: for a follower that bends to two thirds of its length 60 links are 1e-3 off.
CONFIRMING: Final[Mapping[str, tuple[dict[str, str], ...]]] = {
    "mujoco": ({"links": "60", "armature": "0"}, {"links": "160"}),
    "exudyn": ({"elements": "32", "step": "5e-5", "newton_tolerance": "1e-6"},),
}
#: The faster one, for uses where one is enough.
CONFIRMING_ONE: Final = "mujoco"
#: Largest difference (relative, in the tip deflection) between the two with which the truth counts as confirmed. Measured in run 24: 3e-5
#: by mujoco, 6e-5 by exudyn.
CONFIRMED: Final = 2e-4
#: Difference of the two from the start on, up to which a scene's motion counts as known.
KNOWN: Final = 0.1 * LEVELS[0]


@dataclass(frozen=True)
class Truth:
    """The solution of a scene."""

    trajectory: Trajectory  # up to where it is known: the duration, the end of the scene, or where two formulations part
    confirmation: Row  # a second formulation: its errors are its differences from the trajectory, its status says why there are none
    end: float | None = None  # s, when the slider leaves the follower

    @property
    def until(self) -> float:
        """The length of the stretch that is known, s."""
        return float(self.trajectory["time"][-1])

    @property
    def uncertainty(self) -> float:
        """Relative difference of the two formulations in the tip deflection; 0 without a second one."""
        return self.confirmation.error or 0.0

    @property
    def confirmed(self) -> bool:
        """Whether the two agree to `CONFIRMED`."""
        return self.confirmation.completed and self.uncertainty <= CONFIRMED


def truth_of(case: Case) -> Truth:
    """The solution of a case, with a second formulation beside it. EngineFailure, Refusal: there is none."""
    trajectory, end = _marched(case, settings_of(*TRUTH, case))
    return _known(trajectory, *confirmation_of(case, trajectory), end)


def truth_by_itself(case: Case) -> Truth:
    """The solution of a case by `reference` with six modes more than it takes for 0.01 %, and beside it that with two more.

    It takes milliseconds where `truth_of` may take hours, as for a stiff arm. Other engines that are asked for an error in the same scene
    confirm it. EngineFailure, Refusal: there is none.
    """
    usual = settings_of(TRUTH[0], {}, case)
    modes, tolerance = usual.as_dict()["modes"], max(0.1 * usual.as_dict()["tolerance"], 1e-12)
    coarse, fine = (usual.with_texts({"modes": str(min(modes + more, 13)), "tolerance": str(tolerance)}) for more in (2, 6))
    trajectory, end = _marched(case, fine)
    second, _ = _marched(case, coarse)
    row = Row(scene=case.name, engine=TRUTH[0], settings=coarse.as_dict(), errors=errors_of(second, trajectory))
    return _known(trajectory, row, second, end)


def _marched(case: Case, settings: Settings) -> tuple[Trajectory, float | None]:
    """The columns that every engine gives of a run of `reference`, and the time (s) when it ended before the duration."""
    try:
        trajectory, end = run_of(engine(TRUTH[0]), case, settings).trajectory, None
    except EngineFailure as failure:
        if failure.partial is None or len(failure.partial) < 2:
            raise
        trajectory, end = failure.partial, float(failure.time)
    return _head(trajectory, len(trajectory)), end


def _known(truth: Trajectory, confirmation: Row, second: Trajectory | None, end: float | None) -> Truth:
    """The truth up to where a second solution, if there is one, agrees with it to `KNOWN`."""
    if second is not None and (confirmation.error or 0.0) > KNOWN:
        rows = min(len(second), len(truth))
        size, apart = (np.cumsum(np.square(each)) for each in (truth[TIP][:rows], second[TIP][:rows] - truth[TIP][:rows]))
        truth = _head(truth, max(2, int(np.max(np.flatnonzero(apart <= KNOWN**2 * size), initial=0)) + 1))
        confirmation = replace(confirmation, errors=errors_of(second, truth))
    return Truth(truth, confirmation, end)


def _head(trajectory: Trajectory, rows: int) -> Trajectory:
    return replace(trajectory, columns={name: trajectory[name][:rows] for name in REQUIRED})


def confirmation_of(case: Case, truth: Trajectory, name: str = CONFIRMING_ONE) -> tuple[Row, Trajectory | None]:
    """An engine in `CONFIRMING` against the truth: its row, and its trajectory as far as it goes."""
    row, found = Row(scene=case.name, engine=name), None
    for texts in CONFIRMING[name]:
        settings, ended = settings_of(name, texts, case), None
        try:
            found = run_of(engine(name), case, settings).trajectory
        except EngineFailure as failure:
            found, ended = failure.partial, failure
        except Refusal as refusal:
            return replace(row, status=str(refusal)), None
        if found is None or len(found) < 2:
            return replace(row, status=str(ended)), None
        errors, time = errors_of(found, truth), None if ended is None else ended.time
        row = replace(row, settings=settings.as_dict(), errors=errors, time=time, solve_seconds=found.solve_seconds)
        if (row.error or 0.0) <= CONFIRMED:
            break
    return row, found


def run_of(chosen: AnyEngine, case: Case, settings: Settings) -> CompletedRun:
    """One run of a case from its standard start, over its duration and output step. Raises as `run_once`."""
    return run_once(chosen, case.mechanism, standard_start(case.mechanism), case.duration, case.output_step, settings)


def settings_of(name: str, texts: Mapping[str, str], case: Case) -> Settings:
    """An engine's settings for an accuracy of 1e-4, with some replaced."""
    return engine(name).settings_for(1e-4, case.mechanism).with_texts(dict(texts))
