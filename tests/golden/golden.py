"""The golden record: key numbers of every engine on every case of the library, each with what the engine claims of its own error.

    python -m tests.golden.golden trajectories --engine reference --engine mujoco

writes the rows of these engines anew (kinds: trajectories, modes, steady). A change of the code must reproduce the record within the
claims of both; what differs stands in `changes.csv` with its reason. A number here is chosen so that the claim bounds its error: the RMS
of a column and its projection on a fixed sweep differ by no more than the RMS of the difference does.
"""

import argparse
import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from quickreturn.cases.comparison.campaign import carry_out
from quickreturn.cases.library import case_names, load_case
from quickreturn.cases.motion.request import Run, RunRequest
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.job import Executor, Job, Limits
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.start import standard_start
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.reference_model.mechanism import Mechanism

FOLDER: Final = Path(__file__).parent
KINDS: Final = ("trajectories", "modes", "steady")
#: Crank angles (deg) at which natural frequencies are recorded, and how many.
ANGLES: Final = (0, 90, 180)
COUNT: Final = 3
#: Claims of natural frequencies, relative: nothing but rounding may change them.
SAME: Final = 1e-6
#: An engine on a case is given up after this time, s; the row then says so. The longest takes 180 s, alone on a slow machine.
LONGEST: Final = 900.0
HALVES: Final = ("pre", "post")

Row = dict[str, Any]


def trajectory_row(case: str, name: str) -> Row:
    """RMS and projection of the estimated columns over the case's duration at the default accuracy, from the standard start."""
    loaded = load_case(case)
    try:
        result = simulate(engine(name), loaded.scene, standard_start(loaded.scene), loaded.duration, loaded.output_step)
    except Refusal:
        return {"status": "refused"}
    except EngineFailure as failure:
        return {"status": "ended", "end": failure.time}
    row: Row = {"status": "reached" if result.reached else "missed"}
    time = result.trajectory["time"]
    sweep = math.sqrt(2.0) * np.cos(2.0 * np.pi * (2.0 + 8.0 * time / time[-1]) * time / time[-1])
    for column in ESTIMATED:
        if column not in result.trajectory.columns:
            continue
        values, claim = result.trajectory[column], result.error_estimates.get(column)
        size = float(np.sqrt(np.mean(values**2)))
        row |= {f"{column} rms": size, f"{column} sweep": float(np.mean(sweep * values))}
        row[f"{column} claim"] = None if claim is None else claim * size
    return row


def modes_row(case: str, name: str) -> Row:
    """Natural frequencies (Hz) with the crank held."""
    scene, chosen = load_case(case).scene, engine(name)
    if not isinstance(scene, Mechanism):
        return {"status": "refused"}
    row: Row = {"status": "found"}
    try:
        settings = chosen.settings_for(chosen.default_accuracy, scene)
        for angle in ANGLES:
            found = chosen.natural_frequencies(scene, math.radians(angle), COUNT, settings)
            row |= {f"{angle} deg, {number + 1}": float(value) for number, value in enumerate(found)}
    except Refusal:
        return {"status": "refused"}
    return row


def steady_rows(pairs: Sequence[tuple[str, str]], executor: Executor) -> dict[tuple[str, str], Row]:
    """Measures of the settled cycle at the default accuracy, by case and engine; taken from the store of results where they are there."""
    loaded = {case: load_case(case) for case, _ in pairs}
    requests = {
        (case, name): RunRequest(mechanism=loaded[case].mechanism, duration=loaded[case].duration, engine=name)
        for case, name in pairs
        if isinstance(loaded[case].scene, Mechanism)
    }
    workshop = Workshop(Store(), executor)
    runs = carry_out(requests, workshop, "steady states")
    return {pair: steady_row(runs[pair]) if pair in runs else {"status": "refused"} for pair in pairs}


def steady_row(run: Run) -> Row:
    """Frequencies with uncertainty, extremes with what the estimate says of them."""
    row: Row = {"status": run.status}
    if not run.approach.settled:
        return row
    for consensus in run.measured.consensus:
        row[f"{consensus.half} frequency"] = consensus.first_mode_frequency
        row[f"{consensus.half} frequency claim"] = consensus.uncertainty
    for channel in dict.fromkeys(measure.channel for measure in run.measured.measures):
        of_channel = [measure for measure in run.measured.measures if measure.channel == channel]
        row[f"{channel} minimum"] = min(measure.minimum for measure in of_channel)
        row[f"{channel} maximum"] = max(measure.maximum for measure in of_channel)
        peak = max(abs(row[f"{channel} minimum"]), abs(row[f"{channel} maximum"]))
        estimate = run.computation.error_estimates.get(channel)
        row[f"{channel} claim"] = None if estimate is None else (estimate + (run.approach.settling_error or 0.0)) * peak
    return row


_MAKERS: Final[Mapping[str, Callable[[str, str], Row]]] = {"trajectories": trajectory_row, "modes": modes_row}


def rows_of(kind: str, pairs: Iterable[tuple[str, str]], executor: Executor | None = None) -> pd.DataFrame:
    """Rows of (case, engine) pairs, computed in processes of their own unless an executor is given."""
    pairs, executor = list(pairs), executor or LocalProcesses(limits=Limits(seconds=LONGEST))
    if kind == "steady":
        of_pair = steady_rows(pairs, executor)
        return pd.DataFrame([{"case": case, "engine": name, **of_pair[case, name]} for case, name in pairs])
    wanted = {f"{case} {name}": (case, name) for case, name in pairs}
    found: dict[str, Row] = {}
    work = [Job(label, _MAKERS[kind], pair) for label, pair in wanted.items()]
    for outcome in executor.run(work):
        found[outcome.job.name] = outcome.value if outcome.completed else {"status": outcome.failure}
        print(kind, outcome.job.name, f"{outcome.seconds:.1f} s", found[outcome.job.name]["status"], file=sys.stderr, flush=True)
    return pd.DataFrame([{"case": case, "engine": name, **found[label]} for label, (case, name) in wanted.items()])


def recorded(kind: str) -> pd.DataFrame:
    """The record of a kind."""
    return pd.read_csv(FOLDER / f"{kind}.csv", dtype={"status": str})


def changes() -> pd.DataFrame:
    """What is known to differ from the record: kind, case and engine ("*" for each), quantity, reason."""
    return pd.read_csv(FOLDER / "changes.csv", dtype=str)


def claim_of(row: Mapping[str, Any], quantity: str) -> float | None:
    """What a row claims of the error of one of its quantities; None where it claims nothing."""
    if "deg" in quantity:
        return SAME * abs(float(row[quantity]))
    name = quantity if quantity.endswith("frequency") else quantity.rpartition(" ")[0]
    claim = row.get(f"{name} claim")
    return None if claim is None or not math.isfinite(float(claim)) else float(claim)


def differences(then: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Quantities of two rows of one case and engine that differ by more than both claim, as clauses."""
    if then["status"] != now["status"]:
        return [f"status: {then['status']} then, {now['status']} now"]
    found = []
    for quantity, value in then.items():
        if quantity in ("case", "engine", "status", "end") or quantity.endswith("claim"):
            continue
        other = now.get(quantity)
        if not _is_number(value) or not _is_number(other):
            if _is_number(value) != _is_number(other):
                found.append(f"{quantity}: {value} then, {other} now")
            continue
        claims = [claim_of(row, quantity) for row in (then, now)]
        known = [claim for claim in claims if claim is not None]
        # six digits are recorded
        allowed = sum(known) + 1e-5 * abs(float(value)) if known else math.inf
        if abs(float(other) - float(value)) > allowed:
            found.append(f"{quantity}: {float(value):.6g} then, {float(other):.6g} now, {allowed:.2g} claimed")
    return found


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and math.isfinite(value)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line, see the top of this file."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden.golden")
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--engine", action="append", choices=(*MAIN, *RIVALS), required=True)
    parser.add_argument("--case", action="append", help="default: all of the library")
    parser.add_argument("--jobs", type=int)
    given = parser.parse_args(arguments)
    executor = LocalProcesses(given.jobs, Limits(seconds=LONGEST))
    table = rows_of(given.kind, [(case, name) for name in given.engine for case in given.case or case_names()], executor)
    file = FOLDER / f"{given.kind}.csv"
    if file.exists():
        kept = recorded(given.kind)
        fresh = set(zip(table["case"], table["engine"], strict=True))
        keep = [pair not in fresh for pair in zip(kept["case"], kept["engine"], strict=True)]
        table = pd.concat([kept[keep], table], ignore_index=True)
    table.to_csv(file, index=False, float_format="%.6g")
    versions = {name: metadata.version(name) for name in ("numpy", "scipy", "numba", "exudyn", "mujoco", "quickreturn")}
    (FOLDER / "versions.txt").write_text("".join(f"{name} {version}\n" for name, version in versions.items()))


if __name__ == "__main__":
    main()
