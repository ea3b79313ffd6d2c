"""The constructions of both programs beside a converged solution, as JSON, one line each.

    python measure.py [NAME ...]  # all of them, or some

error: RMS of the difference of the tip deflection over its RMS; peak, frequency: over the true
ones, less 1; damping: ratio of the first mode; gap: the largest, m; seconds: processor time of the
solve; end: when the program lost the motion, s.
"""

import json
import math
import sys
from typing import Any, Final

import numpy as np
import quickreturn as qr

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


def measured(name: str, deflection: np.ndarray, true_frequency: float) -> dict[str, float]:
    """The numbers of one construction; `end` alone if the program lost the motion."""
    program, machine = MACHINES[name]
    columns, seconds = program.simulate(machine)
    if columns["time"][-1] < 2.0:
        return {"end": float(columns["time"][-1])}
    true = deflection[np.round(1e3 * columns["time"]).astype(int)]
    error = math.sqrt(np.mean((columns["tip_deflection"] - true) ** 2) / np.mean(true**2))
    peak = float(np.abs(columns["tip_deflection"]).max() / np.abs(true).max()) - 1.0
    found = {"error": error, "peak": peak, "seconds": seconds}
    if program is mujoco_machines:
        frequency, damping = program.pluck(machine)
        gap = float(columns["constraint_gap"].max())
        found |= {"frequency": frequency / true_frequency - 1.0, "damping": damping, "gap": gap}
    return found


if __name__ == "__main__":
    true = truth()
    for name in sys.argv[1:] or MACHINES:
        found = {key: float(f"{each:.3g}") for key, each in measured(name, *true).items()}
        print(json.dumps({"name": name, "program": MACHINES[name][0].PROGRAM} | found), flush=True)
