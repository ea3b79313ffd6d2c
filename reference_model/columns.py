"""What the models tell of every instant, in the order in which compiled code lays it down; `time` is added by the caller."""

from typing import Final

COLUMNS: Final = (
    "crank_angle",
    "crank_speed",
    "follower_angle",
    "slider_position",
    "tip_x",
    "tip_y",
    "tip_deflection",
    "tip_acceleration",
    "strain_1",
    "strain_2",
    "strain_3",
    "slider_force",
    "crank_torque",
    "kinetic_energy",
    "strain_energy",
    "dissipated_energy",
    "constraint_gap",
    "gravity_energy",
    "drive_work",
)
#: Of the follower alone on a base that turns as prescribed.
FOLLOWER_COLUMNS: Final = (
    "follower_angle",
    "tip_x",
    "tip_y",
    "tip_deflection",
    "tip_acceleration",
    "strain_1",
    "strain_2",
    "strain_3",
    "base_torque",
    "kinetic_energy",
    "strain_energy",
    "dissipated_energy",
    "gravity_energy",
    "drive_work",
)
#: What an open loop's joint does: rate of the gap (m/s), power of the slider's force on crank and follower together (W).
JOINT_COLUMNS: Final = ("gap_rate", "joint_power")
