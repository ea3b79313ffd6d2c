"""Frozen modes of run 24: the greatest first frequency, and where the vibration at the return goes if the slider has a mass of its own.

The slider's mass in the model rides on the crank. A part of it, m, beyond the compliance k, moves with the follower, which then meets the
dynamic stiffness k - m omega^2. With the mass-normalised modes phi_j of the follower on the spring alone as shapes, Rayleigh's quotient is
q' diag(omega_j^2) q / q' (1 + m phi(s) phi(s)') q, whose stationary values are the squares of the new frequencies.
"""

import functools
import math
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator
from scipy.linalg import eigh

from quickreturn.cases.library.thesis.runs import run_case
from quickreturn.plugins.thesis.inference.study import EXAMPLE
from quickreturn.plugins.thesis.inference.unknowns import changes_of_machine
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.scene_values import changed

Array = NDArray[np.float64]

#: Crank angle in the middle of the return's first sixth, rad, and the number of modes there, of which the lowest are used.
RETURN: Final = math.radians(390.0)
MODES: Final = 12
USED: Final = 5
#: Place of the mode among those at the return that rings with a frequency within some 3 % of its own, in the machines computed.
RINGING: Final = 2
#: Grid of the table: stiffness over the arm's relative one, N/m, and mass beyond it, kg.
STIFFNESSES: Final = np.geomspace(2e3, 4e5, 16)
MASSES: Final = np.linspace(0.0, 0.1, 6)
#: Crank angles between which the greatest first frequency of run 24 lies, rad.
ANGLES: Final = np.linspace(0.6 * math.pi, math.pi, 5)


def with_mass(scene: Mechanism, crank_angle: float, mass: float, count: int = USED) -> Array:
    """The lowest natural frequencies (Hz) with the crank held and a mass (kg) on the follower at the slider, beyond a compliant joint."""
    modes = frozen_crank_modes(scene, crank_angle, MODES)
    shapes = modes.deflection(np.array([modes.slider_position]))[:, 0]
    squares = eigh(np.diag((2.0 * np.pi * modes.frequencies) ** 2), np.eye(MODES) + mass * np.outer(shapes, shapes), eigvals_only=True)
    return np.sqrt(squares[:count]) / (2.0 * np.pi)


def greatest_first_frequency(machine: Array) -> float:
    """The greatest first frequency (Hz) of a machine in run 24 over the crank angle, with the stiffer roller in contact."""
    changes = changes_of_machine(machine, EXAMPLE)
    rollers = [changes.get(f"slider.joint_stiffness_{side}", math.inf) for side in ("plus", "minus")]
    of_strip = {key: value for key, value in changes.items() if not key.startswith("slider.")}
    held = changed(run_case(EXAMPLE).mechanism, of_strip | {"slider.joint_stiffness": max(rollers)})
    return max(float(frozen_crank_modes(held, float(angle), 1).frequencies[0]) for angle in ANGLES)


@functools.cache
def _table() -> RegularGridInterpolator:
    """Frequencies at the return (Hz) over log stiffness and mass, with the printed bending stiffness, shape (..., `USED`)."""
    scene = run_case(EXAMPLE).mechanism
    rows = [
        [with_mass(changed(scene, {"slider.joint_stiffness": float(stiffness)}), RETURN, float(mass)) for mass in MASSES]
        for stiffness in STIFFNESSES
    ]
    return RegularGridInterpolator((np.log(STIFFNESSES), MASSES), np.array(rows), bounds_error=False, fill_value=None)


def at_return(stiffness: Array, plus: Array, mass: Array) -> Array:
    """Frequencies with the crank at 390 degrees (Hz, shape (n, `USED`)), which scale with the root of EI if k / EI and the mass stay.

    `stiffness`: bending stiffness over the printed one; `plus`: roller after the return, kN/m; `mass`: beyond it, kg; each of shape (n,).
    """
    scaled = np.log(np.minimum(1e3 * plus / stiffness, STIFFNESSES[-1]))
    return np.sqrt(stiffness)[:, None] * _table()(np.column_stack([scaled, mass]))


def moved_by_mass(frequency: Array, without: Array, having: Array) -> tuple[Array, Array]:
    """Where a vibration at the return goes (Hz, shape (n,)) by a mass: in the mode nearest to it, or in the next one.

    Which of the two rings the hand model cannot say. `frequency`: without the mass, Hz, shape (n,); `without`, `having`: of `at_return`.
    """
    nearest = np.argmin(np.abs(np.log(without / frequency[:, None])), axis=1)
    rows, following = np.arange(len(frequency)), np.minimum(nearest + 1, USED - 1)
    own = frequency * having[rows, nearest] / without[rows, nearest]
    return own, np.where(np.any(having != without, axis=1), having[rows, following], own)
