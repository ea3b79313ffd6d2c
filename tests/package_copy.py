"""A copy of a part of the package, laid out as it installs.

Python's compiled files come along, which are as old as their sources say: to compile 400 modules takes longer than what most tests do with
them. Numba's do not.
"""

import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
_WITHOUT_MACHINE_CODE = shutil.ignore_patterns("quickreturn-*", "*.nbi", "*.nbc")


def copied_package(folder: Path, *inner: str) -> Path:
    """The folder `quickreturn`, made inside `folder`: the public package's names, and the inner packages that are given."""
    package = folder / "quickreturn"
    package.mkdir(parents=True)
    for public in ("__init__.py", "__init__.pyi"):
        shutil.copy(ROOT / "quickreturn" / public, package)
    for name in inner:
        shutil.copytree(ROOT / name, package / name, ignore=_WITHOUT_MACHINE_CODE)
    return package


def whole_package(folder: Path) -> Path:
    """The folder `quickreturn` with all its packages, made inside `folder`."""
    package = folder / "quickreturn"
    shutil.copytree(ROOT / "quickreturn", package, ignore=_WITHOUT_MACHINE_CODE)
    return package
