"""What a scene lacks is the limit of having little of it."""

from typing import Any

import numpy as np
import pytest

from reference_model.mechanism import Slider, Tip
from reference_model.model import BeamModel
from reference_model.rigid import rigid_motion
from tests.engines.scenes import run_24
from tests.reference_model.beam_runs import Array, run
from tests.reference_model.thesis_runs import error


def shown(**changes: Any) -> dict[str, Array]:
    return run(BeamModel.following(run_24(**changes), 3), 0.3, 150, 1e-10)[1]


@pytest.mark.parametrize(
    ("little", "less", "none"),
    [
        ({"slider": Slider(inertia=1e-7)}, {"slider": Slider(inertia=1e-8)}, {}),
        ({"slider": Slider(mass=1e-3)}, {"slider": Slider(mass=1e-4)}, {}),
        ({"tip": Tip(mass=1e-4, inertia=1e-8)}, {"tip": Tip(mass=1e-5, inertia=1e-9)}, {"tip": None}),
        ({"tip": {"center_of_mass": 1e-5}}, {"tip": {"center_of_mass": 1e-6}}, {}),
        ({"base": {"damping": 1e-4}}, {"base": {"damping": 1e-5}}, {"base": {"damping": 0.0}}),
        ({"follower": {"damping": 1e-3}}, {"follower": {"damping": 1e-4}}, {"follower": {"damping": 0.0}}),
        ({"gravity": (0.0, 1e-3)}, {"gravity": (0.0, 1e-4)}, {}),
    ],
    ids=["slider inertia", "slider mass", "tip", "tip offset", "base damping", "beam damping", "gravity"],
)
def test_limits_are_approached_at_first_order(little: dict[str, Any], less: dict[str, Any], none: dict[str, Any]) -> None:
    limit, far, near = shown(**none), shown(**little), shown(**less)
    for name in ("tip_deflection", "strain_2", "slider_force", "crank_angle"):
        a, b = error(far[name], limit[name]), error(near[name], limit[name])
        # a tenth of the cause has a tenth of the effect, where that stands out from the integration error
        assert b < 0.12 * a + 1e-8, name
        assert a < 1e-2, name


def test_a_stiff_follower_moves_like_the_rigid_one() -> None:
    stiff = run_24(follower={"bending_stiffness": 1e4 * run_24().follower.bending_stiffness})
    _, columns = run(BeamModel.following(stiff, 1), 0.1, 100, 1e-10)
    motion = rigid_motion(stiff, columns["crank_angle"], columns["crank_speed"])
    # deflections are 27 mm / 1e4
    np.testing.assert_allclose(columns["slider_position"], motion.slider_position, atol=1e-6)
    np.testing.assert_allclose(columns["follower_angle"], motion.follower_angle, atol=2e-5)
