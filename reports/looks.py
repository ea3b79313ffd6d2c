"""How each engine is drawn, in the page and in pictures: nested stripes, so that one sees where curves lie on each other.

Width and dashes say what colour-blind eyes cannot tell. Against the page's ground every colour has a contrast of 4.5 and more, on light
and on dark.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Look:
    """Colour on light and on dark, width (CSS pixels), dashes (pixels drawn and left out, none: solid); a higher `order` lies on top."""

    light: str
    dark: str
    width: float
    dash: tuple[float, ...] = ()
    order: int = 0


_LOOKS: Final = {
    "reference": Look("#0072b2", "#4aa8e0", 6.0, order=1),
    "mujoco": Look("#007f59", "#2fc596", 3.4, order=2),
    "exudyn": Look("#141414", "#f4f4f4", 1.5, (7.0, 6.0), order=3),
    "thesis": Look("#c24400", "#ff8a4c", 2.0, order=4),
    "fixed-shapes": Look("#8a4fbe", "#c294f0", 2.0, (11.0, 3.0), order=5),
    "multiplier": Look("#b0457f", "#ee8cc0", 2.0, (3.0, 3.0), order=6),
    "stiff-spring": Look("#8a6500", "#e0b13a", 2.0, (8.0, 3.0, 2.0, 3.0), order=7),
    "nodal-load": Look("#5c6670", "#aab4be", 2.0, (2.0, 4.0), order=8),
}
#: For engines that the project does not know, in the order in which they come.
_OTHERS: Final = (
    Look("#b0457f", "#ee8cc0", 2.0, (9.0, 3.0), order=9),
    Look("#8a6500", "#e0b13a", 2.0, (5.0, 5.0), order=10),
    Look("#8a4fbe", "#c294f0", 2.0, (2.0, 2.0), order=11),
)


def looks(engines: Sequence[str]) -> dict[str, Look]:
    """The look of each of some engines; those that are not the project's share three, in their order."""
    others = iter(range(len(engines)))
    return {name: _LOOKS.get(name) or _OTHERS[next(others) % len(_OTHERS)] for name in engines}
