# ruff: noqa: E501  (rows of tables)
"""Thousands of mistakes, each answered by the program with one clear sentence, exit code 2, and nothing else.

The engine is the fake one of these tests, so that what is accepted costs nothing.
"""

import itertools
import os
import random
import re
import shlex
from pathlib import Path

import pytest

from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import load_case
from tests.cases.files.scene_texts import parse_case
from tests.quickreturn.conftest import Answer, Call
from tests.quickreturn.input import mistakes
from tests.quickreturn.input.mistakes import scene, written

LONGEST = 400  # characters: five lines of a terminal
MODES = "modes small.toml --engine fake --crank-angle 90"
OUTPUT = "simulate small.toml --engine fake --output"
SIMULATE = f"{OUTPUT} out.csv"


def sentence(answer: Answer) -> str:
    """What a refusal says; it must be one bearable sentence on standard error, with exit code 2 and nothing on standard output."""
    (told,) = sentences(answer)
    return told


def sentences(answer: Answer) -> list[str]:
    """What a refusal says of each mistake, a line each."""
    assert (answer.code, answer.output) == (2, ""), answer
    assert re.fullmatch(r"(quickreturn: [^\n]+\n)+", answer.errors), answer.errors
    return [bearable(line.removeprefix("quickreturn: ")) for line in answer.errors.splitlines()]


def bearable(told: str) -> str:
    """One sentence that can be printed, and is not too long."""
    assert len(told) <= LONGEST, told
    assert told.isprintable(), told
    assert "Traceback" not in told, told
    assert "unforeseen" not in told, told
    assert not re.search(r"[.!?] +[A-Z]", re.sub(r'"(?:\\.|[^"\\])*"', "", told)), f"more than one sentence: {told}"
    return told


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where the program is called: a good case file, and things that are none."""
    (tmp_path / "small.toml").write_text(written(scene()))
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "loop.toml").symlink_to("loop.toml")
    (tmp_path / "dangling.toml").symlink_to("nowhere.toml")
    (tmp_path / "empty.toml").write_text("")
    (tmp_path / "zeros.toml").write_bytes(bytes(1000))
    (tmp_path / "huge.toml").write_bytes(b"#" * 1_000_000)
    (tmp_path / "deep.toml").write_text("x = " + "[" * 900)
    (tmp_path / "deep-sections.toml").write_text("\n".join(f"[{'.'.join('a' * depth)}]" for depth in range(1, 300)))
    (tmp_path / "wide.toml").write_text("".join(f"key-{number} = 1\n" for number in range(5000)))
    (tmp_path / "utf-16.toml").write_text(written(scene()), encoding="utf-16")
    (tmp_path / "picture.toml").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)))
    (tmp_path / "unclosed.toml").write_text('[crank]\nlength = "4 in\nmass = "1 kg"\n')
    (tmp_path / "table.csv").write_text("time,tip_x\n0,0\n")
    os.mkfifo(tmp_path / "pipe.toml")
    return tmp_path


def mistakes_in_the_file() -> list[str]:
    """What reading the case file says of each mistake, as the program prints it; none if it is read."""
    try:
        load_case("small.toml")
    except CaseError as error:
        return [bearable(line) for line in str(error).splitlines()]
    return []


def refused(call: Call) -> str:
    """The one sentence on the case file: from reading it, or from the program where an engine is what refuses."""
    told = mistakes_in_the_file()
    assert len(told) <= 1, told
    return told[0] if told else sentence(call(*MODES.split()))


# --- mistakes in a case file -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("apart", [10, pytest.param(1, marks=pytest.mark.verify)], ids=["some", "all"])
@pytest.mark.parametrize("path", mistakes.paths())
def test_every_mistake_in_a_quantity_is_told_with_its_place(call: Call, tmp_path: Path, path: str, apart: int) -> None:
    """Of all of them, or of one in ten, which are others from one quantity to the next."""
    every = [*mistakes.wrong_quantities(path), *mistakes.wrong_keys(path)]
    assert len(every) > 90
    made = every[mistakes.paths().index(path) % apart :: apart]
    for place, mistake in enumerate(made):
        (tmp_path / "small.toml").write_text(mistake.text, encoding="utf-8")
        asked = place == sum(path.encode()) % len(made)  # the program itself, once for each quantity
        told = sentence(call(*MODES.split())) if asked else refused(call)
        assert told.startswith("small.toml: "), (mistake.what, told)
        assert "; " in told, (mistake.what, f"what is accepted is missing: {told}")
        for word in mistake.words:
            assert word in told, (mistake.what, told)


@pytest.mark.parametrize("files", [41, pytest.param(400, marks=pytest.mark.verify)])
def test_a_good_file_is_accepted_however_it_is_written(call: Call, tmp_path: Path, files: int) -> None:
    chance, good = random.Random(1999), parse_case(written(scene()), "small.toml")
    for count in range(files):
        text = mistakes.rewritten(chance)
        # equal to the last bit: arithmetic is decimal, so the same quantity has the same nearest double
        assert parse_case(text, "small.toml") == good, text
        if count % 40 == 0:
            (tmp_path / "small.toml").write_bytes(chance.choice([b"", b"\xef\xbb\xbf"]) + text.encode())
            assert call(*MODES.split()).code == 0


# --- mistakes on the command line ------------------------------------------------------------------------------------------------

NO_NUMBERS = ("", " ", "x", "1,5", "nan", "inf", "-inf", "1e400", "٣", "１", "½", "1_0", "0x10", "1e", "--1", "1 kg", "1%", "1 2", "9" * 400,
              "1\x00", "\x1b[31m1", "\udcff", "$(ls)", "%s%n", "1;2")  # fmt: skip
NUMBERS = {
    "--duration": (SIMULATE, ("0", "-1", "1e9", "1e-9", "0.0005", "1 ns", "0 s", "1s", "1 h", "1 m", "s")),
    "--output-step": (SIMULATE, ("0", "-1", "1e-12", "3", "7 ms", "1e-60 s", "1 Hz")),
    "--accuracy": (SIMULATE, ("0", "1", "-1e-3", "0.06", "1e-5", "0.0501", "9.9e-5")),
    "--crank-angle": (MODES, ("1e7", "north", "90 deg", "pi", "0:360", "0:360:0", "0:360:-10", "0:1:2:3", "0:360:1e-9", "0::10")),
    "--count": (MODES, ("0", "-1", "2.5", "101", "1e1", "1000000000")),
    "--runs": ("benchmark small.toml --engine fake", ("0", "-2", "1.5", "1001")),
    "--time-limit": (SIMULATE, ("0", "-1 s", "1 m", "1 kg")),
    "--memory-limit": (SIMULATE, ("0", "-1", "1e9", "4 GiB")),
    "--magnify": ("animate small.toml --engine fake --output out.webp", ("0", "-1", "1e9")),
    "--jobs": ("run small.toml --engine fake", ("0", "-2", "1.5", "1000000000000")),
    "--set": (MODES, ("crank", "=", "=1 in", "engine", "crank.length", "crank.length=", "length=4 in", "crank.length==4 in", "x=1", "name=x",
                      "crank.lenght=4 in", "crank.length=4", "crank.length=4,5 in", "crank.length=4 in;5 in", "engine.stp=1", "engine.=1",
                      "engine.step=", "engine.step=0", "engine.step=1e9", "engine.step=nan", "engine.step=1_0", "engine.step=٣",
                      "engine.step=0.1 s", "engine.behaviour=bad", "follower.strain_gauges=1 in", 'mechanism.gravity=["0 m/s^2"]',
                      'mechanism.gravity=["0 m/s^2", "1 m/s^2"', "crank.prescribed_speed=16 Hz", "simulation.duration=1",
                      "follower.length=10 in", "crank.length=18 in", "follower.thickness=0 in", "crank.mass=-1 kg")),
}  # fmt: skip


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("option", NUMBERS)
def test_every_wrong_number_of_an_option_is_told_with_the_option(call: Call, tmp_path: Path, option: str) -> None:
    command, more = NUMBERS[option]
    for given in (*NO_NUMBERS, *more):
        told = sentence(call(*command.split(), option, given))
        assert option in told, told
        assert not given.isalnum() or given[:20] in told or f"{float(given):g}" in told, told
    assert not (tmp_path / "out.csv").exists()


NO_CASES = ("", " ", "-", ".", "/", "thesis-25", "thesis", "24", "missing.toml", "no/such.toml", "small.toml/", "small.toml/x.toml", "~/small.toml",
            "folder.toml", "loop.toml", "dangling.toml", "empty.toml", "zeros.toml", "huge.toml", "deep.toml", "deep-sections.toml", "wide.toml",
            "utf-16.toml", "picture.toml", "pipe.toml", "/dev/null", "/dev/zero", "/dev/full", "/proc/self/mem", "a\0b.toml", "\udcff.toml",
            "\x1b[31m.toml", "two\nlines.toml", "a" * 300 + ".toml", "a" * 100_000, "../" * 3000 + "x.toml")  # fmt: skip

TAKE_CASES = ("show -", MODES, SIMULATE, "run - --engine fake", "report -", "benchmark - --engine fake", "plot - --output out.png",
              "animate - --engine fake --output out.webp")  # fmt: skip


@pytest.mark.usefixtures("folder")
def test_whatever_is_no_case_is_told_with_its_name(call: Call, tmp_path: Path) -> None:
    for name, command in zip(NO_CASES, itertools.cycle(TAKE_CASES), strict=False):
        subcommand, _, *options = command.split()
        told = sentences(call(subcommand, *options, "--", name))
        assert not re.fullmatch(r"[\w./-]{1,50}", name) or all(name in each for each in told), told
    assert not (tmp_path / "out.csv").exists()


NO_OUTPUTS = ("", " ", ".", "..", "/", "folder.toml", "absent/out.csv", "small.toml", "./small.toml", "small.toml/out.csv", "/proc/out.csv", "/dev/full",
              "loop.toml", "a\0b.csv", "a" * 300, "a" * 100_000)  # fmt: skip


@pytest.mark.parametrize("output", NO_OUTPUTS, ids=lambda output: repr(output)[:30])
def test_an_output_that_cannot_be_is_told(call: Call, folder: Path, output: str) -> None:
    before = (folder / "small.toml").read_text()
    told = sentence(call(*OUTPUT.split(), output, "--set", "engine.step=0.1"))
    assert told.startswith("--output ")
    assert not re.fullmatch(r"[\w./]{1,50}", output) or os.path.normpath(output) in told, told
    assert (folder / "small.toml").read_text() == before


# --- what the answer names -------------------------------------------------------------------------------------------------------

#: What is typed, and what the answer must name: where it is, what was given, what is accepted or nearest.
TYPED = [
    ("show thesis-25", ("thesis-25", "thesis-02", "quickreturn cases")),
    ("show", ("CASE", "quickreturn show --help")),
    ("show small.toml --jason", ("--jason", "--json", "quickreturn show --help")),
    ("show spin-up --for-other-tools", ("[crank]",)),
    ("show small.toml --json --for-other-tools", ("--for-other-tools", "--json")),
    ("show small.toml --units feet", ("--units", "feet", "si, mm, inch")),
    ("simulate small.toml --engine fake --no-estimate --accuracy 0.01", ("--no-estimate", "--accuracy 0.01")),
    ("cases --tag thesys", ("thesys", "thesis")),
    ("modes small.toml --engine mujco --crank-angle 0", ("--engine", "mujco", "perhaps mujoco", "exudyn")),
    (f"{MODES} --set crank.lenght='4 in'", ("--set", "crank.lenght", "4 in", "crank.length")),
    (f"{MODES} --set engine.step=x", ("--set engine.step", '"x"', "0.0001 to 1 s")),
    (f"{MODES} --set engine.step=1 --set engine.step=2", ("--set engine.step", '"1" and "2"')),
    (f"{MODES} --set slider.mass='1 kg'", ("slider.mass", "massless slider only")),
    ("run small.toml ./small.toml --engine fake", ("scene", "a name of its own")),
    ("run small.toml --engine fake --set mujoco.links=16", ("--set mujoco.links", "fake")),
    ("run example --engine reference --engine mujoco --set engine.tolerance=1e-6", ("--set engine.tolerance", "engine mujoco")),
    (f"{SIMULATE} --engine reference", ("--output out.csv", "{engine}")),
    (f"{SIMULATE} --duration '1.5 ms'", ("--duration", "0.0015", "whole multiple")),
    (f"{OUTPUT} absent/out.csv", ("--output absent/out.csv", "no folder")),
    (f"{OUTPUT} small.toml", ("--output small.toml", "the case file itself")),
    (f"{OUTPUT} x.parquet", ("--output x.parquet", ".csv")),
    ("plot small.toml --output x.gif", ("--output x.gif", ".png, .svg, .pdf, .webp")),
    ("plot small.toml --column tip_x --output x.png", ("--column", "--engine")),
    ("plot small.toml --engine fake --column tip_z --output x.png", ("tip_z", "tip_x")),
    ("animate small.toml --engine fake --output x.avi", ("--output x.avi", ".webp, .gif, .mp4, .html")),
    ("animate small.toml --engine fake --magnify 5 --output x.html", ("--magnify", ".html")),
    ("animate small.toml --engine fake --output x.webp", ("shape_01", "the shape of the follower")),
    ("report small.toml --output page.html", ("--output", "page.html", "give a folder")),
    ("show smal.toml", ("smal.toml", "did you mean small.toml?")),
    ("show example.toml", ("example.toml", "the library case example")),
    ("show table.csv", ("table.csv", "not a case file", "compare")),
    ("new small.toml", ("small.toml", "not overwritten", "another name")),
    ("new 'my machine.toml'", ("my machine.toml", "letters from a to z, digits", "my-machine.toml")),
    ("new thesis-24.toml", ("thesis-24.toml", "library", "my-thesis-24.toml")),
    ("new mine.toml --from small.toml --set crank.lenght='4 in'", ("crank.lenght", "crank.length")),
    ("new mine.toml --set engine.step=0.1", ("engine.step", "no meaning here")),
    ("report small.toml --set crank.mass='1 kg'", ("--set", "crank.mass", "case file")),
    ("run spin-up", ("[crank]", "use show or simulate")),
]


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("typed", "words"), TYPED, ids=lambda text: text[:60])
def test_answer_to_a_mistake_on_the_command_line(call: Call, typed: str, words: tuple[str, ...]) -> None:
    told = sentence(call(*shlex.split(typed)))
    for word in words:
        assert word in told
