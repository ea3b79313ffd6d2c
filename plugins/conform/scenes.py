"""The scenes in which adapters are tried: a mild one that coarse models get right, and the same with one quantity changed at a time.

The first bending frequency is twenty times the crank's, so that the follower bends (3 mm at the tip) and hardly rings: one cubic is 11 %
off in the tip deflection, but 80 % off in the thesis' run 24. The crank is light: its speed varies by a quarter, so that drive and inertias
have an effect. Optional features are absent, so that a mistake in one does not affect other checks. Each change is so large that its effect
exceeds the error of a coarse engine.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, FollowerAlone, Mechanism, SpinUp, TorqueDrive
from quickreturn.reference_model.scene_values import changed
from quickreturn.reference_model.table import Table
from quickreturn.reference_model.tip import FIXED, Tip

OUTPUT_STEP: Final = 1e-3  # s
DURATION: Final = 0.58  # s: a turn of the crank and a little more, so that angles run past a turn
SPEED: Final = 12.0  # of the crank, rad/s

_DRIVE: Final = TorqueDrive(torque=0.6, damping=0.05, initial_speed=SPEED)
_BEAM: Final = Follower(
    length=0.6, mass_per_length=0.33, bending_stiffness=20.0, thickness=3e-3, width=0.04, strain_gauges=(0.14, 0.29, 0.46)
)
BASE: Final = Mechanism(
    pivot_distance=0.42,
    crank=Crank(length=0.11, drive=_DRIVE, mass=1.2, center_of_mass=0.03, inertia=2e-3, initial_angle=math.pi),
    base=Base(inertia=2e-5),
    follower=_BEAM,
    tip=Tip(mass=0.05, inertia=2e-6),
)
#: The mild scene for engines that need a prescribed crank speed.
PRESCRIBED: Final = changed(BASE, {"crank.prescribed_speed": SPEED})
#: A softer follower (N m^2), which bends by 10 mm, so that mistakes of the geometry show; and the time, s, after which its state is a bent
#: start in motion.
SOFT: Final = {"follower.bending_stiffness": 8.0}
UNTIL_BENT: Final = 0.2
#: A crank longer than the distance of the pivots, half a radian before the slider is farthest from P; and 220 deg of the crank, s, in which
#: the arm passes half a turn and a whole one. An angle that wraps or is an inverse tangent of one argument shows in no arm that swings.
LONG_CRANK: Final = {"mechanism.pivot_distance": 0.1, "crank.length": 0.25, "crank.initial_angle": math.pi - 0.5}
TURNED: Final = 0.32
#: The follower clamped to a base that is held, and let go from straight: it sinks by 0.4 % of its length.
CLAMPED: Final = FollowerAlone(spin_up=SpinUp(speed=0.0, time=1.0), base=Base(), follower=BASE.follower, gravity=(0.0, -9.81))
#: The mild scene's follower on a turning base: it bends by a hundredth of its length; and the duration, s, after which the base has turned
#: steadily for a while.
ALONE: Final = FollowerAlone(spin_up=SpinUp(speed=6.0, time=0.4), base=BASE.base, follower=BASE.follower, tip=BASE.tip)
SPUN_UP: Final = 0.6


@dataclass(frozen=True)
class Change:
    """A quantity of the scene, named by its key in a case file, with a new value that an engine must follow."""

    name: str
    given: Mapping[str, Any]  # dotted key -> new value
    context: Mapping[str, Any] = field(default_factory=dict)  # other values that it needs to have an effect, before and after the change
    duration: float = 0.4  # of the motion, s; three quarters of a turn unless another one shows more


_GRAVITY: Final = "mechanism.gravity"
#: Gravity (m/s^2) in a direction that every mistake changes, and a start angle (rad) of the crank other than 180 deg.
_ASLANT: Final = (6.0, -8.0)
_ELSEWHERE: Final = {"crank.initial_angle": 2.0}
_DRIVEN: Final = {"crank.prescribed_speed": SPEED}
_SOFT_JOINT: Final = {"slider.joint_stiffness": 5e3}
_TWO_ROLLERS: Final = {"slider.joint_stiffness_plus": 2e4, "slider.joint_stiffness_minus": 2e4}
_GENTLE_FRICTION: Final = {"slider.friction_speed": 0.1}
#: Duration, s, of less than half a turn, in which the slider does not turn back; it is also long enough for a damping with which explicit
#: solvers need small steps.
_ONE_WAY: Final = 0.2
#: Start angle of the crank, rad, from which the slider moves outwards.
_OUTWARDS: Final = {"crank.initial_angle": 0.2}
_CUT: Final = {"tip.force": (0.0, 1.5), "tip.force_from": math.radians(200.0), "tip.force_to": math.radians(300.0)}
_TABLE: Final = Table(FIXED, (0.3, 1.2, 2.4, 3.1, 4.0, 5.2), ((0.0, -2.0, -4.0, -3.0, 2.0, 0.0), (0.0, 1.0, 1.5, 2.0, 0.5, -0.5)))
#: A motor's curve, and a speed over the crank's turn that varies by a quarter.
_MOTOR: Final = Table(("crank_speed", "crank_torque"), (0.0, 0.7 * SPEED, 1.3 * SPEED), ((0.5, 0.9, -0.4),))
_SPEEDS: Final = Table(("crank_angle", "crank_speed"), (0.3, 1.2, 2.4, 4.0), ((SPEED, 1.1 * SPEED, 0.9 * SPEED, 0.85 * SPEED),))
#: A spring across the follower, beyond its middle; and with stops within its travel.
_SPRING: Final = {"spring.stiffness": 20.0, "spring.anchor": (0.03, -0.35), "spring.place": 0.4, "spring.free_length": 0.35}
_STOPS: Final = {**_SPRING, "spring.shortest": 0.3, "spring.longest": 0.4, "spring.stop_ramp": 0.01, "spring.stop_stiffness": 30.0}

#: Quantities that need no others to have an effect: key -> another value.
_PLAIN: Final[Mapping[str, Any]] = {
    "mechanism.pivot_distance": 0.40, "crank.length": 0.09, "crank.mass": 4.0, "crank.center_of_mass": 0.06, "crank.inertia": 6e-3,
    "crank.initial_angle": 2.3, "crank.initial_speed": 9.0, "crank.torque": 1.2, "crank.damping": 0.1, "crank.prescribed_speed": SPEED,
    "crank.torque_table": _MOTOR, "crank.speed_table": _SPEEDS,
    "base.inertia": 8e-3, "base.damping": 0.1, "base.friction_torque": 0.1, "follower.length": 0.64, "follower.mass_per_length": 0.6,
    "follower.bending_stiffness": 12.0, "follower.thickness": 2e-3, "follower.damping": 8.0, "follower.strain_gauges": (0.08, 0.22, 0.54),
    "tip.mass": 0.12, "tip.inertia": 8e-4, "tip.force_following": (3.0, 1.5), "tip.force_table": _TABLE, "slider.mass": 0.5,
    "slider.inertia": 2e-3, "slider.joint_stiffness": 5e3,
}  # fmt: skip
#: Quantities that do: key -> another value, and the values of the others.
_IN_CONTEXT: Final[Mapping[str, tuple[Any, Mapping[str, Any]]]] = {
    "base.friction_rate": (2.0, {"base.friction_torque": 0.1}),
    "tip.center_of_mass": (-0.08, {"tip.inertia": 8e-4}),  # with everything on it is positive
    "tip.force_from": (math.radians(250.0), _CUT),
    "tip.force_to": (math.radians(250.0), _CUT),
    "tip.force_ramp": (math.radians(45.0), _CUT),
    "tip.force_scale": (2.0, {"tip.force": (0.0, 1.5)}),
    "tip.friction_force": (0.4, {"tip.friction_speed": 0.3}),
    "tip.friction_speed": (3.0, {"tip.friction_force": 0.4}),
    "spring.stiffness": (40.0, _SPRING),
    "spring.anchor": ((0.15, -0.3), _SPRING),
    "spring.place": (0.55, _SPRING),
    "spring.preload": (3.0, {**_SPRING, "spring.free_length": None, "spring.preload_length": 0.35, "spring.preload": 1.0}),
    "spring.damping": (2.0, _SPRING),
    "spring.stop_stiffness": (120.0, _STOPS),
    "slider.joint_damping": (60.0, _SOFT_JOINT),
    "slider.joint_stiffness_plus": (5e3, _TWO_ROLLERS),
    "slider.joint_stiffness_minus": (5e3, _TWO_ROLLERS),
    "slider.clearance": (2e-3, {**_SOFT_JOINT, "slider.joint_damping": 60.0}),
    "slider.preload": (5.0, {"slider.joint_stiffness": 2e3}),
    "slider.contact_damping": (10.0, {"slider.joint_stiffness": 2e3}),
    "slider.friction_force": (2.0, _GENTLE_FRICTION),
    "slider.friction_speed": (0.8, {"slider.friction_force": 2.0}),
}
#: Every quantity that can show in a motion. The width of the section does not.
CHANGES: Final = (
    *(Change(key, {key: value}) for key, value in _PLAIN.items()),
    *(Change(key, {key: value}, context) for key, (value, context) in _IN_CONTEXT.items()),
    Change("mechanism.gravity along n1", {_GRAVITY: (9.81, 0.0)}),
    Change("mechanism.gravity along n2", {_GRAVITY: (0.0, 9.81)}),
    Change("mechanism.gravity with the crank elsewhere", {_GRAVITY: _ASLANT}, _ELSEWHERE),
    Change("mechanism.gravity at a prescribed speed", {_GRAVITY: _ASLANT}, {**_DRIVEN, **_ELSEWHERE}),
    Change("mechanism.gravity on the slider at a prescribed speed", {_GRAVITY: _ASLANT}, {**_DRIVEN, "slider.mass": 0.5}),
    Change("crank.prescribed_speed, reversed", {"crank.prescribed_speed": -SPEED}),
    Change("follower.material_damping", {"follower.material_damping": 2e-3}, duration=_ONE_WAY),
    Change("tip.force along n1", {"tip.force": (6.0, 0.0)}),
    Change("tip.force along n2", {"tip.force": (0.0, 1.5)}),
    Change("slider.friction, the slider moving inwards", {"slider.friction": 0.5}, _GENTLE_FRICTION, _ONE_WAY),
    Change("slider.friction, the slider moving outwards", {"slider.friction": 0.5}, {**_GENTLE_FRICTION, **_OUTWARDS}, _ONE_WAY),
)
_AS_IN_A_MECHANISM: Final = (
    "mechanism.gravity along n1", "mechanism.gravity along n2", "follower.length", "follower.mass_per_length", "follower.bending_stiffness",
    "follower.damping", "follower.material_damping", "tip.mass", "tip.inertia", "tip.center_of_mass",
)  # fmt: skip
#: Those of a follower alone.
CHANGES_ALONE: Final = (
    Change("base.spin_up_speed", {"base.spin_up_speed": 8.0}, duration=SPUN_UP),
    Change("base.spin_up_time", {"base.spin_up_time": 0.3}, duration=SPUN_UP),
    *(replace(change, duration=SPUN_UP) for change in CHANGES if change.name in _AS_IN_A_MECHANISM),
)

#: Optional features of a scene, for a scene with all that an engine accepts: quantities that are right one by one may be wrong in pairs.
FEATURES: Final[tuple[Mapping[str, Any], ...]] = (
    {"crank.initial_angle": 2.3}, {"mechanism.gravity": (5.0, -7.0)}, {"base.damping": 0.03}, {"follower.damping": 2.0},
    {"tip.center_of_mass": 0.06, "tip.inertia": 4e-4}, {"tip.force": (-1.0, 1.5), "tip.force_from": 3.3, "tip.force_to": 5.3},
    {"tip.friction_force": 0.2, "tip.friction_speed": 0.3}, _SPRING, {"spring.damping": 0.5}, {"slider.mass": 0.3},
    {"slider.inertia": 1e-3}, {"slider.joint_stiffness": 2e4}, {"slider.joint_damping": 40.0},
    {"slider.joint_stiffness": math.inf, "slider.joint_stiffness_plus": 2e4, "slider.joint_stiffness_minus": 8e3},
    {"slider.preload": 1.0}, {"slider.contact_damping": 2.0}, {"slider.friction": 0.2, "slider.friction_speed": 0.1},
    {"slider.friction_force": 0.5, "slider.friction_speed": 0.1}, {"base.friction_torque": 0.03}, {"follower.material_damping": 1e-3},
)  # fmt: skip
#: Those of a follower alone.
FEATURES_ALONE: Final[tuple[Mapping[str, Any], ...]] = (
    {"tip.mass": 0.08, "tip.inertia": 8e-4, "tip.center_of_mass": 0.05}, {"follower.damping": 2.0}, {"mechanism.gravity": (4.0, -7.0)}
)  # fmt: skip
