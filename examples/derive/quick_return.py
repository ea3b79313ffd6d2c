"""The quick-return of the thesis, its follower in one cubic, in shapes that stay, in shapes that follow."""

from collections.abc import Callable
from math import pi

import casadi as ca

from quickreturn.derive import Beam, System, turned, vector

#: Beam and place of the slider, of a system, the slider's coordinate, and what all followers share.
Follower = Callable[..., tuple[Beam, ca.SX, ca.SX]]


def quick_return(follower: Follower) -> System:
    """Run 24: crank 4 in, six plates at the tip, 16.6 rad/s."""
    system = System("quick-return")
    p = system.constants(
        pivot_distance=(18, "in"), crank_length=(4, "in"), length=(25, "in"),
        crank_mass=(0.1, "lbf*s^2/in"), crank_center_of_mass=(3, "in"), crank_inertia=(4e-4, "lbf*s^2*in"),
        crank_torque=(10, "lbf*in"), crank_damping=(0.60176535, "lbf*in*s/rad"),
        base_inertia=(1.5e-4, "lbf*s^2*in"), base_damping=(2e-5, "lbf*in*s/rad"),
        mass_per_length=(4.75987e-5, "lbf*s^2/in^2"), bending_stiffness=(2128.22, "lbf*in^2"),
        beam_damping=(2e-5, "lbf*s/in^2"), tip_mass=(2.9e-4, "lbf*s^2/in"), tip_inertia=(1.96e-5, "lbf*s^2*in"),
        tip_center_of_mass=(0, "in"), slider_mass=(0, "kg"), slider_inertia=(0, "kg*m^2"),
        gravity_1=(0, "m/s^2"), gravity_2=(0, "m/s^2"), force_1=(0, "N"), force_2=(0, "N"),
    )  # fmt: skip
    system.gravity = vector(p.gravity_1, p.gravity_2)
    q1 = system.coordinate("crank_angle", "rad", rate="crank_speed")
    q2 = system.coordinate("follower_angle", "rad", guess=pi)
    s = system.coordinate("slider_position", "m", guess=0.5)
    beam, slider, slope = follower(
        system, s, p, name="follower", origin=vector(p.pivot_distance, 0), angle=q2,
        mass_per_length=p.mass_per_length, damping=p.beam_damping,
    )  # fmt: skip
    crank_tip, end, turn = turned(q1, p.crank_length), beam.end(), beam.end_slope()
    system.body("crank", p.crank_mass, turned(q1, p.crank_center_of_mass), p.crank_inertia, q1)
    system.body("slider", p.slider_mass, crank_tip, p.slider_inertia, slope)
    system.body("base", inertia=p.base_inertia, angle=q2)
    system.body("tip", p.tip_mass, end + turned(turn, p.tip_center_of_mass), p.tip_inertia, turn)
    system.load("motor", q1, p.crank_torque)
    system.load("tool", end, vector(p.force_1, p.force_2))
    system.damper("crank bearing", q1, p.crank_damping)
    system.damper("pivot", q2, p.base_damping)
    force = system.loop("slider", slider - crank_tip, gives=[q2, s])
    return system


def one_cubic(system: System, s: ca.SX, p, **common) -> tuple[Beam, ca.SX, ca.SX]:
    """The thesis' follower: deflection and slope of the tip, foreshortening to second order."""
    w, slope = system.coordinate("tip_deflection", "m"), system.coordinate("tip_slope", "rad")

    def deflection(x):
        u = x / p.length
        return (3 * u**2 - 2 * u**3) * w + p.length * (u**3 - u**2) * slope

    beam = Beam(system, edges=[0, p.length], deflection=deflection, bending_stiffness=p.bending_stiffness, **common)
    return beam, beam.place(s), beam.slope(s)


def one_cubic_bent(system: System, s: ca.SX, p, **common) -> tuple[Beam, ca.SX, ca.SX]:
    """The same cubic as the angle of the tangent: places without approximation."""
    w, slope = system.coordinate("tip_deflection", "m"), system.coordinate("tip_slope", "rad")
    now = system.freeze(s)

    def tangent(x):
        u = x / p.length
        return 6 * (u - u**2) / p.length * w + (3 * u**2 - 2 * u) * slope

    beam = Beam(system, edges=[0, now, p.length], tangent=tangent, bending_stiffness=p.bending_stiffness, points=7, **common)
    kappa = ca.jtimes(tangent(now), now, 1)
    return beam, beam.slider(0, s - now, kappa), beam.end_slope(0)


def following(tables) -> Follower:
    """Natural modes of the follower supported at the slider, which they follow, from tables in s."""

    def follower(system: System, s: ca.SX, p, **common) -> tuple[Beam, ca.SX, ca.SX]:
        now, n = system.freeze(s), tables.modes
        eta = system.amplitudes("eta", n, "kg**0.5*m", size=1e-3)
        table = system.table(s, tables.low, tables.step, tables.coefficients)
        psi = ca.reshape(table.function("1/(kg**0.5*m)", *tables.psi), -1, n)
        beam = Beam(
            system, edges=[0, now, p.length], tangent=lambda x: ca.mtimes(psi, eta), points=tables.points, **common
        )
        system.energy("bending", 0.5 * ca.dot(table.function("1/s**2", *tables.squares), eta**2))
        kappa = ca.dot(table.function("1/(kg**0.5*m**2)", tables.curvature), eta)
        return beam, beam.slider(0, s - now, kappa), beam.end_slope(0)

    return follower


class Modes:
    """Where the columns of the project's tables of shapes that follow are."""

    def __init__(self, t, n):
        self.low, self.step, self.coefficients, self.modes, self.points = t.low, t.step, t.coefficients, n, t.G
        import numpy as np
        N = t.cells * t.S
        blocks = np.arange(t.kinds * n * N).reshape(t.kinds, n, t.cells, t.S)[:, :, :, : t.G + 1]
        self.psi = [block.ravel().tolist() for block in blocks]
        extras = t.kinds * n * N + np.arange(5 * n).reshape(5, n)
        self.squares, self.curvature = extras[:2].tolist(), extras[2].tolist()
