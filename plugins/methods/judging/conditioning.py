"""Conditioning of a scene: the change of the tip deflection by `reference` if a parameter changes by 0.1 %.

Parameters are never known to 0.1 %. If so small a change moves the answer by several percent, an accuracy of a percent over the whole
duration has no meaning: two good solutions diverge beyond a horizon, and only energy, extremes and spectrum can be compared there
(`later_differences`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from quickreturn.cases.library.hard import Variation
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.mechanism import Mechanism

Array = NDArray[np.float64]

#: Bands of the spectrum: third octaves. Two motions that diverge have the same band levels, but not the same lines.
BANDS_PER_OCTAVE: Final = 3
#: Relative change of a parameter.
CHANGE: Final = 1e-3
#: Relative change of the tip deflection above which a scene is ill-conditioned: fifty times the change of the parameter.
ILL: Final = 0.05
#: Least number of rows beyond the horizon for a comparison of spectra.
FEWEST_LATER: Final = 16
#: Accuracy at which the reference runs. Its error is the same with and without the change, so that it hardly shows in the difference.
_ACCURACY: Final = 1e-3


@dataclass(frozen=True)
class Conditioning:
    """Conditioning of one scene."""

    # parameter ("stiffness", "damping", "speed", "speed at the same crank angle") -> RMS change of the tip deflection over its RMS, for
    # `CHANGE` of the parameter, over the duration or until the scene ends
    changes: Mapping[str, float]
    # length (s) of the longest stretch from the start on which no change exceeds `ILL`; the duration if fewer than `FEWEST_LATER` rows are
    # beyond that. A change of speed counts at the same crank angle, because the same motion only comes sooner.
    horizon: float
    scene: str = ""  # name of the case
    converged: float | None = None  # claimed error of its converged solution; None where there is none


def conditioning(mechanism: Mechanism, duration: float, output_step: float) -> Conditioning:
    """The conditioning of a scene from its standard start; times in s. EngineFailure: the reference cannot run the scene at all."""
    nominal = _run(mechanism, duration, output_step)
    differences: dict[str, Array] = {}
    for variation in variations(mechanism):
        run, name = _run(variation.of(mechanism), duration, output_step), variation.name
        rows = min(len(nominal), len(run))
        differences[name] = run["tip_deflection"][:rows] - nominal["tip_deflection"][:rows]
        if name == "speed":
            differences["speed at the same crank angle"] = _at_same_angle(run, nominal)
    deflection = nominal["tip_deflection"]
    ratios = {name: _running_ratio(difference, deflection[: len(difference)]) for name, difference in differences.items()}
    counting = [ratio for name, ratio in ratios.items() if name != "speed"]
    return Conditioning({name: float(ratio[-1]) for name, ratio in ratios.items()}, _horizon(counting, duration, output_step))


def variations(mechanism: Mechanism) -> tuple[Variation, ...]:
    """Variations with one kind of parameter larger by `CHANGE`: bending stiffness, dampings of beam and pivot, mean crank speed."""
    speed = ("crank.torque", "crank.initial_speed") if mechanism.crank_is_free else ("crank.prescribed_speed",)
    kinds = {"stiffness": ("follower.bending_stiffness",), "damping": ("follower.damping", "base.damping"), "speed": speed}
    return tuple(Variation(name, scaled=dict.fromkeys(paths, 1.0 + CHANGE)) for name, paths in kinds.items())


def _run(mechanism: Mechanism, duration: float, output_step: float) -> Trajectory:
    """The motion, up to the time when the slider leaves the follower."""
    engine = ReferenceEngine()
    settings = engine.settings_for(_ACCURACY, mechanism)
    try:
        return run_once(engine, mechanism, standard_start(mechanism), duration, output_step, settings).trajectory
    except EngineFailure as failure:
        if failure.partial is None or len(failure.partial) < 2:
            raise
        return failure.partial


def _at_same_angle(run: Trajectory, nominal: Trajectory) -> Array:
    """Difference of the deflections at the same crank angle, in the rows of the nominal run up to the last angle of the other one."""
    turned, nominal_turned = (np.abs(each["crank_angle"] - each["crank_angle"][0]) for each in (run, nominal))
    rows = int(np.searchsorted(nominal_turned, turned[-1], side="right"))
    return CubicSpline(turned, run["tip_deflection"])(nominal_turned[:rows]) - nominal["tip_deflection"][:rows]


def _running_ratio(difference: Array, deflection: Array) -> Array:
    """RMS of the difference over the RMS of the deflection, each from the start up to a row."""
    sums, changes = np.cumsum(deflection**2), np.cumsum(difference**2)
    return np.sqrt(np.divide(changes, sums, out=np.zeros_like(sums), where=sums > 0.0))


def _horizon(ratios: Sequence[Array], duration: float, output_step: float) -> float:
    """Length of the longest stretch from the start on which no ratio exceeds `ILL`, s; the duration if that is all there is."""
    rows = min(map(len, ratios))
    well = np.flatnonzero(np.max([ratio[:rows] for ratio in ratios], axis=0) <= ILL)
    return duration if well[-1] >= rows - FEWEST_LATER else output_step * float(max(well[-1], 1))


def later_differences(columns: dict[str, Array], other: dict[str, Array], since: float) -> dict[str, float]:
    """Relative differences of two trajectories after an instant.

    Args:
        columns: columns of one trajectory; at least time, tip_deflection, and strain_energy if there is one.
        other: columns of the other, on the same grid.
        since: s, the rows after it are compared.

    Returns:
        "extremes": difference of the tip deflection's minimum and maximum (the larger), relative to the other's largest modulus.
        "spectrum": RMS difference of the tip deflection's band levels, relative to their RMS.
        "energy": difference of the mean strain energy, relative; left out where one of them has no such column.
    """
    later = columns["time"] > since
    ours, theirs = columns["tip_deflection"][later], other["tip_deflection"][later]
    largest = float(np.max(np.abs(theirs)))
    extremes = max(abs(float(ours.max() - theirs.max())), abs(float(ours.min() - theirs.min()))) / largest
    row = float(columns["time"][1] - columns["time"][0])
    levels, their_levels = band_levels(ours, row), band_levels(theirs, row)
    spectrum = float(np.linalg.norm(levels - their_levels) / np.linalg.norm(their_levels))
    differences = {"extremes": extremes, "spectrum": spectrum}
    if "strain_energy" in columns and "strain_energy" in other:
        energies = [float(np.mean(each["strain_energy"][later])) for each in (columns, other)]
        differences["energy"] = abs(energies[0] - energies[1]) / energies[1]
    return differences


def band_levels(signal: Array, row: float) -> Array:
    """RMS of a signal in third-octave bands, from the lowest frequency resolved to half the sampling rate.

    Args:
        signal: shape (n,), n >= 4.
        row: s, sampling interval.

    Returns:
        Levels in the signal's unit, shape (bands,); the number of bands depends on n alone.
    """
    window = np.hanning(len(signal))
    power = np.abs(np.fft.rfft((signal - signal.mean()) * window)) ** 2 / np.sum(window**2) / len(signal)
    power[1:] *= 2.0  # the negative frequencies
    frequencies = np.fft.rfftfreq(len(signal), row)
    bands = np.round(BANDS_PER_OCTAVE * np.log2(frequencies[1:] / frequencies[1])).astype(int)
    return np.sqrt(np.bincount(bands, weights=power[1:]))
