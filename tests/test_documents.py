"""README and docs: every command and example is run, what they show is what comes out, and every link leads somewhere.

A block's first word says how it is read, the second which file it becomes, or who runs it:

    sh                commands; `sh verify`, and likewise with the next two: by `make verify`; `sh long`: what would take hours is only
                      asked for its `--help`, by `make verify`, too
    python            runs in the document's folder, after the blocks before it
    console           `$ command` and what it prints; "..." stands for anything. Below a command that is refused stands its message,
                      below one that ends otherwise but well `# exit code N`
    text printed      what the block before it prints
    toml my-case.toml a file of this name, there from the beginning
"""

import functools
import itertools
import os
import re
import shlex
import subprocess
import sys
import textwrap
import tomllib
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import quickreturn
from quickreturn.cases.files.keys import SECTIONS
from quickreturn.cases.motion.endings import Ending
from quickreturn.command_line import COMMANDS, main
from quickreturn.commands.console import ExitCode
from tests.quickreturn.conftest import warm_workers
from tests.quickreturn.program import TESTS_ALONE

__all__ = ["warm_workers"]

ROOT = Path(__file__).resolve().parents[1]
BIN = Path(sys.executable).parent
DOCUMENTS = {
    path.relative_to(ROOT).as_posix(): path.read_text("utf-8") for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
}

LONGEST_README = 900  # words, code and tables included
MOST_NUMBERS = 25  # in the README's text and tables; not in code, names, links and the versions that it was tested on
LONGEST_LINE_OF_CODE = 100
LARGEST_ANIMATION = 500_000  # bytes
#: A block between fences, which may be indented as a part of a list.
FENCED = re.compile(r"^(?P<by> *)```(?P<kind>[a-z]*)[ ]?(?P<about>\S*)\n(?P<text>.*?)^(?P=by)```$", re.MULTILINE | re.DOTALL)
RUN = ("sh", "python", "console")


class Block(NamedTuple):
    """A fenced block: the document, its line there, the words after the fence, and the text."""

    document: str
    line: int
    kind: str
    about: str
    text: str

    @property
    def is_file(self) -> bool:
        return "." in self.about


def blocks_of(document: str) -> list[Block]:
    text = DOCUMENTS[document]
    return [
        Block(document, text.count("\n", 0, found.start()) + 1, found["kind"], found["about"], _dedented(found))
        for found in FENCED.finditer(text)
    ]


def _dedented(found: "re.Match[str]") -> str:
    """The text, of commands with those that go on over several lines on one."""
    text = textwrap.dedent(found["text"])
    return re.sub(r"\\\n\s*", "", text) if found["kind"] == "sh" else text


BLOCKS = [block for document in DOCUMENTS for block in blocks_of(document)]


def commands() -> list[str]:
    """Of all blocks, without comments."""
    lines = [line.split("   #")[0].strip() for block in BLOCKS if block.kind == "sh" for line in block.text.splitlines()]
    shown = [line[2:] for block in BLOCKS if block.kind == "console" for line in block.text.splitlines() if line.startswith("$ ")]
    return [line for line in (*lines, *shown) if line and not line.startswith("#")]


def prose(document: str) -> str:
    return FENCED.sub("", DOCUMENTS[document])


# What is run


@functools.cache
def folder_of(document: str, base: Path) -> Path:
    """Like the project's root, as far as commands look at it, with the document's files and a store of its own."""
    folder = base / document.replace("/", "-").removesuffix(".md")
    folder.mkdir()
    (folder / "docs/pictures").mkdir(parents=True)
    for part in ("cases", "plugins", "examples"):
        (folder / part).symlink_to(ROOT / part)
    for block in blocks_of(document):
        if block.is_file:
            (folder / block.about).write_text(block.text, "utf-8")
    return folder


NAMES: dict[str, dict[str, Any]] = {}
#: Blocks of Python that have been run: a block for make verify needs those before it, which make test runs.
DONE: set[Block] = set()
PRINTED: dict[str, str] = {}


def _marks(block: Block, *shown: Block) -> Any:
    """A block that is run, and what is shown of it, named by the place of the last."""
    place = (block, *shown)[-1]
    marks = [pytest.mark.verify] if block.about in ("verify", "long") else []
    return pytest.param(block, *shown, id=f"{place.document}:{place.line}", marks=marks)


@pytest.mark.parametrize("block", [_marks(block) for block in BLOCKS if block.kind in RUN and not block.is_file])
def test_blocks_run(
    block: Block, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = folder_of(block.document, tmp_path_factory.getbasetemp())
    monkeypatch.chdir(folder)
    monkeypatch.setenv("QUICKRETURN_STORE", str(folder / "store"))
    monkeypatch.setenv("PATH", f"{BIN}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(TESTS_ALONE))
    if block.kind == "python" or block.about == "verify":
        before = [each for each in blocks_of(block.document) if each.kind == "python" and not each.about and each.line < block.line]
        for each in (*(each for each in before if each not in DONE), *[block] * (block.kind == "python")):
            exec(compile(each.text, f"{each.document}:{each.line}", "exec"), NAMES.setdefault(each.document, {}))
            DONE.add(each)
    if block.kind == "sh":
        for line in block.text.splitlines():
            command = line.split("   #")[0].strip()
            if command and not command.startswith(("#", "make ", ". ")):
                assert called(f"{command} --help" if block.about == "long" else command) == ExitCode.GOOD, command
    elif block.kind != "python":
        for command, shown in exchanges(block.text):
            capfd.readouterr()
            assert called(command) == code_of(shown), command
            printed = "".join(capfd.readouterr())
            for line in shown:
                assert line.startswith("# exit code ") or appears(line, printed), printed
    PRINTED[block.document] = capfd.readouterr().out


@pytest.mark.parametrize(("before", "block"), [_marks(*pair) for pair in itertools.pairwise(BLOCKS) if pair[1].about == "printed"])
def test_what_is_shown_is_printed(
    before: Block,
    block: Block,
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    test_blocks_run(before, tmp_path_factory, monkeypatch, capfd)
    for line in block.text.splitlines():
        assert appears(line, PRINTED[block.document]), PRINTED[block.document]


def called(command: str) -> int:
    """The exit code. The program itself runs in this process, which spares its start."""
    words = shlex.split(command)
    if words[0] == "quickreturn" and not {">", "|", "&&"} & set(words):
        return main(["--quiet", *words[1:]])
    return subprocess.run(["bash", "-c", command], check=False, timeout=500).returncode


def exchanges(text: str) -> Iterator[tuple[str, list[str]]]:
    """Commands and the lines shown below each."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, *shown = part.splitlines()
        yield command, [line for line in shown if line.strip()]


def code_of(shown: list[str]) -> int:
    """The exit code that the lines below a command tell of."""
    told = [int(line.removeprefix("# exit code ")) for line in shown if line.startswith("# exit code ")]
    refused = any(line.startswith("quickreturn: ") for line in shown)
    return told[0] if told else ExitCode.BAD_INPUT if refused else ExitCode.GOOD


def appears(line: str, printed: str) -> bool:
    """Whether a line is printed as shown, but for white space at its end and what "..." stands for."""
    pattern = ".*".join(map(re.escape, line.rstrip().split("...")))
    return re.search(rf"^{pattern}\s*$", printed, flags=re.MULTILINE) is not None


# What stands there


def test_the_list_of_endings_is_theirs() -> None:
    rows = re.findall(r"^\| ([a-z ]+) \| ([^|]+) \| (\d) \|$", DOCUMENTS["docs/report.md"], re.MULTILINE)
    codes = {ending: ExitCode.GOOD if ending.delivered else ExitCode.ENGINE_TROUBLE for ending in Ending} | {
        Ending.REFUSED: ExitCode.BAD_INPUT
    }
    assert rows == [(ending.value, ending.sentence, str(codes[ending].value)) for ending in Ending]


def test_the_list_of_exit_codes_is_theirs() -> None:
    _, _, chapter = DOCUMENTS["docs/report.md"].partition("## Exit codes")
    assert re.findall(r"^\| (\d+) \|", chapter, re.MULTILINE) == [str(code.value) for code in ExitCode]


def test_every_command_is_shown() -> None:
    shown = " ".join(commands())
    assert [name for name in COMMANDS if f"quickreturn {name}" not in shown] == []


@pytest.mark.parametrize("target", sorted({line.split()[1] for line in commands() if line.startswith("make ")}))
def test_make_targets_exist(target: str) -> None:
    """Running them here would run this test again; that they are rules of the Makefile is what can be held."""
    found = subprocess.run(["make", "--dry-run", target], cwd=ROOT, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr


def headings(path: Path) -> set[str]:
    """Anchors as GitHub makes them of headings."""
    text = FENCED.sub("", path.read_text("utf-8"))
    names = [re.sub(r"[`*$]", "", name).strip().lower() for name in re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)]
    return {"".join(sign for sign in name if sign in " -_" or unicodedata.category(sign)[0] in "LN").replace(" ", "-") for name in names}


@pytest.mark.parametrize("document", DOCUMENTS)
def test_links_lead_somewhere(document: str) -> None:
    lost = []
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(document)):
        if target.startswith(("http://", "https://")):
            continue
        name, _, anchor = target.partition("#")
        path = ((ROOT / document).parent / name).resolve() if name else ROOT / document
        if not path.exists() or (anchor and anchor not in headings(path)):
            lost.append(target)
    assert lost == []


@pytest.mark.parametrize("document", DOCUMENTS)
def test_files_that_are_named_exist(document: str) -> None:
    """A path within the project, in `typewriter`; NAME stands for that of a file to be written."""
    named = re.findall(r"`([\w./-]+/[\w.-]+\.(?:py|md|csv|toml|html|txt)|[\w./-]+/)`", prose(document))
    ours = [path for path in named if path.startswith(tuple(each.name for each in ROOT.iterdir())) and "NAME" not in path]
    assert [path for path in ours if not (ROOT / path).exists()] == []


def test_the_readme_is_short_and_its_pictures_are_light() -> None:
    assert len(DOCUMENTS["README.md"].split()) <= LONGEST_README
    text = re.sub(r"`[^`]*`|\]\([^)]*\)|\brun \d+", "", prose("README.md").partition("## Tested on")[0])
    assert len(re.findall(r"\b\d[\d.]*", text)) <= MOST_NUMBERS
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", DOCUMENTS["README.md"])
    assert pictures
    assert all(1000 < (ROOT / picture).stat().st_size <= LARGEST_ANIMATION for picture in pictures)


@pytest.mark.parametrize("document", sorted(DOCUMENTS))
def test_examples_have_short_lines(document: str) -> None:
    """They are read, in a narrow column and beside other text."""
    code = [block for block in blocks_of(document) if block.kind in ("python", "toml")]
    assert [line for block in code for line in block.text.splitlines() if len(line) > LONGEST_LINE_OF_CODE] == []


@pytest.mark.parametrize("file", sorted((ROOT / "examples").rglob("*.py")), ids=lambda file: file.name)
def test_examples_that_are_packages_have_short_lines(file: Path) -> None:
    assert [line for line in file.read_text("utf-8").splitlines() if len(line) > LONGEST_LINE_OF_CODE] == []


def test_the_version_is_told_everywhere_alike(capfd: pytest.CaptureFixture[str]) -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    released = re.search(r"^## (\S+) \((\S+)\)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert released
    assert released[1] == version
    assert f"\nversion: {version}\ndate-released: {released[2]}\n" in (ROOT / "CITATION.cff").read_text("utf-8")
    assert quickreturn.__version__ == version
    assert called("quickreturn --version") == ExitCode.GOOD
    assert version in capfd.readouterr().out


def test_metadata_and_citation_name_the_same_authors_and_keywords() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    cited = (ROOT / "CITATION.cff").read_text("utf-8").partition("references:")[0]
    assert re.findall(r"^  - name: (.*)$", cited, re.MULTILINE) == [author["name"] for author in project["authors"]]
    assert re.findall(r"^  - (.*)$", cited.partition("keywords:")[2], re.MULTILINE) == project["keywords"]


def test_the_keys_of_a_case_file_are_those_declared() -> None:
    """The table of sections: every key that the dataclasses declare, by unit."""
    rows = re.findall(r"^\| `\[(\w+)\]` \| (.*) \|$", DOCUMENTS["docs/case-file.md"], re.MULTILINE)
    assert [section for section, _ in rows] == list(SECTIONS)
    for section, row in rows:
        found = {key: unit for keys, unit in (each.rsplit(" ", 1) for each in row.split("; ")) for key in re.findall(r"`(\w+)`", keys)}
        assert found == {key: declared.unit if declared.unit != "1" else "-" for key, declared in SECTIONS[section].items()}
