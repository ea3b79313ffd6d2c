"""Doubtful values of a scene: possible, but probably mistakes; they are reported, never refused."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from quickreturn.cases.files.units import in_si
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.rigid import rigid_motion
from quickreturn.reference_model.spring import Spring, pull_of, spring_tension

#: Least and largest usual length of a follower, m: a watch's lever and a crane's jib.
_LENGTHS: Final = (1e-3, 20.0)
#: Least and largest density of solids, kg/m^3: rigid foam, and metals such as platinum.
_DENSITIES: Final = (20.0, 25e3)
#: Least elastic modulus, Pa: soft plastics have less, as metals in MPa for GPa have; and the largest: diamond has 1.1e12 Pa.
_MODULI: Final = (0.5e9, 1.5e12)
#: Density, kg/m^3, above which materials are metal, glass or stone, and the modulus, Pa, that these exceed: lead has 16 GPa.
_METAL_DENSITY, _METAL_MODULUS = 2500.0, 10e9
#: Largest usual mass of a tip, as a multiple of the follower's.
_HEAVIEST_TIP: Final = 5.0
#: Number of crank angles in a turn at which a spring's length is looked at.
_ANGLES: Final = 181
#: Largest usual crank speed, rad/s (19,000 rpm): only spindles turn faster.
_FASTEST: Final = 2e3


def doubts(scene: Scene) -> Iterator[str]:
    """Sentences on values that are possible, but probably mistakes."""
    follower, tip, crank = scene.follower, scene.tip, scene.crank
    length = f"{follower.length:.6g} m"
    found = [*_of_follower(follower)]
    if tip is not None and tip.mass > _HEAVIEST_TIP * follower.mass:
        found.append(f"tip.mass is {tip.mass:.6g} kg, {tip.mass / follower.mass:.3g} times the follower's ({follower.mass:.3g} kg)")
    if tip is not None and abs(tip.center_of_mass) > follower.length:
        found.append(f"tip.center_of_mass is {tip.center_of_mass:.6g} m, more than the follower's length ({length})")
    if crank is not None and abs(crank.center_of_mass) > scene.pivot_distance:
        found.append(
            f"crank.center_of_mass is {abs(crank.center_of_mass):.6g} m, more than the pivot distance ({scene.pivot_distance:.6g} m)"
        )
    if crank is not None and abs(crank.drive.initial_speed) > _FASTEST:
        found.append(f"the crank turns at {abs(crank.drive.initial_speed) / in_si('rpm'):.6g} rpm")
    if scene.crank is not None and (spring := scene.acting_spring) is not None and spring.stop_stiffness > 0.0:
        found += _of_stops(scene, spring)
    yield from (f"{each}: is that meant?" for each in found)


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
                f" lets go, is up to {way:.3g} m engaged, and makes a force of {force:.4g} N on a stiff arm"
            )


def _of_follower(follower: Follower) -> Iterator[str]:
    if not _LENGTHS[0] <= follower.length <= _LENGTHS[1]:
        yield f"follower.length is {follower.length:.6g} m"
    section, key = follower.section, "thickness" if follower.diameter is None else "diameter"
    if section.depth > 0.25 * follower.length:
        slender = f"more than a quarter of the length ({follower.length:.6g} m), and shear is not modelled"
        yield f"follower.{key} is {section.depth:.6g} m, {slender}"
    if section.depth > section.breadth and section.name == "rectangle":
        plane = "and lies in the plane of motion, so that the follower bends about its stiff side"
        yield f"follower.thickness is {section.depth:.6g} m, more than the width ({section.breadth:.6g} m), {plane}"
    density, modulus = follower.density, follower.elastic_modulus
    if not _DENSITIES[0] <= density <= _DENSITIES[1]:
        yield f"follower.mass_per_length (or density) and the section make a density of {density:.3g} kg/m^3"
    least = _METAL_MODULUS if density > _METAL_DENSITY else _MODULI[0]
    if not follower.is_rigid and not least <= modulus <= _MODULI[1]:
        unit = "GPa" if modulus >= in_si("GPa") else "MPa"
        made = f"a modulus of {modulus / in_si(unit):.3g} {unit} at a density of {density:.4g} kg/m^3"
        yield f"follower.bending_stiffness (or elastic_modulus) and the section make {made} (aluminium has 70 GPa, steel 210 GPa)"
