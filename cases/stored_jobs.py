"""Results computed in processes of their own and stored as they come, so that an interrupted campaign continues where it stopped.

A process that died is kept as such: it would only die again. One that was stopped from outside is not: on a less busy machine it may
go better.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cases.fingerprint import SIMULATION, code_fingerprint
from cases.progress import with_progress
from cases.store import Store, key_of
from cases.workers import Job, Limits, run_jobs
from engines.registry import engine

#: What one result may take: what would never end must not hold up the others for ever.
LIMITS: Final = Limits(seconds=3600.0, memory=8 * 2**30)

#: How the failure of a worker begins that was stopped from outside.
_FROM_OUTSIDE: Final = ("killed by SIGKILL", "stopped at the time limit")

#: A JSON document and arrays by name.
Result = tuple[dict[str, Any], Mapping[str, NDArray[np.float64]]]


@dataclass(frozen=True)
class Work:
    """One result to be had: `function(*arguments)` under a name; `engines` are those whose versions it depends on.

    The first part of the name says what kind of result it is and counts in its key; the others are for telling results apart.
    """

    name: tuple[str, ...]
    engines: tuple[str, ...]
    function: Callable[..., Result]
    arguments: tuple[Any, ...]


@dataclass(frozen=True)
class Campaign:
    """What results have in common: `kind` counts in their keys, `modules` in the code that they depend on besides the simulation's."""

    kind: str
    modules: tuple[str, ...]


def results(
    work: Sequence[Work], campaign: Campaign, store: Store, jobs: int | None, *, compute: bool = True
) -> dict[tuple[str, ...], Result]:
    """Results by name. One whose process ended badly is {"failure": a clause}, without arrays.

    Args:
        work: what is wanted.
        campaign: that it belongs to.
        store: results are taken from here and kept here.
        jobs: processes at a time; None: one per core.
        compute: False: what is not stored is left out.

    Raises:
        UnknownEngine: a name that is no engine's.
        StoreError: see `cases.store`.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    found: dict[tuple[str, ...], Result] = {}
    missing: dict[str, Work] = {}
    code = code_fingerprint((*SIMULATION, *campaign.modules))
    for item in work:
        content = {"kind": campaign.kind, "what": item.name[0], "arguments": list(item.arguments), "versions": _versions(item.engines)}
        key = key_of(content | {"code": code})
        entry = store.get(key)
        if entry is not None:
            found[item.name] = (entry.document, entry.arrays)
        elif compute:
            missing[key] = item
    pending = [Job(key, item.function, item.arguments) for key, item in missing.items()]
    running = run_jobs(pending, jobs, LIMITS)
    for outcome in with_progress(running, len(pending), f"{campaign.kind}s"):
        document, arrays = outcome.value if outcome.completed else ({"failure": outcome.failure}, {})
        if not outcome.failure.startswith(_FROM_OUTSIDE):
            store.put(outcome.job.name, document, arrays)
        found[missing[outcome.job.name].name] = (document, arrays)
    return found


def _versions(names: Sequence[str]) -> list[str]:
    chosen = [engine(name) for name in names]
    return ["" if each.unavailable() else each.version() for each in chosen]
