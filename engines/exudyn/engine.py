"""The `exudyn` engine: what it accepts, which settings it starts from, and how a simulation is prepared.

The library is loaded when the first model is built, not when engines are listed.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib.util import find_spec
from typing import Final

from quickreturn.engines.base import (
    DRIVEN,
    HELD,
    ROLLERS,
    SPIN_UP,
    TOOL,
    USUAL,
    Comparison,
    Engine,
    ModelDescription,
    Refusal,
    Simulation,
    installed,
    too_old,
)
from quickreturn.engines.exudyn import settings as ladder
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.ladder import gain_of
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.units import Units
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.natural_modes import clamped_modes, stiffness_ratio
from quickreturn.reference_model.rigid import crank_pace

#: Oldest version that works: in 1.11 properties and settings have other names.
OLDEST: Final = (1, 13, 6)

#: Lowest frequency (Hz) in run 24, on which the ladder was measured.
MEASURED_FREQUENCY: Final = 10.9

#: Fewest elements for natural frequencies, whatever a simulation has: the first of run 24 is then right to 1e-5, the third to 1.5e-4.
ELEMENTS_OF_MODES: Final = 24


class ExudynEngine(Engine[ExudynSettings]):
    """Absolute nodal coordinates, the slider as a joint that moves along the cable, generalized-alpha in time."""

    name = "exudyn"
    method = "ANCF cable elements with an ALE sliding joint, generalized-alpha (index 3)"
    default_accuracy = 3e-3
    settings_type = ExudynSettings
    quantities = (*USUAL, *DRIVEN, *TOOL, *HELD, *ROLLERS, "follower.material_damping", SPIN_UP)

    def version(self) -> str:
        return f"exudyn {installed('exudyn') or 'not installed'}"

    def unavailable(self) -> str | None:
        found = installed("exudyn")
        return too_old("exudyn", found, OLDEST) if found and find_spec("exudyn") else "the package exudyn is not installed"

    def _check(self, scene: Scene, settings: ExudynSettings) -> None:
        (_SLIDING_JOINT if settings.joint == ladder.SLIDING else self).check(scene)

    def describe(self, scene: Scene, settings: ExudynSettings) -> ModelDescription:
        """Bodies, joints and degrees of freedom of the assembled system."""
        self._check(scene, settings)
        from quickreturn.engines.exudyn.models import model_of

        return model_of(scene, standard_start(scene), settings).assembly.describe()

    def settings_for(self, accuracy: float, scene: Scene) -> ExudynSettings:
        """The rung of the ladder measured in run 24, a coarser one for a stiffer follower; for one alone with a step by its longest period.

        Where rollers touch and part, twice the elements and half the step in place of an extrapolated table. Elsewhere the table of a stiff
        arm is extrapolated, which keeps its energy balance.
        """
        ratio = stiffness_ratio(scene)
        rung = ladder.rung_for(accuracy, gain_of(scene), 0.0 < ratio < ladder.SLOW)
        if scene.crank is None:
            slowest = float(clamped_modes(scene, 1).frequencies[0])
            return rung.replaced(step=min(rung.step * MEASURED_FREQUENCY / slowest, ladder.LARGEST_STEP))
        if scene.slider.has_corners:
            return rung.replaced(elements=min(2 * rung.elements, ladder.MOST_ELEMENTS), step=rung.step / 2.0, extrapolated=False)
        return ladder.balanced(rung, accuracy, ratio * crank_pace(scene)) if 0.0 < ratio < ladder.STIFFEST_BALANCED else rung

    def comparisons(self, settings: ExudynSettings, scene: Scene, output_step: float) -> tuple[Comparison, ...]:
        """Pairs for time, space, stretch and the slider's passing of nodes, whose errors have different signs.

        A follower alone has no slider; a rigid follower has no elements, and only the pair for time.
        """
        in_time = ladder.in_time(settings, output_step, scene.slider.has_corners)
        if scene.follower.is_rigid:
            return (in_time,)
        in_stretch = ladder.in_stretch(settings, in_time)
        if scene.crank is None:
            return in_time, ladder.in_space(settings, in_time), in_stretch
        in_space, *in_passing = ladder.in_elements(settings, in_time)
        return in_time, in_space, in_stretch, *in_passing

    def finer(self, settings: ExudynSettings, excess: Mapping[str, float], output_step: float) -> ExudynSettings | None:
        """Smaller steps, more elements or a stiffer cable, as far as each is needed."""
        return ladder.finer(settings, excess, output_step)

    def prepare(self, scene: Scene, start: Start | None, settings: ExudynSettings) -> Simulation:
        """Build the system in the state `start`; see `Engine.prepare`."""
        self._check(scene, settings)
        from quickreturn.engines.exudyn.models import model_of
        from quickreturn.engines.exudyn.simulation import ExtrapolatedSimulation, ExudynSimulation, PassingSimulation

        units = Units.of(scene)
        if settings.joint == ladder.SLIDING:
            units = replace(units, mass=units.mass * ladder.LIGHT)

        def simulation(steps_in: Callable[[float], int]) -> ExudynSimulation:
            began = time.perf_counter()
            model = model_of(units.scene(scene), start and units.start(start), settings)
            return ExudynSimulation(model, settings, steps_in, units, began)

        fine = simulation(settings.steps_in)
        stepped = ExtrapolatedSimulation(fine, simulation(settings.fewer_steps_in)) if settings.extrapolated else fine
        return PassingSimulation(stepped, settings.rows_in_step) if settings.rows > 1 else stepped

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ExudynSettings) -> Array:
        """Frozen-crank frequencies in Hz; none for a rigid follower on a rigid joint. See `Engine.natural_frequencies`."""
        self.check(mechanism)
        from quickreturn.engines.exudyn.models import natural_frequencies

        units = Units.of(mechanism)
        elements = max(settings.elements, ELEMENTS_OF_MODES)
        return natural_frequencies(units.scene(mechanism), crank_angle, count, elements) / units.time


class _SlidingJoint(ExudynEngine):
    """What the engine accepts with a sliding joint, which has no carriage and needs a cable."""

    name = f'exudyn with engine.joint = "{ladder.SLIDING}"'
    quantities = (*USUAL, *DRIVEN, *TOOL, *HELD, "follower.material_damping")

    def check(self, scene: Scene) -> None:
        super().check(scene)
        if scene.follower.is_rigid:
            raise Refusal(f"follower.bending_stiffness: inf is not modelled by engine {self.name}; accepted: a number")


_SLIDING_JOINT: Final = _SlidingJoint()
