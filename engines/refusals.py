"""Refusals that several engines share. Each function raises `Refusal` if the scene has the feature in the function's name."""

from quickreturn.engines.base import Refusal
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.shapes import ShapeSet


def of_massless_parts(name: str, scene: Scene, why: str) -> None:
    """Refuse a crank or follower without mass, for an engine with an open loop; `why` ends the clause on the follower."""
    if scene.crank_is_free and scene.crank_inertia <= 0.0:
        raise Refusal(
            f"crank.inertia: {scene.crank.inertia:g} kg*m^2 on a crank without mass cannot be modelled by {name}, whose open loop"
            " leaves the crank to itself; accepted: above 0, or crank.mass or slider.mass above 0"
        )
    if (mass := scene.follower.mass_per_length) <= 0.0:
        raise Refusal(f"follower.mass_per_length: {mass:g} kg/m cannot be modelled by {name}{why}; accepted: above 0")


def of_kinks(scene: Scene, shapes: ShapeSet, accepted: str) -> None:
    """Refuse a slider with rotary inertia on shapes whose curvature jumps; `accepted` names the shapes that are accepted."""
    if (inertia := scene.slider.inertia) > 0.0 and not shapes.has_continuous_curvature:
        raise Refusal(
            f"slider.inertia: {inertia:g} kg*m^2 is not accepted with these settings: a slider with rotary inertia needs shapes with"
            f" continuous curvature, {accepted}"
        )
