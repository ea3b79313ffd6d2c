"""The notebooks of docs: every cell runs, what is kept is what comes out, and their text is true of it."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from tests.notebooks import code_cells, fresh_outputs, source_of

DOCS = Path(__file__).resolve().parents[1] / "docs"
NOTEBOOKS = {path.name: json.loads(path.read_text("utf-8")) for path in sorted(DOCS.glob("*.ipynb"))}

LARGEST = 100_000  # bytes: text only


def texts_of(outputs: list[dict[str, Any]]) -> list[str]:
    return ["".join(text) for output in outputs for text in (output.get("text"), *output.get("data", {}).values()) if text]


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_every_cell_runs_and_puts_out_what_is_kept(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    document = NOTEBOOKS[name]
    for number, (cell, fresh) in enumerate(zip(code_cells(document), fresh_outputs(document), strict=True), 1):
        assert texts_of(cell["outputs"]) == texts_of(fresh), f"cell {number}; python -m tests.notebooks docs/{name} renews it"
        assert cell["execution_count"] == number


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_numbers_of_an_answer_stand_in_the_output_above_it(name: str) -> None:
    above, answers = "", 0
    for cell in NOTEBOOKS[name]["cells"]:
        if cell["cell_type"] == "code":
            above = "".join(texts_of(cell["outputs"]))
            continue
        for answer in re.findall(r"\*\*Answer:\*\*[^#]*", source_of(cell)):
            answers += 1
            for number in re.findall(r"\d+\.\d+", answer):
                assert re.search(rf"(?<![\d.]){re.escape(number)}", above), number
    assert answers == 5, "steps 2 to 6"


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_is_small_well_formed_and_its_links_lead_somewhere(name: str) -> None:
    document = NOTEBOOKS[name]
    assert (DOCS / name).stat().st_size < LARGEST
    assert (document["nbformat"], document["metadata"]["kernelspec"]["name"]) == (4, "python3")
    assert len({cell["id"] for cell in document["cells"]}) == len(document["cells"])
    for cell in document["cells"]:
        if cell["cell_type"] == "code":
            assert max(map(len, source_of(cell).splitlines())) <= 100
        for target in re.findall(r"\]\(([^)\s]+)\)", source_of(cell)) if cell["cell_type"] == "markdown" else []:
            assert (DOCS / target.partition("#")[0]).exists(), target
