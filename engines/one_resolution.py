"""A base for engines with one resolution, whose error falls by a known power of it: ladder, estimate and version follow from both."""

import math
from collections.abc import Mapping
from typing import ClassVar, Final, Self, TypeVar

from quickreturn.engines.base import Comparison, Engine, installed
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.reference_model.mechanism import Scene

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
