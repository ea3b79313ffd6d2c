"""Every key of a case file, by section: those of the scene as `reference_model.mechanism` declares them, and the simulation's times."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from cases.case import Case
from cases.units import DIMENSIONS, Dimension
from reference_model.quantities import Quantity, key_of, quantities_of
from reference_model.scene_values import SECTIONS as SECTIONS_OF_SCENE

#: Section -> key -> quantity.
SECTIONS: Final[Mapping[str, Mapping[str, Quantity]]] = MappingProxyType(
    {**SECTIONS_OF_SCENE, "simulation": {key_of(declared, found): found for declared, found in quantities_of(Case)}}
)
#: Keys outside all sections.
HEADER: Final = ("name", "title", "tags")
#: Dotted path -> quantity, in the order of the file.
PATHS: Final = MappingProxyType({f"{section}.{name}": found for section, keys in SECTIONS.items() for name, found in keys.items()})


def dimension_of(path: str) -> Dimension:
    """What the quantity at a dotted path must measure."""
    return DIMENSIONS[PATHS[path].unit]
