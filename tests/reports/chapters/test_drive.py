"""What the page and the terminal say of motor, flywheel and bearings: numbers of the catalogue, in words that fit them."""

import dataclasses
import json
import math
import re

import numpy as np
import pytest

from quickreturn.cases.case_file import load_case
from quickreturn.cases.measures.catalogue import MEASURES, numbers
from quickreturn.cases.measures.number import Number
from quickreturn.cases.printable import in_lines
from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.reports.chapters.drive import POINTS, finding
from quickreturn.reports.output import plain as as_plain
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.plot import Plot
from quickreturn.reports.results.drive import CaseDrive, drive_of, drive_sentences, text_of
from quickreturn.verdict_text import as_document, parts_of
from tests.reports import pages
from tests.reports.pages import chapter_of, one_run, plain, read
from tests.reports.plotted_results import with_run
from tests.reports.reported_results import reported_result


@pytest.fixture(scope="module")
def shaper() -> CaseResult:
    """At a prescribed speed: 2 N m in the mean and 4 N m in the first harmonic, over a cycle of 400 rows."""
    result = reported_result("hard-shaper-steel")
    for engine, run in result.runs.items():
        angle = run.cycle["crank_angle"]
        speed = np.full(angle.size, 10.0)
        torque = 2.0 + 4.0 * np.cos(angle - 0.5)
        cycle = {**run.cycle, "crank_speed": speed, "time": (angle - angle[0]) / 10.0, "crank_torque": torque}
        result = with_run(result, engine, cycle=cycle)
    return result


def wanting(result: CaseResult, fluctuation: float) -> CaseResult:
    """The same results of a machine whose speed should vary by no more."""
    mechanism = result.case.mechanism
    scene = dataclasses.replace(mechanism, crank=dataclasses.replace(mechanism.crank, wanted_fluctuation=fluctuation))
    return dataclasses.replace(result, case=dataclasses.replace(result.case, scene=scene))


def test_the_sentences_give_the_closed_forms(shaper: CaseResult) -> None:
    motor, flywheel, bearings = map(plain, drive_sentences(drive_of(shaper)))
    back = 2.0 * (4.0 * math.sin(math.pi / 3.0) - 2.0 * math.pi / 3.0)  # J, over 120 degrees of a turn
    assert motor == (
        "The torque of the drive is 2.000 N m in the mean, 3.464 N m RMS and 6.000 N m at most; its power is 20.00 W in the mean and"
        f" 60.00 W at most. In a turn {4.0 * math.pi + back:.2f} J go to the machine and {back:.3f} J come back, at 20.00 W at most."
    )
    assert flywheel.startswith(
        "With a motor of constant torque, crank and flywheel store and release 8.000 J in a turn; with crank.wanted_fluctuation"
    )
    assert re.fullmatch(
        r"Ball bearings are chosen by an equivalent load of \S+ N at P \(\S+ N with rollers\) and \S+ N at O \(\S+ N with rollers\); P"
        r" turns by 57\.65° in a turn of the crank, to and fro\.",
        bearings,
    )
    *_, fully = map(plain, drive_sentences(drive_of(dataclasses.replace(shaper, case=load_case("whitworth")))))
    assert fully.endswith(" in a turn of the crank.")
    _, flywheel, _ = map(plain, drive_sentences(drive_of(wanting(shaper, 0.05))))
    assert flywheel == (  # 8 J / (0.05 (10 rad/s)^2)
        "With a motor of constant torque, crank and flywheel store and release 8.000 J in a turn. For a speed whose range is 5 % of its"
        " mean they need an inertia of 1.600 kg m² about O together; the crank has 0.1000 kg m²."
    )
    _, flywheel, _ = map(plain, drive_sentences(drive_of(wanting(shaper, 0.9))))
    assert flywheel.endswith("they need an inertia of 0.08889 kg m² about O together; the crank has 0.1000 kg m², which is enough.")


def test_the_error_of_an_angle_is_an_angle() -> None:
    units = load_case("example").units
    angle, amplitude = Number(-0.1, 1e-3), Number(2.0, 1e-3)
    assert plain(text_of("torque.harmonic_1.phase", angle, units, with_error=True)) == "−5.730° (± 0.05730°)"
    assert plain(text_of("torque.harmonic_1", amplitude, units, with_error=True)) == "2.000 N m (± 0.05 %)"
    assert plain(text_of("torque.harmonic_1", Number(1e-4, 2e-3), units, with_error=True)) == "0 N m (± 0.002000 N m)"


def test_a_machine_with_a_driving_torque_fluctuates_and_has_no_harmonics() -> None:
    result = reported_result("example")
    drive = drive_of(result)
    told = [plain(sentence) for sentence in drive_sentences(drive)]
    assert told[0].startswith("At the shaft the drive gives ")
    assert told[1] == "The speed of the crank fluctuates by 2.000 % of its mean, from the least to the largest."
    chapter = chapter_of(one_run(result), "drive")
    assert [table.name for table in chapter.tables] == ["drive", "bearing_forces"]
    assert [plot.file for plot in chapter.plots] == ["bearing_forces.csv"] * 2


def test_the_heading_is_that_of_the_first_machine(shaper: CaseResult) -> None:
    cases = [drive_of(shaper), drive_of(reported_result("example"))]
    loads = numbers(shaper.case.mechanism, shaper.runs["reference"])
    at = {place: f"{loads[f'equivalent.{force}_force.ball'].value:.4g} N at {place}" for place, force in (("P", "pivot"), ("O", "crank"))}
    told = f"20.00 W in the mean, 60.00 W at most; equivalent loads {at['P']} and {at['O']}"
    assert plain(finding(cases[:1])) == told
    assert plain(finding(cases)) == f"hard-shaper-steel: {told}"


def test_the_tables_are_the_catalogue_s_numbers(shaper: CaseResult) -> None:
    result = wanting(shaper, 0.05)
    page = read(one_run(result))
    right = numbers(result.case.mechanism, result.runs["mujoco"])
    heads, rows = page.heads["drive.csv"], page.tables["drive.csv"]
    assert heads == ["case", "quantity", *(f"{engine} [SI]" for engine in ("thesis", "reference", "exudyn", "mujoco"))]
    assert len(rows) == 19 + 16
    for row in rows:
        name = row[1][1]
        assert float(row[heads.index("mujoco [SI]")][1]) == right[name].value, name
    phase = next(row for row in rows if row[1][1] == "torque.harmonic_1.phase")
    assert [cell[0].replace("\N{NO-BREAK SPACE}", " ") for cell in phase[2:]] == ["28.65° (error unknown)"] * 4


def test_the_pictures_show_the_rows(shaper: CaseResult) -> None:
    bars, at_p, at_o = chapter_of(one_run(shaper), "drive").plots
    assert [series.name for series in bars.series] == ["thesis", "reference", "exudyn", "mujoco"]
    assert all(series.columns and list(series.x) == [*range(1, 9)] for series in bars.series)
    assert bars.series[0].y[0] == pytest.approx(4.0, abs=1e-6)
    cycle = shaper.runs["reference"].cycle
    for plot, force in ((at_p, "pivot_force"), (at_o, "crank_force")):
        assert isinstance(plot, Plot)
        assert plot.alike
        curve = next(series for series in plot.series if series.name == "reference")
        assert len(curve.x) == POINTS + 1
        sizes = np.hypot(np.array(curve.x, float), np.array(curve.y, float))
        assert sizes.max() == pytest.approx(np.hypot(cycle[f"{force}_x"], cycle[f"{force}_y"]).max(), rel=1e-2)
        (marks,) = (series for series in plot.series if series.labels)
        assert marks.labels == ["270°", "0°", "90°", "180°"]  # from the slider's farthest place on
        for place, angle in enumerate((270.0, 0.0, 90.0, 180.0)):
            turned = math.radians((angle - 180.0) % 360.0) or math.tau
            x = np.interp(turned, cycle["crank_angle"] - cycle["crank_angle"][0], cycle[f"{force}_x"])
            assert marks.x[place] == pytest.approx(x, abs=1e-9)


def test_run_says_it_in_words_and_in_json(shaper: CaseResult) -> None:
    words = in_lines(parts_of(shaper))
    assert "  reference: the torque of the drive is 2.000 N m in the mean, 3.464 N m RMS and 6.000 N m at most; its power is" in words
    (case,) = json.loads(json.dumps(as_plain(as_document([shaper], ()))))["cases"]
    (document,) = (engine["numbers"] for engine in case["engines"] if engine["engine"] == "mujoco")
    assert document["torque.harmonic_1"]["value"] == pytest.approx(4.0, abs=1e-6)
    assert document["torque.harmonic_1"]["unit"] == "N m"
    assert document["flywheel.inertia"]["value"] is None
    assert document.keys() == MEASURES.keys()


@pytest.mark.verify
def test_without_the_torque_there_is_no_chapter(shaper: CaseResult) -> None:
    assert "drive" not in [chapter.id for chapter in chapters_of(one_run())]  # the thesis
    without = shaper
    for engine, run in shaper.runs.items():
        without = with_run(without, engine, cycle={name: values for name, values in run.cycle.items() if name != "crank_torque"})
    assert drive_sentences(CaseDrive(without.case, {})) == drive_sentences(drive_of(without)) == []
    assert "drive" not in [chapter.id for chapter in chapters_of(one_run(without))]
    no_forces = shaper
    for engine, run in shaper.runs.items():
        no_forces = with_run(no_forces, engine, cycle={name: values for name, values in run.cycle.items() if "_force_" not in name})
    assert len([*chapter_of(one_run(no_forces), "drive").plots]) == 1
    assert "Which motor, which bearings?" in pages.text_of(one_run(no_forces))
