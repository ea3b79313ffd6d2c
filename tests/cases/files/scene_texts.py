"""A case file in inches, the same in SI, and what tests do with their text."""

from dataclasses import astuple, is_dataclass

import pytest

from quickreturn.cases.files.case import parse_case
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

# The same scene, each number converted by hand with 1 in = 0.0254 m and 1 lbf = 4.4482216152605 N; decimals are exact.
IN_SI = """\
name = "scene"
title = "A scene"
tags = ["test"]

[mechanism]
pivot_distance = "0.4572 m"
gravity = ["0 m/s^2", "-9.8044 m/s^2"]

[crank]
length = "101.6 mm"
mass = "17.51268352464763779527559055118 kg"
center_of_mass = "76.2 mm"
inertia = "4.519393161104668e-5 kg*m^2"
torque = "1.129848290276167 N*m"
damping = "0.06799035518449393052845 N*m*s/rad"
initial_angle = "3.14159265358979323846 rad"
initial_speed = "16.617773 rad/s"

[base]
inertia = "1.6947724354142505e-5 kg*m^2"
damping = "2.259696580552334e-6 N*m*s"

[follower]
length = "0.635 m"
mass_per_length = "0.32818148397033291316 kg/m"
bending_stiffness = "6.1075969499621216987996 N*m^2"
thickness = "3.175 mm"
width = "3.81 cm"
damping = "0.1378951458633672 N*s/m^2"
strain_gauges = ["0.15875 m", "0.3175 m", "0.47625 m"]

[tip]
mass = "50.786782221478149606299212598422 g"
inertia = "2.21450264894128732e-6 kg*m^2"
center_of_mass = "1.27 cm"
force = ["0.44482216152605 N", "-88.96443230521 mN"]
force_from = "3.49065850398865915385 rad"
force_to = "5.75958653158128760385 rad"
force_ramp = "0.20943951023931954923 rad"

[slider]
mass = "1.751268352464763779527559055118 kg"
inertia = "1.129848290276167e-5 kg*m^2"
joint_stiffness = "17.51268352464763779527559055118 kN/m"
joint_damping = "17.51268352464763779527559055118 N*s/m"

[simulation]
duration = "2000 ms"
output_step = "0.001 s"
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
