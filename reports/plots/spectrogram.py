"""Spectrogram of the tip acceleration over the steady cycle, under the natural frequencies that belong to each crank angle."""

from typing import Final

import matplotlib.patheffects as effects
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from cases.measures import TimeScale
from cases.runs.comparison import CaseResult
from reports.plots.picture import Picture, picture
from reports.plots.steady_cycle import best_run, cycle_axis, direction, fraction
from reports.plots.style import FONT_SIZE, SMALL, new_figure, tidy

Array = NDArray[np.float64]

HIGHEST: Final = 180.0  # Hz
STEP: Final = 1.5  # Hz, between the rows
INSTANTS: Final = 240  # of a cycle
WINDOW: Final = 0.7  # standard deviation of the window in periods of the mean first mode: 1.4 of its half bandwidths in frequency
RIGID_WINDOW: Final = 1.0 / 12.0  # of a cycle, where there is no first mode
RANGE: Final = 60.0  # dB shown below the largest value: a settled cycle closes to 1e-3, so that nothing below is certain
LEVEL: Final = 5.0  # dB between two shades
COLOURS: Final = 64  # of the picture: shades, their edges, lines


def spectrogram_figure(result: CaseResult, scale: TimeScale | None) -> Picture | None:
    """Spectrogram of the reference's tip acceleration (of the next best engine's if it has none), with f1, f2, f3 drawn over it.

    Args:
        result: of a case.
        scale: the case's natural frequencies over the crank angle; None for a rigid follower.

    Returns:
        None where no engine has a cycle to show.
    """
    figure = draw_spectrogram(result, scale)
    best = best_run(result)
    if figure is None or best is None:
        return None
    alt = f"{result.case.name}: spectrogram of the tip acceleration over the steady cycle, engine {best[0]}, 0 to {HIGHEST:.0f} Hz in dB"
    return picture(figure, alt + (", with the first three natural frequencies" if scale is not None else ""), COLOURS)


def draw_spectrogram(result: CaseResult, scale: TimeScale | None) -> Figure | None:
    """The figure before it is rendered; see `spectrogram_figure`."""
    best = best_run(result)
    if best is None:
        return None
    name, run = best
    time, angle = run.cycle["time"], run.cycle["crank_angle"]
    frequencies = np.arange(0.0, HIGHEST + STEP / 2.0, STEP)
    mean_first = float(np.mean(scale.frequencies(angle)[:, 0])) if scale is not None else None
    window = WINDOW / mean_first if mean_first else RIGID_WINDOW * (time[-1] - time[0])
    instants = np.linspace(time[0], time[-1], INSTANTS + 1)
    amplitude = spectrogram(time, run.cycle["tip_acceleration"], instants, frequencies, window)
    level = 20.0 * np.log10(np.maximum(amplitude, 1e-12))
    top = LEVEL * np.ceil(level.max() / LEVEL)

    figure = new_figure(4.0)
    axes = figure.subplots()
    at_instants = CubicSpline(time, fraction(angle))(instants)
    shades = axes.contourf(
        at_instants, frequencies, np.maximum(level, top - RANGE), np.arange(top - RANGE, top + 0.5 * LEVEL, LEVEL), cmap="cividis"
    )
    if scale is not None:
        for mode, values in enumerate(scale.frequencies(angle).T, start=1):
            (line,) = axes.plot(fraction(angle), values, color="white", linewidth=1.3, linestyle=(0, (5, 2)))
            line.set_path_effects([effects.withStroke(linewidth=2.8, foreground="black")])
            text = axes.text(
                0.03, values[int(0.03 * values.size)] + 2.5, f"f{'₁₂₃'[mode - 1]}", color="white", fontsize=FONT_SIZE, va="bottom"
            )
            text.set_path_effects([effects.withStroke(linewidth=2.0, foreground="black")])
    tidy(axes, None, "frequency (Hz)", "none")
    cycle_axis([axes], direction(run), "white")
    axes.text(0.98, 0.97, name, transform=axes.transAxes, color="white", fontsize=SMALL, ha="right", va="top")
    axes.set_ylim(0.0, HIGHEST)
    bar = figure.colorbar(shades, ax=axes, location="right", fraction=0.06, pad=0.02, ticks=np.arange(top - RANGE, top + 1.0, 4 * LEVEL))
    bar.set_label("tip acceleration (dB re 1 m/s²)", fontsize=FONT_SIZE)
    bar.ax.tick_params(labelsize=SMALL, length=2.5, width=0.6)
    return figure


def spectrogram(time: Array, signal: Array, instants: Array, frequencies: Array, window: float) -> Array:
    """Amplitude of a periodic signal about each instant and frequency, through a Gaussian window that wraps around the period.

    A steady sine of amplitude a, far from 0 Hz against 1/(2 pi window), gives a at its frequency.

    Args:
        time: s, increasing, shape (n,), from the start of a period to its end.
        signal: shape (n,).
        instants: s, within the period, shape (m,).
        frequencies: Hz, shape (k,).
        window: s, standard deviation.

    Returns:
        Shape (k, m).
    """
    period = time[-1] - time[0]
    samples = 2 * time.size
    uniform = time[0] + period * np.arange(samples) / samples
    spectrum = np.fft.rfft(CubicSpline(time, signal)(uniform)) / samples
    spectrum[1:] *= 2.0  # a line and its mirror image at the negative frequency
    harmonics = np.arange(spectrum.size) / period
    gains = np.exp(-0.5 * (2.0 * np.pi * window * (frequencies[:, None] - harmonics)) ** 2)
    keep = harmonics < frequencies.max() + 6.0 / (2.0 * np.pi * window)
    turning = np.exp(2j * np.pi * harmonics[keep, None] * (instants - time[0]))
    return np.abs((gains[:, keep] * spectrum[keep]) @ turning)
