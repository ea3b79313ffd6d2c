"""The engine `derived`, a witness of `reference`: the computer derives its equations of motion from a description.

It shares with `reference` only the shapes that follow the slider, their tables and their known errors. The errors in its ladder are those
of the shapes (`engines/LADDERS.md`, section 1). What computes is loaded when a model is built, not when engines are listed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from quickreturn.engines import refusals
from quickreturn.engines.base import HELD, SPRING, TOOL, USUAL, Comparison, Engine, ModelDescription, Refusal, installed
from quickreturn.engines.ladder import Ladder, fitted
from quickreturn.engines.own.beam_engine import ELIMINATED_SLIDER, description
from quickreturn.engines.own.reference import ALIKE_WITHIN, COMPARED, MODES_WITH_ORDER, RATIO, SLOWEST_RATIO
from quickreturn.engines.settings import Settings, setting
from quickreturn.engines.start import Start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, Scene

if TYPE_CHECKING:
    from quickreturn.plugins.derive.witness.simulation import DerivedSimulation

#: Largest number of modes. The code has no loops: it grows with the square of the points and with the modes, to 74,000 instructions for 11.
MOST_MODES: Final = 11


@dataclass(frozen=True, kw_only=True)
class DerivedSettings(Settings):
    """Settings of `derived`."""

    modes: int = setting(2, "modes of the beam supported at the slider", low=1, high=MOST_MODES)
    tolerance: float = setting(1e-7, "local error of the integration, relative to fixed sizes of the states", low=1e-11, high=1e-4)


#: Number of modes, tolerance, and the error of the tip deflection that this number of modes leaves in run 24 over 2 s.
_RUNGS: Final = ((1, 1e-6, 2.7e-2), (2, 1e-6, 1.5e-3), (4, 1e-7, 8e-4), (5, 1e-7, 4.9e-4), (7, 1e-8, 8.2e-5))
LADDER: Final = Ladder(
    tuple((DerivedSettings(modes=modes, tolerance=tolerance), claim) for modes, tolerance, claim in _RUNGS), "modes", "tolerance"
)


class DerivedEngine(Engine[DerivedSettings]):
    """Simulates the quick-return by equations that are derived from its description."""

    name = "derived"
    interface = 1
    method = "equations derived by the computer from a description (CasADi), shapes that follow the slider, DOP853"
    compiles = True
    default_accuracy = 3e-3
    settings_type = DerivedSettings
    quantities = (*USUAL, *TOOL, *HELD, "slider.inertia", *SPRING, "base.friction_torque", "follower.material_damping")

    def version(self) -> str:
        """The version of CasADi, or that it is not installed."""
        return f"casadi {installed('casadi') or 'not installed'}"

    def unavailable(self) -> str | None:
        """The missing package and how to install it; None if it is installed."""
        return None if find_spec("casadi") else "CasADi is not installed; pip install 'quickreturn[derive]'"

    def check(self, scene: Scene) -> None:
        """Raise Refusal also for a rigid follower and, if the joint is compliant, for parts without inertia."""
        super().check(scene)
        if scene.follower.is_rigid:
            raise Refusal(f"follower.bending_stiffness: inf N*m^2 is not modelled by engine {self.name}; accepted: a finite stiffness")
        if not scene.slider.is_rigid:
            refusals.of_massless_parts(self.name, scene, " with a compliant joint, which does not hold the follower")

    def describe(self, mechanism: Mechanism, settings: DerivedSettings) -> ModelDescription:
        """The bodies and joints that have terms in the equations."""
        self.check(mechanism)
        slider, rigid = mechanism.slider, mechanism.slider.is_rigid
        compliant = f"slider beside the centre line (compliant joint, {slider.joint_stiffness:g} N/m, {slider.joint_damping:g} N*s/m)"
        beam = f"{settings.modes} shapes that follow the slider"
        return description(mechanism, beam, ELIMINATED_SLIDER if rigid else compliant, settings.modes + (not rigid))

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> DerivedSettings:
        """The settings of the ladder, with fewer modes if the follower is stiffer than that of run 24."""
        return fitted(LADDER, accuracy, mechanism)

    def comparisons(self, settings: DerivedSettings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """Compare with a run of more modes, as many as `reference` takes; if that does not suffice, with one of still more modes."""
        more, ratio = COMPARED.get(settings.modes, (settings.modes + 2, RATIO))
        if more > MOST_MODES:
            return (Comparison(settings, LADDER.sized(settings, settings.modes - 2), 1.0 / RATIO, of="modes"),)
        finer, further = LADDER.sized(settings, more), None
        if more + 2 <= MOST_MODES:
            further = Comparison(
                finer, LADDER.sized(finer, more + 2), RATIO if settings.modes < MODES_WITH_ORDER else SLOWEST_RATIO, of="modes"
            )
        return (Comparison(settings, finer, ratio, further, alike=ALIKE_WITHIN.get(settings.modes, 0.0), of="modes"),)

    def finer(self, settings: DerivedSettings, excess: Mapping[str, float], output_step: float) -> DerivedSettings | None:
        """The next settings of the ladder."""
        return LADDER.finer(settings, excess)

    def prepare(self, mechanism: Mechanism, start: Start, settings: DerivedSettings) -> "DerivedSimulation":
        """See `Engine.prepare`."""
        self.check(mechanism)
        from quickreturn.plugins.derive.witness.simulation import DerivedSimulation

        return DerivedSimulation(mechanism, start, settings.modes, settings.tolerance)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: DerivedSettings) -> Array:
        """Natural frequencies of the linearised model, discretized with two modes more than the requested number.

        The shapes take neither the slider's rotary inertia nor a compliant joint into account: each changes the third frequency by some
        per cent.
        """
        self.check(mechanism)
        from quickreturn.plugins.derive.witness.simulation import frequencies

        return frequencies(mechanism, crank_angle, min(max(settings.modes, count + 2), MOST_MODES))[:count]
