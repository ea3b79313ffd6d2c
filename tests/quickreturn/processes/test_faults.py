"""What a user sees of a fault, of a disk among them: one sentence that names it, an exit code, and all that it has not touched."""

import contextlib
import json
import os
import resource
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.engines import faulty_engines
from tests.engines.faulty_engines import SIGNAL
from tests.quickreturn.conftest import Answer, Call
from tests.quickreturn.processes.faulty_runs import answer_of, engines, nothing_half_done, place, prepared, run, simulations, stored
from tests.quickreturn.program import descendants, running, started, wait_until

__all__ = ["place"]

_LINES = Path(faulty_engines.__file__).read_text("utf-8").splitlines()
_PLACE = f"faulty_engines.py, line {next(number for number, line in enumerate(_LINES, 1) if 'a bug' in line)}"
#: Engine -> what is said of it.
FAULTS = {
    "raises": f"failed at t = 0 s: the engine raised ZeroDivisionError at {_PLACE}: a bug; report this to the author of the engine",
    "returns-nan": "failed at t = 0.0008 s: strain_2 is no longer a finite number; try finer settings",
    "hoards": "ran out of memory (memory limit of 0.25 GiB)",
    "hoards-in-c": 'killed by SIGABRT (its last words: "fatal error: cannot allocate memory")',
    "segfaults": "killed by SIGSEGV",
    "is-killed": "killed by SIGKILL (by the user, or by the system for lack of memory)",
    "quits": "ended without a result (exit code 0)",
    "cuts-the-line": "cut its connection to the runner",
    "fills-the-disk": "raised OSError: [Errno 28] No space left on device",
    "says-nonsense": "its result cannot be stored: Out of range float values are not JSON compliant",
}


# --- engines that misbehave ------------------------------------------------------------------------------------------------------


class Campaign:
    """One run of all faulty engines between two sound ones."""

    def __init__(self, folder: Path) -> None:
        limits = ("--memory-limit", "0.25", "--jobs", "3")
        program = started(
            "run", "--quiet", "small.toml", *engines("sound", *FAULTS, "also-sound"), *limits, "--json", folder=prepared(folder)
        )
        self.folder = folder
        self.answer = answer_of(program)
        self.document = json.loads(self.answer.output)
        self.engines = {engine["engine"]: engine for engine in self.document["cases"][0]["engines"]}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    return Campaign(tmp_path_factory.mktemp("campaign"))


@pytest.mark.parametrize("engine", FAULTS)
def test_an_engine_is_named_for_what_it_did(campaign: Campaign, engine: str) -> None:
    found = campaign.engines[engine]
    remark = found["remark"]
    assert (found["status"], remark.removesuffix(": nan")) == ("failed", FAULTS[engine])  # newer versions of Python name the value
    assert {"case": "small", "engine": engine, "status": "failed", "remark": remark} in campaign.document["failures"]
    assert f"quickreturn: small: engine {engine} failed: {remark}\n" in campaign.answer.errors


def test_an_engine_that_hangs_is_stopped_at_the_time_limit(place: Path, call: Call) -> None:
    code, output, _ = call("run", "small.toml", "--engine", "hangs", "--time-limit", "1 s", "--json")
    assert code == 3
    (failure,) = json.loads(output)["failures"]
    assert failure["remark"] == "stopped at the time limit of 1 s"
    assert stored(place) == []


def test_the_engines_beside_them_complete(campaign: Campaign) -> None:
    assert campaign.answer.code == 3
    for engine in ("sound", "also-sound"):
        assert campaign.engines[engine]["status"] == "settled"
        assert len(campaign.engines[engine]["measures"]) > 0
    assert len(campaign.answer.errors.splitlines()) == len(FAULTS)


def test_what_the_machine_did_to_an_engine_is_not_kept(campaign: Campaign) -> None:
    # An engine's own failure would come out again and is kept beside the two results; the other faults may be gone the next time.
    assert len(stored(campaign.folder)) == len(["sound", "also-sound", "raises", "returns-nan"])
    assert nothing_half_done(campaign.folder)


@pytest.mark.verify
def test_a_report_asks_engines_as_run_does(place: Path, call: Call) -> None:
    """A run with the same settings and accuracy finds the report's result in the store."""
    asked = ("small.toml", "--engine", "sound", "--set", "sound.step=0.2", "--accuracy", "0.05")
    assert call("report", *asked)[0] == 0
    done = simulations(place)
    code, output, _ = call("run", *asked, "--json")
    assert code == 0
    assert simulations(place) == done != []
    (case,) = json.loads(output)["cases"]
    (engine,) = case["engines"]
    assert engine["settings"]["step"] == 0.2


def test_an_engine_that_is_not_installed_is_refused_by_name_and_passed_over_as_one_of_the_main_ones(
    place: Path, call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    reason = "it cannot be loaded (ModuleNotFoundError: No module named 'no_such_library')"
    for arguments in (("run", "small.toml", "--engine", "sound"), ("simulate", "small.toml", "--output", "out.csv")):
        code, output, errors = call(*arguments, "--engine", "not-installed")
        assert (code, output) == (2, "")
        assert errors.startswith("quickreturn: ")
        assert "not-installed" in errors
        assert errors.endswith(f"{reason}\n")
    assert simulations(place) == []
    monkeypatch.setattr("quickreturn.arguments.MAIN", ("sound", "not-installed"))
    code, output, errors = call("run", "small.toml", "--json")
    assert code == 3
    assert [engine["status"] for engine in json.loads(output)["cases"][0]["engines"]] == ["settled", "unavailable"]
    assert errors == f"quickreturn: small: engine not-installed unavailable: {reason}\n"
    assert len(stored(place)) == 1, "an engine may be installed tomorrow"


@pytest.mark.verify
def test_a_simulation_that_is_stopped_at_its_limits_leaves_no_file(place: Path, call: Call) -> None:
    words = {"hangs": "stopped at the time limit of 1.5 s", "hoards": "ran out of memory (memory limit of 0.5 GiB)"}
    for engine, said in words.items():
        limits = ("--time-limit", "1.5" if engine == "hangs" else "1 min", "--memory-limit", "0.5")
        code, _, errors = call("simulate", "small.toml", "--engine", engine, "--output", "out.csv", *limits)
        assert code == 3
        assert f"engine {engine}: {said}" in errors
        assert errors.endswith("there is nothing to keep\n")
        assert not (place / "out.csv").exists()


# --- the runner is killed or interrupted -----------------------------------------------------------------------------------------


@pytest.mark.verify
def test_a_killed_run_takes_its_workers_with_it_and_the_next_one_continues(place: Path, call: Call) -> None:
    program = run(place, "sound", "also-sound", "waits")
    wait_until(lambda: len(stored(place)) == 2 and "waits" in simulations(place), program)
    below = descendants(program.pid)
    assert len(below) >= 2, "a fork server with the worker that waits"
    before = simulations(place)
    entries = {file: file.read_bytes() for file in stored(place)}
    program.kill()
    program.communicate()
    wait_until(lambda: not any(map(running, below)))
    (place / SIGNAL).touch()
    code, output, errors = call("run", "small.toml", *engines("sound", "also-sound", "waits"), "--json")
    assert (code, errors) == (0, "")
    assert [engine["status"] for engine in json.loads(output)["cases"][0]["engines"]] == ["settled"] * 3
    assert set(simulations(place)[len(before) :]) == {"waits"}, "what was stored is not computed again"
    assert len(stored(place)) == 3
    assert {file: file.read_bytes() for file in entries} == entries
    assert nothing_half_done(place)


@pytest.mark.verify
def test_an_interrupted_run_ends_at_once_and_keeps_what_it_has(place: Path) -> None:
    program = run(place, "sound", "hangs", process_group=0)
    wait_until(lambda: len(stored(place)) == 1 and "hangs" in simulations(place), program)
    below = descendants(program.pid)
    for _ in range(20):  # an impatient user; a terminal sends it to the whole group
        os.killpg(program.pid, signal.SIGINT)
        time.sleep(0.005)
    answer = answer_of(program)
    assert (answer.code, answer.output) == (130, "")
    assert answer.errors == "quickreturn: interrupted; what was finished is kept in .quickreturn; the same command goes on from there\n"
    wait_until(lambda: not any(map(running, below)))
    assert len(stored(place)) == 1
    assert nothing_half_done(place)


@contextlib.contextmanager
def no_file_larger_than(size: int) -> Iterator[None]:
    """A limit on the size of files stands for a full disk: it holds for root too."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.verify
def test_a_full_disk_costs_no_result_that_is_shown_and_none_that_was_stored(place: Path, call: Call) -> None:
    assert call("run", "small.toml", *engines("also-sound")).code == 0
    (entry,) = stored(place)
    before = entry.read_bytes()
    with no_file_larger_than(3 * len(before) // 4):  # too small for the other result, and large enough for what is printed
        code, output, errors = call("run", "small.toml", *engines("sound", "also-sound"), "--json")
    document = json.loads(output)
    (sentence,) = document["notices"]
    assert (code, errors) == (2, f"quickreturn: {sentence}\n")
    assert ".quickreturn" in sentence
    assert "file too large" in sentence
    assert [engine["status"] for engine in document["cases"][0]["engines"]] == ["settled", "settled"]
    assert stored(place) == [entry]
    assert entry.read_bytes() == before
    assert nothing_half_done(place)


def test_an_output_file_on_a_full_disk_stays_as_it_was(place: Path, call: Call) -> None:
    (place / "out.csv").write_text("old")
    with no_file_larger_than(5_000):  # the trajectory takes some 15 kB
        answer = call("simulate", "small.toml", "--engine", "sound", "--output", "out.csv")
    assert answer == Answer(2, "", "quickreturn: --output out.csv: it cannot be written (file too large)\n")
    assert (place / "out.csv").read_text() == "old"
    assert nothing_half_done(place)


def test_standard_output_on_a_full_disk_is_one_sentence(place: Path) -> None:
    with open("/dev/full", "w") as full:
        program = started("cases", folder=place, stdout=full)
        assert answer_of(program)[::2] == (2, "quickreturn: standard output cannot be written (no space left on device)\n")


@pytest.mark.parametrize("folder", ["file", "file/below", "/proc/nowhere", "/dev/null"])
def test_a_folder_that_cannot_be_is_told_before_anything_runs(
    place: Path, call: Call, monkeypatch: pytest.MonkeyPatch, folder: str
) -> None:
    (place / "file").write_text("not a folder")
    code, output, errors = call("report", "small.toml", "--output", folder)
    assert (code, output, errors.count("\n")) == (2, "", 1)
    assert f"--output {folder}" in errors.replace("'", "")
    monkeypatch.setenv("QUICKRETURN_STORE", folder)
    for arguments in (("run", "small.toml", *engines("sound")), ("report", "small.toml")):
        code, output, errors = call(*arguments)
        assert (code, output, errors.count("\n")) == (2, "", 1)
        assert f"store folder {folder}" in errors
        assert "QUICKRETURN_STORE" in errors
    assert (place / "file").read_text() == "not a folder"
    assert simulations(place) == []
