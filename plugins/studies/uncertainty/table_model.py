"""Simulates the rows of a recorded table by `reference`, for any values of a scene's parameters."""

import math
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.comparison.tables import recorded_run
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.marching import output_step, periodic_cycle
from quickreturn.cases.motion.request import STANDARD
from quickreturn.engines.base import NoSteadyState
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import rms
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.rigid import mean_crank_speed

#: Columns that are compared, if a table has them: those that every engine delivers. Time and crank angle locate a row.
COMPARED: Final = tuple(name for name, column in COLUMNS.items() if column.required and name not in ("time", "crank_angle"))
#: Periods of the first mode in the shortest stretch that is fitted: the phase is within half a turn there if the stiffness is a third off.
FIRST_STRETCH: Final = 3.0
FEWEST_ROWS: Final = 20


class TableModel:
    """The rows of a table, and the same rows of a simulation.

    A table that begins in the standard start is compared with a simulation from there, row by row in time. Any other table is compared with
    the periodic steady state at equal crank angles.
    """

    def __init__(self, case: Case, table: RecordedTable) -> None:
        run = recorded_run(table, case)
        self.begins = run.approach.start == STANDARD  # whether the table begins in the standard start
        if not self.begins and run.status == Ending.NOT_SETTLED:
            raise CaseError(table.shown, None, None, "neither begins in the standard start nor has settled", run.remark)
        self.names = tuple(name for name in COMPARED if name in run.cycle and np.any(table.columns[name]))
        if not self.names:
            raise CaseError(table.shown, None, None, "has no column to fit", f"give some of {', '.join(COMPARED)}")
        self.values = np.array([table.columns[name] for name in self.names])  # SI, shape (C, N)
        self.sizes = np.array([rms(column) for column in self.values])  # RMS of each column, shape (C,)
        self.engine = ReferenceEngine()
        self._time = table.columns["time"] - (run.recording.begins if run.recording else 0.0)
        scene = case.mechanism
        even = scene.crank.initial_angle + mean_crank_speed(scene) * self._time
        self._angle = table.columns.get("crank_angle", even)

    @property
    def rows(self) -> int:
        """Number of rows, N."""
        return len(self._time)

    def stretches(self, scene: Mechanism) -> list[int]:
        """Numbers of rows, from the first row on, of the successive fits; the last is all rows.

        With a slightly wrong stiffness the vibration's phase error grows, and beyond half a turn the best fit is no longer downhill. So the
        first stretch is short, and each is twice the one before.
        """
        stretches = [self.rows]
        if self.begins and not scene.follower.is_rigid:
            shortest = FIRST_STRETCH / float(frozen_crank_modes(scene, math.pi, 1).frequencies[0])
            least = max(FEWEST_ROWS, int(np.searchsorted(self._time, shortest)))
            while stretches[0] // 2 >= least:
                stretches.insert(0, stretches[0] // 2)
        return stretches

    def simulated(self, scene: Mechanism, settings: ReferenceSettings, rows: int) -> Array:
        """The columns in the first `rows` rows, shape (C, rows). EngineFailure, Refusal, NoSteadyState: the simulation fails."""
        if self.begins:
            time = self._time[:rows]
            step = float(np.median(np.diff(self._time)))
            duration = step * math.ceil(time[-1] / step - 1e-6)
            run = run_once(self.engine, scene, standard_start(scene), duration, step, settings).trajectory
            return np.array([CubicSpline(run["time"], run[name])(time) for name in self.names])
        self.engine.check(scene)
        state = self.engine.steady_state(scene, standard_start(scene), settings)
        if state is None or not state.stable:
            raise NoSteadyState("a rigid follower or a soft joint has none that can be searched" if state is None else "it is not stable")
        cycle, _ = periodic_cycle(state, output_step(scene))
        turned = np.abs(cycle.crank_angle - cycle.crank_angle[0])
        direction = math.copysign(1.0, mean_crank_speed(scene))
        of_rows = np.mod(direction * self._angle[:rows] - math.pi, 2.0 * math.pi)  # rad since the slider's farthest place
        found = np.array([CubicSpline(turned, cycle.channels[name])(of_rows) for name in self.names])
        if scene.turns_fully and "follower_angle" in self.names:  # of the same turn as the row
            angle = found[self.names.index("follower_angle")]
            angle += 2.0 * np.pi * np.round((self.values[self.names.index("follower_angle"), :rows] - angle) / (2.0 * np.pi))
        return found
