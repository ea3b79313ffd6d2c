"""The engine `stiff-spring`: the slider's constraint replaced by a stiff transverse spring at the moving point (Lee)."""

import math
from dataclasses import dataclass
from typing import Final

from quickreturn.engines.base import FRICTION, ROLLERS, USUAL, Comparison
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.own.beam_engine import gain_of
from quickreturn.engines.own.staying_shapes import LADDER as SHAPES
from quickreturn.engines.own.staying_shapes import RivalEngine, ShapeSettings, StayingShapesEngine, of_shapes
from quickreturn.engines.settings import setting
from quickreturn.reference_model import slider_constraint
from quickreturn.reference_model.joint import Rollers, friction_in_words, joint_in_words, rollers
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.slider_constraint import SliderConstraint

LEAST_STIFFNESS: Final = 1.0  # N/m
MOST_STIFFNESS: Final = 1e12  # N/m
MOST_DAMPING: Final = 1e8  # N s/m
#: EI / L^3 (N/m) in run 24: a follower as much stiffer has a spring as much stiffer.
FOLLOWER_OF_RUN_24: Final = 23.9
#: Time constant damping / stiffness (s) and the follower's, sqrt(rho A / EI) L^2 (s), in run 24.
TIME_CONSTANT: Final = 3e-5
TIME_OF_RUN_24: Final = 0.0935
#: Parts of the accuracy that go to the shapes and to the spring.
_SHARE_OF_SHAPES: Final = 0.65
_SHARE_OF_SPRING: Final = 0.3
#: How many times as stiff the next spring is, at least, at most, and where nothing is known.
_LEAST_AT_ONCE: Final = 2.0
_MOST_AT_ONCE: Final = 8.0
_UNKNOWN: Final = 3.0
#: Spring to compare with: the error is of first order in its compliance, as long as the damping has the same time constant.
SOFTER: Final = 0.5


@dataclass(frozen=True, kw_only=True)
class StiffSpringSettings(ShapeSettings):
    """Settings of `stiff-spring`; a scene with a compliant slider joint brings stiffness and damping of its own."""

    stiffness: float = setting(1e6, "of the spring that stands for the constraint", unit="N/m", low=LEAST_STIFFNESS, high=MOST_STIFFNESS)
    damping: float = setting(30.0, "of the damper beside it", unit="N*s/m", low=0.0, high=MOST_DAMPING)


#: Clamped-free modes, integration tolerance, stiffness (N/m) and what they claim of the tip deflection in run 24 over 2 s: the sum of what
#: the shapes claim (`staying_shapes.LADDER`) and of the spring's error (8.8e-3 at 1e6 N/m, in proportion to 1/k).
_RUNGS: Final = (
    (1, 1e-8, 1e5, 1.4),
    (2, 1e-8, 1e5, 5.5e-1),
    (3, 1e-8, 2e5, 1.7e-1),
    (4, 1e-8, 5e5, 5.7e-2),
    (6, 1e-8, 1e6, 2.6e-2),
    (10, 1e-9, 3e6, 1.3e-2),
    (12, 1e-9, 1e7, 9.7e-3),
    (16, 1e-9, 1e7, 4.2e-3),
    (20, 1e-9, 2e7, 2.6e-3),
    (24, 1e-9, 3e7, 1.3e-3),
    (28, 1e-10, 6e7, 8.0e-4),
    (32, 1e-10, 1e8, 5.5e-4),
)
LADDER: Final = Ladder(
    tuple(
        (StiffSpringSettings(shapes=shapes, tolerance=tolerance, stiffness=stiffness), claim)
        for shapes, tolerance, stiffness, claim in _RUNGS
    ),
    size="shapes",
    tolerance="tolerance",
    order=SHAPES.order,
)


class StiffSpringEngine(RivalEngine[StiffSpringSettings], StayingShapesEngine[StiffSpringSettings]):
    """A gap opens between crank tip and centre line as far as the slider force bends the spring; exact for a compliant joint."""

    name = "stiff-spring"
    method = "stiff transverse spring and damper at the slider, fixed shapes, exact planar geometry, DOP853"
    default_accuracy = 1e-2
    settings_type = StiffSpringSettings
    quantities = (*USUAL, *ROLLERS, *FRICTION, "follower.material_damping")

    def constraint(self, scene: Scene, settings: StiffSpringSettings) -> SliderConstraint:
        """The scene's joint if it is compliant, else the stiff spring of the settings; dampings of joint and settings do not add."""
        if scene.slider.is_rigid:
            spring = Rollers(plus=settings.stiffness, minus=settings.stiffness, damping=settings.damping)
        else:
            spring = rollers(scene.slider)
        return SliderConstraint(kind=slider_constraint.ROLLERS, rollers=spring)

    def joint_line(self, scene: Scene, settings: StiffSpringSettings) -> str:
        """Whose spring it is."""
        stiff = f"stiff spring in place of the constraint, {settings.stiffness:g} N/m, {settings.damping:g} N*s/m"
        slider = scene.slider
        return f"slider beside the centre line ({stiff if slider.is_rigid else joint_in_words(slider)})" + friction_in_words(slider)

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> StiffSpringSettings:
        """Shapes and stiffness from the measured table, for a follower as stiff and as fast as this one."""
        rung = LADDER.pick(accuracy, gain_of(mechanism))
        scale, time = _follower(mechanism)
        stiffness = float(f"{min(max(scale * rung.stiffness, LEAST_STIFFNESS), MOST_STIFFNESS):.2g}")
        damping = float(f"{min(time * TIME_CONSTANT * stiffness, MOST_DAMPING):.2g}")
        return rung.replaced(stiffness=stiffness, damping=damping)

    def comparisons(self, settings: StiffSpringSettings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """Other numbers of shapes on the same spring, and a spring half as stiff; of a compliant joint the spring is no error."""
        if not mechanism.slider.is_rigid:
            return of_shapes(settings)
        part = SOFTER if SOFTER * settings.stiffness >= LEAST_STIFFNESS else 1.0 / SOFTER
        other = settings.replaced(stiffness=part * settings.stiffness, damping=min(part * settings.damping, MOST_DAMPING))
        return (*of_shapes(settings), Comparison(settings, other, 1.0 / part))

    def finer(self, settings: StiffSpringSettings, excess: tuple[float, ...], output_step: float) -> StiffSpringSettings | None:
        """More shapes, a stiffer spring or both, as the parts of the estimate ask for."""
        count = len(of_shapes(settings))
        in_shapes, in_spring = sum(excess[:count]) / _SHARE_OF_SHAPES, sum(excess[count:]) / _SHARE_OF_SPRING
        found: StiffSpringSettings | None = settings
        if in_shapes > 1.0 or not excess:
            found = SHAPES.finer(settings, (in_shapes,) if excess else ())
        if found is None or (excess and in_spring <= 1.0):
            return found
        times = min(max(in_spring, _LEAST_AT_ONCE), _MOST_AT_ONCE) if excess else _UNKNOWN
        stiffness, damping = (float(f"{times * value:.2g}") for value in (settings.stiffness, settings.damping))
        return found.replaced(stiffness=stiffness, damping=damping) if stiffness <= MOST_STIFFNESS and damping <= MOST_DAMPING else None


def _follower(mechanism: Mechanism) -> tuple[float, float]:
    """Stiffness EI / L^3 and time sqrt(rho A / EI) L^2 of a follower over those of run 24's; 1 for a rigid one."""
    follower = mechanism.follower
    if follower.is_rigid:
        return 1.0, 1.0
    time = math.sqrt(follower.mass_per_length / follower.bending_stiffness) * follower.length**2
    return follower.bending_stiffness / follower.length**3 / FOLLOWER_OF_RUN_24, time / TIME_OF_RUN_24
