"""Facts on the machine, the software and the time behind results and solve times."""

import contextlib
import datetime
import os
import platform
import re
from importlib import metadata
from pathlib import Path
from typing import Final

from quickreturn.cases.running.isolation import available_cores

#: Packages whose versions the report names besides those of the engines.
PACKAGES: Final = ("quickreturn", "numpy", "scipy", "numba", "pandas", "matplotlib", "pint")


def machine_facts() -> dict[str, str]:
    """Name of a fact -> the fact in words."""
    return {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": _processor(),
        "cores": f"{available_cores()} usable of {os.cpu_count() or 'unknown'}",
        "memory": f"{os.sysconf('SC_PHYS_PAGES') * os.sysconf('SC_PAGE_SIZE') / 2**30:.1f} GiB",
        "system": _system(),
        "Python": f"{platform.python_implementation()} {platform.python_version()}",
        "packages": ", ".join(f"{name} {version(name)}" for name in PACKAGES),
    }


def version(package: str) -> str:
    """Version of a package, or "not installed"."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    with contextlib.suppress(OSError):
        cpu_info = Path("/proc/cpuinfo").read_text("utf-8", errors="replace")
        if model := re.search(r"^model name\s*:\s*(.+)$", cpu_info, re.MULTILINE):
            return model[1].strip()
    return platform.processor() or platform.machine() or "unknown"


def _system() -> str:
    try:
        name = platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        name = platform.system()
    return f"{name}, {platform.system()} {platform.release()}, {platform.machine()}"
