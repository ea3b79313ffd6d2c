"""Made-up results with all that a report reads, and a reader of finished pages."""

import dataclasses
from html.parser import HTMLParser

from quickreturn.cases.comparison.engines import CaseResult, compare
from quickreturn.cases.comparison.pair import Difference
from quickreturn.cases.motion.cycle import EXTREMES, HALVES
from quickreturn.cases.motion.request import PeriodicOrbit
from tests.reports.plotted_results import made_up_result, with_run

DEGREES_OF_FREEDOM = {"thesis": 3, "reference": 17, "exudyn": 70, "mujoco": 20}


def reported_result(name: str, statuses: dict[str, str] | None = None, seed: int = 0) -> CaseResult:
    """All four engines on a case of the library, with all that is known of a run."""
    result = made_up_result(name, statuses, seed)
    for engine, run in result.runs.items():
        result = with_run(
            result,
            engine,
            method="made up",
            accuracy=1e-3,
            remark="" if run.usable else "failed at t = 0.25 s: the beam <snapped>; try another beam",
            settled=run.usable,
            cycles=12,
            settling_error=5e-4,
            error_estimate=8e-4,
            error_estimates={"tip_deflection": 8e-4, "strain_3": 9e-4},
            settings={"elements": 16, "step": 1e-4},
            degrees_of_freedom=DEGREES_OF_FREEDOM[engine],
        )
    # largest modulus 0.768
    orbit = PeriodicOrbit(period=0.378, multipliers=((0.6, 0.48), (0.5, 0.0)), stable=True, iterations=5)
    return with_run(result, "reference", periodic_orbit=orbit)


#: Engine -> factors for `with_frequencies` by which its frequencies are alike in both halves.
ALIKE = {"thesis": (1.13, 1.13), "reference": (1.0, 1.0), "exudyn": (1.0, 1.0), "mujoco": (1.0, 1.0)}


def with_frequencies(name: str, factors: dict[str, tuple[float, float]], base: float = 17.0) -> CaseResult:
    """A case on which each engine's consensus is `base` times its factors before and after the return."""
    result = reported_result(name)
    for engine, run in result.runs.items():
        frequency = {half: base * factor for half, factor in zip(HALVES, factors[engine], strict=True)}
        known = {half: {"first_mode_frequency": frequency[half], "first_mode_frequency_uncertainty": 0.1} for half in HALVES}
        measures = tuple(dataclasses.replace(measure, **known[measure.half]) for measure in run.measured.measures)
        consensus = tuple(dataclasses.replace(each, first_mode_frequency=frequency[each.half]) for each in run.measured.consensus)
        result = with_run(result, engine, measures=measures, consensus=consensus)
    return result


def agreeing(result: CaseResult) -> CaseResult:
    """The same with estimates of the extremes so large that the made-up numbers agree."""
    for engine, run in result.runs.items():
        wide = [{f"{name}_estimate": 0.04 * run.peak(each.channel) for name in EXTREMES} for each in run.measured.measures]
        measures = tuple(dataclasses.replace(each, **estimates) for each, estimates in zip(run.measured.measures, wide, strict=True))
        result = with_run(result, engine, measures=measures)
    return compare(result.case, result.runs)


def departing(result: CaseResult, excess: float = 3.0) -> tuple[CaseResult, Difference]:
    """The same with exudyn's maximum of strain 3 before the return off by so many times what both claim, and its check."""
    reference, exudyn = (result.runs[name].measure("pre", "strain_3") for name in ("reference", "exudyn"))
    assert exudyn is not None
    wanted = ("exudyn", "maximum", "pre", "strain_3")

    def found(of: CaseResult) -> Difference:
        (check,) = (c for c in of.checks if (c.engine, c.quantity, c.half, c.channel) == wanted)
        return check

    off = reference.maximum + excess * found(result).tolerance
    measures = [dataclasses.replace(each, maximum=off) if each is exudyn else each for each in result.runs["exudyn"].measured.measures]
    result = with_run(result, "exudyn", measures=tuple(measures))
    other = compare(result.case, result.runs)
    return other, found(other)


class PageReader(HTMLParser):
    """Tables (file -> header keys and rows of (text, value)), links, sources and text of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tables: dict[str, list[list[tuple[str, str]]]] = {}
        self.heads: dict[str, list[str]] = {}
        self.links: list[str] = []
        self.sources: list[str] = []
        self.tags: set[str] = set()
        self.anchors: list[str] = []
        self.text = ""
        self._file = ""
        self._cell: list[str] | None = None
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attrs}
        self.tags.add(tag)
        self.links += [found["href"]] if "href" in found else []
        self.sources += [found["src"]] if "src" in found else []
        self.anchors += [found["id"]] if "id" in found else []
        if tag == "table":
            self._file = found["data-file"]
            self.tables[self._file], self.heads[self._file] = [], []
        elif "data-column" in found:
            self.heads[self._file].append(found["data-column"])
        elif tag == "tr" and self._file:
            self.tables[self._file].append([])
        elif "data-value" in found:
            self._cell = ["", found["data-value"]]

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "th") and self._cell is not None:
            self.tables[self._file][-1].append((self._cell[0].strip(), self._cell[1]))
            self._cell = None
        if tag == "table":
            self.tables[self._file] = [row for row in self.tables[self._file] if row]
            self._file = ""

    def handle_data(self, data: str) -> None:
        if self.lasttag in ("script", "style"):
            return
        self.text += data
        if self._cell is not None:
            self._cell[0] += data
