"""A measure is added as `docs/developing.md` says: a function and its declaration in one file. Done on a copy of the package."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.package_copy import ROOT, whole_package

FUNCTION = '''def rms_of_jerk(turn: Turn) -> float:
    """Root mean square of the jerk at the tip, m/s^3."""
    return rms_over_time(turn["time"], np.gradient(turn["tip_acceleration"], turn["time"]))


'''
DECLARATION = """    OfTurn(
        "rms.tip_jerk",
        "m/s^3",
        "root mean square of the jerk at the tip over a turn",
        ("time", "tip_acceleration"),
        rms_of_jerk,
        size=True,
        in_tables=TableColumn("RMS tip jerk", ".3g", in_terminal=".1f"),
    ),
"""
#: Shows made-up results in every way, with the names under which the test finds them.
SHOW = """
import json, sys
from pathlib import Path
import quickreturn as qr
from quickreturn.cases.motion.catalogue import listed
from quickreturn.cases.comparison.engines import compare
from quickreturn.verdict_text import as_document
from quickreturn.cross_validation import CrossValidation
from quickreturn.reports.output import plain
from quickreturn.reports.report import write
from quickreturn.plugins.studies.resonance_curve.resonance import OF_CURVE
from tests.reports.pages import one_run
from tests.reports.reported_results import reported_result
from tests.witnesses import unconfirmed

made_up = reported_result("example")
run = made_up.runs["reference"]
result = compare(made_up.case, {"reference": run})
found = CrossValidation([result])
write(one_run(result), Path(sys.argv[1]))
numbers = found.numbers.set_index(["engine", "measure"])
print(json.dumps({
    "time": run.cycle["time"].tolist(), "acceleration": run.cycle["tip_acceleration"].tolist(),
    "python": plain(numbers.loc[("reference", "rms.tip_jerk")].to_dict()), "json": plain(as_document([result], ())), "text": str(found),
    "help": [each.name for each in listed()], "measures": [each.name for each in qr.measures()], "curve": list(OF_CURVE),
    "unconfirmed": sorted(unconfirmed()),
}))
"""


def with_jerk(folder: Path) -> dict[str, str]:
    """The environment of a copy of the package with a further measure."""
    package = whole_package(folder)
    file = package / "cases/motion/of_turn.py"
    text, declarations = file.read_text("utf-8"), "#: The declarations.\nOF_TURN: Final = (\n"
    assert text.count(declarations) == 1
    file.write_text(text.replace(declarations, FUNCTION + declarations + DECLARATION), "utf-8")
    return os.environ | {"PYTHONPATH": os.pathsep.join((str(package.parent), str(ROOT / "build/tests-alone")))}


@pytest.mark.verify
def test_a_measure_needs_a_function_and_a_declaration_and_appears_wherever_measures_do(tmp_path: Path) -> None:
    environment = with_jerk(tmp_path / "copy")
    (tmp_path / "report").mkdir()
    command = [sys.executable, "-c", SHOW, str(tmp_path / "report")]
    told = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stderr
    found = json.loads(told.stdout)
    time = np.array(found["time"])
    jerk = np.gradient(found["acceleration"], time)
    right = float(np.sqrt(np.trapezoid(jerk**2, time) / np.ptp(time)))
    assert found["python"] == {"case": "example", "value": pytest.approx(right), "error": None, "unit": "m/s^3"}
    engines = {each["engine"]: each["numbers"] for each in found["json"]["cases"][0]["engines"]}
    assert engines["reference"]["rms.tip_jerk"] == {"value": pytest.approx(right), "error": None, "unit": "m/s^3"}
    (heads,) = (line for line in found["text"].splitlines() if line.startswith("engine"))
    assert "f1 post Hz  RMS tip jerk m/s3  peak accel. m/s2" in heads
    assert f"{right:.1f}" in found["text"]
    for listing in ("help", "measures", "curve"):
        assert "rms.tip_jerk" in found[listing], listing
    assert found["unconfirmed"] == [["measure", "rms.tip_jerk"]]  # until the table of witnesses has it
    rows = [line.split(",") for line in (tmp_path / "report/run_example.csv").read_text("utf-8").splitlines()]
    place = rows[0].index("rms_tip_jerk [m/s³]")
    assert [float(row[place]) for row in rows[1:] if row[0] == "reference"] == [pytest.approx(right)]
    page = (tmp_path / "report/index.html").read_text("utf-8")
    assert "RMS tip jerk" in page[page.index('id="table-run_example"') :]
