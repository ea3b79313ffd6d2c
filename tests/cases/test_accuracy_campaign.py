"""Asking for an accuracy delivers it, on scenes that no table of settings was made for."""

import dataclasses
import itertools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import cases.accuracy_campaign
from cases.accuracy_campaign import ACCURACIES, SEED, Row, campaign, chapter, judged, library_scenes, main, scene_rows, summary
from cases.library import case_names
from cases.random_scenes import LARGEST_CONDITION, LARGEST_DEFLECTION, LARGEST_SLIDER_POSITION, Scene, random_scenes
from cases.store import Store
from engines.pseudo_coordinate.reference import ReferenceEngine, ReferenceSettings
from engines.start import standard_start

BAD = [[], ["--random", "0"], ["--random", "-3"], ["--library", "--jobs", "-1"], ["--random", "1", "--accuracy", "1,5"]]
REFERENCE = tuple(itertools.product(["reference"], ACCURACIES))


def check(table: pd.DataFrame) -> None:
    """Who says to have reached an accuracy is within it in 95 % of the requests, and within three times in all; who has not, says why."""
    found = judged(table)
    for name, group in found[found["reached"]].groupby("engine"):
        outside = group[group["ratio"] > 1.0]
        assert len(outside) <= 0.05 * len(group), f"{name}:\n{outside.to_string()}"
        assert (group["ratio"] <= 3.0).all(), f"{name}:\n{outside.to_string()}"
    assert (table[~table["reached"]]["remark"] != "").all()


def test_random_scenes_are_sensible_and_the_same_each_time() -> None:
    scenes = list(itertools.islice(random_scenes(SEED), 2))
    assert scenes == list(itertools.islice(random_scenes(SEED), 2))
    assert scenes[0].mechanism != scenes[1].mechanism
    for scene in scenes:
        mechanism = scene.mechanism
        simulation = ReferenceEngine().prepare(mechanism, standard_start(mechanism), ReferenceSettings(modes=4))
        motion = simulation.advance(scene.duration, 1e-3)
        length = mechanism.follower.length
        assert motion["slider_position"].max() < LARGEST_SLIDER_POSITION * length
        # judged with four modes, as here; the tolerance differs
        assert np.abs(motion["tip_deflection"]).max() < 1.001 * LARGEST_DEFLECTION * length
        assert 0.0 < scene.condition < LARGEST_CONDITION


def test_scenes_of_the_library_are_those_that_the_truth_can_model(monkeypatch: pytest.MonkeyPatch) -> None:
    # without a crank, with a soft joint, leaving the follower's end: each has no truth to be judged by
    names = ("spin-up", "hard-joint-1e5", "hard-speed-x3", "thesis-24")
    assert set(names) < set(case_names())
    monkeypatch.setattr(cases.accuracy_campaign, "case_names", lambda: names)
    assert [scene.name for scene in library_scenes()] == ["thesis-24"]


def test_accuracy_asked_is_delivered_on_five_random_scenes() -> None:
    requests = (("reference", 1e-2), ("reference", 1e-3), ("exudyn", 1e-2))
    rows = [row for scene in itertools.islice(random_scenes(SEED), 5) for row in scene_rows(scene, requests, confirm=False)]
    table = pd.DataFrame([dataclasses.asdict(row) for row in rows])
    check(table)
    coarse = table[table["asked"] == 1e-2]
    assert coarse["reached"].all()
    assert len(judged(coarse)) == len(coarse) == 10


@pytest.mark.verify
def test_accuracy_asked_is_delivered(record_property: Callable[[str, object], None]) -> None:
    table, broken = campaign(_full(), Store())
    assert not broken
    found = summary(table)
    text = (
        "Error of the tip deflection over the accuracy asked for, in runs that say to have reached it; truth, scenes and what is judged: "
        "cases/accuracy_campaign.py."
    )
    record_property("chapter", chapter(found, "Asked and achieved", text))
    record_property("chapter", chapter(table.drop(columns="confirmation"), "Asked and achieved, request by request", ""))
    check(table)
    # an engine that never says to have reached anything would pass the above
    coarse = judged(table).query("asked >= 1e-3")
    assert coarse["reached"].mean() > 0.95
    # a second formulation meets the truth within its own error, some 1e-4 in run 24 and up to tenfold in scenes as stiff or as wild
    confirmed = table.drop_duplicates("scene")["confirmation"].dropna()
    assert confirmed.median() < 3e-4
    assert (confirmed < 0.01).mean() > 0.9


def _full() -> list[tuple[Scene, tuple[tuple[str, float], ...]]]:
    """The library and fifty random scenes; the finest accuracy is asked of `exudyn` in every fourth, a run there takes half a minute."""
    scenes = [*library_scenes(), *itertools.islice(random_scenes(SEED), 50)]
    asked = []
    for number, scene in enumerate(scenes):
        finest = ACCURACIES if number % 4 == 3 else ACCURACIES[:-1]
        asked.append((scene, (*REFERENCE, *itertools.product(["exudyn"], finest))))
    return asked


def row(**changes: object) -> Row:
    known = Row(scene="a", condition=1.0, engine="reference", asked=1e-2, truth_error=1e-5, confirmation=None)
    return dataclasses.replace(known, **({"estimate": 8e-3, "achieved": 5e-3, "reached": True} | changes))  # type: ignore[arg-type]


def test_summary_counts_what_is_judged() -> None:
    rows = [row(), row(achieved=2e-2), row(achieved=3e-2, reached=False, remark="no"), row(truth_error=4e-3), row(achieved=None)]
    (line,) = summary(pd.DataFrame([dataclasses.asdict(each) for each in rows])).to_dict("records")
    assert (line["judged"], line["say so"], line["within"]) == (3, 2, 1)
    assert line["worst achieved / asked"] == pytest.approx(2.0)
    assert line["least estimate / achieved"] == pytest.approx(8e-3 / 3e-2)


def test_process_that_broke_down_is_named_and_the_others_are_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    documents = {("scene", "a"): ({"rows": [dataclasses.asdict(row())]}, {}), ("scene", "b"): ({"failure": "killed by SIGSEGV"}, {})}
    monkeypatch.setattr(cases.accuracy_campaign, "results", lambda *_: documents)
    table, broken = campaign([], Store(tmp_path))
    assert broken == ["b: killed by SIGSEGV"]
    assert table.to_dict("records") == [dataclasses.asdict(row())]


@pytest.mark.parametrize("arguments", BAD)
def test_bad_arguments_are_refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(arguments)
    assert left.value.code == 2
    assert "give" in capsys.readouterr().err


def test_an_engine_that_is_none_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["--random", "1", "--engine", "exudin"])
    assert left.value.code == 2
    assert '"exudin": no such engine (perhaps exudyn is meant)' in capsys.readouterr().err


def test_command_line_writes_what_it_computed_and_continues(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("QUICKRETURN_STORE", str(tmp_path / "store"))
    arguments = ["--random", "1", "--engine", "reference", "--accuracy", "1e-2", "--no-confirmation", "--output", str(tmp_path / "a.csv")]
    assert main(arguments) == 0
    first = (tmp_path / "a.csv").read_bytes()
    assert pd.read_csv(tmp_path / "a.csv")["achieved"].item() < 1e-2
    assert "reference" in capsys.readouterr().out
    monkeypatch.setattr("cases.stored_jobs.run_jobs", lambda jobs, *_: (pytest.fail("computed again") for _ in jobs))
    assert main(arguments) == 0
    assert (tmp_path / "a.csv").read_bytes() == first


def test_campaign_without_any_row_has_an_empty_table(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(cases.accuracy_campaign, "results", lambda *_: {("scene", "a"): ({"rows": []}, {})})
    table, _ = campaign([], Store(tmp_path))
    assert table.empty
    assert summary(table).empty


def test_chapter_has_a_value_per_column() -> None:
    found = chapter(pd.DataFrame([dataclasses.asdict(row(remark="x"))]), "title", "text")
    (line,) = found["rows"]
    assert len(line) == len(found["columns"])
    assert line[found["columns"].index("reached")] == "yes"
    assert line[found["columns"].index("confirmation")] is None
