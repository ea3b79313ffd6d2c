"""A case file in inches, and what tests do with its text."""

from collections.abc import Mapping
from dataclasses import astuple, is_dataclass

import pytest

from quickreturn.cases.files.case import Case, case_of
from quickreturn.cases.files.document import read_document
from quickreturn.cases.files.errors import CaseError

SCENE = """\
name = "scene"
title = "A scene"
tags = ["test"]

[mechanism]
pivot_distance = "18 in"
gravity = ["0 in/s^2", "-386 in/s^2"]

[crank]
length = "4 in"
mass = "0.1 lbf*s^2/in"
center_of_mass = "3 in"
inertia = "4.0e-4 lbf*s^2*in"
torque = "10 lbf*in"
damping = "0.60176535 lbf*in*s/rad"
initial_angle = "180 deg"
initial_speed = "16.617773 rad/s"

[base]
inertia = "1.5e-4 lbf*s^2*in"
damping = "2e-5 lbf*in*s/rad"

[follower]
length = "25 in"
mass_per_length = "4.75987e-5 lbf*s^2/in^2"
bending_stiffness = "2128.22 lbf*in^2"
thickness = "0.125 in"
width = "1.5 in"
damping = "2e-5 lbf*s/in^2"
strain_gauges = ["6.25 in", "12.5 in", "18.75 in"]

[tip]
mass = "2.90e-4 lbf*s^2/in"
inertia = "1.96e-5 lbf*s^2*in"
center_of_mass = "0.5 in"
force = ["0.1 lbf", "-0.02 lbf"]
force_from = "200 deg"
force_to = "330 deg"
force_ramp = "12 deg"

[slider]
mass = "0.01 lbf*s^2/in"
inertia = "1e-4 lbf*s^2*in"
joint_stiffness = "100 lbf/in"
joint_damping = "0.1 lbf*s/in"

[simulation]
duration = "2 s"
output_step = "1 ms"
"""


def changed(old: str, new: str) -> str:
    assert SCENE.count(old) == 1, old
    return SCENE.replace(old, new)


def message(text: str) -> str:
    with pytest.raises(CaseError) as refused:
        parse_case(text, "scene.toml")
    return str(refused.value)


def numbers(value: object) -> list[float]:
    """All numbers in a tree of dataclasses and tuples, in order."""
    if is_dataclass(value) and not isinstance(value, type):
        value = astuple(value)
    if isinstance(value, tuple):
        return [number for item in value for number in numbers(item)]
    return [float(value)] if isinstance(value, float) else []


def parse_case(text: str, source: str, overrides: Mapping[str, str] | None = None) -> Case:
    """The case that the text of a file describes, with changed values."""
    return case_of(read_document(text, source).overridden_by(overrides or {}))
