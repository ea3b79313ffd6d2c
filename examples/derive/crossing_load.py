"""A force and a mass cross a simply supported beam at constant speed."""

import casadi as ca

from quickreturn.derive import Beam, System, vector


def crossing_load(shapes: int = 5) -> System:
    """A small bridge in `shapes` sines; the beam's own weight is left out."""
    system = System("crossing load")
    p = system.constants(
        length=(10, "m"), mass_per_length=(200, "kg/m"), bending_stiffness=(2e6, "N*m^2"),
        speed=(54, "km/hour"), force=(5, "kN"), mass=(0, "kg"),
    )  # fmt: skip
    eta = system.amplitudes("eta", shapes, "m", size=1e-3)

    def deflection(x):
        return sum(eta[k] * ca.sin((k + 1) * ca.pi * x / p.length) for k in range(shapes))

    beam = Beam(
        system, "bridge", origin=vector(0, 0), angle=0, edges=[0, p.length / 2, p.length],
        deflection=deflection, foreshortening=False, points=4 + 2 * shapes,
        mass_per_length=p.mass_per_length, bending_stiffness=p.bending_stiffness,
    )  # fmt: skip
    contact = beam.place(p.speed * system.time)
    system.load("force", contact, vector(0, -p.force))
    system.body("mass", mass=p.mass, place=contact)
    system.output("middle", deflection(p.length / 2), "mm")
    system.output("under_load", contact[1], "mm")
    return system
