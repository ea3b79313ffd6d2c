"""The look of each engine and each signal, everywhere: in the page's plots, curves and mechanism, and in pictures.

A look belongs to a name, so a method keeps its colour, dashes and mark from chart to chart. Where curves coincide, all of them show: the
reference is a broad solid line, and the dashes of thesis, mujoco and exudyn on it have one period and are offset, so that each shows in its
own colour. Colours are also distinct for colour-blind eyes (`tests/reports/test_line_styles.py`), and have a contrast ratio of at least 3
with a light and a dark ground; names are written in the colour of text.
"""

import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Look:
    """The look of a line and of its marks."""

    light: str  # colour on a light ground
    dark: str  # colour on a dark ground
    width: float  # of the line, CSS pixels
    dash: tuple[float, ...] = ()  # pixels drawn and left out; empty for a solid line
    offset: float = 0.0  # offset into the dashes at which a line begins, pixels
    order: int = 0  # of two looks the higher one lies on top
    # shape of marks: "circle", "square", "diamond", "triangle", "triangle-down", "triangle-left", "triangle-right", "pentagon",
    # "hexagon", "star", "plus" or "cross"
    marker: str = "circle"


_BLUE: Final = ("#1062c8", "#38b0ff")
_VERMILION: Final = ("#d95f02", "#f08a30")
_TEAL: Final = ("#00937f", "#00937c")
_INK: Final = ("#111111", "#fcfcf4")
_PURPLE: Final = ("#45167a", "#b653ba")
_WINE: Final = ("#7d2b49", "#fb7aa9")
_BROWN: Final = ("#754202", "#e8ec3a")
_OLIVE: Final = ("#7e8c5a", "#9c8f54")
_SKY: Final = ("#2c8dcd", "#6078ff")
_NAVY: Final = ("#00009b", "#ded0ff")
_FOREST: Final = ("#00330a", "#c8f38d")

#: Looks of the project's engines.
ENGINES: Final = {
    "reference": Look(*_BLUE, 5.5, order=1, marker="circle"),
    # of each period of 26 pixels thesis draws 0 to 20, mujoco above it 6 to 20, and exudyn on top 15 to 24
    "thesis": Look(*_VERMILION, 2.6, (20.0, 6.0), order=2, marker="diamond"),
    "mujoco": Look(*_TEAL, 3.4, (14.0, 12.0), 20.0, order=3, marker="triangle-down"),
    "exudyn": Look(*_INK, 2.4, (9.0, 17.0), 11.0, order=4, marker="triangle"),
    "fixed-shapes": Look(*_PURPLE, 2.4, (11.0, 3.0), order=5, marker="square"),
    "multiplier": Look(*_WINE, 2.4, (3.0, 3.0), order=6, marker="cross"),
    "stiff-spring": Look(*_BROWN, 2.4, (8.0, 3.0, 2.0, 3.0), order=7, marker="plus"),
    "nodal-load": Look(*_OLIVE, 2.4, (2.0, 4.0), order=8, marker="pentagon"),
    "moving-boundaries": Look(*_FOREST, 2.4, (14.0, 3.0, 2.0, 3.0), order=9, marker="star"),
    "derived": Look(*_NAVY, 2.4, (5.0, 8.0), order=10, marker="hexagon"),
}
#: Looks of quantities, in charts of one engine.
SIGNALS: Final = {
    "tip_deflection": Look(*_SKY, 5.0, order=1, marker="circle"),
    "tip_acceleration": Look(*_NAVY, 2.6, order=6, marker="square"),
    "strain_1": Look(*_WINE, 2.6, (15.0, 5.0), order=2, marker="triangle"),
    "strain_2": Look(*_BROWN, 2.6, (10.0, 10.0), order=3, marker="diamond"),
    "strain_3": Look(*_OLIVE, 2.6, (5.0, 5.0), order=4, marker="triangle-down"),
    "slider_force": Look(*_PURPLE, 2.6, (2.0, 4.0), order=5, marker="star"),
}
#: Looks of a resonance curve: its parts and special points.
RESONANCE: Final = {
    "stable": Look(*_BLUE, 3.4, order=1),
    "unstable": Look(*_VERMILION, 3.0, (6.0, 4.0), order=2),
    "fold": Look(*_WINE, 2.4, order=4, marker="diamond"),
    "period doubling": Look(*_TEAL, 2.4, order=5, marker="square"),
    "torus": Look(*_OLIVE, 2.4, order=6, marker="pentagon"),
    "slider left": Look(*_BROWN, 2.4, order=7, marker="cross"),
    "lost": Look(*_NAVY, 2.4, order=8, marker="plus"),
}
#: Looks of all other names.
_OTHERS: Final = (
    Look(*_SKY, 2.4, (9.0, 3.0), order=9, marker="hexagon"),
    Look(*_NAVY, 2.4, (5.0, 5.0), order=10, marker="star"),
    Look(*_FOREST, 2.4, (12.0, 3.0, 3.0, 3.0), order=11, marker="triangle-left"),
    Look(*_WINE, 2.4, (6.0, 2.0), order=12, marker="triangle-right"),
    Look(*_BROWN, 2.4, (2.0, 2.0), order=13, marker="square"),
)


def looks(names: Iterable[str]) -> dict[str, Look]:
    """Name -> its look, for engines, signals and any other names.

    An unknown name gets one of five looks, chosen by the name's checksum (CRC-32), or the next look that is free. With more than five
    unknown names looks repeat.
    """
    wanted = list(dict.fromkeys(names))
    project_looks = ENGINES | SIGNALS | RESONANCE
    chosen = {name: project_looks[name] for name in wanted if name in project_looks}
    for name in sorted(set(wanted) - set(chosen)):
        taken, first = list(chosen.values()), zlib.crc32(name.encode()) % len(_OTHERS)
        chosen[name] = min(_OTHERS[first:] + _OTHERS[:first], key=taken.count)
    return {name: chosen[name] for name in wanted}
