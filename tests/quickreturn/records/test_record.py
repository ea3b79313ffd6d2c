"""Recorded results: what is written is read back, and what is recorded comes out again."""

import dataclasses
import os
from pathlib import Path

import pytest

from quickreturn import record as recording
from quickreturn.cases.running.job import Outcome
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.conform.contract import Check, Conformance, job
from quickreturn.plugins.conform.records import ConformanceRow, verdicts
from quickreturn.plugins.methods import studies as of_methods
from quickreturn.plugins.methods.race import Race
from quickreturn.plugins.methods.row import Row
from quickreturn.plugins.methods.studies import recorded
from quickreturn.plugins.methods.tests.made_up_map import made_up_map
from quickreturn.plugins.methods.tests.made_up_races import made_up_race
from quickreturn.record import main
from quickreturn.reports import long_studies
from quickreturn.reports.long_studies import About, table, text_of
from quickreturn.reports.page.content import Content

#: Bytes of all recorded tables together; a scene of the race takes some 25,000, of which there are five.
MOST = 250_000


def test_what_is_written_is_read_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_studies, "FOLDER", tmp_path)
    measured = made_up_race()
    (tmp_path / "rows.csv").write_text(text_of(measured.rows))
    (tmp_path / "scenes.csv").write_text(text_of([dataclasses.replace(measured, rows=())]))
    for read, written in zip(table("rows", Row), measured.rows, strict=True):
        for name, value in vars(written).items():  # four digits of numbers
            known = getattr(read, name)
            assert known == (pytest.approx(value, rel=5e-4) if name == "errors" or isinstance(value, float) else value), name
    assert table("scenes", Race) == [dataclasses.replace(measured, rows=())]
    assert table("nothing", Row) == []


def test_conformance_of_record_stands_where_ones_own_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    checks = (Check("a", "passed"), Check("b", "passed"), Check("c", "not judged", "it is coarse"))
    found = [ConformanceRow.of(Conformance(name, True, checks), "1.2") for name in ("thesis", "mujoco")]
    (tmp_path / "conformance.csv").write_text(text_of(found))
    (tmp_path / "about.csv").write_text(text_of([About("conformance", "2001-02-03", "numpy 1", "abc1234", "def5678")]))
    monkeypatch.setattr(long_studies, "FOLDER", tmp_path)
    long_studies.about.cache_clear()
    workshop = Workshop(Store(tmp_path / "store"))
    workshop.kept(Outcome(job("thesis"), Conformance("thesis", False, (Check("a", "failed", "no"),))))
    told = verdicts(Content(results=[], engines=("thesis", "reference", "mujoco"), workshop=workshop))
    long_studies.about.cache_clear()
    recorded = "recorded on 2001-02-03 at commit abc1234; cells of it were last confirmed at commit def5678"
    assert told == {
        "reference": "not tested: run quickreturn conform reference",
        "thesis": "does not conform: 1 check failed; 0 checks passed",
        "mujoco": f"conforms; 2 checks passed, 1 could not be judged ({recorded})",
    }
    assert table("conformance", ConformanceRow) == found


def test_one_study_alone_is_written_and_the_others_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (long_studies, recording):
        monkeypatch.setattr(module, "FOLDER", tmp_path)
    monkeypatch.setenv("QUICKRETURN_STORE", str(tmp_path / "store"))
    monkeypatch.setattr(of_methods, "classes", lambda workshop: made_up_map())
    (tmp_path / "about.csv").write_text(text_of([About("finding", "2001-02-03", "numpy 1", "abc1234", "def5678")]))
    long_studies.about.cache_clear()
    assert main(["--stored", "classes"]) == 0
    written = {study: made for study in long_studies.studies() if (made := long_studies.about(study))}
    long_studies.about.cache_clear()
    assert set(written) == {"finding", "classes"}
    assert written["finding"].date == "2001-02-03"
    assert (written["classes"].commit, written["classes"].confirmed) == (recording.commit(), "")
    recording.confirm("finding")
    assert long_studies.about("finding").confirmed == recording.commit()  # type: ignore[union-attr]
    assert long_studies.about("classes") == written["classes"]
    long_studies.about.cache_clear()
    assert {path.name for path in tmp_path.glob("*.csv")} == {"about.csv", "classes.csv", "classes_scenes.csv"}
    assert of_methods.class_map() == made_up_map()


def test_the_recorded_tables_are_small_and_say_how_they_were_made() -> None:
    files = sorted(long_studies.FOLDER.glob("*.csv"))
    assert files
    assert sum(os.path.getsize(file) for file in files) <= MOST
    made = [long_studies.about(study) for study in long_studies.studies()]
    assert any(made)
    assert all(each.date and each.versions and each.commit for each in made if each)
    assert bool(recorded("benchmark")) == (long_studies.about("benchmark") is not None)
