"""Every number in every heading of the page is what the CSV files beside the page say, over all engines that they name."""

import re
from pathlib import Path

import pandas as pd
import pytest

from quickreturn.cases.benchmark import Compiling
from quickreturn.cases.case_file import load_case
from quickreturn.cases.jobs.store import Store
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.library import catalogue
from quickreturn.reports.machine import machine_facts
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.report import PAGE, write, write_report
from quickreturn.reports.thesis.content import ThesisContent
from tests.cases.made_up_map import made_up_map
from tests.reports.headings import EXPECTED, headings, mistakes, numbers_in, tables_in
from tests.reports.made_up_benchmark import made_up_benchmark
from tests.reports.made_up_resonance import made_up_around
from tests.reports.pages import content_of
from tests.reports.plotted_results import with_table
from tests.reports.reported_results import reported_result
from tests.reports.test_hard_scenes_page import matrix
from tests.reports.test_report import studies
from tests.reports.test_sharpness import agreeing
from tests.reports.thesis.made_up_finding import made_up_finding


@pytest.fixture(scope="module", params=["all agree", "an engine fails, one claim is wrong, estimates were not timed"])
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report on made-up results with every chapter that a report on the thesis' runs can have."""
    good = request.param == "all agree"
    place = tmp_path_factory.mktemp("headings")
    first = with_table(agreeing(reported_result("thesis-24")), "tool.csv", ["strain_2", "tip_acceleration"], {"version": "7"})
    second = agreeing(reported_result("thesis-06", seed=5)) if good else reported_result("thesis-06", {"exudyn": "failed"}, seed=5)
    content = content_of(
        results=[first, second],
        studies=studies(),
        benchmarks=[made_up_benchmark(timed=good), made_up_benchmark("thesis-17", timed=good)],
        compiling=[Compiling("reference", 40.0, 0.5)] if good else [],
        hard_scenes=matrix(wrong=not good),
        classes=made_up_map(),
        finding=made_up_finding() if good else (),
        facts=machine_facts(),
    )
    write(content, place)
    missing = set(EXPECTED) - {"answer", "next", "strength", "resonance"} - {chapter.id for chapter in chapters_of(content)}
    assert not missing
    return place


def of(folder: Path) -> tuple[dict[str, str], dict[str, pd.DataFrame]]:
    return headings((folder / PAGE).read_text("utf-8")), dict(tables_in(folder))


def test_every_heading_says_what_the_tables_say(folder: Path) -> None:
    told, tables = of(folder)
    assert mistakes(told, tables) == []


def test_another_number_in_any_heading_is_noticed(folder: Path) -> None:
    told, tables = of(folder)
    for name, text in told.items():
        for place in re.finditer(r"\d+(?:\.\d+)?", text):
            other = f"{text[: place.start()]}{float(place[0]) + 1.0:g}{text[place.end() :]}"
            assert mistakes({name: other}, tables), other


@pytest.mark.parametrize(
    ("chapter", "table", "column"),
    [
        ("experiment", "experiment", "strain_mujoco"),
        ("hard", "hard_scenes_cells", "model_error"),
        ("methods", "fastest", "reference solve_seconds"),
        ("accuracy", "accuracy", "tip_deflection"),
        ("thesis", "thesis_over_reference", "post_median"),
        ("agreement", "map", "thesis_frequency_difference"),
    ],
)
def test_another_number_in_a_table_is_noticed(folder: Path, chapter: str, table: str, column: str) -> None:
    told, tables = of(folder)
    if chapter == "thesis" and "finding" in tables:  # then the heading is about that
        table, column = "finding", "post_frequency"
    changed = tables[table].copy()
    changed[column] *= 3.0
    assert mistakes({chapter: told[chapter]}, tables | {table: changed})


def test_a_report_on_ones_own_case_says_what_its_tables_say(tmp_path: Path) -> None:
    content = content_of(results=[reported_result("example", {"exudyn": "failed"})], around=[made_up_around()], facts=machine_facts())
    write(content, tmp_path)
    told, tables = of(tmp_path)
    del told["answer"]  # it names strengths and lengths of the case, too, which no table has
    assert {"next", "strength", "resonance"} <= set(told)
    assert mistakes(told, tables) == []


def test_numbers_in_words_count() -> None:
    assert numbers_in("Three of 24 set-ups, 0.5 in") == ["0.5", "24", "3"]


@pytest.mark.verify
def test_the_report_on_all_runs_says_what_its_tables_say(tmp_path: Path) -> None:
    """From the store, where that holds the results; else they are computed."""
    cases = [load_case(entry.name) for entry in catalogue("thesis")]
    write_report(cases, tmp_path, Workshop(Store()), content_type=ThesisContent)
    told, tables = of(tmp_path)
    assert len(tables["map"]) == 24
    assert {"thesis", "reference", "exudyn", "mujoco"} <= set(tables["run_by_engine"]["engine"])
    assert mistakes(told, tables) == []
