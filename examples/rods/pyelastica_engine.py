"""PyElastica's Cosserat rod as an engine, `PyElasticaRod()`. It needs `pip install pyelastica`."""

import elastica as ea
import numpy as np
import quickreturn as qr


class System(ea.BaseSystemCollection, ea.Constraints, ea.Forcing):
    """What the rod needs of PyElastica."""


class Cosserat(qr.Rod):
    """A rod whose clamp holds its first element, so that it stands half an element deep in it."""

    def __init__(self, scene, pieces):
        beam, h = scene.follower, scene.follower.length / (pieces - 0.5)
        if scene.tip_body.mass:
            raise qr.Refusal("tip.mass: the rod has no body at its end; accepted: 0 kg")
        # a thick rod needs fewer steps, but its shear costs 2 % of the third frequency
        radius = beam.length / 50
        modulus = 4 * beam.bending_stiffness / (np.pi * radius**4)
        density = beam.mass_per_length / (np.pi * radius**2)
        along, normal = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
        self.rod = ea.CosseratRod.straight_rod(
            *(pieces, -h / 2 * along, along, normal, pieces * h, radius, density),
            youngs_modulus=modulus,
            shear_modulus=modulus / 2.6,
        )
        self.system = System()
        self.system.append(self.rod)
        clamp = self.system.constrain(self.rod)
        clamp.using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
        weight = self.system.add_forcing_to(self.rod)
        weight.using(ea.GravityForces, acc_gravity=np.array([*scene.gravity, 0.0]))
        self.system.finalize()
        self.stepper, self.time = ea.PositionVerlet(), 0.0
        self.step = 0.8 * radius / np.sqrt(modulus / density)

    def advance(self, duration):
        """As many steps as its shear needs."""
        steps = int(np.ceil(duration / self.step))
        for _ in range(steps):
            self.time = self.stepper.step(self.system, self.time, duration / steps)

    def points(self):
        """The nodes."""
        return self.rod.position_collection[:2].T

    def acceleration(self):
        """Of the last node, in the latest step."""
        return self.rod.acceleration_collection[:2, -1]


class PyElasticaRod(qr.RodEngine):
    """PyElastica's rod without damping."""

    name, method, library, rod = "pyelastica", "Cosserat rod", "pyelastica", Cosserat
    quantities = ("mechanism.gravity",)
    errors, order = {5: 0.023, 10: 0.0044, 20: 0.0013}, 1.5
    compiles, freedoms = True, 6
