"""What the page is told of the slider's joint, from which `templates/script/stage.js` draws its rollers."""

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
