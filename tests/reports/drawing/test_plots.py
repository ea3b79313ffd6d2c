"""Every picture of the documents renders without a warning, is small, and says what it shows."""

import dataclasses
import warnings
from collections.abc import Iterator

import numpy as np
import pytest
from matplotlib.figure import Figure

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reports.drawing import cycle
from quickreturn.reports.drawing.style import picture
from tests.reports.plotted_results import made_up_result, with_table

TROUBLES = {
    "settled": made_up_result("thesis-24"),
    "failed": made_up_result("thesis-01", {"exudyn": "failed", "reference": "failed"}),
    "backwards": made_up_result("thesis-06", turning=-1),
    "rigid": made_up_result("rigid"),
}


def of_cycle(result: CaseResult) -> Figure:
    return cycle.draw([result], CHANNELS)


@pytest.fixture(autouse=True)
def _warnings_are_errors() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def _has_data(axes: object) -> bool:
    return any(len(getattr(axes, kind)) > 0 for kind in ("lines", "collections", "images", "patches"))


def _check(figure: Figure) -> None:
    picture(figure, ".png")
    assert all(_has_data(axes) for axes in figure.axes)
    everything = figure.get_tightbbox()  # in
    width, height = figure.get_size_inches()
    assert everything.x0 >= 0.0  # nothing is cut off
    assert everything.y0 >= 0.0
    assert everything.x1 <= width
    assert everything.y1 <= height


def _texts(figure: Figure) -> list[str]:
    of_legends = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    return of_legends + [text.get_text() for axes in figure.axes for text in axes.texts]


@pytest.mark.parametrize(
    "trouble", ["settled", "rigid", *(pytest.param(name, marks=pytest.mark.verify) for name in ("failed", "backwards"))]
)
def test_a_case_renders_whatever_became_of_its_runs(trouble: str) -> None:
    _check(of_cycle(TROUBLES[trouble]))


def test_every_axis_has_its_unit() -> None:
    figure = of_cycle(TROUBLES["settled"])
    assert all("(" in axes.get_ylabel() for axes in figure.axes)
    assert figure.axes[-1].get_xlabel().startswith("cycle")


def test_recorded_tables_are_drawn_over_the_engines_under_their_plain_names() -> None:
    result = with_table(TROUBLES["settled"], "$a_1$.csv", ("strain_2", "tip_deflection"))
    figure = cycle.draw([result])
    _check(figure)
    assert [axes.get_ylabel() for axes in figure.axes] == ["strain 2\n(10⁻⁶)", "tip deflection\n(mm)"]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["thesis", "reference", "exudyn", "mujoco", r"\$a_1\$.csv"]


def test_each_panel_has_its_column_of_every_engine() -> None:
    result = TROUBLES["settled"]
    for axes, channel, factor in zip(of_cycle(result).axes, CHANNELS, (1.0, 1e6, 1e6, 1e6), strict=False):
        (line,) = [line for line in axes.lines if line.get_zorder() == 2.0]  # the reference lies lowest
        np.testing.assert_allclose(np.asarray(line.get_ydata()), factor * result.runs["reference"].cycle[channel], rtol=1e-12)


def test_a_single_engine_has_pictures_of_its_own_but_no_comparison() -> None:
    result = TROUBLES["settled"]
    alone = dataclasses.replace(result, runs={"own": dataclasses.replace(result.runs["exudyn"], engine="own")}, checks=())
    _check(of_cycle(alone))
