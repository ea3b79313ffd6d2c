"""A case: one scene, and what to simulate of it."""

from dataclasses import dataclass

from cases.errors import CaseError
from reference_model.mechanism import Mechanism, Scene
from reference_model.quantities import quantity


@dataclass(frozen=True, kw_only=True)
class Case:
    """A named scene in SI units with its simulation times.

    Attributes:
        name: as used on the command line.
        title: one line for people.
        tags: groups that the case belongs to, e.g. "thesis".
        scene: the mechanism, or a follower alone.
        duration: s, a whole multiple of `output_step`.
        output_step: s.
        notes: what a reader of results must know, e.g. which published value was replaced and why, or which value is hardly meant.
        source: the file's path, or "library".
    """

    name: str
    title: str
    tags: tuple[str, ...]
    scene: Scene
    duration: float = quantity("s", "time to simulate, a multiple of output_step", sign="positive")
    output_step: float = quantity("s", "between rows of a trajectory", sign="positive")
    notes: tuple[str, ...] = ()
    source: str = ""

    @property
    def mechanism(self) -> Mechanism:
        """The scene, where crank and slider are needed.

        Raises:
            CaseError: it has none.
        """
        if isinstance(self.scene, Mechanism):
            return self.scene
        raise CaseError(
            self.name, "[crank]", None, "this case has no crank and no slider, and what is asked needs them", "use show or simulate"
        )
