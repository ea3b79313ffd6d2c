"""Asked in rpm and mm, answered in rpm and mm; asked in inches, in inches: in every text of every command and on the page."""

import dataclasses
import json
import re
from collections.abc import Iterator
from html import unescape
from pathlib import Path

import pytest

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.files.shown import in_lines
from quickreturn.plugins.strength.case_loads import loads_of_case
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.verdict_text import parts_of
from tests.quickreturn.conftest import Call
from tests.reports.pages import one_run, plain
from tests.reports.pages import read as read_page
from tests.reports.reported_results import reported_result

MACHINE = """
name = "lever"
[mechanism]
pivot_distance = "450 mm"
[crank]
length = "100 mm"
mass = "1 kg"
center_of_mass = "0 mm"
inertia = "0.01 kg*m^2"
initial_angle = "180 deg"
prescribed_speed = "90 rpm"
[base]
inertia = "0.001 kg*m^2"
damping = "0 N*m*s/rad"
[follower]
length = "600 mm"
elastic_modulus = "70 GPa"
density = "2700 kg/m^3"
thickness = "3 mm"
width = "30 mm"
material_damping = "1 ms"
damping = "1 N*s/m^2"
strain_gauges = ["150 mm", "300 mm", "450 mm"]
yield_strength = "100 MPa"
[simulation]
duration = "1 s"
output_step = "1 ms"
"""
#: The same machine to ten digits, in inches, pounds and rpm.
IN_INCHES = {
    "450 mm": "17.71653543 in", "100 mm": "3.937007874 in", "1 kg": "0.005710147155 lbf*s^2/in", "0 mm": "0 in",
    "0.01 kg*m^2": "0.08850745792 lbf*s^2*in", "0.001 kg*m^2": "0.008850745792 lbf*s^2*in", "600 mm": "23.62204724 in",
    "3 mm": "0.1181102362 in", "30 mm": "1.181102362 in", "1 N*s/m^2": "0.0001450377377 lbf*s/in^2", "150 mm": "5.905511811 in",
    "300 mm": "11.81102362 in", "0 N*m*s/rad": "0 lbf*in*s/rad", "100 MPa": "14503.77377 psi",
}  # fmt: skip
#: Lines in SI or as the file has them: a material, an engine's words on its model, the caption of a CSV file.
IN_SI = re.compile(
    r"^\s+(elastic_modulus|density|body|joint)\b|^[a-z-]+: .* is not modelled by|As a file only|Accelerations in m/s², strains as 1"
)
#: Commands that answer in words, with `FILE` for the case.
COMMANDS = (
    ("show", "FILE"),
    ("simulate", "FILE", "--output", "motion.csv"),
    ("modes", "FILE"),
    ("run", "FILE", "--engine", "reference", "--engine", "mujoco"),
    ("sweep", "FILE", "--vary", "crank.prescribed_speed = 88 rpm; 90 rpm", "--measure", "peak.stress", "--measure", "peak.crank_torque",
     "--measure", "mean.crank_speed", "--measure", "peak.tip_acceleration", "--output", "sweep.csv"),
    ("resonance", "FILE", "--speed", "88 rpm .. 92 rpm", "--no-claims", "--output", "curve.svg"),
    ("compare", "FILE", "motion.csv", "--engine", "reference", "--output", "compared.svg"),
    ("calibrate", "FILE", "motion.csv", "--free", "follower.thickness"),
    ("advise", "FILE"),
    ("explain", "FILE"),
    ("plot", "FILE", "--engine", "reference", "--column", "crank_speed", "--column", "tip_deflection",
     "--output", "plot.svg"),
    ("report", "FILE", "--engine", "reference", "--output", "page"),
)  # fmt: skip
#: What a machine in mm and rpm must not be answered with: other speeds, bare pascals and metres, and any inches.
STRANGE = re.compile(r"rad/s|\bPa\b|\d m\b(?!/)|\[m\]|e\+0[4-9]|\bin/s|lbf|psi|\d in\b(?! motion)")
#: What one in inches must not be answered with.
METRIC = re.compile(r"rad/s|[MG]?Pa\b|\d(\.\d+)? ?m?m\b|\[m?m\]|\bm/s|\d N\b|\bN[ *]m|\bkg\b")


def machine(inches: bool) -> str:
    text = MACHINE
    for metric, inch in IN_INCHES.items() if inches else ():
        text = text.replace(f'"{metric}"', f'"{inch}"')
    return text


def read(path: Path) -> str:
    """What a person reads of a page or a picture: its text without styles, scripts, file names and headings of CSV files."""
    text = path.read_text("utf-8")
    if path.suffix == ".svg":
        return " ".join(re.findall(r"<!-- (.*?) -->", text))
    text = re.sub(r"<(style|script)\b.*?</\1>", " ", text, flags=re.DOTALL)
    text += " ".join(re.findall(r'"label": "[^"]*", "unit": "([^"]*)"', path.read_text("utf-8")))
    return unescape(re.sub(r"<[^>]*>", " ", text))


def answers(call: Call, file: str) -> Iterator[tuple[str, str]]:
    """Every command with all texts that it leaves to be read."""
    for command in COMMANDS:
        coarse = () if command[0] in ("show", "modes", "calibrate", "advise") else ("--accuracy", "0.02")
        found = call(*(file if part == "FILE" else part for part in command), *coarse)
        assert found.code in (0, 1), (command, found.errors)
        files = [Path(part) for part in command if part.endswith(".svg")] + [Path("page/index.html")] * (command[0] == "report")
        yield command[0], "\n".join([found.output, found.errors, *map(read, files)])


def in_inches(name: str) -> CaseResult:
    """A made-up result whose numbers are shown in inches."""
    result = reported_result(name)
    return dataclasses.replace(result, case=result.case.in_units("inch"))


def test_words_on_a_run_and_its_page_are_in_the_units_that_are_asked_for() -> None:
    result = in_inches("example")
    words = in_lines(parts_of(result))
    assert not METRIC.search(words), words
    assert "peak accel. in/s2" in words
    page = read_page(one_run(result)).text
    stress = loads_of_case(result).loads["reference"].stress
    for text in (f"{stress.largest.value / 6894.757293168:.0f} psi", "lbf in", "tip acc. in/s²", 'crank.length="3.543 in"'):
        assert text in plain(page), text
    wrong = [line for line in page.replace("\N{NO-BREAK SPACE}", " ").splitlines() if METRIC.search(line) and not IN_SI.search(line)]
    assert not wrong


def test_plots_and_tables_of_a_page_have_the_same_numbers_in_every_set() -> None:
    def files(units: str) -> dict[str, str]:
        result = in_inches("example")
        content = one_run(dataclasses.replace(result, case=result.case.in_units(units)))
        return {table.name: table.csv() for chapter in chapters_of(content) for table in chapter.tables}

    assert files("si") == files("inch")


@pytest.mark.verify
@pytest.mark.parametrize("inches", [False, True], ids=["mm", "inches"])
def test_every_command_answers_in_the_units_of_the_file(call: Call, inches: bool) -> None:
    Path("lever.toml").write_text(machine(inches))
    wrong = {}
    for command, text in answers(call, "lever.toml"):
        shown = [line for line in text.splitlines() if not IN_SI.search(line)]
        strange = METRIC if inches else STRANGE
        if lines := [line for line in shown if strange.search(line)]:
            wrong[command] = lines
    assert not wrong


@pytest.mark.verify
def test_files_and_documents_are_in_si_to_the_bit_whatever_is_shown(call: Call) -> None:
    Path("lever.toml").write_text(machine(inches=False))
    kept = {}
    for units in ("si", "mm", "inch"):
        run = json.loads(call("run", "lever.toml", "--engine", "reference", "--json", "--accuracy", "0.02", "--units", units).output)
        shown = json.loads(call("show", "lever.toml", "--json", "--units", units).output)
        call("simulate", "lever.toml", "--output", "motion.csv", "--accuracy", "0.02", "--units", units)
        call("report", "lever.toml", "--engine", "reference", "--output", "page", "--accuracy", "0.02", "--units", units)
        files = {path.name: path.read_bytes() for path in [Path("motion.csv"), *Path("page").glob("*.csv")]}
        del shown["derived"]["resonance"]["meaning"]  # a sentence
        kept[units] = (run, shown, {name: content for name, content in files.items() if name != "provenance.csv"})
    assert kept["si"] == kept["mm"] == kept["inch"]
    assert len(kept["si"][2]) > 5
