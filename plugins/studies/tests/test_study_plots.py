"""Pictures of studies: what is drawn is what was computed, in the units that were given, and what did not settle is marked."""

import math

import numpy as np
import pytest
from matplotlib.patches import PathPatch

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.stability import UNSTABLE
from quickreturn.plugins.studies.drawing.study import ENDINGS, draw
from quickreturn.plugins.studies.sweep.grid import Grid, axis
from quickreturn.plugins.studies.sweep.rows import LEFT, MeasureRequest
from quickreturn.plugins.studies.sweep.study import Study
from quickreturn.plugins.studies.sweep.sweeping import dataset_of, summary

DOUBLING = UNSTABLE.format("period doubling")
SPEEDS = "crank.prescribed_speed = 60 rpm .. 120 rpm : 13"


def made_up(*axes: str, measures: tuple[str, ...] = ("peak.tip_acceleration",)) -> Study:
    """Values from 1 to 1000 over the grid; the last but one point is unstable, and at the last the slider left."""
    grid = Grid(load_case("thesis-24"), tuple(axis(text) for text in axes))
    shape = grid.shape
    values = np.geomspace(1.0, 1000.0, math.prod(shape)).reshape(shape)
    statuses = np.full(shape, Ending.SETTLED, dtype=object)
    statuses.flat[-2:] = [DOUBLING, LEFT]
    values.flat[-1] = math.nan
    measured = np.repeat(values[..., None], len(measures), axis=-1)
    return Study(
        grid,
        MeasureRequest(measures=measures),
        measured,
        np.full_like(measured, math.nan),
        statuses,
        np.full(shape, "", dtype=object),
    )


def test_one_key_is_a_line_in_the_unit_given() -> None:
    found = made_up(SPEEDS)
    (panel,) = draw(found).axes
    line = panel.lines[0]
    np.testing.assert_allclose(line.get_xdata(), np.linspace(60.0, 120.0, 13))
    np.testing.assert_allclose(line.get_ydata(), found.values[:, 0])
    assert panel.get_xlabel() == "crank speed [rpm]"
    assert panel.get_ylabel() == "largest magnitude of tip\nacceleration [m/s²]"
    assert panel.get_yscale() == "log"
    marks = {each.get_marker(): float(each.get_xdata()[0]) for each in panel.lines[1:] if len(each.get_xdata())}
    assert marks == {ENDINGS[DOUBLING][1]: pytest.approx(115.0), ENDINGS[LEFT][1]: pytest.approx(120.0)}


def test_people_see_megapascals_and_the_unit_given_and_datasets_are_in_si() -> None:
    found = made_up(SPEEDS, measures=("peak.stress",))
    (panel,) = draw(found).axes
    np.testing.assert_allclose(panel.lines[0].get_ydata(), 1e-6 * found.values[:, 0])
    assert panel.get_ylabel() == "largest stress along the arm, by\nbending and the normal force [MPa]"
    dataset = dataset_of(found)
    assert summary(dataset, found.grid.case.units)[1] == (
        "peak.stress [MPa]: least 1e-06 at crank.prescribed_speed = 60 rpm, greatest 0.000562341 at crank.prescribed_speed = 115 rpm"
    )
    assert dataset["peak.stress"].attrs["units"] == "Pa"
    assert dataset["crank.prescribed_speed"].attrs == {"units": "rad/s", "given_in": "rpm"}


@pytest.mark.parametrize(("second", "count"), [("tip.mass = 0 g; 25 g; 50 g", 3), ("engine = reference; mujoco", 2)])
def test_few_values_of_a_second_key_are_lines_with_their_names(second: str, count: int) -> None:
    figure = draw(made_up(SPEEDS, second))
    assert len([each for each in figure.axes[0].lines if len(each.get_xdata()) == 13]) == count
    told = [text.get_text() for text in figure.legends[0].get_texts()]
    assert told[:count] == [each.strip() for each in second.partition("=")[2].split(";")]
    assert told[count:] == [DOUBLING, LEFT]


@pytest.mark.parametrize("order", [1, -1])
def test_two_keys_are_a_map_with_the_longer_one_across(order: int) -> None:
    found = made_up(*(SPEEDS, "tip.mass = 0 g .. 60 g : 7")[::order])
    panel = draw(found).axes[0]
    (mesh,) = [each for each in panel.collections if each.get_array() is not None]
    values = found.values[..., 0]
    np.testing.assert_allclose(np.ma.filled(mesh.get_array(), math.nan).ravel(), (values.T if order == 1 else values).ravel())
    assert (panel.get_xlim(), panel.get_ylim()) == (pytest.approx((57.5, 122.5)), pytest.approx((-5.0, 65.0)))
    patches = {each.get_hatch(): each for each in panel.patches if isinstance(each, PathPatch)}
    assert set(patches) == {ENDINGS[DOUBLING][0], ENDINGS[LEFT][0]}
    corner = patches[ENDINGS[LEFT][0]].get_path().get_extents()
    assert corner.bounds == pytest.approx((117.5, 55.0, 5.0, 10.0))
    assert patches[ENDINGS[DOUBLING][0]].get_facecolor()[3] == 0.0  # its value is seen
    levels = mesh.norm.boundaries
    assert levels[0] <= 1.0
    assert levels[-1] >= np.nanmax(values)
    assert set(levels) <= {m * 10.0**p for m in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0) for p in range(4)}
