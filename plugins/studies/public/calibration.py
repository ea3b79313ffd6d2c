"""Parameters of a machine, fitted to a recorded table."""

from collections.abc import Sequence

from quickreturn import descriptions
from quickreturn.arguments import AnyCase, one_case
from quickreturn.cases.files.errors import texts_given
from quickreturn.cases.files.number_rows import Form
from quickreturn.cases.running.job import Job, Limits
from quickreturn.plugins.studies.uncertainty import calibration
from quickreturn.plugins.studies.uncertainty.calibration import frees_of
from quickreturn.plugins.studies.uncertainty.fit import Fit
from quickreturn.plugins.studies.uncertainty.table_model import TableModel
from quickreturn.table_comparison import AnyTable, as_table


def calibrate(
    case: AnyCase,
    table: AnyTable,
    free: str | Sequence[str],
    *,
    separator: str | None = None,
    decimal: str | None = None,
    skip: int = 0,
    limits: "Limits | None" = None,
    quiet: bool = False,
) -> Fit:
    """Find the parameters with which `reference` is closest to a recorded table, and how well the table determines them.

    Args:
        case: a name, a path or a `Case`, for all other values and for the first values of the search.
        table: a path, a DataFrame or a dictionary of arrays with units in the headings, or what `simulate` or `read_table` returns;
            it begins in the standard start or shows the steady state.
        free: keys of a case file, each alone, or with a range in which it lies: "tip.center_of_mass = 0 in .. 0.5 in".
        separator: sign between the columns of a file; None: recognised.
        decimal: decimal sign of a file; None: recognised.
        skip: number of lines above the headings of a file.
        limits: time and memory limits of the process that computes; None: the default ones.
        quiet: whether progress on standard error is left out.

    Raises:
        CaseError: an invalid case, table or key.
        EngineFailure, Refusal: the case cannot be simulated where the search begins.
    """
    chosen, recorded, keys = one_case(case), as_table(table, form=Form(separator, decimal, skip)), texts_given(free, "free", "tip.mass")
    frees_of(keys, chosen)
    TableModel(chosen, recorded)
    job = Job("calibration", calibration.calibrate, (chosen, recorded, keys))
    return descriptions.value_of(descriptions.outcomes([job], "calibration", limits, quiet)[0])
