"""The program from outside: exit codes, one sentence on standard error, JSON alone on standard output, files whole or not at all."""

import csv
import json
import math
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from quickreturn.command_line import main
from quickreturn.engines.trajectory import REQUIRED
from tests.quickreturn.conftest import Answer, Call
from tests.quickreturn.program import PROGRAM, descendants, started, wait_until
from tests.quickreturn.scene_file import SCENE


@pytest.fixture(autouse=True)
def scene(tmp_path: Path) -> Path:
    """A case file `small.toml` in the folder from which the program is called."""
    file = tmp_path / "small.toml"
    file.write_text(SCENE)
    return file


def simulated(call: Call, *more: str, case: str = "small.toml", engine: str = "fake") -> Answer:
    return call("simulate", case, "--engine", engine, "--output", "out.csv", *more)


def document(answer: Answer) -> Any:
    """The one JSON document on standard output; json.loads refuses anything beside it."""
    return json.loads(answer.output)


def refused(answer: Answer, *words: str) -> None:
    """Exit code 2, nothing on standard output, one line on standard error with these words."""
    assert answer.code == 2, answer
    assert answer.output == ""
    assert answer.errors.count("\n") == 1, answer.errors
    assert answer.errors.startswith("quickreturn: ")
    for word in words:
        assert word in answer.errors


def variant(tmp_path: Path, line: str) -> None:
    """Install an engine `variant`: the fake one with one line of its class changed."""
    from tests.engines.fake_package import install

    source = f"from command_line_fake import FakeEngine\nclass Engine(FakeEngine):\n    name = 'variant'\n    {line}\n"
    install(tmp_path / "packages", "variants", {"command_line_variant": source}, {"variant": "command_line_variant:Engine"})


# --- lists -----------------------------------------------------------------------------------------------------------------------


def test_engines_lists_main_and_third_party_ones(call: Call) -> None:
    answer = call("engines", "--json")
    assert answer.code == 0
    rows = {row["name"]: row for row in document(answer)}
    assert list(rows)[:4] == ["thesis", "reference", "exudyn", "mujoco"]
    known = {"version": "fake 1.0", "method": "closed form", "estimate_of": "total", "available": True, "reason": None}
    assert rows["fake"] == {"name": "fake"} | known
    assert "fake 1.0" in call("engines").output


def test_engine_that_fails_without_a_word_is_shown_as_failed(call: Call, tmp_path: Path) -> None:
    variant(tmp_path, "def describe(self, *_): raise ValueError")
    shown = next(each for each in document(call("show", "thesis-24", "--json"))["engines"] if each["engine"] == "variant")
    assert shown["refused"] == "raised ValueError"


def test_engines_describes_one_with_its_settings(call: Call) -> None:
    shown = call("engines", "reference").output
    assert re.search(r"^engine\.modes +1 to 16 +modes of the beam", shown, flags=re.MULTILINE)
    found = document(call("engines", "fake", "--json"))
    assert found["default_accuracy"] == 1e-2
    settings = {row["name"]: row["accepted"] for row in found["settings"]}
    assert settings["engine.step"] == "0.0001 to 1 s"
    assert settings["engine.behaviour"].startswith("good, coarse fails")


def test_engine_that_crashes_on_import_is_listed_with_the_reason(call: Call, tmp_path: Path) -> None:
    from tests.engines.fake_package import install

    crash = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)\n"
    install(tmp_path / "packages", "crashing", {"command_line_crash": crash}, {"crash": "command_line_crash:Engine"})
    (row,) = (row for row in document(call("engines", "--json")) if row["name"] == "crash")
    assert not row["available"]
    assert "killed by SIGSEGV" in row["reason"]


def test_cases_by_tag(call: Call) -> None:
    names = [row["name"] for row in document(call("cases", "--tag", "thesis", "--json"))]
    assert names == [f"thesis-{run:02d}" for run in range(1, 25)]
    assert "thesis-24" in call("cases").output


def test_help_names_every_command(call: Call) -> None:
    answer = call("--help")
    assert answer.code == 0
    for name in ("engines", "cases", "show", "simulate", "modes"):
        assert re.search(rf"^  {name} ", answer.output, re.MULTILINE)
    assert call().output == answer.output


# --- show and modes --------------------------------------------------------------------------------------------------------------


def test_show_gives_the_scene_in_si(call: Call) -> None:
    shown = document(call("show", "small.toml", "--set", "slider.mass=500 g", "--json"))
    assert shown["scene"]["crank"]["length"] == pytest.approx(0.1016, rel=1e-15)  # 101.6 mm, one rounding
    assert shown["units"]["crank"]["length"] == "m"
    assert shown["scene"]["crank"]["initial_speed"] == pytest.approx(1.13 / 0.068, rel=1e-15)  # torque / damping
    assert shown["scene"]["slider"]["joint_stiffness"] == "inf"
    assert shown["scene"]["simulation"] == {"duration": pytest.approx(0.1), "output_step": pytest.approx(1e-3)}
    assert "tip" not in shown["scene"]
    fake = next(each for each in shown["engines"] if each["engine"] == "fake")
    assert fake["refused"] == "slider.mass: engine fake models a massless slider only"


def test_show_says_what_an_engine_builds(call: Call) -> None:
    fake = next(each for each in document(call("show", "small.toml", "--json"))["engines"] if each["engine"] == "fake")
    assert fake == {
        "engine": "fake",
        "refused": None,
        "bodies": ["crank", "follower"],
        "joints": ["slider on the follower"],
        "degrees_of_freedom": 3,
    }
    text = call("show", "small.toml").output
    assert "fake: 3 degrees of freedom" in text
    assert re.search(r"length +0\.1016 +m\n", text)


def test_modes_in_hertz(call: Call) -> None:
    answer = call("modes", "small.toml", "--engine", "fake", "--crank-angle", "180", "--count", "2", "--json")
    # The fake engine adds the crank angle in rad to 10, 20, ... Hz: degrees must have become radians.
    assert document(answer)["frequencies"] == pytest.approx([10.0 + math.pi, 20.0 + math.pi])
    assert "13.1416 Hz" in call("modes", "small.toml", "--engine", "fake", "--crank-angle", "180").output


def test_frequencies_that_cannot_be_are_the_engines_failure(call: Call, tmp_path: Path) -> None:
    """What else cannot be: `tests.engines.test_natural_frequencies`."""
    variant(tmp_path, "def natural_frequencies(self, *_): return [10.0, float('nan')]")
    for more in ((), ("--json",)):
        answer = call("modes", "small.toml", "--engine", "variant", "--crank-angle", "0", *more)
        assert (answer.code, answer.output) == (3, "")
        assert answer.errors.startswith("quickreturn: small: engine variant: the engine returned natural frequencies ")
        assert "that are not finite: [10.0, nan]" in answer.errors
        assert answer.errors.count("\n") == 1


def test_a_model_that_cannot_vibrate_has_no_frequencies(call: Call, tmp_path: Path) -> None:
    variant(tmp_path, "def natural_frequencies(self, *_): return []")
    asked = ("modes", "small.toml", "--engine", "variant", "--crank-angle", "0")
    assert document(call(*asked, "--json"))["frequencies"] == []
    assert "no natural frequency" in call(*asked).output


# --- simulate --------------------------------------------------------------------------------------------------------------------


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
UNITS = {"tip_deflection": " m", "tip_acceleration": " m/s\\^2", "slider_force": " N"}


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
    assert re.search(rf"^ +tip's place +{found['error_estimate']:.1e} +\S+ m$", shown, re.MULTILINE), shown


def test_an_integration_error_is_called_so(call: Call, tmp_path: Path) -> None:
    variant(tmp_path, "estimates = 'integration'")
    answer = simulated(call, "--accuracy", "1e-2", engine="variant")
    assert (answer.code, answer.errors) == (0, "")
    assert re.search(
        r"^integration error +of .*\n +deflection +\S+ +\S+ m +asked: 0\.01; model error not estimated, see `run`$",
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
    assert re.search(r"^ +deflection +\S+ +\S+ m +asked: 0\.01; estimate not verified$", answer.output, re.MULTILINE)
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


def test_unforeseen_error_is_a_sentence_too(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*arguments: object) -> None:
        raise KeyError("surprise")

    monkeypatch.setattr("quickreturn.commands.case_document.document_of", broken)
    answer = call("show", "small.toml")
    assert answer.code == 3
    assert answer.errors == "quickreturn: unforeseen: KeyError: 'surprise'; please report this\n"


# --- real processes --------------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("call")
def test_program_as_a_process(tmp_path: Path) -> None:
    arguments = ("simulate", "small.toml", "--engine", "fake", "--output", "out.csv", "--set", "engine.step=0.1")
    program = started("--quiet", *arguments, "--json", folder=tmp_path)
    output, errors = program.communicate()
    assert (program.returncode, errors) == (0, "")
    assert json.loads(output)["rows"] == 101


@pytest.mark.parametrize(("given", "then"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_the_command_keeps_linear_algebra_to_one_thread_unless_told_otherwise(given: dict[str, str], then: str) -> None:
    program = """
import os, sys
from quickreturn.command_line import main
sys.argv[1:] = ["cases"]
main()
print(os.environ["OPENBLAS_NUM_THREADS"])
"""
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"} | given
    run = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == then


def test_reader_that_has_enough_is_no_error(tmp_path: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    program = subprocess.Popen([PROGRAM, "cases"], stdout=writing, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    os.close(writing)
    assert program.communicate()[1] == ""
    assert program.returncode == 0


@pytest.mark.usefixtures("call")
def test_interrupt_is_exit_130_and_leaves_nothing_behind(tmp_path: Path) -> None:
    arguments = ("simulate", "small.toml", "--engine", "fake", "--output", "out.csv", "--set", "engine.behaviour=hangs")
    program = started("--quiet", *arguments, folder=tmp_path, process_group=0)
    wait_until(lambda: any(descendants(process) for process in descendants(program.pid)), program)  # a worker below the fork server
    os.killpg(program.pid, signal.SIGINT)  # as a terminal does
    output, errors = program.communicate(timeout=300.0)
    told = "quickreturn: interrupted; nothing is kept, the same command begins anew\n"
    assert (program.returncode, output, errors) == (130, "", told)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["packages", "small.toml"]


def test_main_returns_the_code_and_raises_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "no-such-case"]) == 2
    assert main(["show", "\0"]) == 2
    assert main(["\udcff"]) == 2
    assert main(["modes", "\x1b[31m" + "x" * 5000, "--engine", "thesis", "--crank-angle", "0"]) == 2
    assert main(["simulate", "small.toml", "--engine", "thesis", "--output", "\udc00"]) == 2
    errors = capsys.readouterr().err
    assert len(errors.splitlines()) == 5
    assert max(map(len, errors.splitlines())) < 1000
    assert "\x1b" not in errors
    assert "Traceback" not in errors


def test_show_groups_parts_that_differ_in_their_numbers_alone() -> None:
    from quickreturn.commands.case_document import grouped

    assert grouped(["crank", "link 1: rod", "link 2: rod", "link 3: rod", "tip"]) == ["crank", "link 1 to 3: rod", "tip"]
