"""Races with known numbers: errors fall as a power of the number of unknowns, times and calls grow with them."""

from quickreturn.plugins.methods.race import Race
from quickreturn.plugins.methods.row import ENDED, FAILED, OWN_EQUATIONS, REACHED, REFUSED, WRONG, Row
from quickreturn.reports.long_studies import About

COLUMNS = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
#: Engine and variant -> order of the error, error with one unknown, seconds per unknown.
METHODS = {
    ("reference", ""): (4.0, 0.1, 1e-3),
    ("multiplier", ""): (3.0, 1.0, 1e-2),
    ("multiplier", "hermite"): (4.0, 30.0, 2e-2),
    ("exudyn", ""): (2.0, 2.0, 0.1),
    ("thesis", ""): (0.0, 0.8, 1e-2),
}


def made_up_race(case: str = "thesis-24", confirmed: bool = True, engines: tuple[str, ...] = (), acceleration: float = 1.0) -> Race:
    """Of some engines, or of all; the error of the acceleration is `acceleration` times that of the others."""
    rows = []
    for (engine, variant), (order, error, pace) in METHODS.items():
        if engines and engine not in engines:
            continue
        for free in (2, 4, 8, 16):
            errors = dict.fromkeys(COLUMNS, error * free ** (-order))
            errors["tip_acceleration"] *= acceleration
            rows.append(
                Row(
                    scene=case,
                    engine=engine,
                    variant=variant,
                    settings={"modes": free, "tolerance": 1e-7} if engine == "reference" else {"elements": free},
                    signed="a. n. other" if engine == "exudyn" and free == 16 else "",
                    errors=errors,
                    calls=1000.0 * free,
                    call_seconds=0.9e-3 * pace,
                    rows_seconds=0.1 * pace * free,
                    solve_seconds=pace * free,
                    setup_seconds=0.01,
                )
            )
        rows.append(
            Row(scene=case, engine=engine, level=0.01, status=REACHED, errors={"tip_deflection": 5e-3}, claim=7e-3, answer_seconds=0.5)
        )
    rows.append(Row(scene=case, engine="nodal-load", settings={"elements": 2}, status="failed at t = 0.1 s: the beam snapped; try another"))
    confirmation = Row(scene=case, engine="mujoco", settings={"links": 60}, errors=dict.fromkeys(COLUMNS, 1e-4 if confirmed else 1e-2))
    return Race(case, "a title", 2.0, 2.0, confirmation, 32, {"processor": "one"}, tuple(rows))


def made_up_fronts(*races: Race) -> tuple[tuple[Race, ...], About | None]:
    """Those of run 24, or of some races, which are not recorded."""
    return races or (made_up_race(),), None


def made_up_hard_scenes(wrong: bool = False) -> tuple[tuple[Race, ...], About | None]:
    """Two scenes: one that ends, and one in which an engine is silently wrong, or refuses."""
    name = "hard-speed-x3"
    ended = {"status": ENDED, "time": 0.2526, "errors": {"tip_deflection": 4e-3}, "claim": 5e-3}
    first = [
        Row(scene=name, engine="thesis", level=0.01, status=OWN_EQUATIONS, errors={"tip_deflection": 0.81}, claim=1e-4),
        Row(scene=name, engine="reference", level=0.01, **ended),  # type: ignore[arg-type]
    ]
    other = "hard-speed-x2"
    claims = (
        {"status": WRONG, "errors": {"tip_deflection": 0.03}, "claim": 4e-3} if wrong else {"status": REFUSED, "remark": "slider.mass: no"}
    )
    second = [
        Row(scene=other, engine="thesis", level=0.01, status=FAILED, time=0.09, remark="the loop cannot close"),
        Row(scene=other, engine="reference", level=0.01, **claims),  # type: ignore[arg-type]
    ]
    confirmation = Row(scene=name, engine="mujoco", errors={"tip_deflection": 1e-4})
    titles = {name: "Run 24, crank speed x 3: the slider leaves the follower", other: "Run 24, crank speed x 2"}
    scenes = ((other, second), (name, first))
    return tuple(Race(each, titles[each], 2.0, 0.25, confirmation, 0, {}, tuple(rows)) for each, rows in scenes), None
