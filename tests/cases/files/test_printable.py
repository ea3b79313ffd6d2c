"""Things that show themselves in rows: the same texts in a terminal and in a notebook."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator

from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.cases.library import load_case
from quickreturn.plugins.conform.bench import Check, Conformance
from tests.cases.files.scene_texts import SCENE, parse_case

HOSTILE = "</td><script>alert('owned')</script> & \"<b>\""


class Things(Printable):
    def _parts(self) -> Iterator[Cell]:
        yield HOSTILE
        yield Rows([("length", "4", "in"), ("inner", Rows([("one", "1"), ("two", "22")], ("name", "x")), HOSTILE)], ("a", "b", "c"))


def texts_of(html: str) -> list[str]:
    """All texts of well-formed HTML, in order; fails on any element that shows or does anything else."""
    root = ET.fromstring(html)
    known = {"div", "p", "table", "thead", "tbody", "tr", "th", "td"}
    assert {element.tag for element in root.iter()} <= known
    assert {name for element in root.iter() for name in element.attrib} <= {"style"}
    return [text for text in root.itertext() if text]


def words_of(thing: Printable) -> list[str]:
    return " ".join(texts_of(thing._repr_html_())).split()


def test_html_is_well_formed_and_every_text_is_escaped() -> None:
    texts = texts_of(Things()._repr_html_())
    assert texts == [HOSTILE, "a", "b", "c", "length", "4", "in", "inner", "name", "x", "one", "1", "two", "22", HOSTILE]
    root = ET.fromstring(Things()._repr_html_())
    assert len(root.findall("table")) == 1
    assert len(root.findall("table/tbody/tr/td/table")) == 1


def test_text_is_aligned_and_rows_within_rows_stay_in_their_column() -> None:
    assert repr(Things()).splitlines()[1:] == [
        "a       b         c",
        "length  4         in",
        f"inner   name  x   {HOSTILE}",
        "        one   1",
        "        two   22",
    ]


def test_text_and_html_say_the_same() -> None:
    found = Conformance("mine", False, (Check("rows", "passed"), Check("signs", "failed", "tip_x < 0")))
    for thing in (load_case("thesis-24"), load_case("spin-up"), found):
        assert words_of(thing) == repr(thing).split()


def test_a_title_and_a_value_cannot_smuggle_elements() -> None:
    case = parse_case(SCENE.replace('title = "A scene"', "title = '<script>alert(1)</script>'"), "scene.toml")
    assert case.title == "<script>alert(1)</script>"
    assert f"scene: {case.title}" in texts_of(case._repr_html_())
