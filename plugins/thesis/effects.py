"""Facts on the causes of the thesis' finding: the recorded study of effects, its plot, and the sufficient effects."""

import statistics
from collections.abc import Sequence
from typing import Any, Final

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.plugins.thesis import effect_tables as tables
from quickreturn.plugins.thesis.experiment import statements
from quickreturn.plugins.thesis.finding.effects import effects, name_of
from quickreturn.plugins.thesis.finding.study import SECOND, Row
from quickreturn.plugins.thesis.runs import thesis_runs
from quickreturn.plugins.thesis.sufficiency import OF_NO_JOINT, SIMULATION, Trial, sufficiency, trials
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.words import counted, number, percent

#: The statement that the frequency before the return is right, and the least ratio by which the excess after it is larger.
PRE: Final = next(each for each in statements() if each.id == "pre-frequency")
EXCESS: Final = next(each.low for each in statements() if each.id == "post-excess")
#: Lower end of the drawn region that is open below, as a part of the frequency.
DEPTH: Final = 0.06
#: Effects of friction.
FRICTION: Final = ("friction", "drag", "pivot")
#: The effect whose strength is a preload, N: a force of the slider below it leaves both rollers in contact. Section 3.2 of the thesis says
#: that the rollers were tightened.
PRELOAD: Final = "preload"


#: Hz, the frequency that section 3.4 reads off run 24.
SECOND_MODE: Final = next(statement.low for statement in statements() if statement.id == "second-mode")


def effect_facts(study: Sequence[Row], results: Sequence[CaseResult]) -> dict[str, Any]:
    """Sentences, tables and the plot of the chapter on the thesis, without a plot if no study is recorded."""
    sets = trials(study)
    rows, second = ([row for row in study if (row.engine == SECOND) == other] for other in (False, True))
    pairs = [
        (confirmed, confirming)
        for confirming in second
        for confirmed in rows
        if (confirmed.effect, confirmed.strength) == (confirming.effect, confirming.strength)
    ]
    if not sets:
        return {"effects_plot": None}
    verdicts = sufficiency(sets)
    return {
        "odd": odd_words(rows),
        "sets": set_words(sets),
        "runs": min(row.runs for row in rows),
        "rings": ring_words(sets, rows, results),
        "effects_plot": _plot(rows),
        "effects": tables.effects(rows),
        "second": tables.second(pairs),
        "sufficient": tables.statements(verdicts, len(sets), OF_NO_JOINT),
        "all_sets": tables.sets(sets),
    }


def symmetric_effects_differ(rows: Sequence[Row]) -> bool:
    """Whether an effect that acts alike on both sides moves the halves apart by more than the measurement leaves open."""
    symmetric = {effect.id for effect in effects() if effect.symmetric}
    return any(row.tells_halves_apart for row in rows if row.effect in symmetric and row.engine != SECOND)


def tightened_words(rows: Sequence[Row]) -> str:
    """What the strongest preload leaves of the difference between the halves (a clause); "" if that was not recorded."""
    strongest = _strongest_preload(rows)
    if strongest is None or strongest.apart is None:
        return ""
    apart, asked = strongest.apart, 1.0 / EXCESS - 1.0
    against = "less than" if apart > asked else "as"
    return (
        f"section 3.2 says that the rollers were tightened, and a preload of {strongest.strength} leaves {percent(apart, '+.1f')}"
        f" between the halves, {against} the words ask ({percent(asked, '+.1f')})"
    )


def _strongest_preload(rows: Sequence[Row]) -> Row | None:
    return next((row for row in reversed(rows) if row.effect == PRELOAD and row.engine == REFERENCE), None)


def odd_words(rows: Sequence[Row]) -> str:
    """What symmetric effects and friction do."""
    moved = {(row.effect, row.strength): gap for row in rows if (gap := row.apart) is not None}
    gap, name, strength = max((gap, name_of(effect), strength) for (effect, strength), gap in moved.items() if effect in FRICTION)
    none = "" if symmetric_effects_differ(rows) else "None of these moves the halves apart by more than the measurement leaves open. "
    return (
        "A law that is odd in the gap and conserves energy cannot make the halves differ, because reversed time and a reflection map"
        f" one half of the cycle onto the other. {none}Friction makes them differ in the opposite sense: {name}, {strength}:"
        f" {percent(gap, '+.1f')}."
    )


def set_words(sets: Sequence[Trial]) -> str:
    """How certain the finding is."""
    choices, best = sorted({len(each.choices) for each in sets}), max(sets, key=lambda each: sum(each.shown.values()))
    return (
        f"Certainty: this is an inference from words and axis labels, because no curve survives. {len(sets)} sets were tried; none of their"
        f" {choices[0]} to {choices[-1]} choices is published, and the best shows {sum(best.shown.values())} of the {len(best.shown)}"
        f" statements that a joint can bear on ({best.words})."
    )


def ring_words(sets: Sequence[Trial], rows: Sequence[Row], results: Sequence[CaseResult]) -> str:
    """What a digitised curve of run 24 would decide, and gentle runs; "" if the frequencies at the return are not known."""
    rings, gentle = _rings(sets), _gentle(rows, results)
    if len(rings) < 2:
        return ""
    return (
        f"A digitised curve of run 24 would decide: just after the return clearance rings at {_hertz(rings['clearance'])}, a soft roller at"
        f" {_hertz(rings['soft'])} (strongest from 60 to 200 Hz); section 3.4 read {SECOND_MODE:g} Hz.{gentle}"
    )


def _hertz(frequencies: Sequence[float]) -> str:
    ends = (number(min(frequencies), ".0f"), number(max(frequencies), ".0f"))
    return f"{' to '.join(dict.fromkeys(ends))} Hz"


def _rings(sets: Sequence[Trial]) -> dict[str, list[float]]:
    """Strongest frequencies (Hz) of run 24 from 60 to 200 Hz at the return: with "clearance", and with a "soft" roller on one side."""
    wanted = {"clearance", "post-side", "preload", "post-side-alloy"}
    rings: dict[str, list[float]] = {}
    for trial in sets:
        if trial.row.effect in wanted and trial.row.example:
            rings.setdefault("clearance" if trial.row.effect == "clearance" else "soft", []).append(trial.row.example[3])
    return rings


def _gentle(rows: Sequence[Row], results: Sequence[CaseResult]) -> str:
    """How far the strongest preload moves the halves apart, in runs whose slider force it exceeds and in the others; "" if not known."""
    strongest = _strongest_preload(rows)
    cycles = {run: result.runs[REFERENCE].cycle for run, result in thesis_runs(results).items() if REFERENCE in result.runs}
    forces = {run: max(abs(cycle["slider_force"])) for run, cycle in cycles.items() if "slider_force" in cycle}
    if strongest is None:
        return ""
    preload = float(strongest.strength.split()[0])
    gaps: dict[bool, list[float]] = {True: [], False: []}
    before, after = (strongest.changes(f"{half}_frequency") for half in HALVES)
    for run in before:
        if run in after and run in forces:
            gaps[forces[run] < preload].append((1.0 + after[run]) / (1.0 + before[run]) - 1.0)
    if not all(gaps.values()):
        return ""
    gentle, others = (percent(statistics.median(gaps[kind]), "+.1f") for kind in (True, False))
    return (
        f" Gentle runs would, too: where a preload of {strongest.strength} exceeds the slider’s force it makes the joint linear, and the"
        f" difference between the halves is {gentle} ({counted(len(gaps[True]), 'run')}), otherwise {others} ({len(gaps[False])})."
    )


def _plot(rows: Sequence[Row]) -> Plot:
    """Plot of the change after the return over that before it: a line for each effect through its strengths, bars between quartiles."""
    series = []
    for effect in effects():
        of_effect = [row for row in rows if row.effect == effect.id]
        spreads = [tuple(100.0 * each for half in HALVES for each in tables.spread(row.changes(f"{half}_frequency"))) for row in of_effect]
        points = [(row, spread) for row, spread in zip(of_effect, spreads, strict=True) if len(spread) == 6]
        texts = [f"{row.strength}: {number(spread[1], '+.1f')} % before, {number(spread[4], '+.1f')} % after" for row, spread in points]
        across, up = [spread[1] for _, spread in points], [spread[4] for _, spread in points]
        bars = [(spread[0], spread[2], spread[3], spread[5]) for _, spread in points]
        series.append(Series(effect.name, effect.id, across, up, texts, bars=bars))
    cubic = next(row for row in rows if (row.effect, row.strength) == SIMULATION)
    regions = [_asked(1.0), _asked(1.0 + tables.spread(cubic.changes("pre_frequency"))[1])]
    return Plot("finding.csv", "change before the return [%]", "change after the return [%]", series, regions=regions)


def _asked(simulation: float) -> list[tuple[float, float]]:
    """Corners of the region, %, where the words place the experiment, open below; `simulation`: its frequency over the converged one."""
    ends = [simulation / ratio for ratio in (PRE.high, PRE.low)]
    corners = [(end, end / EXCESS) for end in ends] + [(end, end / EXCESS - DEPTH) for end in reversed(ends)]
    return [(100.0 * (x - 1.0), 100.0 * (y - 1.0)) for x, y in corners]
