"""The page on paper, in Chromium."""

import pytest

from tests.reports.in_a_browser import Open


@pytest.mark.verify
def test_on_paper_there_are_stills_no_buttons_and_every_chapter(opened: Open) -> None:
    page = opened("#at=0", color_scheme="dark")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    assert page.locator("#stills canvas").count() == 4
    assert page.locator("button:not(.sort, .remark):visible").count() == 0
    stills = page.locator("#stills canvas").evaluate_all("all => all.map(canvas => canvas.toDataURL())")
    assert len(set(stills)) == 4
    assert page.locator("details.chapter:not([open])").count() == 0
    assert page.locator("details.part[open]").count() == 0
    widths = page.locator(".chart:visible, #signals canvas, #curve").evaluate_all(
        "all => all.map(each => each.getBoundingClientRect().width)"
    )
    assert len(widths) == page.locator(".drawn:visible, #signals canvas, #curve").count()
    assert all(600 < width <= 700 for width in widths)  # of a sheet's 703 between its margins
    sharp = page.locator("#signals canvas").evaluate_all("all => all.map(canvas => canvas.width / canvas.clientWidth)")
    assert min(sharp) > 2.9  # dots to a pixel
    assert page.evaluate("getComputedStyle(document.querySelector('.chart rect')).fill") == "rgb(255, 255, 255)"
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.locator("details[open]").count() == 0


@pytest.mark.verify
def test_all_chapters_are_printed_on_few_pages(opened: Open) -> None:
    """The thesis' own page, with all 24 runs, has 25 at most; this one has three runs."""
    page = opened("#at=0")
    pages = page.pdf(format="A4").count(b"/Type /Page\n")
    assert 8 < pages <= 20
