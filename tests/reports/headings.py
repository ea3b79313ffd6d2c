"""The headings of a report, and what they must say by the CSV files beside the page.

What is recomputed here shares no code with what made the headings but the way numbers are written.
"""

import html
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from quickreturn.reports.words import case_label, duration, in_words, listed, number, quantity, size

Tables = Mapping[str, pd.DataFrame]

#: Statuses of runs whose numbers are used.
USABLE: Final = ("settled", "inaccurate")
#: Effects that time reversal and the mirror forbid to make the halves differ.
SYMMETRIC: Final = [
    "cubic elements", "both rollers soft", "clearance", "mass of the slider", "inertia of the slider", "tip body’s centre farther out",
    "strip stiffer", "drive: mass of the crank",
]  # fmt: skip
#: An engine tells the same story where at most this part of its numbers is beyond what is claimed.
FEW: Final = 0.05
_WORDS: Final = {word: str(count) for count, word in enumerate(map(in_words, range(1, 13)), start=1)}
_NUMBER: Final = re.compile(r"\d+(?:\.\d+)?|\b(?:" + "|".join(_WORDS) + r")\b", re.IGNORECASE)


def headings(page: str) -> dict[str, str]:
    """Chapter -> the finding in its heading; and under "answer" the first screen's sentences and numbers."""
    chapters = re.findall(r'<details class="chapter" id="(\w+)">.*?<span class="finding">(.*?)</span></h2>', page, re.DOTALL)
    answer = page[page.index('<div class="told">') : page.index('<fieldset id="engines">')]
    return {name: _plain(text) for name, text in [("answer", answer), *chapters]}


def tables_in(folder: Path) -> Tables:
    """The CSV files of a report by their names without ending, columns without units."""
    found = {file.stem: pd.read_csv(file) for file in folder.glob("*.csv")}
    return {name: table.rename(columns=lambda head: re.sub(r" \[.*\]$", "", head)) for name, table in found.items()}


def numbers_in(text: str) -> list[str]:
    """All numbers of a text, those in words, too, sorted."""
    return sorted(_WORDS.get(found.lower(), found) for found in _NUMBER.findall(text))


def mistakes(told: Mapping[str, str], tables: Tables) -> list[str]:
    """What is wrong with headings: a phrase that should be there, or a number that nothing accounts for."""
    found = []
    for name, text in told.items():
        phrases = [_plain(phrase) for phrase in EXPECTED[name](tables)]
        found += [f"{name}: {phrase!r} is not in {text!r}" for phrase in phrases if phrase.lower() not in text.lower()]
        accounted = numbers_in(" ".join(phrases))
        if numbers_in(text) != accounted:
            found.append(f"{name}: the numbers of {text!r} are not {accounted}")
    return found


def _plain(text: str) -> str:
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", text)).replace("\N{NO-BREAK SPACE}", " ").split())


def _runs(tables: Tables) -> pd.DataFrame:
    return tables["run_by_engine"]


def _engines(tables: Tables) -> list[str]:
    return list(dict.fromkeys(_runs(tables)["engine"]))


def _judged(tables: Tables) -> tuple[pd.Series, pd.Series]:
    """Comparisons of each engine, and how many of them are beyond what is claimed."""
    if "compared" not in tables:
        return pd.Series(dtype=int), pd.Series(dtype=int)
    sums = tables["compared"].groupby("engine", sort=False)[["compared", "beyond"]].sum()
    return sums["compared"], sums["beyond"]


def _alike(tables: Tables) -> list[str]:
    """The engine that the others are held against, and those that agree with it."""
    compared, beyond = _judged(tables)
    alike = [name for name in compared.index if beyond[name] <= FEW * compared[name]]
    return [*dict.fromkeys(tables["compared"]["other"]), *alike] if alike else []


def _differences(tables: Tables, names: list[str], ending: str) -> np.ndarray:
    """All differences of engines from the reference in columns of `run_by_engine` with an ending."""
    rows = _runs(tables)[_runs(tables)["engine"].isin(names)]
    values = rows[[head for head in rows.columns if head.endswith(ending)]].to_numpy(dtype=float).ravel()
    return values[np.isfinite(values)]


def answer(tables: Tables) -> list[str]:
    """The first screen."""
    runs, alike, engines, cases = _runs(tables), _alike(tables), _engines(tables), len(tables["map"])
    others = [name for name in alike if name != "reference"]
    frequency = size(np.abs(_differences(tables, others, "_frequency_difference")).max())
    amplitudes = np.abs(_differences(tables, others, "_amplitude_difference"))
    rows = runs[runs["engine"].isin(others)]
    heads = [head for head in rows.columns if head.endswith("_amplitude_difference")]
    worst = rows.loc[rows[heads].abs().max(axis=1).idxmax(), "case"]
    cubic, ratios = _differences(tables, ["thesis"], "_frequency_difference"), []
    for name, table in tables.items():
        if name.startswith("run_thesis"):
            peaks = table.set_index("engine")["peak_strain_2"]
            ratios.append(peaks["thesis"] / peaks["reference"])
    setups = {1: "this set-up", 2: "both set-ups"}.get(cases, f"all {in_words(cases)} set-ups")
    median, span = float(np.median(cubic)), [number(100.0 * value, ".0f") for value in (cubic.min(), cubic.max())]
    solving, split = _fastest(tables)[:2], []
    if "finding" in tables:
        strength, pre, post = _softer_side(tables)
        split = [f"({number(100.0 * pre, '+.1f')} % before, {number(100.0 * post, '+.1f')} % after, at {strength}"]
        rows = tables["finding"][tables["finding"]["effect"] == "roller soft after the return"]
        posts = [f"{number(100.0 * value, '+.1f')} %" for value in rows["post_frequency"]]
        split += [f"after the return {', '.join(posts)} at the {in_words(len(posts))} strengths tried"]
    setup = _measured(tables, solving[0])["setup_seconds"]
    return [
        f"{in_words(len(alike))} of {in_words(len(engines))} simulations" if len(alike) < len(engines) else f"{in_words(len(alike))} sim",
        f"{in_words(len(alike))} programs that model the arm in different ways compute the same motion in {setups}",
        f"its ringing frequency differs by at most {frequency}",
        f"The 1999 model, which lets the arm bend in one simple curve only, rings {size(median)} faster",
        f"shows {number(100.0 * float(np.median(ratios)), '.0f')} % of the strain",
        *(["a roller that is softer on one side makes that difference", *split] if split else []),
        f"{(runs['status'] == 'settled').sum()} of {len(runs)} simulations",
        "by their own estimates",
        f"{frequency} largest frequency difference of the {in_words(len(alike))} that agree",
        f"largest amplitude difference {size(amplitudes.max())} ({case_label(worst)})",
        f"{number(100.0 * median, '+.0f')} % the 1999 model’s frequency over the converged one (median; {span[0]} to {span[1]} %)",
        f"{duration(solving[0][1])} to solve {case_label(tables['fastest']['case'][1])} to 0.1 %,",
        f"after a set-up of {duration(setup)}: {solving[0][0]}, made for this mechanism;",
        f"{solving[1][0]} takes {number(solving[1][1] / solving[0][1], '.0f')} times as long",
    ]


def strength(tables: Tables) -> list[str]:
    """Will it hold? By the reference where it gives the stress, else by the first engine that does."""
    rows = tables["strength"][tables["strength"]["case"] == tables["strength"]["case"][0]]
    lead = sorted(rows[rows["quantity"] == "stress"]["engine"], key=lambda name: name != "reference")[0]
    mine = rows[rows["engine"] == lead].set_index("quantity")
    found = [f"{quantity(mine['value']['stress'], 'MPa')} at {1e3 * mine['place']['stress']:.0f} mm from P"]
    known = [(key, word) for key, word in (("yield_factor", "yielding"), ("fatigue_factor", "fatigue")) if key in mine.index]
    found += [f"safety {mine['value'][key]:.3g} against {word}" for key, word in known[:1]]
    ratios = rows[rows["quantity"] == "frequency_ratio"]["value"]
    if len(ratios):
        harmonic = max(1, round(ratios.iloc[0]))
        found.append(f"harmonic {harmonic} is {size(ratios.iloc[0] / harmonic - 1.0)} from resonance")
    return found


def resonance(tables: Tables) -> list[str]:
    """How near is a resonance? Of the first case."""
    rows = tables["resonances"][tables["resonances"]["case"] == tables["resonances"]["case"][0]]
    own = rows[rows["point"] == "your machine"].iloc[0]

    def nearest(points: pd.DataFrame, otherwise: str) -> str:
        if points.empty:
            return f"no {otherwise} within 15 %"
        found = points.loc[points["distance"].abs().idxmin()]
        way = "faster" if found["distance"] > 0.0 else "slower"
        return f"{number(30.0 / np.pi * found['speed'], '.5g')} rpm{{}}, {size(found['distance'])} {way}"

    peaks, changes = rows[rows["point"] == "peak"], rows[~rows["point"].isin(["peak", "your machine"])]
    order = "" if peaks.empty else f" (order {peaks.loc[peaks['distance'].abs().idxmin(), 'order']:.0f})"
    found = [f"your machine runs at {number(30.0 / np.pi * own['speed'], '.5g')} rpm"]
    return [*found, nearest(peaks, "peak").format(order), nearest(changes, "fold and no loss of stability").format("")]


def agreement(tables: Tables) -> list[str]:
    """Who agrees with whom."""
    compared, beyond = _judged(tables)
    if not compared.sum():
        return ["Nothing could be judged"]
    found = [f"In {beyond.sum()} of {compared.sum()} comparisons engines differ by more than they claim"]
    if not beyond.sum():
        sharp = tables["sharpness"].groupby("kind")["found_somewhere"].max()
        least = [f"{size(sharp[kind])} in every {word}" for kind, word in (("frequency", "frequency"), ("extreme", "peak"))]
        silent = tables["compared"]["say_nothing"].sum()
        told = f"{compared.sum() - silent} comparisons" if silent else f"all {compared.sum()} comparisons"
        found = [
            f"{in_words(len(_alike(tables)))} agree within what they claim in {told}",
            *([f"{silent} more say nothing"] if silent else []),
        ]
        found += [*least, f"or {size(sharp['amplitude'])} in every amplitude would have shown"]
    cubic = size(tables["map"]["thesis_frequency_difference"].abs().max())
    return [*found, f"the 1999 model’s frequency is {cubic} off the converged one at worst"]


def runs(tables: Tables) -> list[str]:
    """Every run on every engine."""
    rows, found = _runs(tables), []
    unsettled = (rows["status"] != "settled").sum()
    found.append(f"{unsettled} of the simulations" if unsettled else "All settled")
    for name in _engines(tables):
        usable = rows[(rows["engine"] == name) & rows["status"].isin(USABLE)]
        told = usable[["pre_frequency", "post_frequency"]].notna().to_numpy()
        found += [f"{name} {told.sum()} of {told.size}"] if told.size else []
    return found


def recorded(tables: Tables) -> list[str]:
    """Recorded tables."""
    rows = tables["recorded"]
    compared, beyond = rows["compared"].sum(), rows["beyond"].sum()
    return [listed(list(dict.fromkeys(rows["table"]))), f"{beyond} of {compared} comparisons" if beyond else f"all {compared} comparisons"]


def methods(tables: Tables) -> list[str]:
    """Which method excels."""
    solve = _solve_seconds(tables)
    won = solve.dropna(how="all").idxmin(axis=1)
    winner, unwon = won.value_counts().index[0], len(solve) - len(won)
    first, second = _fastest(tables)[:2]
    own = winner.split(",")[0] not in ("exudyn", "mujoco")
    code = ", this project’s own code compiled for this one mechanism," if own else ""
    found = [f"{winner}{code} solves fastest in {won.value_counts().iloc[0]} of {len(solve)} contests"]
    if "waiting" in tables:
        soonest = tables["waiting"].sort_values("waited_seconds", kind="stable").groupby(["case", "level"])["method"].first()
        found.append(f"(by waiting time, {(soonest == winner).sum()})")
    found += [f"{unwon} nobody wins"] if unwon else []
    found.append(f"to 0.1 % in {case_label(tables['fastest']['case'][1])} {first[0]} solves in {duration(first[1])}")
    found.append(f"({second[0]} in {duration(second[1])})")
    mine = _measured(tables, (winner, solve[winner][1]))
    found.append(f"takes {duration(mine['setup_seconds'])} for set-up")
    if np.isfinite(mine["estimate_seconds"]):
        found.append(f"{duration(mine['estimate_seconds'])} for the estimate of its error")
    if "compiling" in tables and winner in set(tables["compiling"]["engine"]):
        seconds = tables["compiling"].set_index("engine")["compile_seconds"][winner]
        found.append(f"once {duration(seconds)} for compilation")
    return found


#: Scenes of the map of classes: six speeds by three tips, and fourteen in which another group varies.
WHOLE_MAP = 6 * 3 + 14


def classes(tables: Tables) -> list[str]:
    """Which method, where: to 1 %."""
    rows, cells = tables["classes"], tables["classes_map_1_0.01"].filter(regex=r"^speed [\d.]+$").notna().sum().sum()
    rows = rows[rows["level"] == 0.01]
    alone, waited = (rows.pivot_table(index="scene", columns="engine", values=f"{time}_seconds") for time in ("solve", "waited"))
    won = alone.idxmin(axis=1)
    winner = won.value_counts().index[0]
    factors = [row.nsmallest(2).iloc[1] / row.min() for _, row in alone[won == winner].iterrows() if row.count() > 1]
    span = [number(min(factors), ".2g"), "to"] * (len(factors) > 1) + [number(max(factors), ".0f" if max(factors) >= 9.95 else ".1f")]
    code = ", this project’s own code," if winner not in ("exudyn", "mujoco") else ""
    return [
        f"{winner}{code} solves fastest to 1 % in {(won == winner).sum()} of {cells} classes of machines",
        f"(the next takes {' '.join(span)} times as long); by waiting time, ",
        *(f"{name} in {count}" for name, count in waited.idxmin(axis=1).value_counts().items()),
        *([f"; {WHOLE_MAP - cells} more classes of the map are not recorded"] * int(cells < WHOLE_MAP)),
    ]


def _solve_seconds(tables: Tables) -> pd.DataFrame:
    """A row per contest, a column per method."""
    table = tables["fastest"]
    heads = [head for head in table.columns if head.endswith(" solve_seconds")]
    return table[heads].rename(columns=lambda head: head.removesuffix(" solve_seconds")).astype(float)


def _fastest(tables: Tables) -> list[tuple[str, float]]:
    """Methods of different engines in the second contest (0.1 % in the first scene), with their solve times, fastest first."""
    assert tables["fastest"]["level"][1] == 1e-3
    order = _solve_seconds(tables).iloc[1].dropna().sort_values(kind="stable")
    first = order.index[0]
    return [(name, seconds) for name, seconds in order.items() if name == first or name.split(",")[0] != first.split(",")[0]]


def _measured(tables: Tables, which: tuple[str, float]) -> pd.Series:
    """The row of the benchmark's first scene with a method and a solve time."""
    rows = tables["benchmark"]
    rows = rows[(rows["case"] == tables["fastest"]["case"][1]) & (rows["method"] == which[0])]
    return rows.loc[(rows["solve_seconds"] - which[1]).abs().idxmin()]


def thesis(tables: Tables) -> list[str]:
    """What the thesis saw."""
    table, outcomes = tables["thesis_over_reference"], tables["statements"]["verdict"].value_counts()
    ratios = table[table["quantity"] == "first-mode frequency"].iloc[0]
    halves = [number(ratios[f"{half}_median"], ".2f") for half in ("pre", "post")]
    many = {"holds": "hold", "holds in part": "hold in part", "does not hold": "do not hold"}
    counted = [f"{count} {many.get(outcome, outcome) if count > 1 else outcome}" for outcome, count in outcomes.items()]
    if "finding" in tables:
        (strength, pre, post), symmetric = _softer_side(tables), tables["finding"].set_index("effect").loc[SYMMETRIC]
        nothing = (symmetric["apart"].abs() <= 2.0**0.5 * symmetric["measured"]).all()
        return [
            "Of the effects tried, only a roller that is softer on one side makes the halves differ as it says:",
            f"at {strength} by {number(100.0 * pre, '+.1f')} % before and {number(100.0 * post, '+.1f')} % after the return (medians)",
            *(["no symmetric effect tried moves them apart by more than the measurement leaves open"] if nothing else []),
            f"{outcomes.sum()} statements",
            *counted,
        ]
    return [
        f"Its one cubic is too stiff before and after the return alike ({halves[0]} and {halves[1]} times the converged frequency",
        f"medians of {ratios['pre_runs']:.0f} and {ratios['post_runs']:.0f} runs",
        f"{outcomes.sum()} statements",
        *counted,
    ]


def _softer_side(tables: Tables) -> tuple[str, float, float]:
    """The weakest softness of the roller that carries after the return that makes the halves differ by 2 %, and what it changes."""
    rows = tables["finding"][tables["finding"]["effect"] == "roller soft after the return"]
    first = rows[(rows["apart"] <= 1.0 / 1.02 - 1.0) & (-rows["apart"] > 2.0**0.5 * rows["measured"])].iloc[0]
    return first["strength"], first["pre_frequency"], first["post_frequency"]


def accuracy(tables: Tables) -> list[str]:
    """Accuracy and cost; without studies it tells of the search for steady states alone."""
    if "accuracy" not in tables:
        return [f"the work of {number(tables['periodic_orbits']['cycles_of_work'].median(), '.3g')} cycles"]
    rows = tables["accuracy"]
    return ["run 24", *(f"{size(error)} ({name})" for name, error in zip(rows["engine"], rows["tip_deflection"], strict=True))]


def hard(tables: Tables) -> list[str]:
    """Hard scenes."""
    cells, own = tables["hard_scenes_cells"], "solves its own equations"
    off = cells[cells["verdict"] == own]["model_error"].dropna() * 100.0
    checked = cells[cells["claim_holds"].notna()]
    failed = int((checked["claim_holds"].astype(str) == "False").sum())
    wrong = "none silently wrong" if not failed else f"{failed} claim{'s' * (failed > 1)} did not hold"
    found = [f"Of {len(cells)} cells"]
    for verdict, count in cells["verdict"].value_counts().items():
        words = f"{count} {'solve their' if count > 1 else 'solves its'} own equations alone"
        found.append(words if verdict == own else f"{count} {verdict}")
    if len(off) > 1:
        found.append(f"{off.min():.0f} to {off.max():.0f} % off there")
    elif len(off):
        found.append(f"{size(off.iloc[0] / 100.0)} off there")
    found.append(f"{wrong} of {len(checked)} claims that could be checked")
    of_model = (checked["engine"] == "thesis").sum()
    return [*found, f"{of_model} of them against a model’s own equations"] if of_model else found


def experiment(tables: Tables) -> list[str]:
    """The experiment: of every engine on the page."""
    table, ranges = tables["experiment"], dict[str, list[str]]()
    for name in _engines(tables):
        ratios = table[f"strain_{name}"].dropna()
        ranges.setdefault(f"{ratios.min():.2f} to {ratios.max():.2f}", []).append(name)
    factor = {name: np.median(np.abs(np.log(table[f"strain_{name}"].dropna()))) for name in ("thesis", "reference")}
    worse = ["the converged model fits this one contact with the measurement worse"] if factor["reference"] > factor["thesis"] else []
    return [*(f"{span} ({listed(names)})" for span, names in ranges.items()), *worse]


def inconsistencies(tables: Tables) -> list[str]:
    """Published inconsistencies."""
    return [f"{len(tables['inconsistencies'])} contradictions and gaps"]


def provenance(tables: Tables) -> list[str]:
    """Provenance; the date of the verification is no number of a table."""
    troubles = int((_runs(tables)["status"] != "settled").sum())
    told = [f"{troubles} run{'s' * (troubles > 1)} not simply settled"] if troubles else []
    engines = len(tables["engines"])
    return [f"{engines} engine{'s' * (engines > 1)}, versions", *told]


def following(tables: Tables) -> list[str]:
    """What to do next."""
    failed = int((~_runs(tables)["status"].isin(("settled", "refused"))).sum())
    return [f"{failed} simulation{'s' * (failed > 1)} did not deliver"] if failed else []


def files(tables: Tables) -> list[str]:
    """Tables as files: all but their list."""
    return [f"{len(tables) - 1} tables"]


#: Chapter -> what its heading must say: phrases that hold all of its numbers.
EXPECTED: Final[Mapping[str, Callable[[Tables], list[str]]]] = {
    "answer": answer,
    "strength": strength,
    "resonance": resonance,
    "agreement": agreement,
    "runs": runs,
    "recorded": recorded,
    "methods": methods,
    "classes": classes,
    "thesis": thesis,
    "accuracy": accuracy,
    "hard": hard,
    "experiment": experiment,
    "inconsistencies": inconsistencies,
    "each": lambda _: [],
    "next": following,
    "provenance": provenance,
    "files": files,
}
