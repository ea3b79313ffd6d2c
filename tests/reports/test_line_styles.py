"""Looks: a colour and a mark for each name, told apart by colour-blind eyes, too; lines at 3:1 and text at 4.5:1 against their ground."""

import re
from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_hex

from quickreturn.engines.registry import MAIN, own_engines
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.reference_model.arrays import Array
from quickreturn.reports.drawing.style import all_looks
from quickreturn.reports.line_styles import ENGINES, SIGNALS, looks
from quickreturn.reports.page.render import KINDS, environment

STYLE = environment().get_template("style.css").render(engines=(), looks={})
LIGHT, DARK = (dict(re.findall(r"--([\w-]+): (#\w+)", block)) for block in re.findall(r"{([^}]*--ground[^}]*)}", STYLE)[:2])

#: What eyes without one kind of cones make of linear RGB: Machado, Oliveira and Fernandes (2009), severity 1.
EYES = {
    "all cones": np.eye(3),
    "deuteranopia": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    "protanopia": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
}
#: Of linear RGB to XYZ over that of white (IEC 61966-2-1).
XYZ = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]])
XYZ /= XYZ.sum(axis=1, keepdims=True)
#: Distance in CIE L*a*b* (1976) that colours keep: eight times what can just be told apart side by side (2.3).
APART = 8 * 2.3


def linear(colour: str) -> Array:
    """Linear RGB."""
    digits = colour.lstrip("#")
    digits = "".join(2 * digit for digit in digits) if len(digits) == 3 else digits
    parts = np.array([int(digits[k : k + 2], 16) / 255.0 for k in (0, 2, 4)])
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def luminance(colour: str) -> float:
    """Relative luminance (WCAG 2.2)."""
    return float(np.array([0.2126, 0.7152, 0.0722]) @ linear(colour))


def lab(colour: str, eyes: Array) -> Array:
    """CIE L*a*b* of a colour as some eyes see it."""
    part = XYZ @ np.clip(eyes @ linear(colour), 0.0, 1.0)
    x, y, z = np.where(part > 216.0 / 24389.0, np.cbrt(part), (24389.0 / 27.0 * part + 16.0) / 116.0)
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("engine", [*ENGINES, "somebody's"])
def test_curves_stand_out(engine: str) -> None:
    look = looks([engine])[engine]
    for ground in ("ground", "page"):
        assert contrast(look.light, LIGHT[ground]) >= 3.0
        assert contrast(look.dark, DARK[ground]) >= 3.0
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


@pytest.mark.parametrize("eyes", EYES)
@pytest.mark.parametrize("names", [(*ENGINES, "press", "a.csv", "mine"), tuple(SIGNALS)], ids=["engines", "signals"])
def test_colours_keep_apart_for_every_eye(names: tuple[str, ...], eyes: str) -> None:
    found = looks(names)
    for scheme in ("light", "dark"):
        colours = {getattr(look, scheme) for look in found.values()}
        near = [np.linalg.norm(lab(one, EYES[eyes]) - lab(other, EYES[eyes])) for one, other in combinations(sorted(colours), 2)]
        assert min(near) >= APART


@pytest.mark.parametrize("names", [tuple(ENGINES), tuple(SIGNALS)], ids=["engines", "signals"])
def test_names_can_be_told_apart_without_colour(names: tuple[str, ...]) -> None:
    found = looks(names)
    assert len({(look.width, look.dash) for look in found.values()}) == len(found)
    assert len({look.marker for look in found.values()}) == len(found)
    assert len({look.light for look in found.values()}) == len({look.dark for look in found.values()}) == len(found)


def test_every_engine_of_the_project_has_a_look_and_two_words_of_its_own() -> None:
    assert set(own_engines()) - {"mujoco-contact"} == set(ENGINES) == set(KINDS)


def test_a_name_has_its_look_in_any_company() -> None:
    alone, among = looks(["press"])["press"], looks([*MAIN, "press", *SIGNALS])["press"]
    assert alone == among == looks(["press", "reference"])["press"]
    assert looks([*RIVALS, *MAIN])["mujoco"] == looks(["mujoco"])["mujoco"]


def test_pictures_have_the_colours_of_the_page() -> None:
    names = [*ENGINES, "press"]
    assert {name: to_hex(style["color"]) for name, style in all_looks(names).items()} == {
        name: look.light for name, look in looks(names).items()
    }
