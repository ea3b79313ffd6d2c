"""Differences of two runs, column by column, and their explanation: a mistake, noise, or another case."""

import math
from collections.abc import Collection, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from threadpoolctl import threadpool_limits

from quickreturn.cases.case import Case
from quickreturn.cases.measures.steady_state import GRID, on_common_grid
from quickreturn.cases.mistakes.construction import built_otherwise
from quickreturn.cases.mistakes.diagnosis import diagnose, share_of
from quickreturn.cases.mistakes.explanation import Hypothesis
from quickreturn.cases.runs.marching import channels_of
from quickreturn.cases.runs.noise import white_noise
from quickreturn.cases.runs.other_case import OtherCases, other_cases
from quickreturn.cases.runs.recorded import GROWING, VIBRATING
from quickreturn.cases.runs.request import NOTHING, Run
from quickreturn.engines.relative import relative_error, rms
from quickreturn.reference_model.columns import COLUMNS

Array = NDArray[np.float64]

#: Least relative RMS difference of a column that is explained.
LEAST_DIFFERENCE: Final = 0.02
#: What to do about a column that is late.
_SHIFTED: Final = "look from where the crank angle is counted, and when the row is taken"
#: Key of an explanation of the whole table, in place of a column: it looks like one of another case.
WHOLE: Final = "case"
#: Key of a sentence on a table that does not fit its case, for which neither a mistake nor another case is known.
UNFIT: Final = "scene"
#: Key of a lead to other values of quantities.
QUANTITIES: Final = "quantities"
#: Key of a hypothesis on how another program's machine was built.
BUILT: Final = "construction"
#: A table does not fit its case if at least `FEWEST_COLUMNS` vibrate, all of them differ by more than `LARGE_DIFFERENCE` of their RMS, and
#: fewer than half of them are explained by a mistake that leaves at most the part `LARGEST_REMAINDER` of the column: a factor that is
#: fitted to the column of another case leaves half of it.
FEWEST_COLUMNS: Final = 3
LARGE_DIFFERENCE: Final = 0.1
LARGEST_REMAINDER: Final = 0.3
#: Least relative RMS difference of a column that is told without an explanation: half of its size.
LEAST_UNEXPLAINED: Final = 0.5
#: Least RMS of a difference besides noise that is reported, as a part of the noise, whose RMS is known to 7 % from 200 rows.
LEAST_REST: Final = 0.5


def column_differences(run: Run, other: Run) -> dict[str, float]:
    """RMS difference of each column that both have, over its RMS in the other, at equal crank angles of the turn that was measured."""
    return {name: relative_error(recorded, expected) for name, (recorded, expected) in _on_grid(run, other).items()}


def explanations(run: Run, other: Run, case: Case) -> dict[str, str]:
    """Explanations of the differences of a table from an engine: column -> a sentence that names the mistake and says what to do.

    If all vibrating columns are equally late, the crank angle is wrong. A table of another case is reported under `WHOLE`, and none of its
    columns is explained; under `UNFIT` stands that nothing explains it, and under `BUILT` a hypothesis on how another program's machine was
    built. `run` is that of the table, `other` that of the engine on the case, in the same turn or state.
    """
    with threadpool_limits(limits=1, user_api="blas"):  # hundreds of small eigenproblems
        others = other_cases(run, other, case)
    if others.names and others.sure:
        return {WHOLE: _of_another(others)}
    grids, right = _on_grid(run, other), on_common_grid(channels_of(other.cycle, COLUMNS.keys() & other.cycle.keys()))
    sentences, remainders, late, puzzling = dict[str, str](), dict[str, float](), dict[str, int](), dict[str, float]()
    for name, (recorded, expected) in grids.items():
        if noise := _noise_of(name, run, other):
            sentences[name], remainders[name] = noise, 0.0
            continue
        lag = _lag(recorded, expected)
        shifted = Hypothesis(f"is about {_degrees(abs(lag)):.3g} deg of the crank {_when(lag)}", _SHIFTED, np.roll(expected, lag), fitted=1)
        finding = diagnose(name, recorded, expected, LEAST_DIFFERENCE * max(rms(expected), rms(recorded)), right, case.mechanism, [shifted])
        if finding is not None and finding.remainder is not None:
            sentences[name], remainders[name] = f"{finding.cause}; {finding.advice}", finding.remainder
            if finding.advice == _SHIFTED:
                late[name] = lag
        elif finding is not None:
            puzzling[name] = relative_error(recorded, expected)
    vibrating = [name for name in grids if name in VIBRATING]
    if len(vibrating) > 1 and late.keys() >= set(vibrating) and max(late.values()) - min(late.values()) <= 1:
        lag = late[vibrating[0]]
        off = f"{_degrees(abs(lag)):.3g} deg too {'large' if lag > 0 else 'small'}"
        ahead = f"crank_angle is about {off}, or all columns are {_when(lag)}"
        return {"crank_angle": ahead} | {name: sentence for name, sentence in sentences.items() if name not in late}
    off_by = {name: relative_error(*grids[name]) for name in vibrating}
    specific = {
        name: told for name, told in sentences.items() if name in off_by and remainders[name] <= LARGEST_REMAINDER * rms(grids[name][0])
    }
    construction = "" if "tip_deflection" in sentences else _construction(run, other, case, off_by.get("tip_deflection", 0.0))
    hint = {BUILT: construction} if construction else {}
    if len(off_by) >= FEWEST_COLUMNS and min(off_by.values()) > LARGE_DIFFERENCE and 2 * len(specific) < len(off_by):
        if others.names:
            return {WHOLE: _of_another(others)} | specific
        return {UNFIT: _fits_not(case.name, off_by, others.told)} | specific | hint
    for name, share in puzzling.items():
        if share > LEAST_UNEXPLAINED and not hint:
            sentences[name] = f"{name} is off by {share_of(share)}, and no single mistake explains that"
    return sentences | hint


def _construction(run: Run, other: Run, case: Case, off: float) -> str:
    """A hypothesis on how another program's machine was built, whose tip deflection is `off`, relative; "" where there is none."""
    if off <= LEAST_DIFFERENCE or run.recording is None or run.recording.filtered:
        return ""
    return built_otherwise(run.cycle, other.cycle, run.recording.gap, case.mechanism, case.units)


def _of_another(others: OtherCases) -> str:
    return f"this looks like a table of {' or '.join(others.names)}: {others.told}; compare it with that case"


def _fits_not(case: str, off_by: Mapping[str, float], told: str) -> str:
    """A sentence on a table whose columns do not fit; `told`: further evidence, a clause or ""."""
    off = f"off by {100.0 * min(off_by.values()):.0f} to {100.0 * max(off_by.values()):.0f} %{told and '; '}{told}"
    question = "is it a table of another case, is a quantity of the scene another one, or is the model coarse?"
    return f"none of its {len(off_by)} columns that vibrate fits {case} ({off}), and no single mistake explains that: {question}"


def is_puzzling(run: Run, other: Run, sentences: Collection[str]) -> bool:
    """Whether most of the columns that vibrate differ and have no explanation; `sentences`: keys of `explanations`."""
    off_by = {name: share for name, share in column_differences(run, other).items() if name in VIBRATING}
    puzzling = [name for name, share in off_by.items() if share > LEAST_DIFFERENCE and name not in sentences]
    return WHOLE not in sentences and 2 * len(puzzling) > len(off_by)


def _noise_of(name: str, run: Run, other: Run) -> str:
    """A sentence on a column whose differences are mostly noise, if that is more than `LEAST_DIFFERENCE` of the column; otherwise ""."""
    turned, other_turned = (np.abs(each.cycle["crank_angle"] - each.cycle["crank_angle"][0]) for each in (run, other))
    expected = CubicSpline(other_turned, other.cycle[name])(turned)
    inside = slice(1, -1)  # the first and the last row of a turn are interpolated
    difference, size = (run.cycle[name] - expected)[inside], rms(expected)
    noise = white_noise(run.cycle["time"][inside], difference)
    if noise is None or noise.rms <= LEAST_DIFFERENCE * size:
        return ""
    white = f"{100.0 * noise.rms / size:.2g} % RMS, white" + (f" above {noise.above:.2g} Hz" if noise.above else "")
    besides = math.sqrt(max(rms(difference) ** 2 - noise.rms**2, 0.0))
    more = f"; besides that it is off by {100.0 * besides / size:.1g} %" if besides > LEAST_REST * noise.rms else ""
    return f"the differences of {name} look like noise of {white}{more}"


def _lag(recorded: Array, expected: Array) -> int:
    """Lateness of a column in points of the grid, at most half a turn; negative if it is early."""
    lag = int(np.argmax(np.fft.irfft(np.fft.rfft(recorded) * np.conj(np.fft.rfft(expected)), GRID)))
    return lag if lag <= GRID // 2 else lag - GRID


def _degrees(places: int) -> float:
    return 360.0 * places / GRID


def _when(lag: int) -> str:
    return "late" if lag > 0 else "early"


def _on_grid(run: Run, other: Run) -> dict[str, tuple[Array, Array]]:
    """Columns that both have and that are not zero in the other, at even crank angles of the turn."""
    names = [name for name in run.cycle if name in other.cycle and name not in GROWING and other.peak(name) > NOTHING]
    recorded, expected = (on_common_grid(channels_of(each.cycle, names)) for each in (run, other))
    return {name: (recorded[name], expected[name]) for name in names}
