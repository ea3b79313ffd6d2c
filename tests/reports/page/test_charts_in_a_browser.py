"""The charts of the page, in Chromium: no text covers another or is cut off, legends are complete, a name has one colour in all of them."""

import dataclasses
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page

from quickreturn.cases.comparison.engines import compare
from quickreturn.reports.line_styles import looks
from quickreturn.reports.report import machine_facts, write
from tests.reports.in_a_browser import Open
from tests.reports.pages import content_of
from tests.reports.plotted_results import made_up_result

#: Pixels by which boxes of letters may reach into each other: they are higher than what is drawn of the letters.
LEADING = 3.0
#: For each chart its name, its box, and its texts with their boxes, in pixels of the window.
TEXTS = """() => {
    const inside = ({ left, top, right, bottom }) => [left, top, right, bottom];
    const charts = [...document.querySelectorAll(".drawn")].filter((each) => each.clientWidth).map((each) => [
        each.getAttribute("aria-label"), inside(each.getBoundingClientRect()),
        [...each.querySelectorAll("text, .key li, .reading, .take")].map((text) =>
            [text.textContent, ...inside(text.getBoundingClientRect())]),
    ]);
    const canvases = [...document.querySelectorAll("#stage, #curve, #signals canvas")].map((each) => {
        const box = each.getBoundingClientRect(), texts = seen.get(each)?.texts ?? [];
        return [each.getAttribute("aria-label"), inside(box), texts.map(([text, left, top, right, bottom]) =>
            [text, box.left + left, box.top + top, box.left + right, box.top + bottom])];
    });
    return [...charts, ...canvases];
}"""
#: Opens everything that can be opened, and waits until it is drawn.
OPEN = """async () => {
    for (const each of document.querySelectorAll("details")) each.open = true;
    for (const each of document.querySelectorAll(".choices > [hidden]")) each.hidden = false;
    await new Promise((done) => setTimeout(done, 50));
    dispatchEvent(new Event("resize"));
}"""


def everything(opened: Open, **about: Any) -> Page:
    page = opened("#at=200", reduced_motion="reduce", **about)
    page.evaluate(OPEN)
    return page


def meet(one: list[Any], other: list[Any]) -> bool:
    """Whether two boxes share more than the room around letters."""
    across = min(one[3], other[3]) - max(one[1], other[1])
    return bool(across > 1.0 and min(one[4], other[4]) - max(one[2], other[2]) > LEADING)


def assert_fitting(name: str, box: list[float], texts: list[Any]) -> None:
    """No text of a chart covers another or is cut off."""
    met = [(one[0], other[0]) for one, other in combinations(texts, 2) if meet(one, other)]
    assert met == [], f"{name}: texts cover each other"
    left, _, right, bottom = box
    out = [text for text, x0, _, x1, y1 in texts if x0 < left - 0.5 or x1 > right + 0.5 or y1 > bottom + 0.5]
    assert out == [], f"{name}: texts are cut off"


@pytest.mark.parametrize("width", [390, pytest.param(1400, marks=pytest.mark.verify)])
@pytest.mark.verify
def test_no_text_of_a_chart_covers_another_or_is_cut_off(opened: Open, width: int) -> None:
    page = everything(opened, width=width)
    charts = page.evaluate(TEXTS)
    assert len(charts) == page.locator(".drawn").count() + 2 + page.locator("#signals canvas").count()
    for name, box, texts in charts:
        assert len(texts) > 4, name
        assert_fitting(name, box, texts)


@pytest.mark.parametrize("width", [390, pytest.param(1400, marks=pytest.mark.verify)])
@pytest.mark.verify
def test_what_is_too_wide_can_be_scrolled_and_says_so(opened: Open, width: int) -> None:
    page = everything(opened, width=width)
    script = """() => [...document.querySelectorAll("main *")].filter((each) => each.clientWidth && each.scrollWidth > each.clientWidth + 1)
        .filter((each) => getComputedStyle(each).display !== "inline")
        .map((each) => [each.outerHTML.slice(0, 99), getComputedStyle(each).overflowX, each.classList.contains("more")])"""
    wide = page.evaluate(script)
    assert [each for each in wide if each[1:] != ["auto", True]] == []
    if width == 390:
        assert wide


@pytest.mark.verify
def test_a_legend_names_every_series_that_is_drawn(opened: Open) -> None:
    page = everything(opened)
    script = """each => [JSON.parse(each.previousElementSibling.textContent).series.map(series => series.name),
        [...each.querySelectorAll(".key li")].map(item => item.textContent),
        [...each.querySelectorAll("[data-series]")].map(group => group.dataset.series)]"""
    for chart in page.locator(".drawn").all():
        told, legend, drawn = chart.evaluate(script)
        assert legend == told
        assert set(drawn) == set(told)
    panels = page.locator("#signals .key li").all_inner_texts()
    assert panels == ["reference", "thesis", "mujoco", "exudyn"]  # in the order in which they lie on each other


def rgb(colour: str) -> str:
    return f"rgb({', '.join(str(int(colour[k : k + 2], 16)) for k in (1, 3, 5))})"


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.verify)])
@pytest.mark.verify
def test_a_name_has_one_colour_and_one_mark_in_all_charts(opened: Open, scheme: str) -> None:
    page = everything(opened, color_scheme=scheme)
    script = """all => all.filter(each => each.dataset.of).flatMap(each => [...each.querySelectorAll("circle, polygon, polyline, line")]
        .map(part => [each.dataset.of, part.tagName, part.points?.length ?? 0, getComputedStyle(part).stroke]))"""
    found = page.locator(".drawn [data-of]").evaluate_all(script)
    names = {name for name, *_ in found}
    wanted = {name: rgb(getattr(look, scheme)) for name, look in looks(names).items()}
    assert {"reference", "thesis", "exudyn", "multiplier"} <= names
    assert {(name, colour) for name, _, _, colour in found} == set(wanted.items())
    marks = {name: {(tag, points) for other, tag, points, _ in found if other == name and tag in ("circle", "polygon")} for name in names}
    assert all(len(shapes) == 1 for shapes in marks.values()), marks
    stripes = page.locator("#engines label").evaluate_all("""all => all.map(each =>
        [each.querySelector("input").value, getComputedStyle(each.querySelector("line")).stroke])""")
    values = page.locator("#values .value").evaluate_all(
        "all => all.map(each => [each.innerText.split(' ')[0], each.firstChild.style.background])"
    )
    assert len(stripes) == len(values) == 4
    assert {*map(tuple, stripes), *map(tuple, values)} <= set(wanted.items())
    drawn = page.evaluate("[...document.querySelectorAll('#stage, #curve, #signals canvas')].map(each => [...seen.get(each).colours])")
    for colours in drawn:
        assert {getattr(looks([name])[name], scheme) for name, _ in stripes} <= set(colours)


@pytest.mark.verify
def test_curves_that_lie_on_each_other_are_all_seen_in_their_own_colours(opened: Open, tmp_path: Path) -> None:
    """Colours along the curve of the reference, on which two other engines lie."""
    result = made_up_result("thesis-24")
    lead = result.runs["reference"]
    runs = {name: dataclasses.replace(lead, engine=name) for name in ("reference", "exudyn", "mujoco")}
    write(content_of(results=[compare(result.case, runs)], facts=machine_facts()), tmp_path)
    page = opened("#at=0", (tmp_path / "index.html").as_uri(), reduced_motion="reduce")
    pixels = page.evaluate("""() => {
        const canvas = document.getElementById("curve"), { points } = seen.get(canvas), ratio = canvas.width / canvas.clientWidth;
        const whole = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        const places = points.map(([x, y]) => 4 * (Math.round(y * ratio) * canvas.width + Math.round(x * ratio)));
        return places.map((at) => [...whole.slice(at, at + 3)]);
    }""")
    colours = {name: np.array([int(look.light[k : k + 2], 16) for k in (1, 3, 5)]) for name, look in looks(runs).items()}
    on_the_curve = np.array(pixels)
    near = {name: np.max(np.abs(on_the_curve - colour), axis=1) <= 40 for name, colour in colours.items()}
    parts = {name: float(np.mean(found)) for name, found in near.items()}
    assert min(parts.values()) > 0.1, parts
    assert sum(parts.values()) > 0.7, parts  # the others: axes, cursor, and where one dash ends and the next begins
