"""Clamped-free modes or Hermite elements, in any number: settings of the rivals that accept both, their ladder, and runs to compare."""

from dataclasses import dataclass
from typing import Final, TypeVar

from quickreturn.engines.base import Comparison
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.own.beam_engine import BeamSettings
from quickreturn.engines.settings import setting
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.shapes import ShapeSet, clamped_free_modes, hermite_elements


@dataclass(frozen=True, kw_only=True)
class ShapeSettings(BeamSettings):
    """Settings of the engines that accept any fixed shapes."""

    shapes: int = setting(12, "number of shapes (with Hermite elements: two per element)", low=1, high=64)
    family: str = setting("clamped-free", "shapes that stay where they are", choices=("clamped-free", "hermite"))

    @property
    def shape_count(self) -> int:
        """See `BeamSettings.shape_count`; an element has two."""
        return 2 * max(1, self.shapes // 2) if self.family == "hermite" else self.shapes


AnyShapes = TypeVar("AnyShapes", bound=ShapeSettings)

#: Number of clamped-free modes, tolerance of the implicit integration, and the error of the tip deflection that they claim in run 24
#: over 2 s, with the slider eliminated or held by a multiplier (`reference_model/RIVALS.md`, section 3).
_RUNGS: Final = (
    (1, 1e-3, 1.3),
    (2, 1e-3, 4.6e-1),
    (3, 1e-3, 1.4e-1),
    (4, 1e-3, 4.4e-2),
    (6, 3e-4, 2.0e-2),
    (10, 1e-4, 1.1e-2),
    (12, 1e-4, 9.7e-3),
    (16, 3e-5, 3.8e-3),
    (20, 1e-5, 2.4e-3),
    (24, 1e-5, 1.3e-3),
    (28, 3e-6, 7.4e-4),
    (32, 3e-6, 5.6e-4),
    (40, 1e-6, 2.7e-4),
)


def ladder_of(kind: type[AnyShapes]) -> Ladder[AnyShapes]:
    """The ladder with settings of a kind."""
    rungs = ((kind(shapes=shapes, tolerance=tolerance), claim) for shapes, tolerance, claim in _RUNGS)
    return Ladder(tuple(rungs), size="shapes", tolerance="tolerance", order=3.0)


LADDER: Final = ladder_of(ShapeSettings)

#: Two coarser runs for the estimate: number of shapes over that of the run, and assumed error over that of the run. The error of fixed
#: shapes depends on how their waves fit the kink at the slider, so that one difference alone may vanish by accident.
COARSER: Final = ((0.5, 3.0), (0.75, 2.0))
#: Smallest number of shapes whose error has an order. Fewer are compared with more than twice as many, and the assumed error of those over
#: that of the run.
FEWEST_WITH_ORDER: Final = 8
PART_OF_FINER: Final = 2.0 / 7.0


def shapes_of(settings: ShapeSettings, length: float) -> ShapeSet:
    """The shapes of a flexible follower of this length (m)."""
    if settings.family == "hermite":
        return hermite_elements(length, settings.shape_count // 2)
    return clamped_free_modes(length, settings.shapes)


def compared_shapes(settings: ShapeSettings, mechanism: Mechanism) -> tuple[Comparison, ...]:
    """Comparisons with two runs of fewer shapes; or with one of more shapes and a tolerance to match, where there are too few for that."""
    if (count := settings.shape_count) < FEWEST_WITH_ORDER:
        return (Comparison(settings, LADDER.sized(settings, 2 * count + 2), PART_OF_FINER, of="modes"),)
    even = settings.family == "hermite"  # an element has two shapes
    fewer = ((round(ratio * count), factor) for ratio, factor in COARSER)
    return tuple(Comparison(settings, settings.replaced(shapes=n + n % 2 if even else n), factor, of="modes") for n, factor in fewer)
