"""The quick-return of the thesis: a follower of one cubic."""

from collections.abc import Callable
from math import pi

import casadi as ca

from quickreturn.derive import Beam, System, turned, vector

#: Of a system, the slider's arc length, the constants: beam, the slider's place and angle, and the
#: tangent there.
Follower = Callable[..., tuple[Beam, ca.SX, ca.SX, ca.SX]]


def quick_return(follower: Follower) -> System:
    """Run 24: crank 4 in, six plates, 16.6 rad/s."""
    system = System("quick-return")
    p = system.constants(
        pivot_distance=(18, "in"), crank_length=(4, "in"), length=(25, "in"),
        crank_mass=(0.1, "lbf*s^2/in"), crank_center_of_mass=(3, "in"),
        crank_inertia=(4e-4, "lbf*s^2*in"), crank_torque=(10, "lbf*in"),
        crank_damping=(0.60176535, "lbf*in*s/rad"), beam_damping=(2e-5, "lbf*s/in^2"),
        base_inertia=(1.5e-4, "lbf*s^2*in"), base_damping=(2e-5, "lbf*in*s/rad"),
        mass_per_length=(4.75987e-5, "lbf*s^2/in^2"), bending_stiffness=(2128.22, "lbf*in^2"),
        tip_mass=(2.9e-4, "lbf*s^2/in"), tip_inertia=(1.96e-5, "lbf*s^2*in"),
        tip_center_of_mass=(0, "in"), slider_mass=(0, "kg"), slider_inertia=(0, "kg*m^2"),
        gravity_1=(0, "m/s^2"), gravity_2=(0, "m/s^2"), force_1=(0, "N"), force_2=(0, "N"),
    )  # fmt: skip
    system.gravity = vector(p.gravity_1, p.gravity_2)
    q1 = system.coordinate("crank_angle", "rad", rate="crank_speed")
    q2 = system.coordinate("follower_angle", "rad", guess=pi)
    s = system.coordinate("slider_position", "m", guess=0.5)
    pivot, crank_tip = vector(p.pivot_distance, 0), turned(q1, p.crank_length)
    beam, slider, slope, tangent = follower(
        system, s, p, origin=pivot, angle=q2,
        mass_per_length=p.mass_per_length, damping=p.beam_damping,
    )  # fmt: skip
    end, turn = beam.end(), beam.end_slope()
    system.body("crank", p.crank_mass, turned(q1, p.crank_center_of_mass), p.crank_inertia, q1)
    system.body("slider", p.slider_mass, crank_tip, p.slider_inertia, slope)
    system.body("base", inertia=p.base_inertia, angle=q2)
    system.body("tip", p.tip_mass, end + turned(turn, p.tip_center_of_mass), p.tip_inertia, turn)
    system.load("motor", q1, p.crank_torque)
    system.load("tool", end, vector(p.force_1, p.force_2))
    system.damper("crank bearing", q1, p.crank_damping)
    system.damper("pivot", q2, p.base_damping)
    force, arm = system.loop("slider", slider - crank_tip, gives=[q2, s]), slider - pivot
    # by the moment about P: what few shapes that follow leave along the tangent has next to none
    moment = arm[0] * force[1] - arm[1] * force[0]
    system.output("slider_force", moment / ca.dot(arm, tangent), "N")
    system.output("tip_x", end[0], "m")
    system.output("tip_y", end[1], "m")
    return system


def one_cubic(system, s, p, **common):
    """The thesis' follower: deflection and slope of the tip, foreshortening to second order."""
    w, slope = system.coordinate("tip_deflection", "m"), system.coordinate("tip_slope", "rad")

    def deflection(x):
        u = x / p.length
        return (3 * u**2 - 2 * u**3) * w + p.length * (u**3 - u**2) * slope

    beam = Beam(
        system, "follower", edges=[0, p.length], deflection=deflection,
        bending_stiffness=p.bending_stiffness, **common,
    )  # fmt: skip
    place, along = beam.place(s), ca.jtimes(beam.place(s), s, 1)
    return beam, place, beam.slope(s), along / ca.norm_2(along)
