"""simulate from outside: its file, its numbers, its estimates, and what becomes of failures."""

import csv
import math
import re
from pathlib import Path

import pytest

from quickreturn.engines.trajectory import REQUIRED
from tests.quickreturn.conftest import Call
from tests.quickreturn.input.answers import document, refused, scene, simulated, variant

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


def test_accuracy_missed_is_exit_3_and_the_file_is_kept(call: Call, tmp_path: Path) -> None:
    answer = simulated(call, "--accuracy", "1e-3")
    assert answer.code == 3
    assert "engine fake: the estimated error" in answer.errors
    assert "misses the accuracy 0.001" in answer.errors
    assert "101 rows are kept in out.csv" in answer.errors
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 102


#: Names of what is estimated, in the terminal, and in the JSON document.
COLUMNS = {
    "deflection": "tip_deflection",
    "acceleration": "tip_acceleration",
    "strain 1": "strain_1",
    "strain 2": "strain_2",
    "strain 3": "strain_3",
    "force": "slider_force",
}


#: Of the columns that have one.
UNITS = {"tip_deflection": " mm", "tip_acceleration": " m/s\\^2", "slider_force": " N"}


def test_the_estimate_of_every_column_is_shown(call: Call) -> None:
    found = document(simulated(call, "--accuracy", "1e-2", "--json"))["error_estimates"]
    assert list(found) == list(COLUMNS.values())
    assert found["strain_1"] is not None
    assert found["slider_force"] is None, "zero throughout"
    shown = simulated(call, "--accuracy", "1e-2").output
    assert re.search(r"^error estimate +of +relative +RMS$", shown, re.MULTILINE)
    for name, column in COLUMNS.items():
        text = "unknown" if found[column] is None else f"{found[column]:.1e}"
        size = rf" +\S+{UNITS.get(column, '')}" if found[column] else ""
        asked = r" +asked: 0\.01" if column == "tip_deflection" else ""
        assert re.search(rf"^ +{name} +{re.escape(text)}{size}{asked}$", shown, re.MULTILINE), (name, shown)


def test_the_estimate_of_a_follower_that_does_not_bend_is_the_tips(call: Call) -> None:
    found = document(simulated(call, "--set", "engine.behaviour=rigid", "--json"))
    assert found["error_estimates"]["tip_deflection"] is None
    shown = simulated(call, "--set", "engine.behaviour=rigid").output
    assert re.search(rf"^ +tip's place +{found['error_estimate']:.1e} +\S+ mm$", shown, re.MULTILINE), shown


def test_an_integration_error_is_called_so(call: Call, tmp_path: Path) -> None:
    variant(tmp_path, "estimates = 'integration'")
    answer = simulated(call, "--accuracy", "1e-2", engine="variant")
    assert (answer.code, answer.errors) == (0, "")
    assert re.search(
        r"^integration error +of .*\n +deflection +\S+ +\S+ mm +asked: 0\.01; model error not estimated, see `run`$",
        answer.output,
        re.MULTILINE,
    )
    assert document(simulated(call, "--json", engine="variant"))["estimate_of"] == "integration"
    for arguments in (("engines",), ("engines", "variant")):
        assert "integration error; model error not estimated, see `run`" in call(*arguments).output
    assert document(call("engines", "variant", "--json"))["estimate_of"] == "integration"
    missed = simulated(call, "--accuracy", "1e-4", engine="variant")
    assert missed.code == 3
    assert "the estimated integration error" in missed.errors


def test_an_estimate_that_is_not_verified_reaches_no_accuracy_that_was_asked(call: Call, tmp_path: Path) -> None:
    variant(tmp_path, "estimates = 'unverified'")
    answer = simulated(call, "--accuracy", "1e-2", engine="variant")
    assert answer.code == 3
    assert re.search(r"^ +deflection +\S+ +\S+ mm +asked: 0\.01; estimate not verified$", answer.output, re.MULTILINE)
    assert answer.errors.startswith("quickreturn: small: engine variant: ")
    assert "are not verified" in answer.errors
    assert "101 rows are kept in out.csv" in answer.errors
    asked_nothing = simulated(call, "--json", engine="variant")
    assert (asked_nothing.code, asked_nothing.errors) == (0, "")
    assert document(asked_nothing)["estimate_of"] == "unverified"
    assert "error; estimate not verified" in call("engines").output


def test_without_an_estimate_nothing_is_said_of_the_error(call: Call) -> None:
    found = document(simulated(call, "--no-estimate", "--json"))
    assert (found["error_estimate"], found["reached"], found["estimate_seconds"]) == (None, True, pytest.approx(0.0, abs=0.1))
    shown = simulated(call, "--no-estimate").output
    assert "error estimate" not in shown
    assert re.search(r"^remark +the error is not estimated, as asked$", shown, re.MULTILINE)
    refused = simulated(call, "--no-estimate", "--accuracy", "1e-2")
    assert refused.code == 2
    assert "--accuracy 0.01 and --no-estimate are both given" in refused.errors


def test_an_unknown_error_is_told_with_its_reason(call: Call) -> None:
    settings = ("--set", "engine.step=0.05", "--set", "engine.behaviour=coarse fails")
    answer = simulated(call, *settings)
    assert (answer.code, answer.errors) == (0, "")
    assert answer.output.count("unknown") >= len(COLUMNS)
    assert re.search(r"^remark +the error is unknown: .*the step is too large", answer.output, re.MULTILINE)
    asked = simulated(call, *settings, "--accuracy", "1e-2", "--json")
    assert asked.code == 3
    assert "the error is unknown: " in asked.errors
    assert document(asked)["error_estimate"] is None


def test_failure_is_exit_3_and_keeps_what_was_computed(call: Call, tmp_path: Path) -> None:
    answer = simulated(call, "--set", "engine.behaviour=fails", "--json")
    assert answer.code == 3
    assert document(answer)["failure"] == {"time": 0.002, "cause": "the beam snapped", "advice": "try another beam"}
    assert "failed at t = 0.002 s: the beam snapped; try another beam; 3 rows are kept in out.csv" in answer.errors
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 4


@pytest.mark.parametrize(
    ("behaviour", "words"),
    [
        ("nan", "strain_2 is no longer a finite number"),
        ("raises", "the engine raised ZeroDivisionError at command_line_fake.py, line "),
        ("dies", "engine fake: killed by SIGSEGV"),
        ("hungry", "ran out of memory"),
    ],
)
def test_misbehaving_engine_is_exit_3_with_one_line(call: Call, behaviour: str, words: str) -> None:
    answer = simulated(call, "--set", f"engine.behaviour={behaviour}", "--json")
    assert answer.code == 3
    assert document(answer)["failure"]["cause"] in answer.errors
    assert words in answer.errors
    assert answer.errors.count("\n") == 1


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


def test_output_that_cannot_be_is_refused_before_the_simulation(call: Call) -> None:
    # The engine would die: that it does not shows that it was not asked.
    asked = ("simulate", "small.toml", "--engine", "fake", "--output", "absent/out.csv", "--set", "engine.behaviour=dies")
    refused(call(*asked), "absent/out.csv", "no folder")


def test_full_disk_is_one_sentence(call: Call) -> None:
    refused(
        call("simulate", "small.toml", "--engine", "fake", "--output", "/dev/full", "--set", "engine.step=0.1"),
        "/dev/full",
        "no space left",
    )
    assert Path("/dev/full").is_char_device(), "a device must not be replaced by a file"


def test_output_through_a_link_replaces_the_file_and_not_the_link(call: Call, tmp_path: Path) -> None:
    (tmp_path / "target.csv").write_text("old")
    (tmp_path / "out.csv").symlink_to("target.csv")
    assert simulated(call, "--set", "engine.step=0.1").code == 0
    assert (tmp_path / "out.csv").is_symlink()
    assert (tmp_path / "target.csv").read_text().startswith("time,")
