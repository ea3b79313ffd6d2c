"""The constructions of all programs beside a converged solution.

python measure.py [NAME ...]   # all of them, or some
"""

import math
import sys
from dataclasses import dataclass
from typing import Final

import numpy as np
import quickreturn as qr

import exudyn_machines
import mujoco_machines

#: Run 24, damped by its material.
CASE: Final = qr.case("thesis-24").with_(
    {"follower.damping": "0 N*s/m^2", "follower.material_damping": "1e-4 s"}
)


#: Which program, and its constructions by name.
MACHINES: Final = {
    name: (program, machine)
    for program in (mujoco_machines, exudyn_machines)
    for name, machine in program.MACHINES.items()
}


@dataclass(frozen=True)
class Measured:
    """A construction beside the converged solution."""

    name: str
    end: float  # s, of the motion; less than 2 s if the program lost it
    error: float  # of the tip deflection, RMS of the difference over RMS
    peak: float  # largest tip deflection over the true one, less 1
    frequency: float  # of the first mode with the crank held at 180 deg, over the true one, less 1
    damping: float  # its damping ratio
    gap: float  # largest distance of pin and centre line, m
    seconds: float  # processor time of the solve

    def __str__(self) -> str:
        if self.end < 2.0:
            return f"{self.name}: ends at {self.end:g} s"
        return (
            f"{self.name}: deflection {self.error:.2%}, peak {self.peak:+.1%},"
            f" frequency {self.frequency:+.2%}, damping ratio {self.damping:.4f},"
            f" gap {1e3 * self.gap:.3f} mm, {self.seconds:.2f} s"
        )


def truth() -> tuple[np.ndarray, float, float]:
    """Tip deflection at each millisecond of 2 s; first frequency at 180 deg, and damping ratio.

    The damping ratio is half of eta omega.
    """
    run = qr.simulate(CASE, "reference", settings={"modes": 9, "tolerance": 1e-8}, estimate=False)
    frequency = float(qr.modes(CASE, "reference", 180.0, count=1).iloc[0, 0])
    return run.trajectory["tip_deflection"], frequency, 0.5e-4 * 2.0 * math.pi * frequency


def measured(name: str, deflection: np.ndarray, true_frequency: float) -> Measured:
    """One construction."""
    program, machine = MACHINES[name]
    columns, seconds = program.simulate(machine)
    true = deflection[np.round(1e3 * columns["time"]).astype(int)]
    error = math.sqrt(np.mean((columns["tip_deflection"] - true) ** 2) / np.mean(true**2))
    peak = np.abs(columns["tip_deflection"]).max() / np.abs(true).max() - 1.0
    frequency, damping = (
        program.pluck(machine) if columns["time"][-1] >= 2.0 else (math.nan, math.nan)
    )
    gap = float(columns["constraint_gap"].max())
    return Measured(
        name,
        float(columns["time"][-1]),
        error,
        float(peak),
        frequency / true_frequency - 1.0,
        damping,
        gap,
        seconds,
    )


if __name__ == "__main__":
    deflection, frequency, damping = truth()
    print(f"true: {frequency:.3f} Hz, damping ratio {damping:.4f}")
    for name in sys.argv[1:] or MACHINES:
        print(measured(name, deflection, frequency), flush=True)
