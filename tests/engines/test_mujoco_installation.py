"""Which installations of MuJoCo are accepted, what is said of the others, and that old versions work."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from quickreturn.engines.mujoco import installation

ROOT = Path(__file__).parents[2]


def laid(folder: Path, *distributions: str, files: bool = True) -> None:
    """Write the metadata of distributions such as "mujoco 3.17.0", and the package's first file."""
    for name, version in (each.split() for each in distributions):
        metadata = folder / f"{name.replace('-', '_')}-{version}.dist-info"
        metadata.mkdir(parents=True)
        (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    (folder / "mujoco").mkdir()
    if files:
        (folder / "mujoco" / "__init__.py").touch()


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in which alone packages are found; what is imported already does not count."""
    monkeypatch.delitem(sys.modules, "mujoco")
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    return tmp_path


@pytest.mark.parametrize(
    ("distributions", "version"),
    [
        (("mujoco 3.3.1",), "3.3.1"),
        (("mujoco 3.17.0",), "3.17.0"),
        (("mujoco 4.0.0", "mujoco-core 4.0.0"), "4.0.0"),
        (("mujoco-core 4.0.1",), "4.0.1"),
    ],
)
def test_either_distribution_will_do(site: Path, distributions: tuple[str, ...], version: str) -> None:
    laid(site, *distributions)
    assert installation.unavailable() is None
    assert installation.version() == f"mujoco {version}"


@pytest.mark.parametrize(
    ("distributions", "files", "words"),
    [
        ((), None, "mujoco is not installed"),
        (("mujoco 3.3.0",), True, "mujoco 3.3.0 is installed, 3.3.1 or later is needed"),
        (("mujoco 3.17.0",), False, "files of the package mujoco are missing"),
        (("mujoco 3.17.0", "mujoco-core 4.0.1"), True, "pip uninstall mujoco mujoco-core, then pip install mujoco"),
    ],
)
def test_what_is_wrong_with_an_installation(site: Path, distributions: tuple[str, ...], files: bool | None, words: str) -> None:
    if files is not None:
        laid(site, *distributions, files=files)
    assert words in str(installation.unavailable())


def test_a_distribution_in_another_folder_does_not_count(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    laid(site / "first", "mujoco 3.17.0")
    laid(site / "second", "mujoco-core 4.0.1")
    monkeypatch.setattr(sys, "path", [str(site / "first"), str(site / "second")])
    assert installation.unavailable() is None
    assert installation.version() == "mujoco 3.17.0"


@pytest.mark.verify
@pytest.mark.parametrize("version", ["3.3.1", "3.17.0"])
def test_the_adapters_work_with_older_versions(version: str, tmp_path: Path) -> None:
    """The oldest and one between, in a folder that Python looks into first; the other tests run with the newest."""
    asked = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(tmp_path), f"mujoco=={version}", "glfw"]
    installed = subprocess.run(asked, capture_output=True, text=True, check=False)
    if installed.returncode != 0:
        pytest.skip(f"mujoco {version} cannot be installed here: {installed.stderr.strip().splitlines()[-1]}")
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    printed = [sys.executable, "-c", "from quickreturn.engines.mujoco import installation as i; print(i.version(), i.unavailable())"]
    found = subprocess.run(printed, env=environment, capture_output=True, text=True, check=True)
    assert found.stdout.strip() == f"mujoco {version} None"
    files = [f"tests/engines/test_{name}.py" for name in ("mujoco_engine", "mujoco_motion", "natural_frequencies")]
    tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", "0", *files]
    run = subprocess.run(tests, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout[-3000:]
