"""Columns and cells that tables of several chapters share."""

from typing import Any, Final

from quickreturn.cases.runs.comparison import CaseResult, Difference
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.runs.request import Run
from quickreturn.reports.results.differences import outward
from quickreturn.reports.tables.table import Cell, Column
from quickreturn.reports.words import HALF, QUANTITY, case_label, channel_name

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
    Column("value", unit="SI", form=".4g"),
    Column("other_value", unit="SI", form=".4g"),
    Column("difference", unit="%", form="+.2f"),
    Column("tolerance", unit="%", form=".2f"),
)
#: The text of a number that cannot be measured.
UNRESOLVABLE: Final = "n. r."


def compared(result: CaseResult, check: Difference) -> dict[str, Any]:
    """The cells of `COMPARISON` that are not fields of the comparison itself."""
    return {
        "case": result.case.name,
        "value": check.mine.value,
        "other_value": check.its.value,
        "difference": outward(check.quantity, check.difference) / check.scale,
        "tolerance": check.tolerance / check.scale,
    }


def status_cell(run: Run) -> Cell:
    """How a run ended, with the engine's remark."""
    return Cell(run.status, note=run.remark, mark="open" if run.status == Ending.INACCURATE else "" if run.usable else "failed")
