"""The descriptions of `examples/derive`, which are files, not a package."""

import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType

FOLDER = Path(__file__).resolve().parents[3] / "examples" / "derive"


@cache
def described(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"described_{name}", FOLDER / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
