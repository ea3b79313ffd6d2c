"""The packages of `examples/`, each installed as its user would and put to its own tests."""

import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.verify
def test_the_pinocchio_engine_passes_its_tests(tmp_path: Path) -> None:
    """In an environment of its own, which takes all else from this one: Pinocchio is large, and nothing else here needs it."""
    package, environment = tmp_path / "package", tmp_path / "environment"
    shutil.copytree(ROOT / "examples" / "pinocchio_engine", package)
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    python = environment / "bin" / "python"
    site = Path(sysconfig.get_path("purelib", vars={"base": str(environment)}))
    (site / "beside.pth").write_text(f"import site; site.addsitedir({sysconfig.get_path('purelib')!r})\n", encoding="utf-8")
    install = [python, "-m", "pip", "install", "--quiet", "--constraint", ROOT / "constraints.txt", package]
    done = subprocess.run(install, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"pip cannot install the example with its dependency pin:\n{done.stderr}"
    done = subprocess.run([python, "-m", "pytest", "-q", package], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
