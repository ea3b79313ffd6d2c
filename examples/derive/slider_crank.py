"""The slider-crank with a flexible rod of the Test Set for Initial Value Problem Solvers.

B. Simeon, Modelling a flexible slider crank mechanism by a mixed system of DAEs and PDEs,
Mathematical Modelling of Systems 2 (1996) 1-18. The rod bends in two sines and stretches in a
quadratic element. The set's program `crank.f` gives the stretch fifteen times its consistent
inertia, and pi eight digits, whose fourth power is in the bending stiffness; `consistent` does not.
"""

from math import pi

import casadi as ca
import numpy as np

from quickreturn.derive import Beam, System, turned


def slider_crank(consistent: bool = False) -> System:
    """Crank at 150 rad/s; no gravity, no damping."""
    system = System("slider-crank of the IVP test set")
    p = system.constants(
        crank_length=(0.15, "m"), crank_inertia=(0.002727, "kg*m^2"), speed=(150, "rad/s"),
        rod_length=(0.3, "m"), rod_side=(8, "mm"), density=(7870, "kg/m^3"), modulus=(0.2e12, "Pa"),
        rod_inertia=(0.0045339259, "kg*m^2"), block_mass=(0.075552, "kg"),
    )  # fmt: skip
    phi1, phi2 = system.coordinate("phi1", "rad"), system.coordinate("phi2", "rad")
    x3, L = system.coordinate("x3", "m"), p.rod_length
    bend = system.amplitudes("bend", 2, "m", size=1e-4)
    stretch = system.amplitudes("stretch", 2, "m", size=1e-5)

    def deflection(x):
        return bend[0] * ca.sin(pi * x / L) + bend[1] * ca.sin(2 * pi * x / L)

    def lengthening(x):
        return stretch[0] * 4 * x / L * (1 - x / L) + stretch[1] * x / L * (2 * x / L - 1)

    section, mass = p.rod_side**2, p.density * p.rod_side**2
    rounded = 1 if consistent else (3.1415927 / pi) ** 4
    bending = p.modulus * section * p.rod_side**2 / 12 * rounded
    rod = Beam(
        system, "rod", origin=turned(phi1, p.crank_length), angle=phi2, edges=[0, L], points=12,
        deflection=deflection, stretch=lengthening, foreshortening=False,
        mass_per_length=mass, bending_stiffness=bending, axial_stiffness=p.modulus * section,
    )  # fmt: skip
    system.body("crank", inertia=p.crank_inertia, angle=phi1)
    system.body("thickness of the rod", inertia=p.rod_inertia - mass * L**3 / 3, angle=phi2)
    system.body("block", mass=p.block_mass, place=turned(0.0, x3))
    for u, weight in [] if consistent else zip(*np.polynomial.legendre.leggauss(4), strict=True):
        place = turned(phi2, lengthening((u + 1) * L / 2))
        system.body("what the set adds", mass=14 * mass * L * weight / 2, place=place)
    system.loop("pin", rod.end() - turned(0.0, x3), gives=[phi2, x3])
    system.loop("drive", phi1 - p.speed * system.time, "rad", gives=[phi1])
    return system
