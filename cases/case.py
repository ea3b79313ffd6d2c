"""A case: one scene, and what to simulate of it; and every key of its file, as `reference_model.mechanism` and `Case` declare them."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

from cases.errors import CaseError
from cases.units import DIMENSIONS, Dimension
from reference_model.mechanism import Mechanism, Scene
from reference_model.quantities import Quantity, quantities_of, quantity
from reference_model.scene_values import SECTIONS as SECTIONS_OF_SCENE
from reference_model.scene_values import values_of


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
        rows = [(f"{section}.{key}", value) for section, keys in self.values.items() for key, value in keys.items()]
        lines = [f"  {path:30} {shown_value(value)} {PATHS[path].unit}".rstrip() for path, value in rows]
        return "\n".join([f"{self.name}: {self.title}", *lines])

    @property
    def values(self) -> dict[str, dict[str, Any]]:
        """Values in SI by section and key of the case file; sections and keys that the scene lacks are left out."""
        return {**values_of(self.scene), "simulation": {"duration": self.duration, "output_step": self.output_step}}

    def to_toml(self) -> str:
        """The text of a case file for the same case, in SI units, each key with its meaning. CaseError: a value that no file can hold."""
        from cases.document import document_of
        from cases.written import as_toml

        return as_toml(document_of(self))

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


def shown_value(value: Any) -> str:
    """A number, or several, to nine digits."""
    return ", ".join(map(shown_value, value)) if isinstance(value, (list, tuple)) else f"{value:.9g}"


#: Section -> key -> quantity.
SECTIONS: Final[Mapping[str, Mapping[str, Quantity]]] = MappingProxyType(
    {**SECTIONS_OF_SCENE, "simulation": {key: found for _, key, found in quantities_of(Case)}}
)
#: Keys outside all sections.
HEADER: Final = ("name", "title", "tags")
#: Dotted path -> quantity, in the order of the file.
PATHS: Final = MappingProxyType({f"{section}.{name}": found for section, keys in SECTIONS.items() for name, found in keys.items()})


def dimension_of(path: str) -> Dimension:
    """What the quantity at a dotted path must measure."""
    return DIMENSIONS[PATHS[path].unit]
