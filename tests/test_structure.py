"""Which parts of the product import which."""

import ast
import sys
from functools import cache
from graphlib import TopologicalSorter
from importlib.util import find_spec
from pathlib import Path

import pytest

import quickreturn
from quickreturn.reference_model.imported_modules import modules_in

ROOT = Path(__file__).resolve().parents[1]
#: From bottom to top; what stands in `quickreturn` itself is above them all.
FLOORS = ("reference_model", "engines", "cases", "reports")
TOP = "quickreturn"
PACKAGE = Path(quickreturn.__file__).parent
PLUGINS = sorted(path.parent.name for path in (ROOT / "plugins").glob("*/__init__.py"))
#: Plugin -> other plugins that it imports.
NEEDED = {"pack": {"derive"}, "thesis": {"studies"}}
MODULES = modules_in(TOP)
FILES = list(MODULES.values())


@cache
def imported(file: Path) -> set[str]:
    """Modules that a file imports, anywhere in it: of `from a import b` the module b of the package a, where there is one, otherwise a."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names = (f"{node.module}.{alias.name}" for alias in node.names)
            found |= {name if name in MODULES else str(node.module) for name in names}
    return found


def floor_of(module: str) -> int:
    """Of a module of this project."""
    inner = module.removeprefix(f"{TOP}.").partition(".")[0]
    return FLOORS.index(inner) if inner in FLOORS else len(FLOORS)


@pytest.mark.parametrize("floor", FLOORS)
def test_imports_go_one_way(floor: str) -> None:
    files = list(modules_in(f"{TOP}.{floor}").values())
    assert len(files) > 10
    for file in files:
        above = {name for name in imported(file) if name.split(".")[0] == TOP and floor_of(name) > FLOORS.index(floor)}
        assert above - {TOP} == set(), file


@pytest.mark.parametrize("name", PLUGINS)
def test_a_plugin_is_imported_by_none_but_those_that_name_it(name: str) -> None:
    """And by the public names of `quickreturn`, which are imported on their first use."""
    inner = f"{TOP}.plugins.{name}"
    importing = {module for module, file in MODULES.items() if any(f"{each}.".startswith(f"{inner}.") for each in imported(file))}
    apart = {module.split(".")[2] for module in importing if module.startswith(f"{TOP}.plugins.")}
    assert {module for module in importing if not module.startswith(f"{TOP}.plugins.")} <= {f"{TOP}.{name}"}
    assert apart - {name} <= {other for other, named in NEEDED.items() if name in named}


def test_no_modules_import_each_other() -> None:
    """Neither at their heads nor inside functions, nor for the type checker alone. CycleError names the modules.

    That Python runs a package before its modules makes no circle.
    """
    importing = {module: imported(file) & set(MODULES) for module, file in MODULES.items()}
    TopologicalSorter(importing).prepare()
    assert len(importing) > 300


def test_commands_import_no_commands() -> None:
    names = {file.stem for file in (PACKAGE / "commands").glob("*.py") if "@click.command" in file.read_text("utf-8")}
    assert len(names) > 7
    for name in names:
        found = {each.split(".")[2] for each in imported(PACKAGE / "commands" / f"{name}.py") if each.startswith(f"{TOP}.commands.")}
        assert found & names == set(), name


def test_one_folder_of_the_core_draws() -> None:
    drawing = [file for file in FILES if any(name.split(".")[0] == "matplotlib" for name in imported(file))]
    assert {file.parent.relative_to(PACKAGE).as_posix() for file in drawing} == {
        "reports/drawing",
        "plugins/methods",
        "plugins/studies/drawing",
    }


def test_the_tests_see_what_a_user_sees() -> None:
    """The folders at the top of the checkout are no packages: a name that only works there would fail at the user's."""
    assert [name for name in FLOORS if find_spec(name) is not None] == []
    assert str(ROOT) not in sys.path
