"""Declaration of what a field of a scene measures: unit, meaning, sign, and whether a case file may leave it out."""

from collections.abc import Iterator
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, Final, Literal

Sign = Literal["any", "not negative", "positive"]

_KEY: Final = "quantity"
#: Length of a list that may have any.
ANY_COUNT: Final = 0


@dataclass(frozen=True)
class Quantity:
    """A number with a unit, a list of them, or a table."""

    unit: str  # SI unit, as written in a case file
    meaning: str  # in words
    sign: Sign  # which signs make sense
    key: str  # name in a case file, where it is not that of the field
    optional: bool  # whether a case file may leave it out
    count: int | None  # length of the list, `ANY_COUNT` for any; None for a single number
    infinity: bool  # whether it may be infinite, for a rigid part
    moves: bool  # whether the motion depends on it
    named: bool  # whether a model may lack it: an engine has it only if its `quantities` name it
    in_file: bool  # whether its value is a table, which a case file names or holds
    default: Any  # SI value where a case file leaves it out; None where there is no fixed one

    @property
    def is_number(self) -> bool:
        """Whether its value is a single number."""
        return self.count is None and not self.in_file


def quantity(
    unit: str,
    meaning: str,
    *,
    sign: Sign = "any",
    default: Any = MISSING,
    key: str = "",
    optional: bool | None = None,
    count: int | None = None,
    infinity: bool = False,
    moves: bool = True,
    measured: bool = False,
    named: bool = False,
    in_file: bool = False,
) -> Any:
    """A field of a scene's dataclass; see `Quantity`.

    Unless given, `key` is the field's name, and a quantity with a default is optional. A quantity on which the motion does not depend
    (`moves` False) is ignored in comparisons of scenes and in the key under which a result is stored, unless a measure depends on it
    (`measured`).
    """
    optional = default is not MISSING if optional is None else optional
    declared = Quantity(unit, meaning, sign, key, optional, count, infinity, moves, named, in_file, None if default is MISSING else default)
    return field(default=default, compare=moves or measured, metadata={_KEY: declared})


def quantities_of(part: Any) -> Iterator[tuple[str, str, Quantity]]:
    """Name, key in a case file, and declaration of each field of a part (a dataclass or its instance) that is a quantity."""
    for part_field in fields(part):
        if (declared := part_field.metadata.get(_KEY)) is not None:
            yield part_field.name, declared.key or part_field.name, declared
