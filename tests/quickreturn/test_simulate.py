"""simulate from outside: its file, its numbers, its estimates, and what becomes of failures."""

import csv
import math
import re
import sys
from pathlib import Path

import pytest

from quickreturn.engines.trajectory import REQUIRED
from tests.quickreturn.conftest import Call
from tests.quickreturn.input.answers import document, scene, simulated, variant
from tests.quickreturn.scene_file import SCENE

__all__ = ["scene"]


def test_simulate_writes_columns_in_order_and_numbers_in_full(call: Call, tmp_path: Path) -> None:
    answer = simulated(call, "--set", "engine.step=0.1")
    assert answer.code == 0, answer.errors
    with (tmp_path / "out.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head == [*REQUIRED, "kinetic_energy"]
    assert len(rows) == 101
    times, deflections = ([float(row[head.index(name)]) for row in rows] for name in ("time", "tip_deflection"))
    assert times[-1] == pytest.approx(0.1)
    # Bit for bit the number of the engine: error_of(0.1) = 0.5 x 0.1^2.
    assert deflections[0] == 0.5 * 0.1**2
    assert answer.errors == ""


def test_simulate_json(call: Call) -> None:
    found = document(simulated(call, "--accuracy", "1e-2", "--json"))
    assert (found["case"], found["engine"], found["rows"]) == ("small", "fake", 101)
    assert (found["setup_seconds"], found["solve_seconds"]) == (0.25, 0.125)
    assert found["settings"] == {"step": 0.025, "behaviour": "good"}
    # sin t + e cos t with e = 0.5 x 0.025^2: over 0.1 s the sine has an RMS of 0.1 / sqrt(3), the cosine one of nearly 1 (to 0.2 %).
    assert found["error_estimate"] == pytest.approx(0.5 * 0.025**2 * math.sqrt(3.0) / 0.1, rel=0.01)
    assert found["reached"] is True


def test_chatter_of_a_library_does_not_reach_standard_output(call: Call) -> None:
    answer = simulated(call, "--set", "engine.behaviour=prints", "--json")
    assert document(answer)["settings"]["behaviour"] == "prints"
    assert answer.errors == ""


@pytest.mark.parametrize(
    ("duration", "step", "rows"), [("0.2", "0.01", 21), ("200 ms", "10 ms", 21), ("0.2 s", "1e-2", 21), ("2e-3", "1 ms", 3)]
)
def test_times_with_and_without_units(call: Call, duration: str, step: str, rows: int) -> None:
    answer = simulated(call, "--duration", duration, "--output-step", step, "--set", "engine.step=0.1", "--json")
    assert document(answer)["rows"] == rows


def test_output_through_a_link_replaces_the_file_and_not_the_link(call: Call, tmp_path: Path) -> None:
    (tmp_path / "target.csv").write_text("old")
    (tmp_path / "out.csv").symlink_to("target.csv")
    assert simulated(call, "--set", "engine.step=0.1").code == 0
    assert (tmp_path / "out.csv").is_symlink()
    assert (tmp_path / "target.csv").read_text().startswith("time,")


#: What is estimated, as the terminal and the JSON document name it.
COLUMNS = {"deflection": "tip_deflection", "acceleration": "tip_acceleration", "force": "slider_force"} | {
    f"strain {k}": f"strain_{k}" for k in (1, 2, 3)
}


@pytest.mark.parametrize(
    ("line", "more", "code", "estimate_of", "errors"),
    [
        ("", ("--accuracy", "1e-3"), 3, "total", 1),
        ("", ("--set", "engine.behaviour=rigid"), 0, "total", 0),
        ("", ("--no-estimate",), 0, "total", 0),
        ("", ("--set", "engine.step=0.05", "--set", "engine.behaviour=coarse fails", "--accuracy", "1e-2"), 3, "total", 1),
        ("estimates = 'integration'", ("--accuracy", "1e-2"), 0, "integration", 0),
        ("estimates = 'unverified'", ("--accuracy", "1e-2"), 3, "unverified", 1),
    ],
)
def test_the_terminal_shows_the_estimates_of_the_document_and_the_code_whether_they_suffice(
    call: Call, tmp_path: Path, line: str, more: tuple[str, ...], code: int, estimate_of: str, errors: int
) -> None:
    variant(tmp_path, line or "pass")
    words, answer = (simulated(call, *more, *json, engine="variant") for json in ((), ("--json",)))
    found = document(answer)
    assert (words.code, answer.code, found["estimate_of"], words.errors.count("\n")) == (code, code, estimate_of, errors)
    assert (found["reached"], found["rows"]) == (code == 0, 101)
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 102
    estimates = found["error_estimates"]
    for name, column in COLUMNS.items() if "--no-estimate" not in more else ():
        text = "unknown" if estimates[column] is None else f"{estimates[column]:.1e}"
        rigid = column == "tip_deflection" and estimates[column] is None and found["error_estimate"] is not None
        shown = rf"tip's place +{found['error_estimate']:.1e} +\S+ mm" if rigid else f"{name} +{re.escape(text)}"
        assert re.search(rf"^ +{shown}", words.output, re.MULTILINE), (name, words.output)


def test_a_failure_is_exit_3_and_keeps_what_was_computed(call: Call, tmp_path: Path) -> None:
    answer = simulated(call, "--set", "engine.behaviour=fails", "--json")
    assert answer.code == 3
    assert document(answer)["failure"] == {"time": 0.002, "cause": "the beam snapped", "advice": "try another beam"}
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 4
    assert (
        "3 rows are kept only with --output" in call("simulate", "small.toml", "--engine", "fake", "--set", "engine.behaviour=fails").errors
    )


@pytest.mark.parametrize(
    ("command", "file", "module", "extra"),
    [
        ("animate", "run.webp", "matplotlib", "plot"),
        ("sweep", "run.parquet", "pyarrow", "tables"),
        ("sweep", "run.nc", "h5netcdf", "tables"),
    ],
)
def test_an_extra_that_is_missing_is_told_before_anything_is_computed(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, file: str, module: str, extra: str
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / "small.toml").write_text(SCENE)
    varied = ("--vary", "tip.mass = 0.01 kg; 0.02 kg") if command == "sweep" else ()
    answer = call(command, "small.toml", "--output", file, *varied)
    assert answer == (2, "", f"quickreturn: {file} needs {module}, which is not installed; pip install 'quickreturn[{extra}]'\n")
