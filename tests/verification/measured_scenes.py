"""A cycle made of two synthetic halves in every channel, for the tests of the measures."""

import functools

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_simpson

from quickreturn.cases.motion.time_scale import TimeScale, time_scale
from tests.verification.measures_accuracy import thesis_scene

Array = NDArray[np.float64]


@functools.cache
def scale_of_run(run: int) -> tuple[TimeScale, float]:
    """Time scale of a thesis run and its crank speed in rad/s."""
    mechanism, speed = thesis_scene(run)
    scale = time_scale(mechanism)
    assert scale is not None
    return scale, speed


def vibrating_cycle(
    scale: TimeScale, speed: float, factor: float, amplitude: float, second: tuple[float, float] = (1.0, 0.0), samples: int = 801
) -> tuple[Array, Array, dict[str, Array]]:
    """Time, crank angle and all channels: slow shape of unit RMS plus first and second mode, without noise.

    `factor` and `amplitude`: of the first mode, over its own frequency and times its template; `second`: the same of the second mode.
    """
    time = np.linspace(0.0, 2.0 * np.pi / speed, samples)
    crank_angle = np.pi + speed * time
    speeds = np.full(samples, speed)
    phases = cumulative_simpson(2.0 * np.pi * scale.running_frequencies(crank_angle, speeds).T, x=time, initial=0.0)
    channels = {}
    for name in scale.channels:
        templates = scale.templates[name](crank_angle).T
        late = scale.quadratures[name](crank_angle) * speeds
        channels[name] = (
            scale.slow_shapes[name](crank_angle)
            + amplitude * (templates[0] * np.cos(factor * phases[0]) + late * np.sin(factor * phases[0]))
            + second[1] * templates[1] * np.cos(second[0] * phases[1] + 0.7)
        )
    return time, crank_angle, channels
