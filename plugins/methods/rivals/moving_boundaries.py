"""The engine `moving-boundaries`: a linear beam across the line from pivot to slider, the crank at a known speed (Beale and Scott)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from quickreturn.engines.base import USUAL, Comparison
from quickreturn.engines.own.beam_engine import EXPLICIT, BeamEngine, BeamSettings, integrator, tolerance
from quickreturn.engines.settings import setting
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.natural_modes import frozen_crank_modes

if TYPE_CHECKING:
    from quickreturn.plugins.methods.moving_boundaries.model import MovingBoundariesModel

#: Tolerance over the integration error of the tip deflection (`reference_model/RIVALS.md`, section 4).
TOLERANCE_PER_ERROR: Final = 1e-4
#: Ratio of the tolerances of two runs that are compared.
TIGHTER: Final = 0.01
#: Largest error of the run with the tighter tolerance over that of the other run.
PART_OF_TIGHTER: Final = 0.3
LOOSEST: Final = 1e-5
TIGHTEST: Final = 1e-12


@dataclass(frozen=True, kw_only=True)
class MovingBoundariesSettings(BeamSettings):
    """Settings of `moving-boundaries`."""

    modes: int = setting(2, "modes of the beam supported at the slider", low=1, high=8)
    foreshortening: bool = setting(False, "shortening of the bent beam along the line, to second order: the axial force that stiffens it")
    tolerance: float = tolerance(1e-7, low=TIGHTEST, high=LOOSEST)
    integrator: str = integrator(EXPLICIT, choices=(EXPLICIT,))
    slowed_to: int = setting(0, "no mode is slowed", low=0, high=0)

    @property
    def shape_count(self) -> int:
        return self.modes


class MovingBoundariesEngine(BeamEngine[MovingBoundariesSettings]):
    """Modes on two domains that move with the slider. They are the model, so that accuracy and error estimate are the integration's."""

    name = "moving-boundaries"
    method = "linear beam across the line from pivot to slider, modes on domains that move with it, crank at known speed, DOP853"
    default_accuracy = 1e-3
    estimates = "integration"
    settings_type = MovingBoundariesSettings
    kind_of_shapes = "shapes that follow the slider"
    quantities = tuple(name for name in USUAL if name != "crank.torque")

    def opens_loop(self, scene: Scene) -> bool:
        """Never: the crank's angle gives the slider's place."""
        return False

    def joint_line(self, scene: Scene, settings: MovingBoundariesSettings) -> str:
        return "slider supports the beam where it meets the line (known from the crank's angle)"

    def model(self, mechanism: Mechanism, settings: MovingBoundariesSettings) -> "MovingBoundariesModel":  # type: ignore[override]
        from quickreturn.plugins.methods.moving_boundaries.model import MovingBoundariesModel

        return MovingBoundariesModel(mechanism, settings.modes, settings.foreshortening)

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> MovingBoundariesSettings:
        """Integration tolerance for an integration error."""
        return MovingBoundariesSettings(tolerance=min(max(accuracy * TOLERANCE_PER_ERROR, TIGHTEST), LOOSEST))

    def ladder(self, mechanism: Mechanism) -> tuple[MovingBoundariesSettings, ...]:
        """Numbers of modes, because the model's error exceeds that of its integration; one rung for a free crank, which is refused."""
        return tuple(MovingBoundariesSettings(modes=modes) for modes in ((2,) if mechanism.crank_is_free else (1, 2, 3, 4, 6)))

    def comparisons(self, settings: MovingBoundariesSettings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """A run with a hundredth of the tolerance, or with a hundred times one that is too tight for that."""
        times, factor = TIGHTER, PART_OF_TIGHTER
        if settings.tolerance * TIGHTER < TIGHTEST:
            times, factor = 1.0 / TIGHTER, 1.0 / PART_OF_TIGHTER
        return (Comparison(settings, settings.replaced(tolerance=times * settings.tolerance), factor, of="time"),)

    def finer(self, settings: MovingBoundariesSettings, excess: Mapping[str, float], output_step: float) -> MovingBoundariesSettings | None:
        """A tenth of the tolerance."""
        return settings.replaced(tolerance=0.1 * settings.tolerance) if settings.tolerance > 10.0 * TIGHTEST else None

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: MovingBoundariesSettings) -> Array:
        """Converged: the shapes are the natural modes with the crank held."""
        self.check(mechanism)
        return frozen_crank_modes(mechanism, crank_angle, min(count, settings.modes)).frequencies
