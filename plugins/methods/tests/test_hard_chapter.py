"""The page of the hard scenes, on a made-up matrix."""

from dataclasses import replace

import pytest

from quickreturn.cases.library.hard import IMPOSSIBLE
from quickreturn.plugins.methods.chapters import hard as tables
from quickreturn.plugins.methods.chapters.hard import finding
from quickreturn.plugins.methods.judging.matrix import Matrix
from quickreturn.plugins.methods.judging.verdicts import (
    ACCURATE,
    MEANINGS,
    OWN_EQUATIONS,
)
from quickreturn.plugins.methods.tests import pages
from quickreturn.plugins.methods.tests.made_up_matrix import VERDICTS, made_up_matrix
from quickreturn.plugins.methods.tests.pages import plain
from tests.reports.reported_results import PageReader


def read(found: Matrix | None) -> PageReader:
    return pages.read(pages.one_run(hard_scenes=found))


def test_the_heading_counts_each_verdict_and_every_claim_that_was_checked() -> None:
    told = plain(finding(made_up_matrix()))
    for kind in ("Of 7 cells 1 accurate", "model is 81 % off", "1 ended", "1 not converged", "1 contradicted", "1 diverged", "1 refused"):
        assert kind in told
    assert "none silently wrong of 3 claims that could be checked, 1 of them" in told
    assert "1 claim did not hold of 3" in plain(finding(made_up_matrix(wrong=True)))
    found = made_up_matrix()
    of_model = found.cells["hard-speed-x3", "thesis"]
    second = replace(of_model, scene="hard-speed-x2", model_error=1.13, holds=False)
    several = plain(finding(replace(found, cells={("hard-speed-x3", "thesis"): of_model, ("hard-speed-x2", "thesis"): second})))
    assert "2 solve their own equations alone (thesis, whose model is 81 to 113 % off there)" in several


def test_every_cell_says_its_verdict_in_words() -> None:
    (first, second) = read(made_up_matrix()).tables["hard_scenes.csv"]
    texts = [text.replace("\N{NO-BREAK SPACE}", " ") for text, _ in (*first, *second)]
    assert texts == [
        "crank speed x 2",
        "✗ diverged at 0.09 s",
        "accurate 0.4 % up to 0.42 s, then in energy, extremes and spectrum",
        "✗ not converged",
        "✗ contradicted",
        "crank speed x 3: the slider leaves the follower",
        "solves its own equations; its model is 81 % off",
        "ends at 0.2526 s, until then accurate 0.5 %",
        "refused",
        "not computed",
    ]


@pytest.mark.parametrize(("model_error", "kind"), [(0.81, OWN_EQUATIONS), (None, OWN_EQUATIONS), (0.011, OWN_EQUATIONS), (0.009, ACCURATE)])
def test_a_cell_of_a_model_is_accurate_only_if_the_model_is(model_error: float | None, kind: str) -> None:
    known = made_up_matrix().cells["hard-speed-x3", "thesis"]
    found = made_up_matrix()
    changed = replace(found, cells={**found.cells, ("hard-speed-x3", "thesis"): replace(known, model_error=model_error)})
    told = plain(finding(changed))
    assert f"Of 7 cells {1 + (kind == ACCURATE)} accurate, " in told  # that of reference besides
    off = {0.81: " (thesis, whose model is 81 % off there)", 0.011: " (thesis, whose model is 1.1 % off there)"}.get(model_error or 0.0, "")
    assert (f"1 solves its own equations alone{off}, " in told) == (kind == OWN_EQUATIONS)
    cell = tables.verdicts(changed).rows[1]["thesis"]
    assert (cell.value, cell.mark == "good") == (kind, kind == ACCURATE)
    others = [cell for cell in changed.cells.values() if cell.engine != "thesis"]
    assert all(cell.kind == cell.verdict.kind for cell in others)


def test_reasons_and_evidence_go_into_the_files() -> None:
    found = tables.verdicts(made_up_matrix()).csv()
    for verdict in VERDICTS.values():
        assert verdict.reason in found
    every = tables.cells(made_up_matrix()).csv().splitlines()
    assert len(every) == 1 + len(VERDICTS)
    assert every[2] == "hard-speed-x2,reference,accurate,estimated error 0.004,0.004,0.42,,0.003,True,,modes = 5"


def test_the_page_explains_itself_and_tells_what_was_checked() -> None:
    text = read(made_up_matrix()).text
    assert all(meaning in text for meaning in MEANINGS.values())
    assert all(sentence in text for sentence in IMPOSSIBLE.values())
    assert "none silently wrong of 3 claims that could be checked, 1 of them against a model’s own equations" in text
    assert "1\N{NO-BREAK SPACE}cell of the matrix has not been computed" in text


def test_a_claim_that_does_not_hold_is_shouted() -> None:
    found = read(made_up_matrix(wrong=True))
    assert "1\N{NO-BREAK SPACE}claim did not hold of 3" in found.text
    assert "Claims that did not hold: reference in hard-speed-x2" in found.text
    assert "silently wrong: claims 0.4" in found.text
    assert "none silently wrong" not in found.text


def test_without_results_there_is_no_made_up_matrix() -> None:
    assert "hard" not in read(None).anchors
