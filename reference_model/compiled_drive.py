"""The drive of the crank in compiled equations, for any parameters that hold `constants.drive_constants`."""

from typing import Any, Final

from quickreturn.reference_model.native.compilation import inner
from quickreturn.reference_model.table import table_value

value_of = inner(table_value)
#: Decay of a difference from the prescribed speed by integration, 1/rad of the crank's angle: far slower than a step.
KEPT: Final = 16.0


@inner
def given_torque(p: Any, speed: float) -> tuple[float, float]:
    """Torque on a free crank at its speed (rad/s), N m, and its derivative by the speed, without the damping."""
    return (p.torque, 0.0) if len(p.drive_table) == 0 or p.drive_way != 0.0 else value_of(speed, p.drive_table, 0.0)


@inner
def prescribed_acceleration(p: Any, angle: float, speed: float) -> float:
    """Acceleration (rad/s^2) that a table of speeds prescribes at the crank's angle (rad) and speed (rad/s); 0 without one."""
    if p.drive_way == 0.0:
        return 0.0
    kept, slope = value_of(p.drive_way * (angle - p.drive_begin), p.drive_table, p.drive_period)
    return speed * p.drive_way * slope + KEPT * abs(speed) * (kept - speed)
