"""The engine `reference`: pseudo-coordinates with shapes that follow the slider, converged.

`engines/LADDERS.md`, section 1, has the measurements behind its numbers.
"""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Self, TypeVar

from quickreturn.engines import refusals
from quickreturn.engines.base import DRIVEN, FRICTION, HELD, ROLLERS, SPIN_UP, TOOL, USUAL, Comparison, NoSteadyState, SteadyState
from quickreturn.engines.ladder import Ladder, fitted
from quickreturn.engines.own.beam_engine import (
    EXPLICIT,
    IMPLICIT,
    LEAST_TOLERANCE,
    BeamEngine,
    BeamSettings,
    compared_integration,
    compared_slowing,
    integrator,
    state_of,
    tolerance,
)
from quickreturn.engines.settings import setting
from quickreturn.engines.start import Start
from quickreturn.reference_model import joint
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.beam.modes import needs_base_shape
from quickreturn.reference_model.constants import unslowed
from quickreturn.reference_model.joint import CLOSED, MULTIPLIER, SliderConstraint, friction_in_words, joint_in_words, rollers
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.natural_modes import frozen_crank_modes, stiffness_ratio
from quickreturn.reference_model.rigid import crank_pace
from quickreturn.reference_model.scene_values import changed
from quickreturn.reference_model.state import State

if TYPE_CHECKING:
    from quickreturn.engines.own.simulation import FoundOrbit
    from quickreturn.engines.trajectory import Trajectory
    from quickreturn.reference_model.model import BeamModel

#: Modes -> modes of the finer run for the error estimate, and its error over that of the run. Beside one mode none of them is slowed.
COMPARED: Final = {1: (4, 0.2), 2: (5, 0.5), 3: (6, 0.25), 4: (7, 0.2)}
#: Relative change of the lowest frequency's square by a compliant joint, above which the joint's own vibration is not slowed.
SOFT_JOINT: Final = 5e-4
#: Error by slowing the joint's vibration, over the error of the modes.
ERROR_OF_SLOWING: Final = 5e-3
#: Smallest number of modes if rollers strike the follower: blows excite more modes than the crank does.
MODES_OF_BLOWS: Final = 7
#: Value of `blow` above which a roller strikes the follower: 0.07 was measured to need no more modes than a rigid joint, 0.6 needs more
#: (`engines/LADDERS.md`, section 5).
LEAST_BLOW: Final = 0.1
#: Smallest frequency of a slowed mode over that of a blow (`engines/LADDERS.md`, section 1).
BLOW_RESOLVED: Final = 5.0
#: Largest tolerance of a finer run over that of the run: a tenth shows the integration's error. Where rollers touch and part it is the
#: ratio itself, because there more modes need no smaller tolerance.
TENTH: Final = 0.1
#: Rate (1/s) at which numerical errors of the gap decay in a rigid joint with friction.
STABILIZATION: Final = 100.0
#: Error with two more modes over the error without.
RATIO: Final = 0.25
#: Largest number of modes; a run with as many is compared with one of two fewer.
MOST_MODES: Final = 16
#: Most modes of a run whose first row is compared with that of the most modes: they must show a part of what is lacking.
MODES_COMPARED_AT_START: Final = 12
#: Number of modes from which on the error falls smoothly, and the largest ratio of errors then stated for two more modes; below, `RATIO`.
MODES_WITH_ORDER: Final = 4
SLOWEST_RATIO: Final = 0.5
#: `stiffness_ratio` below which no mode is slowed, because the motion needs the higher modes. In run 24 (4.1) slowing costs nothing; with a
#: tenth of its stiffness (1.3) the error is ten times as large (`engines/LADDERS.md`, section 1).
SOFT_FOLLOWER: Final = 3.0
#: `stiffness_ratio` below which an accuracy of 1 % takes so many modes that implicit steps are cheaper (`engines/LADDERS.md`, section 1).
VERY_SOFT_FOLLOWER: Final = 1.9
#: `stiffness_ratio` of run 24 with a tenth of its stiffness, on which the ladder of soft followers was measured; and the power with which
#: the error is taken to fall with this ratio, to begin near the rung that suffices (`engines/LADDERS.md`, section 1).
RATIO_OF_VERY_SOFT: Final = 1.3
POWER_OF_VERY_SOFT: Final = 3.0
#: Modes -> `Comparison.alike`; 0 for other numbers of modes, and for modes as they are, which follow where slowed ones were not enough.
ALIKE_WITHIN: Final = {1: 4.0, 2: 4.0, 4: 2.0}
#: Length of the last step of the search for a periodic motion, relative to the motion. A tenth of it or less is left, which counts as
#: settled in a simulation from cycle to cycle.
ORBIT_TOLERANCE: Final = 1e-3
#: Loosest tolerance of the integration in that search. At 1e-4 the implicit one finds multipliers of soft followers wrong by up to 6e-3, at
#: 1e-5 by 2e-4.
ORBIT_INTEGRATION: Final = 1e-5


R = TypeVar("R", bound="ReferenceSettings")


@dataclass(frozen=True, kw_only=True)
class ReferenceSettings(BeamSettings):
    """Settings of `reference`."""

    modes: int = setting(5, "modes of the beam supported at the slider", low=1, high=MOST_MODES)
    tolerance: float = tolerance(1e-7)
    integrator: str = integrator(EXPLICIT)

    @property
    def shape_count(self) -> int:
        return self.modes

    def with_texts(self, texts: dict[str, str]) -> Self:
        """See `Settings.with_texts`; unless they are given, too, slowed modes and a tolerance to match come with modes and integrator."""
        changed = super().with_texts(texts)
        if self.slowed_to and "modes" in texts and "slowed_to" not in texts:
            changed = slowed(changed)
        if changed.integrator != self.integrator and "tolerance" not in texts:
            changed = changed.replaced(tolerance=ladder_of(changed).rung(changed.modes).tolerance)
        return changed


#: Modes; integration tolerance explicit with added inertia, explicit without, implicit without; and error of the tip deflection over 2 s in
#: run 24, and with a tenth of its stiffness.
_RUNGS: Final = (
    (1, 1e-5, 1e-5, 1e-4, 2.7e-2, 1.2),
    (2, 1e-5, 1e-5, 1e-4, 1.5e-3, 0.97),
    (4, 1e-5, 3e-7, 1e-4, 8e-4, 2.8e-2),
    (5, 1e-5, 1e-7, 1e-4, 4.9e-4, 1.8e-2),
    (6, 3e-6, 1e-7, 1e-4, 2.3e-4, 8.5e-3),
    (7, 3e-6, 1e-8, 3e-5, 8.2e-5, 3.7e-3),
    (8, 1e-6, 1e-8, 1e-5, 3.5e-5, 1.2e-3),
    (9, 1e-6, 3e-9, 1e-5, 1.5e-5, 4.4e-4),
    (11, 1e-7, 1e-9, 1e-6, 4e-6, 8.8e-5),
)


def slowed(settings: R) -> R:
    """The settings with the higher half of the modes slowed."""
    return settings.replaced(slowed_to=unslowed(settings.modes))


def _ladder(tolerated: int, error: int, integrates: str = EXPLICIT) -> Ladder[ReferenceSettings]:
    """The rungs, with tolerance and error in two columns of `_RUNGS`."""
    rungs = ((ReferenceSettings(modes=rung[0], tolerance=rung[tolerated], integrator=integrates), rung[error]) for rung in _RUNGS)
    return Ladder(tuple(rungs), "modes", "tolerance")


#: Ladders for modes of which the higher half is slowed, and for modes as they are: runs begin on the first and climb to the second; and for
#: modes as they are where none can be slowed.
SLOWED, AS_THEY_ARE, IMPLICITLY = _ladder(1, 4), _ladder(2, 4), _ladder(3, 5, IMPLICIT)


def ladder_of(settings: ReferenceSettings) -> Ladder[ReferenceSettings]:
    """The ladder that settings belong to."""
    if settings.slowed_to:
        return SLOWED
    return IMPLICITLY if settings.integrator == IMPLICIT else AS_THEY_ARE


class ReferenceEngine(BeamEngine[ReferenceSettings]):
    """Modes of the beam supported where the slider is, projected on the free speeds; observables recovered from equilibrium."""

    name = "reference"
    method = "pseudo-coordinate, shapes that follow the slider, exact planar geometry, equilibrium recovery, compiled DOP853"
    default_accuracy = 1e-3
    settings_type = ReferenceSettings
    kind_of_shapes = "shapes that follow the slider"
    kind_of_clamped_shapes = "clamped modes"
    quantities = (*USUAL, *DRIVEN, *TOOL, *HELD, "slider.inertia", *ROLLERS, *FRICTION, "follower.material_damping", SPIN_UP)

    def check(self, scene: Scene) -> None:
        """Refuse also parts without mass, if the slider's joint is compliant or has friction."""
        super().check(scene)
        if self.opens_loop(scene):
            refusals.of_massless_parts(self.name, scene, " with a joint that gives way or rubs, which leaves the follower to itself")

    def opens_loop(self, scene: Scene) -> bool:
        """With a compliant joint, which leaves the follower's angle free, or with friction, which needs the normal force."""
        return not scene.slider.is_rigid or scene.slider.has_friction

    def model(self, scene: Scene, settings: ReferenceSettings, at: float | None = None) -> "BeamModel":
        """See `BeamEngine.model`; the slider is eliminated unless its joint is compliant or has friction.

        The follower alone has modes of the beam clamped at its base: with five the error in the library's spin-up is 6e-5. `at`: see
        `BeamModel.following`.
        """
        from quickreturn.reference_model.model import BeamModel

        constraint = CLOSED
        if not scene.slider.is_rigid:
            inertia = joint_inertia(scene, settings.modes) if scene.slider.is_linear else 0.0
            constraint = SliderConstraint(kind=joint.ROLLERS, rollers=rollers(scene.slider), inertia=inertia)
        elif scene.slider.has_friction:
            constraint = SliderConstraint(kind=MULTIPLIER, stabilization=STABILIZATION)
        above = BLOW_RESOLVED * rate_of_blow(scene) if scene.slider.has_corners else 0.0
        return BeamModel.following(scene, settings.modes, constraint, slowed_to=settings.slowed_to, slowed_above=above, at=at)

    def joint_line(self, scene: Scene, settings: ReferenceSettings) -> str:
        """Rigid, compliant or with friction."""
        slider = scene.slider
        if not slider.is_rigid:
            line = f"slider beside the centre line ({joint_in_words(slider)})"
        else:
            line = "slider on the centre line (Lagrange multiplier)" if slider.has_friction else super().joint_line(scene, settings)
        return line + friction_in_words(slider)

    def settings_for(self, accuracy: float, scene: Scene) -> ReferenceSettings:
        """Number of modes from the measured table; fewer for a stiffer follower than run 24's, more where rollers strike it.

        None is slowed of a soft follower, whose motion needs the higher modes; nor where a shape carries the moment at the base: with an
        added inertia it would carry a sudden one too late. The integration is implicit there, and of a very soft follower.
        """
        if not scene.slider.has_corners:
            ratio = stiffness_ratio(scene)
            if 0.0 < ratio < VERY_SOFT_FOLLOWER:
                return IMPLICITLY.pick(accuracy, min((RATIO_OF_VERY_SOFT / ratio) ** POWER_OF_VERY_SOFT, 1.0))
            if scene.crank is not None and needs_base_shape(scene):
                return IMPLICITLY.rung(fitted(AS_THEY_ARE, accuracy, scene).modes)
            is_slowed = scene.crank is not None and not 0.0 < ratio < SOFT_FOLLOWER
            return slowed(fitted(SLOWED, accuracy, scene)) if is_slowed else fitted(AS_THEY_ARE, accuracy, scene)
        if blow(scene) <= LEAST_BLOW:
            return slowed(fitted(AS_THEY_ARE, accuracy, scene))
        usual = AS_THEY_ARE.pick(accuracy)
        return slowed(usual.replaced(modes=max(usual.modes, MODES_OF_BLOWS)))

    def comparisons(self, settings: ReferenceSettings, scene: Scene, output_step: float) -> tuple[Comparison, ...]:
        """A run with more modes and a tolerance to match, which shows the errors of truncation and integration together.

        A run with still more modes checks whether the error falls as stated. It does not after a blow, which excites all modes; the
        relative difference is then larger in accelerations than in the deflection. With clamped modes the error of the deflection falls
        faster than stated, so that its estimate is a little too large.
        """
        ladder = ladder_of(settings)
        less_slowed = settings.slowed_to >= unslowed(settings.modes)  # with more modes, whose error includes that by slowing
        others = () if less_slowed else compared_slowing(settings)
        if settings.modes + 2 > MOST_MODES:
            if settings.integrator == IMPLICIT:
                others = (*others, *compared_integration(settings))
            fewer = ladder.sized(settings, settings.modes - 2)
            return (Comparison(settings, slowed(fewer) if less_slowed else fewer, 1.0 / RATIO, of="modes"), *others)

        def sized(run: ReferenceSettings, modes: int) -> ReferenceSettings:
            usual, tenth = ladder.sized(run, modes), max(TENTH * run.tolerance, LEAST_TOLERANCE)
            if settings.modes == 1:  # slowed modes may err as much as modes left out
                usual = usual.replaced(slowed_to=0)
            elif less_slowed:
                usual = slowed(usual)
            return usual.replaced(tolerance=tenth if scene.slider.has_corners else min(usual.tolerance, tenth))

        measured = COMPARED if scene.crank is not None else {}
        more, ratio = measured.get(settings.modes, (settings.modes + 2, RATIO))
        finer, further = sized(settings, more), None
        if more + 2 <= MOST_MODES:
            further = Comparison(finer, sized(finer, more + 2), RATIO if settings.modes < MODES_WITH_ORDER else SLOWEST_RATIO, of="modes")
        alike = ALIKE_WITHIN.get(settings.modes, 0.0) if settings.slowed_to else 0.0
        return (Comparison(settings, finer, ratio, further, alike=alike, of="modes"), *others)

    def first_row(self, scene: Scene, start: Start | None, settings: ReferenceSettings, place: float) -> "Trajectory | None":
        """See `Engine.first_row`: with the most modes, in tables about the slider's place."""
        if scene.crank is None or scene.follower.is_rigid or settings.modes > MODES_COMPARED_AT_START:
            return None
        from quickreturn.engines.own.simulation import OwnSimulation

        model = self.model(scene, settings.replaced(modes=MOST_MODES, slowed_to=0), place)
        return OwnSimulation(model, state_of(model, scene, start), settings.tolerance, 0.0).advance(0.0, 1.0)

    def finer(self, settings: ReferenceSettings, excess: Mapping[str, float], output_step: float) -> ReferenceSettings | None:
        """The same modes as they are, if any was slowed, for they may ring too slowly; else the next rung of the ladder."""
        plain = settings.replaced(slowed_to=0)
        ladder = ladder_of(plain)
        return ladder.sized(plain, settings.modes) if settings.slows else ladder.finer(plain, excess)

    def steady_state(
        self, mechanism: Mechanism, start: Start, settings: ReferenceSettings, near: SteadyState | None = None
    ) -> "FoundOrbit | None":
        """See `Engine.steady_state`; None for a rigid follower, a compliant joint or friction."""
        if mechanism.follower.is_rigid or self.opens_loop(mechanism):
            return None
        from quickreturn.engines.own.simulation import FoundOrbit, OwnSimulation
        from quickreturn.reference_model.cycles.periodic import NoPeriodicOrbit, PeriodicOrbit, periodic_orbit
        from quickreturn.reference_model.cycles.poincare import turn_to
        from quickreturn.reference_model.model import BeamModel

        begin = self.prepare(mechanism, start, settings)
        model = begin.model
        assert isinstance(model, BeamModel)
        turn_to(model, begin.state.copy(), float(begin.state[0]), 1)  # so that the time of the search does not count its compilation
        began = time.perf_counter()
        guess: Array | PeriodicOrbit = begin.state
        if isinstance(near, FoundOrbit) and near.simulation.model.scene == mechanism:
            guess = near.orbit
        elif isinstance(near, FoundOrbit):
            guess = near.orbit.state.copy()
            if not mechanism.crank_is_free:
                State.of(guess).u[0] = State.of(begin.state).u[0]
        try:
            orbit = periodic_orbit(model, guess, ORBIT_TOLERANCE, min(settings.tolerance, ORBIT_INTEGRATION))
        except NoPeriodicOrbit as reason:
            raise NoSteadyState(str(reason)) from reason
        return FoundOrbit(
            simulation=OwnSimulation(model, orbit.state, settings.tolerance, begin.setup_seconds),
            period=orbit.period,
            multipliers=tuple(complex(multiplier) for multiplier in orbit.multipliers),
            stable=orbit.stable,
            iterations=orbit.iterations,
            cycles_of_work=orbit.cycles_of_work,
            residual=orbit.residual,
            solve_seconds=time.perf_counter() - began,
            orbit=orbit,
        )

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ReferenceSettings) -> Array:
        """Converged, whatever the number of modes in simulations; a rigid follower vibrates on a soft joint alone."""
        self.check(mechanism)
        if mechanism.follower.is_rigid:
            return self.model(mechanism, settings).natural_frequencies(crank_angle, count)
        return frozen_crank_modes(mechanism, crank_angle, count).frequencies


def blow(scene: Scene) -> float:
    """Estimated force of a blow over the slider force, when that changes its sign; infinite with clearance, 0 for a smooth joint.

    The softer roller lets the follower go at a speed v, the rate of the force over its stiffness, and the stiffer one (stiffness k) stops
    a mass m of that speed with the force v sqrt(k m). In order of magnitude the rate of the force is the force times `crank_pace`, and m
    is the follower's mass.
    """
    if scene.crank is None or not scene.slider.has_corners:
        return 0.0
    if scene.slider.clearance > 0.0:
        return math.inf
    softer, stiffer = sorted(scene.slider.sides)
    return crank_pace(scene) / softer * stiffer / rate_of_blow(scene)


def rate_of_blow(scene: Scene) -> float:
    """Angular frequency (rad/s) of the follower's mass on the stiffer roller; infinite for a massless follower."""
    return math.sqrt(max(scene.slider.sides) / scene.follower.mass) if scene.follower.mass > 0.0 else math.inf


def joint_inertia(scene: Scene, modes: int) -> float:
    """Inertia (kg) parallel to a compliant joint's spring, which slows the gap's own vibration without a visible error.

    Without it the steps of the explicit integration would have to follow that vibration above 1e6 N/m. With the inertia
    stiffness / Omega^2 a motion of the angular frequency omega meets a joint that is softer by the fraction (omega / Omega)^2. The joint
    changes the square of the lowest frequency by a fraction E. The product of both is kept at `ERROR_OF_SLOWING` times the error of the
    modes, for the lowest frequency with the slider at its farthest place. 0 where the joint is too soft to need it (`SOFT_JOINT`).
    """
    stiffness = scene.slider.closed_stiffness
    if scene.crank is None or scene.follower.is_rigid or stiffness <= 0.0:
        return 0.0
    held = changed(scene, {"slider": None, "slider.inertia": scene.slider.inertia})
    rigid, compliant = (float(frozen_crank_modes(machine, math.pi, 1).frequencies[0]) for machine in (held, scene))
    change = 2.0 * abs(1.0 - compliant / rigid)  # of the frequency's square, with which a motion's amplitude changes
    if change > SOFT_JOINT:
        return 0.0
    highest = float(frozen_crank_modes(held, math.pi, modes).frequencies[-1])
    # not slower than the modes, which bound the step anyway
    slowed = 2.0 * math.pi * max(rigid * math.sqrt(change / (ERROR_OF_SLOWING * AS_THEY_ARE.claim(modes))), highest)
    return stiffness / slowed**2
