"""Every output with its witness: columns, measures, and the numbers of results.

`python -m quickreturn.cases.witnesses` prints the table that `docs/belief.md` shows.
"""

from collections.abc import Iterator
from typing import Any, Final

from quickreturn.cases.loads.fatigue import Fatigue
from quickreturn.cases.loads.resonance import Resonance
from quickreturn.cases.loads.stress import ArmStress, Factor
from quickreturn.cases.measures.catalogue import MEASURES
from quickreturn.cases.measures.cycle import ChannelMeasures
from quickreturn.cases.resonance_curve.curve import ResonanceCurve, ResonancePeak, SpecialPoint
from quickreturn.cases.runs.request import PeriodicOrbit
from quickreturn.cases.solving import Frequencies
from quickreturn.cases.uncertainty.fit import FittedParameter
from quickreturn.cases.uncertainty.scatter import Quantile, Share
from quickreturn.engines.accurate import Result
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.witnesses import Witness

#: Classes of results besides trajectories and measures -> what they are called.
RESULTS: Final[dict[type[Any], str]] = {
    ChannelMeasures: "half cycle",
    ArmStress: "stress along the arm",
    Fatigue: "fatigue",
    Factor: "safety factor",
    Resonance: "distance to resonance",
    PeriodicOrbit: "periodic orbit",
    ResonanceCurve: "resonance curve",
    SpecialPoint: "special point",
    ResonancePeak: "peak of a curve",
    Quantile: "quantile",
    Share: "share of variance",
    FittedParameter: "fitted parameter",
    Frequencies: "natural frequencies",
    Result: "simulation",
}


def outputs() -> Iterator[tuple[str, str, Witness]]:
    """Kind, name and witness of every output."""
    yield from (("column", name, column.witness) for name, column in COLUMNS.items())
    yield from (("measure", name, measure.witness) for name, measure in MEASURES.items())
    for result, kind in RESULTS.items():
        yield from ((kind, name, witness) for name, witness in result.witnesses.items())


def rows() -> Iterator[tuple[str, str, str, str]]:
    """Rows of the table: outputs, witness, largest difference, test; outputs with one witness and one test share a row."""
    groups: dict[tuple[str, str, str], list[tuple[str, float]]] = {}
    for kind, name, witness in outputs():
        groups.setdefault((kind, witness.by, witness.test), []).append((name, witness.largest))
    for (kind, by, test), members in groups.items():
        least, most = min(largest for _, largest in members), max(largest for _, largest in members)
        largest = f"{most:.0e}" if least == most else f"{least:.0e} to {most:.0e}"
        yield f"{kind} {_named([name for name, _ in members])}", by, largest.replace("0e+00", "none"), test


def _named(names: list[str]) -> str:
    """Names in one cell; those that differ in a number or behind a dot are joined."""
    joined: dict[str, str] = {}
    for name in names:
        stem = name.split(".")[0] if "." in name else name.rstrip("0123456789")
        joined[stem] = name if stem not in joined else f"{stem}.*" if "." in name else f"{stem}*"
    return ", ".join(f"`{name}`" for name in joined.values())


def table() -> str:
    """The table in Markdown."""
    heading = ("output", "confirmed by", "largest difference", "test"), ("---",) * 4
    shown = ((output, by, largest, f"`{test}`") for output, by, largest, test in rows())
    return "\n".join(f"| {' | '.join(row)} |" for row in (*heading, *shown))


if __name__ == "__main__":
    print(table())
