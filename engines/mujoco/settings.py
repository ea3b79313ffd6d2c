"""Settings of the link chain, the ladder of them, and what a chain consists of: all that is known without loading the library."""

from dataclasses import dataclass
from typing import Final

from quickreturn.engines.base import ModelDescription
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.settings import Settings as AnySettings
from quickreturn.engines.settings import setting
from quickreturn.reference_model.joint import friction_in_words, joint_in_words
from quickreturn.reference_model.mechanism import Scene

#: Armature of a hinge, by default and at most, in the unit of `ChainSettings.armature` (LADDERS.md, section 4, as for the ladder).
ARMATURE: Final = 7e-4
STIFFEST_ARMATURE: Final = 1.0
MOST_LINKS: Final = 256


@dataclass(frozen=True, kw_only=True)
class ChainSettings(AnySettings):
    """Number of links, time step and armature."""

    links: int = setting(13, "number of links, and of hinges", low=1, high=MOST_LINKS)
    step: float = setting(0.9, "largest time step, in units of the longest stable one of the straight chain", low=0.01, high=2.0)
    armature: float = setting(
        ARMATURE,
        "inertia added to each hinge, in units of mass per length x (link length x length)^1.5; allows larger steps",
        low=0.0,
        high=STIFFEST_ARMATURE,
    )


#: Links -> error of the tip deflection that they claim in most of the thesis' runs over 2 s.
_CLAIMS: Final = {
    3: 0.35, 4: 0.15, 5: 0.09, 6: 0.05, 9: 0.02, 11: 1e-2, 13: 5e-3, 16: 2.5e-3, 20: 1.3e-3, 23: 9e-4, 28: 5e-4, 34: 3e-4, 41: 2e-4,
    53: 9e-5, 64: 5e-5, 90: 2.5e-5,
}  # fmt: skip
LADDER: Final = Ladder(tuple((ChainSettings(links=links), claim) for links, claim in _CLAIMS.items()), size="links", order=2.5)


def hinge_count(mechanism: Scene, links: int) -> int:
    """Number of hinges N: that of the links, or 0 for a rigid follower."""
    return 0 if mechanism.follower.is_rigid else links


def description_of(scene: Scene, hinges: int) -> ModelDescription:
    """Bodies and joints that `chain.build` makes, with the slider's constraint or the drive of the base, which the control hook adds."""
    slider, spring = scene.slider, "spring EI/h" if scene.follower.material_damping == 0.0 else "spring EI/h and damper"
    links = [f"hinge {j}: {spring}" for j in range(1, hinges + 1)]
    if scene.crank is None:
        joints = ["base hinge at O, turned as prescribed: one constraint, exact torque", *links]
    else:
        crank = ["crank hinge at O, driven by a torque against viscous damping"] if scene.crank_is_free else []
        moving = "crank tip" if scene.crank_is_free else "crank tip, moved at the prescribed speed,"
        how = f"beside the follower's smooth centre line: {joint_in_words(slider)}"
        if slider.is_rigid:
            how = "on the follower's smooth centre line: one constraint, exact multiplier"
        held = [] if scene.acting_spring is None else [scene.acting_spring.in_words]
        joints = [*crank, "base hinge at P", *links, f"{moving} {how}{friction_in_words(slider)}", *held]
    bodies = {
        "crank: rigid arm about O": scene.crank_is_free,
        "slider: point mass fixed to the crank tip": scene.crank_is_free and slider.mass > 0.0,
        "base and rigid follower: one body about P": hinges == 0,
        "base: block and half a link about P": hinges > 0,
        **{f"link {j}: rigid rod": True for j in range(1, hinges)},
        f"link {hinges}: half a link at the end": hinges > 0,
        "tip: rigid body fixed to the end": scene.tip is not None,
    }
    free = hinges + int(scene.crank_is_free) + int(not slider.is_rigid)
    return ModelDescription(tuple(name for name, there in bodies.items() if there), tuple(joints), free)
