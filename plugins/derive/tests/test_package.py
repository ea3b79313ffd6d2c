"""The kit stands alone: it imports nothing of the rest, and without CasADi it says what to install."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[1]
REST = {"reference_model", "engines", "cases", "reports"}


@pytest.mark.parametrize("file", sorted(set(FOLDER.glob("*.py")) - {FOLDER / "plugin.py"}), ids=lambda file: file.name)
def test_it_imports_nothing_of_the_rest(file: Path) -> None:
    found = [node for node in ast.walk(ast.parse(file.read_text("utf-8"))) if isinstance(node, ast.Import | ast.ImportFrom)]
    names = [alias.name for node in found if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module or "" for node in found if isinstance(node, ast.ImportFrom)]
    assert not {name.partition(".")[0] for name in names} & REST
    assert all(name.startswith("quickreturn.plugins.derive") for name in names if name.startswith("quickreturn"))


def test_without_casadi_it_says_what_to_install() -> None:
    hide = "import sys; sys.modules['casadi'] = None; import quickreturn.derive"
    done = subprocess.run([sys.executable, "-c", hide], capture_output=True, text=True, check=False)
    assert done.stderr.splitlines()[-1] == "ImportError: quickreturn.derive needs CasADi and sympy: pip install 'quickreturn[derive]'"
