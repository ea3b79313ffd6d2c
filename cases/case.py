"""A case: one scene, and what to simulate of it."""

from dataclasses import dataclass

from cases.errors import CaseError
from reference_model.mechanism import Mechanism, Scene
from reference_model.quantities import quantity
from reference_model.scene_values import SECTIONS, Value, values_of


@dataclass(frozen=True, kw_only=True, repr=False)
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

    def __repr__(self) -> str:
        """Name, title and the values in SI, one to a line."""
        rows = [
            (f"{section}.{key}", value, SECTIONS[section][key].unit)
            for section, keys in values_of(self.scene).items()
            for key, value in keys.items()
        ]
        rows += [(f"simulation.{key}", getattr(self, key), "s") for key in ("duration", "output_step")]
        lines = [f"  {path:30} {_text(value)} {unit}".rstrip() for path, value, unit in rows]
        return "\n".join([f"{self.name}: {self.title}", *lines])

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


def _text(value: Value) -> str:
    return ", ".join(map(_text, value)) if isinstance(value, tuple) else f"{value:.9g}"
