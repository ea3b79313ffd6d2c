"""The installation of MuJoCo: which distributions brought the package `mujoco`, and whether it can be used.

The distribution `mujoco` has all files up to 3.x, and requires `mujoco-core` of the same version from 4.0 on, which has them then.
"""

from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from quickreturn.engines.base import too_old

_DISTRIBUTIONS: Final = ("mujoco", "mujoco-core")
#: In 3.3.0 the compiled control hook crashes.
_OLDEST: Final = (3, 3, 1)
_ANEW: Final = "pip uninstall mujoco mujoco-core, then pip install mujoco"


def version() -> str:
    """Name and version."""
    return f"mujoco {next(reversed(_present().values()), 'not installed')}"


def unavailable() -> str | None:
    """Why it cannot be used (a sentence), or None."""
    present = _present()
    if not present:
        return "the package mujoco is not installed (distribution mujoco)"
    if len(set(present.values())) > 1:
        both = " and ".join(f"{name} {number}" for name, number in present.items())
        return f"the distributions {both} have written the same files, of which one version is left of each: {_ANEW}"
    if _folder() is None:
        return f"files of the package mujoco are missing, as after another distribution with the same files was removed: {_ANEW}"
    return too_old("mujoco", next(iter(present.values())), _OLDEST)


def _folder() -> Path | None:
    """Folder of the package that Python would import."""
    found = find_spec("mujoco")
    return None if found is None or found.origin is None else Path(found.origin).parent


def _present() -> dict[str, str]:
    """Name -> version of the distributions that belong to this folder, or of all if there is none; the one with the library is the last."""
    folder, present = _folder(), {}
    for name in _DISTRIBUTIONS:
        try:
            found = distribution(name)
        except PackageNotFoundError:
            continue
        if folder is None or Path(str(found.locate_file("mujoco"))) == folder:
            present[name] = found.version
    return present
