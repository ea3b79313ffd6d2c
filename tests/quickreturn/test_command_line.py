"""The program from outside: exit codes, one sentence on standard error, JSON alone on standard output, files whole, and its help."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from quickreturn.command_line import commands
from tests.quickreturn.conftest import Call
from tests.quickreturn.input.answers import document, scene, variant
from tests.quickreturn.program import PROGRAM, descendants, started, wait_until

__all__ = ["scene"]


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
    assert re.search(r"length +101\.6 +mm\n", text)


def test_unforeseen_error_is_a_sentence_too(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*arguments: object) -> None:
        raise KeyError("surprise")

    monkeypatch.setattr("quickreturn.commands.case_document.document_of", broken)
    answer = call("show", "small.toml")
    assert answer.code == 3
    assert answer.errors == "quickreturn: unforeseen: KeyError: 'surprise'; please report this\n"


# --- real processes --------------------------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize(("returned", "code"), [("[10.0, float('nan')]", 3), ("[]", 0)])
def test_frequencies_that_cannot_be_are_the_engines_failure_and_none_is_an_answer(
    call: Call, tmp_path: Path, returned: str, code: int
) -> None:
    variant(tmp_path, f"def natural_frequencies(self, *_): return {returned}")
    asked = ("modes", "small.toml", "--engine", "variant", "--crank-angle", "0")
    words, answer = call(*asked), call(*asked, "--json")
    assert (words.code, answer.code, bool(words.output), words.errors.count("\n")) == (code, code, code == 0, int(code == 3))
    assert document(answer)["frequencies"] == [] if code == 0 else "variant" in answer.errors


WIDTH = 80
#: What may follow the last sentence of an option.
DEFAULT = r" +\[(default: [^\]]+|required)\]"


def entries(lines: list[str]) -> list[str]:
    """The texts of a list of options or commands, each on one line, without the names before them."""
    column = min(found.end() for line in lines if (found := re.match(r"  \S.*?  +(?=\S)", line)))
    texts: list[str] = []
    for line in lines:
        if line[2] != " ":  # a name stands there
            texts.append("")
        texts[-1] = f"{texts[-1]} {line[column:]}".strip()
    return texts


@pytest.mark.parametrize("name", ["", *commands()])
def test_every_help_text_consists_of_whole_sentences(call: Call, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    answer = call(*filter(None, [name]), "--help")
    assert (answer.code, answer.errors) == (0, "")
    assert max(map(len, answer.output.splitlines())) <= WIDTH
    usage, *paragraphs = answer.output.strip().split("\n\n")
    assert usage.startswith("Usage: quickreturn")
    assert len(paragraphs) >= 2
    for paragraph in paragraphs:
        head, *lines = paragraph.splitlines()
        texts = entries(lines) if head in ("Options:", "Commands:", "Measures:") else [" ".join(paragraph.split())]
        for text in texts:
            assert re.fullmatch(rf"[A-Z].*[^.]\.({DEFAULT})?", text), text
            assert "..." not in text, text
    assert "--quiet" in answer.output
    if name:  # the list of commands has the first sentence of each
        told = re.split(r"(?<=\.)\s", " ".join(paragraphs[0].split()))[0]
        assert f"{name} {told}" in " ".join(call("--help").output.partition("Commands:\n")[2].split())


def test_help_imports_no_command() -> None:
    asked = "import sys; from quickreturn.command_line import main; main(['--help']); print('imported', *sys.modules)"
    loaded = (
        subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True).stdout.partition("imported ")[2].split()
    )
    assert [name for name in loaded if name.startswith("quickreturn.commands.")] == ["quickreturn.commands.console"]
