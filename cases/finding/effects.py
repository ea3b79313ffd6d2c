"""The effects that could tell the machine from its simulation, each at three strengths."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final

from reference_model.mechanism import Mechanism, PrescribedSpeed, changed

INCH: Final = 0.0254  # m
STANDARD_GRAVITY: Final = 9.80665  # m/s^2
#: Loss in the contact of a roller (s/m), and damping of the strip's material (s), wherever a roller can lift off. Neither is published.
#: Without them impacts set modes ringing that nothing stops.
LOSSES: Final[Mapping[str, Any]] = {"slider.contact_damping": 0.5, "follower.material_damping": 2e-5}
#: Stiffnesses of a soft joint or roller, kN/m.
SOFT: Final = (20.0, 10.0, 6.0)
#: EI over the published one with ordinary aluminium: 6061 (10.0 million psi) and 2024 (10.6).
ALLOYS: Final = (1.147, 1.218)


@dataclass(frozen=True)
class Strength:
    """An effect of one strength: its words, and what it makes of a scene, by quantity.

    Attributes:
        words: what tells it from the effect's other strengths.
        changes: place in the scene's dataclasses -> its value, the `Factor` that multiplies it, or `PRESCRIBED`.
        engine: that computes it.
        settings: of that engine, besides those of the study.
    """

    words: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    engine: str = "reference"
    settings: Mapping[str, str] = field(default_factory=dict)

    def scene(self, mechanism: Mechanism, speed: float) -> Mechanism:
        """The changed scene; `speed`: mean crank speed of the published one, rad/s."""
        values = {
            key: value.of(mechanism, key) if isinstance(value, Factor) else PrescribedSpeed(speed=speed) if value is PRESCRIBED else value
            for key, value in self.changes.items()
        }
        return changed(mechanism, values)


@dataclass(frozen=True)
class Factor:
    """A change in proportion."""

    value: float

    def of(self, mechanism: Mechanism, key: str) -> float:
        """The changed value of the quantity."""
        part, name = key.split(".")
        return self.value * float(getattr(getattr(mechanism, part), name))


#: A crank that turns at the mean speed of the published scene, whatever it takes.
PRESCRIBED: Final = "prescribed"


@dataclass(frozen=True)
class Effect:
    """One effect.

    Attributes:
        id: short name.
        words: name for people.
        strengths: weak to strong.
        choices: what is chosen to have it, for none of it is published.
        symmetric: why it cannot make the halves differ, where a symmetry forbids it; "" where none does.
    """

    id: str
    words: str
    strengths: tuple[Strength, ...]
    choices: tuple[str, ...] = ()
    symmetric: str = ""


Strengths = tuple[Strength, ...]
#: Why a law that is odd in the gap cannot tell the halves apart: run backwards and seen in a mirror the cycle is the same cycle.
MIRROR: Final = "but for losses, time reversal and the mirror map one half onto the other"


def _each(unit: str, key: str, values: tuple[float, ...], scale: float = 1.0, more: Mapping[str, Any] = MappingProxyType({})) -> Strengths:
    """Strengths that differ in one value, in a unit that is `scale` SI units."""
    return tuple(Strength(f"{value:g} {unit}".strip(), {key: scale * value, **more}) for value in values)


def _one_side(side: str, more: Mapping[str, Any] = MappingProxyType({})) -> Strengths:
    return _each("kN/m", f"slider.joint_stiffness_{side}", SOFT, 1e3, {**LOSSES, **more})


#: The crank turns counter-clockwise in all runs: the plus roller carries after the return, the minus roller before it.
EFFECTS: Final = (
    Effect(
        "cubic",
        "cubic elements for the follower",
        tuple(Strength(words, engine="thesis", settings={"elements": words[0]}) for words in ("3 elements", "2 elements", "1 element")),
    ),
    Effect("linear", "joint soft on both sides", _each("kN/m", "slider.joint_stiffness", SOFT, 1e3), ("stiffness",), MIRROR),
    Effect("post-side", "roller soft that carries after the return", _one_side("plus"), ("side", "stiffness", "losses")),
    Effect("pre-side", "roller soft that carries before the return", _one_side("minus"), ("side", "stiffness", "losses")),
    Effect(
        "preload",
        "preload, and the roller soft (10 kN/m) that carries after the return",
        _each("N", "slider.preload", (1.0, 3.0, 6.0), 1.0, {**LOSSES, "slider.joint_stiffness_plus": 1e4}),
        ("side", "stiffness", "preload", "losses"),
    ),
    Effect("clearance", "clearance", _each("mm", "slider.clearance", (0.05, 0.2, 0.5), 1e-3, LOSSES), ("clearance", "losses"), MIRROR),
    Effect("friction", "friction of the rollers on the follower", _each("", "slider.friction", (0.1, 0.3, 0.5)), ("coefficient",)),
    Effect("drag", "drag along the follower", _each("N", "slider.friction_force", (2.5, 5.0, 10.0)), ("force",)),
    Effect("pivot", "friction of the pivot", _each("N m", "base.friction_torque", (0.0125, 0.025, 0.05)), ("torque",)),
    Effect("slider-mass", "mass of the slider", _each("kg", "slider.mass", (0.03, 0.1, 0.3)), ("mass",), MIRROR),
    Effect("slider-inertia", "inertia of the slider", _each("kg mm²", "slider.inertia", (10.0, 30.0, 100.0), 1e-6), ("inertia",), MIRROR),
    Effect("tip", "centre of the tip body beyond the end", _each("in", "tip.center_of_mass", (0.125, 0.25, 0.5), INCH), ("place",), MIRROR),
    Effect(
        "gravity",
        "gravity: the mechanism tilted about n1",
        tuple(Strength(f"{angle}°", {"gravity": (0.0, -STANDARD_GRAVITY * math.sin(math.radians(angle)))}) for angle in (1, 3, 10)),
        ("tilt",),
    ),
    Effect(
        "strip",
        "bending stiffness of the strip",
        tuple(Strength(f"× {scale:g}", {"follower.bending_stiffness": Factor(scale)}) for scale in (1.05, *ALLOYS)),
        ("bending stiffness",),
        MIRROR,
    ),
    Effect(
        "drive",
        "drive: inertia of the crank",
        (
            *(Strength(f"× {scale:g}", {"crank.mass": Factor(scale), "crank.inertia": Factor(scale)}) for scale in (0.3, 3.0)),
            Strength("infinite: prescribed speed", {"crank.drive": PRESCRIBED}),
        ),
        ("inertia",),
        MIRROR,
    ),
    Effect(
        "post-side-alloy",
        "roller soft that carries after the return, 3 N of preload, strip of 2024 aluminium",
        _one_side("plus", {"slider.preload": 3.0, "follower.bending_stiffness": Factor(ALLOYS[1])}),
        ("side", "stiffness", "preload", "losses", "bending stiffness"),
    ),
)
