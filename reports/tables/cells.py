"""Columns and cells that tables of several chapters share."""

import math
from typing import Any, Final

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.comparison.pair import Difference
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Units
from quickreturn.cases.motion.catalogue import IN_TABLES, MEASURES, numbers
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import Run
from quickreturn.reports.results.engine_differences import outward
from quickreturn.reports.tables.table import Cell, Column
from quickreturn.reports.words import HALF, QUANTITY, case_label, channel_name, quantity

CASE: Final = Column("case", "run", words=case_label)
QUANTITY_COLUMN: Final = Column("quantity", words=QUANTITY.__getitem__)
HALF_COLUMN: Final = Column("half", words=HALF.__getitem__)
CHANNEL: Final = Column("channel", words=channel_name)
#: Columns of a comparison of two numbers.
COMPARISON: Final = (
    CASE,
    Column("engine"),
    Column("other", "against"),
    QUANTITY_COLUMN,
    HALF_COLUMN,
    CHANNEL,
    Column("value", unit="[SI]", form=".4g"),
    Column("other_value", unit="[SI]", form=".4g"),
    Column("difference", unit="%", form="+.2f"),
    Column("tolerance", unit="%", form=".2f"),
)
#: The text of a number that cannot be measured.
UNRESOLVABLE: Final = "n. r."


def measure_column(name: str, units: Units) -> Column:
    """The column of a measure that the tables of a run show."""
    shown = IN_TABLES[name]
    column = Column(shown.key or name.replace(".", "_"), shown.head, shown.unit or MEASURES[name].unit, shown.form, group=shown.group)
    return column if shown.unit else column.shown_in(units)


def measure_cells(case: Case, run: Run) -> dict[str, Cell]:
    """The cells of all these measures; empty of a run without a usable cycle."""
    cells = {}
    for name, found in numbers(case.mechanism, run, IN_TABLES).items():
        why = "no channel resolves the first mode" if MEASURES[name].vibration else "it cannot be measured"
        cells[measure_column(name, case.units).key] = (
            Cell(None, UNRESOLVABLE, why, "open") if math.isnan(found.value) else Cell(found.value)
        )
    return cells


def compared(result: CaseResult, check: Difference) -> dict[str, Any]:
    """The cells of `COMPARISON` that are not fields of the comparison itself."""
    unit = result.case.units.column(check.unit)
    return {
        "case": result.case.name,
        "value": Cell(check.number.value, quantity(check.number.value, unit)),
        "other_value": Cell(check.other_number.value, quantity(check.other_number.value, unit)),
        "difference": outward(check.quantity, check.difference) / check.scale,
        "tolerance": check.tolerance / check.scale,
    }


def status_cell(run: Run) -> Cell:
    """How a run ended, with the engine's remark."""
    return Cell(run.status, note=run.remark, mark="open" if run.status == Ending.INACCURATE else "" if run.usable else "failed")
