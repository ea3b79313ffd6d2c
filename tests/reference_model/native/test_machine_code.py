"""Where compiled code is kept: beside the sources, else in the user's cache, else for as long as the process lives.

And when: code of other sources is never taken, and what is not compiled has no say.
"""

import ctypes
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from quickreturn.cases.running.key import modules_in
from tests.package_copy import ROOT, copied_package

PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH = 24, 1, 2

#: Compiles, calls and keeps a small function; tells where code is kept, and what there is to say.
CODE = """
from quickreturn.reference_model.native.cache_folder import folder
from quickreturn.reference_model.small import double
assert double(4.0) == 8.0
assert any(folder().glob("*.nbi"))
"""
TELLS = """
from quickreturn.reference_model.native import cache_folder
print(cache_folder.folder(), cache_folder.warning_if_not_kept(), sep="|")
"""
DECORATORS = "quickreturn.reference_model.native.compilation"
SMALL = f"from {DECORATORS} import compiled\n\n\n@compiled\ndef double(x):\n    return x + x\n"


def powerless() -> None:
    """Have permissions count for root, too."""
    for capability in (CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH):
        ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)


@pytest.fixture
def installed(tmp_path: Path) -> Iterator[Path]:
    """A copy of what compiles."""
    package = copied_package(tmp_path / "installed", "reference_model", "engines")
    (package / "reference_model/small.py").write_text(SMALL)
    yield tmp_path / "installed"
    for path in [tmp_path / "installed", *(tmp_path / "installed").rglob("*")]:  # so that it can be removed
        path.chmod(path.stat().st_mode | 0o200)


def told(installed: Path, home: Path, compiles: bool = True, **variables: str) -> tuple[Path, str]:
    """Where code is kept, and what is said of it, by a process that finds this home folder; `compiles`: it keeps some there."""
    environment = {
        "PATH": os.environ["PATH"],
        "HOME": str(home),
        "PYTHONPATH": str(installed),
        "TMPDIR": str(installed.parent),
        **variables,
    }
    command = [sys.executable, "-P", "-c", f"{CODE if compiles else ''}{TELLS}"]
    found = subprocess.run(command, env=environment, preexec_fn=powerless, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    folder, sentence = found.stdout.strip().split("|")
    return Path(folder), sentence


def test_code_is_kept_beside_the_sources(installed: Path, tmp_path: Path) -> None:
    folder, sentence = told(installed, tmp_path)
    assert folder.parent == installed / "quickreturn/reference_model/__pycache__"
    assert sentence == ""


@pytest.mark.verify
def test_code_of_an_installation_that_cannot_be_written_is_kept_for_the_user(installed: Path, tmp_path: Path) -> None:
    read_only(installed)
    folder, sentence = told(installed, tmp_path)
    assert folder.parent == tmp_path / ".cache/quickreturn"
    assert sentence == ""
    cache, _ = told(installed, tmp_path, compiles=False, XDG_CACHE_HOME=str(tmp_path / "xdg"))
    assert cache.parent == tmp_path / "xdg/quickreturn"
    other = tmp_path / "chosen"
    chosen, sentence = told(installed, tmp_path, compiles=False, NUMBA_CACHE_DIR=str(other))
    assert (chosen.parent, sentence) == (other, "")


@pytest.mark.verify
def test_without_a_home_it_lives_as_long_as_the_process_and_that_is_said(installed: Path, tmp_path: Path) -> None:
    read_only(installed)
    folder, sentence = told(installed, Path("/proc/nowhere"))
    assert folder.parent.parent == tmp_path
    assert "NUMBA_CACHE_DIR" in sentence
    assert not folder.parent.exists()


#: A source, what is replaced in it and by what, and whether the code that is compiled stays the same.
CHANGES = [
    ("engines/refusals.py", '"""', '"""Once more: ', True),
    ("engines/own/beam_engine.py", '"""', '"""Once more: ', True),
    ("engines/exudyn/slider.py", '"""', '"""Once more: ', True),
    ("reference_model/dop853_loop.py", "INTERPOLATED: Final = ", "INTERPOLATED: Final = 0 + ", False),
    ("reference_model/joint.py", "import math", "import math  # other", False),
    ("reference_model/small.py", "x + x", "2.0 * x", False),
    ("reference_model/__pycache__/unpacked/machine.py", "import math", "import math  # other", True),
]
#: Prints the hash, and then that with each change alone.
HASHES = """
import json, sys
from pathlib import Path
from quickreturn.reference_model.native.cache_folder import source_hash
print(source_hash())
for file, before, after, _ in json.loads(sys.argv[1]):
    text = Path(file).read_text()
    assert before in text, file
    Path(file).write_text(text.replace(before, after, 1))
    source_hash.cache_clear()
    print(source_hash())
    Path(file).write_text(text)
"""


def test_code_is_compiled_anew_where_what_is_compiled_has_changed(installed: Path) -> None:
    unpacked = installed / "quickreturn/reference_model/__pycache__/unpacked/machine.py"  # what a Python FMU brings, beside compiled code
    unpacked.parent.mkdir(parents=True, exist_ok=True)
    unpacked.write_text("import math")
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(installed), "NUMBA_CACHE_DIR": "/tmp"}
    command = [sys.executable, "-P", "-c", HASHES, json.dumps(CHANGES)]
    run = subprocess.run(command, cwd=installed / "quickreturn", env=environment, capture_output=True, text=True, check=True)
    old, *new = run.stdout.split()
    assert {file: found == old for (file, *_), found in zip(CHANGES, new, strict=True)} == {file: same for file, *_, same in CHANGES}


@pytest.mark.verify
def test_a_function_of_another_file_is_compiled_anew_where_that_has_changed(tmp_path: Path) -> None:
    code = f"from {DECORATORS} import compiled\nfrom small import value\nprint(value())"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join((str(tmp_path), str(ROOT))), "NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    for number in ("1.5", "2.5"):
        (tmp_path / "small.py").write_text(
            f"from {DECORATORS} import compiled\nVALUE = {number}\n@compiled\ndef value():\n    return VALUE\n"
        )
        run = [sys.executable, "-P", "-B", "-c", code]
        assert subprocess.run(run, env=environment, capture_output=True, text=True, check=True).stdout == f"{number}\n"


def test_compiled_functions_call_those_of_the_reference_model_and_of_their_own_folder() -> None:
    """By the names that they use, once all modules are imported: changes elsewhere would not have them compiled anew."""
    functions = 0
    for module in {**modules_in("quickreturn.reference_model"), **modules_in("quickreturn.engines")}:
        for member in vars(import_module(module)).values():
            if (function := getattr(member, "py_func", None)) is None:
                continue
            functions += 1
            used = [function, *(function.__globals__.get(name) for name in function.__code__.co_names)]
            homes = {home for each in used if (home := home_of(each)).startswith("quickreturn.")}
            near = "quickreturn.reference_model.", module.rpartition(".")[0] + "."
            assert all(home.startswith(near) for home in homes), f"{module}: {member}"
    assert functions > 50


def home_of(value: Any) -> str:
    """The module of a function, compiled or not, or the name of a module."""
    return str(getattr(getattr(value, "py_func", value), "__module__", None) or getattr(value, "__name__", ""))


def read_only(folder: Path) -> None:
    for path in [folder, *folder.rglob("*")]:
        path.chmod(path.stat().st_mode & 0o555)
