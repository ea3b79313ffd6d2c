"""Combines templates, style, script and data into one self-contained file."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, Final

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reports import words
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.first_screen import Figure, agreement_screen, answer_of
from quickreturn.reports.page.part import parts
from quickreturn.reports.page.view import View, cycles, shown_first, trajectories
from quickreturn.reports.tables import csv_text

#: Parts of every page's script, in their order, and further parts for a page with chapters.
SCRIPT: Final = ("unpack.js", "motion.js", "stage.js", "curve.js", "page.js", "paper.js")
OF_CHAPTERS: Final = ("tables.js", "marks.js", "chart.js", "plots.js", "choice.js")
#: Functions of `reports.words` that templates call.
WORDS: Final = ("number", "percent", "counted", "listed", "case_label")
#: Short description of an engine for a reader.
KINDS: Final = {
    "thesis": "one curve, 1999",
    "reference": "many curves",
    "exudyn": "finite elements",
    "mujoco": "rigid links",
    "fixed-shapes": "curves that stay",
    "multiplier": "constraint force",
    "stiff-spring": "stiff spring",
    "nodal-load": "force on nodes",
    "moving-boundaries": "two moving spans",
    "derived": "by computer",
}


@cache
def environment(packages: tuple[str, ...] = ()) -> Environment:
    """The Jinja environment of these templates and those of other packages; inserted values are plain text to a browser.

    Each template is compiled once in a process.
    A template of the page goes by its name in `templates`, any other one by its path in its package: `chapters/ID.html`.
    """
    loader = ChoiceLoader([PackageLoader("quickreturn.reports"), *(PackageLoader(each, "") for each in ("quickreturn.reports", *packages))])
    jinja = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    jinja.globals |= {name: getattr(words, name) for name in WORDS}
    jinja.filters["csv"] = csv_text
    jinja.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return jinja


def rendered(template: str, view: View, more: tuple[str, ...] = (), packages: tuple[str, ...] = (), **values: Any) -> str:
    """A page around a view.

    Args:
        template: a template that extends `page.html`.
        view: the moving mechanism.
        more: parts of the script besides `SCRIPT`.
        packages: further packages with templates.
        values: values for the template.
    """
    jinja = environment(packages)
    shared = {
        "view": view,
        "document": view.document | {"start": values.pop("start", view.runs[0]["name"])},
        "looks": view.looks,
        "kinds": KINDS,
        "cyclic": view.axis == "crank_angle",
        "enveloped": any(run["stress"] for run in view.runs),
        "groups": _groups(view),
        "style": Markup(jinja.get_template("style.css").render(engines=view.engines, looks=view.looks)),
        "script": Markup("\n".join(jinja.get_template(f"script/{part}").render() for part in (*SCRIPT, *more))),
    }
    return jinja.get_template(template).render(shared | values)


def report_page(content: Content, chapters: Sequence[Chapter]) -> str:
    """The page of a report."""
    results, answer = content.results, answer_of(content)
    machines = next(filter(None, (part.machines(content) for part in parts() if part.machines)), {})
    view = cycles(results, answer.engines, {name: screen.along_arm for name, screen in machines.items()})
    view.drawn = [series.of for chapter in chapters for plot in chapter.plots for series in plot.series]
    shown = shown_first(results)
    title_of_case = shown.case.title if len(results) == 1 else ""
    figures = (part.figure(content) for part in parts() if part.figure)
    simulations = f"{words.counted(len(results), 'run')} × {words.counted(len(answer.engines), 'engine')}"
    return rendered(
        "report.html",
        view,
        OF_CHAPTERS,
        (*content.templates, *(package for part in parts() for package in part.templates)),
        start=shown.case.name,
        title=title_of_case or "Cross-validation of flexible-multibody engines",
        subtitle=f"cross-validation report · {simulations} · {content.facts.get('date', '')[:10]}",
        screen=agreement_screen(answer, content.subject, title_of_case, next(filter(None, figures), _first_mode(shown))),
        machines=machines,
        shown=shown.case.name,
        chapters=chapters,
    )


def _first_mode(result: CaseResult) -> Figure | None:
    """First-mode frequencies before and after the return by the leading engine; None if none is resolvable."""
    lead = result.runs.get(REFERENCE) or next(iter(result.runs.values()))
    frequencies = [lead.consensus_frequency(half) if lead.usable else None for half in HALVES]
    if not any(frequencies):
        return None
    shown = " / ".join("n. r." if value is None else f"{value:.1f}" for value in frequencies)
    return f"{shown} Hz", f"first-mode frequency before and after the quick return, {words.case_label(result.case.name)}"


def animation_page(case: Case, motions: Mapping[str, Trajectory]) -> str:
    """A page of its own with the moving mechanism of a case.

    Args:
        case: gives geometry and title.
        motions: engine -> its trajectory.

    Raises:
        CaseError: the case has no crank.
    """
    view = trajectories(case, {name: motion.columns for name, motion in motions.items()})
    return rendered("animation.html", view, title=case.title, subtitle="motion from the standard start")


def _groups(view: View) -> dict[str, list[dict[str, Any]]]:
    """Group -> its registered cases, for the page's buttons; empty if there is another case, which the page then offers in a list."""
    if len(view.runs) < 2 or not all(run["group"] for run in view.runs):
        return {}
    return {group: [run for run in view.runs if run["group"] == group] for group in dict.fromkeys(run["group"] for run in view.runs)}
