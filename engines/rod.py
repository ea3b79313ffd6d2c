"""A base for engines that model a clamped rod and nothing else, as rod libraries do.

An author writes a `Rod`, which is built, moved on and looked at, and a `RodEngine`, with its errors and the quantities that it models.
Rows, strains, ladder, error estimate, refusals, failures and version follow.
"""

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Final, NoReturn

import numpy as np

from quickreturn.engines.base import SPIN_UP, EngineFailure, ModelDescription, Refusal, Simulation
from quickreturn.engines.settings import Settings, setting
from quickreturn.engines.simple import OneResolution
from quickreturn.engines.trajectory import FollowerTrajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import FollowerAlone, Scene

#: Part of its length by which a rod that begins straight may be bent, or be off its place: rounding, in single precision too.
_STRAIGHT: Final = 1e-5


@dataclass(frozen=True, kw_only=True)
class RodSettings(Settings):
    """Resolution."""

    resolution: int = setting(12, "number of pieces: elements, segments, links", low=1, high=1000)


class Rod(ABC):
    """A rod that is clamped at the origin along n1 and let go at time 0, straight and at rest."""

    @abstractmethod
    def __init__(self, scene: FollowerAlone, pieces: int) -> None:
        """Build it. Raises Refusal: the library cannot model this scene."""

    @abstractmethod
    def advance(self, duration: float) -> None:
        """Move it on by `duration` (s), with as many steps as it needs."""

    @abstractmethod
    def points(self) -> Any:
        """Ends of the pieces, the free end last, along n1 and n2: m, shape (n, 2). The first lies behind a clamp that holds a piece."""

    @abstractmethod
    def acceleration(self) -> Any:
        """Of the free end, along n1 and n2: m/s^2, shape (2,)."""


class RodEngine(OneResolution[RodSettings]):
    """An engine that models a clamped rod.

    Its `errors` are those of the sag under its weight or of the first natural frequency, whichever is larger.
    """

    needed = ("name", "method", "rod", "library", "errors", "order")
    settings_type = RodSettings
    default_accuracy = 0.02
    rod: ClassVar[type[Rod]]
    #: Degrees of freedom of a piece.
    freedoms: ClassVar[int] = 1

    def __init_subclass__(cls) -> None:
        cls.quantities = tuple(dict.fromkeys((*cls.quantities, SPIN_UP)))  # says that it models a follower alone
        super().__init_subclass__()

    def check(self, scene: Scene) -> None:
        """Refuse a crank, a base that turns, a rigid rod, and what `quantities` does not name."""
        if scene.crank is not None or scene.spin_up.speed != 0.0:
            raise Refusal(f"engine {self.name} models a clamped rod; accepted: a scene without [crank], base.spin_up_speed = 0")
        super().check(scene)
        if scene.follower.is_rigid:
            raise Refusal(f"follower.bending_stiffness: inf N*m^2 is not modelled by engine {self.name}; accepted: a finite stiffness")

    def describe(self, scene: FollowerAlone, settings: RodSettings) -> ModelDescription:
        self.check(scene)
        pieces = settings.resolution
        tip = ["tip body"] if scene.tip else []
        return ModelDescription((f"rod, {pieces} pieces", *tip), ("clamp",), pieces * self.freedoms)

    def prepare(self, scene: FollowerAlone, start: None, settings: RodSettings) -> Simulation:
        """See `Engine.prepare`; SettingError: a resolution that is coarser than any that was measured."""
        self.check(scene)
        self._not_too_coarse(settings.resolution)
        began = time.perf_counter()
        rod = self.rod(scene, settings.resolution)
        return _RodSimulation(rod, scene, time.perf_counter() - began)

    def natural_frequencies(self, mechanism: Any, crank_angle: float, count: int, settings: RodSettings) -> NoReturn:
        """Raise Refusal: they are those of a mechanism whose crank is held."""
        raise Refusal(f"engine {self.name} models a clamped rod, which has no crank to hold")


class _RodSimulation(Simulation):
    """A rod, advanced from row to row."""

    def __init__(self, rod: Rod, scene: FollowerAlone, setup_seconds: float) -> None:
        """Raises EngineFailure: the rod does not begin straight along n1."""
        self.rod, self.beam = rod, scene.follower
        self.setup_seconds, self.time = setup_seconds, 0.0
        points = self._looked_at("points", (-1, 2))
        if len(points) < 2 or np.ptp(points[:, 1]) > _STRAIGHT * self.beam.length or (np.diff(points[:, 0]) <= 0.0).any():
            cause = f"points() of {type(rod).__name__} does not begin as a straight line along n1"
            raise EngineFailure(0.0, cause, f"it begins with {points[0]} and ends with {points[-1]}")
        self.places = points[:, 0]

    def advance(self, duration: float, output_step: float) -> FollowerTrajectory:
        began, begin, rows = time.perf_counter(), self.time, [self._row()]
        for k in range(round(duration / output_step)):
            self.rod.advance(output_step)
            self.time = begin + (k + 1) * output_step
            rows.append(self._row())
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        return FollowerTrajectory(columns, time.perf_counter() - began)

    def _row(self) -> dict[str, float]:
        """The columns at present. Raises EngineFailure: points or acceleration have another shape than they should."""
        points, (ax, ay) = self._looked_at("points", (len(self.places), 2)), self._looked_at("acceleration", (2,))
        angles = np.unwrap(np.arctan2(*np.diff(points, axis=0).T[::-1]))
        end, (x, y) = angles[-1], points[-1]
        strains = self.beam.extreme_fibre * np.interp(self.beam.strain_gauges, *self._curvature(angles))
        return {
            "time": self.time, "follower_angle": 0.0, "tip_x": float(x), "tip_y": float(y), "tip_deflection": float(y),
            "tip_acceleration": float(np.cos(end) * ay - np.sin(end) * ax),
            **{f"strain_{k}": float(strain) for k, strain in enumerate(strains, 1)},
        }  # fmt: skip

    def _curvature(self, angles: Array) -> tuple[Array, Array]:
        """Places along the rod, m, and the curvature at each, 1/m, from the directions of the pieces.

        A piece's direction is that of the tangent in its middle, so that two neighbours show the curvature at the point between. The first
        piece shows that at the clamp, where the tangent is n1, unless the clamp holds the middle of the piece. The free end has none.
        """
        middles = (self.places[:-1] + self.places[1:]) / 2.0
        places, curvature = self.places[1:], np.append(np.diff(angles) / np.diff(middles), 0.0)
        if middles[0] > _STRAIGHT * self.beam.length:
            places, curvature = np.append(0.0, places), np.append(angles[0] / middles[0], curvature)
        return places, curvature

    def _looked_at(self, name: str, shape: tuple[int, int] | tuple[int]) -> Array:
        """What a method of the rod returns, of a shape; -1: any number. Raises EngineFailure: it has another shape."""
        found = np.array(getattr(self.rod, name)(), dtype=np.float64)  # a copy: libraries return views of their state
        if found.shape[1:] != shape[1:] or (shape[0] >= 0 and len(found) != shape[0]):
            needed = f"({'n' if shape[0] < 0 else shape[0]}{', 2' if len(shape) > 1 else ','})"
            raise EngineFailure(self.time, f"{name}() of {type(self.rod).__name__} has the shape {found.shape}", f"{needed} is needed")
        return found
