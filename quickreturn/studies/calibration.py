"""Uncertain parameters: fitted to a recorded table, or drawn from distributions."""

import os
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any, Final

from quickreturn import questions
from quickreturn.accuracy import checked
from quickreturn.cases.errors import CaseError, as_written, nearest_or_all, texts_given
from quickreturn.cases.jobs.job import Job, Limits
from quickreturn.cases.sweep.rows import MeasureRequest
from quickreturn.cases.text.broken_toml import broken_toml
from quickreturn.cases.text.text_file import read_text
from quickreturn.cases.uncertainty import calibration
from quickreturn.cases.uncertainty.calibration import frees_of
from quickreturn.cases.uncertainty.fit import Fit
from quickreturn.cases.uncertainty.propagation import Scatter, planned
from quickreturn.cases.uncertainty.table_model import TableModel
from quickreturn.catalogue import AnyCase, one_case
from quickreturn.computing import Computing
from quickreturn.table_comparison import AnyTable, as_table

#: Key of a study file -> its type, and an example.
KEYS: Final[Mapping[str, tuple[type, str]]] = {
    "case": (str, '"thesis-24"'),
    "measures": (list, '["post.frequency"]'),
    "uncertain": (dict, "a table [uncertain]"),
}


def calibrate(case: AnyCase, table: AnyTable, free: str | Sequence[str], *, limits: "Limits | None" = None, quiet: bool = False) -> Fit:
    """Find the parameters with which `reference` is closest to a recorded table, and how well the table determines them.

    Args:
        case: a name, a path or a `Case`, for all other values and for the first values of the search.
        table: a path, a DataFrame or a dictionary of arrays with units in the headings, or a result of `simulate`; it begins in the
            standard start or shows the steady state.
        free: keys of a case file, each alone, or with a range in which it lies: "tip.center_of_mass = 0 in .. 0.5 in".
        limits: time and memory limits of the process that computes; None: the default ones.
        quiet: whether progress on standard error is left out.

    Raises:
        CaseError: an invalid case, table or key.
        EngineFailure, Refusal: the case cannot be simulated where the search begins.
    """
    chosen, recorded, keys = one_case(case), as_table(table), texts_given(free, "free", "tip.mass")
    frees_of(keys, chosen)
    TableModel(chosen, recorded)
    job = Job("calibration", calibration.calibrate, (chosen, recorded, keys))
    return questions.value_of(questions.asked([job], "calibration", limits, quiet)[0])


def uncertainty(
    case: AnyCase | None,
    uncertain: Mapping[str, str] | str | os.PathLike[str],
    measures: str | Sequence[str] = (),
    samples: int = 256,
    *,
    claims: bool = True,
    accuracy: float | None = None,
    jobs: int | None = None,
    quiet: bool = False,
) -> "Scatter":
    """Measure the settled motion at quasi-random values of uncertain parameters.

    Args:
        case: a name, a path or a `Case`; None: that of the study file.
        uncertain: key of a case file -> distribution: "uniform 0 kg .. 0.3 kg", "log-uniform 1 N/m .. 1e3 N/m" or
            "normal 2128 lbf*in^2 +- 4 %"; or the path of a study file with `case`, `measures` and `[uncertain]`.
        measures: one name or several, see `qr.measures`.
        samples: number of points, a power of two.
        claims: whether every number gets the simulation's error estimate, which takes about twice as long.
        accuracy: error of the tip deflection to ask for; None: the engine's default.
        jobs: processes at a time; None: one per core.
        quiet: whether progress on standard error is left out.

    Returns:
        Points, which print as a summary, with `quantiles(measure)`, `shares(measure)` (Sobol' indices) and `surrogate(measure)`.

    Raises:
        CaseError: an invalid argument; the sentence says what is accepted.
    """
    if isinstance(uncertain, Mapping):
        source, distributions = "uncertain", dict(uncertain)
    else:
        source = os.fspath(uncertain)
        study = _study_file(source)
        case, measures, distributions = case or study["case"], measures or study["measures"], study["uncertain"]
    if case is None or not measures:
        where, example = ("case", "thesis-24") if case is None else ("measures", "post.frequency")
        raise CaseError(where, None, None, "none is given", f"give one, such as {as_written(example)}")
    request = MeasureRequest(measures=tuple(texts_given(measures, "measures", "post.frequency")), claims=claims, accuracy=checked(accuracy))
    plan = planned(one_case(case), distributions, request, samples, source)
    with Computing(jobs, quiet=quiet).opened() as workshop:
        return plan.scatter(workshop)


def _study_file(path: str) -> dict[str, Any]:
    """`case`, `measures` and `uncertain` of a study file, with dotted keys joined. CaseError: it is no study file."""
    text = read_text(path, "a study file", 1_000_000)
    try:
        content = tomllib.loads(text)
    except ValueError as broken:
        raise broken_toml(path, text, str(broken)) from None
    for key, (kind, example) in KEYS.items():
        if not isinstance(content.get(key), kind):
            given = as_written(content[key]) if key in content else None
            raise CaseError(path, key, given, "is missing or not of its kind", f"give {example}")
    if unknown := [key for key in content if key not in KEYS]:
        raise CaseError(path, unknown[0], None, "is an unknown key", nearest_or_all(unknown[0], tuple(KEYS)))
    flat: dict[str, Any] = {}
    for section, value in content["uncertain"].items():
        flat |= {f"{section}.{key}": text for key, text in value.items()} if isinstance(value, dict) else {section: value}
    return {**content, "uncertain": flat}
