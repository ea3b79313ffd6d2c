"""Every command and function that takes an engine takes the file beside an FMU, or says why not."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import quickreturn as qr
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.motion.orbit import begins_in_orbit
from quickreturn.command_line import main
from quickreturn.engines.registry import UnknownEngine, engine
from quickreturn.plugins.fmu.tests.build import Make
from quickreturn.plugins.studies.uncertainty.study import study_of

STUDY = """
case = "case.toml"
engine = "my.toml"
measures = ["peak.slider_force"]
samples = 8
[uncertain]
"crank.length" = "uniform 100 mm .. 110 mm"
"""
HANGS = ("mode = 0", "mode = 1")


@pytest.mark.parametrize("arguments", [("resonance", "case.toml"), ("calibrate", "case.toml", "my.csv"), ("advise", "case.toml")])
def test_what_has_no_place_for_an_fmu_says_so(make_plain: Make, capfd: pytest.CaptureFixture[str], arguments: tuple[str, ...]) -> None:
    command, *rest = arguments
    assert main([command, *rest, "--engine", make_plain()]) == 2
    assert capfd.readouterr().err.splitlines()[-1].startswith("quickreturn: No such option: --engine")


def test_python_takes_the_path_of_the_file_from_any_folder(make_plain: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_plain()
    here = qr.simulate("case.toml", engine="my.toml", quiet=True)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    for path in ("../my.toml", Path("../my.toml"), tmp_path / "my.toml"):
        there = qr.simulate("../case.toml", engine=path, quiet=True)
        assert there.version == here.version == qr.engine(path).version()
        assert np.array_equal(there.trajectory["tip_x"], here.trajectory["tip_x"])
    with pytest.raises(CaseError, match="there is no such file; give the path of a file that declares an FMU"):
        qr.simulate("../case.toml", engine=Path("my.toml"))
    with pytest.raises(UnknownEngine, match="no engine; give a name"):
        qr.simulate("../case.toml", engine=5)  # type: ignore[arg-type]


def test_the_store_notices_that_the_fmu_or_its_file_changed(make_plain: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QUICKRETURN_STORE", "store")
    assert not qr.simulate("case.toml", engine=make_plain(), quiet=True).stored
    assert qr.simulate("case.toml", engine="my.toml", quiet=True).stored
    assert not qr.simulate("case.toml", engine=make_plain(('"eps"', '"-eps"')), quiet=True).stored
    Path("plain.fmu").write_bytes(Path("plain.fmu").read_bytes() + b"\0")
    assert not qr.simulate("case.toml", engine="my.toml", quiet=True).stored


def test_a_study_names_its_engine_from_its_folder(make_plain: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    make_plain()
    Path("study.toml").write_text(STUDY)
    assert study_of("study.toml")["engine"] == "my.toml"
    Path("deeper").mkdir()
    monkeypatch.chdir("deeper")
    assert study_of("../study.toml")["engine"] == "../my.toml"


def test_an_fmu_begins_in_no_periodic_state(make_plain: Make) -> None:
    assert not begins_in_orbit(engine(make_plain()))


def test_files_of_engines_have_the_name_without_its_folder(make_plain: Make, capfd: pytest.CaptureFixture[str]) -> None:
    make_plain()
    Path("other").mkdir()
    Path("other/my.toml").write_text(Path("my.toml").read_text().replace("plain.fmu", "../plain.fmu"))
    both = ["--engine", "my.toml", "--engine", "other/my.toml"]
    assert main(["simulate", "case.toml", *both, "--output", "{engine}.csv"]) == 2
    assert "two engines are called my.toml; simulate one after the other" in capfd.readouterr().err


@pytest.mark.verify
def test_commands_take_an_fmu_from_another_folder(
    make_plain: Make, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The FMU's follower seems to bend by 1e-3 of its length times the sine of the crank's angle: the steady state is exact."""
    make_plain(("[parameters]", '[resolution]\nsteps = ["1 ms", "0.5 ms"]\n[parameters]'))
    Path("study.toml").write_text(STUDY)
    Path("elsewhere").mkdir()
    monkeypatch.chdir("elsewhere")

    def told(*arguments: str) -> Any:
        capfd.readouterr()
        assert main([*arguments, "--json"]) == 0
        return json.loads(capfd.readouterr().out)

    case, chosen = "../case.toml", ("--engine", "../my.toml")
    assert main(["simulate", case, *chosen, "--engine", "reference", "--duration", "1.2", "--output", "{engine}.csv"]) == 0
    assert {path.name for path in Path().glob("*.csv")} == {"my.toml.csv", "reference.csv"}
    [run] = told("run", case, *chosen)["cases"][0]["engines"]
    assert (run["engine"], run["status"]) == ("../my.toml", "settled")
    peak = ("--measure", "peak.tip_deflection")
    assert main(["sweep", case, *chosen, "--vary", "follower.length = 0.6 m; 0.7 m", *peak, "--output", "sweep.csv"]) == 0
    rows = np.genfromtxt("sweep.csv", delimiter=",", skip_header=1, usecols=(0, 1))
    assert rows[:, 1] == pytest.approx(1e-3 * rows[:, 0], rel=1e-4)  # rows of 1 ms are 0.7 degrees apart
    scattered = told("uncertainty", "../study.toml")
    assert scattered["engine"] == "../my.toml"
    [table] = told("benchmark", case, *chosen, "--runs", "6")["benchmarks"]
    given = [point for point in table["points"] if point["level"] is None]
    assert len({point["settings"]["step"] for point in given}) == len(given) > 1
    assert told("compare", case, "my.toml.csv", *chosen)
    assert told("explain", case, *chosen)
    assert not qr.conform(Path("../my.toml"), groups=("frequencies",), quiet=True).failed
    assert main(["modes", case, *chosen, "--crank-angle", "30"]) == 2
    assert "natural frequencies cannot be asked of engine ../my.toml: an FMU for co-simulation" in capfd.readouterr().err
    assert main(["plot", case, *chosen, "--output", "a.png"]) == 0
    for picture in ("a.webp", "a.html"):
        assert main(["animate", case, *chosen, "--output", picture]) == 2
        assert "does not tell the shape of the follower, so it cannot be drawn; use an engine with" in capfd.readouterr().err


@pytest.mark.verify
def test_an_endless_step_is_stopped_at_the_limit_and_takes_nothing_with_it(make_plain: Make, capfd: pytest.CaptureFixture[str]) -> None:
    Path(make_plain()).rename("sound.toml")
    engines = ("--engine", make_plain(HANGS), "--engine", "sound.toml")
    assert main(["simulate", "case.toml", *engines, "--time-limit", "3", "--output", "{engine}.csv"]) == 3
    [told] = [line for line in capfd.readouterr().err.splitlines() if line.startswith("quickreturn:")]
    assert told.startswith("quickreturn: mild: engine my.toml: stopped at the time limit of 3 s; see the limits of time and memory")
    assert [path.name for path in Path().glob("*.csv")] == ["sound.toml.csv"]
