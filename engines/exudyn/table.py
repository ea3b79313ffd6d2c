"""Tables that take more than one run, or whose rows are closer than the steps."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from quickreturn.engines.base import EngineFailure, Simulation
from quickreturn.engines.exudyn.simulation import ExudynSimulation
from quickreturn.engines.trajectory import Trajectory, join
from quickreturn.reference_model.interpolation import CubicSpline


class ExtrapolatedSimulation(Simulation):
    """Two simulations of a scene, one with about twice the steps of the other, and the table that their tables lead to (Richardson).

    The errors fall with the square of the step: a + (a - b) / (r^2 - 1) has none of second order, r being the ratio of the steps. Where
    the finer run takes one step to a row, the coarser one passes every other row, and a - b is interpolated there.
    """

    def __init__(self, fine: ExudynSimulation, coarse: ExudynSimulation) -> None:
        self._fine, self._coarse = fine, coarse
        self.time, self.setup_seconds = 0.0, fine.setup_seconds + coarse.setup_seconds

    def advance(self, duration: float, output_step: float) -> Trajectory:
        """See `Simulation.advance`; where one of the two fails, the table is extrapolated as far as both go."""
        fine, failure = _as_far_as_it_goes(self._fine, duration, output_step)
        steps, rows = self._fine.steps_in(output_step), len(fine) - 1
        stride = 2 if steps == 1 else 1
        at, pieces = np.r_[: rows - rows % stride + 1 : stride, rows - rows % stride + 1 : rows + 1], []
        for intervals, number in ((stride, rows // stride), (1, rows % stride)):  # a row may be left, to which the last step is shorter
            if number:
                piece, other = _as_far_as_it_goes(self._coarse, number * intervals * output_step, intervals * output_step)
                pieces.append(piece)
                failure = failure or other
                if other:
                    break
        coarse = join(pieces) if pieces else fine
        at = at[: len(coarse)]
        squared, shown = (steps * stride / self._coarse.steps_in(stride * output_step)) ** 2, slice(int(at[-1]) + 1)
        columns = {name: values[shown] for name, values in fine.columns.items()}
        for name in columns.keys() - {"time", "constraint_gap"}:
            error = (columns[name][at] - coarse[name]) / (squared - 1.0)
            columns[name] = columns[name] + np.interp(np.arange(len(columns[name])), at, error)
        statistics = {name: number + coarse.statistics.get(name, 0.0) for name, number in fine.statistics.items()}
        trajectory = type(fine)(columns, fine.solve_seconds + coarse.solve_seconds, statistics)
        self.time = float(trajectory["time"][-1])
        if failure is not None:
            raise EngineFailure(self.time, failure.cause, failure.advice, trajectory)
        return trajectory


class PassingSimulation(Simulation):
    """A simulation whose steps pass rows of the table: these are interpolated by cubic splines.

    Rows that are left at the end of a call, fewer than a step passes, are one step of their own.
    """

    def __init__(self, stepped: Simulation, rows_in_step: Callable[[float], int]) -> None:
        self._stepped, self._rows_in_step = stepped, rows_in_step
        self.time, self.setup_seconds = 0.0, stepped.setup_seconds

    def advance(self, duration: float, output_step: float) -> Trajectory:
        """See `Simulation.advance`; where the simulation fails, there are rows up to its last step."""
        rows, passed, begun = round(duration / output_step), self._rows_in_step(output_step), self.time
        left = rows % passed
        pieces, failure = [], None
        for number, stride in ((rows - left, passed), (left, left)):
            if number and failure is None:
                piece, failure = _as_far_as_it_goes(self._stepped, number * output_step, stride * output_step)
                pieces.append(piece)
        stepped = join(pieces)
        self.time = float(stepped["time"][-1])
        trajectory = _with_rows_between(stepped, begun + output_step * np.arange(round((self.time - begun) / output_step) + 1))
        if failure is not None:
            raise EngineFailure(self.time, failure.cause, failure.advice, trajectory)
        return trajectory


def _with_rows_between(stepped: Trajectory, time: np.ndarray) -> Trajectory:
    """The trajectory at other times (s), the first and last of which are its own."""
    if len(time) == len(stepped):
        return stepped
    names = [name for name in stepped.columns if name != "time"]
    spline = CubicSpline(stepped["time"], np.column_stack([stepped[name] for name in names]))
    columns = {"time": time} | dict(zip(names, np.ascontiguousarray(spline(time).T), strict=True))
    columns["constraint_gap"] = np.abs(columns["constraint_gap"])  # a distance
    return replace(stepped, columns={name: columns[name] for name in stepped.columns})


def _as_far_as_it_goes(simulation: Simulation, duration: float, output_step: float) -> tuple[Trajectory, EngineFailure | None]:
    try:
        return simulation.advance(duration, output_step), None
    except EngineFailure as failure:
        if failure.partial is None:
            raise
        return failure.partial, failure
