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
