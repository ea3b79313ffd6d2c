"""The constructions of all programs beside a converged solution.

python measure.py [NAME ...]         # all of them, or some
python measure.py --rows [NAME ...]  # as JSON, one line each
"""

import importlib
import json
import math
import sys
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
import quickreturn as qr

#: Run 24, damped by its material.
CASE: Final = qr.case("thesis-24").with_(
    {"follower.damping": "0 N*s/m^2", "follower.material_damping": "1e-4 s"}
)


@dataclass(frozen=True)
class Measured:
    """A construction beside the converged solution; None where the program lost the motion."""

    name: str
    program: str  # with its version
    end: float  # s, of the motion; less than 2 s if the program lost it
    error: float | None = None  # of the tip deflection, RMS of the difference over RMS
    peak: float | None = None  # largest tip deflection over the true one, less 1
    frequency: float | None = (
        None  # of the first mode with the crank held, over the true one, less 1
    )
    damping: float | None = None  # its damping ratio
    gap: float | None = None  # largest distance of pin and centre line, m
    seconds: float | None = None  # processor time of the solve

    def __str__(self) -> str:
        if self.error is None:
            return f"{self.name}: ends at {self.end:g} s"
        return (
            f"{self.name}: deflection {self.error:.2%}, peak {self.peak:+.1%},"
            f" frequency {self.frequency:+.2%}, damping ratio {self.damping:.4f},"
            f" gap {1e3 * self.gap:.3f} mm, {self.seconds:.2f} s"
        )


def machines() -> dict[str, tuple[Any, Any]]:
    """Name -> module and construction, of the programs that are installed."""
    found = {}
    for name in (
        "mujoco_machines",
        "exudyn_machines",
        "drake_machines",
        "pyelastica_machines",
        "newton_machines",
    ):
        try:
            program = importlib.import_module(name)
        except ModuleNotFoundError as missing:
            print(f"{name} is left out: {missing}", file=sys.stderr)
            continue
        found.update({key: (program, machine) for key, machine in program.MACHINES.items()})
    return found


def truth() -> tuple[np.ndarray, float, float]:
    """Tip deflection at each millisecond of 2 s; first frequency at 180 deg, and damping ratio.

    The damping ratio is half of eta omega.
    """
    run = qr.simulate(CASE, "reference", settings={"modes": 9, "tolerance": 1e-8}, estimate=False)
    frequency = float(qr.modes(CASE, "reference", 180.0, count=1).iloc[0, 0])
    return run.trajectory["tip_deflection"], frequency, 0.5e-4 * 2.0 * math.pi * frequency


def measured(name: str, deflection: np.ndarray, true_frequency: float) -> Measured:
    """One construction."""
    program, machine = machines()[name]
    columns, seconds = program.simulate(machine)
    end = float(columns["time"][-1])
    if end < 2.0:
        return Measured(name, program.PROGRAM, end)
    true = deflection[np.round(1e3 * columns["time"]).astype(int)]
    error = math.sqrt(np.mean((columns["tip_deflection"] - true) ** 2) / np.mean(true**2))
    peak = float(np.abs(columns["tip_deflection"]).max() / np.abs(true).max()) - 1.0
    frequency, damping = program.pluck(machine)
    off, gap = frequency / true_frequency - 1.0, float(columns["constraint_gap"].max())
    return Measured(name, program.PROGRAM, end, error, peak, off, damping, gap, seconds)


def shortened(row: dict[str, Any]) -> dict[str, Any]:
    """The row with three digits of each number."""
    return {key: float(f"{v:.3g}") if isinstance(v, float) else v for key, v in row.items()}


if __name__ == "__main__":
    as_rows = sys.argv[1:2] == ["--rows"]
    deflection, frequency, damping = truth()
    if not as_rows:
        print(f"true: {frequency:.3f} Hz, damping ratio {damping:.4f}")
    for name in sys.argv[1 + as_rows :] or machines():
        found = measured(name, deflection, frequency)
        print(json.dumps(shortened(asdict(found))) if as_rows else found, flush=True)
