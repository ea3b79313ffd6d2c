"""Which parts of the product import which, how large they are, and what is left without a plugin."""

import ast
import os
import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from functools import cache
from graphlib import TopologicalSorter
from importlib.util import find_spec
from pathlib import Path

import pytest

import quickreturn
from quickreturn.cases.running.key import modules_in

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

#: What one must know to change anything else: nothing in it imports anything outside it at the head of a file (docs/developing.md).
KERNEL = """
reference_model: arrays columns drive errors follower interpolation mechanism natural_modes quantities rigid scene_values
    shapes slider spring table tip
reference_model.native: cache_folder
engines: accurate base error_parts ladder one_run plugins progress refusals registry settings start
    trajectory
cases.files: case document errors keys number_rows reading shown table text_file units written
cases.motion: cycle drifting_fit extremes first_mode moving_mode number time_scale
cases.running: display job key store workshop
"""
#: Lines of the kernel at most, everything counted.
LARGEST_KERNEL = 9_090
#: Room -> lines of code at most: blank lines, comments, docstrings and imports do not count, nor do tests.
BUDGETS = {
    "reference_model": 6_025,
    "engines": 4_400,
    "cases": 5_930,
    "reports": 2_200,
    "quickreturn": 1_855,
    "pack": 90,
    "plugins/as_built": 305,
    "plugins/conform": 940,
    "plugins/derive": 1_850,
    "plugins/fmu": 390,
    "plugins/linear": 330,
    "plugins/methods": 1_880,
    "plugins/pack": 430,
    "plugins/strength": 1_165,
    "plugins/studies": 2_035,
    "plugins/thesis": 1_235,
}


@cache
def imported(file: Path) -> set[str]:
    """Modules that a file imports, anywhere in it: of `from a import b` the module b of the package a, where there is one, otherwise a."""
    return imported_by(ast.parse(file.read_text("utf-8")))


def imported_by(tree: ast.Module) -> set[str]:
    """What the statements of a tree import."""
    found: set[str] = set()
    for node in ast.walk(tree):
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
    names = {file.stem for file in (PACKAGE / "commands").glob("*.py") if "@options.command" in file.read_text("utf-8")}
    assert len(names) > 2
    for name in names:
        found = {each.split(".")[2] for each in imported(PACKAGE / "commands" / f"{name}.py") if each.startswith(f"{TOP}.commands.")}
        assert found & names == set(), name


def test_one_folder_of_the_core_draws() -> None:
    drawing = [file for file in FILES if any(name.split(".")[0] == "matplotlib" for name in imported(file))]
    assert {file.parent.relative_to(PACKAGE).as_posix() for file in drawing} == {
        "reports/drawing",
        "plugins/linear",
        "plugins/studies/resonance_curve",
    }


def test_the_tests_see_what_a_user_sees() -> None:
    """The folders at the top of the checkout are no packages: a name that only works there would fail at the user's."""
    assert [name for name in FLOORS if find_spec(name) is not None] == []
    assert str(ROOT) not in sys.path


def test_the_kernel_imports_nothing_outside_it() -> None:
    folders = dict(line.split(": ") for line in KERNEL.replace("\n    ", " ").strip().splitlines())
    kernel = {f"{TOP}.{folder}.{name}" for folder, names in folders.items() for name in names.split()}
    packages = {f"{TOP}.{folder}" for folder in (*folders, *FLOORS)}
    for module in kernel:
        statements = ast.parse(MODULES[module].read_text("utf-8")).body
        head = ast.Module([each for each in statements if isinstance(each, ast.Import | ast.ImportFrom)], [])
        outside = {name for name in imported_by(head) if name in MODULES} - kernel - packages
        assert outside == set(), module
    assert sum(len(MODULES[module].read_text("utf-8").splitlines()) for module in kernel) <= LARGEST_KERNEL


def test_every_room_keeps_its_budget() -> None:
    lines = Counter[str]()
    for module, file in MODULES.items():
        first, _, rest = module.removeprefix(f"{TOP}.").partition(".")
        room = f"plugins/{rest.split('.')[0]}" if first == "plugins" else first
        lines[room if room in BUDGETS else TOP] += lines_of_code(file.read_text("utf-8"))
    beyond = {room: count for room, count in lines.items() if count > BUDGETS[room]}
    assert beyond == {}


def lines_of_code(text: str) -> int:
    """Lines that hold code, without blank lines, comments, docstrings and imports."""
    lines = {number for number, line in enumerate(text.splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")}
    for node in ast.walk(ast.parse(text)):
        left_out: ast.stmt | None = node if isinstance(node, ast.Import | ast.ImportFrom) else None
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module) and ast.get_docstring(node) is not None:
            left_out = node.body[0]
        if left_out is not None:
            lines -= set(range(left_out.lineno, (left_out.end_lineno or left_out.lineno) + 1))
    return len(lines)


@pytest.mark.verify  # a copy of the package, in which a report is written
@pytest.mark.parametrize("name", PLUGINS)
def test_without_a_plugin_the_rest_works(name: str, tmp_path: Path) -> None:
    """Its folder and its line in `pyproject.toml` deleted: help, a trajectory, a run, a report, and the tests that need no plugin."""
    copy = tmp_path / "copy"
    shutil.copytree(ROOT, copy, symlinks=True, ignore=shutil.ignore_patterns(".*", "build", "*.egg-info", "__pycache__", "output"))
    shutil.rmtree(copy / "plugins" / name)
    kept = [line for line in (copy / "pyproject.toml").read_text("utf-8").splitlines() if f"quickreturn.plugins.{name}." not in line]
    (copy / "pyproject.toml").write_text("\n".join(kept), "utf-8")
    information = copy / "quickreturn-1.0.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: quickreturn\nVersion: 1.0.0\n", "utf-8")
    points = tomllib.loads("\n".join(kept))["project"]["entry-points"]["quickreturn.plugins"]
    lines = [f"{key} = {value}" for key, value in points.items() if name not in NEEDED.get(key, ())]
    (information / "entry_points.txt").write_text("\n".join(["[quickreturn.plugins]", *lines]), "utf-8")
    without = {**os.environ, "PYTHONPATH": str(copy), "QUICKRETURN_STORE": str(tmp_path / "store")}

    def call(*arguments: str) -> None:
        done = subprocess.run([sys.executable, *arguments], cwd=copy, env=without, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{arguments}: {done.stdout[-2000:]}{done.stderr[-2000:]}"

    call("-m", "quickreturn", "--help")
    call("-m", "quickreturn", "simulate", "thesis-24", "--engine", "reference", "--output", "run.csv")
    call("-m", "quickreturn", "run", "thesis-17", "--engine", "reference")
    call("-m", "quickreturn", "report", "example", "--engine", "reference", "--output", "page")
    tests = [file for file in (copy / "tests/cases/motion").glob("test_*.py") if "quickreturn.plugins" not in file.read_text("utf-8")]
    call("-m", "pytest", "-q", "-p", "no:cacheprovider", *map(str, tests))
