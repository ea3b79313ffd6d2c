"""Mistakes that were not used while the checks were written."""

import dataclasses
import math
from typing import Any

import numpy as np

from quickreturn.engines.base import Comparison
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import Start
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.scene_values import changed
from tests.cases.conformance.mutants import Columns, Mutant, column, of_columns, of_frequencies, of_scene


def _accelerometer(columns: Columns, mechanism: Mechanism) -> None:
    columns["tip_acceleration"] = columns["tip_acceleration"] / 9.80665


def _from_tip(columns: Columns, mechanism: Mechanism) -> None:
    columns["slider_position"] = mechanism.follower.length - columns["slider_position"]


def _in_the_base_frame(columns: Columns, mechanism: Mechanism) -> None:
    columns["tip_acceleration"] = columns["tip_acceleration"] * np.cos(columns["follower_angle"])


def _dissipation_restarts(columns: Columns, mechanism: Mechanism) -> None:
    columns["dissipated_energy"] = columns["dissipated_energy"] - columns["dissipated_energy"][0]


class AboutTheEnd(Mutant):
    def scene(self, mechanism: Mechanism) -> Mechanism:
        tip = mechanism.tip
        return mechanism if tip is None else changed(mechanism, {"tip.inertia": max(0.0, tip.inertia - tip.mass * tip.center_of_mass**2)})


class _ForwardSpeed(Mutant):
    """A crank that can only be turned forwards."""

    def scene(self, mechanism: Mechanism) -> Mechanism:
        drive = mechanism.crank.drive
        return changed(mechanism, {"crank.prescribed_speed": abs(drive.speed)}) if isinstance(drive, PrescribedSpeed) else mechanism

    def start(self, start: Start) -> Start:
        return dataclasses.replace(start, crank_speed=abs(start.crank_speed))


class _DegreesForRadians(Mutant):
    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ReferenceSettings) -> Any:
        return super().natural_frequencies(mechanism, math.radians(crank_angle), count, settings)


class _UpsideDown(Mutant):
    def comparisons(self, settings: ReferenceSettings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        return tuple(dataclasses.replace(pair, factor=1.0 / pair.factor) for pair in super().comparisons(settings, mechanism, output_step))


class _CoarserWhenAsked(Mutant):
    def settings_for(self, accuracy: float, mechanism: Any) -> ReferenceSettings:
        return ReferenceEngine.settings_for(self, 1e-3 if accuracy > 0.01 else 0.05, mechanism)


class _Smooth(Mutant):
    """A moving average, as to look better."""

    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        columns["tip_acceleration"] = np.convolve(np.pad(columns["tip_acceleration"], 4, mode="edge"), np.ones(9) / 9.0, mode="valid")


SECOND: dict[str, tuple[type[Mutant], str, str]] = {
    "acceleration in g": (of_columns(_accelerometer), r"tip_acceleration .*\bg\b", "motion"),
    "slider from the tip": (of_columns(_from_tip), "slider_position .*from the tip", "motion"),
    "acceleration along the wrong axis": (of_columns(_in_the_base_frame), "tip_acceleration", "motion"),
    "force in pounds": (column("slider_force", lambda y: y / 4.4482216152605), "slider_force .*pounds", "motion"),
    "force without its sign": (column("slider_force", np.abs), "slider_force is a size without sign", "motion"),
    "speed in Hz": (column("crank_speed", lambda y: y / (2.0 * math.pi)), "crank_speed .*Hz", "motion"),
    "smoothed acceleration": (_Smooth, "tip_acceleration", "motion"),
    "dissipated energy restarts": (of_columns(_dissipation_restarts), "dissipated_energy", "motion"),
    "base inertia 3 times": (of_scene(base__inertia=lambda x: 3.0 * x), "base.inertia", "motion"),
    "tip inertia about the wrong point": (of_scene(tip__inertia=lambda x: x + 0.05 * 0.02**2), "tip.inertia", "motion"),
    "tip inertia about the flexible end": (AboutTheEnd, "tip.inertia is taken about the flexible end", "quantities"),
    "half the base damping": (of_scene(base__damping=lambda x: 0.5 * x), "base.damping acts .*half as large", "quantities"),
    "turns forwards alone": (_ForwardSpeed, "reversed", "quantities"),
    "slider mass on the crank twice": (of_scene(slider__mass=lambda x: 2.0 * x), "slider.mass acts", "quantities"),
    "degrees for radians": (_DegreesForRadians, "degrees|crank", "frequencies"),
    "factor upside down": (_UpsideDown, "factor", "resolution"),
    "settings_for backwards": (_CoarserWhenAsked, "settings_for", "resolution"),
    "twice as many frequencies": (of_frequencies(lambda f: np.repeat(f, 2)[: len(f)]), "twice", "frequencies"),
}
