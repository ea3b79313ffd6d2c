"""The usual engine in a few lines: one resolution, and an error of known order.

An author writes a `Model`: the state that a start makes, its accelerations, what a row of output looks like; and a `SimpleEngine` that
says how its error falls and which quantities of a scene it has. Grid, integration, ladder, error estimate, refusals, failures, version
and natural frequencies follow. Who needs more derives from `engines.base.Engine`.
"""

import dataclasses
import math
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import Radau

from quickreturn.engines.base import Comparison, Engine, EngineFailure, ModelDescription, Refusal, Simulation, installed
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.settings import SettingError, Settings, setting
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import REQUIRED, Trajectory
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed, Scene, TorqueDrive

Array = NDArray[np.float64]

#: Factor on the resolution for the run that the error is estimated with.
_COMPARED: Final = 1.5
#: Tolerance over the error of a resolution, and the loosest and tightest. At 1e-5 ten polynomials of docs/engine.md are 7e-4 off in a mild
#: scene, by the integration alone; in run 24 (3.8e-3) and with four of them (3.7e-3) it is not seen.
_SHARE: Final = 5e-4
_LOOSEST, _TIGHTEST = 1e-5, 1e-12
#: Displacement (rad or m) of a coordinate for the differences that linearize.
_MOVED: Final = 1e-5
#: Inertia (kg m^2) of a crank that is held.
_HELD: Final = 1e4
#: Part of the largest squared angular frequency below which a square is round-off.
_NONE: Final = 1e-10
#: Part of the follower's length: where the integration stops with the slider beyond it, the slider has left the follower.
_NEARLY: Final = 0.97
_LEFT: Final = "the slider has left the follower's end"


@dataclass(frozen=True, kw_only=True)
class SimpleSettings(Settings):
    """One resolution, and how closely its equations are integrated."""

    resolution: int = setting(8, "number of links, elements, shapes: what the engine's method says", low=1, high=1000)
    tolerance: float = setting(1e-5, "local error of the integration, relative and in the state's units", low=_TIGHTEST, high=1e-2)


class Model(ABC):
    """A scene's equations of motion.

    Attributes:
        state: n coordinates and behind them their n speeds at the start, shape (2n,); of order one in SI units, as angles are.
    """

    state: Array

    @abstractmethod
    def __init__(self, mechanism: Mechanism, start: Start, resolution: int) -> None:
        """Build the equations and set `state`; `engines.start_state.reconstruct` tells place and velocity of every point at the start."""

    @abstractmethod
    def accelerations(self, time: float, coordinates: Array, speeds: Array) -> Array:
        """Second derivatives of the coordinates, shape (n,); NaN where a trial state has none: the step is tried again, shorter."""

    @abstractmethod
    def row(self, time: float, coordinates: Array, speeds: Array) -> Mapping[str, float]:
        """The columns of `reference_model.columns` at an instant: all that are required but the time, any of the others."""

    def states(self, times: Array, state: Array, tolerance: float) -> Iterator[Array]:
        """The state at each of `times` (s, shape (m,)), which begin with that of `state`; fewer if the integration stops early.

        The accelerations are integrated by Radau's method (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8), whose
        steps follow the motion and not the fastest vibration that a fine model could make. A tool that steps by itself does so here.
        """
        n, latest = len(state) // 2, state

        def rates(at: float, y: Array) -> Array:
            nonlocal latest
            found = np.asarray(self.accelerations(at, y[:n], y[n:]))
            if found.shape != (n,):
                told = f"accelerations() of {type(self).__name__} has the shape {found.shape}"
                raise EngineFailure(at, told, f"the state of {len(state)} numbers needs ({n},)")
            latest = np.concatenate([y[n:], found])
            return latest

        yield state
        solver, done = Radau(rates, times[0], state, times[-1], rtol=tolerance, atol=tolerance), 1
        while solver.status == "running":
            try:
                solver.step()
            except ValueError:  # the solver's, of a matrix of NaN
                if np.isfinite(latest).all():
                    raise
                return
            if solver.status == "failed":
                return
            reached = int(np.searchsorted(times, solver.t, side="right"))
            yield from solver.dense_output()(times[done:reached]).T
            done = reached


class SimpleEngine(Engine[SimpleSettings]):
    """An engine with one resolution."""

    settings_type = SimpleSettings
    default_accuracy = 0.05
    model: ClassVar[type[Model]]
    #: Distribution whose version is the engine's.
    library: ClassVar[str]
    #: Resolution -> measured error of the tip deflection in the first 2 s of run 24, coarse to fine: what the engine may choose from.
    errors: ClassVar[Mapping[int, float]]
    #: The error, of whichever column converges slowest, falls as the resolution to the power of minus this.
    order: ClassVar[float]

    def version(self) -> str:
        return f"{self.library} {installed(self.library) or 'not installed'}"

    def unavailable(self) -> str | None:
        return None if installed(self.library) else f"the package {self.library} is not installed"

    def check(self, scene: Scene) -> None:
        """Refuse what is not among `quantities`, and a rigid follower."""
        super().check(scene)
        if scene.follower.is_rigid:
            raise Refusal(f"follower.bending_stiffness: inf N*m^2 is not modelled by engine {self.name}; accepted: a finite stiffness")

    def describe(self, mechanism: Mechanism, settings: SimpleSettings) -> ModelDescription:
        """Bodies by the scene, degrees of freedom by the state."""
        self.check(mechanism)
        free = len(self.model(mechanism, standard_start(mechanism), settings.resolution).state) // 2
        bodies = ("crank", f"follower, resolution {settings.resolution}", *(["tip body"] if mechanism.tip else []))
        return ModelDescription(bodies, ("crank pivot", "follower pivot", "slider on the follower"), free)

    def _ladder(self) -> Ladder[SimpleSettings]:
        rungs = [
            (SimpleSettings(resolution=size, tolerance=float(np.clip(_SHARE * error, _TIGHTEST, _LOOSEST))), error)
            for size, error in self.errors.items()
        ]
        return Ladder(tuple(rungs), "resolution", "tolerance", self.order)

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> SimpleSettings:
        return self._ladder().pick(accuracy)

    def comparisons(self, settings: SimpleSettings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """A run that is half as fine again, its integration as well."""
        more = math.ceil(_COMPARED * settings.resolution)
        factor = (settings.resolution / more) ** self.order
        return (Comparison(settings, SimpleSettings(resolution=more, tolerance=max(_TIGHTEST, factor * settings.tolerance)), factor),)

    def finer(self, settings: SimpleSettings, excess: tuple[float, ...], output_step: float) -> SimpleSettings | None:
        return self._ladder().finer(settings, excess)

    def prepare(self, mechanism: Mechanism, start: Start, settings: SimpleSettings) -> Simulation:
        """See `Engine.prepare`; SettingError: a resolution that is coarser than any that was measured."""
        self.check(mechanism)
        if settings.resolution < (coarsest := min(self.errors)):
            raise SettingError(f"engine.resolution: {settings.resolution} is not accepted; engine {self.name} begins with {coarsest}")
        began = time.perf_counter()
        model = self.model(mechanism, start, settings.resolution)
        return _SimpleSimulation(model, mechanism.follower.length, settings.tolerance, time.perf_counter() - began)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: SimpleSettings) -> Array:
        """By differences of the accelerations about the straight follower at rest, undamped there; its crank is too heavy to move."""
        self.check(mechanism)
        free = "crank.torque" in self.quantities
        drive = TorqueDrive(torque=0.0, damping=0.0, initial_speed=0.0) if free else PrescribedSpeed(speed=0.0)
        crank = dataclasses.replace(mechanism.crank, inertia=_HELD, drive=drive)
        tip = mechanism.tip and dataclasses.replace(mechanism.tip, force=(0.0, 0.0))
        still = dataclasses.replace(mechanism, crank=crank, gravity=(0.0, 0.0), tip=tip)
        model = self.model(still, Start(crank_angle, 0.0), settings.resolution)
        rest = model.state[: len(model.state) // 2]
        moved = np.concatenate([rest - _MOVED * np.eye(len(rest)), rest + _MOVED * np.eye(len(rest))])
        back, forth = np.split(np.array([model.accelerations(0.0, q, 0.0 * rest) for q in moved]), 2)
        squares = np.sort(np.linalg.eigvals((back - forth).T / (2.0 * _MOVED)).real)
        found: Array = np.sqrt(squares[squares > _NONE * squares[-1]]) / (2.0 * math.pi)
        return found[:count]


class _SimpleSimulation(Simulation):
    """A model, advanced from row to row."""

    def __init__(self, model: Model, length: float, tolerance: float, setup_seconds: float) -> None:
        self.model, self.length, self.tolerance = model, length, tolerance
        self.setup_seconds, self.time = setup_seconds, 0.0
        self.state = np.asarray(model.state, dtype=np.float64)

    def advance(self, duration: float, output_step: float) -> Trajectory:
        began, rows, cause = time.perf_counter(), list[dict[str, float]](), ""
        times: Array = self.time + output_step * np.arange(round(duration / output_step) + 1, dtype=np.float64)
        for at, state in zip(times, self.model.states(times, self.state, self.tolerance), strict=False):
            row = self._row(float(at), state)
            if (lost := next((name for name, value in row.items() if not math.isfinite(value)), None)) is not None:
                cause = f"the motion explodes, {lost} is {row[lost]}"
            elif row["slider_position"] > self.length:
                cause = _LEFT
            if cause:
                break
            rows.append(row)
            self.time, self.state = float(at), state
        columns = {name: np.array([row[name] for row in rows]) for name in (rows[0] if rows else ())}
        table = Trajectory(columns, time.perf_counter() - began) if rows else None
        if table is None or len(rows) < len(times):
            near = rows and rows[-1]["slider_position"] > _NEARLY * self.length
            cause = cause or (_LEFT if near else "the integration does not get on")
            raise EngineFailure(self.time, cause, "try a slower crank, a stiffer or longer follower or a smaller engine.tolerance", table)
        return table

    def _row(self, at: float, state: Array) -> dict[str, float]:
        n, who = len(state) // 2, f"row() of {type(self.model).__name__}"
        row = {**self.model.row(at, state[:n], state[n:]), "time": at}
        if missing := [name for name in REQUIRED if name not in row]:
            raise EngineFailure(at, f"{who} lacks {', '.join(missing)}", f"it gives {', '.join(row)}")
        for name, value in row.items():
            if name not in COLUMNS:
                raise EngineFailure(at, f"{who} gives {name}, which is no column", f"accepted: {', '.join(COLUMNS)}")
            if np.ndim(value) or np.iscomplexobj(value):
                raise EngineFailure(at, f"{name} in {who} is {value!r}", "give one real number")
        return {name: float(value) for name, value in row.items()}
