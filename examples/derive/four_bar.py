"""A four-bar linkage whose coupler bends."""

import casadi as ca

from quickreturn.derive import Beam, System, turned, vector


def four_bar(shapes: int = 3) -> System:
    """All bars move freely, without gravity; the coupler's frame follows its mean tangent."""
    system = System("four-bar linkage")
    p = system.constants(
        ground=(400, "mm"), crank=(100, "mm"), coupler=(400, "mm"), rocker=(300, "mm"),
        crank_inertia=(5e-3, "kg*m^2"), rocker_inertia=(4e-3, "kg*m^2"),
        mass_per_length=(0.16, "kg/m"), bending_stiffness=(1.2, "N*m^2"),
    )  # fmt: skip
    crank = system.coordinate("crank_angle", "rad")
    coupler = system.coordinate("coupler_angle", "rad", guess=0.8)
    rocker = system.coordinate("rocker_angle", "rad", guess=1.6)
    eta = system.amplitudes("eta", shapes, "rad", size=0.01)

    def tangent(x):
        waves = [eta[k] * ca.cos((k + 1) * ca.pi * x / p.coupler) for k in range(shapes)]
        return sum(waves, 0 * x)

    beam = Beam(
        system, "coupler", origin=turned(crank, p.crank), angle=coupler,
        edges=[0, p.coupler / 2, p.coupler], tangent=tangent,
        mass_per_length=p.mass_per_length, bending_stiffness=p.bending_stiffness,
        points=4 + 2 * shapes,
    )  # fmt: skip
    system.body("crank", inertia=p.crank_inertia, angle=crank)
    system.body("rocker", inertia=p.rocker_inertia, angle=rocker)
    hinge = vector(p.ground, 0) + turned(rocker, p.rocker)
    system.loop("hinge", beam.end() - hinge, gives=[coupler, rocker])
    across = beam.end(0) - (turned(crank, p.crank) + hinge) / 2
    normal = turned(coupler, 0, 1)
    system.output("bow", ca.dot(across, normal), "mm")
    return system
