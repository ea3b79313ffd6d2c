"""Doubtful values of a scene: possible, but probably mistakes; they are reported, never refused."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from quickreturn.cases.units import in_si
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.rigid import rigid_motion
from quickreturn.reference_model.spring import Spring, pull_of, spring_tension

#: Least and largest usual length of a follower, m: a watch's lever and a crane's jib.
_LENGTHS: Final = (1e-3, 20.0)
#: Least and largest density of solids, kg/m^3: rigid foam, and metals such as platinum.
_DENSITIES: Final = (20.0, 25e3)
#: Elastic modulus, Pa, below which a material is a soft plastic or rubber. A metal's modulus with MPa in place of GPa is also below it.
_SOFT_MODULUS: Final = 0.5e9
#: Elastic modulus, Pa, that no solid has: diamond has 1.1e12 Pa.
_IMPOSSIBLE_MODULUS: Final = 1.5e12
#: Density, kg/m^3, above which materials are metal, glass or stone, and a modulus, Pa, that these exceed: lead, the softest, has 16 GPa.
_METAL_DENSITY, _METAL_MODULUS = 2500.0, 10e9
#: Elastic moduli of metals, for comparison in messages.
_METALS: Final = "aluminium has 70 GPa, steel 210 GPa"
#: Largest usual mass of a tip, as a multiple of the follower's.
_HEAVIEST_TIP: Final = 5.0
#: Number of crank angles in a turn at which a spring's length is looked at.
_ANGLES: Final = 181
#: Largest usual crank speed, rad/s (19,000 rpm): only spindles turn faster.
_FASTEST: Final = 2e3


def doubts(scene: Scene) -> Iterator[str]:
    """Sentences on values that are possible, but probably mistakes."""
    follower, tip = scene.follower, scene.tip
    yield from _of_follower(follower)
    if tip is not None and tip.mass > _HEAVIEST_TIP * follower.mass:
        yield f"tip.mass is {tip.mass:.6g} kg, {tip.mass / follower.mass:.3g} times the follower's ({follower.mass:.3g} kg): is that meant?"
    if tip is not None and abs(tip.center_of_mass) > follower.length:
        yield f"tip.center_of_mass is {tip.center_of_mass:.6g} m, more than the follower's length ({follower.length:.6g} m): is that meant?"
    if scene.crank is None:
        return
    if abs(centre := scene.crank.center_of_mass) > scene.pivot_distance:
        yield f"crank.center_of_mass is {centre:.6g} m, more than the pivot distance ({scene.pivot_distance:.6g} m): is that meant?"
    if abs(speed := scene.crank.drive.initial_speed) > _FASTEST:
        yield f"the crank turns at {speed / in_si('rpm'):.6g} rpm: is that meant?"
    if (spring := scene.acting_spring) is not None and spring.stop_stiffness > 0.0:
        yield from _of_stops(scene, spring)


def _of_stops(scene: Mechanism, spring: Spring) -> Iterator[str]:
    """A stop that the rigid machine never leaves: the place on the arm that it holds is held all turn."""
    turn = rigid_motion(scene, np.linspace(0.0, 2.0 * np.pi, _ANGLES), 0.0)
    place = scene.pivot_distance + spring.place_on(scene.follower.length) * np.exp(1j * turn.follower_angle)
    length = pull_of(spring, place, 0.0 * place).length
    low, high, law = float(length.min()), float(length.max()), spring.law
    for key, engaged, way in (("longest", low > law.longest, high - law.longest), ("shortest", high < law.shortest, law.shortest - low)):
        if engaged:
            force = abs(spring_tension(high if key == "longest" else low, 0.0, law))
            yield (
                f"spring.{key} is {getattr(law, key):.6g} m, and the spring is {low:.4g} to {high:.4g} m long over the turn: the stop never"
                f" lets go, is up to {way:.3g} m engaged, and makes a force of {force:.4g} N on a stiff arm: is that meant?"
            )


def _of_follower(follower: Follower) -> Iterator[str]:
    if not _LENGTHS[0] <= follower.length <= _LENGTHS[1]:
        yield f"follower.length is {follower.length:.6g} m: is that meant?"
    section, key = follower.section, "thickness" if follower.diameter is None else "diameter"
    if section.depth > 0.25 * follower.length:
        yield (
            f"follower.{key} is {section.depth:.6g} m, more than a quarter of the length ({follower.length:.6g} m): that is no"
            " slender beam, and shear is not modelled"
        )
    if section.depth > section.breadth and section.name == "rectangle":
        yield (
            f"follower.thickness is {section.depth:.6g} m, more than the width ({section.breadth:.6g} m): the thickness lies in the"
            " plane of motion, so the follower bends about the stiff side of its section; if it should bend about the thin side,"
            " exchange them"
        )
    if not _DENSITIES[0] <= follower.density <= _DENSITIES[1]:
        yield f"follower.mass_per_length (or density) and the section make a density of {follower.density:.3g} kg/m^3: is that meant?"
    if not follower.is_rigid and (doubt := _of_modulus(follower.elastic_modulus, follower.density)):
        shown = _shown(follower.elastic_modulus)
        yield f"follower.bending_stiffness (or elastic_modulus) and the section make a modulus of {shown}, {doubt}"


def _of_modulus(modulus: float, density: float) -> str:
    """The doubt about an elastic modulus (Pa) at a density (kg/m^3), as a clause; "" if there is none."""
    if modulus > _IMPOSSIBLE_MODULUS:
        return f"and no material is that stiff ({_METALS}, diamond 1100 GPa): is that meant?"
    if modulus < _METAL_MODULUS and density > _METAL_DENSITY:
        return f"as plastics or rubber have it, and a density of {density:.4g} kg/m^3, as metals have it ({_METALS}): is that meant?"
    if modulus < _SOFT_MODULUS:
        return f"which fits rubber or a soft plastic ({_METALS}, stiff plastics 2 to 4 GPa): is that meant?"
    return ""


def _shown(modulus: float) -> str:
    unit = "GPa" if modulus >= in_si("GPa") else "MPa"
    return f"{modulus / in_si(unit):.3g} {unit}"
