"""The page as a person uses it, in Chromium: it moves, its links and switches work, nothing overflows, and text from outside stays text."""

import csv
import dataclasses
import io
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page

from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.columns import SHAPE
from quickreturn.reports.page.render import animation_page
from quickreturn.reports.report import machine_facts, write
from tests.reports.in_a_browser import RESULTS, Open
from tests.reports.pages import content_of
from tests.reports.plotted_results import made_up_result
from tests.reports.reported_results import reported_result

HOSTILE = "</script><img src=x onerror=\"document.title='owned'\"> & <b>bold</b>"


def drawn(page: Page, canvas: str) -> str:
    """What a canvas shows; "" if it is blank."""
    script = """id => {
        const canvas = document.getElementById(id), blank = document.createElement("canvas");
        Object.assign(blank, { width: canvas.width, height: canvas.height });
        return canvas.toDataURL() === blank.toDataURL() ? "" : canvas.toDataURL();
    }"""
    return str(page.evaluate(script, canvas))


def cursor(page: Page) -> float:
    return float(page.input_value("#at"))


def test_the_animation_begins_by_itself_advances_and_stops(opened: Open) -> None:
    page = opened()
    first, picture = cursor(page), drawn(page, "stage")
    page.wait_for_timeout(300)
    assert cursor(page) != first
    assert drawn(page, "stage") not in ("", picture)
    page.get_by_role("button", name="Pause").click()
    stopped = cursor(page)
    page.wait_for_timeout(200)
    assert cursor(page) == stopped
    page.get_by_role("button", name="Play").focus()
    page.keyboard.press("Space")
    page.wait_for_timeout(200)
    assert cursor(page) != stopped


@pytest.mark.verify
def test_a_link_restores_the_view(opened: Open) -> None:
    page = opened("#run=thesis-17&engines=reference,mujoco&at=123.5&signal=strain_2&bend=10&chapter=thesis")
    assert cursor(page) == 123.5
    assert page.locator("#run-buttons button[aria-pressed=true]").inner_text() == "17"
    assert page.locator("#engines input:checked").evaluate_all("found => found.map(each => each.value)") == ["reference", "mujoco"]
    assert page.input_value("#signal") == "strain_2"
    assert page.input_value("#bend") == "10"
    assert page.locator("#thesis").get_attribute("open") is not None
    again = opened(page.evaluate("location.hash"))
    assert drawn(again, "stage") == drawn(page, "stage")
    assert drawn(again, "curve") == drawn(page, "curve")


def test_an_address_from_outside_does_no_harm(opened: Open) -> None:
    page = opened("#run=<img src=x>&engines=__proto__,reference&at=-5e99&signal=constructor&chapter=%22%3E<b>&bend=-3")
    assert page.locator("#run-buttons button[aria-pressed=true]").inner_text() == "24"
    assert page.input_value("#signal") == "tip_acceleration"
    assert cursor(page) == 0.0
    assert drawn(page, "stage")


@pytest.mark.verify
def test_engines_are_switched_off_in_every_plot(opened: Open) -> None:
    page = opened("#at=200&chapter=each")
    page.wait_for_selector("#signals canvas")
    page.locator("#methods > summary").click()
    page.locator("#methods-thesis-24 > summary").click()
    page.wait_for_timeout(400)
    plots = page.locator("#signals"), page.locator("#methods .drawn").first

    def pictures() -> list[str | bytes]:
        return [drawn(page, "stage"), drawn(page, "curve"), *(plot.screenshot() for plot in plots)]

    before = pictures()
    page.locator("#engines input[value=thesis]").uncheck()
    page.wait_for_timeout(400)
    after = pictures()
    assert all(one != other for one, other in zip(before, after, strict=True))
    assert "engines=reference,exudyn,mujoco" in page.url
    page.locator("#engines input[value=thesis]").check()
    assert drawn(page, "stage") == before[0]


@pytest.mark.verify
@pytest.mark.parametrize("turning", [-1, 1])
def test_time_runs_to_the_right_whichever_way_the_crank_turns(opened: Open, tmp_path: Path, turning: int) -> None:
    write(content_of(results=[made_up_result("example", turning=turning)], facts=machine_facts()), tmp_path)
    page = opened("#chapter=each", (tmp_path / "index.html").as_uri(), reduced_motion="reduce")
    page.wait_for_selector("#signals canvas")
    texts = page.evaluate("seen.get(document.querySelector('#signals canvas')).texts")
    angles = [text for text, left, *_ in sorted(texts, key=lambda text: text[1]) if text.endswith("°")]
    forwards = ["180°", "225°", "270°", "315°", "360°", "45°", "90°", "135°", "180°"]
    assert angles == (forwards if turning > 0 else ["180°", "135°", "90°", "45°", "0°", "315°", "270°", "225°", "180°"])


@pytest.mark.verify
def test_a_cell_of_the_map_opens_its_run(opened: Open) -> None:
    page = opened("#at=100&chapter=agreement")
    page.locator("#table-map tbody tr").nth(1).locator("a").last.click()
    page.wait_for_function("document.querySelector('#run-buttons [aria-pressed=true]').value === 'thesis-06'")
    assert "failed" in page.locator("#engines label", has_text="exudyn").inner_text()
    assert page.evaluate("scrollY") == 0


def test_the_curve_tells_values_zooms_and_is_taken_away(opened: Open) -> None:
    page = opened("#at=90&run=thesis-24")
    box = page.locator("#curve").bounding_box()
    before = page.inner_text("#values")
    page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 50)
    assert page.inner_text("#values") != before
    assert "m/s²" in page.inner_text("#values")
    whole = drawn(page, "curve")
    page.get_by_role("button", name="Zoom in").click()
    page.mouse.move(5, 5)
    assert drawn(page, "curve") != whole
    with page.expect_download() as waited:
        page.get_by_role("button", name="CSV").click()
    rows = list(csv.DictReader(io.StringIO(Path(waited.value.path()).read_text("utf-8"))))
    for engine in ("thesis", "reference"):
        cycle = RESULTS[0].runs[engine].cycle
        values = np.array([float(row["tip_acceleration [m/s^2]"]) for row in rows if row["engine"] == engine])
        # packed in steps of 2^-24 of the range
        assert np.max(np.abs(values - cycle["tip_acceleration"])) < 2.0**-24 * np.ptp(cycle["tip_acceleration"])
        times = np.array([float(row["time [s]"]) for row in rows if row["engine"] == engine])
        assert np.max(np.abs(times - (cycle["time"] - cycle["time"][0]))) < 2.0**-23 * np.ptp(cycle["time"])


def test_tables_are_sorted_and_filtered(opened: Open) -> None:
    page = opened("#at=0&chapter=runs")
    page.locator("#table-run_by_engine th[data-column='pre_frequency [Hz]'] button").click()
    values = page.locator("#table-run_by_engine tbody tr").evaluate_all("rows => rows.map(row => row.cells[8].dataset.value)")
    known = [float(value) for value in values if value]
    assert known == sorted(known)
    assert len(known) > 4
    page.locator("input.filter").fill("exudyn")
    assert page.locator("#table-run_by_engine tbody tr:visible").count() == len(RESULTS)


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.verify)])
@pytest.mark.verify
def test_nothing_overflows_a_telephone_and_no_picture_is_empty(opened: Open, scheme: str) -> None:
    page = opened("#at=200", width=390, height=844, color_scheme=scheme)
    page.evaluate("document.querySelectorAll('details.chapter').forEach(each => { each.open = true; })")
    page.wait_for_function("[...document.querySelectorAll('.drawn, #signals')].every(each => each.children.length || !each.clientWidth)")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert drawn(page, "stage")
    assert drawn(page, "curve")
    for holder in page.locator(".drawn:visible, #signals").all():
        assert len(holder.screenshot()) > 5000  # a blank one of this size takes some 1,000 bytes
    labels = page.locator("canvas[role=img][id], .drawn").evaluate_all("all => all.map(each => each.getAttribute('aria-label'))")
    assert all(label and len(label) > 20 for label in labels)


def test_a_hostile_title_stays_text(opened: Open, tmp_path: Path) -> None:
    own = reported_result("example")
    own = dataclasses.replace(own, case=dataclasses.replace(own.case, title=HOSTILE, notes=(HOSTILE,)))
    write(content_of(results=[own], facts=machine_facts()), tmp_path)
    page = opened("#at=0&chapter=each", (tmp_path / "index.html").as_uri())
    assert page.inner_text("h1") == HOSTILE
    assert page.title() == f"{HOSTILE} – quickreturn"
    assert HOSTILE in page.inner_text("#caption")
    assert page.locator("main img").count() == 0


@pytest.mark.parametrize(
    "kind",
    ["all failed", *(pytest.param(kind, marks=pytest.mark.verify) for kind in ("backwards", "rigid", "not settled", "without shape"))],
)
def test_whatever_became_of_the_runs_there_is_a_page(opened: Open, tmp_path: Path, kind: str) -> None:
    result = {
        "rigid": made_up_result("rigid"),
        "backwards": made_up_result("thesis-06", turning=-1),
        "not settled": made_up_result("example", {"reference": "not settled"}),
        "all failed": made_up_result("example", dict.fromkeys(("thesis", "reference", "exudyn", "mujoco"), "failed")),
        "without shape": made_up_result("example"),
    }[kind]
    if kind == "without shape":
        for run in result.runs.values():
            for name in SHAPE:
                del run.cycle[name]
    write(content_of(results=[result], facts=machine_facts()), tmp_path)
    page = opened("#at=100&chapter=each", (tmp_path / "index.html").as_uri())
    page.wait_for_timeout(300)
    assert page.locator("#nothing").is_visible() == (kind == "all failed")
    if kind != "all failed":
        assert drawn(page, "stage")
        assert drawn(page, "curve")
        turned = {"backwards": "80°", "rigid": "280°"}.get(kind, "280°")
        assert page.inner_text("#values .where") == turned
        page.get_by_role("button", name="Play").click()
        page.wait_for_timeout(200)
        assert cursor(page) != 100.0


def test_an_animation_of_its_own_runs_over_time(opened: Open, tmp_path: Path) -> None:
    run = RESULTS[0].runs["reference"]
    motions = {name: Trajectory(RESULTS[0].runs[name].cycle, 0.0) for name in ("thesis", "reference")}
    (tmp_path / "run.html").write_text(animation_page(RESULTS[0].case, motions), "utf-8")
    page = opened("#at=0.1&engines=reference", (tmp_path / "run.html").as_uri())
    assert page.inner_text("#values .where") == "0.1 s"
    assert float(page.get_attribute("#at", "max") or "nan") == pytest.approx(run.cycle["time"][-1] - run.cycle["time"][0], rel=1e-6)
    assert drawn(page, "stage")
    assert page.locator("details").count() == 0


#: Width of the mechanism over that of its box; `seen` holds the places of lines, of which the lowest are those of the scale.
FILLED = """() => {
    const canvas = document.getElementById("stage");
    const xs = seen.get(canvas).points.filter(([x, y]) => y < canvas.clientHeight - 20).map(([x]) => x);
    return (Math.max(...xs) - Math.min(...xs)) / canvas.clientWidth;
}"""


@pytest.mark.parametrize(("width", "height"), [(1400, 900), pytest.param(2560, 1440, marks=pytest.mark.verify)])
def test_the_mechanism_uses_the_space_that_there_is(opened: Open, width: int, height: int) -> None:
    page = opened("#at=100", width=width, height=height)
    box, main = (page.locator(name).bounding_box() or {} for name in (".stage", "main"))
    assert main["width"] == width
    assert box["height"] > 0.45 * height
    assert page.evaluate(FILLED) > 0.55
    below = page.evaluate("document.querySelector('.signal').getBoundingClientRect().bottom")
    assert below > 0.85 * height  # no blank below


@pytest.mark.verify
def test_the_stress_along_the_arm_is_drawn_for_ones_own_machine_and_can_be_switched_off(opened: Open, tmp_path: Path) -> None:
    results = [made_up_result("example"), made_up_result("shaper-cutting")]
    write(content_of(results=results, facts=machine_facts()), tmp_path)
    own = (tmp_path / "index.html").as_uri()
    page = opened("#at=100", url=own)
    assert page.is_checked("#stress")
    with_band = drawn(page, "stage")
    page.uncheck("#stress")
    without = drawn(page, "stage")
    assert without not in ("", with_band)
    page.wait_for_function("location.hash.includes('stress=off')")
    again = opened(page.evaluate("location.hash"), url=own, width=390)
    assert not again.is_checked("#stress")
    assert again.evaluate("document.documentElement.scrollWidth") <= 390
    tops = again.evaluate("['.numbers', '#stage'].map(each => document.querySelector(each).getBoundingClientRect().top)")
    assert tops[0] < tops[1]  # on a telephone the answer comes before the picture
    for result in results:  # each case has its answer
        page.select_option("#run", result.case.name)
        page.wait_for_function("title => document.querySelector('.answer:not([hidden]) h1').innerText === title", arg=result.case.title)
        assert page.locator(".answer:visible").count() == 1
        assert page.locator(".answer:visible dt").count() == 8
    assert opened("#at=0").locator("#stress").count() == 0  # the thesis' page keeps its first screen
