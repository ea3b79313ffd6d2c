"""What a chain consists of, in words: known without the library, which need not be loaded to show it."""

from quickreturn.engines.base import ModelDescription
from quickreturn.reference_model.joint import friction_in_words, joint_in_words
from quickreturn.reference_model.mechanism import Scene


def hinge_count(mechanism: Scene, links: int) -> int:
    """Number of hinges N: that of the links, or 0 for a rigid follower."""
    return 0 if mechanism.follower.is_rigid else links


def describe(scene: Scene, hinges: int) -> ModelDescription:
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
