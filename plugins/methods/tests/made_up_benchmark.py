"""A benchmark with known numbers: errors fall as a power of the degrees of freedom, times grow with them."""

from quickreturn.plugins.methods.benchmark import Benchmark
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.plugins.methods.trials.truth import Truth

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
    trials = []
    for method, (engine, order, error, pace) in METHODS.items():
        for free in (2, 4, 8, 16):
            settings = {"modes": free, "tolerance": 1e-7} if engine == "reference" else {"elements": free}
            of_reference = {"calls_per_period": 12.0} if engine == "reference" else {}
            trial = Trial(
                scene=case,
                engine=engine,
                variant="" if method == engine else method,
                settings=settings | {"always": 1},
                degrees_of_freedom=free,
                errors=dict.fromkeys(COLUMNS, error * free ** (-order)),
                solve_seconds=pace * free,
                solve_seconds_median=1.1 * pace * free,
                solve_seconds_largest=1.2 * pace * free,
                repetitions=5,
                setup_seconds=0.01,
                statistics={"right_hand_side_calls": 1000.0 * free, "integration_seconds": 0.9 * pace * free, "largest_gap": 1e-9}
                | of_reference,
                estimate_seconds=(9.0 if engine == "reference" else 1.0) * pace * free if timed else None,
            )
            trials.append(trial)
    status = "failed at t = 0.1 s: the beam snapped; try another beam"
    trials.append(Trial(scene=case, engine="nodal-load", settings={"elements": 2}, status=status))
    return Benchmark(
        case=case,
        title="a title",
        duration=2.0,
        truth=Truth("reference", {"modes": 11}, dict.fromkeys(COLUMNS, 0.01)),
        confirmation=Trial(scene=case, engine="mujoco", settings={"links": 60}, errors=dict.fromkeys(COLUMNS, 1e-4 if confirmed else 1e-2)),
        trials=tuple(trials),
        repetitions=5,
        longest=10.0,
        machine={"processor": "one"},
    )
