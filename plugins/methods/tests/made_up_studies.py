"""Made-up studies of accuracy and cost."""

from dataclasses import replace

from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.plugins.methods.accuracy import Prescribed, Studies
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.plugins.methods.trials.truth import Truth

ERRORS = dict.fromkeys(("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force"), 0.001)


def errors(part: float = 1.0) -> dict[str, float | None]:
    return {name: part * error for name, error in ERRORS.items()}


def studied(engine: str, part: float = 1.0) -> Trial:
    numbers = {"degrees_of_freedom": 17, "solve_seconds": 1.5, "setup_seconds": 0.1}
    return Trial(scene="thesis-24", engine=engine, settings={"step": 1e-4}, claim=9e-4, errors=errors(part), **numbers)


def rung(modes: int) -> Trial:
    return replace(studied("reference", 100.0 / modes), settings=ReferenceSettings(modes=modes, tolerance=1e-9).as_dict())


def made_up_studies() -> Studies:
    """All parts of the studies, in which nothing failed."""
    return Studies(
        accuracy=[studied(name) for name in ("thesis", "reference")],
        converged=Truth("reference", {"modes": 9}, {}),
        confirming=[Trial(scene="thesis-24", engine="exudyn", settings={"elements": 32}, errors=errors())],
        prescribed=Prescribed(errors(300.0), [studied("moving-boundaries", 90.0), studied("moving-boundaries", 20.0)]),
        convergence=[rung(modes) for modes in (2, 4, 8)],
        failures=(),
    )
