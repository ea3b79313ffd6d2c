"""What a run to an accuracy asks of an engine, whichever kind of scene it simulates."""

from typing import Any, Protocol, TypeVar

from engines.base import Comparison, EstimateOf, ModelDescription, Simulation
from reference_model.mechanism import Scene

S = TypeVar("S", bound=Scene)
S_in = TypeVar("S_in", bound=Scene, contravariant=True)


class Solver(Protocol[S_in]):
    """An `Engine` is one for the mechanism, a `FollowerEngine` for the follower alone; see there. Settings are its own."""

    @property
    def name(self) -> str:
        """As typed on the command line."""

    @property
    def compiles(self) -> bool:
        """Whether code is compiled or loaded on first use."""

    @property
    def default_accuracy(self) -> float:
        """Error of the tip deflection that the default settings aim at."""

    @property
    def estimates(self) -> EstimateOf:
        """What the error estimate is an estimate of."""

    def check(self, scene: S_in, /) -> None:
        """Raise `Refusal` if a feature of the scene cannot be modelled."""

    def describe(self, scene: S_in, settings: Any, /) -> ModelDescription:
        """What `prepare` builds."""

    def settings_for(self, accuracy: float, scene: S_in, /) -> Any:
        """Where to start for an accuracy."""

    def comparisons(self, settings: Any, scene: S_in, output_step: float, /) -> tuple[Comparison, ...]:
        """Pairs of runs that show the parts of the error."""

    def finer(self, settings: Any, excess: tuple[float, ...], output_step: float, /) -> Any | None:
        """The next finer rung."""

    def prepare(self, scene: S_in, start: Any, settings: Any, /) -> Simulation:
        """Build the model in the state `start`."""
