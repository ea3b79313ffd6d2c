"""Where compiled code is kept: beside the sources, else in the user's cache, else for as long as the process lives."""

import ctypes
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.package_copy import copied_package

PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH = 24, 1, 2

#: Compiles, calls and keeps a small function; then tells where, and what there is to say.
CODE = """
import os
from pathlib import Path
from quickreturn.reference_model.machine import machine_code
from quickreturn.reference_model.small import double
assert double(4.0) == 8.0
folder = Path(os.environ["NUMBA_CACHE_DIR"])
print(folder, any(folder.rglob("*.nbi")), machine_code.warning_if_not_kept(), sep="|")
"""
SMALL = "from quickreturn.reference_model.machine.compilation import compiled\n\n\n@compiled\ndef double(x):\n    return x + x\n"


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


def told(installed: Path, home: Path, **variables: str) -> tuple[Path, str]:
    """Where code was kept, and what is said of it, by a process that finds this home folder."""
    environment = {
        "PATH": os.environ["PATH"],
        "HOME": str(home),
        "PYTHONPATH": str(installed),
        "TMPDIR": str(installed.parent),
        **variables,
    }
    found = subprocess.run(
        [sys.executable, "-P", "-c", CODE], env=environment, preexec_fn=powerless, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stderr
    folder, kept, sentence = found.stdout.strip().split("|")
    assert kept == "True"
    return Path(folder), sentence


def test_code_is_kept_beside_the_sources(installed: Path, tmp_path: Path) -> None:
    folder, sentence = told(installed, tmp_path)
    assert folder.parent == installed / "quickreturn/reference_model/__pycache__"
    assert sentence == ""


def test_code_of_an_installation_that_cannot_be_written_is_kept_for_the_user(installed: Path, tmp_path: Path) -> None:
    read_only(installed)
    folder, sentence = told(installed, tmp_path)
    assert folder.parent == tmp_path / ".cache/quickreturn"
    assert sentence == ""
    cache, _ = told(installed, tmp_path, XDG_CACHE_HOME=str(tmp_path / "xdg"))
    assert cache.parent == tmp_path / "xdg/quickreturn"
    other = tmp_path / "chosen"
    assert told(installed, tmp_path, NUMBA_CACHE_DIR=str(other)) == (other, "")


def test_without_a_home_it_lives_as_long_as_the_process_and_that_is_said(installed: Path, tmp_path: Path) -> None:
    read_only(installed)
    folder, sentence = told(installed, Path("/proc/nowhere"))
    assert folder.parent == tmp_path
    assert "NUMBA_CACHE_DIR" in sentence
    assert not folder.exists()


def read_only(folder: Path) -> None:
    for path in [folder, *folder.rglob("*")]:
        path.chmod(path.stat().st_mode & 0o555)
