"""A benchmark with known numbers: errors fall as a power of the degrees of freedom, times grow with them."""

from quickreturn.cases.benchmark import Benchmark
from quickreturn.cases.benchmark.findings import Measured, Point
from quickreturn.cases.benchmark.truth import Confirmation, Converged

COLUMNS = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
#: Method -> engine, order of the error, error with one degree of freedom, seconds per degree of freedom.
METHODS = {
    "reference": ("reference", 4.0, 0.1, 1e-3),
    "multiplier": ("multiplier", 3.0, 1.0, 1e-2),
    "multiplier, elements": ("multiplier", 4.0, 30.0, 2e-2),
    "exudyn": ("exudyn", 2.0, 2.0, 0.1),
    "thesis": ("thesis", 0.0, 0.8, 1e-2),
}


def made_up_benchmark(case: str = "thesis-24", confirmed: bool = True, timed: bool = False) -> Benchmark:
    """With `timed` estimates of the errors that take as long as 9 solutions of `reference`, and as 1 of any other engine."""
    points = []
    for method, (engine, order, error, pace) in METHODS.items():
        for free in (2, 4, 8, 16):
            settings = {"modes": free, "tolerance": 1e-7} if engine == "reference" else {"elements": free}
            measured = Measured(
                degrees_of_freedom=free,
                errors=dict.fromkeys(COLUMNS, error * free ** (-order)),
                solve_seconds=pace * free,
                solve_seconds_median=1.1 * pace * free,
                solve_seconds_largest=1.2 * pace * free,
                repetitions=5,
                setup_seconds=0.01,
                statistics={"right_hand_side_calls": 1000.0 * free, "integration_seconds": 0.9 * pace * free, "largest_gap": 1e-9},
                calls_per_period=12.0 if engine == "reference" else None,
                estimate_seconds=(9.0 if engine == "reference" else 1.0) * pace * free if timed else None,
            )
            known = {"method": method, "engine": engine, "settings": settings | {"always": 1}, "changing": settings}
            points.append(Point(**known, status="completed", measured=measured))
    status = "failed at t = 0.1 s: the beam snapped; try another beam"
    failed = {"settings": {"elements": 2}, "changing": {"elements": 2}, "status": status}
    points.append(Point(method="nodal-load", engine="nodal-load", **failed))
    return Benchmark(
        case=case,
        title="a title",
        duration=2.0,
        truth=Converged("reference", {"modes": 11}, dict.fromkeys(COLUMNS, 0.01)),
        confirmation=Confirmation("mujoco", {"links": 60}, dict.fromkeys(COLUMNS, 1e-4 if confirmed else 1e-2)),
        points=tuple(points),
        repetitions=5,
        longest=10.0,
        machine={"processor": "one"},
    )
