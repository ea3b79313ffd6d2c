"""The resonance curve on the page of one's own machine, in Chromium: lines, marks and texts, and what pointer and keys read off."""

import pytest
from playwright.sync_api import Locator, Page

from quickreturn.plugins.studies.around import around_of
from quickreturn.plugins.studies.tests.made_up_resonance import RPM, height, made_up_around, speed
from quickreturn.reports.page.content import Content
from quickreturn.reports.report import machine_facts, write
from tests.reports.in_a_browser import Open
from tests.reports.page.test_charts_in_a_browser import TEXTS, assert_fitting
from tests.reports.reported_results import reported_result

AROUND = made_up_around()


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The page of one machine."""
    folder = tmp_path_factory.mktemp("own")
    write(Content(results=[reported_result("example")], data={around_of: [AROUND]}, facts=machine_facts()), folder)
    return (folder / "index.html").as_uri()


def chart(opened: Open, width: int = 1400) -> tuple[Page, Locator]:
    page = opened("#chapter=resonance", reduced_motion="reduce", width=width)
    found = page.locator("#resonance .chart")
    found.wait_for()
    return page, found


@pytest.mark.parametrize("width", [390, pytest.param(1400, marks=pytest.mark.verify)])
@pytest.mark.verify
def test_it_fits_and_no_text_covers_another(opened: Open, width: int) -> None:
    page, found = chart(opened, width)
    name, box, texts = next(each for each in page.evaluate(TEXTS) if each[0].startswith("The resonance curve"))
    assert_fitting(name, box, texts)
    assert {"8×", "your machine runs here", "crank speed [rpm]", "largest tip acceleration in a turn [m/s²]"} <= {
        text for text, *_ in texts
    }
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert found.bounding_box()["width"] <= width  # type: ignore[index]


@pytest.mark.verify
def test_unstable_parts_are_dashed_and_the_machine_is_marked(opened: Open) -> None:
    _, found = chart(opened)
    script = """all => all.map(each => [each.parentElement.dataset.series, each.getAttribute("stroke-dasharray")])"""
    lines = found.locator("polyline").evaluate_all(script)
    assert [name for name, _ in lines] == ["stable", "stable", "unstable"]
    assert [dashes == "none" for _, dashes in lines] == [True, True, False]
    marks = found.locator("[data-series='your machine'] polygon")
    assert marks.count() == 3
    line = found.locator("line[stroke-dasharray='2 3']").bounding_box()
    for mark in marks.all():
        box = mark.bounding_box()
        assert box["x"] + box["width"] / 2.0 == pytest.approx(line["x"] + line["width"] / 2.0, abs=0.6)


@pytest.mark.verify
def test_arrow_keys_go_along_the_curve_and_to_other_series(opened: Open) -> None:
    page, found = chart(opened)
    told = page.locator("#resonance .reading")
    found.focus()
    page.keyboard.press("ArrowRight")
    first = told.inner_text()
    pace = AROUND.own / RPM
    assert first.startswith(f"stable: {pace * speed(-1.0):.5g} rpm, {height(-1.0):.4g} m/s²")
    page.keyboard.press("ArrowRight")
    assert told.inner_text() != first
    page.keyboard.press("ArrowLeft")
    assert told.inner_text() == first
    seen = []
    for _ in range(5):
        page.keyboard.press("ArrowDown")
        seen.append(told.inner_text().partition(":")[0])
    assert seen == ["unstable", "peak", "fold", "your machine", "stable"]
    assert found.locator("circle[visibility=visible]").count() == 1
