"""The second process compiles just what the first would have to."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from quickreturn.reference_model.first_start import compiled_by_the_second
from quickreturn.reference_model.model import BeamModel
from tests.engines.scenes import run_24

#: A few steps of run 24 and their observables, as a program of its own.
RUN = """
from quickreturn.reference_model.model import BeamModel
from tests.engines.scenes import run_24
model = BeamModel.following(run_24(), 2)
model.observe(model.integrate(model.straight_state(1.0, 0.0), 1e-3, 3, 1e-5).states)
"""


def test_a_run_asks_for_what_the_second_compiles_and_for_no_other_types() -> None:
    model = BeamModel.following(run_24(), 2)
    model.observe(model.integrate(model.straight_state(1.0, 0.0), 1e-3, 3, 1e-5).states)
    for function, signature in compiled_by_the_second():
        # of the equations' parts where the equations are not on the disk
        assert list(function.signatures) in ([signature], []), function


@pytest.mark.verify
def test_nothing_is_compiled_twice_at_the_first_start(tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", RUN], env=environment, check=True)
    compiled = sorted(path.name.split("-")[0] for path in tmp_path.rglob("*.nbc"))
    assert {"equations.kernel", "equations.observe_states", "dop853_loop.loop"} <= set(compiled)
    assert len(compiled) == len(set(compiled))
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    subprocess.run([sys.executable, "-c", RUN], env=environment, check=True)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before
