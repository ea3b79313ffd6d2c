"""Changing any one sign, product or constant of the equations makes a comparison with what is known of them fail."""

import pytest

from quickreturn.plugins.derive.tests.mutation.mutants import HUNTS
from quickreturn.plugins.derive.tests.mutation.mutation import Hunt, original

pytestmark = pytest.mark.parametrize("hunt", HUNTS.values(), ids=list(HUNTS))


@pytest.mark.verify
def test_the_unchanged_source_agrees(hunt: Hunt) -> None:
    assert max(hunt.exercise(original(hunt.source))) < hunt.tolerance


@pytest.mark.verify
def test_every_term_is_evaluated(hunt: Hunt) -> None:
    """No branch of the equations escapes the states of the checks."""
    refusals = "1"  # of a state that cannot be, in place of -1
    assert [str(site) for site in hunt.sites[1] if site.flip != refusals] == []


@pytest.mark.verify
def test_every_mutant_is_caught(hunt: Hunt) -> None:
    assert len(hunt.sites[0]) > hunt.least
    assert hunt.survivors(hunt.sites[0]) == []


@pytest.mark.verify
def test_every_equivalent_mutant_still_exists(hunt: Hunt) -> None:
    assert set(hunt.equivalent) <= {(site.function, site.flip) for site in hunt.sites[0]}
