"""The motion does not depend on when it is looked at: output step and pieces."""

import pytest
from hypothesis import strategies as st

from quickreturn.engines.trajectory import join
from tests.properties.law import for_all
from tests.properties.runs import EXPLICIT, EXUDYN, FIXED_SHAPES, MUJOCO, REFERENCE, STEPS_ADD_UP, THESIS, TOLERANCE, Method, assert_close
from tests.strategies import Scene, scenes

#: Exudyn and MuJoCo divide the output step, so that another one changes their steps: only runs of the same steps can be compared.
EXACT = 1e-12
#: Two pieces begin the second one from states that are rounded once more, which the chain's vibrations magnify: up to 6e-13 in 40 scenes,
#: 1.1e-12 in one of them with other compiled code.
ROUNDED = 4e-12


@pytest.mark.parametrize("method", EXPLICIT, ids=str)
@for_all(few=3, many=25, scene=scenes(), times=st.integers(2, 5))
def test_the_output_step_does_not_show(method: Method, scene: Scene, times: int) -> None:
    """Rows are interpolated: the steps are the same whatever is shown."""
    fine = method.run(scene, rows=times * scene.rows)
    seen = {name: values[::times] for name, values in fine.columns.items()}
    # LSODA alone stops at each row
    bound = STEPS_ADD_UP * TOLERANCE if method is THESIS else EXACT
    assert_close(seen, method.run(scene), scene, method, bound)


@pytest.mark.parametrize("method", [REFERENCE, THESIS, FIXED_SHAPES, pytest.param(EXUDYN, marks=pytest.mark.verify), MUJOCO], ids=str)
@for_all(few=3, many=25, scene=scenes(), share=st.floats(0.1, 0.9))
def test_pieces_do_not_show(method: Method, scene: Scene, share: float) -> None:
    first = max(1, int(share * scene.rows))
    simulation = method.engine.prepare(scene.mechanism, scene.start, method.settings)
    pieces = [simulation.advance(rows * scene.output_step, scene.output_step) for rows in (first, scene.rows - first)]
    # Exudyn's and MuJoCo's steps are the same in one piece and in two
    bound = ROUNDED if method in (EXUDYN, MUJOCO) else STEPS_ADD_UP * TOLERANCE
    assert_close(join(pieces).columns, method.run(scene), scene, method, bound)
