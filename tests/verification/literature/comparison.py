"""One computed value beside one that comes from elsewhere."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

Kind = Literal["published", "closed form"]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A row of a table of comparisons.

    Attributes:
        case: whose scene was simulated.
        engine: name.
        quantity: what, in words.
        unit: of the values.
        computed: by the engine.
        expected: the value from elsewhere.
        scale: size that differences are related to: the expected value, or something of its kind where that is zero.
        bound: largest difference over `scale` that is to be expected, the sum of what both sides leave open.
        reason: where the bound comes from.
        kind: a published number, or a closed form evaluated here.
        source: of the expected value.
        seen: whether the published number was read in a text; of a closed form, which is derived here, True.
        note: what a reader must know; may be empty.
    """

    case: str
    engine: str
    quantity: str
    unit: str
    computed: float
    expected: float
    scale: float
    bound: float
    reason: str
    kind: Kind
    source: str
    seen: bool = True
    note: str = ""

    @property
    def difference(self) -> float:
        """Computed less expected, over `scale`."""
        return (self.computed - self.expected) / self.scale

    @property
    def agrees(self) -> bool:
        """Whether the difference is within the bound."""
        return abs(self.difference) <= self.bound

    def as_dict(self) -> dict[str, Any]:
        """Plain values by name, for tables and JSON."""
        return asdict(self) | {"difference": self.difference, "agrees": self.agrees}
