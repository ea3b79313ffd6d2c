"""Times to compile an engine's machine code, once on a machine, and to load it, in every new process."""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass

from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import engine
from quickreturn.reference_model.native.cache_folder import VARIABLE


@dataclass(frozen=True)
class Compiling:
    """Wall times, s, of the first output step of an engine whose code is compiled."""

    engine: str
    compile_seconds: float  # without compiled code
    load_seconds: float  # with the code of another process


def compiling(workshop: Workshop, names: Sequence[str]) -> list[Compiling]:
    """The times of engines among `names` that compile code. KeyboardInterrupt: Ctrl-C; finished measurements are stored."""
    able = [name for name in names if engine(name).compiles and not engine(name).unavailable()]
    jobs = [Job(f"compiling {name}", measured, (name,), "compiling", (name,)) for name in able]
    return [outcome.value for outcome in workshop.outcomes(jobs, "compiling") if outcome.value is not None]


def measured(name: str) -> Compiling:
    """Both times of an engine in run 24: two processes, one after the other, share a folder for machine code that is empty at first."""
    command = [sys.executable, "-m", "quickreturn", "simulate", "thesis-24", "--engine", name, "--duration", "1 ms", "--json", "--output"]
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(2):
            places = {VARIABLE: folder, "QUICKRETURN_STORE": f"{folder}/store {number}"}
            run = subprocess.run([*command, f"{folder}/{number}.csv"], env={**os.environ, **places}, capture_output=True, check=False)
            seconds.append(float(json.loads(run.stdout)["compile_seconds"]))
    return Compiling(name, *seconds)
