"""Noise is told by its spectrum: signals whose noise is known."""

import numpy as np
import pytest

from quickreturn.cases.runs.noise import white_noise

TIME = np.arange(1000) * 1e-3


def test_noise_beside_a_slow_signal_is_white_above_it() -> None:
    random, found = np.random.default_rng(1), []
    for _ in range(20):
        slow = 2.0 * np.sin(2.0 * np.pi * 5.0 * TIME) / np.sqrt(2.0)
        noise = white_noise(TIME, 1.5 * random.standard_normal(len(TIME)) + slow)
        assert noise is not None
        found.append(noise.rms)
        assert 4.0 < noise.above < 16.0  # a band reaches down to half its highest frequency
    assert np.mean(found) == pytest.approx(1.5, rel=0.03)


@pytest.mark.parametrize("digits", [1, 2])
def test_rounding_looks_like_noise_of_the_known_size(digits: int) -> None:
    """Uniform between half a digit: an RMS of the digit over the square root of 12."""
    values = 3.0 * np.sin(2.0 * np.pi * 7.3 * TIME) + np.sin(2.0 * np.pi * 31.7 * TIME)
    noise = white_noise(TIME, np.round(values, digits) - values)
    assert noise is not None
    assert noise.rms == pytest.approx(10.0**-digits / np.sqrt(12.0), rel=0.1)


@pytest.mark.parametrize(
    "difference",
    [
        np.sin(2.0 * np.pi * 16.0 * TIME),  # a vibration
        np.exp(-3.0 * TIME) * np.sin(2.0 * np.pi * 230.0 * TIME),  # of a high mode
        TIME**2,
        np.zeros(1000),
        np.sign(np.sin(2.0 * np.pi * 3.0 * TIME)),
    ],
)
def test_what_is_no_noise_is_not_called_so(difference: np.ndarray) -> None:
    assert white_noise(TIME, difference) is None


def test_of_few_or_uneven_rows_noise_is_not_told() -> None:
    values = np.random.default_rng(2).standard_normal(1000)
    assert white_noise(TIME[:40], values[:40]) is None
    assert white_noise(TIME**1.01, values) is None
