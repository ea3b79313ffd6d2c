# ruff: noqa: E501  (a row of the tables is one answer, on one line)
"""Thousands of mistakes, each answered by the program with one clear sentence, exit code 2, and nothing else.

The engine is the fake one of these tests, so that what is accepted costs nothing. The table shows what a person gets to read.
"""

import os
import random
import re
import shlex
from importlib import import_module
from pathlib import Path

import click
import pytest

from cases.reading import parse_case
from quickreturn.command_line import COMMANDS
from quickreturn.commands.options import SingleOption
from tests.quickreturn import mistakes
from tests.quickreturn.conftest import Answer, Call
from tests.quickreturn.mistakes import scene, with_value, written
from tests.quickreturn.program import started

LONGEST = 400  # characters: five lines of a terminal
MODES = "modes small.toml --engine fake --crank-angle 90"
OUTPUT = "simulate small.toml --engine fake --output"
SIMULATE = f"{OUTPUT} out.csv"


def sentence(answer: Answer) -> str:
    """What a refusal says; it must be one bearable sentence on standard error, with exit code 2 and nothing on standard output."""
    assert (answer.code, answer.output) == (2, ""), answer
    assert re.fullmatch(r"quickreturn: [^\n]+\n", answer.errors), answer.errors
    told = answer.errors.removeprefix("quickreturn: ").removesuffix("\n")
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
    (tmp_path / "twice.toml").write_text('[crank]\nlength = "4 in"\nlength = "5 in"\n')
    os.mkfifo(tmp_path / "pipe.toml")
    return tmp_path


# --- mistakes in a case file -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", mistakes.paths())
def test_every_mistake_in_a_quantity_is_told_with_its_place(call: Call, tmp_path: Path, path: str) -> None:
    made = [*mistakes.wrong_quantities(path), *mistakes.wrong_keys(path)]
    assert len(made) > 90
    for mistake in made:
        (tmp_path / "small.toml").write_text(mistake.text, encoding="utf-8")
        told = sentence(call(*MODES.split()))
        assert told.startswith("small.toml: "), (mistake.what, told)
        assert "; " in told, (mistake.what, f"what is accepted is missing: {told}")
        for word in mistake.words:
            assert word in told, (mistake.what, told)


def test_a_damaged_file_is_read_or_refused(call: Call, tmp_path: Path) -> None:
    chance, accepted = random.Random(1999), 0
    for _ in range(300):
        (tmp_path / "small.toml").write_bytes(mistakes.damaged(written(scene()), chance))
        answer = call(*MODES.split())
        if answer.code == 0:
            accepted += 1
            assert answer.errors == ""
        else:
            assert sentence(answer).startswith("small.toml: ")
    assert 0 < accepted < 100  # some accidents happen in a comment's place or to an optional key


def test_a_good_file_is_accepted_however_it_is_written(call: Call, tmp_path: Path) -> None:
    chance, good = random.Random(1999), parse_case(written(scene()), "small.toml")
    for count in range(200):
        text = mistakes.rewritten(chance)
        # equal to the last bit: arithmetic is decimal, so the same quantity has the same nearest double
        assert parse_case(text, "small.toml") == good, text
        if count % 40 == 0:
            (tmp_path / "small.toml").write_bytes(chance.choice([b"", b"\xef\xbb\xbf"]) + text.encode())
            assert call(*MODES.split()).code == 0


def test_a_good_file_with_other_values_is_accepted() -> None:
    chance = random.Random(1999)
    for _ in range(200):
        parse_case(mistakes.varied(chance), "small.toml")


# --- mistakes on the command line ------------------------------------------------------------------------------------------------

NO_NUMBERS = ("", " ", "x", "1,5", "nan", "inf", "-inf", "1e400", "٣", "１", "½", "1_0", "0x10", "1e", "--1", "1 kg", "1%", "1 2", "9" * 400,
              "1\x00", "\x1b[31m1", "\udcff", "$(ls)", "%s%n", "1;2")  # fmt: skip
NUMBERS = {
    "--duration": (SIMULATE, ("0", "-1", "1e9", "1e-9", "0.0005", "1 ns", "0 s", "1s", "1 h", "1 m", "s")),
    "--output-step": (SIMULATE, ("0", "-1", "1e-12", "3", "7 ms", "1e-60 s", "1 Hz")),
    "--accuracy": (SIMULATE, ("0", "1", "-1e-3", "0.06", "1e-5", "0.0501", "9.9e-5")),
    "--crank-angle": (MODES, ("1e7", "north", "90 deg", "pi", "0:360", "0:360:0", "0:360:-10", "0:1:2:3", "0:360:1e-9", "0::10")),
    "--count": (MODES, ("0", "-1", "2.5", "101", "1e1", "1000000000")),
    "--repetitions": ("benchmark small.toml --engine fake", ("0", "-2", "1.5", "101")),
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
        assert not given.isalnum() or given[:20] in told, told
    assert not (tmp_path / "out.csv").exists()


NO_CASES = ("", " ", "-", ".", "/", "thesis-25", "thesis", "24", "missing.toml", "no/such.toml", "small.toml/", "small.toml/x.toml", "~/small.toml",
            "folder.toml", "loop.toml", "dangling.toml", "empty.toml", "zeros.toml", "huge.toml", "deep.toml", "deep-sections.toml", "wide.toml",
            "utf-16.toml", "picture.toml", "pipe.toml", "/dev/null", "/dev/zero", "/dev/full", "/proc/self/mem", "a\0b.toml", "\udcff.toml",
            "\x1b[31m.toml", "two\nlines.toml", "a" * 300 + ".toml", "a" * 100_000, "../" * 3000 + "x.toml")  # fmt: skip


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    "command",
    [
        "show -",
        MODES,
        SIMULATE,
        "run - --engine fake",
        "report -",
        "benchmark - --engine fake",
        "plot - --output out.png",
        "animate - --engine fake --output out.webp",
    ],
    ids=lambda text: text.split()[0],
)
def test_whatever_is_no_case_is_told_with_its_name(call: Call, tmp_path: Path, command: str) -> None:
    subcommand, _, *options = command.split()
    for name in NO_CASES:
        told = sentence(call(subcommand, *options, "--", name))
        assert not re.fullmatch(r"[\w./-]{1,50}", name) or name in told, told
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


# --- what a person gets to read --------------------------------------------------------------------------------------------------

WRITE_LENGTH = 'write one plain number, one space and a unit, such as "2 in" (or in mm or m)'
WRITE_TORQUE = 'write one plain number, one space and a unit, such as "2 lbf*in" (or in N*m)'
WRITE_LINE = 'write [section] or key = "number unit", such as length = "4 in"'
ENGINES = "thesis, reference, exudyn, mujoco, fixed-shapes, multiplier, stiff-spring, nodal-load, fake"

#: What is written for a key of small.toml, and the answer.
IN_THE_FILE = [
    ("crank.length", '"4,5 in"', f'"4,5 in" has a comma in its number (the decimal sign is a point); {WRITE_LENGTH}'),
    ("crank.length", '"4in"', f'"4in" has no space between number and unit; {WRITE_LENGTH}'),
    ("crank.length", '"4  in"', f'"4  in" has more than one space between number and unit; {WRITE_LENGTH}'),
    ("crank.length", '"4\u00a0in"', rf'"4\xa0in" has white space other than one plain space after its number; {WRITE_LENGTH}'),
    ("crank.length", '"٤ in"', f'"٤ in" has other digits than 0 to 9; {WRITE_LENGTH}'),
    ("crank.length", '"2*2 in"', f'"2*2 in" has arithmetic in its number (give the result); {WRITE_LENGTH}'),
    ("crank.length", '"4 kg"', f'"4 kg" is a mass (kg), but a length is needed; {WRITE_LENGTH}'),
    ("crank.length", '"1e400 m"', '"1e400 m" is out of range; magnitudes from 1e-60 to 1e+60 in SI units and zero are accepted'),
    ("crank.length", "4", '4 is a bare number; write a string with number and unit, such as "2 in"'),
    ("crank.length", '"18 in"', '"18 in" cannot be: the crank (0.4572 m) must be shorter than mechanism.pivot_distance (0.4572 m)'),
    ("crank.torque", '"1 Nm"', f'"1 Nm" is a quantity in m/kg (perhaps meant as "N*m"), but a torque is needed; {WRITE_TORQUE}'),
    ("crank.torque", '"1 lb*in"', f'"1 lb*in" is a quantity in kg*m (perhaps meant as "lbf*in"), but a torque is needed; {WRITE_TORQUE}'),
    ("crank.initial_angle", '"1e9 deg"', '"1e9 deg" is beyond a million degrees; angles from -1e6 deg to 1e6 deg are accepted'),
    ("follower.thickness", '"0 in"', '"0 in" is not positive; a length greater than zero is accepted'),
    ("follower.strain_gauges", '"26 in"', '["6.25 in", "12.5 in", "26 in"] leaves the strain gauge at 0.6604 m outside the follower; its length is 0.635 m'),
    ("simulation.output_step", '"3 s"', '"2 s" gives 0.666667 output steps (duration 2 s, output step 3 s); the duration must be a whole multiple of the output step'),
]  # fmt: skip

#: What is typed, and how the answer begins.
TYPED = [
    ("show thesis-25", '"thesis-25": no case of the library has this name; the nearest one is thesis-02 (`quickreturn cases` lists all); or give a path'),
    ("show missing.toml", "missing.toml: there is no such file; give the path of a case file or the name of a library case"),
    ("show folder.toml", "folder.toml: is no regular file; give the path of a case file"),
    ("show huge.toml", "huge.toml: is larger than 64 kB; give the path of a case file"),
    ("show utf-16.toml", "utf-16.toml: is not in UTF-8 (line 1); save it as plain text in UTF-8"),
    ("show deep.toml", "deep.toml: is nested too deeply; sections with strings and lists of strings are accepted"),
    ("show wide.toml", "wide.toml: key-0: 1 belongs to an unknown key; known are name, title, tags, mechanism, crank, base, follower, tip, slider, simulation"),
    ("show unclosed.toml", 'unclosed.toml: line 2: "length = \\"4 in" is no valid TOML: '),
    ("show twice.toml", 'twice.toml: line 3: "length = \\"5 in\\"" repeats a key or section that is there already; give each of them once'),
    ("show", "Missing argument 'CASE'; see quickreturn show --help"),
    ("show small.toml --jason", "No such option: --jason (perhaps --json is meant); see quickreturn show --help"),
    ("shaw small.toml", '"shaw": no such command (perhaps show is meant); accepted: engines, cases, show, simulate, modes, run, '),
    ("cases --tag thesys", 'tag "thesys": no case has this tag; accepted: '),
    (f"{MODES} --count 0", '--count "0": give a whole number from 1 to 100'),
    (f"{MODES} --set crank.lenght='4 in'", '--set: crank.lenght: "4 in" belongs to an unknown key; the nearest known one is crank.length'),
    (f"{MODES} --set crank.length", '--set "crank.length": give KEY=VALUE, e.g. crank.length="5 in" or engine.elements=32'),
    (f"{MODES} --set engine.step=x", '--set engine.step: "x" is not accepted; give a plain number from 0.0001 to 1 s'),
    (f"{MODES} --set engine.links=8", "--set engine.links: no such setting of this engine; accepted: engine.step, engine.behaviour"),
    ("run small.toml ./small.toml --engine fake", "scene: two cases have this name; give each a name of its own"),
    ("run 'thesis-9*'", '"thesis-9*": no case of the library and no case file matches; such as thesis-2* or my/*.toml'),
    ("run small.toml --engine fake --set mujoco.links=16", "--set mujoco.links: engine mujoco does not run here; those that do are fake"),
    (f"{SIMULATE} --engine reference", "--output out.csv: several engines would write the same file; put {engine} into its name"),
    (f"{OUTPUT} x.parquet", '--output x.parquet: ".parquet" is no known format; accepted: .csv, such as x.csv'),
    ("plot small.toml --output x.gif", '--output x.gif: ".gif" is no known format; accepted: .png, .svg, .pdf, .webp, such as x.png'),
    ("plot small.toml --column tip_x --output x.png", "--column: without --engine nothing is simulated; give --engine as well"),
    ("plot small.toml --engine fake --column tip_z --output x.png", '"tip_z": no such column; the nearest known one is tip_x'),
    ("plot missing.csv --output x.png", "missing.csv: there is no such file"),
    ("animate small.toml --engine fake --output x.gif", '--output x.gif: ".gif" is no known format; accepted: .webp, .html, such as x.webp'),
    ("animate small.toml --engine fake --magnify 5 --output x.html", "--magnify: in a page (.html) it is chosen with a slider; leave it out"),
    ("animate small.toml --engine fake --output x.webp", '"shape_01": this trajectory does not tell the shape of the follower'),
    ("report --output x.parquet",'--output "x.parquet": the ending ".parquet" is that of a file; give a folder, the page in it is index.html'),
    ("run example --engine reference --engine mujoco --set engine.tolerance=1e-6", "--set engine.tolerance: no such setting of this engine; accepted: engine.links, engine.step, engine.armature (engine mujoco)"),
    ("modes small.toml --engine mujco --crank-angle 0", f'--engine "mujco": no such engine (perhaps mujoco is meant); accepted: {ENGINES}'),
    ("modes small.toml --engine fake --crank-angle north", '--crank-angle "north": give a plain number of degrees, from -1000000 to 1000000, e.g. 180'),
    (f"{SIMULATE} --accuracy 1e-9", '--accuracy "1e-9": give a plain number from 0.0001 to 0.05, e.g. 1e-3'),
    (f"{SIMULATE} --duration 1e9", 'command line: --duration: "1e9" gives 1e+12 output steps (duration 1e+09 s, output step 0.001 s); at most 2 million are accepted'),
    (f"{SIMULATE} --duration '1.5 ms'", 'command line: --duration: "1.5 ms" gives 1.5 output steps (duration 0.0015 s, output step 0.001 s); the duration must be'),
    (f"{OUTPUT} absent/out.csv", "--output absent/out.csv: there is no folder "),
    (f"{OUTPUT} small.toml", "--output small.toml: this is the case file itself, which would be lost; give another name"),
    (f"{SIMULATE} --duration 1 --set 'simulation.duration=1 s'", '--duration "1" and --set simulation.duration="1 s" are both given; give one of them'),
    (f"{OUTPUT} x.parquet", '--output x.parquet: ".parquet" is no known format; accepted: .csv, such as x.csv'),
    (f"{OUTPUT} x", "--output x: no ending tells the format; accepted: .csv, such as x.csv"),
    (f"{OUTPUT} x.csv.gz", '--output x.csv.gz: ".gz" is no known format; accepted: .csv'),
    ("report small.toml --output page.html", '--output "page.html": the ending ".html" is that of a file; give a folder, the page in it is index.html'),
    (f"{MODES} --count 2 --count 3", '--count: "2" and "3" are both given; give one of them'),
    (f"{SIMULATE} --output x.csv --output y.csv", '--output: "out.csv" and "x.csv" and "y.csv" are all given; give one of them'),
]  # fmt: skip


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("path", "value", "answer"), IN_THE_FILE, ids=lambda text: text[:40])
def test_answer_to_a_mistake_in_the_file(call: Call, tmp_path: Path, path: str, value: str, answer: str) -> None:
    (tmp_path / "small.toml").write_text(with_value(path, value))
    blamed = path.replace("output_step", "duration")
    assert sentence(call(*MODES.split())) == f"small.toml: {blamed}: {answer}"


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("typed", "answer"), TYPED, ids=lambda text: text[:60])
def test_answer_to_a_mistake_on_the_command_line(call: Call, typed: str, answer: str) -> None:
    assert sentence(call(*shlex.split(typed))).startswith(answer)


@pytest.mark.parametrize("name", COMMANDS)
def test_no_option_of_which_one_value_counts_takes_the_last_of_two(name: str) -> None:
    for option in import_module(f"quickreturn.commands.{name}").command.params:
        if isinstance(option, click.Option) and not option.is_flag and not option.multiple:
            assert isinstance(option, SingleOption), option.name


def answer_of_a_process(folder: Path, command: str) -> Answer:
    program = started(*shlex.split(command), folder=folder)
    output, errors = program.communicate(timeout=60.0)
    return Answer(program.returncode, output, errors)


@pytest.mark.usefixtures("call")  # installs the fake engine
@pytest.mark.parametrize("typed", [TYPED[0][0], TYPED[14][0], TYPED[24][0]])
def test_answers_of_processes(folder: Path, typed: str) -> None:
    assert sentence(answer_of_a_process(folder, typed)).startswith(dict(TYPED)[typed])


@pytest.mark.verify
@pytest.mark.usefixtures("call")
def test_all_answers_of_processes(folder: Path) -> None:
    for typed, answer in TYPED:
        assert sentence(answer_of_a_process(folder, typed)).startswith(answer)
    for path, value, answer in IN_THE_FILE:
        (folder / "small.toml").write_text(with_value(path, value))
        assert sentence(answer_of_a_process(folder, MODES)).endswith(answer)
