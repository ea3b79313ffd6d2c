"""The engine of the rivals with fixed shapes: a rival is what is in `Rival`, and nothing else distinguishes their engines."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines import refusals
from quickreturn.engines.base import HELD, TOOL, USUAL, Comparison, EstimateOf
from quickreturn.engines.ladder import Ladder, gain_of
from quickreturn.engines.own.beam_engine import BeamEngine, S
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.shapes import ShapeSet, no_shapes
from quickreturn.reference_model.slider_constraint import CLOSED, SliderConstraint

if TYPE_CHECKING:
    from quickreturn.reference_model.model import BeamModel


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
    natural_frequencies: Callable[[Mechanism, float, int], NDArray[np.float64]] | None = None  # if they are not the model's


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
        return BeamModel.staying(scene, shapes, self.rival.constraint(settings, scene) if self.rival.constraint else CLOSED)

    def joint_line(self, scene: Scene, settings: S) -> str:
        return self.rival.joint_line(settings, scene) if self.rival.joint_line else super().joint_line(scene, settings)

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> S:
        """A rung of the ladder, a coarser one for a follower that is stiffer than run 24's."""
        rung = self.rival.ladder.pick(accuracy, gain_of(mechanism))
        return self.rival.scaled(rung, mechanism) if self.rival.scaled else rung

    def comparisons(self, settings: S, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        return self.rival.comparisons(settings, mechanism)

    def finer(self, settings: S, excess: Mapping[str, float], output_step: float) -> S | None:
        return self.rival.finer(settings, excess) if self.rival.finer else self.rival.ladder.finer(settings, excess)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: S) -> NDArray[np.float64]:
        if self.rival.natural_frequencies is None:
            return super().natural_frequencies(mechanism, crank_angle, count, settings)
        self.check(mechanism)
        return np.zeros(0) if mechanism.follower.is_rigid else self.rival.natural_frequencies(mechanism, crank_angle, count)
