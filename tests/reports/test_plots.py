"""Every picture of the report: it renders without a warning whatever became of the runs, is small, and says what it shows."""

import dataclasses
import io
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from PIL import Image

from cases.experiment import MeasuredCurve, axis_labels
from cases.measures import time_scale
from cases.runs.comparison import CaseResult
from reference_model.mechanism import PrescribedSpeed
from reports.plots import convergence, cycle, forces, heat_map, mechanism, overview, sensitivity, spectrogram, work_precision
from reports.plots.picture import Picture, picture
from tests.reports.made_up_benchmark import made_up_benchmark
from tests.reports.plotted_results import made_up_result, with_mechanism

#: Bytes. Four pictures for each of 24 runs shall leave the page below 5 MB with its base64: 40 kB each on average. The made-up curves
#: are busier than real ones, which take 35 kB at most; the heat map, of which there is one, may have more.
LARGEST, LARGEST_HEAT_MAP = 45_000, 65_000

TROUBLES = {
    "settled": made_up_result("thesis-24"),
    "not settled": made_up_result("thesis-10", {"reference": "not settled", "mujoco": "not settled"}),
    "failed": made_up_result("thesis-01", {"exudyn": "failed", "reference": "failed"}),
    "backwards": made_up_result("thesis-06", turning=-1),
    "rigid": made_up_result("rigid"),
}
NOTHING = made_up_result("thesis-24", dict.fromkeys(("thesis", "reference", "exudyn", "mujoco"), "failed"))
RUNS = [made_up_result(f"thesis-{run:02d}", {"mujoco": "failed"} if run == 5 else None, seed=10 * run) for run in range(1, 25)]
CURVE = MeasuredCurve(
    run=24,
    channel="strain_2",
    crank_angle=np.pi + 2.0 * np.pi * np.linspace(0.0, 0.995, 200),
    time=np.linspace(0.0, 0.37, 200),
    values=2e-4 * np.sin(np.linspace(0.0, 40.0, 200)),
    crank_speed=16.6,
    origin="synthetic",
    source="a sine",
    declared={"unit": "strain"},
    path=Path("sine.csv"),
)

OF_ONE_CASE: dict[str, Callable[[CaseResult], Figure | None]] = {
    "cycle": lambda result: cycle.draw_cycle(result, _labels(result), ()),
    "mechanism": mechanism.draw_mechanism,
    "forces": forces.draw_forces,
    "spectrogram": lambda result: spectrogram.draw_spectrogram(result, time_scale(result.case.mechanism)),
}
OF_ALL: dict[str, Callable[[], Figure | None]] = {
    "overview": lambda: overview.draw_overview(RUNS),
    "heat map": lambda: heat_map.draw_heat_map(RUNS),
    "convergence": lambda: convergence.draw_convergence(_convergence_table()),
    "work precision": lambda: work_precision.draw(made_up_benchmark(), "solve_seconds"),
    "degrees of freedom": lambda: work_precision.draw(made_up_benchmark(), "degrees_of_freedom"),
    "sensitivity": lambda: sensitivity.draw_sensitivity(_sensitivity_table()),
}


def _labels(result: CaseResult) -> tuple:  # type: ignore[type-arg]
    name = result.case.name
    return axis_labels(int(name[-2:])) if name.startswith("thesis-") else ()


def _convergence_table() -> pd.DataFrame:
    pairs = [(shapes, tolerance) for shapes in (2, 4, 8, 16) for tolerance in (1e-5, 1e-9)]
    rows = [
        {"modes": shapes, "tolerance": tolerance, **dict.fromkeys(convergence.COLUMNS, shapes**-2.0), "is_reference": False}
        for shapes, tolerance in pairs
    ]
    rows[-1] |= dict.fromkeys(convergence.COLUMNS, 0.0) | {"is_reference": True}
    return pd.DataFrame(rows)


def _sensitivity_table() -> pd.DataFrame:
    rows = []
    for run in ("thesis-10", "thesis-24"):
        for change in ("EI + 5 %", "tip centre of mass 0.5 in beyond the end"):
            for half in ("pre", "post"):
                rows.append((run, change, half, sensitivity.FREQUENCY, 0.02))
                rows += [(run, change, half, sensitivity.AMPLITUDE, value) for value in (-0.1, 0.2, np.nan)]
    return pd.DataFrame(rows, columns=["run", "change", "half", "quantity", "relative_change"])


@pytest.fixture(autouse=True)
def _warnings_are_errors() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def _has_data(axes: object) -> bool:
    return any(len(getattr(axes, kind)) > 0 for kind in ("lines", "collections", "images", "patches"))


def _check(figure: Figure | None, limit: int = LARGEST) -> Picture:
    assert figure is not None
    rendered = picture(figure, "a figure")
    assert len(rendered.data) <= limit
    image = Image.open(io.BytesIO(rendered.data))
    assert image.size == (2 * rendered.width, 2 * rendered.height)
    assert rendered.width == 480
    assert all(_has_data(axes) for axes in figure.axes)
    everything = figure.get_tightbbox()  # in
    width, height = figure.get_size_inches()
    assert everything.x0 >= 0.0  # nothing is cut off
    assert everything.y0 >= 0.0
    assert everything.x1 <= width
    assert everything.y1 <= height
    return rendered


def _texts(figure: Figure) -> list[str]:
    of_legends = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    return of_legends + [text.get_text() for axes in figure.axes for text in axes.texts]


@pytest.mark.parametrize("trouble", TROUBLES)
@pytest.mark.parametrize("kind", OF_ONE_CASE)
def test_a_case_renders_whatever_became_of_its_runs(kind: str, trouble: str) -> None:
    _check(OF_ONE_CASE[kind](TROUBLES[trouble]))


@pytest.mark.parametrize("kind", OF_ONE_CASE)
def test_nothing_is_drawn_where_nothing_ran(kind: str) -> None:
    assert OF_ONE_CASE[kind](NOTHING) is None


@pytest.mark.parametrize("kind", OF_ALL)
def test_pictures_of_all_runs_render(kind: str) -> None:
    _check(OF_ALL[kind](), LARGEST_HEAT_MAP if kind == "heat map" else LARGEST)


@pytest.mark.parametrize("kind", ["cycle", "forces"])
def test_every_axis_has_its_unit(kind: str) -> None:
    figure = OF_ONE_CASE[kind](TROUBLES["settled"])
    assert figure is not None
    assert all("(" in axes.get_ylabel() for axes in figure.axes)
    assert figure.axes[-1].get_xlabel().startswith("cycle")


@pytest.mark.parametrize("kind", ["overview", "convergence", "sensitivity"])
def test_every_abscissa_is_labelled(kind: str) -> None:
    figure = OF_ALL[kind]()
    assert figure is not None
    assert all(axes.get_xlabel() for axes in figure.axes)


@pytest.mark.parametrize("kind", ["cycle", "mechanism", "forces"])
def test_engines_that_failed_are_named(kind: str) -> None:
    figure = OF_ONE_CASE[kind](TROUBLES["failed"])
    assert figure is not None
    assert any("exudyn: failed" in text for text in _texts(figure))


def test_an_engine_that_did_not_settle_is_drawn_and_says_so() -> None:
    figure = OF_ONE_CASE["cycle"](TROUBLES["not settled"])
    assert figure is not None
    assert "mujoco (not settled)" in _texts(figure)


def test_failures_are_named_in_the_overview() -> None:
    figure = OF_ALL["overview"]()
    assert figure is not None
    assert "mujoco: failed" in _texts(figure)


def test_a_synthetic_curve_is_marked_as_such() -> None:
    figure = cycle.draw_cycle(TROUBLES["settled"], (), [CURVE])
    _check(figure)
    assert figure is not None
    assert any("synthetic" in text for text in _texts(figure))
    shown = cycle.cycle_figure(TROUBLES["settled"], (), [CURVE])
    assert shown is not None
    assert "strain_2 (synthetic)" in shown.alt


def test_strain_is_drawn_in_percent_and_acceleration_in_si() -> None:
    result = TROUBLES["settled"]
    figure = cycle.draw_cycle(result, _labels(result), ())
    assert figure is not None
    reference = result.runs["reference"]
    for axes, channel, factor in zip(
        figure.axes, ("tip_acceleration", "strain_1", "strain_2", "strain_3"), (1.0, 100.0, 100.0, 100.0), strict=False
    ):
        (line,) = [line for line in axes.lines if line.get_zorder() == 2.0]  # the reference lies lowest
        np.testing.assert_array_equal(np.asarray(line.get_ydata()), factor * reference.cycle[channel])


def test_the_printed_range_is_shaded_in_si() -> None:
    """Figure A.24's labels reach from -5000 to 5000 in/s²: ±127 m/s²."""
    result = TROUBLES["settled"]
    figure = cycle.draw_cycle(result, _labels(result), ())
    assert figure is not None
    (band,) = figure.axes[0].patches
    corners = band.get_extents().transformed(figure.axes[0].transData.inverted())
    np.testing.assert_allclose([corners.y0, corners.y1], [-127.0, 127.0], rtol=1e-9)  # 0.0254 is exact, products round


def test_a_backward_crank_is_labelled_backwards() -> None:
    figure = OF_ONE_CASE["forces"](TROUBLES["backwards"])
    assert figure is not None
    above = figure.axes[0].child_axes[0]
    assert [label.get_text() for label in above.get_xticklabels()] == ["180°", "90°", "0°", "−90°", "−180°"]


def test_a_prescribed_speed_shows_the_torque_that_it_takes() -> None:
    settled = TROUBLES["settled"]
    crank = dataclasses.replace(settled.case.mechanism.crank, drive=PrescribedSpeed(speed=16.6))
    result = with_mechanism(settled, crank=crank)
    figure = OF_ONE_CASE["forces"](result)
    _check(figure)
    assert figure is not None
    assert figure.axes[1].get_ylabel() == "drive torque (N m)"
    np.testing.assert_array_equal(np.asarray(figure.axes[1].lines[0].get_ydata()), result.runs["thesis"].cycle["crank_torque"])


def test_the_factor_of_the_deflection_is_stated() -> None:
    figure = mechanism.draw_mechanism(TROUBLES["settled"])
    assert figure is not None
    (factor,) = [float(text.rpartition("× ")[2]) for text in _texts(figure) if "×" in text]
    assert factor == 5.0  # 13 mm (10 mm and what the loop adds) of 635 mm, shown as at most 0.15 of the length, in steps 1, 2, 5, 10


@pytest.mark.parametrize("trouble", ["settled", "backwards", "rigid"])
def test_the_loop_is_drawn_closed(trouble: str) -> None:
    result = TROUBLES[trouble]
    figure = mechanism.draw_mechanism(result)
    assert figure is not None
    LA = result.case.mechanism.crank.length
    for axes in figure.axes:
        follower = np.column_stack([np.asarray(values) for values in axes.lines[2].get_data()])
        slider = np.array([np.asarray(values)[0] for values in axes.lines[6].get_data()])
        assert np.hypot(*slider) == pytest.approx(LA, rel=1e-12)
        # drawn in pieces of 8 mm, which cut a curve of 0.5 m radius by 16 um; small slopes leave as much again
        assert _distance(slider, follower) < 1e-4


def _distance(point: np.ndarray, line: np.ndarray) -> float:
    """Least distance of a point from a line of straight pieces, m."""
    pieces, away = np.diff(line, axis=0), point - line[:-1]
    share = np.clip(np.sum(away * pieces, axis=1) / np.sum(pieces**2, axis=1), 0.0, 1.0)
    return float(np.min(np.hypot(*(away - share[:, None] * pieces).T)))


def test_a_rigid_follower_has_no_strain_panel() -> None:
    figure = OF_ONE_CASE["cycle"](TROUBLES["rigid"])
    assert figure is not None
    assert [axes.get_ylabel() for axes in figure.axes] == ["tip acceleration (m/s²)"]


def test_what_cannot_be_compared_is_hatched() -> None:
    figure = OF_ALL["heat map"]()
    assert figure is not None
    extremes = figure.axes[2]
    hatched = [patch for patch in extremes.patches if patch.get_hatch()]
    assert len(hatched) == 3  # mujoco failed in one run: its pairs with the three others
    assert len(extremes.texts) == 6 * 24 - 3


def test_a_picture_goes_into_a_page_as_it_is() -> None:
    shown = Picture(b"abc", "image/webp", 1, 1, "")
    assert shown.uri == "data:image/webp;base64,YWJj"


def test_pictures_with_nothing_to_compare_are_left_out() -> None:
    assert overview.overview_figure([NOTHING]) is None
    assert convergence.convergence_figure(pd.DataFrame()) is None
    nothing = dataclasses.replace(made_up_benchmark(), points=made_up_benchmark().points[-1:])
    assert work_precision.work_precision_figure(nothing) is None
    assert work_precision.work_freedom_figure(nothing) is None
    assert sensitivity.sensitivity_figure(pd.DataFrame()) is None


def test_all_pictures_describe_themselves() -> None:
    result = TROUBLES["settled"]
    made = [
        cycle.cycle_figure(result, _labels(result)),
        mechanism.mechanism_figure(result),
        forces.force_figure(result),
        spectrogram.spectrogram_figure(result, time_scale(result.case.mechanism)),
        overview.overview_figure(RUNS[:2]),
        heat_map.heat_map_figure(RUNS[:2]),
        convergence.convergence_figure(_convergence_table()),
        work_precision.work_precision_figure(made_up_benchmark()),
        work_precision.work_freedom_figure(made_up_benchmark()),
        sensitivity.sensitivity_figure(_sensitivity_table()),
    ]
    texts = [shown.alt for shown in made if shown is not None]
    assert len(set(texts)) == len(made)
    assert all("thesis-24" in text for text in texts[:4])


def test_a_single_engine_has_pictures_of_its_own_but_no_comparison() -> None:
    result = TROUBLES["settled"]
    alone = dataclasses.replace(result, runs={"own": dataclasses.replace(result.runs["exudyn"])}, checks=())
    for draw in OF_ONE_CASE.values():
        _check(draw(alone))
    assert overview.overview_figure([alone]) is None
    assert heat_map.heat_map_figure([alone]) is None


def test_methods_that_completed_nothing_have_no_mark() -> None:
    figure = OF_ALL["work precision"]()
    assert figure is not None
    assert "nodal-load" not in _texts(figure)
    assert {"reference", "multiplier, elements"} <= set(_texts(figure))


def test_the_front_lies_below_the_points() -> None:
    figure = OF_ALL["work precision"]()
    assert figure is not None
    lowest = min(figure.axes[0].lines, key=lambda line: line.get_zorder())
    seconds, errors = np.asarray(lowest.get_xdata()), np.asarray(lowest.get_ydata())
    assert np.all(np.diff(seconds) > 0.0)
    assert np.all(np.diff(errors) < 0.0)
