"""Times to compile an engine's machine code, once on a machine, and to load it, in every new process.

An engine's first output step is timed in two processes, one after the other. They share a folder for machine code that is empty at first.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from quickreturn.cases.library import load_case
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.one_run import compile_seconds
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.native.cache_folder import VARIABLE

#: The scene of the step; the code is the same for all.
_CASE: Final = "thesis-24"


@dataclass(frozen=True)
class Compiling:
    """Wall times, s, of the first output step of an engine whose code is compiled."""

    engine: str
    compile_seconds: float  # without compiled code
    load_seconds: float  # with the code of another process


def compiling(workshop: Workshop, names: Sequence[str]) -> list[Compiling]:
    """The times of engines among `names` that compile code. KeyboardInterrupt: Ctrl-C; finished measurements are stored."""
    jobs = [
        Job(f"compiling {name}", measured, (name,), "compiling", (name,))
        for name in names
        if engine(name).compiles and not engine(name).unavailable()
    ]
    return [outcome.value for outcome in workshop.outcomes(jobs, "compiling") if outcome.value is not None]


def measured(name: str) -> Compiling:
    """Both times of an engine, in processes of their own."""
    with tempfile.TemporaryDirectory() as folder:
        compile_seconds, load_seconds = (_in_a_new_process(name, folder) for _ in range(2))
    return Compiling(name, compile_seconds, load_seconds)


def _in_a_new_process(name: str, folder: str) -> float:
    command = [sys.executable, "-m", __name__, name]
    return float(subprocess.run(command, env={**os.environ, VARIABLE: folder}, capture_output=True, text=True, check=True).stdout)


def first_step(name: str) -> float:
    """Wall time (s) of an engine's first output step in this process, imports apart."""
    case, chosen = load_case(_CASE), engine(name)
    settings = chosen.settings_for(chosen.default_accuracy, case.mechanism)
    return compile_seconds(chosen, case.mechanism, standard_start(case.mechanism), case.output_step, settings)


if __name__ == "__main__":
    print(first_step(sys.argv[1]))
