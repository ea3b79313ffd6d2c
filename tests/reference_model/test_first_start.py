"""The first start of a program compiles everything, and the next one nothing."""

import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

#: A few steps of run 24 and their observables, as a program of its own.
RUN = """
from quickreturn.reference_model.model import BeamModel
from tests.engines.scenes import run_24
model = BeamModel.following(run_24(), 2)
model.observe(model.integrate(model.straight_state(1.0, 0.0), 1e-3, 3, 1e-5).states)
"""

#: Where objects cannot be loaded, numba's own cache serves.
NO_OBJECTS = """
from pathlib import Path
from quickreturn.reference_model.native import objects
objects._loaded = lambda path: Path("nowhere").read_text()
"""


@pytest.mark.verify
@pytest.mark.parametrize("before", ["", NO_OBJECTS], ids=["objects", "no objects"])
def test_the_second_start_compiles_nothing(tmp_path: Path, before: str) -> None:
    run = [sys.executable, "-c", before + RUN]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run(run, env=environment, check=True)
    compiled = sorted(path.name.split("-")[0].rpartition("reference_model.")[2] for path in tmp_path.rglob("*.nbc"))
    assert {"motion.equations.kernel", "motion.observe.observe_states", "dop853_loop.loop"} <= set(compiled)
    assert max(Counter(compiled).values()) == 1
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    subprocess.run(run, env=environment, check=True)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before
