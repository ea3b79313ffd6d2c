"""Colours: lines at 3:1 and text at 4.5:1 against what they stand on, on light and on dark."""

import re

import pytest

from engines.registry import MAIN, RIVALS
from reports.looks import looks
from reports.page.render import environment

STYLE = environment().get_template("style.css").render(looks={})
LIGHT, DARK = (dict(re.findall(r"--([\w-]+): (#\w+)", block)) for block in re.findall(r"{([^}]*--ground[^}]*)}", STYLE)[:2])


def luminance(colour: str) -> float:
    """Relative luminance (WCAG 2.2)."""
    digits = colour.lstrip("#")
    digits = "".join(2 * digit for digit in digits) if len(digits) == 3 else digits
    parts = [int(digits[k : k + 2], 16) / 255.0 for k in (0, 2, 4)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("engine", [*MAIN, *RIVALS, "somebody's"])
def test_curves_stand_out(engine: str) -> None:
    look = looks([engine])[engine]
    for ground in ("ground", "page"):
        assert contrast(look.light, LIGHT[ground]) >= 4.5
        assert contrast(look.dark, DARK[ground]) >= 4.5
    assert contrast(look.light, LIGHT["quick-wash"]) >= 3.0
    assert contrast(look.dark, DARK["quick-wash"]) >= 3.0


ON_IT = {
    "ground": ("ink", "soft", "accent", "quick-ink"),
    "page": ("ink", "soft", "accent"),
    "open-wash": ("ink", "soft"),
    "quick-wash": ("quick-ink",),
    "bad-wash": ("ink", "bad"),
    "good-wash": ("ink",),
    "accent": ("on-accent",),
}


@pytest.mark.parametrize(("ground", "text"), [(ground, text) for ground, texts in ON_IT.items() for text in texts])
def test_text_can_be_read(ground: str, text: str) -> None:
    for colours in (LIGHT, DARK):
        assert contrast(colours[text], colours[ground]) >= 4.5


def test_edges_of_controls_can_be_seen() -> None:
    for colours in (LIGHT, DARK):
        assert contrast(colours["edge"], colours["ground"]) >= 3.0


def test_engines_can_be_told_apart_without_colour() -> None:
    found = looks([*MAIN, *RIVALS])
    assert len({(look.width, look.dash) for look in found.values()}) == len(found)
