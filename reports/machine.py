"""The machine, the software and the time, as far as they tell how results and solve times came about."""

import datetime
import os
import platform
from importlib import metadata
from pathlib import Path
from typing import Final

from cases.jobs.processes import available_cores

#: Packages whose versions the report names besides those of the engines.
PACKAGES: Final = ("quickreturn", "numpy", "scipy", "numba", "pandas", "matplotlib", "exudyn", "mujoco-core", "pint")


def machine_facts() -> dict[str, str]:
    """Facts in words, by name."""
    return {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": processor(),
        "cores": f"{available_cores()} usable of {os.cpu_count() or 'unknown'}",
        "memory": memory(),
        "system": system(),
        "Python": f"{platform.python_implementation()} {platform.python_version()}",
        "packages": ", ".join(f"{name} {version(name)}" for name in PACKAGES),
    }


def processor() -> str:
    """Model of the processor."""
    for key, value in _pairs("/proc/cpuinfo"):
        if key == "model name":
            return value
    return platform.processor() or platform.machine() or "unknown"


def memory() -> str:
    """Size of the memory."""
    for key, value in _pairs("/proc/meminfo"):
        if key == "MemTotal" and value.split()[0].isdigit():
            return f"{int(value.split()[0]) / 2**20:.1f} GiB"
    return "unknown"


def system() -> str:
    """Name and version of the operating system."""
    try:
        name = platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        name = platform.system()
    return f"{name}, {platform.system()} {platform.release()}, {platform.machine()}"


def version(package: str) -> str:
    """Version of an installed package."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def _pairs(file: str) -> list[tuple[str, str]]:
    """The lines "key : value" of a file of the system, none if there is no such file."""
    try:
        lines = Path(file).read_text("utf-8", errors="replace").splitlines()
    except OSError:
        return []
    return [(key.strip(), value.strip()) for key, sign, value in (line.partition(":") for line in lines) if sign]
