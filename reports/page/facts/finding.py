"""What the thesis' finding comes from: the recorded study, the picture of it, and what would suffice."""

import statistics
from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any, Final

from cases.finding import EFFECTS
from cases.finding.study import Confirmation, Row
from cases.runs.comparison import REFERENCE, CaseResult
from reports.findings.conclusions import ACCURATE
from reports.findings.runs import thesis_runs
from reports.findings.sufficiency import OF_NO_JOINT, SIMULATION, Tried, apart, conflicts, sufficiency, tried, words_of
from reports.page.plot import Plot, Series
from reports.tables import finding as tables
from reports.words import number

#: The ratio after the return over that before it from which on the thesis' words "more substantial" are read.
EXCESS: Final = 1.02
#: The effect that preload makes linear again.
PRELOAD: Final = "preload"


def finding(rows: Sequence[Row], second: Sequence[Confirmation], results: Sequence[CaseResult]) -> dict[str, Any]:
    """Facts for the chapter on the thesis; empty without a recorded study."""
    sets = tried(rows)
    if not sets:
        return {}
    found = sufficiency(sets)
    symmetric = {effect.id for effect in EFFECTS if effect.symmetric}
    moved = {(row.effect, row.strength): gap for row in rows if (gap := apart(row)) is not None}
    return {
        "splitting": _splitting(rows, moved),
        "symmetric": max(abs(gap) for (effect, _), gap in moved.items() if effect in symmetric),
        "against": max(((gap, words_of(effect), strength) for (effect, strength), gap in moved.items()), default=None),
        "nothing": [each.statement.words for each in found if not each.sets and each.statement.id not in OF_NO_JOINT],
        "conflicts": [(one.words, other.words) for one, other in conflicts(found)],
        "sets": len(sets),
        "choices": sorted({len(each.choices) for each in sets}),
        "most": max(sets, key=lambda each: sum(each.shown.values())),
        "rings": _rings(sets),
        "gentle": _gentle(rows, results),
        "apart_from_second": _from_second(second),
        "effects_plot": _plot(rows),
        "effects": tables.effects(rows),
        "second": tables.second(second),
        "sufficient": tables.statements(found, len(sets), OF_NO_JOINT),
        "all_sets": tables.sets(sets),
    }


def _splitting(rows: Sequence[Row], moved: Mapping[tuple[str, str], float]) -> list[dict[str, Any]]:
    """Of each effect that makes the halves differ as the words ask for the weakest strength that does, those of fewest choices first."""
    choices = {effect.id: len(effect.choices) for effect in EFFECTS}
    found = []
    for row in rows:
        if moved.get((row.effect, row.strength), 0.0) <= 1.0 / EXCESS - 1.0 and row.effect not in {each["effect"] for each in found}:
            medians = {half: tables.spread(getattr(row, f"{half}_frequency"))[1] for half in ("pre", "post")}
            told = {"effect": row.effect, "words": words_of(row.effect), "strength": row.strength, "choices": choices[row.effect]}
            found.append(told | medians | {"runs": len(tables.known(row.post_frequency))})
    return sorted(found, key=lambda each: each["choices"])


def _rings(sets: Sequence[Tried]) -> dict[str, list[float]]:
    """Effect -> frequencies (Hz) of run 24's fast vibration at the return, where both halves are told apart or the vibration is seen."""
    wanted = {"clearance", "post-side", "preload", "post-side-alloy"}
    found: dict[str, list[float]] = {}
    for each in sets:
        if each.row.effect in wanted and each.row.example:
            found.setdefault("clearance" if each.row.effect == "clearance" else "soft", []).append(each.row.example[3])
    return found


def _gentle(rows: Sequence[Row], results: Sequence[CaseResult]) -> dict[str, Any] | None:
    """What the strongest preload leaves of the difference between the halves, in runs whose slider force it exceeds and in the others."""
    strongest = next((row for row in reversed(rows) if row.effect == PRELOAD), None)
    cycles = {run: found.runs[REFERENCE].cycle for run, found in thesis_runs(results).items() if REFERENCE in found.runs}
    forces = {run: max(abs(cycle["slider_force"])) for run, cycle in cycles.items() if "slider_force" in cycle}
    if strongest is None:
        return None
    preload = float(strongest.strength.split()[0])
    gaps: dict[bool, list[float]] = {True: [], False: []}
    for run, force in forces.items():
        before, after = strongest.pre_frequency[run - 1], strongest.post_frequency[run - 1]
        if before is not None and after is not None:
            gaps[force < preload].append((1.0 + after / 100.0) / (1.0 + before / 100.0) - 1.0)
    if not all(gaps.values()):
        return None
    return {
        "preload": strongest.strength,
        "gentle": statistics.median(gaps[True]),
        "others": statistics.median(gaps[False]),
        "counts": (len(gaps[True]), len(gaps[False])),
    }


def _from_second(found: Sequence[Confirmation]) -> tuple[float, int, int] | None:
    """Largest difference of a change between both formulations, of how many, and how many the second one could not make."""
    pairs = [pair for each in found for pair in ((each.pre, each.second_pre), (each.post, each.second_post))]
    differences = [abs(one - other) / 100.0 for one, other in pairs if one is not None and other is not None]
    return (max(differences), len(differences), sum(bool(each.reason) for each in found)) if differences else None


def _plot(rows: Sequence[Row]) -> Plot:
    """Change before the return across, after it up: an effect a line through its strengths."""
    series = []
    for effect, strengths in groupby(rows, lambda row: row.effect):
        points = [(row, tables.spread(row.pre_frequency), tables.spread(row.post_frequency)) for row in strengths]
        points = [point for point in points if point[1] and point[2] and effect in {each.id for each in EFFECTS}]
        if points:
            series.append(
                Series(
                    words_of(effect),
                    effect,
                    [100.0 * pre[1] for _, pre, _ in points],
                    [100.0 * post[1] for _, _, post in points],
                    [
                        f"{row.strength}: {number(100.0 * pre[1], '+.1f')} % and {number(100.0 * post[1], '+.1f')} %"
                        for row, pre, post in points
                    ],
                    bars=[[100.0 * pre[0], 100.0 * pre[2], 100.0 * post[0], 100.0 * post[2]] for _, pre, post in points],
                )
            )
    lowest = min(bar[2] for each in series for bar in each.bars)
    cubic = next((row for row in rows if (row.effect, row.strength) == SIMULATION), None)
    excess = 1.0 + tables.spread(cubic.pre_frequency)[1] if cubic else 1.0
    regions = [
        _region("asked of the machine, were the simulation right else", 1.0, lowest),
        _region("with one cubic as the simulation", excess, lowest),
    ]
    return Plot("finding.csv", "change before the return [%]", "change after the return [%]", series, regions=regions)


def _region(name: str, simulation: float, lowest: float) -> tuple[str, list[tuple[float, float]]]:
    """What the experiment may be where the simulation is right before the return and too high by more after it."""
    ends = [simulation / ratio for ratio in reversed(ACCURATE)]
    corners = [(end, end / EXCESS) for end in ends]
    below = 1.0 + lowest / 100.0 if simulation == 1.0 else min(end / EXCESS for end in ends) - 0.05
    corners += [(ends[1], below), (ends[0], below)]
    return name, [(100.0 * (x - 1.0), 100.0 * (y - 1.0)) for x, y in corners]
