"""The experiment: what is left of it, compared with the engines."""

from collections.abc import Mapping, Sequence
from typing import Any

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.engines.registry import MODEL, own_engines
from quickreturn.plugins.thesis.axes import COLUMNS, AxisComparison, axis_comparisons, fits_worse, measured_alone, ratios_of, thesis_runs
from quickreturn.plugins.thesis.experiment import below_aluminium, channel_is_usable, measured_crank_speed
from quickreturn.plugins.thesis.page_data import ThesisData, counts
from quickreturn.reports.engine_differences import engines_of
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.tables import CASE, CHANNEL, Cell, Column, ColumnList, Table
from quickreturn.reports.words import listed, number, percents, span


def experiment(content: ThesisData) -> Chapter:
    """The chapter."""
    axes, alone = axis_comparisons(content.results), measured_alone(content.results)
    engines = [name for name in engines_of(content.results) if name in own_engines()]
    of_channels = {channel: {name: of_name for name in engines if (of_name := ratios_of(axes, channel, name))} for channel in COLUMNS}
    ratios = {channel: of_engines for channel, of_engines in of_channels.items() if of_engines}
    strain, recorded, worse = ratios.get("strain", {}), any(counts(item) for item in content.comparisons), fits_worse(axes)
    clearest = max((axis for axis in alone if axis.channel == "strain"), key=lambda axis: axis.largest_label, default=None)
    facts = {
        "recorded": recorded,
        "short": "tip_acceleration" in ratios and all(max(values) < 1.0 for values in ratios["tip_acceleration"].values()),
        "worse": worse,
        "alone_says_so": clearest.figure if clearest and _worse(clearest.ratios) else "",
        "stiffness": percents(*below_aluminium(), ".0f"),
        "spread": number(max(strain[REFERENCE]) / min(strain[REFERENCE]), ".1f") if worse else "",
        "speeds": speeds_and_axes(content.results, axes, engines),
        "alone_table": alone_table(alone, engines),
    }
    return Chapter("experiment", "The experiment", finding(recorded, strain, worse), facts)


def _worse(ratios: Mapping[str, float]) -> bool:
    """Whether the converged model's peak is farther above a label than the single cubic's."""
    return {MODEL, REFERENCE} <= ratios.keys() and ratios[REFERENCE] > ratios[MODEL]


def finding(recorded: bool, strain: Mapping[str, Sequence[float]], worse: bool) -> str:
    """Whether there are recordings; and how the simulated strains compare with the axes.

    Args:
        recorded: whether there is a recording of the experiment.
        strain: engine -> its peaks of strain over the largest labels.
        worse: whether the converged model's peaks are farther from the labels than the single cubic's.
    """
    text = "There are recordings" if recorded else "No measured waveform survives"
    if not strain:
        return text
    model = ": the converged model fits this one contact with the measurement worse than the stiff cubic" if worse else ""
    return f"{text}; simulated strain peaks are {ranges(strain)} times the largest printed axis label{model}"


def ranges(ratios: Mapping[str, Sequence[float]]) -> str:
    """The ranges of the engines' ratios; engines with the same range together."""
    of_engines: dict[str, list[str]] = {}
    for name, values in ratios.items():
        of_engines.setdefault(span(min(values), max(values), ".2f"), []).append(name)
    return ", ".join(f"{text} ({listed(names)})" for text, names in of_engines.items())


def speeds_and_axes(results: Sequence[CaseResult], axes: Sequence[AxisComparison], engines: Sequence[str]) -> Table:
    """Per run the crank speed, the valid measurements, and the simulated peaks of engines over the largest axis label."""
    columns = [
        CASE,
        Column("measured_speed", "measured", "rad/s", ".3f", group="crank speed"),
        Column("simulated_speed", "simulated", "rad/s", ".3f", group="crank speed", meaning="mean of the reference's steady cycle"),
        Column("acceleration_valid", "acceleration", group="valid"),
        Column("strain_valid", "strain", group="valid"),
    ]
    for name, unit, form, group in (
        ("acceleration", "m/s²", ".1f", "tip acceleration"),
        ("strain", "%", ".2g", "strain, largest of three"),
    ):
        columns.append(Column(f"{name}_label", "label", unit, form, group=group))
        columns += [Column(f"{name}_{engine}", engine, "1", ".2f", group=group, meaning="peak over label") for engine in engines]
    table = Table(
        "experiment",
        """For each run: measured crank speed (table 3.1) and simulated speed; the measurements that section 3.5 calls valid; the largest
        legible axis label in the appendix' figure, and the simulated peak over this label (printed strain read as percent). A label bounds
        the plotted curves only roughly and from below, because labels are missing. In all figures except that of run 1 the thesis'
        simulated curves and the measured ones share the axes.""",
        columns,
    )
    for run_number, result in thesis_runs(results).items():
        cells: dict[str, Any] = {}
        for axis in (axis for axis in axes if axis.run == run_number):
            prefix = "acceleration" if axis.channel == "tip_acceleration" else "strain"
            cells[f"{prefix}_label"] = axis.largest_label
            cells |= {f"{prefix}_{engine}": axis.ratios.get(engine) for engine in engines}
        measured = measured_crank_speed(run_number)
        reference = result.runs.get(REFERENCE)
        if reference is not None and reference.usable:
            cells["simulated_speed"] = reference.mean_crank_speed
        table.add(
            case=result.case.name,
            measured_speed=Cell(None, "none printed", "tables 3.1 and 5.2 say N/A") if measured is None else measured,
            acceleration_valid=channel_is_usable(run_number, "tip_acceleration"),
            strain_valid=channel_is_usable(run_number, "strain_1"),
            **cells,
        )
    return table


def alone_table(axes: Sequence[AxisComparison], engines: Sequence[str]) -> Table:
    """Simulated peaks over the largest label of each figure that shows measured curves alone."""
    ratios = [Column(engine, engine, "1", ".2f", group="simulated peak over label") for engine in engines]
    columns: ColumnList = ("figure", Column("run", form="d"), CHANNEL, Column("largest_label", "largest label", "SI", ".3g"), *ratios)
    table = Table(
        "measured_alone",
        """Figures of the thesis that show only measured curves: the largest legible label, and the simulated peak over this label.""",
        columns,
    )
    for axis in axes:
        table.add(axis, **{engine: axis.ratios.get(engine) for engine in engines})
    return table
