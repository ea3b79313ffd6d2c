"""The solution of a scene that defines errors, and a second one that confirms it."""

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
#: Engine that confirms it, with settings from coarse to fine: it shares no coordinate, joint or integrator with the truth. The finer chain
#: is used if the first does not agree: for a follower that bends to two thirds of its length 60 links are 1e-3 off.
CONFIRMING: Final = ("mujoco", ({"links": "60", "armature": "0"}, {"links": "160"}))
#: Largest difference (relative, in the tip deflection) between the two with which the truth counts as confirmed: 3e-5 in run 24.
CONFIRMED: Final = 2e-4
#: Difference of the two from the start on, up to which a scene's motion counts as known.
KNOWN: Final = 0.1 * LEVELS[0]


@dataclass(frozen=True)
class Truth:
    """The solution of a scene."""

    trajectory: Trajectory  # up to where it is known: the duration, the end of the scene, or where two solutions part
    confirmation: Row  # the second solution: its errors are its differences from the trajectory, its status says why there are none
    end: float | None = None  # s, when the slider leaves the follower

    @property
    def until(self) -> float:
        """The length of the stretch that is known, s."""
        return float(self.trajectory["time"][-1])

    @property
    def uncertainty(self) -> float:
        """Relative difference of the two solutions in the tip deflection; 0 without a second one."""
        return self.confirmation.error or 0.0


def truth_of(case: Case, alone: bool = False) -> Truth:
    """The solution of a case, up to where a second one agrees with it to `KNOWN`.

    `alone`: both by `reference`, with six and two modes more than it takes for 0.01 %. That takes milliseconds where a chain of links may
    take hours, as for a stiff arm; other engines that are asked for an error in the same scene confirm it.

    EngineFailure, Refusal: there is none.
    """
    chosen, end, row, second = settings_of(*TRUTH, case), None, Row(scene=case.name, engine=CONFIRMING[0]), None
    others = [settings_of(CONFIRMING[0], texts, case) for texts in CONFIRMING[1]]
    if alone:
        usual, row = settings_of(TRUTH[0], {}, case), replace(row, engine=TRUTH[0])
        modes, tolerance = usual.as_dict()["modes"], max(0.1 * usual.as_dict()["tolerance"], 1e-12)
        others = [usual.with_texts({"modes": str(min(modes + more, 13)), "tolerance": str(tolerance)}) for more in (2, 6)]
        chosen = others.pop()
    try:
        truth = run_of(engine(TRUTH[0]), case, chosen).trajectory
    except EngineFailure as failure:
        if failure.partial is None or len(failure.partial) < 2:
            raise
        truth, end = failure.partial, float(failure.time)
    for settings in others:
        row, second = _second(replace(row, settings=settings.as_dict()), case, settings, truth)
        if second is None or (row.error or 0.0) <= CONFIRMED:
            break
    if second is not None and (row.error or 0.0) > KNOWN:
        rows = min(len(second), len(truth))
        size, apart = (np.cumsum(np.square(each)) for each in (truth[TIP][:rows], second[TIP][:rows] - truth[TIP][:rows]))
        truth = _head(truth, max(2, int(np.max(np.flatnonzero(apart <= KNOWN**2 * size), initial=0)) + 1))
        row = replace(row, errors=errors_of(second, truth))
    return Truth(_head(truth, len(truth)), row, end)


def _second(row: Row, case: Case, settings: Settings, truth: Trajectory) -> tuple[Row, Trajectory | None]:
    """The row of a second solution against the truth, and its trajectory as far as it goes."""
    try:
        found = run_of(engine(row.engine), case, settings).trajectory
    except Refusal as refusal:
        return replace(row, status=str(refusal)), None
    except EngineFailure as failure:
        if failure.partial is None or len(failure.partial) < 2:
            return replace(row, status=str(failure)), None
        found, row = failure.partial, replace(row, time=failure.time)
    return replace(row, errors=errors_of(found, truth), solve_seconds=found.solve_seconds), found


def _head(trajectory: Trajectory, rows: int) -> Trajectory:
    """The first rows of the columns that every engine gives."""
    return replace(trajectory, columns={name: trajectory[name][:rows] for name in REQUIRED})


def run_of(chosen: AnyEngine, case: Case, settings: Settings) -> CompletedRun:
    """One run of a case from its standard start, over its duration and output step. Raises as `run_once`."""
    return run_once(chosen, case.mechanism, standard_start(case.mechanism), case.duration, case.output_step, settings)


def settings_of(name: str, texts: Mapping[str, str], case: Case) -> Settings:
    """An engine's settings for an accuracy of 1e-4, with some replaced."""
    return engine(name).settings_for(1e-4, case.mechanism).with_texts(dict(texts))
