"""What the thesis does not print, or what it may have tuned: the unknowns of the inference, their ranges, and the points to compute.

A machine is a row of numbers in the units of `UNKNOWNS`. One number, `joint`, is clearance below 0 and preload above it, because a joint
with clearance has no preload; by its square small preloads are more frequent than large ones.
"""

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from quickreturn.cases.library.thesis.runs import run_case
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import value_at

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Unknown:
    """A quantity that the thesis leaves open, with the range in which it is sampled."""

    name: str
    words: str  # for people, with the unit
    low: float
    high: float
    is_log: bool
    reason: str  # why this range


#: The ranges are assumed; all weights hold for these alone.
UNKNOWNS: Final = (
    Unknown(
        "stiffness", "bending stiffness over the printed one", 0.9, 1.35, False, "printed; 1.147 and 1.218 with the modulus of 6061, 2024"
    ),
    Unknown("plus", "roller that carries after the return, kN/m", 3.0, 300.0, True, "a soft rubber tyre to a steel roller on a thin pin"),
    Unknown("minus", "roller that carries before the return, kN/m", 3.0, 300.0, True, "likewise"),
    Unknown(
        "joint", "clearance (−1: 0.2 mm) to preload (1: 30 N, as the square)", -0.45, 1.0, False, "loose to well tightened (section 3.2)"
    ),
    Unknown("tip", "tip body's centre beyond the end, in", 0.0, 0.5, False, "an inch of strip beyond the end counts as tip body"),
    Unknown("damping", "damping of the follower over the printed one", 0.5, 4.0, True, "its printed unit is illegible"),
    Unknown("crank", "mass of the crank over the printed one", 0.2, 2.0, True, "printed for the simulation alone"),
    Unknown("loss", "loss of a roller's contact, s/m", 0.05, 2.0, True, "rubber to metal (Hunt and Crossley)"),
)
NAMES: Final = tuple(unknown.name for unknown in UNKNOWNS)
#: Clearance (m) at `joint` = -1, preload (N) at `joint` = 1.
CLEARANCE: Final = 2e-4
PRELOAD: Final = 30.0
#: Damping of the follower's material, s, of all machines with rollers: without it impacts set modes ringing that nothing stops.
MATERIAL_DAMPING: Final = 2e-5
#: Number of Sobol points, and the seed of their scrambling.
SOBOL: Final = 96
SEED: Final = 1999
#: Chosen points: changes of the machine as published with a rigid joint; the rest of a row is `PRINTED`.
PRINTED: Final[Mapping[str, float]] = dict(zip(NAMES, (1.0, math.inf, math.inf, 0.0, 0.0, 1.0, 1.0, 0.5), strict=True))
CHOSEN: Final[tuple[Mapping[str, float], ...]] = (
    {},
    {"stiffness": 1.147},
    {"stiffness": 1.218},
    {"stiffness": 1.218, "tip": 0.25},
    {"stiffness": 1.218, "plus": 10.0, "minus": 300.0},
    {"stiffness": 1.218, "plus": 20.0, "minus": 300.0},
    {"stiffness": 1.218, "plus": 10.0, "minus": 300.0, "joint": 0.5},
    {"stiffness": 1.218, "plus": 10.0, "minus": 10.0, "joint": 0.8},
    {"stiffness": 1.218, "plus": 100.0, "minus": 100.0, "joint": -0.5},
    {"stiffness": 1.147, "plus": 100.0, "minus": 100.0, "joint": -0.25},
    {"stiffness": 1.218, "plus": 300.0, "minus": 300.0, "joint": 0.7, "damping": 3.0, "crank": 0.3},
    {"stiffness": 1.218, "plus": 40.0, "minus": 300.0, "joint": -0.25},
)


@functools.cache
def points() -> Array:
    """The machines that are computed, shape (`SOBOL` + chosen, unknowns)."""
    chosen = [[{**PRINTED, **changes}[name] for name in NAMES] for changes in CHOSEN]
    return np.vstack([chosen, spread(qmc.Sobol(len(NAMES), seed=SEED).random_base2(7)[:SOBOL])])


def spread(shares: Array) -> Array:
    """Machines from shares of the ranges, shape (n, unknowns), each within 0 .. 1."""
    columns = []
    for unknown, share in zip(UNKNOWNS, np.asarray(shares).T, strict=True):
        low, high = (np.log((unknown.low, unknown.high))) if unknown.is_log else (unknown.low, unknown.high)
        column = low + (high - low) * share
        columns.append(np.exp(column) if unknown.is_log else column)
    return np.column_stack(columns)


def changes_of_machine(machine: Array, run: int) -> dict[str, float]:
    """Key of a case file -> SI value for a machine, in a run of the thesis."""
    scene, of = run_case(run).mechanism, dict(zip(NAMES, map(float, machine), strict=True))
    changes = {
        "follower.bending_stiffness": of["stiffness"] * value_at(scene, "follower.bending_stiffness"),
        "tip.center_of_mass": 0.0254 * of["tip"],
        "follower.damping": of["damping"] * value_at(scene, "follower.damping"),
        "crank.mass": of["crank"] * value_at(scene, "crank.mass"),
    }
    if math.isinf(of["plus"]):
        return changes
    key, value = ("clearance", clearance_of(of["joint"])) if of["joint"] < 0.0 else ("preload", preload_of(of["joint"]))
    return changes | {
        "slider.joint_stiffness_plus": 1e3 * of["plus"],
        "slider.joint_stiffness_minus": 1e3 * of["minus"],
        "slider.contact_damping": of["loss"],
        "follower.material_damping": MATERIAL_DAMPING,
        f"slider.{key}": float(value),
    }


def clearance_of(joint: Array | float) -> Array:
    """Clearance, m."""
    return CLEARANCE * np.maximum(0.0, -joint)


def preload_of(joint: Array | float) -> Array:
    """Preload, N."""
    return PRELOAD * np.maximum(0.0, joint) ** 2


def scene_of(machine: Array, run: int) -> Mechanism:
    """A machine in a run of the thesis."""
    return run_case(run).mechanism_with(changes_of_machine(machine, run))
