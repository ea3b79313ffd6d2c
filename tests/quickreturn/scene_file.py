"""A small case file: run 24 of the thesis in other units, a tenth of a second long."""

SCENE = """
name = "small"
title = "A small scene"

[mechanism]
pivot_distance = "457.2 mm"

[crank]
length = "101.6 mm"
mass = "17.5 kg"
center_of_mass = "76.2 mm"
inertia = "4.5e-5 kg*m^2"
torque = "1.13 N*m"
damping = "0.068 N*m*s/rad"
initial_angle = "180 deg"

[base]
inertia = "1.7e-5 kg*m^2"
damping = "2.3e-6 N*m*s/rad"

[follower]
length = "635 mm"
mass_per_length = "0.328 kg/m"
bending_stiffness = "6.1 N*m^2"
thickness = "3.175 mm"
width = "38.1 mm"
damping = "0.138 N*s/m^2"
strain_gauges = ["158.75 mm", "317.5 mm", "476.25 mm"]

[simulation]
duration = "100 ms"
output_step = "1 ms"
"""
