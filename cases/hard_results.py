"""What the matrix of verdicts is made of, computed in processes of their own and stored as it comes.

Three kinds of results: the conditioning of a scene, the evidence of an engine in it, and its converged solution, which is the evidence
of the reference at a tighter accuracy. A process that died is kept as such: it would only die again. One that was stopped from outside is
not: on a less busy machine it may go better.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cases.conditioning import Conditioning, conditioning
from cases.evidence import Columns, Run, Scene, gather
from cases.fingerprint import SIMULATION, code_fingerprint
from cases.progress import with_progress
from cases.store import Store, key_of
from cases.verdicts import Breakdown, Evidence
from cases.workers import PRELOAD, Job, Limits, run_jobs
from engines.registry import engine
from reference_model.mechanism import Mechanism

#: What one result may take: what would never end must not hold up the others for ever.
LIMITS: Final = Limits(seconds=3600.0, memory=8 * 2**30)

_MODULES: Final = ("cases.evidence", "cases.verdicts", "cases.conditioning", "cases.spectrum", "cases.hard_results")
#: Columns that are kept.
_KEPT: Final = ("time", "tip_deflection", "strain_energy")
#: How the failure of a worker begins that was stopped from outside.
_FROM_OUTSIDE: Final = ("killed by SIGKILL", "stopped at the time limit")

_Stored = tuple[dict[str, Any], Mapping[str, NDArray[np.float64]]]


@dataclass(frozen=True)
class Work:
    """One result to be had: `function(*arguments)` under a name; `engine` is whose version it depends on."""

    name: tuple[str, ...]
    engine: str
    function: Callable[..., _Stored]
    arguments: tuple[Any, ...]


def conditioning_work(case: str, mechanism: Mechanism, duration: float, output_step: float) -> Work:
    """The conditioning of a scene, named ("conditioning", case)."""
    return Work(("conditioning", case), "reference", _conditioning, (mechanism, duration, output_step))


def evidence_work(name: tuple[str, ...], engine: str, scene: Scene, requested: float) -> Work:
    """The evidence of an engine in a scene."""
    return Work(name, engine, _evidence, (engine, scene, requested))


def results(work: list[Work], store: Store, jobs: int | None, *, compute: bool = True) -> dict[tuple[str, ...], _Stored]:
    """Results by name: a document and arrays. A result that ended badly is {"failure": a clause}.

    Args:
        work: what is wanted.
        store: results are taken from here and kept here.
        jobs: processes at a time; None: one per core.
        compute: False: what is not stored is left out.

    Raises:
        StoreError: see `cases.store`.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    found: dict[tuple[str, ...], _Stored] = {}
    missing: dict[str, Work] = {}
    code = code_fingerprint((*SIMULATION, *_MODULES))
    for item in work:
        chosen = engine(item.engine)
        version = "" if chosen.unavailable() else chosen.version()
        key = key_of({"kind": "hard scene", "what": item.name[0], "arguments": list(item.arguments), "version": version, "code": code})
        entry = store.get(key)
        if entry is not None:
            found[item.name] = (entry.document, entry.arrays)
        elif compute:
            missing[key] = item
    pending = [Job(key, item.function, item.arguments) for key, item in missing.items()]
    running = run_jobs(pending, jobs, LIMITS, preload=(*PRELOAD, *_MODULES))
    for outcome in with_progress(running, len(pending), "hard scenes"):
        document, arrays = outcome.value if outcome.completed else ({"failure": outcome.failure}, {})
        if not outcome.failure.startswith(_FROM_OUTSIDE):
            store.put(outcome.job.name, document, arrays)
        found[missing[outcome.job.name].name] = (document, arrays)
    return found


def conditioning_of(stored: _Stored) -> Conditioning | None:
    """A conditioning as it was computed; None where it ended badly."""
    document, _ = stored
    return None if "failure" in document else Conditioning(document["changes"], document["horizon"])


def run_of(stored: _Stored, work: Work) -> Run:
    """The evidence as it was gathered; of a process that ended without a result, that it did."""
    document, arrays = stored
    if "failure" in document:
        _, scene, requested = work.arguments
        broken = Breakdown(time=0.0, cause=document["failure"])
        return Run(Evidence(requested=requested, duration=scene.duration, stretch=0.0, row=scene.output_step, breakdown=broken), {}, {})
    found = dict(document["evidence"])
    if found["breakdown"] is not None:
        found["breakdown"] = Breakdown(**found["breakdown"])
    return Run(Evidence(**found), document["settings"], dict(arrays))


def _conditioning(mechanism: Mechanism, duration: float, output_step: float) -> _Stored:
    found = conditioning(mechanism, duration, output_step)
    return {"changes": dict(found.changes), "horizon": found.horizon}, {}


def _evidence(name: str, scene: Scene, requested: float) -> _Stored:
    run = gather(name, scene, requested)
    kept: Columns = {column: run.columns[column] for column in _KEPT if column in run.columns}
    return {"evidence": _plain(asdict(run.evidence)), "settings": run.settings}, kept


def _plain(value: Any) -> Any:
    """Without numpy's numbers, and with a number that is none as a huge one: it fails every test."""
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else 1e300
    return value.item() if isinstance(value, np.generic) else value
