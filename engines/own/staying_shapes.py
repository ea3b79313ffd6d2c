"""What the engines with shapes that stay where they are have in common: settings, number of shapes, runs to compare."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

from quickreturn.engines import refusals
from quickreturn.engines.base import USUAL, Comparison
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.own.beam_engine import BeamEngine, BeamSettings, S, gain_of
from quickreturn.engines.settings import setting
from quickreturn.reference_model.mechanism import Follower, Mechanism, Scene
from quickreturn.reference_model.shapes import ShapeSet, clamped_free_modes, hermite_elements, no_shapes
from quickreturn.reference_model.slider_constraint import CLOSED, SliderConstraint

if TYPE_CHECKING:
    from quickreturn.reference_model.model import BeamModel


@dataclass(frozen=True, kw_only=True)
class ShapeSettings(BeamSettings):
    """Settings of the engines that take any shapes."""

    shapes: int = setting(12, "number of shapes (with Hermite elements: two per element)", low=1, high=64)
    family: str = setting("clamped-free", "shapes that stay where they are", choices=("clamped-free", "hermite"))

    @property
    def shape_count(self) -> int:
        """Elements bring two each."""
        return 2 * max(1, self.shapes // 2) if self.family == "hermite" else self.shapes


AnyShapes = TypeVar("AnyShapes", bound=ShapeSettings)

#: Number of clamped-free modes, integration tolerance and what they claim of the tip deflection in run 24 over 2 s, with the slider
#: eliminated or held by a multiplier (`reference_model/RIVALS.md`, section 3).
_RUNGS: Final = (
    (1, 1e-8, 1.3),
    (2, 1e-8, 4.6e-1),
    (3, 1e-8, 1.3e-1),
    (4, 1e-8, 3.9e-2),
    (6, 1e-8, 1.7e-2),
    (10, 1e-9, 9.7e-3),
    (12, 1e-9, 8.8e-3),
    (16, 1e-9, 3.3e-3),
    (20, 1e-9, 2.1e-3),
    (24, 1e-9, 9.8e-4),
    (28, 1e-10, 6.5e-4),
    (32, 1e-10, 4.6e-4),
    (40, 1e-10, 2.4e-4),
)
LADDER: Final = Ladder(
    tuple((ShapeSettings(shapes=shapes, tolerance=tolerance), claim) for shapes, tolerance, claim in _RUNGS),
    size="shapes",
    tolerance="tolerance",
    order=3.0,
)

#: Parts of the shapes, and the factors by which the error is taken to grow where there are no more than those. Shapes that stay err more
#: or less as their waves fit the kink at the slider, so that one difference alone may vanish by accident.
COARSER: Final = ((0.5, 3.0), (0.75, 2.0))
#: Fewer shapes than these have no order yet and are compared with more than twice as many, whose error is taken to be this part.
FEWEST_WITH_ORDER: Final = 8
PART_OF_FINER: Final = 2.0 / 7.0


class StayingEngine(BeamEngine[S]):
    """An engine whose shapes stay where they are."""

    @abstractmethod
    def shapes(self, follower: Follower, settings: S) -> ShapeSet:
        """The shapes of a follower; none for a rigid one."""

    def constraint(self, scene: Scene, settings: S) -> SliderConstraint:
        """What happens to the gap at the slider; unless overridden the follower's angle closes it."""
        return CLOSED

    def model(self, mechanism: Mechanism, settings: S) -> "BeamModel":
        from quickreturn.reference_model.model import BeamModel

        return BeamModel.staying(mechanism, self.shapes(mechanism.follower, settings), self.constraint(mechanism, settings))


class StayingShapesEngine(StayingEngine[AnyShapes]):
    """An engine with clamped-free modes or Hermite elements."""

    def shapes(self, follower: Follower, settings: AnyShapes) -> ShapeSet:
        if follower.is_rigid:
            return no_shapes(follower.length)
        if settings.family == "hermite":
            return hermite_elements(follower.length, settings.shape_count // 2)
        return clamped_free_modes(follower.length, settings.shapes)

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> AnyShapes:
        """Number of shapes from the measured table; fewer where the follower is stiffer than run 24's."""
        rung = LADDER.pick(accuracy, gain_of(mechanism))
        return self.settings_type(shapes=rung.shapes, tolerance=rung.tolerance)

    def comparisons(self, settings: AnyShapes, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        return of_shapes(settings)

    def finer(self, settings: AnyShapes, excess: tuple[float, ...], output_step: float) -> AnyShapes | None:
        """The first rung of the ladder with as many shapes as the estimate asks for."""
        return LADDER.finer(settings, excess)


class RivalEngine(StayingEngine[S]):
    """An engine whose loop is open: the follower's angle is a coordinate of its own, the slider's constraint a force."""

    quantities = USUAL

    def check(self, scene: Scene) -> None:
        """Refuse also parts that the open loop leaves without inertia."""
        super().check(scene)
        refusals.of_massless_parts(self.name, scene, ", whose shapes need mass of their own")


def of_shapes(chosen: ShapeSettings) -> tuple[Comparison, ...]:
    """Two runs with fewer shapes, or one with more where there are too few for that, with the tolerance fit for them."""
    elements = chosen.family == "hermite"  # two shapes each: an odd number is not there
    taken = max(2, chosen.shapes - chosen.shapes % 2) if elements else chosen.shapes
    if taken < FEWEST_WITH_ORDER:
        return (Comparison(chosen, LADDER.sized(chosen, 2 * taken + 2), PART_OF_FINER),)
    fewer = ((round(part * taken), factor) for part, factor in COARSER)
    return tuple(Comparison(chosen, chosen.replaced(shapes=n + n % 2 if elements else n), factor) for n, factor in fewer)
