"""What the thesis does not print, or what it may have tuned: the unknowns of the inference, their ranges, and the points to compute.

A machine is a row of numbers in the units of `UNKNOWNS`. One number, `joint`, is clearance below 0 and preload above it, because a joint
with clearance has no preload; by its square small preloads are more frequent than large ones.
"""

import functools
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Final

import numpy as np
from scipy.stats import qmc

from quickreturn.cases.library.thesis import run_case
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import value_at


@dataclass(frozen=True)
class Unknown:
    """A quantity that the thesis leaves open, with the range in which it is sampled."""

    name: str
    words: str  # for people, with the unit
    low: float
    high: float
    printed: float  # of the model as published
    reason: str  # why this range
    is_log: bool = False


_DATA: Final = tomllib.loads((files(__package__) / "unknowns.toml").read_text("utf-8"))
UNKNOWNS: Final = tuple(Unknown(**entry) for entry in _DATA["unknown"])
NAMES: Final = tuple(unknown.name for unknown in UNKNOWNS)
PRINTED: Final[Mapping[str, float]] = {unknown.name: unknown.printed for unknown in UNKNOWNS}
#: Clearance (m) at `joint` = -1, preload (N) at `joint` = 1.
CLEARANCE: Final = 2e-4
PRELOAD: Final = 30.0
#: Damping of the follower's material, s, of all machines with rollers: without it impacts set modes ringing that nothing stops.
MATERIAL_DAMPING: Final = 2e-5
#: Number of Sobol points, and the seed of their scrambling.
SOBOL: Final = 96
SEED: Final = 1999


@functools.cache
def points() -> Array:
    """The machines that are computed, shape (`SOBOL` + chosen, unknowns)."""
    chosen = [[{**PRINTED, **changes}[name] for name in NAMES] for changes in _DATA["chosen"]]
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
