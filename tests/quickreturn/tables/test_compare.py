"""`quickreturn compare` from outside: tables of the program's own trajectories, changed or not, held against an engine."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import quickreturn as qr
from quickreturn.command_line import main
from quickreturn.table_comparison import TableComparison
from tests.engines.fake_package import install
from tests.quickreturn.conftest import Call
from tests.quickreturn.input.answers import refused


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> str:
    """One folder of results for all tests of this file: they compare with the same runs."""
    return str(tmp_path_factory.mktemp("store"))


@pytest.fixture(autouse=True)
def _one_store(store: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QUICKRETURN_STORE", store)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A trajectory of the reference."""
    file = tmp_path_factory.mktemp("trajectory") / "out.csv"
    assert main(["simulate", "thesis-24", "--engine", "reference", "--no-estimate", "--output", str(file)]) == 0
    return file


@pytest.fixture(scope="module")
def trajectory(file: Path) -> pd.DataFrame:
    return pd.read_csv(file)


def test_our_own_trajectory_in_other_units_passes(call: Call, file: Path, trajectory: pd.DataFrame) -> None:
    table = pd.DataFrame(
        {
            "time [ms]": 1e3 * trajectory["time"],
            "crank_angle [deg]": np.degrees(trajectory["crank_angle"]),
            "tip_deflection [mm]": 1e3 * trajectory["tip_deflection"],
            "strain_2 [microstrain]": 1e6 * trajectory["strain_2"],
        }
    )
    Path("tool.csv").write_text("# version = 7.1\n" + table.to_csv(index=False))
    Path("own.csv").symlink_to(file)
    answer = call("compare", "thesis-24", "tool.csv", "own.csv", "--engine", "reference", "--json", "--output", "picture.png")
    assert answer.code == 0, answer.errors
    (case,) = json.loads(answer.output)["cases"]
    assert (case["case"], case["turn"], case["passed"]) == ("thesis-24", 5, True)
    reference, tool, own = case["engines"]
    assert [found["engine"] for found in (reference, tool, own)] == ["reference", "tool.csv", "own.csv"]
    assert tool["version"] == "7.1"
    assert {(found["half"], found["channel"]) for found in tool["measures"]} == {
        (half, channel) for half in ("pre", "post") for channel in ("tip_deflection", "strain_2")
    }
    frequency = {found["half"]: found["first_mode_frequency"] for found in tool["consensus"]}
    for found in reference["consensus"]:
        assert frequency[found["half"]] == pytest.approx(found["first_mode_frequency"], rel=0.01)
    assert case["differences"]["own.csv"]["reference"]["tip_deflection"] < 2e-3
    assert Path("picture.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.verify
def test_a_table_that_departs_is_told_with_its_factor(call: Call, trajectory: pd.DataFrame) -> None:
    trajectory.assign(strain_2=-trajectory["strain_2"]).to_csv("tool.csv", index=False)
    answer = call("compare", "thesis-24", "tool.csv", "--engine", "reference")
    assert answer.code == 1
    assert "tool.csv: strain_2 is -1 times that of reference" in answer.output
    assert "tool.csv and reference disagree by more than they claim" in answer.output
    assert "turn 5" in answer.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["tool.csv"], ["tool.csv", "no such file"]),
        (["bad.csv"], ["bad.csv", "line 1", "tip_deflecton", "tip_deflection"]),
        (["good.csv", "--engine", "nobody"], ["nobody"]),
        (["reference", "--engine", "reference"], ["two", "reference"]),  # a file of an engine's name
        (["good.csv", "--separator", "tabs"], ["--separator", "tabs", ";"]),
        (["titled.csv"], ["titled.csv", "line 1", "--skip"]),
        (["good.csv", "--output", "picture.gif"], ["picture.gif", ".png", ".svg"]),
        ([], ["FILE"]),
    ],
)
def test_bad_input(call: Call, file: Path, arguments: list[str], words: list[str]) -> None:
    Path("folder").mkdir()
    for name in ("good.csv", "folder/good.csv", "reference"):
        Path(name).symlink_to(file)
    Path("bad.csv").write_text("time,tip_deflecton\n0,1\n")
    Path("titled.csv").write_text("Run 7\ntime,tip_deflection\n0,1\n")
    refused(call("compare", "thesis-24", *arguments), *words)


@pytest.mark.verify
def test_report_and_run_take_third_party_engines_and_tables(call: Call, tmp_path: Path) -> None:
    """A copy of the reference in another package, and a table that settles: both are shown and compared, and neither is called ours."""
    twin = "from quickreturn.engines.own.reference import ReferenceEngine\n\n\nclass Twin(ReferenceEngine):\n    name = 'twin'\n"
    twin += "\n    def version(self):\n        return 'twin <b>2'\n"
    install(tmp_path / "packages", "twins", {"command_line_twin": twin}, {"twin": "command_line_twin:Twin"})
    call("simulate", "thesis-24", "--engine", "reference", "--duration", "12 s", "--output", "long.csv")
    Path("<script>alert(1).csv").write_text("# version = <i>7.1\n" + Path("long.csv").read_text())
    arguments = ("thesis-24", "--engine", "reference", "--engine", "twin", "--engine", "<script>alert(1).csv")
    answer = call("report", *arguments, "--output", "page")
    assert answer.code == 0, answer.errors
    page = Path("page/index.html").read_text()
    assert "<script>alert(1).csv" not in page
    assert "<i>7.1" not in page
    engines = pd.read_csv("page/engines.csv", index_col=0)
    assert list(engines.index) == ["reference", "twin", "<script>alert(1).csv"]
    assert list(engines["origin"]) == ["this project", "another package", "a file"]
    assert list(engines["version"])[1:] == ["twin <b>2", "<i>7.1"]
    answer = call("run", *arguments, "--json")
    (case,) = json.loads(answer.output)["cases"]
    assert [found["engine"] for found in case["engines"]] == list(engines.index)
    assert not [
        check
        for check in case["checks"]
        if check["engine"] == "<script>alert(1).csv" and check["other"] == "reference" and not check["passed"]
    ]
    assert call("report", "thesis-24", "thesis-23", "--engine", "long.csv").code == 2  # of which of the two cases it is, it does not say


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("other") / "out.csv"
    assert main(["simulate", "thesis-17", "--engine", "reference", "--no-estimate", "--output", str(file)]) == 0
    return file


@pytest.mark.verify  # quantities are fitted, which takes a quarter of a minute
def test_for_a_table_of_another_case_none_is_proposed(call: Call, other: Path) -> None:
    Path("tool.csv").symlink_to(other)
    answer = call("compare", "thesis-24", "tool.csv", "--engine", "reference", "--json")
    assert answer.code == 1
    (case,) = json.loads(answer.output)["cases"]
    told = case["slips"]["tool.csv"]
    assert {"time", "unexplained"} <= set(told)  # and plain factors of columns that hardly vary
    assert told["time"].startswith("a turn of the crank takes 19 % longer in it than in reference")
    assert "nor one or two quantities of thesis-24, explains the difference of " in told["unexplained"]
    assert "thesis-17" not in str(told)
    assert case["places"]["tool.csv"]["reference"].keys() == case["differences"]["tool.csv"]["reference"].keys()


@pytest.mark.verify
def test_in_python_a_table_is_told_the_same(call: Call, trajectory: pd.DataFrame) -> None:
    found = qr.compare("thesis-24", trajectory.assign(strain_2=-trajectory["strain_2"]), "reference", quiet=True)
    assert found.passed is False
    assert {check.channel for check in found.missed} == {"strain_2"}
    assert set(found.explanations) == {"strain_2"}
    assert "table departs from reference" in found.verdict
    assert found.differences["reference"]["strain_2"] == pytest.approx(2.0, rel=1e-2)
    assert found.differences["reference"]["tip_x"] < 1e-4
    assert len(found.frame) == len(found.rows) > len(found.missed)
    assert "table: strain_2 is -1 times that of reference" in repr(found)
    as_it_is = qr.compare("thesis-24", trajectory, "reference", quiet=True)
    assert (as_it_is.passed, as_it_is.explanations, as_it_is.missed) == (True, {}, ())
    assert f"in all {len(as_it_is.rows)} comparisons" in as_it_is.verdict
    assert {"tip_acceleration", "slider_force", "moment_06", "pivot_force_x"} < {check.channel for check in as_it_is.rows}
    wide = [replace(row, number=replace(row.number, estimate=row.scale)) for row in as_it_is.rows]
    nothing = TableComparison(replace(as_it_is.result, table_checks=tuple(wide)), as_it_is.name)
    assert nothing.passed is None
    assert nothing.verdict.startswith(f"table could not be judged: all {len(wide)} comparisons say nothing")
    some = TableComparison(replace(as_it_is.result, table_checks=(*as_it_is.rows[1:], wide[0])), as_it_is.name)
    assert (some.passed, "of them say nothing" in some.verdict) == (True, True)


def test_in_python_it_is_told_how_a_file_was_read(trajectory: pd.DataFrame, tmp_path: Path) -> None:
    trajectory[["time", "crank_angle", "strain_2"]].to_csv(tmp_path / "tool.csv", sep=";", decimal=",", index=False)
    found = qr.compare("thesis-24", tmp_path / "tool.csv", "reference", quiet=True)
    assert repr(found).splitlines()[0] == f"tool.csv: read as: semicolons, decimal comma, {len(trajectory):,} rows"
    lines = (tmp_path / "tool.csv").read_text()
    (tmp_path / "titled.csv").write_text(f"Run 7\n{lines}")
    with pytest.raises(qr.CaseError, match="skip="):
        qr.compare("thesis-24", tmp_path / "titled.csv", "reference", quiet=True)
    titled = qr.compare("thesis-24", tmp_path / "titled.csv", "reference", separator=";", decimal=",", skip=1, quiet=True)
    assert titled.differences == found.differences
