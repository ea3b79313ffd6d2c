"""Resonance curves as tables and pictures."""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from quickreturn.arguments import AnyCase, one_case
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError, as_written, texts_given
from quickreturn.cases.files.keys import PATHS, si_value
from quickreturn.cases.files.shown import Cell, Printable, Rows, Unit
from quickreturn.cases.running.display import compilation_announced
from quickreturn.computing import checked
from quickreturn.plugins.studies.around import Around
from quickreturn.plugins.studies.resonance_curve.curve import SPEED, ResonanceCurve, range_of
from quickreturn.plugins.studies.resonance_curve.search import OF_CURVE, USUAL, resonance_curve
from quickreturn.plugins.studies.sweep.sweeping import ERROR

if TYPE_CHECKING:
    import pandas as pd

    from quickreturn.reports.drawing.style import Drawing


class Resonance(Printable):
    """The periodic motion of a machine over one of its quantities.

    Attributes:
        case: name of the case.
        curve: points, special points and peaks, as `reference` computed them.
        around: the case's own place on the curve: its motions there, and what is nearest.
    """

    def __init__(self, case: Case, curve: ResonanceCurve) -> None:
        self.case, self.curve, self._units = case.name, curve, case.units
        self.around = Around(case, curve, Unit(curve.range.unit, curve.range.size))

    @property
    def frame(self) -> "pd.DataFrame":
        """A row for each point in order of arclength, SI; claims under the names with ".error"."""
        import pandas as pd

        curve = self.curve
        columns = {curve.range.key: curve.values, f"{curve.range.key}{ERROR}": curve.value_errors, "arclength": curve.arclength}
        for name, values in curve.measures.items():
            columns |= {name: values, f"{name}{ERROR}": curve.errors[name]}
        special = {each.at: each.kind for each in curve.special}
        real, imaginary = curve.multipliers.T
        columns |= {"multiplier": np.hypot(real, imaginary), "multiplier.real": real, "multiplier.imag": imaginary}
        table = pd.DataFrame(columns)
        table["stability"] = [str(curve.stability(at)) for at in range(len(table))]
        table["special"] = [special.get(at, "") for at in range(len(table))]
        peaks = {each.at: each for each in curve.peaks}
        table["peak_order"] = pd.array([peaks[at].order if at in peaks else None for at in range(len(table))], dtype="Int64")
        table["peak_harmonic"] = [peaks[at].name if at in peaks else "" for at in range(len(table))]
        table.attrs["units"] = {name: self._unit(str(name)) for name in table.columns}
        return table

    @property
    def special(self) -> "pd.DataFrame":
        """Special points: kind, value of the varied quantity (SI), the error of its location on the model's curve, and the claim."""
        return _table(self.curve.special, "kind", "value", "tolerance", "error", "reason")

    @property
    def peaks(self) -> "pd.DataFrame":
        """Peaks of the first measure: value of the varied quantity (SI), height, order of the harmonic, mode, and both in words."""
        return _table(self.curve.peaks, "value", "height", "order", "mode").assign(harmonic=[each.name for each in self.curve.peaks])

    def plot(self) -> "Drawing":
        """Draw each measure over the varied quantity: stable parts as lines, unstable ones dashed, special points as marks."""
        from quickreturn.plugins.studies.resonance_curve.drawing import resonance_figure

        return resonance_figure(self.curve, self.case, self._units, self.around.own if self.around.motions else None)

    def document(self) -> dict[str, Any]:
        """The JSON document: the case's own place, special points, peaks, and the points by column."""
        frame = self.frame
        about = {"key": self.curve.range.key, "units": frame.attrs["units"], "settings": self.curve.settings}
        special, peaks = (table.to_dict(orient="records") for table in (self.special, self.peaks))
        columns = {str(name): frame[name].astype(object).where(frame[name].notna(), None).tolist() for name in frame.columns}
        return {**about, "own": self.around.document, "special": special, "peaks": peaks, "points": columns}

    def _unit(self, name: str) -> str:
        """Unit of a column of `frame`."""
        name = name.removesuffix(ERROR)
        if name in OF_CURVE:
            return OF_CURVE[name].unit
        return PATHS[name].unit if name in PATHS else "1" if name.startswith("multiplier") else ""

    def _parts(self) -> Iterator[Cell]:
        curve, unit = self.curve, self.curve.range.unit
        drive = ", the crank's speed prescribed in place of its drive" if curve.prescribed else ""
        stable = sum(curve.stability(at) == "stable" for at in range(len(curve.values)))
        yield f"{self.case}: {len(curve.values)} points along {curve.range.key}, {stable} of them stable{drive}"
        first = next(iter(curve.measures))
        of_height = self._units.of(self._unit(first))
        rows = [
            (each.kind, f"{self._of_range(each.value)} {unit}", f"+- {self._of_range(each.error, '.2g')}", each.reason)
            for each in curve.special
        ]
        for each in curve.peaks:
            error = curve.errors[first][each.at]
            height = of_height.text(each.height) + ("" if math.isnan(error) else f" +- {error / of_height.size:.2g}")
            claim = f"+- {self._of_range(curve.value_errors[each.at], '.2g')}"
            rows.append((f"peak: {each.name}", f"{self._of_range(each.value)} {unit}", claim, height))
        if rows:
            yield Rows(rows)
        yield from self.around.lines

    def _of_range(self, value: float | None, digits: str = ".6g") -> str:
        """A value in the unit in which the range was given."""
        return "unknown" if value is None or math.isnan(value) else f"{value / self.curve.range.size:{digits}}"


def _table(points: Sequence[Any], *columns: str) -> "pd.DataFrame":
    import pandas as pd

    return pd.DataFrame(map(vars, points), columns=list(columns))


def resonance(
    case: AnyCase,
    key: str = SPEED,
    range: str = "",
    *,
    speed: str | None = None,
    measures: str | Sequence[str] = (USUAL,),
    accuracy: float | None = None,
    claims: bool = True,
    quiet: bool = False,
) -> Resonance:
    """Follow the periodic motion of a case over one of its quantities, through folds.

    Args:
        case: a name, a path or a `Case`.
        key: key of the varied quantity, as in a case file.
        range: range of its values, such as "60 rpm .. 300 rpm".
        speed: prescribed speed of the crank if another quantity varies, such as "165 rpm"; None: the case's own drive.
        measures: one name or several, such as "peak.tip_acceleration"; the curve's peaks are those of the first.
        accuracy: relative error of the model whose curve is followed; None: the default of `reference`.
        claims: whether the error of every point is estimated, which takes a third of the time or more.
        quiet: whether messages on standard error are left out while code is compiled.

    Raises:
        CaseError, Refusal: an invalid argument, or a machine without such a curve.
        EngineFailure: no periodic motion was found in the range.
    """
    chosen, names = one_case(case), tuple(texts_given(measures, "measures", USUAL))
    varied, held = range_of(key, range, "range"), speed_of(speed, "speed")
    with compilation_announced(quiet):
        return Resonance(chosen, resonance_curve(chosen, varied, held, names, checked(accuracy), claims))


def speed_of(text: str | None, option: str) -> float | None:
    """A crank speed, rad/s; None for None. CaseError: the text is not a speed, or is zero."""
    speed = None if text is None else si_value(SPEED, text, option)
    if text is not None and speed == 0.0:
        raise CaseError(option, SPEED, as_written(text), "does not turn the crank", 'give a speed such as "165 rpm"')
    return speed
