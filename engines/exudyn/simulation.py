"""Stepping an assembled system on the output grid, with every way of failing turned into an `EngineFailure`.

Some tables take more than one run, or have rows that are closer than the steps.
"""

import itertools
import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from quickreturn.engines.base import EngineFailure, Simulation
from quickreturn.engines.exudyn.construction import longest_stretch
from quickreturn.engines.exudyn.library import exu
from quickreturn.engines.exudyn.record import Model, Record
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.trajectory import Trajectory, join, trajectory_type
from quickreturn.engines.units import Units
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.interpolation import CubicSpline

_Row = tuple[Array, Array, Array, Array, float, float]

#: Change of the coordinates (in the scene's unit of length, rad or slopes) that ends Newton's iteration whatever the first one was:
#: round-off moves slopes and angles by 1e-15 to 1e-14 in an iteration.
LEAST_CHANGE: Final = 1e-12

#: Number of elements up to which a dense factorization is faster than a sparse one (LADDERS.md, section 3).
MOST_FOR_DENSE: Final = 12

_ACCUMULATED = ("dissipated_energy", "drive_work")


class ExudynSimulation(Simulation):
    """A prepared system and its solver, kept alive between calls of `advance` so that its internal accelerations carry over.

    Exudyn's `SolveSteps` restarts its clock at `it.startTime` but continues from the present state. It is therefore called once
    per output step, or more often where that is long, always from 0: the steps are the same whether a time is covered in one call
    or in many. Exudyn's model is in units of the scene's own, and so are its times and rows.

    Attributes:
        steps_in: number of steps from one output to the next, a time (s) later.
    """

    def __init__(self, model: Model, settings: ExudynSettings, steps_in: Callable[[float], int], units: Units, begun: float) -> None:
        self.time = 0.0
        self.steps_in = steps_in
        self._units = units
        self._model = model
        self._mbs = model.assembly.mbs
        self._solver_settings = _solver_settings(settings)
        self._solver = exu.MainSolverImplicitSecondOrder()
        self._impulse = self._lost = 0.0
        self._totals = dict.fromkeys(_ACCUMULATED, 0.0)
        self._length = model.assembly.scene.follower.length
        self._longest = longest_stretch(model.assembly.scene)
        try:
            ready = model.assembly.begin(lambda: self._solver.InitializeSolver(self._mbs, self._solver_settings))
        except exu.ExudynError as error:
            raise EngineFailure(0.0, f"Exudyn refused the start: {_one_line(str(error))}", "check the scene's parameters") from error
        if not ready:
            raise EngineFailure(0.0, "Exudyn could not find the accelerations of the start", "check the scene's parameters")
        # GetODE2CoordinatesTotal corrupts memory beyond 100 coordinates (Exudyn 1.13.6), so the sum is taken here.
        self._reference = self._mbs.systemData.GetODE2Coordinates(configuration=exu.ConfigurationType.Reference)
        self._multiplier, self._loss = self._drive_multiplier(), model.joint_loss()
        rubs = model.assembly.scene.tip_body.friction_force > 0.0
        self._sums = model.drive_equation is not None or model.assembly.joint_is_compliant or rubs
        self._last = self._row()
        self.setup_seconds = time.perf_counter() - begun

    def advance(self, duration: float, output_step: float) -> Trajectory:
        """See `Simulation.advance`; a slider that reaches an end of the follower is a failure too."""
        count = round(duration / output_step)
        begun = time.perf_counter()
        steps = self.steps_in(output_step)
        interval = output_step / self._units.time
        at_once = max(1, math.floor(self._longest / interval * (1.0 + 1e-9)))  # output steps that make up a stretch
        newton_before = self._solver.it.newtonStepsCount
        rows, failure = [self._last], None
        while len(rows) <= count and failure is None:
            found, failure = self._output_steps(interval, steps, min(at_once, count + 1 - len(rows)))
            rows += found
        done = len(rows) - 1
        at = self.time + output_step * np.arange(done + 1, dtype=np.float64)
        record = Record(at / self._units.time, *(np.array(values) for values in zip(*rows, strict=True)))
        columns = self._units.columns_in_si(self._model.columns(record)) | {"time": at}
        for name in _ACCUMULATED:
            columns[name] = columns[name] + self._totals[name]
            self._totals[name] = float(columns[name][-1])
        statistics = {
            "steps": float(done * steps),
            "newton_iterations": float(self._solver.it.newtonStepsCount - newton_before),
        }
        self.time, self._last = float(at[-1]), rows[-1]
        trajectory = trajectory_type(self._model.assembly.scene)(columns, time.perf_counter() - begun, statistics)
        if failure is not None:
            raise EngineFailure(self.time, *failure, trajectory)
        return trajectory

    def _output_steps(self, interval: float, steps: int, outputs: int) -> tuple[list[_Row], tuple[str, str] | None]:
        """Solve up to the next output instants; their rows as far as they are good, and cause and advice where that fails.

        Several outputs are solved in one go, which saves Newton's method a Jacobian for each: those on the way are noted before the step
        that follows them.
        """
        rows: list[_Row] = []
        parts = _stretches(interval, steps, self._longest) if outputs == 1 else 1
        self._set_step(outputs * interval / parts, outputs * steps // parts)
        failure = next(filter(None, (self._stretch(rows, steps) for _ in range(parts))), None)
        if failure is None:
            rows.append(self._row())
        for number, (coordinates, *_) in enumerate(rows):
            if left := self._left(coordinates):
                return rows[:number], left
        return rows, failure

    def _set_step(self, stretch: float, steps: int) -> None:
        integration, iteration = self._solver_settings.timeIntegration, self._solver.it
        integration.endTime = iteration.endTime = stretch
        integration.numberOfSteps = iteration.numberOfSteps = steps
        iteration.maxStepSize = iteration.initialStepSize = iteration.currentStepSize = stretch / steps

    def _stretch(self, rows: list[_Row], steps: int) -> tuple[str, str] | None:
        """Solve a stretch; every so many steps there is a row within it. Cause and advice where that fails."""
        taken = itertools.count()

        def note(_mbs: object, _time: float) -> bool:
            if number := next(taken):
                self._step_done()
                if number % steps == 0:
                    rows.append(self._row())
            return True

        self._mbs.SetPreStepUserFunction(note)
        try:
            failure = self._solved()
        finally:
            self._mbs.SetPreStepUserFunction(0)
        if failure is None:
            self._step_done()
        return failure

    def _step_done(self) -> None:
        """Add the step that was just taken to what is summed from step to step."""
        if not self._sums:
            return
        half = 0.5 * self._solver.it.currentStepSize
        torque, self._multiplier = self._multiplier, self._drive_multiplier()
        loss, self._loss = self._loss, self._model.joint_loss()
        self._impulse += half * (torque + self._multiplier)
        self._lost += half * (loss + self._loss)

    def _drive_multiplier(self) -> float:
        equation = self._model.drive_equation
        return 0.0 if equation is None else self._model.assembly.drive_rate() * float(self._mbs.systemData.GetAECoordinates()[equation])

    def _solved(self) -> tuple[str, str] | None:
        smaller = "try a smaller engine.step"
        rates = self._mbs.systemData.GetODE2Coordinates_t()
        self._model.prepare_stretch(self._coordinates(), rates, self._solver.it.endTime)
        try:
            solved = self._solver.SolveSteps(self._mbs, self._solver_settings)
        except exu.ExudynError as error:
            return f"Exudyn gave up ({_one_line(str(error))})", smaller
        if not solved:
            return f"Newton's iteration did not converge ({_one_line(self._solver.GetErrorString())})", smaller
        if not math.isclose(self._solver.it.currentTime, self._solver.it.endTime, rel_tol=1e-9):
            return "Exudyn stopped before the end of a stretch of steps", smaller
        if not math.isfinite(np.sum(self._mbs.systemData.GetODE2Coordinates())):
            return "the solution is not finite", smaller
        return None

    def _left(self, coordinates: Array) -> tuple[str, str] | None:
        """Cause and advice if the slider is beyond an end of the follower."""
        s = self._model.slider_position(coordinates)
        if s is None or 0.0 <= s <= self._length:
            return None
        place, length = s * self._units.length, self._length * self._units.length
        return f"the slider left the follower (s = {place:.6g} m of {length:.6g} m)", "use a longer follower or a slower crank"

    def _row(self) -> _Row:
        data = self._mbs.systemData
        states = self._coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt(), data.GetAECoordinates()
        return *states, self._impulse, self._lost

    def _coordinates(self) -> Array:
        return self._reference + self._mbs.systemData.GetODE2Coordinates()


def _stretches(interval: float, steps: int, longest: float) -> int:
    """Number of equal parts with whole steps in an interval: the least whose parts are no longer than `longest`, or the steps."""
    fitting = (parts for parts in range(1, steps + 1) if steps % parts == 0 and interval / parts <= longest * (1.0 + 1e-9))
    return next(fitting, steps)


def _solver_settings(settings: ExudynSettings) -> exu.SimulationSettings:
    result = exu.SimulationSettings()
    integration = result.timeIntegration
    integration.startTime, integration.endTime, integration.numberOfSteps = 0.0, settings.step, 1
    integration.adaptiveStep = False  # would hide a failure behind ever smaller steps for a minute
    integration.verboseMode = 0
    integration.generalizedAlpha.spectralRadius = settings.spectral_radius
    integration.newton.useModifiedNewton = True
    # Judged by what an iteration changes in the coordinates. A residual would not do: its round-off grows with the cable's axial
    # stiffness, and the joint's force, small beside that, is not in it (1e-4 off in an arm 25 times as long as thick, 4e-6 so).
    integration.newton.residualMode = 1
    integration.newton.relativeTolerance = settings.newton_tolerance
    integration.newton.absoluteTolerance = LEAST_CHANGE
    few = settings.elements <= MOST_FOR_DENSE
    result.linearSolver.solverType = exu.LinearSolverType.EigenDense if few else exu.LinearSolverType.EigenSparse
    result.linearSolver.reuseAnalyzedPattern = True
    result.solution.file.write = False
    result.solution.sensors.active = False
    return result


def _one_line(text: str) -> str:
    return " ".join(text.split())[:200]


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
