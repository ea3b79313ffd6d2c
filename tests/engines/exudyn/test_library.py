"""Which of Exudyn's two modules is loaded, and that it is loaded in silence."""

import os
import subprocess
import sys

import pytest

LOADED = """
import sys
import quickreturn.engines.exudyn.simulation
print(*(name for name in sys.modules if name.startswith("exudyn.exudynCPP") and name.count(".") == 1))
"""


def loaded(before: str = "", **environment: str) -> str:
    """What a process prints that loads the engine after the statement `before`: the compiled modules, if nothing else prints."""
    inherited = {name: value for name, value in os.environ.items() if name != "EXUDYN_MODULE"}
    command = [sys.executable, "-c", f"{before}\n{LOADED}"]
    return subprocess.run(command, env=inherited | environment, capture_output=True, text=True, check=True).stdout.strip()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processors are told apart by what Linux says of them")
def test_the_module_without_range_checks_is_loaded_where_the_processor_can() -> None:
    with open("/proc/cpuinfo") as processors:
        name = "exudynCPPfast" if "avx2" in processors.read() else "exudynCPP"
    assert loaded() == f"exudyn.{name}"


def test_who_chooses_a_module_keeps_it() -> None:
    assert loaded("import sys; sys.exudynFast = False") == "exudyn.exudynCPP"
    assert loaded("import exudyn") == "exudyn.exudynCPP"
    assert loaded(EXUDYN_MODULE="checked") == "exudyn.exudynCPP"
