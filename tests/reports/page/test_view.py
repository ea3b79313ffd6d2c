"""What the page is told of the slider's joint and of the tool's force, from which `templates/script/stage.js` draws both."""

import math
from typing import Any

import pytest

from quickreturn.reference_model.slider import Slider
from quickreturn.reports.page.view import _scene
from tests.engines.scenes import run_24

DRAWN: dict[str, tuple[Slider, Any]] = {
    "rigid": (Slider(), None),
    "linear": (Slider(joint_stiffness=1e4), {"free": False, "soft": [False, False]}),
    "plus soft": (Slider(joint_stiffness_plus=1e4), {"free": False, "soft": [True, False]}),
    "minus softer": (Slider(joint_stiffness_plus=4e4, joint_stiffness_minus=1e4), {"free": False, "soft": [False, True]}),
    "clearance": (Slider(clearance=2e-4), {"free": True, "soft": [False, False]}),
}


@pytest.mark.parametrize("joint", DRAWN)
def test_rollers_are_drawn_apart_with_clearance_and_dashed_where_softer(joint: str) -> None:
    slider, drawn = DRAWN[joint]
    assert _scene(run_24(slider=slider))["rollers"] == drawn


def test_the_force_points_its_way_where_it_acts() -> None:
    """Down from 90 to 270 deg; or against the arm's end, with which it turns."""
    down = _scene(run_24(tip={"force": (0.0, -5.0), "force_from": 0.5 * math.pi, "force_to": 1.5 * math.pi}))["force"]
    assert not down["follows"]
    ways = down["ways"]
    acting = [at * 360 // len(ways) for at, way in enumerate(ways) if way is not None]
    assert (acting[0], acting[-1]) == (95, 265)
    assert {way for way in ways if way is not None} == {-1.571}
    assert _scene(run_24(tip={"force_following": (-5.0, 0.0)}))["force"] == {"follows": True, "ways": [3.142] * len(ways)}
    assert _scene(run_24())["force"] is None
