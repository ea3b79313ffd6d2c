"""Third-party packages as an installer leaves them: modules and entry points in a folder that is put on the path."""

from collections.abc import Mapping
from pathlib import Path

FAKE_ENGINE = Path(__file__).with_name("fake_engine.py").read_text(encoding="utf-8")


def install(folder: Path, package: str, modules: Mapping[str, str], entries: Mapping[str, str]) -> None:
    """Write `modules` (name -> source) and the entry points `entries` (engine name -> "module:Class") of a package to `folder`."""
    folder.mkdir(exist_ok=True)
    for name, source in modules.items():
        (folder / f"{name}.py").write_text(source, encoding="utf-8")
    information = folder / f"{package}-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n", encoding="utf-8")
    lines = "".join(f"{name} = {value}\n" for name, value in entries.items())
    (information / "entry_points.txt").write_text(f"[quickreturn.engines]\n{lines}", encoding="utf-8")
