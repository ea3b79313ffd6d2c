"""A report on made-up runs, opened in Chromium: one browser and one page for all tests of a process."""

import os
import shutil
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Page, sync_playwright

from quickreturn.plugins.methods.tests.made_up_map import made_up_map
from quickreturn.plugins.methods.tests.made_up_races import made_up_fronts, made_up_race
from quickreturn.plugins.methods.tests.pages import of_studies
from quickreturn.plugins.thesis.page_data import inference_of
from quickreturn.plugins.thesis.tests.made_up_inference import made_up_inference
from quickreturn.reports.report import machine_facts, write
from tests.reports.in_a_browser import RESULTS, Open, Tabs
from tests.reports.pages import content_of
from tests.slices import IN_A_BROWSER

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


@pytest.fixture(scope="session")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A report on three made-up runs, in one of which an engine failed."""
    folder = tmp_path_factory.mktemp("page")
    fronts = made_up_fronts(made_up_race(), made_up_race("thesis-17"))
    write(
        content_of(
            results=RESULTS,
            data=of_studies(fronts=fronts, classes=made_up_map()) | {inference_of: made_up_inference()},
            facts=machine_facts(),
        ),
        folder,
    )
    return (folder / "index.html").as_uri()


#: What is open in this process, and the tabs; empty before the first test in a browser, and after the last.
_open = ExitStack()
_tabs: list[Tabs] = []


@pytest.fixture
def tabs() -> Tabs:
    """Those of the browser, which stays open from the first test in it to the last."""
    if CHROMIUM is None and os.environ.get("CI") != "true":
        pytest.skip("no Chromium was found (Debian: apt-get install chromium)")
    assert CHROMIUM is not None, "no Chromium was found, and CI is true"
    if not _tabs:
        playwright = _open.enter_context(sync_playwright())
        _tabs.append(Tabs(_open.enter_context(playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"]))))
    return _tabs[0]


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(nextitem: pytest.Item | None) -> None:
    """Close the browser after the last test in it: its event loop is in the way of other tests."""
    if nextitem is None or not nextitem.path.name.endswith(IN_A_BROWSER):
        _tabs.clear()
        _open.close()


@pytest.fixture
def opened(tabs: Tabs, address: str) -> Iterator[Open]:
    """Open the page at a place in it; whatever the browser complains of fails the test."""

    def open_page(
        place: str = "",
        url: str = address,
        width: int = 1400,
        height: int = 900,
        has_touch: bool = False,
        reduced_motion: str = "no-preference",
        color_scheme: str = "light",
    ) -> Page:
        page = tabs.take(has_touch, reduced_motion, color_scheme)
        page.set_viewport_size({"width": width, "height": height})
        page.goto(url + place)
        page.wait_for_selector("html[data-ready=true]", timeout=10_000)
        return page

    yield open_page
    assert tabs.leave_all() == []
