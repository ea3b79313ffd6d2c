"""The engine of an FMU: which values of a scene it takes, what it therefore refuses, and its communication steps as resolutions.

What the FMU does inside is unknown. It gets every value of the scene that moves something, or the scene is refused: values go to the
FMU's parameters, are stated to be those that the FMU has built in, or are those of a feature that the scene does not have.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from numpy.typing import NDArray

from quickreturn.engines.base import SPIN_UP, Comparison, Engine, ModelDescription, Refusal, Simulation, installed
from quickreturn.engines.settings import Settings, setting
from quickreturn.engines.start import Start
from quickreturn.plugins.fmu.simulation import SAME, Fmu, FmuSimulation, steps_within
from quickreturn.reference_model.follower import DIMENSIONS
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.quantities import Quantity
from quickreturn.reference_model.scene_values import NAMED, SECTIONS, values_of

#: Distance of the follower's surface from the axis of bending: stands for the dimensions of the section, which only strains depend on.
EXTREME_FIBRE: Final = "follower.extreme_fibre"
#: Keys to which a parameter may belong: numbers on which the motion or the strains depend.
KEYS: Final[Mapping[str, Quantity]] = {
    f"{section}.{name}": quantity
    for section, quantities in SECTIONS.items()
    for name, quantity in quantities.items()
    if quantity.moves and not quantity.in_file and name not in (*DIMENSIONS, "elastic_modulus", "density")
} | {EXTREME_FIBRE: SECTIONS["follower"]["thickness"]}
#: Values of parts that a scene may lack; of a part's friction, spring and so on all strengths.
_ABSENT: Final = {key: quantity.default for key, quantity in KEYS.items() if quantity.named} | {"tip.mass": 0.0, "tip.inertia": 0.0}


@dataclass(frozen=True, kw_only=True)
class FmuSettings(Settings):
    """Settings of an FMU."""

    step: float = setting(1e-3, "largest communication step; it divides the output step", unit="s", low=1e-9, high=1.0)


class FmuEngine(Engine[FmuSettings]):
    """A model in an FMU. The name is the path of the file that declares it."""

    settings_type = FmuSettings
    default_accuracy = 0.01
    estimates = "integration"  # an FMU's elements are as many as they are
    begins_bent = False  # no parameter describes a bent follower

    def __init__(self, name: str, fmu: Fmu) -> None:
        self.name, self.fmu, self.method = name, fmu, fmu.method
        self.quantities = tuple(key for key in (*fmu.parameters, *fmu.fixed) if key in NAMED)

    def version(self) -> str:
        maker = self.fmu.about.generationTool or "an unknown tool"
        return f"fmpy {installed('fmpy')}, FMI {self.fmu.fmi} by {maker}, {self.fmu.fingerprint}"

    def check(self, scene: Scene, /) -> None:
        """Refuse every value that neither goes to a parameter nor is built in, unless it is that of a feature that is not there."""
        if SPIN_UP in self.quantities and scene.crank is not None:
            raise Refusal(f"[crank]: engine {self.name} models a follower alone; accepted: a scene without [crank]")
        super().check(scene)
        given = _given(scene)
        if scene.crank is None:
            del given["base.inertia"]  # the base turns as prescribed
        self._refuse_other_than_built_in(_ABSENT | given)
        for key, value in given.items():
            quantity = KEYS[key]  # a feature's strength is judged by `Engine.check`; what belongs to the feature has no effect without it
            is_judged = quantity.named or (quantity.optional and quantity.default is not None and value == quantity.default)
            if key in self.fmu.parameters:
                if math.inf in _numbers(value):
                    raise Refusal(f"{key}: inf cannot be given to the FMU of engine {self.name}; accepted: a finite value")
            elif key not in self.fmu.fixed and not is_judged:
                raise Refusal(
                    f"{key}: {value} cannot be set in engine {self.name}, which names no parameter of the FMU for it;"
                    f" accepted: such a parameter in [parameters] of the engine's file, or the value that the FMU has in [fixed]"
                )

    def _refuse_other_than_built_in(self, values: Mapping[str, Any]) -> None:
        for key, built_in in self.fmu.fixed.items():
            value = values.get(key)
            pairs = zip(_numbers(value), _numbers(built_in), strict=False)
            if not all(math.isclose(one, other, rel_tol=SAME) for one, other in pairs):
                raise Refusal(f"{key}: {value} cannot be set in engine {self.name}; accepted: {built_in}, as built in (SI)")

    def describe(self, scene: Scene, settings: FmuSettings, /) -> ModelDescription:
        self.check(scene)
        return ModelDescription((f"all bodies as in {self.fmu.path}",), (f"all joints as in {self.fmu.path}",), None)

    def settings_for(self, accuracy: float, scene: Scene, /) -> FmuSettings:
        """The coarsest step: a run's own estimate decides whether it suffices."""
        return FmuSettings(step=self.fmu.steps[0])

    def comparisons(self, settings: FmuSettings, scene: Scene, output_step: float, /) -> tuple[Comparison, ...]:
        """A run with half the step, by twice the number of steps in an output step; the error falls with it at least in proportion."""
        step = output_step / steps_within(output_step, settings.step)
        return (Comparison(settings, FmuSettings(step=0.5 * step), 0.5, of="time"),)

    def finer(self, settings: FmuSettings, excess: Mapping[str, float], output_step: float, /) -> FmuSettings | None:
        """The next step that changes anything: a step longer than the output step is cut to it."""
        present = steps_within(output_step, settings.step)
        return next((FmuSettings(step=step) for step in self.fmu.steps if steps_within(output_step, step) > present), None)

    def ladder(self, mechanism: Mechanism, /) -> tuple[FmuSettings, ...]:
        return tuple(FmuSettings(step=step) for step in self.fmu.steps)

    def prepare(self, scene: Scene, start: Start | None, settings: FmuSettings, /) -> Simulation:
        """See `Engine.prepare`. Refusal: also a start with a bent follower, which no parameter describes."""
        self.check(scene)
        given = _given(scene)
        if start is not None:
            if start.deflection is not None or start.deflection_rate is not None:
                raise Refusal(f"a start with a bent follower cannot be given to engine {self.name}; accepted: the standard start of a case")
            begun = {"crank.initial_angle": start.crank_angle, "crank.initial_speed": start.crank_speed}
            begun = {key: value for key, value in begun.items() if key in given}
            self._refuse_other_than_built_in(begun)
            given |= begun
        length = math.inf if scene.crank is None else scene.follower.length
        return FmuSimulation(self.fmu, self._start_values(given), settings.step, length)

    def _start_values(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Values of the FMU's parameters by their names, in its units; of a part that the scene lacks, those of its absence."""
        sections, values = {key.partition(".")[0] for key in given}, dict(self.fmu.constants)
        for key, variables in self.fmu.parameters.items():
            value = given.get(key, _ABSENT.get(key, KEYS[key].default))
            if value is None and key.partition(".")[0] in sections:
                raise Refusal(f"{key} is not given by the scene, and its FMU needs a value; accepted: a scene with {key}")
            for variable, number in zip(variables, _numbers(value), strict=False):
                if math.isfinite(number):
                    values[variable.name] = (number - variable.offset) / variable.factor
        return values

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: FmuSettings) -> NDArray[Any]:
        """Refused: co-simulation gives a motion, and no equations to linearize."""
        raise Refusal(f"natural frequencies cannot be asked of engine {self.name}: an FMU for co-simulation gives motions alone")


def _given(scene: Scene) -> dict[str, Any]:
    """The values of a scene by `KEYS`, without those of parts that it lacks."""
    values = {f"{section}.{name}": value for section, of_section in values_of(scene).items() for name, value in of_section.items()}
    return {key: value for key, value in values.items() if key in KEYS} | {EXTREME_FIBRE: scene.follower.extreme_fibre}


def _numbers(value: Any) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else () if value is None else (value,)
