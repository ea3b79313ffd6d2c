"""Spin-up of a cantilever.

T. R. Kane, R. R. Ryan and A. K. Banerjee, Journal of Guidance, Control, and Dynamics 10
(1987); with these numbers J. C. Simo and L. Vu-Quoc, Journal of Applied Mechanics 53 (1986).
"""

import casadi as ca

from quickreturn.derive import Beam, System, vector


def spin_up(shapes: int = 5) -> System:
    """The base turns from rest to 6 rad/s within 15 s; the beam bends in `shapes` powers of x/L."""
    system = System("spin-up")
    p = system.constants(
        length=(10, "m"), mass_per_length=(1.2, "kg/m"), bending_stiffness=(14, "kN*m^2"),
        speed=(6, "rad/s"), duration=(15, "s"),
    )  # fmt: skip
    t, period = system.time, p.duration / (2 * ca.pi)
    begun = t**2 / 2 + period**2 * (ca.cos(t / period) - 1)
    after = p.duration * (t - p.duration / 2)
    angle = p.speed / p.duration * ca.if_else(t < p.duration, begun, after)
    eta = system.amplitudes("eta", shapes, "rad", size=0.01)
    beam = Beam(
        system, "beam", origin=vector(0, 0), angle=angle, edges=[0, p.length / 2, p.length],
        tangent=lambda x: sum(eta[k] * (x / p.length) ** (k + 1) for k in range(shapes)),
        mass_per_length=p.mass_per_length, bending_stiffness=p.bending_stiffness,
    )  # fmt: skip
    end = beam.end()
    system.output("base_angle", angle, "rad")
    system.output("tip_deflection", ca.cos(angle) * end[1] - ca.sin(angle) * end[0], "m")
    return system
