"""The constructions of `examples/as_built/`: the statements of docs/as-built.md, and its numbers."""

import math
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from quickreturn.plugins.as_built.chapter import Construction, built

ROOT = Path(__file__).resolve().parents[3]


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


def test_the_frequency_and_damping_of_a_known_ring_are_found(measure: Any) -> None:
    t = 1e-3 * np.arange(1000)
    signal = 2.0 + np.exp(-0.02 * 2.0 * np.pi * 18.0 * t) * np.cos(2.0 * np.pi * 18.0 * t) + 0.2 * np.cos(2.0 * np.pi * 71.0 * t)
    frequency, damping = measure.mujoco_machines.ring(signal, 1e-3)
    assert frequency == pytest.approx(18.0, rel=2e-3)
    assert damping == pytest.approx(0.02, rel=0.05)


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


def row_of(row: Construction) -> str:
    """A recorded construction as a row of the document's table."""
    if row.error is None or row.peak is None or row.seconds is None:
        return f"| {row.name} | lost after {1e3 * row.end:.0f} ms | | | | | |"
    cells = [row.name, f"{short(100.0 * row.error)} %", f"{100.0 * row.peak:+.1f} %"]
    if row.frequency is not None and row.gap is not None:
        cells += [f"{100.0 * row.frequency:+.2f} %".replace("-0.00", "0.00"), f"{row.damping:.4f}", short(1e3 * row.gap)]
    return f"| {' | '.join(cells)} | {row.seconds:.2g} |"


def short(value: float) -> str:
    """Two digits, or the whole number."""
    return f"{value:#.2g}".rstrip(".") if value < 99.5 else f"{value:.0f}"


def test_the_tables_of_the_document_are_the_record() -> None:
    told = (ROOT / "docs" / "as-built.md").read_text(encoding="utf-8").splitlines()
    rows = [row.replace("**", "") for row in told if re.match(r"\| [^|]*(slot|joint)", row)]
    assert rows == [row_of(row) for row in built()]


@pytest.mark.verify
def test_the_record_comes_out_again(measure: Any) -> None:
    """Each construction of a few seconds: to a fifth of its error, and for errors above 1, where chaos decides, to a factor of two."""
    deflection, frequency = measure.truth()
    assert frequency == pytest.approx(20.354, abs=1e-3)
    known = {row.name: row for row in built() if (row.seconds or 0.0) < 5.0}
    for name in known:
        found = measure.measured(name, deflection, frequency)
        assert (found.error is None) == (known[name].error is None)
        if found.error is not None:
            assert abs(math.log(found.error / known[name].error)) < (math.log(2.0) if known[name].error > 1.0 else 0.2), name
