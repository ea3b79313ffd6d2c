"""A rod library for small deflections, a chain of rigid links between joints with springs, right or with one mistake."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from scipy.linalg import eigh, expm

from quickreturn.engines.base import Comparison, Engine, ModelDescription, Refusal, Simulation
from quickreturn.engines.rod import Rod, RodEngine
from quickreturn.engines.settings import Settings, setting
from quickreturn.engines.trajectory import FollowerTrajectory
from quickreturn.plugins.conform.scenes import CLAMPED as SCENE
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import FollowerAlone, Scene

_SIZES: Final = "rod: sags and frequencies"


@dataclass(frozen=True, kw_only=True)
class Links(Settings):
    """The number of links."""

    links: int = setting(12, "number of links", low=2, high=200)


class LinearRod(Engine[Links]):
    """A clamped chain of N links; its joints stand for the piece of a link's length about them, that at the clamp for half of one."""

    name, method = "linear-rod", "chain of links, small deflections"
    default_accuracy = 0.01
    quantities = ("mechanism.gravity", "follower.damping", "follower.material_damping", "base.spin_up_speed")
    settings_type = Links

    def check(self, scene: Scene, /) -> None:
        if not isinstance(scene, FollowerAlone):
            raise Refusal(f"{self.name} models no crank and no slider; give a follower alone")
        super().check(scene)

    def describe(self, scene: FollowerAlone, settings: Links, /) -> ModelDescription:
        return ModelDescription(("links",), ("joints",), settings.links)

    def settings_for(self, accuracy: float, scene: Scene, /) -> Links:
        return Links(links=max(4, math.ceil(1.0 / math.sqrt(accuracy))))

    def comparisons(self, settings: Links, scene: Scene, output_step: float, /) -> tuple[Comparison, ...]:
        return (Comparison(settings, settings.replaced(links=2 * settings.links), 0.25),)

    def finer(self, settings: Links, excess: Mapping[str, float], output_step: float, /) -> Links | None:
        return settings.replaced(links=math.ceil(1.4 * settings.links)) if settings.links < 100 else None

    def natural_frequencies(self, mechanism: Any, crank_angle: float, count: int, settings: Links, /) -> Array:
        raise Refusal("it has no crank")

    def version(self) -> str:
        return "linear-rod 1"

    def length(self, scene: FollowerAlone, n: int) -> float:
        """Of a link, m."""
        return scene.follower.length / n

    def stiffness(self, scene: FollowerAlone, n: int) -> Array:
        """Of the joints, N m."""
        return scene.follower.bending_stiffness / self.length(scene, n) * np.append(2.0, np.ones(n - 1))

    def masses(self, scene: FollowerAlone, n: int) -> Array:
        """Mass matrix of the rod for the deflections of the links' ends, kg: rigid links with evenly spread mass."""
        share = scene.follower.mass_per_length * self.length(scene, n) / 6.0
        matrix: Array = share * (np.diag(np.append(np.full(n - 1, 4.0), 2.0)) + np.eye(n, k=1) + np.eye(n, k=-1))
        return matrix

    def dampers(self, scene: FollowerAlone, n: int) -> Array:
        """Of the joints, N m s."""
        return scene.follower.material_damping * self.stiffness(scene, n)

    def drag(self, scene: FollowerAlone, n: int) -> Array:
        """Damping matrix of the links' ends by the drag of their place, N s/m."""
        matrix: Array = scene.follower.damping / scene.follower.mass_per_length * LinearRod.masses(self, scene, n)
        return matrix

    def prepare(self, scene: FollowerAlone, start: Any, settings: Links, /) -> Simulation:
        return LinearMotion(self, scene, settings.links)


class LinearMotion(Simulation):
    """The chain's motion, exact in time; coordinates are the deflections of the links' ends."""

    def __init__(self, rod: LinearRod, scene: FollowerAlone, n: int) -> None:
        self.length, self.time, self.setup_seconds = n * rod.length(scene, n), 0.0, 0.0
        turns = (np.eye(n) - 2.0 * np.eye(n, k=-1) + np.eye(n, k=-2)) / rod.length(scene, n)
        springs = turns.T @ np.diag(rod.stiffness(scene, n)) @ turns
        masses = rod.masses(scene, n)
        at_clamp = np.zeros(n)
        at_clamp[0] = scene.follower.mass_per_length * rod.length(scene, n) / 6.0  # of the first link, whose other end is held
        weights = scene.gravity[1] * (masses @ np.ones(n) + at_clamp)
        weights[-1] += scene.gravity[1] * scene.tip_body.mass
        masses[-1, -1] += scene.tip_body.mass
        losses = turns.T @ np.diag(rod.dampers(scene, n)) @ turns + rod.drag(scene, n)
        self.rest = np.linalg.solve(springs, weights)
        self.matrix = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(masses, springs), -np.linalg.solve(masses, losses)]])
        self.state = np.append(-self.rest, np.zeros(n))
        beam = scene.follower
        # curvature at the joints, that at the clamp standing for half a link, and none at the free end
        curvature = np.diag(np.append(2.0, np.ones(n - 1)) * n / self.length) @ turns
        at = beam.strain_gauges, self.length / n * np.arange(n + 1)
        self.strains = beam.extreme_fibre * np.array([np.interp(*at, np.append(column, 0.0)) for column in curvature.T]).T

    def advance(self, duration: float, output_step: float) -> FollowerTrajectory:
        rows, step, n = round(duration / output_step), expm(output_step * self.matrix), len(self.rest)
        states = [self.state]
        for _ in range(rows):
            states.append(step @ states[-1])
        table = np.array(states)
        self.state, times = table[-1], self.time + output_step * np.arange(rows + 1)
        self.time, deflection, still = float(times[-1]), table[:, n - 1] + self.rest[-1], np.zeros_like(times)
        columns = {"time": times, "follower_angle": still, "tip_x": still + self.length, "tip_y": deflection}
        columns |= {"tip_deflection": deflection, "tip_acceleration": (table @ self.matrix.T)[:, -1]}
        strains = (table[:, :n] + self.rest) @ self.strains.T
        return FollowerTrajectory(columns | {f"strain_{k + 1}": strains[:, k] for k in range(3)}, 0.0)


class Elements(Rod):
    """Cubic elements, exact in time. `times`: factor on the length of an element in their stiffness and mass."""

    times: ClassVar[Callable[[int], float]] = lambda pieces: 1.0

    def __init__(self, scene: FollowerAlone, pieces: int) -> None:
        if scene.gravity[0]:
            raise Refusal("gravity along the rod")
        beam, self.h, n = scene.follower, scene.follower.length / pieces, 2 * (pieces + 1)
        h, stiffness, masses, weight = self.h * type(self).times(pieces), np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
        bend = np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h * h, -6 * h, 2 * h * h], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h * h]])
        inert = np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h * h, 13 * h, -3 * h * h], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h * h]])
        for k in range(0, n - 2, 2):
            part = slice(k, k + 4)
            stiffness[part, part] += beam.bending_stiffness / h**3 * (bend + np.triu(bend, 1).T)
            masses[part, part] += beam.mass_per_length * h / 420.0 * (inert + np.triu(inert, 1).T)
            weight[part] += beam.mass_per_length * scene.gravity[1] * h / 12.0 * np.array([6.0, h, 6.0, -h])
        masses[-2, -2] += scene.tip_body.mass
        weight[-2] += scene.tip_body.mass * scene.gravity[1]
        self.squares, self.shapes = eigh(stiffness[2:, 2:], masses[2:, 2:])
        self.load, self.time, self.damping = self.shapes.T @ weight[2:], 0.0, beam.material_damping

    def _vibration(self) -> tuple[Array, Array]:
        """Of each mode the deflection, over that at rest, and its second derivative by the time over the load."""
        decay = 0.5 * self.damping * self.squares
        apart = np.sqrt((decay**2 - self.squares).astype(complex))
        one, other = apart - decay, -apart - decay
        first, second = np.exp(one * self.time), np.exp(other * self.time)
        return 1.0 + ((other * first - one * second) / (2.0 * apart)).real, ((one * first - other * second) / (2.0 * apart)).real

    def advance(self, duration: float) -> None:
        self.time += duration

    def points(self) -> Array:
        """Of the nodes; the first one, at the clamp, is left out by the shapes."""
        deflections = self.shapes @ (self._vibration()[0] * self.load / self.squares)
        return np.column_stack([self.h * np.arange(len(deflections) // 2 + 1), np.append(0.0, deflections[0::2])])

    def acceleration(self) -> Array:
        return np.array([0.0, (self.shapes @ (self._vibration()[1] * self.load))[-2]])


class ElementsOfOneMetre(Elements):
    """A homemade program's mistake: element matrices without the element's length."""

    times = lambda pieces: pieces / SCENE.follower.length  # noqa: E731


def of_elements(rod: type[Elements], *errors: tuple[int, float]) -> RodEngine:
    """An engine of such rods with measured errors by the number of elements."""
    values = {"name": "elements", "method": "cubic elements", "library": "scipy", "rod": rod, "order": 2.0, "errors": dict(errors)}
    tested: RodEngine = type("OfElements", (RodEngine,), values | {"quantities": ("mechanism.gravity", "follower.material_damping")})()
    return tested


def mistaken(part: str, change: Callable[[Array, FollowerAlone, int], Array]) -> LinearRod:
    """The chain with a part (a method of `LinearRod`) that is changed; of a scene with a number of links."""

    def wrong(self: LinearRod, scene: FollowerAlone, n: int) -> Array:
        return change(getattr(LinearRod, part)(self, scene, n), scene, n)

    return type("Mistaken", (LinearRod,), {part: wrong})()


def _nodes(scene: FollowerAlone, n: int, last: float) -> Array:
    """Masses at the nodes; that at the free end is a part of the others."""
    return scene.follower.mass_per_length * scene.follower.length / n * np.diag(np.append(np.ones(n - 1), last))


#: Mistake -> the part of the chain, how it is changed, and the check that must fail.
MUTANTS: Final[dict[str, tuple[str, Callable[[Array, FollowerAlone, int], Any], str]]] = {
    "round section": ("stiffness", lambda right, scene, n: 3.0 * math.pi / 16.0 * right, _SIZES),
    "square section": ("stiffness", lambda right, scene, n: 16.0 / (3.0 * math.pi) * right, _SIZES),
    "a segment too many": ("length", lambda right, scene, n: right * n / (n - 1), _SIZES),
    "stiffness of one segment more": ("stiffness", lambda right, scene, n: right * (n + 1) / n, _SIZES),
    "stiffness halved at the ends": ("stiffness", lambda right, scene, n: right * np.append(0.5, np.append(np.ones(n - 2), 0.5)), _SIZES),
    "first half segment rigid": ("stiffness", lambda right, scene, n: right * np.append(1e4, np.ones(n - 1)), _SIZES),
    "half the mass at the end": ("masses", lambda right, scene, n: _nodes(scene, n, 0.25), _SIZES),
    "whole mass at the end": ("masses", lambda right, scene, n: _nodes(scene, n, 1.0), _SIZES),
    "stiffness lost with damping": (
        "stiffness",
        lambda right, scene, n: right * (0.5 if scene.follower.material_damping else 1.0),
        "rod: decay by follower.material_damping",
    ),
    "dampers scale with the mesh": ("dampers", lambda right, scene, n: right * 12.0 / n, "rod: decay by follower.material_damping"),
    "damping of half the size": ("dampers", lambda right, scene, n: 0.5 * right, "rod: decay by follower.material_damping"),
    "drag scales with the mesh": ("drag", lambda right, scene, n: right * n / 10.0, "rod: decay by follower.damping"),
    "drag ignored": ("drag", lambda right, scene, n: 0.0 * right, "rod: decay by follower.damping"),
}
