"""Gap, constraint rows and forces of the rival methods against the bent line computed from its definition."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import reference_model
from reference_model.constraints.joint import BOTH_LINEAR, CONSISTENT, LEVER, Joint
from reference_model.constraints.model import OpenLoopModel
from reference_model.constraints.multiplier import multiplier
from reference_model.constraints.nodal_load import nodal_load
from reference_model.constraints.open_loop import open_right_hand_side
from reference_model.constraints.stiff_spring import stiff_spring
from reference_model.dynamics import right_hand_side
from reference_model.shapes import ShapeSet, clamped_free_modes, hermite_elements
from tests.engines.scenes import run_24
from tests.reference_model import bent_line

Array = NDArray[np.float64]
SCENE = run_24(gravity=(1.0, -9.81))
LENGTH = SCENE.follower.length
MODES = clamped_free_modes(LENGTH, 3)
ELEMENTS = hermite_elements(LENGTH, 4)


def state(model: OpenLoopModel, *, opened: bool) -> Array:
    """A bent and moving follower at q1 = 2 rad, with a gap of a millimetre and a gap rate of 0.1 m/s if `opened`."""
    x = model.closed.projection_points() / LENGTH
    bend = model.closed.project_deflection(0.02 * x**2 * (1.5 - x), 0.02 * (3.0 * x - 3.0 * x**2) / LENGTH)
    rate = model.closed.project_deflection(-0.5 * x**2, -1.0 * x / LENGTH)
    y = model.initial_state(2.0, 16.6, bend, rate)
    if opened:
        y[1] += 0.002
        y[model.shapes.count + 3] += 0.2
    return y


def rates(model: OpenLoopModel, y: Array) -> Array:
    rate = np.empty_like(y)
    assert open_right_hand_side(model.closed.parameters, model.joint, model._workspace, y, rate)
    return rate


def split(model: OpenLoopModel, y: Array) -> tuple[Array, Array]:
    """Coordinates and speeds."""
    size = model.shapes.count + 2
    return y[:size], y[size : 2 * size]


def element_of(model: OpenLoopModel) -> int:
    """The element that carries the slider after an evaluation."""
    return int(np.searchsorted(ELEMENTS.edges, model._workspace.slider[0])) - 1


def distance(model: OpenLoopModel, q: Array) -> float:
    """The gap that the joint sees, from the definition."""
    if model.joint.distribution == BOTH_LINEAR:
        return bent_line.chord_gap(SCENE, model.shapes, q, element_of(model))
    return bent_line.gap(SCENE, model.shapes, q)


CASES = [
    pytest.param(multiplier(0.0), MODES, id="multiplier"),
    pytest.param(nodal_load(CONSISTENT, 0.0), ELEMENTS, id="consistent"),
    pytest.param(nodal_load(LEVER, 0.0), ELEMENTS, id="lever"),
    pytest.param(nodal_load(BOTH_LINEAR, 0.0), ELEMENTS, id="both linear"),
]


@pytest.mark.parametrize(("joint", "shapes"), CASES)
def test_row_is_the_gradient_of_the_gap(joint: Joint, shapes: ShapeSet) -> None:
    model = OpenLoopModel(SCENE, shapes, joint, False)
    y = state(model, opened=True)
    rates(model, y)
    expected = bent_line.gradient(lambda q: distance(model, q), split(model, y)[0])
    # central differences with a step of 1e-6: 1e-12 of the third derivative, which slopes of order 100/m^2 make 1e-7
    np.testing.assert_allclose(model._workspace.row, expected, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize(("joint", "shapes"), CASES)
def test_an_open_gap_keeps_its_rate_without_stabilization(joint: Joint, shapes: ShapeSet) -> None:
    """Along q + q' t + q'' t^2/2 the second difference of the gap vanishes; that of any one term of it does not."""
    model = OpenLoopModel(SCENE, shapes, joint, False)
    y = state(model, opened=True)
    acceleration = rates(model, y)[shapes.count + 2 : 2 * shapes.count + 4]
    q, speed = split(model, y)
    h = 1e-5
    before, now, after = (distance(model, q + speed * t + 0.5 * acceleration * t * t) for t in (-h, 0.0, h))
    # rounding 1e-16 / h^2 = 1e-6; the fourth derivative of the gap (1e8 at these accelerations) times h^2 / 12
    assert abs(before - 2.0 * now + after) / h**2 < 1e-2
    assert np.max(np.abs(model._workspace.row * acceleration)) > 10.0


def test_stabilized_gap_decays_critically() -> None:
    rate = 200.0
    model, free = (OpenLoopModel(SCENE, MODES, multiplier(r), False) for r in (rate, 0.0))
    y = state(model, opened=True)
    gap = bent_line.gap(SCENE, MODES, split(model, y)[0])
    change = rates(model, y)[5:10] - rates(free, y)[5:10]
    gap_rate = float(model._workspace.row @ split(model, y)[1])
    wanted = -2.0 * rate * gap_rate - rate**2 * gap
    assert model._workspace.row @ change == pytest.approx(wanted, rel=1e-8)  # the gap to 1e-15 of 1e-3


@pytest.mark.parametrize("shapes", [MODES, ELEMENTS], ids=["modes", "elements"])
def test_a_closed_gap_moves_as_the_eliminated_constraint_does(shapes: ShapeSet) -> None:
    model = OpenLoopModel(SCENE, shapes, multiplier(100.0), False)
    y, n = state(model, opened=False), shapes.count
    closed = model.closed.initial_state(y[0], y[n + 2], y[2 : n + 2], y[n + 4 : 2 * n + 4])
    expected = np.empty_like(closed)
    assert right_hand_side(model.closed.parameters, model.closed._workspace, closed, expected)
    found = rates(model, y)
    free = np.r_[found[n + 2], found[n + 4 : 2 * n + 4]]
    # two solutions of one linear system whose condition number is 1e4 at most
    np.testing.assert_allclose(free, expected[n + 1 : 2 * n + 2], rtol=1e-10, atol=1e-10 * np.max(np.abs(free)))


def test_nodal_load_distributed_as_the_shapes_say_is_the_multiplier() -> None:
    models = [OpenLoopModel(SCENE, ELEMENTS, joint, False) for joint in (multiplier(50.0), nodal_load(CONSISTENT, 50.0))]
    y = state(models[0], opened=True)
    np.testing.assert_array_equal(rates(models[0], y), rates(models[1], y))


def test_lever_rule_is_two_forces_on_the_nodes() -> None:
    """Virtual work of the shares of a unit force along the slider's normal, on nodes placed by the definition."""
    model = OpenLoopModel(SCENE, ELEMENTS, nodal_load(LEVER, 0.0), False)
    y = state(model, opened=True)
    rates(model, y)
    q = split(model, y)[0]
    s, left = bent_line.foot(SCENE, ELEMENTS, q), element_of(model)
    n_in_b = bent_line.normal(ELEMENTS, q[2:], s)
    n = turned(n_in_b, q[1])
    share = (s - ELEMENTS.edges[left]) / (ELEMENTS.edges[left + 1] - ELEMENTS.edges[left])

    def along(q: Array) -> float:
        nodes = [turned(bent_line.place(ELEMENTS, q[2:], float(ELEMENTS.edges[left + side])), q[1]) for side in (0, 1)]
        arm = SCENE.crank.length * np.array([math.cos(q[0]), math.sin(q[0])])
        return float(n @ (arm - (1.0 - share) * nodes[0] - share * nodes[1]))

    np.testing.assert_allclose(model._workspace.spread, bent_line.gradient(along, q), rtol=0.0, atol=1e-7)


def turned(vector: Array, angle: float) -> Array:
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]) @ vector


def test_spring_pulls_with_its_stiffness_and_damping() -> None:
    k, c = 3e4, 20.0
    spring, free = (OpenLoopModel(SCENE, MODES, joint, False) for joint in (stiff_spring(k, c), stiff_spring(0.0, 0.0)))
    y = state(spring, opened=True)
    change = rates(spring, y)[5:10] - rates(free, y)[5:10]
    q, speed = split(spring, y)
    row = bent_line.gradient(lambda q: bent_line.gap(SCENE, MODES, q), q)
    force = k * bent_line.gap(SCENE, MODES, q) + c * float(row @ speed)
    found = spring._workspace.beam.M @ change
    np.testing.assert_allclose(found, -force * row, rtol=0.0, atol=1e-5 * abs(force))  # as the gradient


def test_frequencies_of_the_spring_approach_the_rigid_ones_at_first_order() -> None:
    scene = run_24()
    rigid = OpenLoopModel(scene, MODES, multiplier(0.0), False).natural_frequencies(math.pi, 3)
    errors = [rigid[0] - OpenLoopModel(scene, MODES, stiff_spring(k, 0.0), False).natural_frequencies(math.pi, 1)[0] for k in (1e6, 1e7)]
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)  # second order in 1/k: 1e-2 of the first at 1e6 N/m
    # converged: 20.354 Hz (transcendental equation of the supported beam); Rayleigh's principle puts three shapes above
    assert 20.354 < rigid[0] < 20.6


def test_lever_rule_makes_frequencies_complex() -> None:
    """Force and motion that are not conjugate make an unsymmetric problem: pairs of roots leave the imaginary axis (flutter)."""
    scene = run_24()
    symmetric, lever = (OpenLoopModel(scene, ELEMENTS, nodal_load(d, 0.0), False) for d in (CONSISTENT, LEVER))
    growth = [np.max(model.growth_rates(angle)) for model in (symmetric, lever) for angle in np.linspace(math.pi, 2.0 * math.pi, 13)]
    assert max(growth[:13]) < 1e-3  # 1/s, rounding of roots near 1e4 rad/s
    assert max(growth[13:]) > 100.0


def test_document_and_code_cite_each_other() -> None:
    """Every equation of RIVALS.md is implemented by something that says so, and nothing cites one that is not there."""
    package = Path(reference_model.__file__).parent
    defined = re.findall(r"\\tag\{(R\d+\.\d+)\}", (package / "RIVALS.md").read_text(encoding="utf-8"))
    assert len(defined) == len(set(defined))
    cited: set[str] = set()
    for file in (package / "constraints").glob("*.py"):
        for first, last in re.findall(r"(R\d+\.\d+)(?:\s+to\s+(R\d+\.\d+))?", file.read_text(encoding="utf-8")):
            cited |= {e for e in defined if first <= e <= (last or first)} | {first}
    assert cited == set(defined)
