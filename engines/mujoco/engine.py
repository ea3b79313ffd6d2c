"""Engine `mujoco`. The library and the compiled loop are loaded when the first model is built, not when engines are listed."""

import itertools
import math
from collections.abc import Mapping
from typing import Final

from quickreturn.engines import refusals
from quickreturn.engines.base import DRIVEN, FRICTION, HELD, ROLLERS, SPIN_UP, TOOL, USUAL, Comparison, Engine, ModelDescription, Simulation
from quickreturn.engines.mujoco import installation
from quickreturn.engines.mujoco.settings import ARMATURE, LADDER, MOST_LINKS, STIFFEST_ARMATURE, ChainSettings, description_of, hinge_count
from quickreturn.engines.start import Start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.natural_modes import stiffness_ratio

#: `stiffness_ratio` above which the follower's fast modes respond to its load statically. For the same error the armature of the hinges may
#: then grow with the square of the ratio, and the step with the ratio.
STIFF: Final = 20.0

#: `stiffness_ratio` up to which the claims of `LADDER` hold. Above it the error falls with this power of the ratio, down to `LEAST_GAIN`.
SOFT: Final = 7.5
POWER: Final = 5.0
LEAST_GAIN: Final = 0.03

#: Links of the finer chain for the estimate, over those of the chain, at least; and the order of the error that is relied on.
FINER: Final = 1.4
ORDER: Final = 1.5

#: Smallest number of links whose error has an order. A chain with fewer is compared with two finer ones, the second of `FINEST` times as
#: many links at least, and the differences show whether the error falls with the square of the links.
FEWEST_WITH_ORDER: Final = 10
FINEST: Final = 2.0
ORDER_OF_FEW: Final = 2.0
#: Error in time of a rigid follower with half the step, over its own: a quarter, or more where rollers touch and part.
HALVED: Final = 1.0 / 3.0


class MujocoEngine(Engine[ChainSettings]):
    """Rigid links with hinge springs; the slider is an exact multiplier on a smooth centre line, closed after every step."""

    name = "mujoco"
    compiles = True
    method = "MuJoCo chain of rigid links, smooth centre line with exact sliding multiplier, leapfrog of order 2"
    default_accuracy = 7e-3
    settings_type = ChainSettings
    quantities = (*USUAL, *DRIVEN, *TOOL, *HELD, *ROLLERS, *FRICTION, "follower.material_damping", SPIN_UP)

    def version(self) -> str:
        return installation.version()

    def unavailable(self) -> str | None:
        return installation.unavailable()

    def check(self, scene: Scene) -> None:
        """Refuse also parts without mass."""
        super().check(scene)
        refusals.of_massless_parts(self.name, scene, ", whose links need mass")

    def describe(self, scene: Scene, settings: ChainSettings) -> ModelDescription:
        return description_of(scene, hinge_count(scene, settings.links))

    def settings_for(self, accuracy: float, scene: Scene) -> ChainSettings:
        """The coarsest rung that claims `accuracy`: the stiffer the follower, the fewer links, and the more armature, for larger steps."""
        ratio = stiffness_ratio(scene)
        gain = max(LEAST_GAIN, min(1.0, (SOFT / ratio) ** POWER)) if ratio > 0.0 else 1.0
        return LADDER.pick(accuracy, gain).replaced(armature=min(ARMATURE * max(1.0, ratio / STIFF) ** 2, STIFFEST_ARMATURE))

    def comparisons(self, settings: ChainSettings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        """Finer chains, whose steps are smaller, too; for a rigid follower, which has no chain, half the step.

        Of the longest chains there are no finer ones, and a coarser one is taken.
        The slider shakes the chain as it passes its links, and a vibration at that rate grows. It does so alike in chains whose numbers of
        links have a divisor in common.
        """
        if mechanism.follower.is_rigid:
            return (Comparison(settings, settings.replaced(step=settings.step / 2.0), HALVED, of="time"),)
        links = settings.links
        finer = _without_common_divisor(FINER * links if FINER * (links + 2) <= MOST_LINKS else links / FINER, links)
        if links >= FEWEST_WITH_ORDER:
            return (Comparison(settings, settings.replaced(links=finer), (links / finer) ** ORDER, of="space"),)
        finest = _without_common_divisor(FINEST * links, links * finer)
        more, most = (settings.replaced(links=number) for number in (finer, finest))
        further = Comparison(more, most, (finer / finest) ** ORDER_OF_FEW, of="space")
        return (Comparison(settings, more, (links / finer) ** ORDER_OF_FEW, further, of="space"),)

    def finer(self, settings: ChainSettings, excess: Mapping[str, float], output_step: float) -> ChainSettings | None:
        return LADDER.finer(settings, excess)

    def prepare(self, scene: Scene, start: Start | None, settings: ChainSettings) -> Simulation:
        self.check(scene)
        from quickreturn.engines.mujoco.simulation import ChainSimulation

        return ChainSimulation(scene, start, settings)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ChainSettings) -> Array:
        self.check(mechanism)
        from quickreturn.engines.mujoco.chain import natural_frequencies

        return natural_frequencies(mechanism, crank_angle, count, settings.links)


def _without_common_divisor(least: float, number: int) -> int:
    """The smallest whole number from `least` on that has no divisor in common with `number`."""
    return next(found for found in itertools.count(math.ceil(least)) if math.gcd(found, number) == 1)
