"""The resonance curve on the page of one's own machine: what it says of the machine, or why there is none."""

import csv
import dataclasses
from collections.abc import Generator, Sequence
from pathlib import Path

import pytest

from quickreturn.cases.files.shown import METRIC
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.running.job import Job, Limits, Outcome, Watch
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import EngineFailure
from quickreturn.plugins.studies.around import Around, around_of, curves_around, motion_sentences, near_words
from quickreturn.plugins.studies.chapter import finding, plot
from quickreturn.plugins.studies.resonance_curve.search import USUAL
from quickreturn.plugins.studies.tests.made_up_resonance import FOLD, OWN, PEAK, RPM, height, made_up_around, speed
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.report import write
from tests.reports.pages import finding_of, one_run, plain, text_of
from tests.reports.reported_results import reported_result

ACCELERATION = (MEASURES[USUAL], METRIC)


@pytest.fixture(scope="module")
def around() -> Around:
    return made_up_around()


def own_page(*curves: Around) -> Content:
    return Content(results=[reported_result(each.case.name) for each in curves], data={around_of: curves})


def test_the_machine_has_every_motion_at_its_speed(around: Around) -> None:
    heights, kinds = zip(*around.motions, strict=True)
    assert heights == pytest.approx([height(-OWN), height(0.0), height(OWN)], rel=1e-5)  # splines of points 1/30 apart
    assert kinds == ("", "fold", "")
    assert around.peak == around.solved_curve.peaks[0]
    assert around.change == min(around.solved_curve.special, key=lambda each: abs(each.value - around.own))


def test_stable_and_unstable_parts_meet_at_the_folds_and_nowhere_else(around: Around) -> None:
    stable, unstable = plot(around).series[:2]
    assert (stable.name, unstable.name) == ("stable", "unstable")
    parts = " ".join("-" if each is None else "." for each in stable.x).replace(" ", "").split("-")
    assert [bool(each) for each in parts] == [True, True, False]  # a gap between, and one behind
    pace = around.own / RPM
    ends = [stable.x[len(parts[0]) - 1], stable.x[len(parts[0]) + 1]]
    assert ends == pytest.approx([pace * speed(-FOLD), pace * speed(FOLD)])
    assert [unstable.x[0], unstable.x[-2]] == pytest.approx(ends)
    assert not stable.marked
    assert unstable.text[1].endswith("multiplier 1.5")


def test_folds_and_peaks_carry_the_order_of_the_harmonic(around: Around) -> None:
    drawn = plot(around)
    marks = {series.name: series for series in drawn.series[2:]}
    assert list(marks) == ["peak", "fold", "your machine"]
    assert marks["peak"].labels == ["8×"]
    assert set(marks["fold"].labels) == {f"{around.order_at(around.own)}×"}  # within 2 % of the machine's own speed
    assert sorted(marks["your machine"].y) == pytest.approx(sorted(height for height, _ in around.motions))
    assert drawn.here == (pytest.approx(around.own / RPM), "your machine runs here")
    assert "driven by 8 times the crank’s speed" in marks["peak"].text[0]


def test_the_tables_have_what_is_drawn(around: Around, tmp_path: Path) -> None:
    write(own_page(around), tmp_path)
    rows = {name: list(csv.DictReader((tmp_path / name).read_text().splitlines())) for name in ("resonances.csv", "resonance_curve.csv")}
    speeds = [float(row["speed [rad/s]"]) for row in rows["resonance_curve.csv"]]
    assert speeds == around.solved_curve.values.tolist()
    assert [row["special"] for row in rows["resonance_curve.csv"] if row["special"]] == ["fold", "fold"]
    points = rows["resonances.csv"]
    assert [row["point"] for row in points] == ["fold", *["your machine"] * 3, "fold", "peak"]
    assert float(points[-1]["distance [1]"]) == pytest.approx(speed(PEAK) - 1.0)
    assert {row["stability"] for row in points if row["point"] == "your machine"} == {"stable", "unstable: fold"}


def test_the_chapter_has_the_motions_and_the_heading_what_is_nearest(around: Around) -> None:
    told = text_of(own_page(around))
    assert "three periodic motions, two of them stable" in told
    assert f"{float(f'{height(0.0):.2g}'):g} m/s² (unstable: fold)" in told
    assert plain(f"The resonance curve has its {around.nearest_peak}") in told  # on the first screen
    lines = plain(" ".join(around.lines))  # of the command
    assert f"reach from {120.0 * speed(FOLD):.5g} rpm to {120.0 * speed(-FOLD):.5g} rpm, and your machine lies within" in lines
    # 120 rpm; the peak at u = PEAK, and the fold that lies 2 % above: 1 + WIDTH (8 u^3 - 3 u) / 5 at -FOLD
    heading = finding_of(own_page(around), "resonance")
    for u in (PEAK, -FOLD):
        assert f"{120.0 * speed(u):.5g} rpm" in heading
        assert f"{120.0 * (speed(u) - 1.0):.3g} rpm or {100.0 * (speed(u) - 1.0):.1f} % faster" in heading
    assert finding([around, around]).startswith("example: ")


def test_a_harmonic_without_a_peak_is_no_alarm(around: Around) -> None:
    bare = Around(around.case, dataclasses.replace(around.solved_curve, peaks=()))
    assert "the 9th harmonic" in plain(bare.without_effect)
    assert "no peak between 102 rpm and 138 rpm" in plain(near_words(bare))
    of_it = dataclasses.replace(around.solved_curve.peaks[0], order=9)
    assert Around(around.case, dataclasses.replace(around.solved_curve, peaks=(of_it,))).without_effect == ""
    nothing = dataclasses.replace(around, curve=dataclasses.replace(around.solved_curve, peaks=(), special=()))
    assert "no fold and no loss of stability between 102 rpm and 138 rpm" in plain(finding([nothing]))
    assert finding([Around(around.case, None, "the crank stands still")]) == "no resonance curve: the crank stands still"


@pytest.mark.parametrize(
    ("motions", "words"),
    [
        ([(12.34, "")], ["one periodic motion", "12 m/s²", "stable"]),
        ([(12.34, "torus")], ["12 m/s²", "unstable (torus)", "would leave it"]),
        ([(10.0, ""), (20.0, "fold"), (30.0, "")], ["three", "two of them stable", "20 m/s² (unstable: fold)", "Its history decides"]),
        ([], ["no motion"]),
    ],
)
def test_motions_have_their_stability(motions: list[tuple[float, str]], words: list[str]) -> None:
    told = motion_sentences(motions, *ACCELERATION)
    assert all(each in told for each in words), told
    assert ("history" in told) == ("Its history decides" in words)


class Failing:
    """An executor on which no periodic motion is found."""

    quiet, limits = True, Limits()

    def run(self, jobs: Sequence[Job], watch: Watch | None = None) -> Generator[Outcome, None, None]:
        for job in jobs:
            yield Outcome(
                job, failure="raised", error=EngineFailure(0.0, "no periodic motion was found within the range", "try another range")
            )


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"follower.bending_stiffness": "inf"}, "a resonance curve needs a follower that bends"),
        ({"slider.joint_stiffness": "1e5 N/m"}, "a resonance curve needs a slider joint that is rigid and frictionless"),
        ({"crank.torque": "0 N*m", "crank.initial_speed": "0 rpm"}, "a resonance curve needs a crank that turns"),
        ({}, "no periodic motion was found within the range"),
    ],
    ids=["rigid follower", "joint that gives way", "crank that stands still", "nothing found"],
)
def test_one_sentence_says_why_there_is_no_curve(changes: dict[str, str], sentence: str, tmp_path: Path) -> None:
    case = load_case("thesis-24", changes)
    for _ in range(2):  # the second time from the store, where the failure is
        (found,) = curves_around([case], Workshop(Store(tmp_path), Failing()), {})
        assert found.curve is None
    content = Content(results=[reported_result("example")], data={around_of: [found]})
    assert sentence in finding_of(content, "resonance")
    if not changes:  # the page says it in the heading and in the chapter, in place of the curve
        told = text_of(content)
        assert f"No resonance curve of {case.title}: " in told
        assert told.count(sentence) == 2
        assert "your machine runs here" not in told


def test_the_report_on_the_thesis_has_no_such_chapter() -> None:
    assert "resonance" not in [chapter.id for chapter in chapters_of(one_run())]
