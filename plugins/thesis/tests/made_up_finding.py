"""A made-up study of what the thesis' finding comes from: every effect, with a known share in each half."""

from quickreturn.cases.library.thesis.runs import RUNS
from quickreturn.plugins.thesis.finding.effects import PUBLISHED, effects
from quickreturn.plugins.thesis.finding.study import CONFIRMED_RUNS, JOINT_EFFECTS, SECOND, Row
from quickreturn.plugins.thesis.scatter import Band

#: Change of the frequency before and after the return at the strongest, %; of other effects none.
CHANGES = {
    "cubic": (12.0, 12.0),
    "linear": (-6.0, -6.0),
    "post-side": (0.0, -6.0),
    "pre-side": (-6.0, 0.0),
    "drag": (-1.8, 1.8),
    "post-side-alloy": (10.5, 4.5),
    "strip": (10.5, 10.5),
}
#: Frequency (Hz) and RMS (m/s^2) of run 24's vibration at the return, and how strain 3 goes with strain 1; else there is none.
RINGS = {"clearance": (134.0, 10.0, 0.5), "post-side": (80.0, 5.0, -0.9), "pre-side": (134.0, 10.0, 0.3)}


def made_up_finding() -> list[Row]:
    """As a recorded study has it; runs 1 to 8 are not resolvable before the return, and strengths go as 1, 2 and 3."""
    rows = [_row(PUBLISHED.id, PUBLISHED.words[0], "reference", (0.0, 0.0))]
    for effect in effects():
        strongest = CHANGES.get(effect.id, (0.0, 0.0))
        for place, words in enumerate(effect.words, start=1):
            rows.append(_row(effect.id, words, effect.engine, (strongest[0] * place / 3.0, strongest[1] * place / 3.0), claimed=place == 2))
    second = [row for row in rows if row.claim and row.effect in JOINT_EFFECTS]
    changes = [(100.0 * row.changes("pre_frequency")[24], 100.0 * row.changes("post_frequency")[24] + 0.1) for row in second]
    return rows + [_row(row.effect, row.strength, SECOND, change) for row, change in zip(second, changes, strict=True)]


def _row(effect: str, strength: str, engine: str, changes: tuple[float, float], claimed: bool = False) -> Row:
    frequency, rms, sign = RINGS.get(effect, (60.0, 0.0, -0.9))
    runs = CONFIRMED_RUNS if engine == SECOND else tuple(RUNS)
    spread = 0.0 if engine == SECOND or changes == (0.0, 0.0) else 0.05
    before, after = ([round(100.0 * (change + spread * (run - 12))) for run in runs] for change in changes)
    return Row(
        effect=effect,
        strength=strength,
        engine=engine,
        pre_frequency=tuple(None if run < 9 else value for run, value in zip(runs, before, strict=True)),
        post_frequency=tuple(after),
        pre_amplitude=(0,) * len(runs),
        post_amplitude=(0,) * len(runs),
        acceleration=2,
        strain=1,
        band=rms,
        example=(16.6 * (1.0 + changes[0] / 100.0), 16.7 * (1.0 + changes[1] / 100.0), rms, frequency, -0.8, sign),
        measured=0.7,
        claim=(0.05, 1.0, 2.0, 1.0, 0.1) if claimed else (),
        runs=len(runs),
        failed=0,
    )


#: Band of run 24 over the scatter of quantities that are not printed.
BAND = Band(
    run=24,
    points=16,
    settled=15,
    compared=14,
    pre=(15.5, 16.4, 17.1),
    post=(15.6, 16.5, 17.2),
    ratio=(0.9995, 1.0023, 1.0051),
    apart=0,
    strain=(2.9e-4, 3.8e-4, 8.4e-4),
    sampled=(0.011, 0.01, 0.12),
    claims=(0.006, 0.007, 0.001),
)
