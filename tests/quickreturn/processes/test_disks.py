"""The store and files of the program where a result is damaged, a disk is full or a folder cannot be."""

import contextlib
import json
import resource
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.quickreturn.conftest import Answer, Call
from tests.quickreturn.processes.faulty_runs import answer_of, engines, nothing_half_done, place, simulations, stored
from tests.quickreturn.program import started

__all__ = ["place"]


@pytest.mark.verify
def test_a_damaged_result_is_computed_anew_and_said_in_one_sentence(place: Path, call: Call) -> None:
    arguments = ("run", "small.toml", *engines("sound", "also-sound"), "--json")
    first = call(*arguments)
    assert (first.code, first.errors) == (0, "")
    simulated = simulations(place)
    assert set(simulated) == {"sound", "also-sound"}
    whole = {file: file.read_bytes() for file in stored(place)}
    damaged, edited = stored(place)
    damaged.write_bytes(whole[damaged][:-100])
    edited.write_bytes(whole[edited].replace(b"settled", b"sattled", 1))
    code, output, errors = call(*arguments)
    said = json.loads(output)["notices"]
    assert (code, sorted(errors.splitlines())) == (0, sorted(f"quickreturn: {sentence}" for sentence in said))
    assert all(any(file.name in sentence and "computed anew" in sentence for sentence in said) for file in (damaged, edited))
    assert sorted(simulations(place)) == sorted(simulated * 2)
    second = json.loads(output)["cases"][0]["engines"]
    assert [engine["measures"] for engine in second] == [engine["measures"] for engine in json.loads(first.output)["cases"][0]["engines"]]
    third = call(*arguments)
    assert (third.code, third.errors) == (0, "")
    assert len(simulations(place)) == 2 * len(simulated)


@contextlib.contextmanager
def no_file_larger_than(size: int) -> Iterator[None]:
    """A limit on the size of files stands for a full disk: it holds for root too."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


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
