"""The page of the hard scenes, on a made-up matrix."""

from dataclasses import replace

import pytest

from quickreturn.cases.case_file import load_case
from quickreturn.cases.judging.conditioning import Conditioning
from quickreturn.cases.judging.matrix import Judged, Matrix
from quickreturn.cases.judging.verdicts import (
    ACCURATE,
    CONTRADICTED,
    DIVERGED,
    ENDED,
    MEANINGS,
    NOT_CONVERGED,
    OWN_EQUATIONS,
    REFUSED,
    Verdict,
)
from quickreturn.cases.library.hard import IMPOSSIBLE
from quickreturn.reports.page.facts.methods import hard_scenes
from quickreturn.reports.tables import hard_scenes as tables
from tests.reports import pages
from tests.reports.reported_results import PageReader

SCENES = ("hard-speed-x2", "hard-speed-x3")
ENGINES = ("thesis", "reference", "exudyn", "mujoco")
VERDICTS = {
    ("hard-speed-x2", "thesis"): Verdict(DIVERGED, "failed at t = 0.09 s: the loop cannot close", time=0.09),
    ("hard-speed-x2", "reference"): Verdict(ACCURATE, "estimated error 0.004", 0.004, 0.42),
    ("hard-speed-x2", "exudyn"): Verdict(NOT_CONVERGED, "the estimated error 0.83 exceeds the 0.01 asked"),
    ("hard-speed-x2", "mujoco"): Verdict(CONTRADICTED, "differs from reference by 0.1"),
    ("hard-speed-x3", "thesis"): Verdict(ACCURATE, "estimated error 0.0001", 0.0001, 2.0),
    ("hard-speed-x3", "reference"): Verdict(ENDED, "the slider leaves", 0.005, 0.24, 0.2526, 1e-3),
    ("hard-speed-x3", "exudyn"): Verdict(REFUSED, "slider.inertia: no"),
}


def matrix(*, wrong: bool = False) -> Matrix:
    cells = {}
    for (scene, engine), verdict in VERDICTS.items():
        known = {} if verdict.claimed_error is None else {"settings": {"modes": 5}, "true_error": 0.003, "holds": True}
        cells[scene, engine] = Judged(scene=scene, engine=engine, verdict=verdict, **{"settings": {}, **known})  # type: ignore[arg-type]
    of_model = {"settings": {}, "true_error": 1e-5, "model_error": 0.81}
    cells["hard-speed-x3", "thesis"] = replace(cells["hard-speed-x3", "thesis"], **of_model)  # type: ignore[arg-type]
    if wrong:
        cells["hard-speed-x2", "reference"] = replace(cells["hard-speed-x2", "reference"], settings={}, true_error=0.83, holds=False)
    changes = {"stiffness": 0.108, "damping": 0.006, "speed": 0.14, "speed at the same crank angle": 0.07}
    conditionings = {"hard-speed-x2": Conditioning(changes, 0.42)}
    return Matrix(tuple(load_case(name) for name in SCENES), ENGINES, cells, conditionings, {"hard-speed-x2": 5e-4})


def read(found: Matrix | None) -> PageReader:
    return pages.read(pages.one_run(hard_scenes=found))


def test_every_cell_says_its_verdict_in_words() -> None:
    (first, second) = read(matrix()).tables["hard_scenes.csv"]
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
    known = matrix().cells["hard-speed-x3", "thesis"]
    found = matrix()
    changed = replace(found, cells={**found.cells, ("hard-speed-x3", "thesis"): replace(known, model_error=model_error)})
    facts = hard_scenes(pages.one_run(hard_scenes=changed))
    assert facts is not None
    assert facts["kinds"].get(ACCURATE, 0) == 1 + (kind == ACCURATE)  # that of reference besides
    assert facts["kinds"].get(OWN_EQUATIONS, 0) == (kind == OWN_EQUATIONS)
    cell = tables.verdicts(changed).rows[1]["thesis"]
    assert (cell.value, cell.mark == "good") == (kind, kind == ACCURATE)
    others = [cell for cell in changed.cells.values() if cell.engine != "thesis"]
    assert all(cell.kind == cell.verdict.kind for cell in others)


def test_reasons_and_evidence_go_into_the_files() -> None:
    found = tables.verdicts(matrix()).csv()
    for verdict in VERDICTS.values():
        assert verdict.reason in found
    every = tables.cells(matrix()).csv().splitlines()
    assert len(every) == 1 + len(VERDICTS)
    assert every[2] == "hard-speed-x2,reference,accurate,estimated error 0.004,0.004,0.42,,0.003,True,,modes = 5"


def test_the_page_explains_itself_and_tells_what_was_checked() -> None:
    text = read(matrix()).text
    assert all(meaning in text for meaning in MEANINGS.values())
    assert all(sentence in text for sentence in IMPOSSIBLE.values())
    assert "none silently wrong of 3 claims that could be checked, 1 of them against a model’s own equations" in text
    assert "1\N{NO-BREAK SPACE}cell of the matrix has not been computed" in text


def test_a_claim_that_does_not_hold_is_shouted() -> None:
    found = read(matrix(wrong=True))
    assert "1\N{NO-BREAK SPACE}claim did not hold of 3" in found.text
    assert "Claims that did not hold: reference in hard-speed-x2" in found.text
    assert "silently wrong: claims 0.4" in found.text
    assert "none silently wrong" not in found.text


def test_without_results_there_is_no_matrix() -> None:
    assert "hard" not in read(None).anchors
