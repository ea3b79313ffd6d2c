"""The scenes in which adapters are tried: a mild one that coarse models get right, and the same with one quantity changed at a time.

The first bending frequency is twenty times the crank's, so that the follower bends (3 mm at the tip) and hardly rings: one cubic is 11 %
off in the tip deflection, but 80 % off in the thesis' run 24. The crank is light: its speed varies by a quarter, so that drive and inertias
have an effect. Optional features are absent, so that a mistake in one does not affect other checks. Each change is so large that its effect
exceeds the error of a coarse engine.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.cases.variation import Variation
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, Mechanism, TorqueDrive
from quickreturn.reference_model.scene_values import changed
from quickreturn.reference_model.tip import ForceTable, Tip

OUTPUT_STEP: Final = 1e-3  # s
DURATION: Final = 0.58  # s: a turn of the crank and a little more, so that angles run past a turn
SPEED: Final = 12.0  # of the crank, rad/s

_TIP: Final = Tip(mass=0.05, inertia=2e-6)
BASE: Final = Mechanism(
    pivot_distance=0.42,
    crank=Crank(
        length=0.11,
        drive=TorqueDrive(torque=0.6, damping=0.05, initial_speed=SPEED),
        mass=1.2,
        center_of_mass=0.03,
        inertia=2e-3,
        initial_angle=math.pi,
    ),
    base=Base(inertia=2e-5),
    follower=Follower(
        length=0.6,
        mass_per_length=0.33,
        bending_stiffness=20.0,
        thickness=3e-3,
        width=0.04,
        strain_gauges=(0.14, 0.29, 0.46),
    ),
    tip=_TIP,
)
#: The mild scene for engines that need a prescribed crank speed.
PRESCRIBED: Final = changed(BASE, {"crank.prescribed_speed": SPEED})


@dataclass(frozen=True)
class Change(Variation):
    """A quantity of the scene, named by its key in a case file, with a new value that an engine must follow."""

    # other values that the quantity needs to have an effect, before and after the change
    context: dict[str, Any] = dataclasses.field(default_factory=dict)
    # mistake with the quantity, in words -> values with which the scene behaves as with this mistake
    alike: dict[str, dict[str, Any]] = dataclasses.field(default_factory=dict)
    duration: float = 0.4  # of the motion, s; three quarters of a turn unless another one shows more

    def mistakes(self) -> list[Variation]:
        """The scene with each mistake of `alike`, and with the quantity half and twice as large."""
        mistakes = [Variation(words, values) for words, values in self.alike.items()]
        if len(self.given) == 1:
            ((path, value),) = self.given.items()
            if isinstance(value, float) and math.isfinite(value):
                half_and_twice = {"half": 0.5 * value, "twice": 2.0 * value}.items()
                mistakes += [Variation(f"{self.name} acts as if it was {words} as large", {path: other}) for words, other in half_and_twice]
        return mistakes


#: A crank of the same inertia without a first moment.
_NO_MOMENT: Final = {"crank.center_of_mass": 0.0, "crank.inertia": BASE.crank.inertia_about_pivot}
_TURNED: Final = "tip.force has the wrong sign, or turns with the follower"
_SOFT_JOINT: Final = {"slider.joint_stiffness": 5e3}
_SOFTER_JOINT: Final = {"slider.joint_stiffness": 2e3}
_TWO_ROLLERS: Final = {"slider.joint_stiffness_plus": 2e4, "slider.joint_stiffness_minus": 2e4}
_EXCHANGED: Final = "the stiffness of the two rollers is exchanged"
_GENTLE_FRICTION: Final = {"slider.friction_speed": 0.1}
#: Duration, s, of less than half a turn, in which the slider does not turn back; it is also long enough for a damping with which explicit
#: solvers need small steps.
_ONE_WAY: Final = 0.2
#: Start angle of the crank, rad, from which the slider moves outwards.
_OUTWARDS: Final = {"crank.initial_angle": 0.2}
_TOOL: Final = {"tip.force": (0.0, 1.5)}
_SLOT: Final = {"tip.force_from": math.radians(200.0), "tip.force_to": math.radians(300.0)}
_WHOLE_TURN: Final = {"tip.force_from": 0.0, "tip.force_to": 2.0 * math.pi}
_CUT: Final = {**_TOOL, **_SLOT}
_FOLLOWING: Final = {"tip.force_following": (3.0, 1.5)}
_TURNED_BACK: Final = {"tip.force_following": (-3.0, -1.5)}
_TABLE: Final = ForceTable((0.3, 1.2, 2.4, 3.1, 4.0, 5.2), (0.0, -2.0, -4.0, -3.0, 2.0, 0.0), (0.0, 1.0, 1.5, 2.0, 0.5, -0.5))
_OF_EXCHANGED_COLUMNS: Final = ForceTable(_TABLE.angles, _TABLE.second, _TABLE.first)
_COLUMNS_EXCHANGED: Final = "the two forces of tip.force_table are exchanged"


_GRAVITY: Final = "mechanism.gravity"


def _gravity(along: str, gravity: tuple[float, float], other: str) -> Change:
    alike: dict[str, dict[str, Any]] = {
        "gravity acts with the wrong sign": {_GRAVITY: (-gravity[0], -gravity[1])},
        f"gravity acts along {other} in place of {along}": {_GRAVITY: gravity[::-1]},
        "gravity does not act on the crank": {_GRAVITY: gravity, **_NO_MOMENT},
    }
    alike[f"gravity acts along minus {other} in place of {along}: it is turned by a quarter"] = {_GRAVITY: (-gravity[1], -gravity[0])}
    return Change(f"mechanism.gravity along {along}", {_GRAVITY: gravity}, alike=alike)


def turned(vector: tuple[float, float], angle: float) -> tuple[float, float]:
    """A vector turned counter-clockwise by an angle, rad."""
    c, s = math.cos(angle), math.sin(angle)
    return c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]


#: Gravity (m/s^2) in a direction that every mistake changes, and a start angle (rad) of the crank other than 180 deg.
_ASLANT: Final = (6.0, -8.0)
_ELSEWHERE: Final = 2.0


#: A spring across the follower, beyond its middle.
SPRING: Final = {"spring.stiffness": 20.0, "spring.anchor": (0.03, -0.35), "spring.place": 0.4, "spring.free_length": 0.35}
#: Stops within its travel.
_STOPS: Final = {**SPRING, "spring.shortest": 0.3, "spring.longest": 0.4, "spring.stop_ramp": 0.01}
_PRELOADED: Final = {**SPRING, "spring.free_length": None, "spring.preload_length": 0.35, "spring.preload": 1.0}


#: Every quantity that can show in a motion. The width of the section does not.
CHANGES: Final = (
    Change("mechanism.pivot_distance", {"mechanism.pivot_distance": 0.40}),
    _gravity("n1", (9.81, 0.0), "n2"),
    _gravity("n2", (0.0, 9.81), "n1"),
    Change(
        "mechanism.gravity with the crank elsewhere",
        {_GRAVITY: _ASLANT},
        {"crank.initial_angle": _ELSEWHERE},
        {
            "gravity acts with the wrong sign": {_GRAVITY: (-_ASLANT[0], -_ASLANT[1])},
            "gravity along n1 has the wrong sign": {_GRAVITY: (-_ASLANT[0], _ASLANT[1])},
            "gravity along n2 has the wrong sign": {_GRAVITY: (_ASLANT[0], -_ASLANT[1])},
            "gravity along n1 and n2 is exchanged": {_GRAVITY: _ASLANT[::-1]},
            "gravity is turned by a quarter, counter-clockwise": {_GRAVITY: (-_ASLANT[1], _ASLANT[0])},
            "gravity is turned by a quarter, clockwise": {_GRAVITY: (_ASLANT[1], -_ASLANT[0])},
            "gravity turns with the crank's angle at the start": {_GRAVITY: turned(_ASLANT, _ELSEWHERE - math.pi)},
            "gravity turns against the crank's angle at the start": {_GRAVITY: turned(_ASLANT, math.pi - _ELSEWHERE)},
            "gravity does not act on the crank": {_GRAVITY: _ASLANT, **_NO_MOMENT},
        },
    ),
    Change(
        "mechanism.gravity at a prescribed speed",
        {_GRAVITY: _ASLANT},
        {"crank.prescribed_speed": SPEED, "crank.initial_angle": _ELSEWHERE},
        {
            "gravity does not act on the crank": {_GRAVITY: _ASLANT, **_NO_MOMENT},
            "the crank's weight has the wrong sign": {_GRAVITY: _ASLANT, "crank.center_of_mass": -BASE.crank.center_of_mass},
            "the crank's weight is taken at the slider": {
                _GRAVITY: _ASLANT,
                "crank.center_of_mass": BASE.crank.length,
                "crank.inertia": 0.0,
            },
        },
    ),
    Change(
        "mechanism.gravity on the slider at a prescribed speed",
        {_GRAVITY: _ASLANT},
        {"crank.prescribed_speed": SPEED, "slider.mass": 0.5},
    ),
    Change("crank.length", {"crank.length": 0.09}),
    Change("crank.mass", {"crank.mass": 4.0}),
    Change("crank.center_of_mass", {"crank.center_of_mass": 0.06}),
    Change("crank.inertia", {"crank.inertia": 6e-3}),
    Change("crank.initial_angle", {"crank.initial_angle": 2.3}),
    Change("crank.initial_speed", {"crank.initial_speed": 9.0}),
    Change("crank.torque", {"crank.torque": 1.2}),
    Change("crank.damping", {"crank.damping": 0.1}),
    Change("crank.prescribed_speed", {"crank.prescribed_speed": SPEED}),
    Change("crank.prescribed_speed, reversed", {"crank.prescribed_speed": -SPEED}),
    Change("base.inertia", {"base.inertia": 8e-3}),
    Change("base.damping", {"base.damping": 0.1}),
    Change("base.friction_torque", {"base.friction_torque": 0.1}),
    Change("base.friction_rate", {"base.friction_rate": 2.0}, {"base.friction_torque": 0.1}),
    Change("follower.length", {"follower.length": 0.64}),
    Change("follower.mass_per_length", {"follower.mass_per_length": 0.6}),
    Change("follower.bending_stiffness", {"follower.bending_stiffness": 12.0}),
    Change("follower.thickness", {"follower.thickness": 2e-3}),
    Change(
        "follower.damping",
        {"follower.damping": 8.0},
        alike={
            "follower.damping is taken for the damping of the base": {"base.damping": 8.0},
            "follower.damping acts on velocities in the fixed frame, not relative to the base": {
                "follower.damping": 8.0,
                "base.damping": 8.0 * BASE.follower.length**3 / 3.0,  # its moment on a follower that turns as a rigid body
            },
        },
    ),
    Change("follower.material_damping", {"follower.material_damping": 2e-3}, duration=_ONE_WAY),
    Change("follower.strain_gauges", {"follower.strain_gauges": (0.08, 0.22, 0.54)}),
    Change("tip.mass", {"tip.mass": 0.12}),
    Change("tip.inertia", {"tip.inertia": 8e-4}),
    Change(
        "tip.center_of_mass",
        {"tip.center_of_mass": -0.08},  # with everything on it is positive
        {"tip.inertia": 8e-4},
        alike={
            "tip.center_of_mass is measured towards the pivot, not beyond the end, or without its sign": {"tip.center_of_mass": 0.08},
            "tip.inertia is shifted to the flexible end twice": {"tip.center_of_mass": -0.08, "tip.inertia": 8e-4 + _TIP.mass * 0.08**2},
            "tip.inertia is taken about the flexible end": {"tip.center_of_mass": -0.08, "tip.inertia": 8e-4 - _TIP.mass * 0.08**2},
        },
    ),
    Change("tip.force along n1", {"tip.force": (6.0, 0.0)}, alike={_TURNED: {"tip.force": (-6.0, 0.0)}}),
    Change("tip.force along n2", {"tip.force": (0.0, 1.5)}, alike={_TURNED: {"tip.force": (0.0, -1.5)}}),
    Change("tip.force_from", {"tip.force_from": math.radians(250.0)}, _CUT, {"the force acts over the whole turn": _WHOLE_TURN}),
    Change("tip.force_to", {"tip.force_to": math.radians(250.0)}, _CUT, {"the force acts over the whole turn": _WHOLE_TURN}),
    Change("tip.force_ramp", {"tip.force_ramp": math.radians(45.0)}, _CUT),
    Change("tip.force_following", _FOLLOWING, alike={"tip.force_following has the wrong sign, or keeps its direction": _TURNED_BACK}),
    Change("tip.force_table", {"tip.force_table": _TABLE}, alike={_COLUMNS_EXCHANGED: {"tip.force_table": _OF_EXCHANGED_COLUMNS}}),
    Change("tip.force_scale", {"tip.force_scale": 2.0}, _TOOL),
    Change("tip.friction_force", {"tip.friction_force": 0.4}, {"tip.friction_speed": 0.3}),
    Change("tip.friction_speed", {"tip.friction_speed": 3.0}, {"tip.friction_force": 0.4}),
    Change("spring.stiffness", {"spring.stiffness": 40.0}, SPRING),
    Change(
        "spring.anchor",
        {"spring.anchor": (0.15, -0.3)},
        SPRING,
        {"the fixed point of the spring is measured from P": {"spring.anchor": (0.15 + BASE.pivot_distance, -0.3)}},
    ),
    Change("spring.place", {"spring.place": 0.55}, SPRING, {"the spring acts at the end": {"spring.place": BASE.follower.length}}),
    Change("spring.preload", {"spring.preload": 3.0}, _PRELOADED),
    Change("spring.damping", {"spring.damping": 2.0}, SPRING),
    Change("spring.stop_stiffness", {"spring.stop_stiffness": 120.0}, {**_STOPS, "spring.stop_stiffness": 30.0}),
    Change("slider.mass", {"slider.mass": 0.5}),
    Change("slider.inertia", {"slider.inertia": 2e-3}),
    Change("slider.joint_stiffness", _SOFT_JOINT),
    Change("slider.joint_damping", {"slider.joint_damping": 60.0}, _SOFT_JOINT),
    Change(
        "slider.joint_stiffness_plus",
        {"slider.joint_stiffness_plus": 5e3},
        _TWO_ROLLERS,
        {_EXCHANGED: {"slider.joint_stiffness_plus": 2e4, "slider.joint_stiffness_minus": 5e3}},
    ),
    Change(
        "slider.joint_stiffness_minus",
        {"slider.joint_stiffness_minus": 5e3},
        _TWO_ROLLERS,
        {_EXCHANGED: {"slider.joint_stiffness_plus": 5e3, "slider.joint_stiffness_minus": 2e4}},
    ),
    Change("slider.clearance", {"slider.clearance": 2e-3}, {**_SOFT_JOINT, "slider.joint_damping": 60.0}),
    Change(
        "slider.preload",
        {"slider.preload": 5.0},
        _SOFTER_JOINT,
        {"slider.preload holds the slider on the line, whatever the stiffness": {"slider.joint_stiffness": math.inf}},
    ),
    Change(
        "slider.contact_damping",
        {"slider.contact_damping": 10.0},
        _SOFTER_JOINT,
        {"slider.contact_damping acts whether a roller is pressed or not": {"slider.joint_damping": 10.0 * 2e3 * 2e-3}},
    ),
    Change("slider.friction, the slider moving inwards", {"slider.friction": 0.5}, _GENTLE_FRICTION, duration=_ONE_WAY),
    Change("slider.friction, the slider moving outwards", {"slider.friction": 0.5}, {**_GENTLE_FRICTION, **_OUTWARDS}, duration=_ONE_WAY),
    Change("slider.friction_force", {"slider.friction_force": 2.0}, _GENTLE_FRICTION),
    Change("slider.friction_speed", {"slider.friction_speed": 0.8}, {"slider.friction_force": 2.0}),
)  # fmt: skip

#: A softer follower (N m^2), which bends by 10 mm, so that mistakes of the geometry show.
SOFT: Final = {"follower.bending_stiffness": 8.0}
#: Time, s, after which its state serves as a bent start in motion.
UNTIL_BENT: Final = 0.2
