"""The engine of the rivals with fixed shapes: a rival is what is in `Rival`, and nothing else distinguishes their engines."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Generic, TypeVar

import numpy as np

from quickreturn.engines import refusals
from quickreturn.engines.base import HELD, TOOL, USUAL, Comparison, EstimateOf
from quickreturn.engines.ladder import Ladder, fitted
from quickreturn.engines.own.beam_engine import (
    LEAST_TOLERANCE,
    ORDER_OF_SLOWING,
    BeamEngine,
    BeamSettings,
    compared_integration,
    compared_slowing,
)
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.joint import CLOSED, SliderConstraint
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.shapes import ShapeSet, no_shapes

if TYPE_CHECKING:
    from quickreturn.reference_model.model import BeamModel


#: Tolerance of the implicit integration over the accuracy, where a scene needs fewer shapes than run 24: its part of the estimate was
#: 2e-3 at 1e-4 in run 17 (10 fixed shapes), and falls in proportion.
TOLERANCE_PER_ACCURACY: Final = 1e-2
#: Fraction of the accuracy for the error by slowing.
SHARE_OF_SLOWING: Final = 0.3
#: Fraction of the accuracy for the error of the implicit integration, and the smallest factor on the tolerance at once.
SHARE_OF_TIME: Final = 0.2
LEAST_AT_ONCE: Final = 0.01
#: Largest factor on the number of the slowest slowed mode at once.
MOST_AT_ONCE: Final = 2.0

S = TypeVar("S", bound=BeamSettings)


@dataclass(frozen=True, kw_only=True)
class Rival(Generic[S]):
    """A method with fixed shapes. Without `constraint` the closed loop gives the follower's angle; with it that is a coordinate."""

    name: str  # this and the next four: see `Engine`
    method: str
    default_accuracy: float
    estimates: EstimateOf = "total"
    quantities: tuple[str, ...] = (*USUAL, *TOOL)
    settings_type: type[S]
    ladder: Ladder[S]  # measured in run 24
    shapes: Callable[[S, float], ShapeSet]  # of a flexible follower, from its length, m
    comparisons: Callable[[S, Mechanism], tuple[Comparison, ...]]  # see `Engine.comparisons`
    constraint: Callable[[S, Scene], SliderConstraint] | None = None  # what it does with the gap between crank tip and follower
    joint_line: Callable[[S, Scene], str] | None = None  # the slider's joint in one line
    scaled: Callable[[S, Mechanism], S] | None = None  # a rung's settings for a mechanism
    finer: Callable[[S, Mapping[str, float]], S | None] | None = None  # see `Engine.finer`, if the ladder's next rung is not enough
    natural_frequencies: Callable[[Mechanism, float, int], Array] | None = None  # if they are not the model's


class RivalEngine(BeamEngine[S]):
    """The engine of a rival. With an open loop it refuses parts without mass."""

    def __init__(self, rival: Rival[S]) -> None:
        self.rival = rival
        self.name, self.method, self.default_accuracy = rival.name, rival.method, rival.default_accuracy
        self.settings_type, self.estimates, self.quantities = rival.settings_type, rival.estimates, (*rival.quantities, *HELD)

    def check(self, scene: Scene) -> None:
        super().check(scene)
        if self.opens_loop(scene):
            refusals.of_massless_parts(self.name, scene, ", whose shapes need mass of their own")

    def opens_loop(self, scene: Scene) -> bool:
        return self.rival.constraint is not None

    def model(self, scene: Scene, settings: S) -> "BeamModel":
        from quickreturn.reference_model.model import BeamModel

        length = scene.follower.length
        shapes = no_shapes(length) if scene.follower.is_rigid else self.rival.shapes(settings, length)
        refusals.of_kinks(scene, shapes, "clamped-free modes or one Hermite element")
        return BeamModel.staying(
            scene, shapes, self.rival.constraint(settings, scene) if self.rival.constraint else CLOSED, slowed_to=settings.slowed_to
        )

    def joint_line(self, scene: Scene, settings: S) -> str:
        return self.rival.joint_line(settings, scene) if self.rival.joint_line else super().joint_line(scene, settings)

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> S:
        """A rung of the ladder, a coarser one for a follower that is stiffer than run 24's."""
        rung = fitted(self.rival.ladder, accuracy, mechanism, TOLERANCE_PER_ACCURACY)
        return self.rival.scaled(rung, mechanism) if self.rival.scaled else rung

    def comparisons(self, settings: S, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        of_slowing = () if mechanism.follower.is_rigid else compared_slowing(settings)
        return (*self.rival.comparisons(settings, mechanism), *of_slowing, *compared_integration(settings))

    def finer(self, settings: S, excess: Mapping[str, float], output_step: float) -> S | None:
        return finer_by_parts(settings, excess, self.rival.finer or self.rival.ladder.finer)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: S) -> Array:
        if self.rival.natural_frequencies is None:
            return super().natural_frequencies(mechanism, crank_angle, count, settings)
        self.check(mechanism)
        return np.zeros(0) if mechanism.follower.is_rigid else self.rival.natural_frequencies(mechanism, crank_angle, count)


def finer_by_parts(settings: S, excess: Mapping[str, float], finer: Callable[[S, Mapping[str, float]], S | None]) -> S | None:
    """What `finer` makes of an excess, with modes slowed less and a smaller tolerance where those parts are too large, or None."""
    shares = {"slowing": SHARE_OF_SLOWING if settings.slows else 0.0, "time": SHARE_OF_TIME if compared_integration(settings) else 0.0}
    slowing, in_time = (excess.get(of, 0.0) / share if share else 0.0 for of, share in shares.items())
    others = {of: part for of, part in excess.items() if of not in shares}
    climbed: S | None = settings
    if not excess or sum(others.values()) > 1.0 - sum(shares.values()):
        climbed = finer(settings, others)
    found = climbed or settings
    if in_time > 1.0:
        found = found.replaced(tolerance=max(min(found.tolerance, max(1.0 / in_time, LEAST_AT_ONCE) * settings.tolerance), LEAST_TOLERANCE))
    if settings.slows and (not excess or slowing > 1.0):
        times = min(slowing ** (1.0 / ORDER_OF_SLOWING), MOST_AT_ONCE)
        raised = max(settings.slowed_to + 1, math.ceil(times * settings.slowed_to))
        found = found.replaced(slowed_to=raised if raised < found.shape_count else 0)
    return found if found != settings else None
