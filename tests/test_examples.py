"""The package `examples/rods/` that docs/engine.md offers to copy, installed as a user does."""

import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def test_the_adapter_is_as_short_as_the_page_says() -> None:
    lines = (ROOT / "examples" / "rods" / "mujoco_engine.py").read_text("utf-8").splitlines()
    assert f"in {len(lines)} lines" in (ROOT / "docs" / "engine.md").read_text("utf-8")


@pytest.mark.verify
def test_the_package_is_installed_and_conforms(tmp_path: Path) -> None:
    """In an environment of its own, which takes all else from this one."""
    package, environment = tmp_path / "package", tmp_path / "environment"
    shutil.copytree(ROOT / "examples" / "rods", package)
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    python = environment / "bin" / "python"
    site = Path(sysconfig.get_path("purelib", vars={"base": str(environment)}))
    (site / "beside.pth").write_text(f"import site; site.addsitedir({sysconfig.get_path('purelib')!r})\n", encoding="utf-8")
    install = [python, "-m", "pip", "install", "--quiet", "--constraint", ROOT / "constraints.txt", package]
    done = subprocess.run(install, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"pip cannot install the example:\n{done.stderr}"
    command = [python, "-m", "quickreturn", "conform", "my-rod"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
