"""A base for simple engines: one resolution, and an error of known order.

An author writes a `Model`, with the state at the start, the accelerations and a row of output, and a `SimpleEngine`, with the order of
the error and the quantities that the model has. Grid, integration, ladder, error estimate, refusals, failures, version and natural
frequencies follow. An engine that needs more derives from `engines.base.Engine`.
"""

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Final, Self, TypeVar

import numpy as np
from scipy.integrate import Radau

from quickreturn.engines.base import Comparison, Engine, EngineFailure, ModelDescription, Refusal, Simulation, installed
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.settings import SettingError, Settings, setting
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import REQUIRED, Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.scene_values import FORCES, OF_TORQUE, changed

R = TypeVar("R", bound=Settings)

#: Factor on the resolution for the run that the error is estimated with.
_FINER: Final = 1.5


class OneResolution(Engine[R]):
    """An engine whose settings have a `resolution`: number of links, elements, shapes."""

    #: Attributes that an engine's class states.
    needed: ClassVar[tuple[str, ...]] = ("name", "method", "library", "errors", "order")
    #: Distribution whose version is the engine's.
    library: ClassVar[str]
    #: Resolution -> measured error, coarse to fine: the resolutions of the ladder.
    errors: ClassVar[Mapping[int, float]]
    #: Order of the error in the resolution, for the column that converges most slowly.
    order: ClassVar[float]

    def __new__(cls) -> Self:
        """Raises TypeError: the class lacks attributes that every engine needs."""
        if missing := [name for name in cls.needed if not hasattr(cls, name)]:
            raise TypeError(f"class {cls.__name__} lacks {', '.join(missing)}; docs/engine.md says what each of them is")
        return super().__new__(cls)

    def version(self) -> str:
        return f"{self.library} {installed(self.library) or 'not installed'}"

    def unavailable(self) -> str | None:
        return None if installed(self.library) else f"the package {self.library} is not installed"

    def _rung(self, resolution: int, error: float) -> R:
        """Settings with a resolution, in whose error others must not show."""
        return self.settings_type(resolution=resolution)  # type: ignore[call-arg]

    def _refined(self, settings: R, resolution: int, factor: float) -> R:
        """The settings with a higher resolution, whose error is smaller by `factor`."""
        return settings.replaced(resolution=resolution)

    def _ladder(self) -> Ladder[R]:
        return Ladder(tuple((self._rung(size, error), error) for size, error in self.errors.items()), "resolution", order=self.order)

    def settings_for(self, accuracy: float, scene: Scene) -> R:
        return self._ladder().pick(accuracy)

    def comparisons(self, settings: R, scene: Scene, output_step: float) -> tuple[Comparison, ...]:
        """A run of 1.5 times the resolution."""
        resolution: int = settings.resolution  # type: ignore[attr-defined]
        more = math.ceil(_FINER * resolution)
        factor = (resolution / more) ** self.order
        return (Comparison(settings, self._refined(settings, more, factor), factor),)

    def finer(self, settings: R, excess: Mapping[str, float], output_step: float) -> R | None:
        return self._ladder().finer(settings, excess)

    def _not_too_coarse(self, resolution: int) -> None:
        """Raise SettingError for a resolution that is coarser than any that was measured."""
        if resolution < (coarsest := min(self.errors)):
            raise SettingError(f"engine.resolution: {resolution} is not accepted; engine {self.name} begins with {coarsest}")


#: Integration tolerance over the error of a resolution, and its loosest and tightest value. At 1e-5 the integration alone makes an error of
#: 7e-4 with ten polynomials for the tangent's angle in a mild scene; in run 24 (3.8e-3) and with four (3.7e-3) it does not show.
_TOLERANCE_PER_ERROR: Final = 5e-4
_LOOSEST, _TIGHTEST = 1e-5, 1e-12
#: Displacement (rad or m) of a coordinate for the stiffness by differences.
_DISPLACEMENT: Final = 1e-5
#: Inertia (kg m^2) of a crank that is too heavy to move.
_HEAVY: Final = 1e4
#: Fraction of the largest squared angular frequency below which a square is round-off.
_ROUND_OFF: Final = 1e-10
#: Fraction of the follower's length: if the integration stops with the slider beyond it, the slider has left the follower.
_NEAR_END: Final = 0.97
_LEFT: Final = "the slider has left the follower's end"


@dataclass(frozen=True, kw_only=True)
class SimpleSettings(Settings):
    """Resolution, and tolerance of the integration."""

    resolution: int = setting(8, "number of links, elements, shapes: what the engine's method says", low=1, high=1000)
    tolerance: float = setting(1e-5, "local error of the integration, relative and in the state's units", low=_TIGHTEST, high=1e-2)


class Model(ABC):
    """A scene's equations of motion.

    Attributes:
        state: n coordinates, then their n speeds, at the start, shape (2n,); of order one in SI units, as angles are.
    """

    state: Array

    @abstractmethod
    def __init__(self, mechanism: Mechanism, start: Start, resolution: int) -> None:
        """Build the equations and set `state`; `engines.start_state.reconstruct` gives place and velocity of every point at the start."""

    @abstractmethod
    def accelerations(self, time: float, coordinates: Array, speeds: Array) -> Array:
        """Second derivatives of the coordinates, shape (n,); NaN for an impossible trial state, after which a shorter step is tried."""

    @abstractmethod
    def row(self, time: float, coordinates: Array, speeds: Array) -> Mapping[str, float]:
        """The columns of `reference_model.columns` at an instant: all required ones except the time, and any others."""

    def states(self, times: Array, state: Array, tolerance: float) -> Iterator[Array]:
        """The state at each of `times` (s, shape (m,)), the first of which is that of `state`; fewer if the integration stops early.

        The accelerations are integrated by Radau's method (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8), whose
        steps follow the motion and not the fastest vibration of a fine model. An engine with an integrator of its own overrides this.
        """
        n, latest = len(state) // 2, state

        def rates(at: float, y: Array) -> Array:
            nonlocal latest
            accelerations = np.asarray(self.accelerations(at, y[:n], y[n:]))
            if accelerations.shape != (n,):
                cause = f"accelerations() of {type(self).__name__} has the shape {accelerations.shape}"
                raise EngineFailure(at, cause, f"the state of {len(state)} numbers needs ({n},)")
            latest = np.concatenate([y[n:], accelerations])
            return latest

        yield state
        solver, done = Radau(rates, times[0], state, times[-1], rtol=tolerance, atol=tolerance), 1
        while solver.status == "running":
            try:
                solver.step()
            except ValueError:  # the solver raises it for a matrix with NaN
                if np.isfinite(latest).all():
                    raise
                return
            if solver.status == "failed":
                return
            reached = int(np.searchsorted(times, solver.t, side="right"))
            yield from solver.dense_output()(times[done:reached]).T
            done = reached


class SimpleEngine(OneResolution[SimpleSettings]):
    """An engine with one resolution. Its `errors` are those of the tip deflection in the first 2 s of run 24."""

    needed = ("name", "method", "model", "library", "errors", "order")
    settings_type = SimpleSettings
    default_accuracy = 0.05
    model: ClassVar[type[Model]]

    def check(self, scene: Scene) -> None:
        """Refuse what `quantities` does not name, and a rigid follower."""
        super().check(scene)
        if scene.follower.is_rigid:
            raise Refusal(f"follower.bending_stiffness: inf N*m^2 is not modelled by engine {self.name}; accepted: a finite stiffness")

    def describe(self, mechanism: Mechanism, settings: SimpleSettings) -> ModelDescription:
        """Bodies by the scene, degrees of freedom by the state."""
        self.check(mechanism)
        free = len(self.model(mechanism, standard_start(mechanism), settings.resolution).state) // 2
        bodies = ("crank", f"follower, resolution {settings.resolution}", *(["tip body"] if mechanism.tip else []))
        return ModelDescription(bodies, ("crank pivot", "follower pivot", "slider on the follower"), free)

    def _rung(self, resolution: int, error: float) -> SimpleSettings:
        return SimpleSettings(resolution=resolution, tolerance=float(np.clip(_TOLERANCE_PER_ERROR * error, _TIGHTEST, _LOOSEST)))

    def _refined(self, settings: SimpleSettings, resolution: int, factor: float) -> SimpleSettings:
        """With a tolerance that falls like the error."""
        return SimpleSettings(resolution=resolution, tolerance=max(_TIGHTEST, factor * settings.tolerance))

    def _ladder(self) -> Ladder[SimpleSettings]:
        return replace(super()._ladder(), tolerance="tolerance")

    def prepare(self, mechanism: Mechanism, start: Start, settings: SimpleSettings) -> Simulation:
        """See `Engine.prepare`; SettingError: a resolution that is coarser than any that was measured."""
        self.check(mechanism)
        self._not_too_coarse(settings.resolution)
        began = time.perf_counter()
        model = self.model(mechanism, start, settings.resolution)
        return _SimpleSimulation(model, mechanism.follower.length, settings.tolerance, time.perf_counter() - began)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: SimpleSettings) -> Array:
        """From differences of the accelerations about the straight follower at rest, with a crank too heavy to move."""
        self.check(mechanism)
        free = "crank.torque" in self.quantities
        at_rest = dict.fromkeys(OF_TORQUE if free else ("crank.prescribed_speed",), 0.0)
        still = changed(mechanism, {**at_rest, **dict.fromkeys(("mechanism.gravity", *FORCES)), "crank.inertia": _HEAVY})
        model = self.model(still, Start(crank_angle, 0.0), settings.resolution)
        rest = model.state[: len(model.state) // 2]
        moved = np.concatenate([rest - _DISPLACEMENT * np.eye(len(rest)), rest + _DISPLACEMENT * np.eye(len(rest))])
        back, forth = np.split(np.array([model.accelerations(0.0, q, 0.0 * rest) for q in moved]), 2)
        squares = np.sort(np.linalg.eigvals((back - forth).T / (2.0 * _DISPLACEMENT)).real)
        frequencies: Array = np.sqrt(squares[squares > _ROUND_OFF * squares[-1]]) / (2.0 * math.pi)
        return frequencies[:count]


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
            if (infinite := next((name for name, value in row.items() if not math.isfinite(value)), None)) is not None:
                cause = f"the motion explodes, {infinite} is {row[infinite]}"
            elif row["slider_position"] > self.length:
                cause = _LEFT
            if cause:
                break
            rows.append(row)
            self.time, self.state = float(at), state
        columns = {name: np.array([row[name] for row in rows]) for name in (rows[0] if rows else ())}
        table = Trajectory(columns, time.perf_counter() - began) if rows else None
        if table is None or len(rows) < len(times):
            near = rows and rows[-1]["slider_position"] > _NEAR_END * self.length
            cause = cause or (_LEFT if near else "the integration does not get on")
            raise EngineFailure(self.time, cause, "try a slower crank, a stiffer or longer follower or a smaller engine.tolerance", table)
        return table

    def _row(self, at: float, state: Array) -> dict[str, float]:
        """The model's row, checked. Raises EngineFailure: columns are missing or unknown, or a value is no real number."""
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
