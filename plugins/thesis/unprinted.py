"""Quantities that the thesis does not print: their assumed distributions, and the effect of their scatter on each run."""

from collections.abc import Sequence
from typing import Any, Final

from quickreturn.cases.library.thesis.runs import run_name
from quickreturn.plugins.thesis.effects import EXCESS
from quickreturn.plugins.thesis.scatter import UNPRINTED, Band
from quickreturn.reports.tables.cells import CASE
from quickreturn.reports.tables.table import Column, Table
from quickreturn.reports.words import HALF, number

#: Share of the points up to which they do not make the halves differ.
RARELY: Final = 0.05
ENDS: Final = ("low", "median", "high")
KINDS: Final = ("pre", "post", "strain")


def scatter_facts(recorded: Sequence[Band]) -> dict[str, Any]:
    """A sentence and the tables of the chapter on the thesis; no sentence and no tables if no run resolves both halves."""
    resolved = [band for band in recorded if band.ratio]
    if not resolved:
        return {"scatter": ""}
    return {"scatter": scatter_words(resolved), "unprinted": unprinted(), "bands": bands(recorded)}


def scatter_words(resolved: Sequence[Band]) -> str:
    """Whether the scatter of these quantities makes the halves differ, in runs that resolve both."""
    compared, apart = (sum(getattr(band, key) for band in resolved) for key in ("compared", "apart"))
    so = " So these quantities do not make the halves differ." if apart <= RARELY * compared else ""
    return (
        f"The words require a machine whose frequency after the return is at most {number(1.0 / EXCESS, '.3f')} times that before it:"
        f" {apart or 'none'} of {compared} points {'has' if apart == 1 else 'have'} this.{so}"
    )


def unprinted() -> Table:
    """The distributions assumed for the unprinted quantities."""
    table = Table(
        "unprinted",
        """Quantities that the thesis does not print, or prints illegibly, and the distributions assumed for them. The bands below hold for
        these alone.""",
        ("key", "distribution", Column("reason", "why")),
    )
    for quantity in UNPRINTED:
        table.add(key=quantity.key, distribution=quantity.distribution, reason=quantity.reason)
    return table


def bands(of_runs: Sequence[Band]) -> Table:
    """Quantiles of each run, their error from the finite number of points, and the simulation's own error."""
    columns = [CASE]
    groups = [(half, f"f₁, {HALF[half]}", "Hz", ".1f") for half in HALF]
    groups += [("ratio", "post over pre (least, median, most)", "1", ".3f"), ("strain", "peak strain", "10⁻⁶", ".0f")]
    for name, group, unit, form in groups:
        columns += [Column(f"{name}_{end}", end, unit, form, group=group) for end in ENDS]
    columns += [Column(f"sampled_{kind}", kind, "%", ".1f", group="± by the points") for kind in KINDS]
    columns += [Column(f"claim_{kind}", unit="%", in_page=False) for kind in KINDS]
    columns += [Column("compared", "resolved", form="d", group="points"), Column("settled", form="d", group="points")]
    columns.append(Column("points", form="d", in_page=False))
    points = max((band.points for band in of_runs), default=0)
    table = Table(
        "scatter",
        f"""Each run at {points} quasi-random values of these quantities, computed by the reference: quantiles of 2.5, 50 and 97.5 % of
        the first mode's frequency (consensus of the channels) and of the largest of the three peak strains; the ratio of the two
        frequencies over all points that resolve both. ± by the points: standard error of the outer quantiles due to the finite number
        of points (bootstrap). None of these numbers contains the simulation's own error; the CSV file has it for the runs in which it
        was estimated.""",
        columns,
    )
    for band in of_runs:
        cells: dict[str, float] = {}
        for name, *_ in groups:
            cells |= {f"{name}_{end}": value for end, value in zip(ENDS, getattr(band, name), strict=False)}
        for name, values in (("sampled", band.sampled), ("claim", band.claims)):
            cells |= {f"{name}_{kind}": value for kind, value in zip(KINDS, values, strict=False)}
        table.add(case=run_name(band.run), compared=band.compared, settled=band.settled, points=band.points, **cells)
    return table
