"""The engine `reference`: pseudo-coordinates with shapes that follow the slider, converged.

What its numbers were measured from stands in `engines/LADDERS.md`, section 1.
"""

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines import refusals
from quickreturn.engines.base import FRICTION, ROLLERS, SPIN_UP, USUAL, Comparison, NoSteadyState, SteadyState
from quickreturn.engines.ladder import Ladder, S
from quickreturn.engines.own.beam_engine import BeamEngine, BeamSettings, gain_of
from quickreturn.engines.settings import setting
from quickreturn.engines.start import Start, standard_start
from quickreturn.reference_model import slider_constraint
from quickreturn.reference_model.constants import unslowed
from quickreturn.reference_model.joint import friction_in_words, joint_in_words, rollers
from quickreturn.reference_model.mechanism import Mechanism, Scene, Slider, changed
from quickreturn.reference_model.natural_modes import frozen_crank_modes, stiffness_ratio
from quickreturn.reference_model.rigid import crank_pace
from quickreturn.reference_model.slider_constraint import CLOSED, MULTIPLIER, SliderConstraint

if TYPE_CHECKING:
    from quickreturn.engines.own.simulation import OwnSimulation
    from quickreturn.reference_model.model import BeamModel

#: Tolerance for an accuracy where so few modes do.
TOLERANCE_PER_ACCURACY: Final = 1e-4

#: Modes -> modes of the finer run that the error is estimated with, and the ratio of their errors.
COMPARED: Final = {1: (4, 0.2), 2: (5, 0.5), 3: (6, 0.25), 4: (7, 0.2)}
#: Relative change of the lowest frequency's square by a compliant joint, above which the joint's own vibration is not slowed.
SOFT: Final = 5e-4
#: Part of the modes' error that slowing it may cost.
UNSEEN: Final = 5e-3
#: Modes at least where rollers are hit: blows set more of them ringing than the crank does.
MODES_OF_BLOWS: Final = 7
#: Part of the slider force from which on a roller that meets the follower hits it (`blow`): measured are 0.07, which needs no more modes
#: than a rigid joint, and 0.6, which does (`engines/LADDERS.md`, section 5).
HIT: Final = 0.1
#: Angular frequency over that of a blow, below which no mode is slowed where rollers are hit (`engines/LADDERS.md`, section 1).
BLOW_RESOLVED: Final = 5.0
#: Largest tolerance of a finer run over that of the run itself: a tenth shows the integration's error. Where rollers touch and part more
#: modes need no smaller one.
TENTH: Final = 0.1
LEAST_TOLERANCE: Final = 1e-12
#: Rate (1/s) at which the gap of a rigid joint with friction decays.
STABILIZATION: Final = 100.0
#: Error with two modes more over that without.
RATIO: Final = 0.25
#: The most modes that are accepted; a run with so many is compared with one of two fewer.
MOST_MODES: Final = 16
#: From so many modes on the error falls smoothly, and two modes more must leave no more than this part of it; below, `RATIO` of it.
SMOOTH: Final = 4
SLOWEST: Final = 0.5
#: First bending frequency over the crank's, below which no mode is slowed: the motion itself needs the higher ones. Run 24 has 4.1, in
#: which slowing costs nothing; with a tenth of its stiffness (1.3) it costs ten times the error (`engines/LADDERS.md`, section 1).
SOFT_FOLLOWER: Final = 3.0
#: Modes -> `Comparison.alike` of a run with so many; 0 for other numbers.
ALIKE: Final = {1: 4.0, 2: 4.0, 4: 2.0}
#: Relative distance from a periodic motion at which the search for it makes its last step. The step leaves a tenth of it or less, which
#: counts as settled when marching.
ORBIT_TOLERANCE: Final = 1e-3


@dataclass(frozen=True, kw_only=True)
class ReferenceSettings(BeamSettings):
    """Settings of `reference`."""

    modes: int = setting(5, "modes of the beam supported at the slider", low=1, high=MOST_MODES)
    tolerance: float = setting(
        1e-7, "local error of the integration, relative to fixed sizes of the states", low=LEAST_TOLERANCE, high=1e-4
    )
    added_inertia: bool = setting(False, "the higher half of the modes has an added inertia and vibrates no faster than the middle one")

    @property
    def shape_count(self) -> int:
        return self.modes


#: Modes, integration tolerance where an added inertia slows the higher half of them and where nothing does, and error of the tip
#: deflection in run 24 over 2 s.
_RUNGS: Final = (
    (1, 1e-5, 1e-5, 2.7e-2),
    (2, 1e-5, 1e-5, 1.5e-3),
    (4, 1e-6, 3e-7, 8e-4),
    (5, 3e-7, 1e-7, 4.9e-4),
    (6, 3e-7, 1e-7, 2.3e-4),
    (7, 3e-7, 1e-8, 8.2e-5),
    (8, 1e-7, 1e-8, 3.5e-5),
    (9, 3e-8, 3e-9, 1.5e-5),
    (11, 1e-8, 1e-9, 4e-6),
)


def _ladder(column: int, added_inertia: bool) -> Ladder[ReferenceSettings]:
    rungs = ((ReferenceSettings(modes=rung[0], tolerance=rung[column], added_inertia=added_inertia), rung[-1]) for rung in _RUNGS)
    return Ladder(tuple(rungs), "modes", "tolerance")


#: Where runs begin, and where they climb.
SLOWED, AS_THEY_ARE = _ladder(1, True), _ladder(2, False)


def fitted(ladder: Ladder[S], accuracy: float, scene: Scene) -> S:
    """The coarsest rung for a scene; where fewer modes do than in run 24, their tolerance fits the accuracy."""
    found = ladder.pick(accuracy, gain_of(scene))
    if found == ladder.pick(accuracy):
        return found
    fit = 10.0 ** math.floor(math.log10(TOLERANCE_PER_ACCURACY * accuracy) + 1e-9)
    return found.replaced(tolerance=min(found.as_dict()["tolerance"], fit))


class ReferenceEngine(BeamEngine[ReferenceSettings]):
    """Modes of the beam supported where the slider is, projected on the free speeds; observables recovered from equilibrium."""

    name = "reference"
    method = "pseudo-coordinate, shapes that follow the slider, exact planar geometry, equilibrium recovery, compiled DOP853"
    default_accuracy = 1e-3
    settings_type = ReferenceSettings
    kind_of_shapes = "shapes that follow the slider"
    kind_of_clamped_shapes = "clamped modes"
    quantities = (*USUAL, "slider.inertia", *ROLLERS, *FRICTION, "follower.material_damping", SPIN_UP)

    def check(self, scene: Scene) -> None:
        """Refuse also, with a joint that gives way or rubs, parts that the open loop leaves without inertia."""
        super().check(scene)
        if self.opens_loop(scene):
            refusals.of_massless_parts(self.name, scene, " with a joint that gives way or rubs, which leaves the follower to itself")

    def opens_loop(self, scene: Scene) -> bool:
        """A joint that gives way leaves the follower's angle free; friction needs the normal force, which an open loop knows."""
        return not scene.slider.is_rigid or scene.slider.has_friction

    def model(self, scene: Scene, settings: ReferenceSettings) -> "BeamModel":
        """See `BeamEngine.model`; the slider is eliminated only where it neither leaves the centre line nor rubs.

        The follower alone has modes of the beam clamped at its base: five leave 6e-5 in the library's spin-up.
        """
        from quickreturn.reference_model.model import BeamModel

        held = CLOSED
        if not scene.slider.is_rigid:
            inertia = joint_inertia(scene, settings.modes) if scene.slider.is_linear else 0.0
            held = SliderConstraint(kind=slider_constraint.ROLLERS, rollers=rollers(scene.slider), inertia=inertia)
        elif scene.slider.has_friction:
            held = SliderConstraint(kind=MULTIPLIER, stabilization=STABILIZATION)
        slowed_to = BLOW_RESOLVED * rate_of_blow(scene) if scene.slider.has_corners else 0.0
        return BeamModel.following(scene, settings.modes, held, slowed_to if settings.added_inertia else None)

    def joint_line(self, scene: Scene, settings: ReferenceSettings) -> str:
        """Rigid or compliant."""
        slider = scene.slider
        if not slider.is_rigid:
            line = f"slider beside the centre line ({joint_in_words(slider)})"
        else:
            line = "slider on the centre line (Lagrange multiplier)" if slider.has_friction else super().joint_line(scene, settings)
        return line + friction_in_words(slider)

    def settings_for(self, accuracy: float, scene: Scene) -> ReferenceSettings:
        """Number of modes from the measured table; fewer where the follower is stiffer than run 24's, more where rollers are hit."""
        ladder = AS_THEY_ARE if scene.crank is None or 0.0 < stiffness_ratio(scene) < SOFT_FOLLOWER else SLOWED
        if not scene.slider.has_corners:
            return fitted(ladder, accuracy, scene)
        hit, usual = blow(scene) > HIT, AS_THEY_ARE.pick(accuracy)
        found = usual.replaced(modes=max(usual.modes, MODES_OF_BLOWS)) if hit else fitted(AS_THEY_ARE, accuracy, scene)
        return found.replaced(added_inertia=True)

    def comparisons(self, settings: ReferenceSettings, scene: Scene, output_step: float) -> tuple[Comparison, ...]:
        """A run with more modes and a tolerance fit for them: it shows truncation and integration at once.

        Of clamped modes the error of more is a smaller part, which makes the estimate a little too large. Another with still more tells
        whether the error falls as it should: after a blow it does not, for that sets all modes ringing. It shows in accelerations, which
        then differ by a larger part than the deflection.
        """
        ladder = SLOWED if settings.added_inertia else AS_THEY_ARE
        if settings.modes + 2 > MOST_MODES:
            return (Comparison(settings, ladder.sized(settings, settings.modes - 2), 1.0 / RATIO),)

        def sized(run: ReferenceSettings, modes: int) -> ReferenceSettings:
            usual, tenth = ladder.sized(run, modes), max(TENTH * run.tolerance, LEAST_TOLERANCE)
            return usual.replaced(tolerance=tenth if scene.slider.has_corners else min(usual.tolerance, tenth))

        if scene.crank is None:
            return (Comparison(settings, sized(settings, settings.modes + 2), RATIO),)
        more, ratio = COMPARED.get(settings.modes, (settings.modes + 2, RATIO))
        finer, further = sized(settings, more), None
        if more + 2 <= MOST_MODES:
            rest = RATIO if settings.modes < SMOOTH else SLOWEST
            further = Comparison(finer, sized(finer, more + 2), rest)
        return (Comparison(settings, finer, ratio, further, alike=ALIKE.get(settings.modes, 0.0)),)

    def finer(self, settings: ReferenceSettings, excess: tuple[float, ...], output_step: float) -> ReferenceSettings | None:
        """The same modes as they are, if some were slowed: after a blow these ring too slowly. Else the next rung of the ladder."""
        plain = settings.replaced(added_inertia=False)
        if settings.added_inertia and unslowed(settings.modes) < settings.modes:
            return AS_THEY_ARE.sized(plain, settings.modes)
        return AS_THEY_ARE.finer(plain, excess)

    def steady_state(
        self, mechanism: Mechanism, start: Start, settings: ReferenceSettings, near: "OwnSimulation | None" = None, patient: bool = False
    ) -> SteadyState | None:
        """See `Engine.steady_state`; a rigid follower, or a slider joint that gives way or rubs, is marched.

        Args:
            mechanism: the scene.
            start: where the search begins.
            settings: of it.
            near: in the periodic state of a neighbouring scene, or with other settings, where the search begins instead.
            patient: whether more turns are made before Newton's method, as where a search failed.
        """
        if mechanism.follower.is_rigid or self.opens_loop(mechanism):
            return None
        from quickreturn.engines.own.simulation import OwnSimulation
        from quickreturn.reference_model.model import BeamModel
        from quickreturn.reference_model.periodic import MARCHED, PATIENT, NoPeriodicOrbit, periodic_orbit
        from quickreturn.reference_model.poincare import turn_to

        begin = self.prepare(mechanism, start, settings)
        model = begin.model
        assert isinstance(model, BeamModel)
        turn_to(model, begin.state.copy(), float(begin.state[0]), 1)  # so that no time counts its compiling
        began = time.perf_counter()
        guess = begin.state if near is None else _guess(near, begin.state[model.parameters.speeds + 1], mechanism)
        try:
            orbit = periodic_orbit(model, guess, ORBIT_TOLERANCE, settings.tolerance, PATIENT if patient else MARCHED)
        except NoPeriodicOrbit as reason:
            raise NoSteadyState(str(reason)) from reason
        return SteadyState(
            simulation=OwnSimulation(model, orbit.state, settings.tolerance, begin.setup_seconds),
            period=orbit.period,
            multipliers=tuple(complex(multiplier) for multiplier in orbit.multipliers),
            stable=orbit.stable,
            iterations=orbit.iterations,
            cycles_of_work=orbit.cycles_of_work,
            residual=orbit.residual,
            solve_seconds=time.perf_counter() - began,
        )

    def periodic_start(self, mechanism: Mechanism, settings: ReferenceSettings) -> Start:
        """The periodic steady state at the slider's farthest place, as a start for any engine.

        Raises:
            NoSteadyState: there is none, it was not found, or it is not stable.
        """
        found = self.steady_state(mechanism, standard_start(mechanism), settings)
        if found is None or not found.stable:
            raise NoSteadyState("a rigid follower or an open loop is marched" if found is None else "the periodic state is not stable")
        from quickreturn.engines.own.simulation import OwnSimulation

        assert isinstance(found.simulation, OwnSimulation)
        return found.simulation.present_start()

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ReferenceSettings) -> NDArray[np.float64]:
        """Converged, whatever the number of modes kept in simulations."""
        self.check(mechanism)
        return frozen_crank_modes(mechanism, crank_angle, count).frequencies


def _guess(near: "OwnSimulation", crank_speed: float, mechanism: Mechanism) -> NDArray[np.float64]:
    """The state of a neighbour's orbit, with the crank speed (rad/s) that is prescribed."""
    state = near.state.copy()
    if not mechanism.crank_is_free:
        state[(len(state) - 5) // 2 + 2] = crank_speed
    return state


def blow(scene: Scene) -> float:
    """Force with which a roller meets the follower as the slider force changes its sign, over that force; infinite across a clearance.

    The softer roller lets go of the follower at the rate of the force over its stiffness, and a mass m that meets the stiffer one at a
    speed v is stopped by v sqrt(k m). The force changes at the crank's pace, and m is the follower's mass, each in order of magnitude.
    """
    if scene.crank is None or not scene.slider.has_corners:
        return 0.0
    if scene.slider.clearance > 0.0:
        return math.inf
    softer, stiffer = sorted(scene.slider.sides)
    return crank_pace(scene) / softer * stiffer / rate_of_blow(scene)


def rate_of_blow(scene: Scene) -> float:
    """Angular frequency (rad/s) of the follower's mass on the stiffer roller; infinite without a mass."""
    return math.sqrt(max(scene.slider.sides) / scene.follower.mass) if scene.follower.mass > 0.0 else math.inf


def joint_inertia(scene: Scene, modes: int) -> float:
    """Inertia (kg) beside a compliant joint's spring, which slows the gap's own vibration by as much as does not show.

    A motion of the angular frequency omega finds the joint softer by (omega / Omega)^2 where the inertia is stiffness / Omega^2, and the
    joint changes the lowest frequency by a part E: the product is kept at a hundredth of the error of the modes, for the lowest frequency
    with the slider at its farthest place. Above 1e6 N/m a step of the explicit integration would else have to follow that vibration.
    """
    stiffness = scene.slider.closed_stiffness
    if scene.crank is None or scene.follower.is_rigid or stiffness <= 0.0:
        return 0.0
    held = changed(scene, {"slider": Slider(inertia=scene.slider.inertia)})
    rigid, own_one = (float(frozen_crank_modes(each, math.pi, 1).frequencies[0]) for each in (held, scene))
    part = 2.0 * abs(1.0 - own_one / rigid)  # of the frequency's square, which a motion's amplitude follows
    if part > SOFT:
        return 0.0
    highest = float(frozen_crank_modes(held, math.pi, modes).frequencies[-1])
    # no slower than the modes themselves, which bound the step anyway
    slowed = 2.0 * math.pi * max(rigid * math.sqrt(part / (UNSEEN * AS_THEY_ARE.claim(modes))), highest)
    return stiffness / slowed**2
