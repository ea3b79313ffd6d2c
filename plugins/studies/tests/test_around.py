"""A machine's own place on its resonance curve: what the curve says of the machine."""

import dataclasses

import pytest

from quickreturn.plugins.studies.around import Around
from quickreturn.plugins.studies.tests.made_up_resonance import FOLD, OWN, PEAK, RPM, height, made_up_around, speed
from tests.reports.pages import plain


@pytest.fixture(scope="module")
def around() -> Around:
    return made_up_around()


def test_the_machine_has_every_motion_at_its_speed(around: Around) -> None:
    heights, kinds = zip(*around.motions, strict=True)
    assert heights == pytest.approx([height(-OWN), height(0.0), height(OWN)], rel=1e-5)  # splines of points 1/30 apart
    assert kinds == ("", "fold", "")
    assert around.peak == around.curve.peaks[0]
    assert around.change == min(around.curve.special, key=lambda each: abs(each.value - around.own))


def test_the_sentences_have_the_motions_and_what_is_nearest(around: Around) -> None:
    told = " ".join(around.lines)
    assert "three periodic motions, two of them stable" in told
    assert f"{float(f'{height(0.0):.2g}'):g} m/s^2 (unstable: fold)" in told
    own = around.own / RPM
    # the peak at u = PEAK, and the fold that lies 2 % above: 1 + WIDTH (8 u^3 - 3 u) / 5 at -FOLD
    for u in (PEAK, -FOLD):
        assert f"{own * speed(u):.5g} rpm" in told
        assert f"{own * (speed(u) - 1.0):.3g} rpm or {100.0 * (speed(u) - 1.0):.1f} % faster" in told


def test_a_harmonic_without_a_peak_is_no_alarm(around: Around) -> None:
    bare = dataclasses.replace(around, curve=dataclasses.replace(around.curve, peaks=()))
    assert "the 9th harmonic" in plain(bare.without_effect)
    reach = f"between {0.85 * around.own / RPM:.5g} rpm and {1.15 * around.own / RPM:.5g} rpm"
    assert f"no peak {reach}" in plain(bare.nearest)
    of_it = dataclasses.replace(around.curve.peaks[0], order=9)
    assert dataclasses.replace(around, curve=dataclasses.replace(around.curve, peaks=(of_it,))).without_effect == ""
    nothing = dataclasses.replace(around, curve=dataclasses.replace(around.curve, peaks=(), special=()))
    assert f"no fold and no loss of stability {reach}" in plain(nothing.nearest)
