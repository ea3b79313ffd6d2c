"""Three lines of Python: what `import quickreturn as qr` offers, on engines that cost nothing."""

import json
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import quickreturn as qr
from quickreturn.reference_model.arrays import Array
from tests.engines.fake_engine import FakeEngine
from tests.engines.fake_package import FAKE_ENGINE, install
from tests.quickreturn.scene_file import SCENE


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a case file, in which an engine is installed."""
    install(tmp_path / "packages", "fakes", {"package_fake": FAKE_ENGINE}, {"fake": "package_fake:FakeEngine"})
    monkeypatch.syspath_prepend(tmp_path / "packages")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SCENE)
    return tmp_path


def test_every_name_is_there_and_listed() -> None:
    for name in qr.__all__:
        assert getattr(qr, name) is not None
    assert set(qr.__all__) < set(dir(qr))
    assert qr.__version__[0].isdigit()
    with pytest.raises(AttributeError, match="the nearest one is simulate"):
        _ = qr.simulat
    assert not hasattr(qr, "_ipython_display_")


def test_importing_it_loads_nothing_else() -> None:
    code = "import sys; before = set(sys.modules); import quickreturn; print(*sorted(set(sys.modules) - before))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert [name for name in loaded if name.startswith("quickreturn")] == ["quickreturn"]
    assert not {name.partition(".")[0] for name in loaded} & {"numpy", "numba", "pandas", "scipy", "matplotlib", "pint"}


@pytest.mark.parametrize(
    ("code", "needless"),
    [
        (
            "qr.simulate('thesis-24', store=False, quiet=True)",
            {"numba", "pandas", "pint", "scipy.integrate", "scipy.interpolate", "scipy.linalg", "scipy.optimize", "scipy.sparse"},
        ),
        (
            'main(["simulate", "thesis-24", "--no-store"])',
            {"numba", "pandas", "pint", "scipy.linalg", "scipy.interpolate", "scipy.optimize"},
        ),
        ('main(["show", "thesis-24"])', {"numba", "pandas", "pint", "scipy.linalg", "scipy.interpolate", "scipy.optimize"}),
    ],
    ids=["simulate", "command simulate", "show"],
)
def test_what_is_not_needed_is_not_imported(code: str, needless: set[str]) -> None:
    begin = "import sys, quickreturn as qr; from quickreturn.command_line import main;"
    for _ in range(2):  # the first may compile
        run = subprocess.run(
            [sys.executable, "-c", f"{begin} {code}; print('imported', *sys.modules)"], capture_output=True, text=True, check=True
        )
        loaded = set(run.stdout.partition("imported ")[2].split())
        assert "quickreturn.engines.registry" in loaded
        if not loaded & needless:
            break
    assert not loaded & needless


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (lambda: qr.case("thesis-24", {"crank.length": 5}), "^overrides: crank.length: 5 is a bare number"),  # type: ignore[dict-item]
        (lambda: qr.case("thesis-24", "crank.length=5 in"), "^overrides: .*is not a dictionary"),  # type: ignore[arg-type]
        (lambda: qr.case("thesis-24", duration="0.5 s"), '^thesis-24: duration: "0.5 s" is not a positive time'),  # type: ignore[arg-type]
        (lambda: qr.case(qr.case("thesis-24"), {}), "a case already"),  # type: ignore[arg-type]
        (lambda: qr.simulate(None), "^None: this is no case"),  # type: ignore[arg-type]
        (lambda: qr.run([]), "^cases: none is given"),
        (lambda: qr.run([qr.case("example"), qr.case("example", {"crank.length": "99 mm"})]), "^example: .*a name of its own"),
        (lambda: qr.run(qr.case("shaper-cutting", {"crank.prescribed_speed": "0 rpm"}), "thesis", quiet=True), "the crank stands still"),
        (lambda: qr.simulate("example", FakeEngine), r"^FakeEngine: this is a class; give an engine, FakeEngine\(\)"),  # type: ignore[arg-type]
        (lambda: qr.simulate("example", settings="modes=5"), "^settings: 'modes=5' is no dictionary"),  # type: ignore[arg-type]
        (lambda: qr.run("example", accuracy="1e-3"), "^accuracy='1e-3': numbers from 0.0001 to 0.05"),  # type: ignore[arg-type]
        (lambda: qr.run("example", jobs=0), "^jobs=0: at least 1"),
        (lambda: qr.modes("example", "thesis", "90 deg"), "^crank_angle='90 deg': degrees"),  # type: ignore[arg-type]
        (lambda: qr.simulate("small.toml", "mujco"), "mujco.*perhaps mujoco"),
        (lambda: qr.run("small.toml", "fake", settings={"mujoco": {"links": 16}}), "mujoco does not run here"),
        (lambda: qr.simulate("small.toml", "fake").plot("tip_deflecton"), "tip_deflecton.*tip_deflection"),
    ],
)
def test_what_cannot_be_is_answered_with_a_sentence(place: Path, ask: Callable[[], object], told: str) -> None:
    with pytest.raises((qr.CaseError, qr.UnknownEngine, qr.UnknownColumn, qr.SettingError, ValueError), match=told):
        ask()


def test_paths_rows_of_the_library_and_tuples_are_taken_where_a_person_would_give_them(place: Path) -> None:
    gravity = ("0 m/s^2", "-9.81 m/s^2")
    assert qr.case(Path("small.toml"), {"mechanism.gravity": gravity}).mechanism.gravity == (0.0, -9.81)  # type: ignore[dict-item]
    assert qr.case(qr.list_cases("thesis")[23]) == qr.case("thesis-24")
    solution = qr.simulate(Path("small.toml"), FakeEngine(), settings={"engine.step": 0.05})  # as messages name it
    assert solution.settings["step"] == 0.05
    assert "step 0.05" in repr(solution)
    assert "fake" in repr(qr.engine("fake"))


def test_simulate_gives_a_table_with_units_and_estimates(place: Path) -> None:
    solution = qr.simulate("small.toml", "fake", accuracy=1e-2)
    assert len(solution.frame) == 101
    assert solution.frame.attrs["units"]["tip_acceleration"] == "m/s^2"
    assert (solution.frame.attrs["case"], solution.frame.attrs["engine"]) == ("small", "fake")
    assert np.array_equal(solution["tip_deflection"], solution.trajectory["tip_deflection"])
    assert solution.reached
    assert solution.estimates["tip_deflection"] < 1e-2
    assert np.isnan(solution.estimates["slider_force"])
    assert solution.settings == {"step": 0.025, "behaviour": "good"}
    assert len(repr(solution).splitlines()) < 20
    assert "101 rows from 0 to" in repr(solution.trajectory)


def test_a_plot_is_a_figure_that_a_notebook_shows(place: Path) -> None:
    figure = qr.simulate("small.toml", "fake").plot("tip_deflection", "strain_1")
    assert len(figure.axes) == 2
    assert figure._repr_png_().startswith(b"\x89PNG")
    (line,) = figure.axes[0].lines
    assert len(line.get_xdata()) == 101


def test_natural_frequencies_are_a_table(place: Path) -> None:
    table = qr.modes("small.toml", "fake", [0.0, 90.0], count=2)
    assert table.to_numpy() == pytest.approx(np.array([[10.0, 20.0], [10.0 + np.pi / 2, 20.0 + np.pi / 2]]))
    assert list(table.index) == [0.0, 90.0]


def test_run_takes_names_and_gives_frames(place: Path) -> None:
    from tests.engines.faulty_engines import install_faulty_engines

    install_faulty_engines(place)
    found = qr.run(qr.case("small.toml"), ["sound", "also-sound"])
    assert found.passed is True
    assert set(found.frame["engine"]) == {"sound", "also-sound"}
    assert found["small", "sound"].approach.settled
    assert found._ipython_key_completions_() == [("small", "sound"), ("small", "also-sound")]
    cycle = found.cycle("small", "also-sound")
    assert cycle.attrs["units"]["strain_1"] == "1"
    assert "within what is claimed" in repr(found)
    for shown, word in ((found["small", "sound"], "settled"), (found.results[0], "also-sound"), (found.results[0].case, "crank.length")):
        assert word in repr(shown)
        assert len(repr(shown)) < 2000
    with pytest.raises(LookupError, match="also-sound"):
        _ = found["small", "also-sond"]
    assert len(found.plot().axes) == 1
    with pytest.raises(qr.UnknownColumn, match="tip_x"):
        found.plot("tip_z")


def test_a_dataset_says_what_everything_is_and_netcdf_keeps_it(place: Path) -> None:
    solution = qr.simulate("small.toml", "fake", accuracy=1e-2)
    dataset = solution.to_xarray()
    assert list(dataset.coords) == ["time"]
    assert set(dataset.variables) == set(solution.frame.columns)
    assert {name: variable.attrs["units"] for name, variable in dataset.variables.items()} == solution.frame.attrs["units"]
    assert dataset["tip_deflection"].attrs["long_name"] == "tip deflection"
    assert dataset["tip_deflection"].attrs["error_estimate"] == dataset.attrs["error_estimate"] == solution.result.error_estimate
    assert "error_estimate" not in dataset["slider_force"].attrs, "unknown"
    about = {
        "case": "small",
        "title": solution.case.title,
        "engine": "fake",
        "accuracy": 1e-2,
        "reached": "yes",
        "error_estimate_of": "total",
    }
    assert about.items() <= dataset.attrs.items()
    assert json.loads(dataset.attrs["settings"]) == solution.settings
    everywhere = [dataset.attrs, *(variable.attrs for variable in dataset.variables.values())]
    assert {type(value) for attributes in everywhere for value in attributes.values()} == {str, float}
    dataset.to_netcdf(place / "run.nc")
    with xr.open_dataset(place / "run.nc") as kept:
        assert kept.identical(dataset)
    assert "remark" in qr.simulate("small.toml", "fake", estimate=False).to_xarray().attrs


class Compiling(FakeEngine):
    """Says that it compiles, and then works or waits."""

    compiles = True

    def __init__(self, work: Callable[[], object]) -> None:
        self.work = work

    def prepare(self, *arguments: Any) -> qr.Simulation:
        self.work()
        return super().prepare(*arguments)

    def natural_frequencies(self, *arguments: Any) -> Array:
        self.work()
        return super().natural_frequencies(*arguments)


def busy() -> None:
    """Takes 0.1 s of the processor, twice the time after which a message comes."""
    began = time.process_time()
    while time.process_time() - began < 0.1:
        pass


@pytest.mark.parametrize("call", [qr.simulate, qr.modes], ids=["simulate", "modes"])
@pytest.mark.verify
def test_the_person_who_waits_for_a_compiler_is_told_once(
    call: Callable[..., object], place: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    display = "quickreturn.cases.running.display"
    monkeypatch.setattr(f"{display}.COMPILING_AFTER", 0.05)
    monkeypatch.setattr(f"{display}.LOOK_INTERVAL", 0.01)
    for engine, quiet, messages in (
        (Compiling(busy), False, ["compiling"]),
        (Compiling(busy), True, []),
        (FakeEngine(), False, []),
        (Compiling(lambda: time.sleep(0.1)), False, []),  # long by the clock alone, as on a busy machine
    ):
        call("small.toml", engine, quiet=quiet)
        output, errors = capfd.readouterr()
        assert (output, [word for word in ("compiling", "waits for") if word in errors]) == ("", messages)
    monkeypatch.setattr(f"{display}.waits_for", lambda: 4711)
    call("small.toml", Compiling(lambda: time.sleep(0.1)))
    assert "waits for process 4711" in capfd.readouterr().err


def test_without_an_estimate_the_table_is_the_same_and_nothing_is_claimed(place: Path) -> None:
    quick = qr.simulate("small.toml", "fake", settings={"step": 0.05}, estimate=False)
    assert quick.frame.equals(qr.simulate("small.toml", "fake", settings={"step": 0.05}).frame)
    assert quick.estimates.isna().all()
    assert "the error is not estimated, as asked" in repr(quick)
    assert "error estimate" not in repr(quick)
    with pytest.raises(ValueError, match=r"^accuracy=0\.01 without an estimate"):
        qr.simulate("small.toml", "fake", accuracy=1e-2, estimate=False)


def test_code_that_is_not_kept_is_said(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quickreturn.reference_model.native.cache_folder.warning_if_not_kept", lambda: "compiled code cannot be kept here")
    with pytest.warns(UserWarning, match="cannot be kept"):
        qr.simulate("small.toml", "fake")
    monkeypatch.undo()
    monkeypatch.chdir(place)
    monkeypatch.syspath_prepend(place / "packages")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        qr.simulate("small.toml", "fake")
