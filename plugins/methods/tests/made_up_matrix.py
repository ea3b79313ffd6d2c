"""A made-up matrix of verdicts on two hard scenes: each verdict occurs, and one cell is missing."""

from dataclasses import replace

from quickreturn.cases.files.case_file import load_case
from quickreturn.plugins.methods.judging.conditioning import Conditioning
from quickreturn.plugins.methods.judging.matrix import Judged, Matrix
from quickreturn.plugins.methods.judging.verdicts import ACCURATE, CONTRADICTED, DIVERGED, ENDED, NOT_CONVERGED, REFUSED, Verdict

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


def made_up_matrix(*, wrong: bool = False) -> Matrix:
    """With `wrong` a claim of the reference does not hold."""
    cells = {}
    for (scene, engine), verdict in VERDICTS.items():
        known = {} if verdict.claimed_error is None else {"settings": {"modes": 5}, "true_error": 0.003, "holds": True}
        cells[scene, engine] = Judged(scene=scene, engine=engine, verdict=verdict, **{"settings": {}, **known})  # type: ignore[arg-type]
    of_model = {"settings": {}, "true_error": 1e-5, "model_error": 0.81}
    cells["hard-speed-x3", "thesis"] = replace(cells["hard-speed-x3", "thesis"], **of_model)  # type: ignore[arg-type]
    if wrong:
        cells["hard-speed-x2", "reference"] = replace(cells["hard-speed-x2", "reference"], settings={}, true_error=0.83, holds=False)
    changes = {"stiffness": 0.108, "damping": 0.006, "speed": 0.14, "speed at the same crank angle": 0.07}
    conditionings = {"hard-speed-x2": Conditioning(changes, 0.42, "hard-speed-x2", 5e-4)}
    return Matrix(tuple(load_case(name) for name in SCENES), ENGINES, cells, conditionings)
