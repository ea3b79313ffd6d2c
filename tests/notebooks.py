"""Runs a notebook without Jupyter and renews its kept output: `python -m tests.notebooks docs/thesis.ipynb`.

What a cell prints, and the value of its last line as text and HTML, are all that is kept. A cell needs nothing else of a kernel, so the
tests need none of Jupyter's packages. Pictures are not kept: their bytes differ from machine to machine.
"""

import ast
import contextlib
import io
import json
import sys
from pathlib import Path
from typing import Any


def fresh_outputs(document: dict[str, Any]) -> list[list[dict[str, Any]]]:
    """What the code cells of a notebook put out now, one after the other; an exception of a cell leaves this function."""
    names: dict[str, Any] = {"__name__": "__main__"}
    return [_outputs(source_of(cell), number, names) for number, cell in enumerate(code_cells(document), 1)]


def code_cells(document: dict[str, Any]) -> list[dict[str, Any]]:
    """The cells that are run."""
    return [cell for cell in document["cells"] if cell["cell_type"] == "code"]


def source_of(cell: dict[str, Any]) -> str:
    """The text of a cell."""
    return "".join(cell["source"])


def _outputs(source: str, number: int, names: dict[str, Any]) -> list[dict[str, Any]]:
    """Runs one cell; its last line is shown if it is an expression and does not end in a semicolon, as Jupyter has it."""
    tree, value = ast.parse(source), None
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(tree, f"cell {number}", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), names)
    outputs: list[dict[str, Any]] = []
    if text := printed.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": text.splitlines(keepends=True)})
    if value is not None and not source.rstrip().endswith(";"):
        data = {"text/plain": repr(value).splitlines(keepends=True)}
        if hasattr(value, "_repr_html_"):
            data["text/html"] = value._repr_html_().splitlines(keepends=True)
        outputs.append({"data": data, "execution_count": number, "metadata": {}, "output_type": "execute_result"})
    return outputs


def main(path: Path) -> None:
    """Writes the fresh output into the notebook."""
    document = json.loads(path.read_text("utf-8"))
    for number, (cell, outputs) in enumerate(zip(code_cells(document), fresh_outputs(document), strict=True), 1):
        cell |= {"outputs": outputs, "execution_count": number}
    path.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", "utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
