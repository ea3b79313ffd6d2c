"""The engine `stiff-spring`: a stiff transverse spring at the moving point in place of the slider's constraint (Lee)."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from quickreturn.engines.base import FRICTION, ROLLERS, TOOL, USUAL, Comparison
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.own.beam_engine import time_over_run_24
from quickreturn.engines.settings import setting
from quickreturn.plugins.methods.rivals.rival import Rival, RivalEngine
from quickreturn.plugins.methods.rivals.staying_shapes import LADDER as SHAPES
from quickreturn.plugins.methods.rivals.staying_shapes import ShapeSettings, compared_shapes, shapes_of
from quickreturn.reference_model import joint
from quickreturn.reference_model.joint import Rollers, SliderConstraint, friction_in_words, joint_in_words, rollers
from quickreturn.reference_model.mechanism import Mechanism, Scene

LEAST_STIFFNESS: Final = 1e-30  # N/m
MOST_STIFFNESS: Final = 1e30  # N/m
MOST_DAMPING: Final = 1e30  # N s/m
MOST_INERTIA: Final = 1e30  # kg
#: EI / L^3 (N/m) in run 24. The spring's stiffness is in proportion to the follower's.
FOLLOWER_OF_RUN_24: Final = 23.9
#: In run 24: the spring's damping / stiffness (s), and the follower's sqrt(rho A / EI) L^2 (s), to which it is in proportion.
TIME_CONSTANT: Final = 3e-5
TIME_OF_RUN_24: Final = 0.0935
#: Mass of the follower in run 24, kg.
MASS_OF_RUN_24: Final = 0.208
#: Fractions of the accuracy for the errors of the shapes and of the spring.
_SHARE_OF_SHAPES: Final = 0.65
_SHARE_OF_SPRING: Final = 0.3
#: Stiffness of the next spring over that of the present one: at least, at most, and if the error is unknown.
_LEAST_AT_ONCE: Final = 2.0
_MOST_AT_ONCE: Final = 8.0
_UNKNOWN: Final = 3.0
#: Stiffness of the spring to compare with, over that of the run: the error is of first order in the compliance, for equal time constants.
SOFTER: Final = 0.5


@dataclass(frozen=True, kw_only=True)
class StiffSpringSettings(ShapeSettings):
    """Settings of `stiff-spring`; a scene with a compliant joint has a stiffness and a damping of its own instead."""

    stiffness: float = setting(1e6, "of the spring that stands for the constraint", unit="N/m", low=LEAST_STIFFNESS, high=MOST_STIFFNESS)
    damping: float = setting(30.0, "of the damper beside it", unit="N*s/m", low=0.0, high=MOST_DAMPING)
    joint_inertia: float = setting(
        0.0, "force over the gap's acceleration, parallel to that spring, whose vibration it slows", unit="kg", low=0.0, high=MOST_INERTIA
    )


#: Clamped-free modes, tolerance of the implicit integration, stiffness (N/m), and the error of the tip deflection that they claim in run
#: 24 over 2 s: the sum of the shapes' claim (`staying_shapes.LADDER`) and of the spring's error (8.8e-3 at 1e6 N/m, in proportion to 1/k).
_RUNGS: Final = (
    (1, 1e-3, 1e5, 1.4),
    (2, 1e-3, 1e5, 5.7e-1),
    (3, 1e-3, 2e5, 1.7e-1),
    (4, 1e-3, 5e5, 6.1e-2),
    (6, 3e-4, 1e6, 2.8e-2),
    (10, 1e-4, 3e6, 1.3e-2),
    (12, 3e-5, 1e7, 9.9e-3),
    (16, 3e-5, 1e7, 4.5e-3),
    (20, 1e-5, 2e7, 2.7e-3),
    (24, 1e-5, 3e7, 1.4e-3),
    (28, 3e-6, 6e7, 8.3e-4),
    (32, 3e-6, 1e8, 5.7e-4),
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


def constraint(settings: StiffSpringSettings, scene: Scene) -> SliderConstraint:
    """The scene's joint if that is compliant, else the stiff spring and the damper of the settings."""
    if scene.slider.is_rigid:
        spring = Rollers(plus=settings.stiffness, minus=settings.stiffness, damping=settings.damping)
        return SliderConstraint(kind=joint.ROLLERS, rollers=spring, inertia=settings.joint_inertia)
    return SliderConstraint(kind=joint.ROLLERS, rollers=rollers(scene.slider))


def joint_line(settings: StiffSpringSettings, scene: Scene) -> str:
    """The scene's joint, or the stiff spring in its place, in one line."""
    stiff = f"stiff spring in place of the constraint, {settings.stiffness:g} N/m, {settings.damping:g} N*s/m"
    slider = scene.slider
    return f"slider beside the centre line ({stiff if slider.is_rigid else joint_in_words(slider)})" + friction_in_words(slider)


def scaled(settings: StiffSpringSettings, mechanism: Mechanism) -> StiffSpringSettings:
    """Settings whose stiffness is in proportion to the follower's, the damping to its time, too, and the inertia to the time's square."""
    scale, time = _follower(mechanism)
    stiffness = float(f"{min(max(scale * settings.stiffness, LEAST_STIFFNESS), MOST_STIFFNESS):.2g}")
    damping = float(f"{min(time * TIME_CONSTANT * stiffness, MOST_DAMPING):.2g}")
    inertia = min(scale * time**2 * settings.joint_inertia, MOST_INERTIA)
    return settings.replaced(stiffness=stiffness, damping=damping, joint_inertia=inertia)


def _follower(mechanism: Mechanism) -> tuple[float, float]:
    """Stiffness EI / L^3 and time sqrt(rho A / EI) L^2 of a follower over those of run 24's; of a rigid one by its mass and the crank."""
    follower = mechanism.follower
    if follower.is_rigid:
        time = time_over_run_24(mechanism)
        return follower.mass / MASS_OF_RUN_24 / time**2, time
    time = math.sqrt(follower.mass_per_length / follower.bending_stiffness) * follower.length**2
    return follower.bending_stiffness / follower.length**3 / FOLLOWER_OF_RUN_24, time / TIME_OF_RUN_24


def comparisons(settings: StiffSpringSettings, mechanism: Mechanism) -> tuple[Comparison, ...]:
    """Comparisons with other numbers of shapes and the same spring; and unless the joint is compliant, with a spring half as stiff."""
    of_shapes = compared_shapes(settings, mechanism)
    if not mechanism.slider.is_rigid:
        return of_shapes
    ratio = SOFTER if SOFTER * settings.stiffness >= LEAST_STIFFNESS else 1.0 / SOFTER
    other = settings.replaced(
        stiffness=ratio * settings.stiffness,
        damping=min(ratio * settings.damping, MOST_DAMPING),
        joint_inertia=min(ratio * settings.joint_inertia, MOST_INERTIA),
    )
    return (*of_shapes, Comparison(settings, other, 1.0 / ratio, of="spring"))


def finer(settings: StiffSpringSettings, excess: Mapping[str, float]) -> StiffSpringSettings | None:
    """Settings with more shapes, a stiffer spring or both, by the parts of the estimate."""
    in_shapes, in_spring = excess.get("modes", 0.0) / _SHARE_OF_SHAPES, excess.get("spring", 0.0) / _SHARE_OF_SPRING
    finer: StiffSpringSettings | None = settings
    if in_shapes > 1.0 or not excess:
        finer = SHAPES.finer(settings, {"modes": in_shapes} if excess else {})
    if finer is None or (excess and in_spring <= 1.0):
        return finer
    times = min(max(in_spring, _LEAST_AT_ONCE), _MOST_AT_ONCE) if excess else _UNKNOWN
    stiffness, damping = (float(f"{times * value:.2g}") for value in (settings.stiffness, settings.damping))
    inertia = min(times * settings.joint_inertia, MOST_INERTIA)  # so that the spring's vibration stays as it is
    fits = stiffness <= MOST_STIFFNESS and damping <= MOST_DAMPING
    return finer.replaced(stiffness=stiffness, damping=damping, joint_inertia=inertia) if fits else None


#: The slider force opens a gap between crank tip and centre line against the spring; exact for a compliant joint.
ENGINE: Final = RivalEngine(
    Rival(
        name="stiff-spring",
        method="stiff transverse spring and damper at the slider, fixed shapes, exact planar geometry, Radau IIA",
        default_accuracy=1e-2,
        settings_type=StiffSpringSettings,
        quantities=(*USUAL, *TOOL, *ROLLERS, *FRICTION, "follower.material_damping"),
        ladder=LADDER,
        shapes=shapes_of,
        comparisons=comparisons,
        constraint=constraint,
        joint_line=joint_line,
        scaled=scaled,
        finer=finer,
    )
)
