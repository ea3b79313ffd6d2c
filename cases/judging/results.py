"""What the matrix of verdicts is made of: the conditioning of a scene, the evidence of an engine in it, and its converged solution.

The last is the evidence of the reference at a tighter accuracy.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, Final

import numpy as np

from cases import stored_jobs
from cases.judging.conditioning import Conditioning, conditioning
from cases.judging.evidence import Columns, Run, Scene, gather
from cases.judging.verdicts import Breakdown, Evidence
from cases.store import Store
from cases.stored_jobs import Campaign, Result, Work
from reference_model.mechanism import Mechanism

_CAMPAIGN: Final = Campaign("hard scene", ("cases.judging",))
#: Columns that are kept.
_KEPT: Final = ("time", "tip_deflection", "strain_energy")


def conditioning_work(case: str, mechanism: Mechanism, duration: float, output_step: float) -> Work:
    """The conditioning of a scene, named ("conditioning", case)."""
    return Work(("conditioning", case), ("reference",), _conditioning, (mechanism, duration, output_step))


def evidence_work(name: tuple[str, ...], engine: str, scene: Scene, requested: float) -> Work:
    """The evidence of an engine in a scene."""
    return Work(name, (engine,), _evidence, (engine, scene, requested))


def results(work: Sequence[Work], store: Store, jobs: int | None, *, compute: bool = True) -> dict[tuple[str, ...], Result]:
    """Results by name, see `cases.stored_jobs.results`."""
    return stored_jobs.results(work, _CAMPAIGN, store, jobs, compute=compute)


def conditioning_of(stored: Result) -> Conditioning | None:
    """A conditioning as it was computed; None where it ended badly."""
    document, _ = stored
    return None if "failure" in document else Conditioning(document["changes"], document["horizon"])


def run_of(stored: Result, work: Work) -> Run:
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


def _conditioning(mechanism: Mechanism, duration: float, output_step: float) -> Result:
    found = conditioning(mechanism, duration, output_step)
    return {"changes": dict(found.changes), "horizon": found.horizon}, {}


def _evidence(name: str, scene: Scene, requested: float) -> Result:
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
