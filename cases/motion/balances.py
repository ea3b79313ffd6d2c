"""Balances that a motion keeps, whatever its settings: energy, the joint, and the crank's angle as the integral of its speed.

A run that violates one is doubtful, though its own error estimate is small: two wrong runs can be equally wrong. They need no right answer.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.mechanism import Mechanism

#: Relative error of the strain energy over that of the amplitude: the energy grows with its square.
ENERGY_PER_ERROR: Final = 2.0
#: Largest gap between slider and centre line, m: ten times that of the loosest engine. A gap only moves the place of the slider's load.
LARGEST_GAP: Final = 1e-4
#: Largest deviation of the crank angle from the integral of its speed by the trapezoidal rule, as a part of the turn in a row; 7e-4 was the
#: largest measured with rows of 1 ms.
LARGEST_JUMP: Final = 0.02


@dataclass(frozen=True, kw_only=True)
class Balances:
    """How far a motion is from its balances."""

    energy_residual: float | None = None  # see `energy_residual`
    constraint_gap: float | None = None  # m, largest; None where the engine has no such column or the joint gives way by its nature
    crank_jump: float = 0.0  # see `crank_jump`

    @classmethod
    def of(cls, columns: Columns, mechanism: Mechanism) -> "Balances":
        """The balances of a trajectory."""
        rigid = mechanism.slider.is_rigid
        gap = float(np.max(np.abs(columns["constraint_gap"]))) if rigid and "constraint_gap" in columns else None
        return cls(energy_residual=energy_residual(columns), constraint_gap=gap, crank_jump=crank_jump(columns))

    def violated(self, asked: float) -> str:
        """The first balance that is violated, where an error `asked` of the tip deflection is allowed (a clause); "" if all are kept."""
        if self.energy_residual is not None and not self.energy_residual <= ENERGY_PER_ERROR * asked:  # also where it is no number
            return f"the energy balance is violated by {self.energy_residual:.2g} of the largest strain energy"
        if self.constraint_gap is not None and not self.constraint_gap <= LARGEST_GAP:
            return f"the slider is off the centre line by up to {self.constraint_gap:.2g} m"
        if not self.crank_jump <= LARGEST_JUMP:
            return f"the crank angle jumps: it is not the integral of the crank speed (by {self.crank_jump:.2g} of a row)"
        return ""


def energy_residual(columns: Columns) -> float | None:
    """Largest violation of the energy balance over the largest strain energy; None without the columns or without strain energy."""
    gains = ("kinetic_energy", "strain_energy", "gravity_energy", "dissipated_energy")
    if not {*gains, "drive_work"} <= set(columns):
        return None
    balance = sum((columns[name] for name in gains), start=-columns["drive_work"])
    largest = float(np.max(np.abs(columns["strain_energy"])))
    return float(np.max(np.abs(balance - balance[0]))) / largest if largest > 0.0 else None


def crank_jump(columns: Columns) -> float:
    """Largest deviation of the crank angle's step from row to row from the trapezoidal rule over the crank speed, over a row's turn."""
    speed, rows = columns["crank_speed"], np.diff(columns["time"])
    turned = float(np.max(np.abs(speed))) * float(np.max(rows, initial=0.0))
    missed = np.abs(np.diff(columns["crank_angle"]) - 0.5 * rows * (speed[1:] + speed[:-1]))
    return float(np.max(missed)) / turned if turned > 0.0 and len(missed) else 0.0
