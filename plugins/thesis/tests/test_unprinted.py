"""What the thesis' chapter says of the quantities that are not printed."""

import dataclasses

from quickreturn.plugins.thesis import records
from quickreturn.plugins.thesis.page_data import bands_of
from quickreturn.plugins.thesis.scatter import EXCESS, UNPRINTED
from quickreturn.plugins.thesis.tests.made_up_finding import BAND
from quickreturn.plugins.thesis.unprinted import bands as banded
from quickreturn.plugins.thesis.unprinted import unprinted
from quickreturn.reports.long_studies import text_of
from tests.reports.pages import one_run
from tests.reports.pages import text_of as told_of


def test_the_page_says_whether_the_halves_differ() -> None:
    other = dataclasses.replace(BAND, ratio=(0.97, 0.98, 1.0), apart=9)
    for band, apart, denied in ((BAND, "none of 14 points", True), (other, "9 of 14 points", False)):
        told = told_of(one_run(data={bands_of: [band]}))
        assert apart in told
        assert ("do not make the halves differ" in told) == denied


def test_the_tables_hold_every_band_and_every_assumed_range() -> None:
    frame = banded([BAND]).frame
    assert frame["strain_high [1]"].tolist() == [8.4e-4]
    assert frame["points"].tolist() == [16]
    assert unprinted().frame["distribution"].tolist() == [each.distribution for each in UNPRINTED]


def test_the_recorded_bands_are_small_and_of_all_runs() -> None:
    recorded = records.bands()
    assert [each.run for each in recorded] == list(range(1, 25))
    assert len(text_of(recorded)) < 6000
    # the words ask for a machine whose frequency after the return is at most 1 / EXCESS of that before it
    assert all(each.ratio[1] > 1.0 / EXCESS for each in recorded if each.ratio)
