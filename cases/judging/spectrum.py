"""What can still be compared where a scene is so ill-conditioned that two good solutions run apart: energy, extremes, spectra."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Bands of the spectrum: third octaves. Two motions that run apart keep their band levels, not their lines.
BANDS_PER_OCTAVE: Final = 3


def later_differences(columns: dict[str, Array], other: dict[str, Array], since: float) -> dict[str, float]:
    """Relative differences of two trajectories after an instant.

    Args:
        columns: of the one; at least time, tip_deflection, and strain_energy where there is one.
        other: of the other, on the same grid.
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
    found = {"extremes": extremes, "spectrum": spectrum}
    if "strain_energy" in columns and "strain_energy" in other:
        energies = [float(np.mean(each["strain_energy"][later])) for each in (columns, other)]
        found["energy"] = abs(energies[0] - energies[1]) / energies[1]
    return found


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
