"""The constructions of both programs beside a converged solution, as JSON, one line each.

python measure.py [NAME ...]  # all of them, or some
"""

import json
import math
import sys
from dataclasses import asdict
from typing import Any, Final

import numpy as np
import quickreturn as qr
from quickreturn.plugins.as_built.chapter import Construction

import exudyn_machines
import mujoco_machines

#: Run 24, damped by its material.
CASE: Final = qr.case("thesis-24").with_(
    {"follower.damping": "0 N*s/m^2", "follower.material_damping": "1e-4 s"}
)
#: Name -> module and construction.
MACHINES: Final[dict[str, tuple[Any, Any]]] = {
    name: (program, machine)
    for program in (mujoco_machines, exudyn_machines)
    for name, machine in program.MACHINES.items()
}


def truth() -> tuple[np.ndarray, float]:
    """Tip deflection (m) at each millisecond of 2 s; first frequency (Hz) at 180 deg."""
    run = qr.simulate(CASE, "reference", settings={"modes": 9, "tolerance": 1e-8}, estimate=False)
    frequency = float(qr.modes(CASE, "reference", 180.0, count=1).iloc[0, 0])
    return run.trajectory["tip_deflection"], frequency


def measured(name: str, deflection: np.ndarray, true_frequency: float) -> Construction:
    """One construction, with three digits of each number."""
    program, machine = MACHINES[name]
    columns, seconds = program.simulate(machine)
    end = float(columns["time"][-1])
    if end < 2.0:
        return Construction(name, program.PROGRAM, end)
    true = deflection[np.round(1e3 * columns["time"]).astype(int)]
    error = math.sqrt(np.mean((columns["tip_deflection"] - true) ** 2) / np.mean(true**2))
    peak = float(np.abs(columns["tip_deflection"]).max() / np.abs(true).max()) - 1.0
    frequency = damping = gap = None
    if program is mujoco_machines:
        frequency, damping = program.pluck(machine)
        frequency, gap = frequency / true_frequency - 1.0, float(columns["constraint_gap"].max())
    numbers = (error, peak, frequency, damping, gap, seconds)
    short = (None if each is None else float(f"{each:.3g}") for each in numbers)
    return Construction(name, program.PROGRAM, end, *short)


if __name__ == "__main__":
    true = truth()
    for name in sys.argv[1:] or MACHINES:
        print(json.dumps(asdict(measured(name, *true))), flush=True)
