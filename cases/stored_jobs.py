"""Results computed in processes of their own and stored as they come, so that an interrupted campaign continues where it stopped."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.fingerprint import SIMULATION, code_fingerprint
from cases.progress import with_progress
from cases.store import Entry, Store, key_of
from cases.workers import PRELOAD, Job, Limits, Outcome, default_limits, run_jobs
from engines.registry import MAIN, RIVALS, engine

#: A JSON document and arrays by name.
Result = tuple[dict[str, Any], Mapping[str, NDArray[np.float64]]]


def value_of(outcome: Outcome) -> Result | None:
    """What a job returned, where it completed."""
    return outcome.value if outcome.completed else None


def stored(
    jobs: Iterable[Job],
    store: Store,
    title: str,
    *,
    at_once: int | None = None,
    limits: Limits | None = None,
    keep: Callable[[Outcome], Result | None] = value_of,
    preload: Sequence[str] = PRELOAD,
) -> tuple[dict[str, Entry], dict[str, Outcome]]:
    """Entries of the store by key, computed where they are missing, and the outcomes of the jobs that left none.

    Args:
        jobs: named by their keys; of equal keys the first is run. Started in this order.
        store: results are taken from here and kept here.
        title: of the progress bar.
        at_once: how many jobs at a time; None: one per core.
        limits: of each job; None: `default_limits`.
        keep: what is stored of an outcome; None: nothing, it is tried again the next time.
        preload: see `cases.workers.run_jobs`.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    entries: dict[str, Entry] = {}
    missing: dict[str, Job] = {}
    for job in jobs:
        if job.name not in entries and job.name not in missing:
            entry = store.get(job.name)
            if entry is None:
                missing[job.name] = job
            else:
                entries[job.name] = entry
    others: dict[str, Outcome] = {}
    with closing(run_jobs(list(missing.values()), at_once, limits or default_limits(), preload)) as outcomes:
        for outcome in with_progress(outcomes, len(missing), title):
            key, kept = outcome.job.name, keep(outcome)
            if kept is None:
                others[key] = outcome
                continue
            try:
                store.put(key, *kept)
                entries[key] = Entry(kept[0], dict(kept[1]))
            except (TypeError, ValueError) as error:  # a third-party engine may hand anything on
                others[key] = replace(outcome, value=None, failure=f"its result cannot be stored: {error}", output="")
    return entries, others


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

    An exception of the work itself is stored as such: it would only be raised again. A process that died or was stopped at a limit, lack
    of memory and the like are not: on another day it may go better.

    Args:
        work: what is wanted.
        campaign: that it belongs to.
        store: results are taken from here and kept here.
        jobs: processes at a time; None: one per core.
        compute: False: what is not stored is left out.

    Raises:
        ValueError: a name is given twice.
        UnknownEngine: a name that is no engine's.
        StoreError: see `cases.store`.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    code = code_fingerprint((*SIMULATION, *campaign.modules))
    keys: dict[tuple[str, ...], str] = {}
    for item in work:
        content = {"kind": campaign.kind, "what": item.name[0], "arguments": list(item.arguments), "engines": _versions(item.engines)}
        keys[item.name] = key_of(content | {"code": code})
    if len(keys) < len(work):
        raise ValueError("two results have one name")
    wanted = [Job(keys[item.name], item.function, item.arguments) for item in work]
    if not compute:
        found = {name: store.get(key) for name, key in keys.items()}
        return {name: (entry.document, entry.arrays) for name, entry in found.items() if entry is not None}
    entries, others = stored(wanted, store, f"{campaign.kind}s", at_once=jobs, keep=_kept)
    return {name: (entries[key].document, entries[key].arrays) if key in entries else _failure(others[key]) for name, key in keys.items()}


def _kept(outcome: Outcome) -> Result | None:
    own = isinstance(outcome.error, Exception) and not isinstance(outcome.error, (MemoryError, OSError))
    return _failure(outcome) if own else value_of(outcome)


def _failure(outcome: Outcome) -> Result:
    return {"failure": outcome.failure}, {}


def _versions(names: Sequence[str]) -> list[list[str]]:
    """Library and, of an engine from elsewhere, code."""
    usable = [chosen for chosen in map(engine, names) if not chosen.unavailable()]
    return [[chosen.name, chosen.version(), "" if chosen.name in (*MAIN, *RIVALS) else code_fingerprint((), chosen)] for chosen in usable]
