"""Plots of the page as data, the drawing's joint and force among them: they show what the results say, and every name has a look."""

import json
import math
import re
from typing import Any

import pytest

from quickreturn.engines.registry import MAIN
from quickreturn.plugins.methods.tests.made_up_races import made_up_fronts
from quickreturn.plugins.methods.tests.pages import of_studies
from quickreturn.reference_model.slider import Slider
from quickreturn.reports.line_styles import looks
from quickreturn.reports.page.chapter import Plot
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.render import report_page
from quickreturn.reports.page.view import _scene, shown_first
from quickreturn.reports.words import QUANTITY
from tests.engines.scenes import run_24
from tests.reports.pages import chapter_of, content_of
from tests.reports.reported_results import reported_result

RESULTS = [reported_result("thesis-24"), reported_result("thesis-17", seed=3)]
CONTENT = content_of(results=RESULTS, data=of_studies(fronts=made_up_fronts()))


def plots(chapter: str) -> list[Plot]:
    return list(chapter_of(CONTENT, chapter).plots)


def test_every_comparison_is_a_dot_at_its_difference_over_the_tolerance() -> None:
    plot = plots("agreement")[0]
    checks = [check for result in RESULTS for check in result.checks]
    assert len(checks) > 50
    assert sum(len(series.y) for series in plot.series) == len(checks)
    for series in plot.series:
        of_engine = [check for check in checks if check.engine == series.name]
        for check, row, used, text in zip(of_engine, series.x, series.y, series.text, strict=True):
            assert row == QUANTITY[check.quantity]
            assert (used > 1.0) == (abs(check.number.value - check.other_number.value) > check.tolerance)
            assert text.endswith("of the tolerance")
    assert plot.limit == (1.0, "tolerance")


def test_a_curve_of_differences_over_the_tolerance_has_the_largest_difference_of_the_waveforms() -> None:
    along, result = plots("agreement")[1], shown_first(RESULTS)
    *engines, limit = along.series
    assert set(limit.y) == {1.0}
    assert engines
    for series in engines:
        checks = [check for check in result.checks if (check.engine, check.quantity) == (series.name, "largest_difference")]
        largest = max(abs(check.difference) / check.tolerance for check in checks)
        assert 0.8 * largest <= max(series.y) <= largest * (1.0 + 1e-9)  # every second crank angle is drawn


def test_errors_are_drawn_in_percent() -> None:
    worst, deflection = plots("methods")
    points = {series.name: series for series in worst.series}
    assert list(points["multiplier"].y) == [100.0 * free**-3.0 for free in (2, 4, 8, 16)]  # the made-up method's power law
    assert worst.below == deflection.below == 0.01


def test_the_page_has_a_look_for_every_name_that_it_draws() -> None:
    page = report_page(CONTENT, list(chapters_of(CONTENT)))
    known = json.loads(re.search(r'id="view">(.*?)</script>', page, re.S)[1])["looks"]  # type: ignore[index]
    drawn = [json.loads(found) for found in re.findall(r'<script type="application/json">(.*?)</script>', page, re.S)]
    names = {series["of"] for plot in drawn for series in plot["series"]} | set(MAIN)
    assert len(drawn) == sum(len(list(chapter.plots)) for chapter in chapters_of(CONTENT)) >= 3
    assert names - {""} <= set(known)
    assert {name: look["light"] for name, look in known.items()} == {name: look.light for name, look in looks(known).items()}


def test_no_cell_of_the_page_is_written_as_a_computer_writes_numbers() -> None:
    page = report_page(CONTENT, list(chapters_of(CONTENT)))
    cells = re.findall(r'<td class=" \w*" data-value="[^"]*">([^<]*)<', page)
    assert len(cells) > 100
    assert [cell for cell in cells if re.search(r"\de[+−-]?\d", cell)] == []


DRAWN: dict[str, tuple[Slider, Any]] = {
    "rigid": (Slider(), None),
    "linear": (Slider(joint_stiffness=1e4), {"free": False, "soft": [False, False]}),
    "plus soft": (Slider(joint_stiffness_plus=1e4), {"free": False, "soft": [True, False]}),
    "minus softer": (Slider(joint_stiffness_plus=4e4, joint_stiffness_minus=1e4), {"free": False, "soft": [False, True]}),
    "clearance": (Slider(clearance=2e-4), {"free": True, "soft": [False, False]}),
}


@pytest.mark.parametrize("joint", DRAWN)
def test_rollers_are_drawn_apart_with_clearance_and_dashed_where_softer(joint: str) -> None:
    slider, drawn = DRAWN[joint]
    assert _scene(run_24(slider=slider))["rollers"] == drawn


def test_the_force_points_its_way_where_it_acts() -> None:
    """Down from 90 to 270 deg; or against the arm's end, with which it turns."""
    down = _scene(run_24(tip={"force": (0.0, -5.0), "force_from": 0.5 * math.pi, "force_to": 1.5 * math.pi}))["force"]
    assert not down["follows"]
    ways = down["ways"]
    acting = [at * 360 // len(ways) for at, way in enumerate(ways) if way is not None]
    assert (acting[0], acting[-1]) == (95, 265)
    assert {way for way in ways if way is not None} == {-1.571}
    assert _scene(run_24(tip={"force_following": (-5.0, 0.0)}))["force"] == {"follows": True, "ways": [3.142] * len(ways)}
    assert _scene(run_24())["force"] is None
