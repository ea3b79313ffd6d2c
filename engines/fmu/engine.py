"""The engine of an FMU: which values of a scene it takes, what it therefore refuses, and its communication steps as resolutions.

What the FMU does inside is unknown. It gets every value of the scene that moves something, or the scene is refused: values go to the
FMU's parameters, are stated to be those that the FMU has built in, or are those of a feature that the scene does not have.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from numpy.typing import NDArray

from quickreturn.engines.base import SPIN_UP, Comparison, Engine, ModelDescription, Refusal, installed
from quickreturn.engines.fmu.description import SAME, Declarations, Fmu, Variable, steps_within
from quickreturn.engines.settings import Settings, setting
from quickreturn.engines.start import Start
from quickreturn.reference_model.follower import DIMENSIONS
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.quantities import Quantity
from quickreturn.reference_model.scene_values import NAMED, SECTIONS, values_of

if TYPE_CHECKING:
    from quickreturn.engines.fmu.simulation import FmuSimulation

#: Distance of the follower's surface from the axis of bending: stands for the dimensions of the section, which only strains depend on.
EXTREME_FIBRE: Final = "follower.extreme_fibre"
#: Values of parts that a scene may lack, where a case file has no default; and of all strengths that such parts have.
_OF_NO_TIP: Final = {"tip.mass": 0.0, "tip.inertia": 0.0}
_ABSENT: Final = {key: quantity.default for key, quantity in NAMED.items() if quantity.default is not None} | _OF_NO_TIP
_INITIAL: Final = ("crank.initial_angle", "crank.initial_speed")


@dataclass(frozen=True, kw_only=True)
class FmuSettings(Settings):
    """Settings of an FMU."""

    step: float = setting(1e-3, "largest communication step; it divides the output step", unit="s", low=1e-9, high=1.0)


#: Default accuracy where the errors of the steps are not declared.
_ACCURACY: Final = 0.01


class FmuEngine(Engine[FmuSettings]):
    """A model in an FMU. The name is the path of the file that declares it."""

    settings_type = FmuSettings
    begins_bent = False  # no parameter describes a bent follower

    def __init__(self, name: str, fmu: Fmu, declared: Declarations) -> None:
        self.name, self.fmu, self._declared = name, fmu, declared
        self.method, self.estimates, errors = declared.method, declared.estimates, declared.errors
        self.default_accuracy = errors[len(errors) // 2] if errors else _ACCURACY
        self.quantities = tuple(key for key in (*declared.parameters, *declared.fixed) if key in NAMED)

    @property
    def alone(self) -> bool:
        """Whether it models a follower alone."""
        return SPIN_UP in self.quantities

    def version(self) -> str:
        maker = self.fmu.about.generationTool or "an unknown tool"
        return f"fmpy {installed('fmpy')}, FMI {self.fmu.fmi} by {maker}, {self.fmu.fingerprint}"

    def check(self, scene: Scene, /) -> None:
        """Refuse every value that neither goes to a parameter nor is built in, unless it is that of a feature that is not there."""
        if self.alone and scene.crank is not None:
            raise Refusal(f"[crank]: engine {self.name} models a follower alone; accepted: a scene without [crank]")
        super().check(scene)
        values = _effective(scene)
        present = {key.partition(".")[0] for key in values}
        absent = {key: value for key, value in _ABSENT.items() if key.partition(".")[0] not in present}
        self._refuse_other_than_built_in(absent | values)
        for key, value in values.items():
            section, _, name = key.partition(".")
            quantity = SECTIONS[section].get(name)
            if key in self._declared.parameters:
                if math.inf in (value if isinstance(value, tuple) else (value,)):
                    raise Refusal(f"{key}: inf cannot be given to the FMU of engine {self.name}; accepted: a finite value")
            elif key not in self._declared.fixed and (quantity is None or not _of_absent_feature(quantity, value)):
                raise Refusal(
                    f"{key}: {value} cannot be set in engine {self.name}, which names no parameter of the FMU for it;"
                    f" accepted: such a parameter in [parameters] of the engine's file, or the value that the FMU has in [fixed]"
                )

    def _refuse_other_than_built_in(self, values: Mapping[str, Any]) -> None:
        for key, built_in in self._declared.fixed.items():
            if key in values and not _same(values[key], built_in):
                raise Refusal(f"{key}: {values[key]} cannot be set in engine {self.name}; accepted: {built_in}, as built in (SI)")

    def describe(self, scene: Scene, settings: FmuSettings, /) -> ModelDescription:
        self.check(scene)
        states = self.fmu.about.numberOfContinuousStates  # many tools list none of those that an FMU for co-simulation integrates
        inside = f"as in {self.fmu.path}"
        return ModelDescription((f"all bodies {inside}",), (f"all joints {inside}",), states // 2 or None)

    def settings_for(self, accuracy: float, scene: Scene, /) -> FmuSettings:
        """The first step whose declared error is small enough, else the finest; the coarsest if no errors are declared."""
        steps, errors = self._declared.steps, self._declared.errors or (0.0,)
        return FmuSettings(step=next((step for step, error in zip(steps, errors, strict=False) if error <= accuracy), steps[-1]))

    def comparisons(self, settings: FmuSettings, scene: Scene, output_step: float, /) -> tuple[Comparison, ...]:
        """A run with half the step: with twice the number of steps in an output step."""
        step = output_step / steps_within(output_step, settings.step)
        return (Comparison(settings, FmuSettings(step=0.5 * step), 0.5**self._declared.order, of="time"),)

    def finer(self, settings: FmuSettings, excess: Mapping[str, float], output_step: float, /) -> FmuSettings | None:
        """The next step that changes anything: a step longer than the output step is cut to it."""
        present = steps_within(output_step, settings.step)
        return next((FmuSettings(step=step) for step in self._declared.steps if steps_within(output_step, step) > present), None)

    def ladder(self, mechanism: Mechanism, /) -> tuple[FmuSettings, ...]:
        return tuple(FmuSettings(step=step) for step in self._declared.steps)

    def prepare(self, scene: Scene, start: Start | None, settings: FmuSettings, /) -> "FmuSimulation":
        """See `Engine.prepare`. Refusal: also a start with a bent follower, which no parameter describes."""
        self.check(scene)
        if start is not None and (start.deflection is not None or start.deflection_rate is not None):
            raise Refusal(f"a start with a bent follower cannot be given to engine {self.name}; accepted: the standard start of a case")
        values = _effective(scene)
        if start is not None:
            begun = {key: value for key, value in zip(_INITIAL, (start.crank_angle, start.crank_speed), strict=True) if key in values}
            self._refuse_other_than_built_in(begun)
            values |= begun
        from quickreturn.engines.fmu.simulation import FmuSimulation

        parameters = (*self._declared.constants, *_parameter_values(self._declared.parameters, values))
        length = math.inf if scene.crank is None else scene.follower.length
        return FmuSimulation(self.fmu, parameters, self._declared.outputs, settings.step, length)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: FmuSettings) -> NDArray[Any]:
        """Refused: co-simulation gives a motion, and no equations to linearize."""
        raise Refusal(f"natural frequencies cannot be asked of engine {self.name}: an FMU for co-simulation gives motions alone")


def _effective(scene: Scene) -> dict[str, Any]:
    """The values of a scene on which its motion or its strains depend, by key; the section's dimensions by what strains need of them."""
    values = {
        f"{section}.{name}": value
        for section, given in values_of(scene).items()
        for name, value in given.items()
        if SECTIONS[section][name].moves and not (section == "follower" and name in DIMENSIONS)
    }
    return {**values, EXTREME_FIBRE: scene.follower.extreme_fibre}


def _parameter_values(parameters: Mapping[str, tuple[Variable, ...]], values: Mapping[str, Any]) -> Iterator[tuple[Variable, float]]:
    """Each parameter with its value in the FMU's unit; of a part that the scene lacks, that of its absence."""
    for key, variables in parameters.items():
        section, _, name = key.partition(".")
        value = values.get(key, _OF_NO_TIP.get(key, SECTIONS[section][name].default if name in SECTIONS[section] else None))
        if value is None and any(other.startswith(f"{section}.") for other in values):
            raise Refusal(f"{key} is not given by the scene, and its FMU needs a value; accepted: a scene with {key}")
        for variable, number in zip(variables, value if isinstance(value, tuple) else (value,), strict=True):
            if number is not None and math.isfinite(number):
                yield variable, (number - variable.offset) / variable.factor


def _of_absent_feature(quantity: Quantity, value: Any) -> bool:
    """Whether a value may be without effect: `Engine.check` has judged it, or it belongs to a feature whose strength is judged there."""
    return quantity.named or (quantity.optional and quantity.default is not None and value == quantity.default)


def _same(value: Any, other: float | tuple[float, ...]) -> bool:
    pairs = zip(*(each if isinstance(each, tuple) else (each,) for each in (value, other)), strict=True)
    return all(one == two or math.isclose(one, two, rel_tol=SAME) for one, two in pairs)
