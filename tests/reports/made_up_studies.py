"""Made-up studies of accuracy and cost."""

from quickreturn.cases.benchmark.findings import Measured, Point
from quickreturn.cases.benchmark.truth import Confirmation, Converged
from quickreturn.cases.runs.request import Run
from quickreturn.cases.studies import BothStarts, Prescribed, StudiedRun, Studies
from quickreturn.engines.own.reference import ReferenceSettings

ERRORS = dict.fromkeys(("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force"), 0.001)


def made_up_both_starts(difference: float = 6e-4) -> BothStarts:
    orbit, straight = (
        Run(engine="exudyn", estimate_of="total", status="settled", cycles=cycles, settling_error=left)
        for cycles, left in ((4, 5e-4), (25, 9e-4))
    )
    return BothStarts("exudyn", orbit, straight, difference)


def errors(part: float = 1.0) -> dict[str, float | None]:
    return {name: part * error for name, error in ERRORS.items()}


def studied(engine: str, part: float = 1.0) -> StudiedRun:
    numbers = {"degrees_of_freedom": 17, "solve_seconds": 1.5, "setup_seconds": 0.1}
    return StudiedRun(engine=engine, settings={"step": 1e-4}, error_estimate=9e-4, errors=errors(part), **numbers)


def rung(modes: int) -> Point:
    measured = Measured(
        degrees_of_freedom=17,
        errors=errors(100.0 / modes),
        solve_seconds=1.5,
        solve_seconds_median=1.5,
        solve_seconds_largest=1.5,
        repetitions=1,
        setup_seconds=0.1,
        statistics={},
        calls_per_period=None,
    )
    settings = ReferenceSettings(modes=modes, tolerance=1e-9).as_dict()
    return Point(method="reference", engine="reference", settings=settings, changing=settings, status="completed", measured=measured)


def made_up_studies() -> Studies:
    """All parts of the studies, in which nothing failed."""
    return Studies(
        accuracy=[studied(name) for name in ("thesis", "reference")],
        converged=Converged("reference", {"modes": 9}, {}),
        confirming=[Confirmation("exudyn", {"elements": 32}, errors())],
        prescribed=Prescribed(errors(300.0), [studied("moving-boundaries", 90.0), studied("moving-boundaries", 20.0)]),
        convergence=[rung(modes) for modes in (2, 4, 8)],
        both_starts=[made_up_both_starts()],
        failures=(),
    )
