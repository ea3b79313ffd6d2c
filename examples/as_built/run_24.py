"""Run 24 in SI units, and what the constructions of both programs share."""

import csv
import sys
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

#: Run 24, SI, with material damping (s) in place of damping against the base.
SCENE: Final = {
    "pivot_distance": 0.4572,
    "crank_length": 0.1016,
    "crank_mass": 17.5126835,
    "crank_center": 0.0762,
    "crank_inertia": 4.51939316e-05,
    "torque": 1.12984829,
    "crank_damping": 0.0679903552,
    "crank_speed": 16.617773,
    "base_inertia": 1.69477244e-05,
    "base_damping": 2.25969658e-06,
    "length": 0.635,
    "mass_per_length": 0.328181484,
    "bending_stiffness": 6.10759695,
    "thickness": 0.003175,
    "width": 0.0381,
    "material_damping": 1e-4,
    "tip_mass": 0.0507867822,
    "tip_inertia": 2.21450265e-06,
}
#: From P to the crank's pin at the start, m.
REACH: Final = SCENE["pivot_distance"] + SCENE["crank_length"]
#: Angular speed of the follower at the start, rad/s.
TURNING: Final = SCENE["crank_speed"] * SCENE["crank_length"] / REACH


def write_table(machines: Mapping[str, Any], simulate: Callable[[Any], Any]) -> None:
    """What the arguments of the command line ask for: the names, or a table of one construction."""
    name, *file_name = sys.argv[1:] or [""]
    if name not in machines or len(file_name) != 1:
        return print(*machines, sep="\n")
    columns, _ = simulate(machines[name])
    with open(file_name[0], "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([list(columns), *np.array(list(columns.values())).T.tolist()])
    return None
