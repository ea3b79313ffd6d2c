"""The follower: the section of the arm, its material, and the beam made of both."""

import math
from dataclasses import dataclass
from typing import Final

from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.quantities import ANY_COUNT, quantity


@dataclass(frozen=True, kw_only=True)
class Section:
    """A cross-section: a rectangle or a circle, less a hollow of the same kind about the same centre.

    An I section lacks a hollow on either side of its web. Together the two count as one about the centre: they have its area, and its
    second moment about the axis of bending.
    """

    name: str  # in words
    depth: float  # m, in the plane of bending
    breadth: float  # m, out of the plane
    hollow_depth: float = 0.0
    hollow_breadth: float = 0.0
    share: float = 1.0  # of its bounding box that a solid one fills: pi / 4 of a circle
    divisor: float = 12.0  # area times depth^2 over the second moment of a solid one: 16 of a circle

    @property
    def extreme_fibre(self) -> float:
        """Distance of the surface from the axis of bending, m."""
        return self.depth / 2.0

    def area(self, density: float = 1.0) -> float:
        """The area, m^2; with a density (kg/m^3) the mass per length, kg/m."""
        return self.share * (density * self.breadth * self.depth - density * self.hollow_breadth * self.hollow_depth)

    def second_moment(self, modulus: float = 1.0) -> float:
        """The second moment of area about the axis of bending, m^4; with a modulus (Pa) the bending stiffness EI, N m^2."""
        solid, hollow = modulus * self.breadth * self.depth**3, modulus * self.hollow_breadth * self.hollow_depth**3
        return self.share * (solid - hollow) / self.divisor

    def axial_stiffness(self, bending_stiffness: float) -> float:
        """EA = EI A / I, N."""
        missing = self.hollow_breadth * self.hollow_depth
        square = self.depth**2 + missing * (self.depth**2 - self.hollow_depth**2) / (self.breadth * self.depth - missing)
        return self.divisor * bending_stiffness / square


def section_of(
    *,
    thickness: float | None = None,
    width: float | None = None,
    diameter: float | None = None,
    wall: float | None = None,
    flange: float | None = None,
    web: float | None = None,
) -> Section:
    """The section that has these dimensions, m: which are given says of which kind it is.

    Raises:
        ImpossibleMechanism: one is missing, or does not fit into another.
    """
    if diameter is not None:
        _check_inside("wall", wall, 2, "diameter", diameter)
        bore = 0.0 if wall is None else diameter - 2.0 * wall
        name = "round" if wall is None else "tube"
        return Section(
            name=name, depth=diameter, breadth=diameter, hollow_depth=bore, hollow_breadth=bore, share=math.pi / 4.0, divisor=16.0
        )
    if thickness is None or width is None:
        raise ImpossibleMechanism("follower.thickness", "or width is missing", "give both, or diameter")
    if (flange is None) != (web is None):
        given, other = ("web", "flange") if flange is None else ("flange", "web")
        raise ImpossibleMechanism(
            f"follower.{given}", f"is that of an I section, which has a {other} too", f"give follower.{other} as well"
        )
    if flange is not None and web is not None:
        _check_inside("flange", flange, 2, "thickness", thickness)
        _check_inside("web", web, 1, "width", width)
        return Section(name="I section", depth=thickness, breadth=width, hollow_depth=thickness - 2.0 * flange, hollow_breadth=width - web)
    if wall is None:
        return Section(name="rectangle", depth=thickness, breadth=width)
    _check_inside("wall", wall, 2, "thickness", thickness)
    _check_inside("wall", wall, 2, "width", width)
    hollow = {"hollow_depth": thickness - 2.0 * wall, "hollow_breadth": width - 2.0 * wall}
    return Section(name="rectangular tube", depth=thickness, breadth=width, **hollow)


def _check_inside(key: str, part: float | None, times: int, outer: str, size: float) -> None:
    """Refuse a part that leaves no room in an outer dimension, in which it stands so many times."""
    if part is not None and times * part >= size:
        raise ImpossibleMechanism(
            f"follower.{key}",
            f"cannot be: {'twice ' if times > 1 else ''}the {key} ({times * part:.6g} m) must be less than follower.{outer} ({size:.6g} m)",
            f"give less than {size / times:.6g} m, or a larger follower.{outer}",
            (f"follower.{outer}",),
        )


#: Keys of the dimensions of a section.
DIMENSIONS: Final = ("thickness", "width", "diameter", "wall", "flange", "web")


@dataclass(frozen=True, kw_only=True)
class Material:
    """Material of a follower; with the section it gives stiffness and mass per length."""

    elastic_modulus: float = quantity("Pa", "Young's modulus", sign="positive")
    density: float = quantity("kg/m^3", "density of the material", sign="positive")


@dataclass(frozen=True, kw_only=True)
class Follower:
    """Uniform, inextensible, unshearable beam from P to the tip; bends across its thickness."""

    length: float = quantity("m", "from P to the tip", sign="positive")
    mass_per_length: float = quantity("kg/m", "mass per length", sign="positive")
    bending_stiffness: float = quantity("N*m^2", "EI of the section", sign="positive", infinity=True)
    thickness: float | None = quantity("m", "of the section, in the plane of bending", sign="positive", default=None, optional=False)
    width: float | None = quantity("m", "of the section, out of the plane", sign="positive", default=None, optional=False)
    diameter: float | None = quantity("m", "of a round section or a tube", sign="positive", default=None, optional=False)
    wall: float | None = quantity("m", "of a tube, round or rectangular", sign="positive", default=None)
    flange: float | None = quantity("m", "thickness of either flange of an I section", sign="positive", default=None)
    web: float | None = quantity("m", "thickness of its web, between them", sign="positive", default=None)
    damping: float = quantity(
        "N*s/m^2",
        "per length, on the centre line's velocity relative to the base",
        sign="not negative",
        default=0.0,
        optional=False,
        named=True,
    )
    material_damping: float = quantity(
        "s",
        "damping moment over EI, per rate of curvature (Kelvin and Voigt)",
        sign="not negative",
        default=0.0,
        named=True,
    )
    strain_gauges: tuple[float, float, float] = quantity(
        "m", "arc lengths from P", sign="not negative", count=3, default=(math.nan, math.nan, math.nan), optional=False
    )
    yield_strength: float | None = quantity(
        "Pa", "stress at which the material yields, for the safety factor", sign="positive", default=None, moves=False
    )
    fatigue_strength: float | None = quantity(
        "Pa", "stress amplitude, fully reversed, that the material bears for ever", sign="positive", default=None, moves=False
    )
    tensile_strength: float | None = quantity(
        "Pa", "ultimate strength of the material, by which the mean stress counts", sign="positive", default=None, moves=False
    )
    notch_places: tuple[float, ...] | None = quantity(
        "m", "arc lengths from P of holes, edges and clamps", sign="not negative", count=ANY_COUNT, default=None, moves=False
    )
    notch_factors: tuple[float, ...] | None = quantity(
        "1", "fatigue notch factor at each of them, on the stress amplitude", sign="positive", count=ANY_COUNT, default=None, moves=False
    )

    def __post_init__(self) -> None:
        section_of(**{name: getattr(self, name) for name in DIMENSIONS})
        for key, what, places in (
            ("strain_gauges", "strain gauge", self.strain_gauges),
            ("notch_places", "notch", self.notch_places or ()),
        ):
            for place in places:
                if place > self.length:
                    problem, accepted = f"leaves the {what} at {place:.6g} m outside the follower", f"its length is {self.length:.6g} m"
                    raise ImpossibleMechanism(f"follower.{key}", problem, accepted, ("follower.length",))
        places, factors = self.notch_places or (), self.notch_factors or ()
        if len(places) != len(factors):
            problem = f"has {len(factors)} values, and follower.notch_places {len(places)}"
            raise ImpossibleMechanism("follower.notch_factors", problem, "give one factor for each place", ("follower.notch_places",))
        if any(factor < 1.0 for factor in factors):
            problem = f"has {min(factors):.6g} in it, and no notch makes the stress amplitude smaller"
            raise ImpossibleMechanism("follower.notch_factors", problem, "factors of 1 or more are accepted")
        for key in ("yield_strength", "fatigue_strength"):
            strength = getattr(self, key)
            if strength is not None and self.tensile_strength is not None and strength > self.tensile_strength:
                problem = f"cannot be: {strength:.6g} Pa is more than follower.tensile_strength ({self.tensile_strength:.6g} Pa)"
                raise ImpossibleMechanism(
                    f"follower.{key}", problem, "give less, or a larger tensile_strength", ("follower.tensile_strength",)
                )

    @property
    def is_rigid(self) -> bool:
        """Whether the follower has no flexible coordinate at all."""
        return math.isinf(self.bending_stiffness)

    @property
    def section(self) -> Section:
        """The section that its dimensions make."""
        return section_of(**{name: getattr(self, name) for name in DIMENSIONS})

    @property
    def mass(self) -> float:
        """Mass of the beam, kg."""
        return self.mass_per_length * self.length

    @property
    def density(self) -> float:
        """Density that follows from mass per length and section, kg/m^3."""
        return self.mass_per_length / self.section.area()

    @property
    def elastic_modulus(self) -> float:
        """Young's modulus that follows from bending stiffness and section, Pa."""
        return self.bending_stiffness / self.section.second_moment()

    @property
    def extreme_fibre(self) -> float:
        """Distance of the surface from the axis of bending, m: strain over curvature."""
        return self.section.extreme_fibre

    @property
    def slenderness(self) -> float:
        """Length over thickness, or over diameter."""
        return self.length / self.section.depth

    @property
    def axial_stiffness(self) -> float:
        """EA in N from EI and the section. For models that can stretch."""
        return self.section.axial_stiffness(self.bending_stiffness)
