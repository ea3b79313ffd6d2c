"""A resonance curve that was interrupted, killed or lost goes on."""

import math
from pathlib import Path

import numpy as np
import pytest

import quickreturn as qr
from quickreturn.cases.running.key import key_of
from quickreturn.cases.running.records import Pieces, encoded
from quickreturn.plugins.studies.resonance_curve.curve import Range, range_of
from quickreturn.plugins.studies.resonance_curve.search import _followed, job
from quickreturn.reference_model.cycles.cycle_family import CycleFamily
from quickreturn.reference_model.cycles.fixed_points import Array, Image
from quickreturn.reference_model.cycles.poincare import CycleBroken
from quickreturn.reference_model.mechanism import Mechanism


class _Interrupted(Exception):
    pass


def test_an_interrupted_curve_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped several times, it evaluates each time at most one piece of cycles anew; the curve has the same bits."""
    monkeypatch.setattr("quickreturn.plugins.studies.resonance_curve.search.PIECE", 3)
    asked = job(qr.case("thesis-24"), range_of("crank.prescribed_speed", "150 rpm .. 165 rpm", "range"), accuracy=0.05, claims=False)
    plain, cycles, left = CycleFamily.image, [0], [math.inf]

    def image(family: CycleFamily, point: Array, value: float) -> Image:
        cycles[0] += 1
        left[0] -= 1
        if left[0] < 0:
            raise _Interrupted
        return plain(family, point, value)

    monkeypatch.setattr(CycleFamily, "image", image)
    whole = asked.function(*asked.arguments)
    alone, cycles[0], stops = cycles[0], 0, 0
    while True:
        left[0] = max(60, alone // 4)
        try:
            resumed = asked.function(*asked.arguments, Pieces(str(tmp_path), key_of(asked)))
            break
        except _Interrupted:
            stops += 1
    assert stops >= 2
    assert cycles[0] <= alone + stops * 60
    assert encoded(resumed).document == encoded(whole).document
    for name, values in encoded(whole).arrays.items():
        assert np.array_equal(values, encoded(resumed).arrays[name], equal_nan=True)


class Gap(CycleFamily):
    """A family of one motion x = a that has no image between 0.1 and 0.4."""

    def __init__(self) -> None:
        pass

    def scene_at(self, value: float) -> Mechanism:
        return qr.case("rigid").mechanism

    def orbit(self, value: float) -> Array:
        return np.array([value])

    def image(self, point: Array, parameter: float) -> Image:
        if 0.1 < parameter < 0.4:
            raise CycleBroken("it broke")
        return Image(0.5 * (point + parameter), np.ones(1), np.full(1, 1e-16))


def test_a_curve_that_is_lost_is_begun_again_beyond() -> None:
    branch = _followed(Gap(), Range("tip.mass", 0.0, 1.0, "kg", 1.0), lambda kind, compute: compute())
    before, after = branch.endings
    assert after is None
    assert before is not None
    assert "it broke" in before.reason
    assert [round(branch.points[at].parameter, 4) for at in (0, -1)] == [0.4, 1.0]
