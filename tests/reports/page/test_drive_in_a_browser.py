"""The chapter on motor and bearings, in Chromium: bars stand on zero, forces have one scale along both axes, texts fit."""

from typing import Any

import pytest
from playwright.sync_api import Page

from quickreturn.reports.page.content import Content
from quickreturn.reports.report import machine_facts, write
from tests.reports.in_a_browser import Open
from tests.reports.page.test_charts_in_a_browser import TEXTS, assert_fitting
from tests.reports.reported_results import reported_result

NAMES = ("Harmonics of the torque", "Force in the bearing P", "Force in the bearing O")


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The page of a machine at a prescribed speed."""
    folder = tmp_path_factory.mktemp("drive")
    write(Content(results=[reported_result("hard-shaper-steel")], facts=machine_facts()), folder)
    return (folder / "index.html").as_uri()


def charts(opened: Open, width: int) -> tuple[Page, list[list[Any]]]:
    page = opened("#chapter=drive", reduced_motion="reduce", width=width)
    page.locator("#drive .chart").last.wait_for()
    found = [each for each in page.evaluate(TEXTS) if each[0].startswith(NAMES)]
    assert len(found) == len(NAMES)
    return page, found


@pytest.mark.parametrize("width", [390, pytest.param(1400, marks=pytest.mark.verify)])
@pytest.mark.verify
def test_they_fit_and_no_text_covers_another(opened: Open, width: int) -> None:
    page, found = charts(opened, width)
    for each in found:
        assert_fitting(*each)
    assert {"amplitude [N m]", "harmonic of the crank’s turn", "8"} <= {text for text, *_ in found[0][2]}
    for _, _, texts in found[1:]:
        assert {"along n₁ [N]", "along n₂ [N]", "0°", "90°"} <= {text for text, *_ in texts}
    assert page.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.verify
def test_bars_stand_on_zero_beside_each_other_and_say_what_they_are(opened: Open) -> None:
    page, _ = charts(opened, 1400)
    chart = page.locator("#drive .chart").first
    script = """all => all.map(each => [each.parentElement.dataset.series,
        each.x.baseVal.value, each.y.baseVal.value + each.height.baseVal.value])"""
    bars = chart.locator("[data-series] rect").evaluate_all(script)
    assert len(bars) == 4 * 8
    assert max(foot for *_, foot in bars) - min(foot for *_, foot in bars) < 0.01
    first = {name: next(x for other, x, _ in bars if other == name) for name, *_ in bars}
    assert sorted(first, key=first.__getitem__) == ["thesis", "reference", "exudyn", "mujoco"]
    chart.focus()
    page.keyboard.press("ArrowRight")
    assert page.locator("#drive .reading").first.inner_text().startswith("reference: harmonic 1, 1.530")


@pytest.mark.parametrize("width", [390, pytest.param(1400, marks=pytest.mark.verify)])
@pytest.mark.verify
def test_forces_have_one_scale_along_both_axes_and_show_where_they_begin(opened: Open, width: int) -> None:
    page, _ = charts(opened, width)
    script = """all => all.map(chart => {
        const [series] = JSON.parse(chart.closest(".drawn").previousElementSibling.textContent).series;
        const line = chart.querySelector(`[data-series="${series.name}"] polyline`).getAttribute("points");
        const points = line.split(" ").map(each => each.split(",").map(Number));
        const range = all => Math.max(...all) - Math.min(...all);
        const text = [...chart.querySelectorAll("text")].filter(each => each.textContent === "0").length;
        return [range(points.map(each => each[0])) / range(series.x), range(points.map(each => each[1])) / range(series.y), text];
    })"""
    scales = page.locator("#drive .pair .chart").evaluate_all(script)
    assert len(scales) == 2
    for along, across, zeros in scales:
        assert along == pytest.approx(across, rel=0.02)
        assert zeros == 2
