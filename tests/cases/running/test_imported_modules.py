"""What a module imports: at its head, inside functions, by a name in quotes, through others; not for the type checker alone."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from quickreturn.cases.running.key import imported_modules, modules_in, names_imported, source_of
from tests.package_copy import ROOT

SOURCE = '''"""A docstring.

from the model import nothing.
"""
from typing import TYPE_CHECKING, Final
import quickreturn.a, quickreturn.b as b  # why
from quickreturn.c import (
    d,  # with (brackets
    e as f,
)

if TYPE_CHECKING:
    from quickreturn.types_alone import T

    from quickreturn.more_types import U
FIND: Final = "quickreturn.quoted.one:function"

def function() -> None:
    from quickreturn.inside import g
    print(g, "the text quickreturn.not_a_name is longer")
'''


def test_imports_are_read_from_a_source() -> None:
    at_the_head = {"quickreturn.a", "quickreturn.b", "quickreturn.c", "quickreturn.c.d", "quickreturn.c.e"}
    found = {name for name in names_imported(SOURCE) if name.startswith("quickreturn")}
    assert found == at_the_head | {"quickreturn.quoted.one", "quickreturn.inside", "quickreturn.inside.g"}


def test_a_relative_import_is_refused() -> None:
    with pytest.raises(ValueError, match=r"relative import: from \.near import a"):
        list(names_imported("from .near import a, b\n"))


@pytest.fixture
def find(tmp_path: Path) -> Callable[[str], Path | None]:
    """Finds the modules of a made-up package."""
    texts = {
        "one.py": "from quickreturn.inner.two import value\n",
        "inner/__init__.py": "import quickreturn.three\n",
        "inner/two.py": "def f():\n    from quickreturn.one import g\n",
        "three.py": "",
        "apart.py": "from quickreturn import one\n",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)

    def found(module: str) -> Path | None:
        place = tmp_path.joinpath(*module.split(".")[1:])
        return next((file for file in (place / "__init__.py", place.with_suffix(".py")) if file.is_file()), None)

    return found


def test_modules_are_followed_through_others_and_in_circles(find: Callable[[str], Path | None]) -> None:
    all_of_one = ["quickreturn.inner", "quickreturn.inner.two", "quickreturn.one", "quickreturn.three"]
    assert list(imported_modules(["quickreturn.one"], find=find)) == all_of_one
    assert list(imported_modules(["quickreturn.inner.two"], find=find)) == all_of_one
    assert list(imported_modules(["quickreturn.apart", "quickreturn.missing"], find=find)) == ["quickreturn.apart", *all_of_one]
    assert imported_modules(["quickreturn.missing"], find=find) == {}


def test_modules_of_each_part_of_the_package_have_their_files() -> None:
    shapes = source_of("quickreturn.reference_model.shapes")
    assert shapes.samefile(ROOT / "reference_model/shapes.py")
    for part in ("reference_model", "engines", "cases", "reports", "derive"):
        for module, file in modules_in(f"quickreturn.{part}").items():
            assert source_of(module) == file
    assert (source_of("numpy"), source_of("quickreturn.missing"), modules_in("quickreturn.missing")) == (None, None, {})
    assert set(modules_in("quickreturn.record")) == {"quickreturn.record"}


@pytest.mark.parametrize("module", ["quickreturn.engines.accurate", pytest.param("quickreturn.reports.report", marks=pytest.mark.verify)])
def test_python_imports_no_module_that_is_not_found(module: str) -> None:
    """What Python has imported after an import is among what is found."""
    asked = f"import json, sys, {module}; print(json.dumps(sorted(name for name in sys.modules if name.startswith('quickreturn.'))))"
    told = subprocess.run([sys.executable, "-P", "-c", asked], capture_output=True, text=True, check=True).stdout
    assert set(json.loads(told)) <= set(imported_modules([module]))
