"""Tables of quantities that the thesis does not print, and of the effect of their scatter on each run."""

from collections.abc import Sequence
from typing import Final

from quickreturn.cases.thesis.runs import run_name
from quickreturn.cases.thesis.scatter import UNPRINTED, Band
from quickreturn.reports.tables.table import CASE, Column, Table
from quickreturn.reports.words import HALF

ENDS: Final = ("low", "median", "high")
KINDS: Final = ("pre", "post", "strain")


def unprinted() -> Table:
    """The distributions assumed for the unprinted quantities."""
    table = Table("unprinted", ("key", "distribution", Column("reason", "why")))
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
    table = Table("scatter", columns, points=max((band.points for band in of_runs), default=0))
    for band in of_runs:
        cells: dict[str, float] = {}
        for name, *_ in groups:
            cells |= {f"{name}_{end}": value for end, value in zip(ENDS, getattr(band, name), strict=False)}
        for name, values in (("sampled", band.sampled), ("claim", band.claims)):
            cells |= {f"{name}_{kind}": value for kind, value in zip(KINDS, values, strict=False)}
        table.add(case=run_name(band.run), compared=band.compared, settled=band.settled, points=band.points, **cells)
    return table
