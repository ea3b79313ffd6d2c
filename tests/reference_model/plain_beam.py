"""An independent picture of the one beam: places in plain numpy, differentiated numerically.

Nothing of `reference_model.motion` or `reference_model.beam.tables` is used. Where the follower's shapes move with the slider they come
from an eigenvalue problem solved anew for every place of it; the slider is put where it belongs by iteration; the dynamics are
d'Alembert's principle for mass points whose partial velocities and accelerations are differences of places. Complex numbers are vectors.
"""

import cmath
import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.optimize import newton
from scipy.special import betainc

from quickreturn.reference_model.joint import Rollers
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism, Scene, Slider, Tip, TorqueDrive
from quickreturn.reference_model.natural_modes import clamped_modes, supported_modes
from quickreturn.reference_model.shapes import ShapeSet
from quickreturn.reference_model.slider_constraint import BASE, CHORDS, ELIMINATED, LEVER, ROLLERS, SliderConstraint

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: Gauss points a piece: integrals of exp(i psi) and of products of modes up to the eighth to rounding.
POINTS: Final = 24
_XI, _WEIGHTS = legendre.leggauss(POINTS)
#: Coefficients of the Legendre series through values at the Gauss points.
_TO_SERIES = (np.arange(POINTS)[:, None] + 0.5) * (legendre.legvander(_XI, POINTS - 1) * _WEIGHTS[:, None]).T

#: Central differences of order eight.
_STEPS = np.arange(-4, 5)
_FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


def derivative(function: Callable[[float], NDArray[Any]], step: float, order: int = 1) -> NDArray[Any]:
    """First or second derivative at 0."""
    weights = (_FIRST, _SECOND)[order - 1]
    return np.tensordot(weights, np.array([function(step * k) for k in _STEPS]), axes=1) / step**order


class Shapes(ABC):
    """Tangent angles of the follower's shapes, piece by piece."""

    count: int

    @abstractmethod
    def edges(self, s: float) -> Array:
        """Ends of the pieces on which the angles are smooth, m, with the slider at s."""

    @abstractmethod
    def angles(self, s: float, x: Array) -> Array:
        """psi_i at arc lengths x (k,), shape (k, n)."""

    @abstractmethod
    def stiffness(self, s: float) -> Array:
        """Matrix (n, n) of twice the strain energy."""


class Following(Shapes):
    """Natural modes of the beam supported at the slider; signs as continued from where `orient` was called."""

    def __init__(self, mechanism: Mechanism, modes: int) -> None:
        self.count = modes
        self._bare = dataclasses.replace(mechanism, slider=Slider())
        self._signs = np.ones(modes)

    def edges(self, s: float) -> Array:
        return np.array([0.0, s, self._bare.follower.length])

    def angles(self, s: float, x: Array) -> Array:
        modes = supported_modes(self._bare, s, self.count)
        return np.asarray((modes.deflection(x, 1) - modes.deflection(np.zeros(1), 1)).T * self._signs, dtype=np.float64)

    def stiffness(self, s: float) -> Array:
        return np.diag((2.0 * math.pi * supported_modes(self._bare, s, self.count).frequencies) ** 2)

    def orient(self, s: float, x: Array, angles: Array) -> None:
        """Choose the signs of the modes at s so that they are those of given shapes `angles` (k, n) at `x` (k,)."""
        self._signs = np.ones(self.count)
        self._signs = np.sign(np.sum(self.angles(s, x) * angles, axis=0))


class Staying(Shapes):
    """Slopes of deflections that stay where they are.

    Args:
        deflection: derivatives of the deflections of given order at arc lengths (k,), shape (k, n).
        edges: of the pieces on which they are smooth, m.
        bending_stiffness: N m^2.
        split: m, a further edge: where the slider is, so that the moment's kink lies between pieces.
    """

    def __init__(self, deflection: Callable[[Array, int], Array], edges: Array, bending_stiffness: float, split: float) -> None:
        self._deflection = deflection
        self._edges = np.unique(np.append(edges, split))
        x, dx = _points(self._edges)
        curvature = deflection(x, 2)
        self._stiffness = bending_stiffness * curvature.T @ (dx[:, None] * curvature)
        self.count = len(self._stiffness)

    def edges(self, s: float) -> Array:
        return self._edges

    def angles(self, s: float, x: Array) -> Array:
        return self._deflection(x, 1)

    def stiffness(self, s: float) -> Array:
        return self._stiffness


def of_set(shapes: ShapeSet, bending_stiffness: float, split: float) -> Staying:
    return Staying(shapes.evaluate, shapes.edges, bending_stiffness, split)


def of_clamped_modes(scene: FollowerAlone, count: int, split: float) -> Staying:
    found, length = clamped_modes(scene, count), scene.follower.length
    edges = np.linspace(0.0, length, 5)
    return Staying(lambda x, order: found.deflection(x, order).T, edges, scene.follower.bending_stiffness, split)


def _points(edges: Array) -> tuple[Array, Array]:
    """Gauss points of all pieces and their weights, m."""
    half = 0.5 * np.diff(edges)
    return (0.5 * (edges[:-1] + edges[1:])[:, None] + half[:, None] * _XI).ravel(), (half[:, None] * _WEIGHTS).ravel()


@dataclass(frozen=True)
class Line:
    """A function along the follower by its Legendre series on pieces, each continued beyond its ends where asked for."""

    edges: Array
    series: list[NDArray[Any]]

    @classmethod
    def through(cls, edges: Array, values: NDArray[Any]) -> "Line":
        """Through values at the Gauss points of all pieces."""
        return cls(edges, [_TO_SERIES @ part for part in values.reshape(len(edges) - 1, POINTS)])

    def integral(self) -> "Line":
        """From 0."""
        found, start = [], 0.0
        for part, length in zip(self.series, np.diff(self.edges), strict=True):
            series = np.asarray(legendre.legint(part, lbnd=-1) * (0.5 * length))
            series[0] += start
            start = series.sum()  # every polynomial is 1 at the end
            found.append(series)
        return Line(self.edges, found)

    def slope(self, x: Any, piece: int) -> Any:
        length = self.edges[piece + 1] - self.edges[piece]
        return legendre.legval(self._xi(x, piece), legendre.legder(self.series[piece])) * 2.0 / length

    def slopes_on_pieces_of(self, edges: Array) -> NDArray[Any]:
        """The derivative by x where `on_pieces_of` takes the values."""
        places = _points(edges)[0].reshape(-1, POINTS)
        return np.concatenate([self.slope(row, piece) for piece, row in enumerate(places)])

    def at(self, x: Any, piece: int) -> Any:
        return legendre.legval(self._xi(x, piece), self.series[piece])

    def everywhere(self, x: Array) -> NDArray[Any]:
        pieces = np.clip(np.searchsorted(self.edges, x) - 1, 0, len(self.series) - 1)
        return np.array([self.at(place, piece) for place, piece in zip(x, pieces, strict=True)])

    def on_pieces_of(self, edges: Array) -> NDArray[Any]:
        """At the Gauss points of other pieces (`edges`, the same number of them), each by the series of its own piece."""
        places = _points(edges)[0].reshape(-1, POINTS)
        return np.concatenate([self.at(row, piece) for piece, row in enumerate(places)])

    def _xi(self, x: Any, piece: int) -> Any:
        start, end = self.edges[piece], self.edges[piece + 1]
        return (2.0 * x - start - end) / (end - start)


@dataclass(frozen=True)
class Configuration:
    """The follower in one position: angles and places along it in frame B, and how it hangs in the loop."""

    psi: Line
    z: Line
    strain_energy: float
    s: float = math.nan
    q2: float = math.nan
    gap: float = 0.0
    turn: float = math.nan  # angle of the line that the slider rides on, relative to frame B

    @property
    def frame(self) -> complex:
        return cmath.exp(1j * self.q2)


class PlainBeam:
    """Places of a scene's parts as functions of the coordinates: q1 (or time), amplitudes, and with an open loop q2.

    Args:
        scene: the mechanism, or the follower alone.
        shapes: of the follower.
        constraint: of the slider.
        near: m, about where the slider is: it decides to which piece of the follower it belongs.
        damps_along: 1, or 0 where the beam damping acts across the base tangent alone.
        node_edges: of the elements, whose two nodes carry the slider with LEVER and CHORDS, m.
    """

    def __init__(
        self,
        scene: Scene,
        shapes: Shapes,
        constraint: SliderConstraint,
        near: float,
        *,
        damps_along: float = 1.0,
        node_edges: Array | None = None,
    ) -> None:
        self.scene, self.shapes, self.constraint, self.near, self.damps_along = scene, shapes, constraint, near, damps_along
        self.kind = BASE if isinstance(scene, FollowerAlone) else constraint.kind
        self.node_edges = node_edges
        self._placed: dict[tuple[float, bytes], Configuration] = {}
        self.speeds = shapes.count + (1 if self.kind in (ELIMINATED, BASE) else 2)

    @property
    def slider_piece(self) -> int:
        """The piece that ends at the slider."""
        return int(np.argmin(np.abs(self.shapes.edges(self.near) - self.near))) - 1

    def nodes(self) -> tuple[float, float]:
        """Arc lengths of the two nodes of the slider's element."""
        assert self.node_edges is not None
        right = int(np.searchsorted(self.node_edges, self.near))
        return float(self.node_edges[right - 1]), float(self.node_edges[right])

    def node_places(self, c: Configuration) -> tuple[complex, complex]:
        left, right = c.z.everywhere(np.array(self.nodes()))
        return complex(left), complex(right)

    def crank_tip(self, q1: float) -> complex:
        """From P."""
        assert isinstance(self.scene, Mechanism)
        return self.scene.crank.length * cmath.exp(1j * q1) - self.scene.pivot_distance

    def at_place(self, s: float, eta: Array) -> Configuration:
        """The follower with the slider at s, not yet hung into the loop. The last one is kept: shapes that stay are the same at any s."""
        key = s if isinstance(self.shapes, Following) else self.near, eta.tobytes()
        if key not in self._placed:
            edges = self.shapes.edges(s)
            psi = Line.through(edges, self.shapes.angles(s, _points(edges)[0]) @ eta)
            z = Line.through(edges, np.exp(1j * psi.on_pieces_of(edges))).integral()
            self._placed = {key: Configuration(psi, z, 0.5 * float(eta @ self.shapes.stiffness(s) @ eta))}
        return self._placed[key]

    def hung(self, q: Array) -> Configuration:
        """The follower with the slider where it belongs."""
        n, piece = self.shapes.count, self.slider_piece
        eta = q[1 : n + 1]
        if isinstance(self.scene, FollowerAlone):
            return dataclasses.replace(self.at_place(self.near, eta), s=self.near, q2=base_angle(self.scene, q[0]))
        tip = self.crank_tip(q[0])

        def find(excess: Callable[[float], float]) -> float:
            return float(newton(excess, self.near, x1=self.near * 1.001, tol=1e-15, rtol=1e-15, maxiter=20, disp=False))

        if self.kind == ELIMINATED:
            s = find(lambda s: abs(complex(self.at_place(s, eta).z.at(s, piece))) - abs(tip))
            found = self.at_place(s, eta)
            q2 = cmath.phase(-tip / complex(found.z.at(s, piece))) + math.pi
            return dataclasses.replace(found, s=s, q2=q2, turn=float(found.psi.at(s, piece)))
        q2 = q[n + 1]
        C = tip * cmath.exp(-1j * q2)
        if self.kind == CHORDS:
            found = self.at_place(self.near, eta)
            left, right = self.node_places(found)
            along = (C - left) / (right - left)
            x1, x2 = self.nodes()
            gap, turn = along.imag * abs(right - left), cmath.phase(right - left)
            return dataclasses.replace(found, s=x1 + along.real * (x2 - x1), q2=q2, gap=gap, turn=turn)

        def beside(c: Configuration, s: float) -> complex:
            """The crank tip from the point at s, along the tangent there and across."""
            return complex((C - c.z.at(s, piece)) * np.exp(-1j * c.psi.at(s, piece)))

        s = find(lambda s: beside(self.at_place(s, eta), s).real)
        found = self.at_place(s, eta)
        return dataclasses.replace(found, s=s, q2=q2, gap=beside(found, s).imag, turn=float(found.psi.at(s, piece)))

    def carriers(self, q: Array, share: float, normal: complex) -> float:
        """What a unit force along `normal` (frame N, held) does work on: crank tip less the nodes by the lever rule of `share`, held."""
        c = self.hung(q)
        left, right = self.node_places(c)
        way = self.crank_tip(q[0]) - c.frame * ((1.0 - share) * left + share * right)
        return float((normal.conjugate() * way).real)


def base_angle(scene: FollowerAlone, t: float) -> float:
    """Of a base spun up as in the literature; rad."""
    speed, time = scene.spin_up.speed, scene.spin_up.time
    if t >= time:
        return speed * (t - 0.5 * time)
    return speed / time * (t**2 / 2.0 + (time / (2.0 * math.pi)) ** 2 * (math.cos(2.0 * math.pi * t / time) - 1.0))


@dataclass(frozen=True)
class Motion:
    """What differences of places say about a state (q, u)."""

    configuration: Configuration
    q2_rate: float
    s_rate: float
    gap_rate: float
    partial_q2: Array  # (m,)
    partial_s: Array
    partial_gap: Array
    spread: Array  # (m,) generalised force per unit of the slider's force, sign reversed
    q2_remainder: float  # second derivative where u' = 0
    s_remainder: float
    gap_remainder: float
    points: Array  # m, arc lengths of the Gauss points of all pieces
    partial_velocity: Complex  # (m, points), frame B
    acceleration_remainder: Complex  # (points,), frame B
    mass_matrix: Array
    force: Array  # everything but M u' and the slider's force
    acceleration: Array  # u'
    dissipated_power: float
    joint_power: float
    drive_power: float
    shown: dict[str, float]  # observables


def force_of_rollers(rollers: Rollers, gap: float, rate: float) -> tuple[float, float, float]:
    """Force of the joint on the follower along its normal (N), energy stored in it (J) and power that it turns into heat (W).

    Each roller is compressed, pushes, stores and loses on its own.
    """
    force, energy, heat = rollers.damping * rate, 0.0, rollers.damping * rate**2
    for stiffness, begin, side in ((rollers.plus, rollers.plus_from, 1.0), (rollers.minus, rollers.minus_from, -1.0)):
        compression, closing = side * gap - begin, side * rate
        if compression > 0.0:
            elastic = stiffness * compression
            push = elastic * (1.0 + rollers.loss * closing) if rollers.loss * closing > -1.0 else 0.0
            force += side * push
            energy += 0.5 * stiffness * compression**2
            heat += (push - elastic) * closing
    return force, energy, heat


def sliding_share(speed: float, over: float) -> float:
    """From -1 to 1, by the exponential function."""
    return 1.0 - 2.0 / (1.0 + math.exp(2.0 * speed / over))


def acting_share(tip: Tip, crank_angle: float) -> float:
    """Share of the force on the tip that acts: the incomplete beta function comes and goes twice continuously differentiable."""
    turned = (crank_angle - tip.force_from) % (2.0 * math.pi)
    inside = min(turned, tip.force_to - tip.force_from - turned)
    return 1.0 if tip.is_always_forced else float(betainc(3.0, 3.0, min(max(inside / tip.force_ramp, 0.0), 1.0)))


def motion(beam: PlainBeam, y: Array) -> Motion:
    """Of a state vector of the model; its place of the slider is not read."""
    m, n, scene = beam.speeds, beam.shapes.count, beam.scene
    q, u = y[:m], y[m + 1 : 2 * m + 1]
    follower, tip = scene.follower, scene.tip_body
    here = beam.hung(q)
    edges = here.psi.edges
    x, dx = _points(edges)
    last, N = len(edges) - 2, len(x)
    L, g = follower.length, complex(*scene.gravity)
    crank_moment, crank_inertia, slider_inertia, crank_length = 0.0, 0.0, 0.0, 0.0
    slider = Slider()
    if isinstance(scene, Mechanism):
        crank, slider = scene.crank, scene.slider
        slider_inertia, crank_length = slider.inertia, crank.length
        crank_moment = crank.mass * crank.center_of_mass + slider.mass * crank_length
        crank_inertia = crank.inertia_about_pivot + slider.mass * crank_length**2

    def picture(at: Array) -> Complex:
        """Places from P (N), of tip centre and end; in frame B (N); angles (N), of end and slider; q2, s, gap; energies; curvatures (N)."""
        c = beam.hung(at)
        z = c.z.on_pieces_of(edges)
        alpha = c.psi.on_pieces_of(edges) + c.q2
        z_end, alpha_end = complex(c.z.at(L, last)), float(c.psi.at(L, last)) + c.q2
        end = c.frame * z_end
        centre = end + tip.center_of_mass * cmath.exp(1j * alpha_end)
        potential = -follower.mass_per_length * float(dx @ np.real(g.conjugate() * c.frame * z))
        potential -= tip.mass * (g.conjugate() * centre).real + crank_moment * (g.conjugate() * cmath.exp(1j * at[0])).real
        tail = [alpha_end, c.turn + c.q2, c.q2, c.s, c.gap, c.strain_energy, potential]
        return np.concatenate([c.frame * z, [centre, end], z, alpha, tail, c.psi.slopes_on_pieces_of(edges)])

    # steps: places change by about a hundredth of their size
    angles = beam.shapes.angles(here.s, x)
    sizes = np.concatenate([[6e-3], 0.01 / np.max(np.abs(angles), axis=0), [6e-3] * (m - n - 1)])

    def along(direction: Array) -> Callable[[float], Complex]:
        return lambda e: picture(q + e * direction)

    partial = np.array([derivative(along(one), size) for one, size in zip(np.eye(m), sizes, strict=True)])
    remainder = derivative(along(u), 1.0 / np.max(np.abs(u) / sizes), 2)
    present = picture(q)
    rate = u @ partial
    relative = slice(N + 2, 2 * N + 2)
    alpha_end, at_slider, q2_at, s_at, gap_at, strain_at, gravity_at = range(3 * N + 2, 3 * N + 9)
    curvatures = slice(3 * N + 9, 4 * N + 9)
    mass = np.concatenate([follower.mass_per_length * dx, [tip.mass]])
    bodies = slice(0, N + 1)

    M = np.real(np.conj(partial[:, bodies]) * mass @ partial[:, bodies].T)
    force = -np.real(np.conj(partial[:, bodies]) @ (mass * remainder[bodies]))
    turning = ((alpha_end, tip.inertia), (at_slider, slider_inertia), (q2_at, scene.base.inertia))
    for which, J in turning:
        if J > 0.0:
            M += J * np.outer(partial[:, which].real, partial[:, which].real)
            force -= J * partial[:, which].real * remainder[which].real
    M[0, 0] += crank_inertia
    q2_rate = float(rate[q2_at].real)
    at_hinge = scene.base.damping * q2_rate + scene.base.friction_torque * sliding_share(q2_rate, 0.1)
    force -= partial[:, strain_at].real + partial[:, gravity_at].real + at_hinge * partial[:, q2_at].real
    drift = rate[relative].real * beam.damps_along + 1j * rate[relative].imag
    force -= follower.damping * np.real(np.conj(partial[:, relative]) @ (dx * drift))
    tool = complex(*tip.force) * acting_share(tip, q[0]) if isinstance(scene, Mechanism) else 0j
    force += np.real(np.conj(partial[:, N + 1]) * tool)
    delay = beam.constraint.bending_damping + follower.material_damping if n else 0.0
    bending_rate = rate[curvatures].real
    damping_moment = follower.bending_stiffness * delay * bending_rate if n else np.zeros(N)
    force -= partial[:, curvatures].real @ (dx * damping_moment)
    drive = scene.crank.drive if isinstance(scene, Mechanism) else None
    crank_damping = 0.0
    if isinstance(drive, TorqueDrive):
        crank_damping = drive.damping
        force[0] += drive.torque - crank_damping * u[0]

    row, gap_rate = partial[:, gap_at].real, float(rate[gap_at].real)
    first = 0 if isinstance(drive, TorqueDrive) else 1
    spread = row
    if beam.kind == LEVER:
        x1, x2 = beam.nodes()
        share, normal = (here.s - x1) / (x2 - x1), 1j * cmath.exp(1j * (here.q2 + here.turn))

        def carried(direction: Array) -> Callable[[float], Array]:
            return lambda e: np.array(beam.carriers(q + e * direction, share, normal))

        spread = np.array([derivative(carried(one), size) for one, size in zip(np.eye(m), sizes, strict=True)])
    acceleration, contact, rubbing, arm, slides = np.zeros(m), 0.0, 0.0, 0.0, 1.0
    law, stored, lost = force_of_rollers(beam.constraint.rollers, here.gap, gap_rate) if beam.kind == ROLLERS else (0.0, 0.0, 0.0)
    if beam.kind in (ELIMINATED, BASE):
        acceleration[first:] = np.linalg.solve(M[first:, first:], force[first:])
    else:
        along_friction = np.zeros(m)
        acts = sliding_share(float(rate[s_at].real), slider.friction_speed)
        if slider.friction > 0.0 or slider.friction_force > 0.0:
            arm, slides, along_friction = _way_of_friction(beam, here, q[0], partial)
        if beam.kind == ROLLERS:
            in_line, of_force = beam.constraint.inertia, -1.0
            wanted = -law - beam.constraint.inertia * float(remainder[gap_at].real)
        else:
            r, in_line, of_force = beam.constraint.stabilization, 1.0, 0.0
            wanted = -float(remainder[gap_at].real) - 2.0 * r * gap_rate - r**2 * here.gap
        # friction goes with the size of the force: of both signs the one that the solution has
        size, agreeing = m - first, []
        for sign in (1.0, -1.0):
            system = np.zeros((size + 1, size + 1))
            system[:size, :size] = M[first:, first:]
            system[:size, size] = (spread - slider.friction * sign * acts * along_friction)[first:]
            system[size, :size], system[size, size] = in_line * row[first:], of_force
            loads = force + slider.friction_force * acts * along_friction
            solved = np.linalg.solve(system, np.append(loads[first:], wanted))
            if solved[size] * sign >= 0.0:
                agreeing.append(solved)
        (solved,) = agreeing
        acceleration[first:], contact = solved[:size], float(solved[size])
        rubbing = (slider.friction_force + slider.friction * abs(contact)) * acts

    # the slider on the follower: of an eliminated one a virtual turn about P, shape and place of contact kept, tells the force
    total = acceleration @ partial + remainder
    moment = float(mass @ np.imag(np.conj(present[bodies]) * (total[bodies] - g)))
    moment += tip.inertia * total[alpha_end].real + scene.base.inertia * total[q2_at].real + at_hinge
    moment -= (complex(present[N + 1]).conjugate() * tool).imag
    slider_moment = tangential = torque = drive_power = 0.0
    tangent, lever, pull, at_crank = 0.0j, 0.0j, 0.0j, 0.0j
    if isinstance(scene, Mechanism):
        tangent = cmath.exp(1j * (here.turn + here.q2))
        piece = beam.slider_piece
        lever = here.frame * complex(here.z.at(here.s, piece))
        if slider_inertia > 0.0:
            curvature = float(here.psi.slope(here.s, piece))
            slider_moment = -slider_inertia * total[at_slider].real / (1.0 - here.gap * curvature)
            tangential = -slider_moment * curvature
        tangential += rubbing / slides
        slider_moment += arm * rubbing / slides
        if beam.kind == ELIMINATED:
            turned = (lever.conjugate() * tangent).imag
            contact = (moment - slider_moment - tangential * turned) / (lever.conjugate() * 1j * tangent).imag
        crank_direction = cmath.exp(1j * q[0])
        pull = (contact * 1j + tangential) * tangent
        torque = ((1j * crank_direction).conjugate() * (crank_length * pull - crank_moment * g)).real
        if isinstance(drive, TorqueDrive):
            torque = drive.torque
        drive_power = torque * u[0]
        at_crank = crank_moment * (1j * acceleration[0] - u[0] ** 2) * crank_direction - (crank.mass + slider.mass) * g + pull
    else:
        torque, drive_power = moment, moment * float(rate[q2_at].real)

    drive_power += float((tool.conjugate() * rate[N + 1]).real)
    power = crank_damping * u[0] ** 2 + at_hinge * q2_rate + float(dx @ (damping_moment * bending_rate)) + lost
    power += rubbing * float(rate[s_at].real)
    power += follower.damping * float(dx @ (beam.damps_along * rate[relative].real ** 2 + rate[relative].imag ** 2))
    strain = here.strain_energy + stored
    kinetic = 0.5 * float(np.sum(mass * np.abs(rate[bodies]) ** 2)) + 0.5 * crank_inertia * u[0] ** 2
    kinetic += 0.5 * sum(J * rate[which].real ** 2 for which, J in turning if J > 0.0)
    kinetic += 0.5 * beam.constraint.inertia * gap_rate**2
    d = scene.pivot_distance if isinstance(scene, Mechanism) else 0.0
    gravity = float(present[gravity_at].real) - (follower.mass_per_length * L + tip.mass) * g.real * d
    joint_power = -contact * float(spread @ u)
    tip_normal = 1j * cmath.exp(1j * present[alpha_end].real)
    at_pivot = complex(mass @ (total[bodies] - g)) - tool - pull
    shown = {
        "pivot_force_x": at_pivot.real,
        "pivot_force_y": at_pivot.imag,
        "crank_force_x": at_crank.real,
        "crank_force_y": at_crank.imag,
        "crank_angle": q[0],
        "crank_speed": u[0],
        "tip_acceleration": float((tip_normal.conjugate() * total[N + 1]).real),
        "slider_force": contact,
        "crank_torque": torque,
        "kinetic_energy": kinetic,
        "strain_energy": strain,
        "gravity_energy": gravity,
        "constraint_gap": abs(here.gap),
        "gap_rate": gap_rate,
        "joint_power": joint_power,
    }
    # loads per length and of the tip body, in frame B
    of_frame = 1.0 / here.frame
    load = -follower.mass_per_length * of_frame * (total[:N] - g) - follower.damping * drift
    of_tip = -tip.mass * of_frame * (total[N] - g), -tip.inertia * total[alpha_end].real
    at_contact = (contact * 1j + tangential) * tangent * of_frame, slider_moment
    shown |= _recovered(beam, here, q[0], load, of_tip, at_contact, tool * of_frame, delay * bending_rate)
    return Motion(
        configuration=here,
        q2_rate=q2_rate,
        s_rate=float(rate[s_at].real),
        gap_rate=gap_rate,
        partial_q2=partial[:, q2_at].real,
        partial_s=partial[:, s_at].real,
        partial_gap=row,
        spread=spread,
        q2_remainder=float(remainder[q2_at].real),
        s_remainder=float(remainder[s_at].real),
        gap_remainder=float(remainder[gap_at].real),
        points=x,
        partial_velocity=partial[:, :N] * of_frame,
        acceleration_remainder=remainder[:N] * of_frame,
        mass_matrix=M,
        force=force,
        acceleration=acceleration,
        dissipated_power=float(power),
        joint_power=joint_power,
        drive_power=float(drive_power),
        shown=shown,
    )


def _way_of_friction(beam: PlainBeam, here: Configuration, q1: float, partial: Complex) -> tuple[float, float, Array]:
    """What a unit of friction against the slider's way does.

    A slider without mass hands the follower a force that passes through the crank tip, which carries the opposite one.

    Returns:
        The arm (m) of the force along the tangent about the foot on the line; how far the crank tip gets along the tangent, on the
        standing follower, for a unit of the slider's way; and the generalised force of a unit of friction for every speed.
    """
    assert isinstance(beam.scene, Mechanism)
    piece, edges, N = beam.slider_piece, here.psi.edges, len(_points(here.psi.edges)[0])

    def tip_at(ds: float) -> Complex:
        """The crank tip in frame B if the slider advances, the gap kept."""
        place, angle = here.z.at(here.s + ds, piece), here.psi.at(here.s + ds, piece)
        return np.array([place + 1j * here.gap * np.exp(1j * angle)])

    along = cmath.exp(1j * here.turn)
    from_foot = complex(tip_at(0.0)[0]) - complex(here.z.at(here.s, piece))
    arm = (from_foot.conjugate() * along).imag
    slides = (along.conjugate() * complex(derivative(tip_at, 1e-3 * here.s)[0])).real
    tangent, crank = along * here.frame, 1j * beam.scene.crank.length * cmath.exp(1j * q1)
    found = []
    for k, one in enumerate(partial):
        of_line = complex(Line.through(edges, one[:N]).at(here.s, piece)) - (crank if k == 0 else 0.0)
        turns = Line.through(edges, one[2 * N + 2 : 3 * N + 2].real).at(here.s, piece)
        found.append(((tangent.conjugate() * of_line).real + arm * turns) / slides)
    return arm, slides, np.array(found)


def _recovered(
    beam: PlainBeam,
    here: Configuration,
    q1: float,
    load: Complex,
    of_tip: tuple[complex, float],
    at_slider: tuple[complex, float],
    of_tool: complex,
    late: Array,
) -> dict[str, float]:
    """Bending by the loads outboard, and the line that it makes.

    Args:
        beam: gives the scene.
        here: the configuration on which the loads act.
        q1: crank angle.
        load: per length at the Gauss points, N/m, frame B.
        of_tip: force of the tip body (N) and its moment about its own centre (N m).
        at_slider: the slider's force (N) and moment (N m) on the follower.
        of_tool: force on the flexible end (N), frame B.
        late: by how much the curvature stays behind that of the moment at the Gauss points, 1/m.
    """
    follower, tip, edges = beam.scene.follower, beam.scene.tip_body, here.psi.edges
    x, L, last = _points(edges)[0], follower.length, len(edges) - 2
    z = here.z.on_pieces_of(edges)
    inboard, about_P = Line.through(edges, load).integral(), Line.through(edges, np.imag(np.conj(z) * load)).integral()
    F, G = inboard.at(L, last), about_P.at(L, last)
    centre = complex(here.z.at(L, last)) + tip.center_of_mass * cmath.exp(1j * float(here.psi.at(L, last)))
    place = complex(here.z.at(here.s, beam.slider_piece))

    def moment(x: Array, z: Complex) -> Array:
        """Of all that acts outboard of the points."""
        outboard = G - about_P.everywhere(x) - np.imag(np.conj(z) * (F - inboard.everywhere(x)))
        outboard += np.imag(np.conj(centre - z) * of_tip[0]) + of_tip[1] + np.imag(np.conj(complex(here.z.at(L, last)) - z) * of_tool)
        return np.asarray(outboard + (x < here.s) * (np.imag(np.conj(place - z) * at_slider[0]) + at_slider[1]), dtype=np.float64)

    bent = moment(x, z) / follower.bending_stiffness - late
    gauges, twelfths = np.array(follower.strain_gauges), np.asarray(L * np.arange(1, 12) / 12.0, dtype=np.float64)
    at_s = np.array([here.s])
    moments = moment(twelfths, here.z.everywhere(twelfths))
    curvature = moment(gauges, here.z.everywhere(gauges)) / follower.bending_stiffness - Line.through(edges, late).everywhere(gauges)
    strains = 0.5 * follower.thickness * curvature
    psi = Line.through(edges, bent).integral()
    line = Line.through(edges, np.exp(1j * psi.on_pieces_of(edges))).integral()
    end, q2, s = complex(line.at(L, last)), here.q2, here.s
    if isinstance(beam.scene, Mechanism):
        # one step of Newton's method along the tangent, the gap kept; then the direction of what it gives
        tangent = cmath.exp(1j * float(psi.at(s, beam.slider_piece)))
        beside, tip_place = complex(line.at(s, beam.slider_piece)) + 1j * here.gap * tangent, beam.crank_tip(q1)
        step = 0.5 * (abs(tip_place) ** 2 - abs(beside) ** 2) / (beside.conjugate() * tangent).real
        s += step
        q2 = math.pi + cmath.phase(-tip_place / (beside + step * tangent))
    d = beam.scene.pivot_distance if isinstance(beam.scene, Mechanism) else 0.0
    tip_place = d + cmath.exp(1j * q2) * end
    return {
        "follower_angle": q2,
        "slider_position": s,
        "tip_x": tip_place.real,
        "tip_y": tip_place.imag,
        "tip_deflection": end.imag,
        **{f"shape_{k:02d}": place.imag for k, place in enumerate(line.everywhere(twelfths), start=1)},
        **{f"moment_{k:02d}": float(found) for k, found in enumerate(moments, start=1)},
        "moment_slider": float(moment(at_s, here.z.everywhere(at_s))[0]),
        **{f"strain_{k + 1}": float(strain) for k, strain in enumerate(strains)},
    }
