"""The emulator: it gives back what it can know, and says how wrong it is where it has not seen a machine."""

import numpy as np
import pytest

from quickreturn.plugins.thesis.inference.emulator import FEWEST, Emulator, features
from quickreturn.plugins.thesis.inference.unknowns import NAMES, SOBOL, points, spread

GENERATOR = np.random.default_rng(7)
MACHINES = spread(GENERATOR.random((120, len(NAMES))))
OTHERS = spread(GENERATOR.random((400, len(NAMES))))


def law(machines: np.ndarray) -> np.ndarray:
    """A smooth number that no polynomial of the features is."""
    return np.sin(2.0 * machines[:, 0]) + 0.3 * np.exp(-machines[:, 4]) * np.log(machines[:, 5])


def test_the_error_at_unseen_machines_is_the_one_that_it_states() -> None:
    noise = 0.02 * GENERATOR.standard_normal(len(MACHINES))
    found = Emulator(features(MACHINES), features(OTHERS))(law(MACHINES) + noise)
    actual = np.sqrt(np.mean((found.mean - law(OTHERS)) ** 2 + 0.02**2))  # what is unseen has noise, too
    assert 0.6 < found.error / actual < 1.6


def test_a_linear_number_is_exact_and_missing_ones_are_left_out() -> None:
    known, wanted = features(MACHINES), features(OTHERS)
    values = known @ np.arange(1.0, known.shape[1] + 1.0)
    values[::5] = np.nan
    found = Emulator(known, wanted)(values)
    assert found.mean == pytest.approx(wanted @ np.arange(1.0, known.shape[1] + 1.0), abs=0.02)
    assert found.count == 96


def test_too_few_machines_give_no_number() -> None:
    values = np.full(len(MACHINES), np.nan)
    values[: FEWEST - 1] = 1.0
    assert np.isinf(Emulator(features(MACHINES), features(OTHERS))(values).error)


def test_a_tight_preload_makes_both_sides_alike_and_a_rigid_joint_has_no_compliance() -> None:
    loose, tight = ({"plus": 10.0, "minus": 300.0, "joint": joint} for joint in (0.0, 1.0))
    base = dict(zip(NAMES, points()[0], strict=True))
    plus, minus = features(np.array([[{**base, **of}[name] for name in NAMES] for of in (loose, tight)])).T[1:3]
    assert plus[0] > 10.0 * minus[0]
    assert plus[1] == pytest.approx(minus[1])
    assert features(points()[:1])[0, 1:3] == pytest.approx(0.0)


def test_points_are_the_same_every_time_and_lie_within_their_ranges() -> None:
    assert np.array_equal(points(), points())
    assert len(np.unique(points(), axis=0)) == len(points()) > SOBOL
