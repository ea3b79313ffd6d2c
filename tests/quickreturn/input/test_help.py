"""What `--help` says: whole sentences within 80 columns, nothing cut off."""

import re
import subprocess
import sys

import pytest

from quickreturn.command_line import commands
from tests.quickreturn.conftest import Call

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
