"""How the page came about: engines, versions, machine, settings, failures, assumptions, files."""

from typing import Final

from cases.runs.request import SETTLED
from reference_model.mechanism import TorqueDrive
from reports.findings.failures import MEANINGS
from reports.findings.runs import thesis_runs
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.tables import engines as engine_tables
from reports.tables import provenance as tables
from reports.tables.table import Column, Table, TableBuilder
from reports.words import number

STANDARD_GRAVITY: Final = 9.80665  # m/s²

#: What is assumed where the thesis is silent.
ASSUMPTIONS: Final = (
    "Slider: no mass, no inertia, a rigid joint; a frictionless point contact that turns with the follower's slope.",
    "Gravity: none in the plane of motion.",
    "Tip body: its centre of mass at the flexible end, x = L. The inch of strip beyond it that the thesis counts as tip mass suggests some"
    " 0.5 in; see What the thesis leaves open.",
    "Beam damping: the printed unit is illegible. It is read as force per length and velocity, on the velocity of the centre line"
    " relative to the base frame, both components.",
    "Crank: driven by a constant torque against viscous damping, not at a prescribed speed. Amplitudes depend on it, and all engines"
    " share it.",
    "Crank damping of run 24: torque over printed speed, because the printed damping contradicts the printed speed.",
    "Printed strain: percent of surface strain.",
    "Axial stiffness, where an engine needs one: EI·A/I of the rectangular section, and up to 16 times that where the stretch would"
    " count: the follower of a scene does not stretch.",
    "Start: crank at 180° with its mean speed, follower straight and moving as in the rigid mechanism. The steady state is taken not"
    " to depend on it.",
)


def provenance(content: Content) -> Chapter:
    """How the page came about."""
    chapter = Chapter("provenance", "Provenance", "Provenance")
    chapter.heading("Failures and statuses", "failures")
    troubles = content.troubles
    if troubles:
        chapter.points([f"{status}: {meaning}." for status, meaning in MEANINGS.items() if status in {t.status for t in troubles}])
        chapter.table(tables.troubles(troubles))
    else:
        chapter.text(f"Every engine {MEANINGS[SETTLED]} on every case.")
    if content.pictures.failures:
        chapter.text("Pictures that could not be drawn:", "warning")
        chapter.points(content.pictures.failures)
    if content.studies is not None and content.studies.failures:
        chapter.text("Parts of the studies that could not be made:", "warning")
        chapter.points(content.studies.failures)
    if content.notices:
        chapter.text("Notices of the store:", "note")
        chapter.points(list(content.notices))
    chapter.heading("Engines", "engines")
    chapter.table(tables.engines(content.results))
    chapter.heading("Machine and software", "machine")
    chapter.table(tables.machine({**content.facts, "code": content.code}))
    chapter.text(
        "Code is the fingerprint (SHA-256) of the code and libraries that computed the results. A stored result is shown only if scene,"
        " settings, engine version and this fingerprint are today's; solve times are those of when it was computed.",
        "note",
    )
    chapter.heading("Assumed where the thesis is silent", "assumptions")
    chapter.points(ASSUMPTIONS)
    chapter.text(_gravity(content))
    chapter.heading("Settings of every run", "settings")
    chapter.table(engine_tables.settings(content.results))
    return chapter


def _gravity(content: Content) -> str:
    """What in-plane gravity would do to the crank."""
    for result in thesis_runs(content.results).values():
        crank = result.case.mechanism.crank
        if isinstance(crank.drive, TorqueDrive):
            weight = crank.mass * STANDARD_GRAVITY * crank.center_of_mass
            return (
                f"In-plane gravity would be no small change: on the thesis' heavy crank it makes up to {number(weight, '.3g')} N m"
                f" against a driving torque of {number(crank.drive.torque, '.3g')} N m."
            )
    return ""


def verification(content: Content) -> Chapter:
    """Results of the long verification."""
    chapter = Chapter("verification", "Verification", "Verification")
    found = content.verification
    if found.absent:
        chapter.text(
            f"The long verification (every engine on every case, convergence, faults and inputs) is made by `make verify`. {found.absent}",
            "note",
        )
        return chapter
    chapter.text(f"Made by `make verify` on {found.date}, with this code.")
    for index, part in enumerate(found.chapters, start=1):
        chapter.heading(str(part["title"]), f"verification-{index}")
        chapter.text(str(part["text"]))
        chapter.table(_table(f"verification_{index}", part))
    return chapter


def _table(name: str, part: dict[str, object]) -> Table:
    heads, rows = list(part["columns"]), list(part["rows"])  # type: ignore[call-overload]  # checked when it was read
    numeric = [any(isinstance(row[i], float) for row in rows) for i in range(len(heads))]
    columns = [Column(f"column_{i}", str(head), form=".4g" if numeric[i] else "") for i, head in enumerate(heads)]
    builder = TableBuilder(name, str(part["title"]), columns)
    for row in rows:
        builder.add(**{column.key: value for column, value in zip(columns, row, strict=True)})
    return builder.table()


def files(content: Content, listed: Table) -> Chapter:
    """The list of all CSV files, which is itself one."""
    chapter = Chapter("files", "Tables as files", "Files")
    chapter.text("Full precision, SI units; remarks such as reasons in columns of their own.")
    chapter.table(listed)
    return chapter
