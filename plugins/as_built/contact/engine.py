"""Engine `mujoco-contact`. The library is loaded when the first model is built, not when engines are listed."""

from collections.abc import Mapping
from typing import Final

from quickreturn.engines import refusals
from quickreturn.engines.base import Comparison, Engine, ModelDescription, Refusal, Simulation
from quickreturn.engines.mujoco import installation
from quickreturn.engines.start import Start
from quickreturn.plugins.as_built.contact.settings import LADDER, ContactSettings
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, Scene

#: Links of the coarser chain for the estimate, over those of the chain, and the order of the error in them (LADDERS.md, section 6).
COARSER: Final = 2.0 / 3.0
ORDER: Final = 1.8
#: Part of the error in time of the finer run for the estimate: its step is half as long, and the order is one.
FINER: Final = 0.5


class MujocoContactEngine(Engine[ContactSettings]):
    """Links on hinges with springs, and a slot along them in which MuJoCo's contact keeps the crank's pin."""

    name = "mujoco-contact"
    method = "plain MuJoCo: chain of links, the crank's pin in contact with the walls of their slot, implicitfast integrator"
    default_accuracy = 0.05
    settings_type = ContactSettings
    quantities = (
        "mechanism.gravity", "crank.torque", "base.damping", "follower.material_damping", "tip.center_of_mass",
        "slider.mass", "slider.clearance",
    )  # fmt: skip

    def version(self) -> str:
        return installation.version()

    def unavailable(self) -> str | None:
        return installation.unavailable()

    def check(self, scene: Scene) -> None:
        """Refuse also a rigid follower, one without mass, and damping against the base, which MuJoCo has by no means of its own."""
        if (damping := scene.follower.damping) > 0.0:
            raise Refusal(
                f"follower.damping: {damping:g} N*s/m^2 is not modelled by engine {self.name}, for MuJoCo has no damper along a body"
                ' that turns; accepted: 0, and follower.material_damping (such as "1e-4 s") in its place'
            )
        super().check(scene)
        if scene.follower.is_rigid:
            raise Refusal(f"follower.bending_stiffness: inf N*m^2 is not modelled by engine {self.name}; accepted: a finite stiffness")
        refusals.of_massless_parts(self.name, scene, ", whose links need mass")

    def describe(self, scene: Mechanism, settings: ContactSettings) -> ModelDescription:
        self.check(scene)
        bodies = (
            "crank: rigid arm about O",
            "slider: body on the crank's pin with two spheres",
            *(f"link {i}: box" for i in range(settings.links)),
        )
        joints = (
            "crank hinge at O, driven by a torque against viscous damping", "base hinge at P",
            *(f"hinge {i}: spring EI/h and damper" for i in range(1, settings.links)), "pin in contact with the walls",
        )  # fmt: skip
        tip = ("tip: rigid body fixed to the end",) if scene.tip is not None else ()
        return ModelDescription((*bodies, *tip), joints, settings.links + 1)

    def settings_for(self, accuracy: float, scene: Mechanism) -> ContactSettings:
        return LADDER.pick(accuracy)

    def comparisons(self, settings: ContactSettings, scene: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """A coarser chain with the same step, and a step of half the length; the contact's time constant changes with the step."""
        links = max(round(COARSER * settings.links), 4)
        ratio = links / settings.links
        coarser = settings.replaced(links=links, step=settings.step * ratio**2)
        halved = settings.replaced(step=settings.step * FINER)
        return Comparison(settings, coarser, ratio**-ORDER, of="space"), Comparison(settings, halved, FINER, of="time")

    def finer(self, settings: ContactSettings, excess: Mapping[str, float], output_step: float) -> ContactSettings | None:
        """More links; a smaller step if that is what most of the error comes from."""
        if excess.get("time", 0.0) > excess.get("space", 0.0):
            return settings.replaced(step=settings.step / 2.0) if settings.step > 0.02 else None
        return LADDER.finer(settings, excess)

    def prepare(self, scene: Mechanism, start: Start, settings: ContactSettings) -> Simulation:
        self.check(scene)
        from quickreturn.plugins.as_built.contact.simulation import ContactSimulation

        return ContactSimulation(scene, start, settings)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ContactSettings) -> Array:
        """Those of the straight chain on a support without give: the contact has no stiffness in N/m, only a time constant."""
        self.check(mechanism)
        from quickreturn.plugins.as_built.contact.chain import natural_frequencies

        return natural_frequencies(mechanism, crank_angle, count, settings.links)
