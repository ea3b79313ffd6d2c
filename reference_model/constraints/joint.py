"""What stands for the slider's constraint: one type for all methods, so that the equations are compiled once."""

from typing import Final, NamedTuple

#: How the slider force reaches the follower, and how the slider's place follows from the follower's.
CONSISTENT: Final = 0  # both by the shapes: force and motion are conjugate
LEVER: Final = 1  # force on the two nodes of the element by the lever rule, place by the shapes: not conjugate
BOTH_LINEAR: Final = 2  # force by the lever rule, the slider rides on the chords between nodes: conjugate


class Joint(NamedTuple):
    """Made by `multiplier`, `stiff_spring` or `nodal_load`."""

    is_spring: bool  # a spring and damper, or a force that keeps the gap closed
    stiffness: float  # N/m
    damping: float  # N s/m
    stabilization: float  # 1/s, rate at which a gap decays where no spring closes it
    distribution: int
    bending_damping: float  # s, ratio of damping moment to elastic moment per curvature rate; only nodal loads need it
