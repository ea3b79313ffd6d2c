"""A chapter is added as `docs/developing.md` says: a module, a template, and its name in one file. Done on a copy of the package."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.package_copy import ROOT, copied_package

MODULE = '''"""How fast the cranks turn."""

from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import CASE
from quickreturn.reports.tables import Column, Table
from quickreturn.reports.words import counted


def speeds(content: Content) -> Chapter:
    """The chapter."""
    table = Table("speeds", "Mean speed of the crank.", (CASE, Column("speed", unit="rad/s", form=".1f")))
    for result in content.results:
        table.add(case=result.case.name, speed=result.runs["reference"].mean_crank_speed)
    return Chapter("speeds", "How fast it turns", finding(len(table.rows)), {"table": table})


def finding(cases: int) -> str:
    """The number of cases."""
    return f"The crank turns in {counted(cases, 'case')}"
'''
TEMPLATE = """{% from "macros.html" import table %}
{% macro body(f) %}
<p>As the reference computes it.</p>
{{ table(f.table) }}
{% endmacro %}
"""
#: Writes reports on made-up results, one on the user's own machine and one on a run of the thesis.
WRITE = """
from pathlib import Path
from quickreturn.reports.report import write
from tests.reports.pages import one_run
from tests.reports.reported_results import reported_result
for case in ("example", "thesis-24"):
    Path(case).mkdir()
    write(one_run(reported_result(case)), Path(case))
"""


def insert(file: Path, text: str, after: str) -> None:
    """Insert a text after another one."""
    written = file.read_text()
    assert written.count(after) == 1
    file.write_text(written.replace(after, after + text))


@pytest.mark.verify
def test_a_chapter_needs_a_module_a_template_and_its_name_in_one_file(tmp_path: Path) -> None:
    package = copied_package(tmp_path / "copy", "reference_model", "engines", "cases", "reports")
    (package / "reports/chapters/speeds.py").write_text(MODULE)
    (package / "reports/chapters/speeds.html").write_text(TEMPLATE)
    chapters, imported = package / "reports/page/chapters.py", "from quickreturn.reports.chapters.{0} import {0}\n"
    insert(chapters, imported.format("speeds"), after=imported.format("recorded"))
    insert(chapters, "speeds: 15, ", after="CHAPTERS: Final[Mapping[MakeChapter, float]] = {")

    environment = os.environ | {"PYTHONPATH": os.pathsep.join((str(package.parent), str(ROOT / "build/tests-alone")))}
    told = subprocess.run([sys.executable, "-c", WRITE], env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stderr
    for case, before, after in (("example", "strength", "each"), ("thesis-24", "agreement", "runs")):
        folder = tmp_path / case
        page = (folder / "index.html").read_text()
        finding = "The crank turns in 1\N{NO-BREAK SPACE}case"
        assert f'<span class="name">How fast it turns</span> <span class="finding">{finding}</span>' in page
        assert page.index(f'id="{before}"') < page.index('id="speeds"') < page.index(f'id="{after}"')
        assert 'id="table-speeds"' in page
        assert (folder / "speeds.csv").read_text().startswith(f"case,speed [rad/s]\n{case},")
        assert "speeds.csv,1,Mean speed of the crank." in (folder / "tables.csv").read_text()
