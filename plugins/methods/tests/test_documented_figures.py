"""Figures of the race in README and documents are those of the records."""

import math
import re

import pytest

from quickreturn.engines.registry import MODEL
from quickreturn.plugins.methods.fronts import DEFLECTION, standings
from quickreturn.plugins.methods.map import TIMES
from quickreturn.plugins.methods.row import LEVELS, REACHED
from quickreturn.plugins.methods.studies import class_map, recorded
from tests.test_documents import prose


def test_speeds_are_those_of_the_recorded_benchmark() -> None:
    """Solve and waiting times of run 24 by method and level of the error; a bare word says that there are none."""
    rows = re.findall(
        r"^\| (`[^|]*`) \| ([^|]*) \| ([^|]*) \| ([^|]*) \|$",
        prose("docs/methods.md").partition("| seconds to solve (wait) |")[2],
        re.MULTILINE,
    )
    assert len(rows) >= 5
    for names, *cells in rows:
        for level, cell in zip(LEVELS, cells, strict=True):
            fastest = fastest_on_run_24(level)
            for name in re.findall(r"`([a-z-]+)`", names):
                found = re.match(r"([\d.]+) \(([\d.]+|–)\)", cell)
                assert (found is None) == (name not in fastest), (name, level)
                if found:
                    given = [None if each == "–" else float(each) for each in found.groups()]
                    assert given == [each and pytest.approx(each, rel=0.03) for each in fastest[name]], (name, level)


def fastest_on_run_24(level: float) -> dict[str, tuple[float, float | None]]:
    """Recorded solve time of each engine at an error of the tip deflection, and the time for its answer (None: too long)."""
    (found,) = (each for each in recorded("benchmark") if each.case == "thesis-24")
    times: dict[str, tuple[float, float | None]] = {}
    given = [row for row in found.given if row.engine != MODEL or row.settings.get("elements", 1) == 1]  # with one cubic, as published
    for at in standings(given, level, DEFLECTION).values():
        answers = [row for row in found.rows if (row.engine, row.level, row.status) == (at.row.engine, level, REACHED)]
        times.setdefault(at.row.engine, (at.seconds, answers[0].answer_seconds if answers else None))
    return times


def test_times_of_shapes_that_stay_are_those_of_the_recorded_benchmark() -> None:
    """Over those of shapes that follow, each with its best integrator, by the worst of four columns."""
    rows = re.findall(r"^  \| [^|]*\(`([\w.-]+)`\) \| ([^|]*) \| ([^|]*) \| ([^|]*) \|$", prose("docs/methods.md"), re.MULTILINE)
    races = {found.case: found for found in recorded("benchmark")}
    assert sorted(name for name, *_ in rows) == sorted(races)
    for name, *cells in rows:
        for level, cell in zip(LEVELS, cells, strict=True):
            ranked = standings(races[name].given, level)
            stay, follow = (
                min((at.seconds for at in ranked.values() if at.row.engine in engines), default=math.inf)
                for engines in (("fixed-shapes", "multiplier"), ("reference",))
            )
            assert (math.inf if cell == "–" else float(cell)) == pytest.approx(stay / follow if follow < math.inf else math.inf, rel=0.03)


@pytest.mark.parametrize("document", ["README.md", "docs/studies.md"])
def test_counts_of_classes_are_those_of_the_recorded_map(document: str) -> None:
    """In how many classes `reference` is first by solve time, and the lead at 1 %."""
    known, text, by_solving = class_map(), " ".join(prose(document).split()), next(iter(TIMES))
    (found,) = re.finditer(r"([\d.]+) to ([\d.]+) times as long to 1 %|to 1 % it takes ([\d.]+) to ([\d.]+)", text)
    factors = known.factors(1e-2, by_solving)["reference"]
    lead = [float(each) for each in found.groups() if each]
    assert lead == pytest.approx([min(factors), max(factors)], rel=0.05)
    for level in (1e-2, 1e-3):
        wins = len(known.factors(level, by_solving)["reference"])
        assert re.search(rf"in {wins} of (the )?{len(known.scenes)} (classes|scenes)", text, re.IGNORECASE)


def test_winners_by_waiting_time_are_those_of_the_recorded_map() -> None:
    text, (_, by_waiting) = " ".join(prose("docs/studies.md").split()), TIMES
    wins = {name: len(factors) for name, factors in class_map().factors(1e-2, by_waiting).items()}
    assert re.search(rf"wins {wins['mujoco']}( classes)?, `fixed-shapes` {wins['fixed-shapes']}, `reference` {wins['reference']}", text)


def test_the_table_of_the_readme_is_the_record() -> None:
    """Times of run 24 to 1 %."""
    rows = re.findall(r"^\| `([a-z-]+)` \| [^|]+ \| (\S+) \| (\S+) \|$", prose("README.md"), re.MULTILINE)
    fastest = fastest_on_run_24(1e-2)
    assert len(rows) == 5
    for name, *cells in rows:
        times = None if "never" in cells[:2] else [float(each) if each != "–" else None for each in cells[:2]]
        assert times == ([each and pytest.approx(each, rel=0.03) for each in fastest[name]] if name in fastest else None), name
