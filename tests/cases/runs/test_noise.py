"""The departure of rows from a smooth course: noise and rounding of a known size."""

import math

import numpy as np
import pytest

from quickreturn.cases.runs.noise import DEVIATIONS, scatter

TIME = np.arange(1000) * 1e-3
SMOOTH = 3.0 * np.sin(2.0 * np.pi * 7.3 * TIME)


def test_noise_has_its_size() -> None:
    noise = 0.05 * np.random.default_rng(1).standard_normal(len(TIME))
    assert scatter(TIME, SMOOTH + noise) == pytest.approx(DEVIATIONS * 0.05, rel=0.1)


def test_rounding_has_the_size_of_uniform_noise() -> None:
    assert scatter(TIME, np.round(SMOOTH, 2)) == pytest.approx(DEVIATIONS * 0.01 / np.sqrt(12.0), rel=0.1)


def test_a_smooth_course_has_none_and_few_rows_show_none() -> None:
    assert scatter(TIME, SMOOTH) < 1e-4
    assert scatter(TIME[:4], SMOOTH[:4]) == math.inf
