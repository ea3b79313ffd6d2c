"""The finished page: complete, self-contained, and of one mind with its CSV files."""

import csv
import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.key import code_fingerprint
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.conform.records import verdicts
from quickreturn.plugins.methods.tests.made_up_races import made_up_fronts, made_up_race
from quickreturn.plugins.methods.tests.pages import of_studies
from quickreturn.reports import report as report_module
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import FILE, verification
from quickreturn.reports.page.render import report_page
from quickreturn.reports.report import CATALOGUE, machine_facts, write, write_report
from tests.reports import pages
from tests.reports.conftest import Call
from tests.reports.pages import content_of
from tests.reports.plotted_results import with_table
from tests.reports.reported_results import PageReader, reported_result


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report on two made-up cases, in one of which an engine failed, with studies."""
    place = tmp_path_factory.mktemp("report")
    results = [reported_result("thesis-24"), reported_result("thesis-06", {"exudyn": "failed"}, seed=5)]
    told = {"facts": machine_facts(), "code": "abc", "notices": ("a <notice>",)}
    data = of_studies(fronts=made_up_fronts(made_up_race(), made_up_race("thesis-17", confirmed=False)))
    content = content_of(results=results, data=data, **told)  # type: ignore[arg-type]
    write(content, place)
    return place


@pytest.fixture(scope="module")
def read(folder: Path) -> PageReader:
    return PageReader((folder / "index.html").read_text("utf-8"))


def test_the_page_refers_to_nothing_but_itself_and_its_tables(folder: Path, read: PageReader) -> None:
    assert "link" not in read.tags
    assert all(source.startswith("data:image/") for source in read.sources)
    for link in read.links:
        if link.startswith("#chapter="):
            assert link.partition("&section=")[2] in read.anchors
        else:
            assert link.startswith("#run=thesis-") or (folder / link).is_file(), link
    text = (folder / "index.html").read_text("utf-8")
    assert "src=" not in text.split("<script>")[0]
    assert "http://" not in text
    assert "https://" not in text
    assert "@import" not in text
    assert "url(" not in text


def test_every_table_in_the_page_says_what_its_csv_file_says(folder: Path, read: PageReader) -> None:
    assert len(read.tables) >= 15
    for file, rows in read.tables.items():
        written = list(csv.DictReader((folder / file).read_text("utf-8").splitlines()))
        assert len(written) == len(rows), file
        for shown, row in zip(rows, written, strict=True):
            assert [value for _, value in shown] == [row[head] for head in read.heads[file]], file


def test_the_catalogue_lists_every_file_and_no_other(folder: Path) -> None:
    listed = {row["file"] for row in csv.DictReader((folder / CATALOGUE).read_text("utf-8").splitlines())}
    assert listed | {CATALOGUE} == {path.name for path in folder.glob("*.csv")}


def test_a_failure_is_told_in_full_and_what_comes_from_outside_is_escaped(folder: Path, read: PageReader) -> None:
    text = (folder / "index.html").read_text("utf-8")
    assert "the beam <snapped>" in read.text
    assert "<snapped>" not in text
    assert "a <notice>" in read.text
    failures = read.tables["failures.csv"]
    assert [(row[0][1], row[1][1], row[2][1]) for row in failures] == [("thesis-06", "exudyn", "failed")]
    assert "7 of 8" in read.text.replace("\N{NO-BREAK SPACE}", " ")


def test_the_chapters_stand_in_their_order_and_are_closed(folder: Path, read: PageReader) -> None:
    wanted = ["agreement", "runs", "methods", "thesis", "experiment", "inconsistencies", "each", "provenance", "files"]
    assert [anchor for anchor in read.anchors if anchor in wanted] == wanted
    assert len(set(read.anchors)) == len(read.anchors)
    assert "<details open" not in (folder / "index.html").read_text("utf-8")


def test_a_report_on_ones_own_case_has_its_title_and_no_word_on_the_thesis() -> None:
    own = content_of(results=[reported_result("example")], facts=machine_facts())
    names = [chapter.id for chapter in chapters_of(own)]
    assert not {"thesis", "experiment", "inconsistencies"} & set(names)
    assert "next" in names
    page = pages.read(own)
    assert own.results[0].case.title in page.text
    assert "statements" not in page.text
    assert "whips" not in page.text  # as the thesis' thin arms do
    assert "belongs to" not in page.text  # no placeholder
    assert 'crank.length="90 mm"' in page.text  # a command for this case, with a value that it can have
    assert names[0] == "strength"
    assert names.index("agreement") > names.index("each")  # the machine comes before what engines think of each other
    both = content_of(results=[reported_result("thesis-24"), reported_result("example")])
    assert "strength" not in [chapter.id for chapter in chapters_of(both)]
    assert [result.case.name for result in both.thesis_results] == ["thesis-24"]


@pytest.mark.verify
def test_a_later_report_removes_the_tables_of_an_earlier_one_and_nothing_else(tmp_path: Path) -> None:
    write(content_of(results=[reported_result("thesis-24"), reported_result("thesis-06")]), tmp_path)
    (tmp_path / "mine.csv").write_text("kept")
    assert (tmp_path / "run_thesis_06.csv").is_file()
    write(content_of(results=[reported_result("thesis-24")]), tmp_path)
    assert not (tmp_path / "run_thesis_06.csv").exists()
    assert (tmp_path / "mine.csv").read_text() == "kept"


def test_recorded_tables_are_shown_with_what_they_say_of_themselves_as_text() -> None:
    hostile = "</script><img src=x onerror=alert(1)>.csv"
    declared = {"origin": "synthetic", "version": "<blink>7", "source": "made up"}
    result = with_table(reported_result("thesis-24"), hostile, ["strain_2"], declared, of_experiment=True)
    both = [with_table(result, "tool.csv", ["tip_deflection"], {"version": "Tool 7.1"})]
    content = content_of(results=both, data={verdicts: {"reference": "conforms"}})
    page = report_page(content, list(chapters_of(content)))
    assert hostile not in page
    read = PageReader(page)
    assert "img" not in read.tags
    assert "blink" not in read.tags
    assert {row[3][1] for row in read.tables["curve_comparison.csv"]} == {"synthetic"}
    assert "synthetic: made up" in read.text
    rows = {row[0][0]: [text for text, _ in row] for row in read.tables["engines.csv"]}
    assert rows[hostile][1:3] == ["a file", "<blink>7"]
    assert rows["tool.csv"][1:3] == ["a file", "Tool 7.1"]
    assert (rows["reference"][1], rows["reference"][3]) == ("this project", "conforms")
    assert rows["tool.csv"][3] != "conforms"


def test_verification_is_shown_as_long_as_the_code_is_the_same(tmp_path: Path) -> None:
    assert "not been run" in verification(tmp_path).absent
    chapter = {"title": "Faults", "text": "All survived.", "columns": ["fault", "share"], "rows": [["disk full", 0.5], ["killed", None]]}
    document = {"code": code_fingerprint(), "date": "today", "chapters": [chapter]}
    (tmp_path / FILE).write_text(json.dumps(document))
    read = pages.read(content_of(results=[reported_result("thesis-24")], verification=verification(tmp_path)))
    assert "All survived." in read.text
    assert read.tables["verification_1.csv"][0][0][1] == "disk full"
    (tmp_path / FILE).write_text(json.dumps(document | {"code": "other"}))
    assert "other code" in verification(tmp_path).absent
    (tmp_path / FILE).write_text("{")
    assert "cannot be read" in verification(tmp_path).absent


@pytest.mark.parametrize(("status", "expected"), [("settled", 0), ("inaccurate", 3), ("failed", 3), ("not settled", 3)])
def test_exit_codes_tell_whether_every_engine_completed(call: Call, monkeypatch: pytest.MonkeyPatch, status: str, expected: int) -> None:
    monkeypatch.setenv("QUICKRETURN_STORE", "store")
    monkeypatch.setattr(report_module, "cross_validate", lambda *_, **__: [reported_result("thesis-17", {"mujoco": status})])
    code, output, errors = call("report", "thesis-17")
    assert code == expected
    remark = "" if status == "inaccurate" else "failed at t = 0.25 s: the beam <snapped>; try another beam"
    told = f"quickreturn: thesis-17: engine mujoco {status}: {remark}".rstrip() + "\n"
    assert errors == ("" if expected == 0 else told)
    lines = output.splitlines()
    assert lines[0] == str(Path("reports/output/index.html"))
    assert len(lines) == 4
    assert Path(lines[0]).is_file()


def test_a_second_report_computes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two engines on the run that settles soonest; then the same again with nothing allowed to run."""
    case, workshop = load_case("thesis-17"), Workshop(Store(tmp_path / "store"))
    first = write_report([case], tmp_path / "first", workshop, engines=("thesis", "reference"))
    assert {run.status for run in first.content.results[0].runs.values()} <= {"settled", "not settled"}
    assert first.content.results[0].runs["reference"].status == "settled"

    def refuse(_: object, jobs: Sequence[object], *__: object) -> Iterator[object]:
        assert not jobs, "a job was started"
        yield from ()

    monkeypatch.setattr(LocalProcesses, "run", refuse)
    write_report([case], tmp_path / "second", workshop, engines=("thesis", "reference"))
    for table in first.tables:
        if table.name not in ("machine", "tables"):  # these two name the time
            assert (tmp_path / "first" / table.file).read_bytes() == (tmp_path / "second" / table.file).read_bytes()
