"""Watches how well the loops determine the motion, and passes positions where they do not.

A position is singular where the Jacobian G of the loops loses rank: rods in line, or a dead point of the coordinates that the loops give.
There the equations of motion divide by zero, although the motion itself is smooth: it goes on as its velocity points. A passage is one step
of Gauss collocation from one side to the other. Its nodes lie beside the singular position, and each is put on the loops; so no equation
is solved where it has no solution, and a motion that turns off, or ends there, is told from one that passes.
"""

from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator

from quickreturn.derive.compiled import CompiledEquations
from quickreturn.derive.units import DescriptionError, in_si

Array = NDArray[np.float64]

#: Smallest singular value of the scaled Jacobian below which a passage is tried. The scales make the largest one about 1.
NEAR: Final = 0.05
#: Factor between one trial and the next, nearer one: a fast vibration is smooth over short passages only.
NEARER: Final = 0.3
#: Smallest singular value at which the motion ends. The relative rounding of an acceleration is 1e-16 over its square.
SINGULAR: Final = 1e-6
#: Number of coordinates that tell the place, at most.
NAMED: Final = 6
#: Nodes of a passage, an even number: none is in the middle. Its error is of the order of twice as many.
NODES: Final = 8
#: Farthest a node is moved to close the loops, over the tolerance of the integration, in a passage that counts as smooth.
MOVED: Final = 10.0
#: Rounding of places in a passage, over their sizes: some 1e-15 divided by the square of the smallest singular value at a node, 0.003.
CLEAN: Final = 1e-10

_X: Final = legendre.leggauss(NODES)[0]
#: Values at the nodes to coefficients of their polynomial.
_SERIES: Final = np.linalg.inv(legendre.legvander(_X, NODES - 1))


class Passage(NamedTuple):
    """A step across a singular position.

    Attributes:
        times: s, of its beginning, its nodes and its end, shape (NODES + 2,).
        states: the states there, shape (NODES + 2, size of a state).
        at: the state at any time between.
        singular: time of the singular position, s.
    """

    times: Array
    states: Array
    at: Callable[[float], Array]
    singular: float

    def between(self, values: Array, times: Array) -> Array:
        """Values at the passage's times, shape (NODES + 2, columns), interpolated to others."""
        return np.asarray(BarycentricInterpolator(self.times, values)(times))


class Watch:
    """The condition of a system's loops along a motion.

    Args:
        model: the compiled equations.
        p: values of the parameters, SI.
        tolerance: that of the integration.
        passes: whether to pass singular positions; otherwise the motion ends there.

    Attributes:
        smallest: smallest singular value of the scaled Jacobian in the present state.
    """

    def __init__(self, model: CompiledEquations, p: Array, tolerance: float, passes: bool = True) -> None:
        self._model, self._p, self._tolerance, self._passes = model, p, tolerance, passes
        loops, e = model.system.loops, model.equations
        self._rows = np.repeat(np.arange(len(loops)), [loop.gap.numel() for loop in loops])
        n = e.q.numel()
        # of a projection the block that is inverted, otherwise all
        self._columns = [k for k in range(n) if k not in e.free] or list(range(n))
        self._reach, self._size = np.zeros(len(self._columns)), np.zeros(len(loops))
        self._sizes = np.array([c.size for c in model.system.coordinates])
        self.smallest = 1.0
        nothing: Array = np.zeros(0)
        self._left, self._right, self._seen, self._scales = nothing, nothing, nothing, nothing
        self._next = NEAR if passes else SINGULAR

    def begin(self, y: Array) -> None:
        """Refuse a singular start."""
        if len(self._rows):
            self._grow(G := self._block(0.0, y))
            self._look(G / self._scales)
            if not self.smallest > SINGULAR:
                raise DescriptionError(
                    f"{self.loops()} of {self._model.system.name!r} cannot determine the motion at the start: the position is singular, or"
                    " one loop repeats another; start beside it, or leave out the loop that repeats"
                )

    def loops(self) -> str:
        """The loops that lose rank, in words."""
        names = [repr(self._model.system.loops[k].name) for k in self._losing()]
        return f"loop {names[0]}" if len(names) == 1 else f"loops {', '.join(names[:-1])} and {names[-1]}"

    def _losing(self) -> list[int]:
        """Indices of the loops that lose rank."""
        shares = np.array([np.linalg.norm(self._left[self._rows == k]) for k in range(len(self._model.system.loops))])
        return np.flatnonzero(shares > 0.1 * shares.max()).tolist()

    def follows(self, time: float, y: Array) -> bool:
        """Whether a later state may replace the present one: not if a singular position comes much nearer, or is left behind."""
        if not len(self._rows):
            return True
        G = self._block(time, y)
        if np.linalg.norm(G / self._scales - self._seen) < 0.5 * self.smallest - NEAR:
            return True  # no singular value changes by more than that
        if not self._left @ (G / self._scales) @ self._right > NEARER * self.smallest:
            return False
        self._grow(G)
        self._look(G / self._scales)
        self._next = self._next if self.smallest < NEAR else (NEAR if self._passes else SINGULAR)
        return True

    def passage(self, time: float, y: Array, before: Callable[[float], Array], step: float) -> Passage | None:
        """A step across the singular position ahead, if one is near and the motion passes it.

        Args:
            time: s.
            y: the present state.
            before: states of the last integration step, by time.
            step: its length, s.

        Raises:
            DescriptionError: the motion cannot be continued; the sentence says when, and names the loops.
        """
        if not len(self._rows) or self.smallest > self._next:
            return None
        earlier = time - 0.1 * step
        falls = (self._signed(earlier, before(earlier)) - self._signed(time, y)) / (time - earlier)
        found = self._across(time, y, 2.0 * self.smallest / falls) if falls > 0.0 and self._passes else None
        if found is None:
            self._next = NEARER * self.smallest
            if self.smallest < SINGULAR / NEARER:
                self.ends(time, y)
        else:
            self._next = NEAR
            self._look(self._block(found.times[-1], found.states[-1]) / self._scales)
        return found

    def ends(self, time: float, y: Array) -> None:
        """Raise DescriptionError: the motion ends in a singular position, near the state y."""
        moved = self._model.jacobian(time, y[: len(self._sizes)], self._p)[np.isin(self._rows, self._losing()), :-1]
        coordinates = [(c, x) for c, x, column in zip(self._model.system.coordinates, y, moved.T, strict=False) if np.any(column)][:NAMED]
        place = ", ".join(f"{c.name} = {x / in_si(c.unit)[0]:.4g} {c.unit}" for c, x in coordinates)
        why = "and do not determine how it goes on" if self._passes else "where sensitivities, and drives that act elsewhere, end"
        raise DescriptionError(
            f"the motion of {self._model.system.name!r} comes to a singular position at {time:.6g} s, with {place}: there {self.loops()}"
            f" {'loses' if len(self._losing()) == 1 else 'lose'} rank"
            f" {why}; shorten the duration, or change a length, the start or the loops"
        )

    def _block(self, time: float, y: Array) -> Array:
        """The Jacobian of the loops by the coordinates that count."""
        return self._model.jacobian(time, y[: len(self._sizes)], self._p)[:, self._columns]

    def _grow(self, G: Array) -> None:
        """Take the largest norms of columns and of loops so far as scales: in a singular position a loop's own may vanish."""
        self._reach = np.maximum(self._reach, np.linalg.norm(G, axis=0))
        reach = np.where(self._reach > 0.0, self._reach, 1.0)
        size = [np.linalg.norm((G / reach)[self._rows == k]) for k in range(len(self._size))]
        self._size = np.maximum(self._size, size)
        self._scales = np.outer(np.where(self._size > 0.0, self._size, 1.0)[self._rows], reach)

    def _look(self, A: Array) -> None:
        """Find the smallest singular value of the scaled Jacobian, and its vectors."""
        left, singular, right = np.linalg.svd(A)
        self._left, self._right, self._seen = left[:, -1], right[min(A.shape) - 1], A
        self.smallest = float(singular[-1]) if len(A) <= A.shape[1] else 0.0

    def _signed(self, time: float, y: Array) -> float:
        """The smallest singular value in another state, which changes its sign in a singular position."""
        return float(self._left @ (self._block(time, y) / self._scales) @ self._right)

    def _across(self, time: float, y: Array, length: float) -> Passage | None:
        """A collocation step, or None if the motion is not smooth over it."""
        e, n, half = self._model.equations, len(self._sizes), 0.5 * length
        times = time + half * (_X + 1.0)
        q, v, _ = self._closed(time, y[:n], self._speeds(time, y))
        a = np.tile(self._acceleration(time, q, v), (NODES, 1))

        def at(x: Array) -> tuple[Array, Array]:
            series = _SERIES @ a
            places = q + half * np.multiply.outer(x + 1.0, v) + half**2 * legendre.legval(x, legendre.legint(series, 2, lbnd=-1)).T
            return places, v + half * legendre.legval(x, legendre.legint(series, lbnd=-1)).T

        last_change = np.inf
        for _ in range(30):
            nodes = [self._closed(t, *each) for t, *each in zip(times, *at(_X), strict=True)]
            new = np.array([self._acceleration(t, *each) for t, (*each, _) in zip(times, nodes, strict=True)])
            if not np.all(np.isfinite(new)):
                return None
            change, a = np.max(np.abs(new - a) / self._sizes) * length**2, new
            stays = change > 0.5 * last_change
            if change < 0.01 * self._tolerance or (stays and change < max(self._tolerance, CLEAN)):
                break  # in the second case only rounding is left
            if stays:
                return None
            last_change = change
        else:
            return None
        places, speeds = at(np.array([1.0]))
        end = self._closed(time + length, places[0], speeds[0])
        if max(moved for *_, moved in [*nodes, end]) > max(MOVED * self._tolerance, CLEAN):
            return None
        inner = np.array([np.concatenate([q_, v_[e.free], y[-2:]]) for q_, v_, _ in nodes])
        power = np.array([self._model.rates(t, each, self._p)[-2:] for t, each in zip(times, inner, strict=True)])

        def integrals(x: Array) -> Array:
            return np.asarray(y[-2:] + half * legendre.legval(x, legendre.legint(_SERIES @ power, lbnd=-1)).T)

        def state(t: float) -> Array:
            x = np.array([(t - time) / half - 1.0])
            (place,), (speed,) = at(x)
            place, speed, _ = self._closed(t, place, speed)
            return np.concatenate([place, speed[e.free], integrals(x)[0]])

        inner[:, -2:] = integrals(_X)
        signed = [self._signed(t, each) for t, each in zip(times, inner, strict=True)]
        singular = float(BarycentricInterpolator(signed, times)(0.0))
        last = np.concatenate([end[0], end[1][e.free], integrals(np.array([1.0]))[0]])
        return Passage(np.array([time, *times, time + length]), np.vstack([y, inner, last]), state, singular)

    def _speeds(self, time: float, y: Array) -> Array:
        """All speeds, from those that the state contains."""
        n, free = len(self._sizes), self._model.equations.free
        v = np.zeros(n)
        v[free] = y[n:-2]
        if len(free) < n:
            G = self._model.jacobian(time, y[:n], self._p)
            v[self._columns] = np.linalg.solve(G[:, self._columns], -G @ np.append(v, 1.0))
        return v

    def _closed(self, time: float, q: Array, v: Array) -> tuple[Array, Array, float]:
        """The nearest coordinates that close the loops, speeds that keep them closed, and the largest move over its coordinate's size."""
        n, begin = len(q), q
        for _ in range(10):
            gap, G = self._model.motion(time, q, v, self._p)[:2]
            step = self._sizes * np.linalg.lstsq(G[:, :n] * self._sizes, -gap, rcond=None)[0]
            q = q + step
            if np.max(np.abs(step) / self._sizes) < 1e-15:
                break
        opening = G @ np.append(v, 1.0)
        v = v - self._sizes * np.linalg.lstsq(G[:, :n] * self._sizes, opening, rcond=None)[0]
        return q, v, float(np.max(np.abs(q - begin) / self._sizes))

    def _acceleration(self, time: float, q: Array, v: Array) -> Array:
        """The accelerations that the loops ask for, and along the directions that they leave those of the forces."""
        n, D = len(q), self._sizes
        _, G, bias, M, Q = self._model.motion(time, q, v, self._p)
        left, singular, right = np.linalg.svd(G[:, :n] * D)
        rank = int(np.sum(singular > 1e-12 * singular[0]))
        held = -right[:rank].T @ ((left[:, :rank].T @ bias) / singular[:rank])
        Z = right[rank:].T
        M, Q = (M * D).T * D, Q * D
        return np.asarray(D * (held + Z @ np.linalg.solve(Z.T @ M @ Z, Z.T @ (Q - M @ held))))
