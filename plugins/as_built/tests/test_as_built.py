"""The constructions of `examples/as_built/`: the statements of docs/as-built.md, and its numbers."""

import math
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
#: Rows of the document's tables: construction -> cells.
ROWS = {
    name: cells
    for name, *cells in (
        [cell.strip(" *") for cell in line.strip("|").split("|")]
        for line in (ROOT / "docs" / "as-built.md").read_text(encoding="utf-8").splitlines()
        if re.match(r"\| \**(slot|sliding)", line)
    )
}
#: Columns of the first table, of which the second has the first two; the last column of both is a time.
COLUMNS = ("error", "peak", "frequency", "damping", "gap")
#: Differences that two digits and another machine's rounding leave.
NEAR = {
    "peak": {"abs": 2e-3},
    "frequency": {"abs": 1e-4, "rel": 1e-3},
    "damping": {"abs": 1e-4, "rel": 0.02},
    "error": {"rel": 0.07},
    "gap": {"rel": 0.07},
}


@pytest.fixture(scope="module")
def measure(module_monkeypatch: pytest.MonkeyPatch) -> Any:
    module_monkeypatch.syspath_prepend(str(ROOT / "examples" / "as_built"))
    import measure

    return measure


@pytest.fixture(scope="module")
def module_monkeypatch() -> Any:
    with pytest.MonkeyPatch.context() as monkeypatch:
        yield monkeypatch
    for name in ("measure", "mujoco_machines", "exudyn_machines", "run_24"):
        sys.modules.pop(name, None)


def test_the_defaults_lose_the_machine_and_a_stiff_contact_keeps_it(measure: Any) -> None:
    machines = measure.mujoco_machines
    lost, _ = machines.simulate(machines.MACHINES["slot, all defaults, 2 ms"], 0.1)
    assert lost["time"][-1] < 0.05
    kept, _ = machines.simulate(machines.STIFF, 0.3)
    assert kept["time"][-1] == pytest.approx(0.3)
    assert kept["constraint_gap"].max() < 5e-5


def test_exudyns_sliding_joint_converges_with_its_step(measure: Any) -> None:
    """In the first 0.3 s of run 24, against the converged solution."""
    machines, (deflection, _) = measure.exudyn_machines, measure.truth()
    errors = {}
    for name in ("sliding joint, not classical, 1 ms", "sliding joint, not classical, 0.25 ms, Newton 1e-5"):
        columns, _ = machines.simulate(machines.MACHINES[name], 0.3)
        true = deflection[np.round(1e3 * columns["time"]).astype(int)]
        errors[name] = math.sqrt(np.mean((columns["tip_deflection"] - true) ** 2) / np.mean(true**2))
    coarse, fine = errors.values()
    assert 6.0 * fine < coarse < 5e-3  # a quarter of the step: of more than first order, until the elements' own error counts
    assert fine < 5e-4


def test_the_document_has_every_construction(measure: Any) -> None:
    assert list(ROWS) == list(measure.MACHINES)


@pytest.fixture(scope="module")
def truth(measure: Any) -> Any:
    return measure.truth()


@pytest.mark.verify
@pytest.mark.parametrize("name", ROWS)
def test_the_numbers_of_the_document_come_out_again(measure: Any, truth: Any, name: str) -> None:
    """To its digits; the error alone, and to a factor of two, where chaos decides."""
    assert truth[1] == pytest.approx(20.354, abs=1e-3)
    found, cells = measure.measured(name, *truth), ROWS[name]
    if cells[0].startswith("lost"):
        assert cells[0] == f"lost after {1e3 * found['end']:.0f} ms"
        return
    for key, cell in zip(COLUMNS, cells[:-1], strict=False):
        number, *unit = cell.split()
        value = float(number) * (1e-2 if unit else 1e-3 if key == "gap" else 1.0)
        if key == "error" and value > 1.0:
            assert 0.5 < found[key] / value < 2.0
            break
        assert found[key] == pytest.approx(value, **NEAR[key]), key
