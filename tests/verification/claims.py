"""What becomes of the claims of a campaign (`accuracy_campaign`): which can be judged, which hold, and what is left out."""

from typing import Final

import pandas as pd

from tests.verification.random_scenes import LARGEST_CONDITION

#: The confirming run's own error may be so much: 40 links leave up to 4e-3 in the acceleration of a thesis' run.
CONFIRMED: Final = 1e-2
#: The truth must be known this many times better than what is judged by it.
MARGIN: Final = 3.0


def judged(table: pd.DataFrame) -> pd.DataFrame:
    """The claims whose truth is known well enough and confirmed, with the column `ratio` = error / claim; violent scenes left out."""
    found = table[(table["condition"] < LARGEST_CONDITION) & table["claim"].notna() & table["error"].notna()]
    numbers = found[["claim", "error", "truth_error", "confirmation"]].astype(float)
    larger = numbers[["claim", "error"]].max(axis=1)
    found = found[(MARGIN * numbers["truth_error"] <= larger) & (numbers["confirmation"] <= CONFIRMED)]
    return found.assign(ratio=found["error"].astype(float) / found["claim"].astype(float))


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """One row per engine, accuracy and column: how many claims are judged, the share that holds, and how far off they are."""
    rows = [
        {
            "engine": name,
            "asked": asked,
            "column": column,
            "claims": len(group),
            "hold": float((group["ratio"] <= 1.0).mean()),
            "worst error / claim": float(group["ratio"].max()),
            "median claim / error": float((1.0 / group["ratio"]).median()),
        }
        for (name, asked, column), group in judged(table).groupby(["engine", "asked", "column"], sort=False)
    ]
    return pd.DataFrame(rows)


def deliveries(table: pd.DataFrame) -> pd.DataFrame:
    """One row per engine and accuracy: in how many scenes it ran, claimed an error for every column, reached what was asked; times."""
    sane = table[table["condition"] < LARGEST_CONDITION]
    rows = []
    for (name, asked), group in sane.groupby(["engine", "asked"], sort=False):
        scenes = group.groupby("scene")
        rows.append(
            {
                "engine": name,
                "asked": asked,
                "scenes": len(scenes),
                "ran": int(scenes["error"].count().gt(0).sum()),
                "claimed": float((scenes["claim"].count() == scenes["column"].count()).mean()),
                "reached": float(scenes["reached"].all().mean()),
                "median solve [s]": float(scenes["solve_seconds"].first().median()),
                "median total [s]": float(scenes["total_seconds"].first().median()),
            }
        )
    return pd.DataFrame(rows)


def left_out(table: pd.DataFrame) -> pd.DataFrame:
    """Scenes with columns that cannot be judged: how violent, how well the truth is known, how far the confirming run is from it."""
    once = table.drop_duplicates(["scene", "column"])
    numbers = once[["condition", "truth_error", "confirmation"]].astype(float)
    unknown = (
        (numbers["condition"] >= LARGEST_CONDITION) | (MARGIN * numbers["truth_error"] > 1e-3) | ~(numbers["confirmation"] <= CONFIRMED)
    )
    return once[unknown][["scene", "column", "condition", "truth_error", "confirmation", "confirmed_by"]].reset_index(drop=True)
