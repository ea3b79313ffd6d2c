"""What the page and the terminal say of motor, flywheel and bearings: numbers of the catalogue, in words that fit them."""

import dataclasses
import json

import numpy as np
import pytest

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.catalogue import MEASURES, numbers
from quickreturn.cases.motion.number import Number
from quickreturn.plugins.strength.case_drive import CaseDrive, drive_of, drive_sentences, finding, text_of
from quickreturn.reports.output import plain as as_plain
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.verdict_text import as_document
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


@pytest.mark.parametrize(("fluctuation", "enough"), [(0.05, False), (0.9, True)])
def test_the_chapter_says_whether_the_crank_is_flywheel_enough(shaper: CaseResult, fluctuation: float, enough: bool) -> None:
    ((_, (_, flywheel, _)),) = chapter_of(one_run(wanting(shaper, fluctuation)), "drive").facts["cases"]
    assert flywheel.endswith("which is enough.") == enough


def test_the_error_of_an_angle_is_an_angle() -> None:
    units = load_case("example").units
    angle, amplitude = Number(-0.1, 1e-3), Number(2.0, 1e-3)
    assert plain(text_of("torque.harmonic_1.phase", angle, units, with_error=True)) == "−5.730° (± 0.05730°)"
    assert plain(text_of("torque.harmonic_1", amplitude, units, with_error=True)) == "2.000 N m (± 0.05 %)"
    assert plain(text_of("torque.harmonic_1", Number(1e-4, 2e-3), units, with_error=True)) == "0 N m (± 0.002000 N m)"


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


def test_the_document_of_a_run_has_the_numbers(shaper: CaseResult) -> None:
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
    assert len(drive_sentences(drive_of(no_forces))) == 2
    assert "Which motor, which bearings?" in pages.text_of(one_run(no_forces))
