"""The interface of an engine, and the errors by which it reports what it cannot do.

An engine turns a `Mechanism` into motion. `prepare` builds the model and returns a `Simulation` that is advanced piece by piece, so
that a run can approach the steady state cycle by cycle. `natural_frequencies` belongs to the frozen crank. An engine refuses what it
cannot model with a sentence (`Refusal`); a run that breaks down raises `EngineFailure` with time, cause, advice and the part computed.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Final, Generic, Literal, TypeVar, get_args

import numpy as np

from quickreturn.engines.settings import Settings as AnySettings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import FollowerTrajectory, Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.errors import EngineTrouble, ToldError
from quickreturn.reference_model.mechanism import Mechanism, MotorCurve, PrescribedSpeed, Scene
from quickreturn.reference_model.rigid import mean_crank_speed
from quickreturn.reference_model.scene_values import NAMED, values_of

S = TypeVar("S", bound=AnySettings)
#: A scene that an engine models: a `Mechanism`; for an engine that names `SPIN_UP` any `Scene`.
ModelledScene = Any
#: A `Start`; None for a follower alone, which begins straight and at rest.
StartOfScene = Any

#: Version of the engines' interface. It changes when an engine written for the version before would no longer work.
INTERFACE: Final = 1

#: Accuracies whose settings make up an engine's ladder: ten in a decade, so that no rung is passed over.
LADDER_ACCURACIES: Final = tuple(float(accuracy) for accuracy in np.geomspace(0.5, 2e-5, 45))

#: The error that an engine estimates. "total": from the solution of the scene, so that other engines can be judged by it. "integration":
#: from the solution of the engine's own equations, whose discretization is its model; the error of that model is not estimated.
#: "unverified": from the solution of the scene, but nobody has measured whether the estimate holds.
EstimateOf = Literal["total", "integration", "unverified"]
ESTIMATES: Final[tuple[EstimateOf, ...]] = get_args(EstimateOf)


class Refusal(ToldError):
    """A scene feature or setting that an engine cannot model; the text is one sentence naming the key and what is accepted."""


@dataclass(eq=False, repr=False)
class EngineFailure(EngineTrouble):
    """A run that broke down.

    Attributes:
        time: last good instant, s since the start of the simulation.
        cause: what happened, a clause.
        advice: what to try, a clause.
        partial: the trajectory up to `time`, or None.
    """

    time: float
    cause: str
    advice: str
    partial: Trajectory | FollowerTrajectory | None = None

    def __post_init__(self) -> None:
        super().__init__(f"failed at t = {self.time:.6g} s: {self.cause}; {self.advice}")

    def __reduce__(self) -> tuple[type, tuple[float, str, str, Trajectory | None]]:
        return type(self), (self.time, self.cause, self.advice, self.partial)


@dataclass(frozen=True)
class ModelDescription:
    """What an engine builds for a scene: one line per body and joint, and the number of degrees of freedom it integrates; None: unknown."""

    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    degrees_of_freedom: int | None


class Simulation(ABC):
    """A prepared model at an instant; `advance` moves it on.

    Attributes:
        setup_seconds: wall time spent building the model, without compilation.
        time: s since the start.
    """

    setup_seconds: float
    time: float

    def present_start(self) -> Start | None:
        """The present state as a start for any engine; None if the simulation cannot give one."""
        return None

    @abstractmethod
    def advance(self, duration: float, output_step: float) -> Trajectory:
        """Continue the simulation by `duration` (s, a multiple of `output_step`).

        Returns:
            The trajectory on the grid `time + k output_step`, k = 0 .. duration/output_step: the first row is the present
            instant (so consecutive pieces share one row), the last is the new one. `Trajectory.solve_seconds` is the wall time
            from the prepared model to the finished table.

        Raises:
            EngineFailure: the run broke down; the simulation must not be advanced again.
        """


@dataclass(frozen=True)
class Comparison:
    """Two runs whose difference D shows a part of an error: that part is D / abs(factor - 1) in `run`.

    Attributes:
        run: settings whose error is judged: those of the delivered run, or of one with the same error in this part.
        other: settings of the run that `run` is compared with.
        factor: this part of the error of `other` over that of `run`; below 1 if `other` is the finer one.
        before: the comparison of `other` with a run that is coarser still, or finer still if `other` is the finer one. It checks
            `factor`: if the differences fall more slowly than both factors say, the factor that they show counts
            (`engines.error_parts.shown_factor`). None: `factor` is taken on trust.
        instead: the comparison to make if a run of this one breaks down, for example with finer runs. None: the error is then unknown.
        besides: another pair that shows the same part, because this one's two runs may by accident have the same error. The larger of the
            two counts.
        alike: `before` is not run, and `factor` is taken on trust, if the relative difference between `run` and `other` is in no
            estimated column more than this many times that in the tip deflection. 0: `before` is always run.
        of: what the part of the error comes from, in a word: "time", "space", "modes", "spring", "slowing". Comparisons may share one.
    """

    run: AnySettings
    other: AnySettings
    factor: float
    before: "Comparison | None" = None
    instead: "Comparison | None" = None
    besides: "Comparison | None" = None
    alike: float = 0.0
    of: str = "resolution"


class NoSteadyState(Exception):
    """An engine's direct search for the steady state ended without one; the text is a clause that says why."""


@dataclass(frozen=True)
class SteadyState:
    """A periodic steady state that an engine found by a direct search.

    Attributes:
        simulation: a simulation in the steady state, with the slider at its farthest place, at time 0.
        period: s; its relative error is below the residual.
        multipliers: Floquet multipliers, the factors by which small disturbances change in a cycle, largest modulus first; those that
            are nearly zero may be missing.
        stable: whether disturbances die away; simulated cycles approach only such a state.
        iterations: number of steps of the search.
        cycles_of_work: cost of the search over that of simulating one cycle.
        residual: distance from exact repetition, relative to the motion.
        solve_seconds: wall time of the search, from the prepared model.
    """

    simulation: Simulation
    period: float
    multipliers: tuple[complex, ...]
    stable: bool
    iterations: int
    cycles_of_work: float
    residual: float
    solve_seconds: float


#: The quantity that an engine names if it also models the follower alone, on a base that turns as prescribed.
SPIN_UP: Final = "base.spin_up_speed"


class Engine(ABC, Generic[S]):
    """One way of simulating the mechanism. Instances carry no state; everything about a run is in its settings."""

    name: str  # as typed on the command line
    method: str  # one line, for `quickreturn engines` and the report
    interface: int = INTERFACE  # version that the engine is written for; state it as a number
    compiles: bool = False  # whether code is compiled or loaded on first use, which must not count as setup or solve time
    default_accuracy: float  # error of the tip deflection that the default settings aim at
    estimates: EstimateOf = "total"  # the error that it estimates
    begins_bent: bool = True  # whether a run can begin with a bent follower, as one from the periodic state of `reference` does
    quantities: tuple[str, ...] = ()  # `section.key` of those quantities in `scene_values.NAMED` that the model has
    settings_type: type[S]

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if unknown := [name for name in cls.quantities if name not in NAMED]:
            raise TypeError(f"{cls.__name__}.quantities: {', '.join(unknown)}: not known; accepted: {', '.join(NAMED)}")

    def __repr__(self) -> str:
        return f"{self.name}: {self.method}"

    def check(self, scene: Scene, /) -> None:
        """Refuse what `quantities` does not name. It is called before anything is built; an override may refuse more.

        Raises:
            Refusal: a feature of the scene that the engine does not have.
        """
        for section, values in values_of(scene).items():
            for key, value in values.items():
                name = f"{section}.{key}"
                if (quantity := NAMED.get(name)) is not None and value != quantity.default and name not in self.quantities:
                    accepted = _accepted_instead(scene, name) if quantity.default is None else quantity.default
                    given = f"{value} {quantity.unit}" if quantity.unit != "1" and not quantity.in_file else f"{value}"
                    raise Refusal(f"{name}: {given} is not modelled by engine {self.name}; accepted: {accepted}")

    @abstractmethod
    def describe(self, scene: ModelledScene, settings: S, /) -> ModelDescription:
        """Bodies, joints and degrees of freedom that `prepare` builds for this scene with these settings."""

    @abstractmethod
    def settings_for(self, accuracy: float, scene: ModelledScene, /) -> S:
        """Settings to begin with for an error of the tip deflection of `accuracy`; the run's own estimate decides whether they suffice."""

    @abstractmethod
    def comparisons(self, settings: S, scene: ModelledScene, output_step: float, /) -> tuple[Comparison, ...]:
        """Pairs of runs that show the parts of the error of `settings`, one pair per part; the estimate is the parts' sum.

        Parts that may have opposite signs (space and time, say) need a pair each: in a run that is coarser in both they could cancel.
        `output_step` (s) bounds the time steps of most engines.
        """

    def first_row(self, scene: ModelledScene, start: StartOfScene, settings: S, place: float, /) -> Trajectory | None:
        """The first row of a run from `start` as finely as the engine gives it, the slider at `place` (m); None: as the run gives it.

        Where a load acts suddenly on a straight follower, accelerations and forces of this row converge far more slowly than the motion:
        two runs may agree in it while both are far off.
        """
        return None

    @abstractmethod
    def finer(self, settings: S, excess: Mapping[str, float], output_step: float, /) -> S | None:
        """The next finer settings, for when the estimate misses the accuracy asked; None at the end of the ladder.

        `excess` holds the parts of the estimate over the accuracy asked, by `Comparison.of`; it is empty if unknown.
        """

    @abstractmethod
    def prepare(self, scene: ModelledScene, start: StartOfScene, settings: S, /) -> Simulation:
        """Build the model in the state `start` (see `Start` for its meaning).

        Raises:
            Refusal: a feature or setting that cannot be modelled.
            EngineFailure: the start cannot be reached (time 0).
        """

    @abstractmethod
    def version(self) -> str:
        """Name and version of the library behind the engine, e.g. 'exudyn 1.13.6'."""

    def unavailable(self) -> str | None:
        """Why the engine cannot be used on this machine (a sentence), or None if it can."""
        return None

    def ladder(self, mechanism: Mechanism) -> tuple[S, ...]:
        """Settings from coarse to fine for a benchmark of speed against error: those for `LADDER_ACCURACIES`, each once."""
        return tuple(dict.fromkeys(self.settings_for(accuracy, mechanism) for accuracy in LADDER_ACCURACIES))

    def steady_state(self, mechanism: Mechanism, start: Start, settings: S, near: SteadyState | None = None) -> SteadyState | None:
        """The periodic steady state, by a direct search that begins in `start`; None (the default) if the engine has no such search.

        `near` is a state that this engine found for a neighbouring scene or with other settings; the search may begin there instead.

        Raises:
            Refusal: as `prepare`.
            EngineFailure: as `prepare`.
            NoSteadyState: the search did not converge.
        """
        return None

    @abstractmethod
    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: S) -> Array:
        """Lowest natural frequencies in Hz, ascending, with the crank held at `crank_angle` (rad).

        Follower straight, at rest, no gravity, undamped. Fewer than `count` if the model has fewer; shape (<= count,).
        """


def _accepted_instead(scene: Scene, name: str) -> str:
    """What to give in place of a quantity that a model lacks and that has no default: a quantity of the drive, or a table."""
    if name.startswith("tip."):
        return "tip.force"
    if scene.crank is None:
        return "a scene with [crank]"
    if isinstance(scene.crank.drive, PrescribedSpeed | MotorCurve):
        return "crank.torque and crank.damping"
    return f'crank.prescribed_speed, such as the mean speed "{mean_crank_speed(scene):.6g} rad/s"'


def first_line(error: BaseException) -> str:
    """The first line of an exception's message."""
    return (str(error).splitlines() or ["no message"])[0]


def installed(*distributions: str) -> str | None:
    """Version of the first of these distributions that is installed; None if none is."""
    for distribution in distributions:
        with suppress(PackageNotFoundError):
            return version(distribution)
    return None


def too_old(package: str, found: str, oldest: tuple[int, ...]) -> str | None:
    """A sentence if this version of a package is older than the oldest that works, else None."""
    if tuple(int(part) for part in found.split(".")[: len(oldest)] if part.isdigit()) >= oldest:
        return None
    return f"{package} {found} is installed, {'.'.join(map(str, oldest))} or later is needed"


#: Quantities that the engines of this project model, whatever the slider's joint.
USUAL: Final[tuple[str, ...]] = (
    "mechanism.gravity", "crank.torque", "crank.prescribed_speed", "base.damping", "follower.damping", "tip.center_of_mass", "tip.force",
    "slider.mass",
)  # fmt: skip
#: A spring from the follower to a fixed point.
HELD: Final[tuple[str, ...]] = ("spring.stiffness", "spring.preload", "spring.damping", "spring.stop_stiffness")
#: A compliant joint that is one linear spring.
SPRING: Final[tuple[str, ...]] = ("slider.joint_stiffness", "slider.joint_damping")
#: A compliant joint of two rollers.
ROLLERS: Final[tuple[str, ...]] = (
    *SPRING, "slider.joint_stiffness_plus", "slider.joint_stiffness_minus", "slider.clearance", "slider.preload", "slider.contact_damping",
)  # fmt: skip
#: Tables of the drive: a motor's curve, and a speed over time or over the turn.
DRIVEN: Final[tuple[str, ...]] = ("crank.torque_table", "crank.speed_table")
#: Forces of a tool but a constant one, and the friction of its slide.
TOOL: Final[tuple[str, ...]] = ("tip.force_following", "tip.force_table", "tip.friction_force")
#: Friction along the follower and in its pivot.
FRICTION: Final[tuple[str, ...]] = ("slider.friction", "slider.friction_force", "base.friction_torque")

#: An engine with any settings.
AnyEngine = Engine[Any]
