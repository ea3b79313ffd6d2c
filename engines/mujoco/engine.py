"""Engine `mujoco`. The library and the compiled loop are loaded when the first model is built, not when engines are listed."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines import refusals
from quickreturn.engines.base import FRICTION, ROLLERS, SPIN_UP, USUAL, Comparison, Engine, ModelDescription, Simulation
from quickreturn.engines.mujoco import description, installation
from quickreturn.engines.mujoco.settings import ARMATURE, LADDER, STIFFEST_ARMATURE, ChainSettings
from quickreturn.engines.start import Start
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.natural_modes import stiffness_ratio

#: `stiffness_ratio` above which the follower's fast modes respond to its load statically. For the same error the armature of the hinges may
#: then grow with the square of the ratio, and the step with the ratio.
STIFF: Final = 20.0

#: Links of the two coarser chains for the estimate, over those of the chain; and the order of the error that is relied on. The slider
#: shakes each chain differently as it passes from link to link, so that one difference alone may vanish by accident. Where it passes links
#: at a natural frequency, the error does not fall with their number.
COARSER: Final = (2.0 / 3.0, 3.0 / 4.0)
SAFE_ORDER: Final = 2.0

#: Smallest number of links whose error has an order. A chain with fewer is compared with one of `FINER` links, whose error is assumed to be
#: a third.
FEWEST_WITH_ORDER: Final = 12
FINER: Final = (18, 1.0 / 3.0)


class MujocoEngine(Engine[ChainSettings]):
    """Rigid links with hinge springs; the slider is an exact multiplier on a smooth centre line, closed after every step."""

    name = "mujoco"
    compiles = True
    method = "MuJoCo chain of rigid links, smooth centre line with exact sliding multiplier, Runge-Kutta of order 4"
    default_accuracy = 7e-3
    settings_type = ChainSettings
    quantities = (*USUAL, *ROLLERS, *FRICTION, "follower.material_damping", SPIN_UP)

    def version(self) -> str:
        return installation.version()

    def unavailable(self) -> str | None:
        return installation.unavailable()

    def check(self, scene: Scene) -> None:
        """Refuse also parts without mass."""
        super().check(scene)
        refusals.of_massless_parts(self.name, scene, ", whose links need mass")

    def describe(self, scene: Scene, settings: ChainSettings) -> ModelDescription:
        return description.describe(scene, description.hinge_count(scene, settings.links))

    def settings_for(self, accuracy: float, scene: Scene) -> ChainSettings:
        """The coarsest rung whose claim in run 24 is within `accuracy`; with more armature, and so larger steps, for a stiff follower."""
        ratio = stiffness_ratio(scene)
        return LADDER.pick(accuracy).replaced(armature=min(ARMATURE * max(1.0, ratio / STIFF) ** 2, STIFFEST_ARMATURE))

    def comparisons(self, settings: ChainSettings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        """Two coarser chains, or a finer one for a chain too coarse. The error of the step is negligible, because stability bounds it."""
        if settings.links < FEWEST_WITH_ORDER:
            links, factor = FINER
            return (Comparison(settings, settings.replaced(links=links), factor, of="space"),)
        coarser = ((settings.replaced(links=round(ratio * settings.links)), ratio**-SAFE_ORDER) for ratio in COARSER)
        return tuple(Comparison(settings, other, factor, of="space") for other, factor in coarser)

    def finer(self, settings: ChainSettings, excess: Mapping[str, float], output_step: float) -> ChainSettings | None:
        return LADDER.finer(settings, excess)

    def prepare(self, scene: Scene, start: Start | None, settings: ChainSettings) -> Simulation:
        self.check(scene)
        from quickreturn.engines.mujoco.simulation import ChainSimulation

        return ChainSimulation(scene, start, settings)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ChainSettings) -> NDArray[np.float64]:
        self.check(mechanism)
        from quickreturn.engines.mujoco import modes

        return modes.natural_frequencies(mechanism, crank_angle, count, settings.links)
