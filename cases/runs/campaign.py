"""Many runs: where each begins, in which order they are computed, and what became of those whose process died."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from cases.jobs.workshop import Workshop
from cases.runs.orbit import begins_in_orbit, orbits
from cases.runs.request import FAILED, UNAVAILABLE, Run, RunRequest
from engines.registry import engine

#: The slowest first, so that the last core does not wait for one of them.
_SLOWEST: Final = ("exudyn", "mujoco", "reference")


def carry_out(requests: Sequence[RunRequest], workshop: Workshop, title: str = "runs", names: Sequence[str] = ()) -> list[Run]:
    """The runs of some requests, in their order. Equal ones are computed once.

    Args:
        requests: what to run; those that shall begin in the orbit of `reference` get it.
        workshop: where.
        title: of them all, for the person who waits.
        names: of each, likewise; none: those of the engines.

    Raises:
        UnknownEngine: see there.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    reasons = {name: engine(name).unavailable() for name in dict.fromkeys(request.engine for request in requests)}
    marching = [number for number, request in enumerate(requests) if not reasons[request.engine] and _marches_from_orbit(request)]
    found = dict(zip(marching, orbits([requests[number].mechanism for number in marching], workshop), strict=True))
    begun = [replace(request, orbit=found.get(number, request.orbit)) for number, request in enumerate(requests)]
    order = [number for number in _order(begun) if not reasons[begun[number].engine]]
    jobs = [begun[number].job(names[number] if names else begun[number].engine) for number in order]
    outcomes = dict(zip(order, workshop.outcomes(jobs, title), strict=True))
    runs = []
    for number, request in enumerate(begun):
        if reason := reasons[request.engine]:
            runs.append(_without(request, UNAVAILABLE, reason))
        else:
            runs.append(outcomes[number].value or _without(request, FAILED, outcomes[number].explanation))
    return runs


def _order(requests: Sequence[RunRequest]) -> list[int]:
    """One of each engine first: what it compiles is there for the others, which would compile the same beside it."""
    by_engine: dict[str, list[int]] = {}
    for number, request in enumerate(requests):
        by_engine.setdefault(request.engine, []).append(number)
    slowest = sorted(by_engine, key=lambda name: _SLOWEST.index(name) if name in _SLOWEST else len(_SLOWEST))
    return [by_engine[name][0] for name in reversed(slowest)] + [number for name in slowest for number in by_engine[name][1:]]


def _marches_from_orbit(request: RunRequest) -> bool:
    found = engine(request.engine)
    if request.straight or request.orbit is not None or not begins_in_orbit(found):
        return False
    try:
        found.check(request.mechanism)
    except Exception:  # it refuses the scene, or will tell in its own process what is wrong
        return False
    return True


def _without(request: RunRequest, status: str, why: str) -> Run:
    """What is said of a request that came to nothing."""
    chosen = engine(request.engine)
    return Run(
        engine=request.engine,
        method=chosen.method,
        estimate_of=chosen.estimates,
        accuracy=request.accuracy or chosen.default_accuracy,
        status=status,
        remark=why,
        cause=why,
        unestimated=why,
    )
