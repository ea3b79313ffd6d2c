"""A step of Gauss collocation, whose nodes lie beside a singular position: it solves the equations only where they have a solution."""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator

from quickreturn.plugins.derive.compiled import CompiledEquations

Array = NDArray[np.float64]

#: Nodes of a passage, an even number: none is in the middle. Its error is of the order of twice as many.
NODES: Final = 8
#: Farthest a node is moved to close the loops, over the tolerance of the integration, in a passage that counts as smooth.
MOVED: Final = 10.0
#: Rounding of places in a passage, over their sizes: some 1e-15 divided by the square of the smallest singular value at a node, 0.003.
CLEAN: Final = 1e-10
#: Part of a step at its beginning where states are not put on the loops once more: they begin on them, and rounding would move them.
LEAST: Final = 0.01

_X: Final = legendre.leggauss(NODES)[0]
#: Values at the nodes to coefficients of their polynomial.
_SERIES: Final = np.linalg.inv(legendre.legvander(_X, NODES - 1))


class Passage(NamedTuple):
    """A step across a singular position."""

    times: Array  # s, of its beginning, its nodes and its end, shape (NODES + 2,); without the beginning where the motion begins with it
    states: Array  # the states there, shape (len(times), size of a state)
    at: Callable[[float], Array]  # the state at any time between
    singular: float  # time of the singular position, s; before 0 where the motion only comes from one
    since: float  # time after which it holds, s; -inf where the motion begins with it, and the state at time 0 is as singular

    def between(self, values: Array, times: Array) -> Array:
        """Values at the passage's times, shape (len(times), columns), interpolated to others."""
        return np.asarray(BarycentricInterpolator(self.times, values)(times))


class Collocation:
    """Steps of Gauss collocation along the motion of a model.

    Args:
        model: the compiled equations.
        p: values of the parameters, SI.
        tolerance: that of the integration.
    """

    def __init__(self, model: CompiledEquations, p: Array, tolerance: float) -> None:
        self._model, self._p, self._tolerance = model, p, tolerance
        self._sizes = np.array([c.size for c in model.system.coordinates])

    def step(
        self, time: float, y: Array, length: float, v: Array | None = None, seek: Sequence[int] = (), turn: Sequence[int] = ()
    ) -> Passage | None:
        """A step of a given length from a state, without the time of the singular position; None if the motion is not smooth over it.

        The rates v are given where the motion begins with it. There the coordinates `seek` and rates `turn` are corrected until the nodes
        agree with the loops; all others stay.
        """
        e, n, half = self._model.equations, len(self._sizes), 0.5 * length
        times = time + half * (_X + 1.0)
        q = y[:n].copy()
        q, v = (q, v.copy()) if v is not None else self._closed(time, q, self._speeds(time, y))[:2]
        a = np.tile(self._acceleration(time, q, v), (NODES, 1))

        def at(x: Array) -> tuple[Array, Array]:
            series = _SERIES @ a
            places = q + half * np.multiply.outer(x + 1.0, v) + half**2 * legendre.legval(x, legendre.legint(series, 2, lbnd=-1)).T
            return places, v + half * legendre.legval(x, legendre.legint(series, lbnd=-1)).T

        last_change = np.inf
        for _ in range(30):
            places, speeds = at(_X)
            nodes = [self._closed(t, place, speed, seek) for t, place, speed in zip(times, places, speeds, strict=True)]
            shift = np.polynomial.polynomial.polyfit(_X + 1.0, np.array([q_ for q_, *_ in nodes]) - places, 1) if seek else np.zeros((2, n))
            q[list(seek)] += shift[0, list(seek)]
            v[list(turn)] += shift[1, list(turn)] / half
            new = np.array([self._acceleration(t, *each) for t, (*each, _) in zip(times, nodes, strict=True)])
            if not np.all(np.isfinite(new)):
                return None
            change, a = max(np.max(np.abs(new - a) / self._sizes) * length**2, np.max(np.abs(shift) / self._sizes)), new
            stays = change > 0.5 * last_change
            if change < 0.01 * self._tolerance or (stays and change < max(self._tolerance, CLEAN)):
                break  # in the second case only rounding is left
            if stays:
                return None
            last_change = change
        else:
            return None
        places, speeds = at(np.array([1.0]))
        end = self._closed(time + length, places[0], speeds[0], seek)
        if max(moved for *_, moved in [*nodes, end]) > max(MOVED * self._tolerance, CLEAN):
            return None
        inner = np.array([np.concatenate([q_, v_[e.free], y[-2:]]) for q_, v_, _ in nodes])
        power = np.array([self._model.rates(t, each, self._p)[-2:] for t, each in zip(times, inner, strict=True)])

        def integrals(x: Array) -> Array:
            return np.asarray(y[-2:] + half * legendre.legval(x, legendre.legint(_SERIES @ power, lbnd=-1)).T)

        def state(t: float) -> Array:
            x = np.array([(t - time) / half - 1.0])
            (place,), (speed,) = at(x)
            if t - time > LEAST * length:
                place, speed, _ = self._closed(t, place, speed, seek)
            return np.concatenate([place, speed[e.free], integrals(x)[0]])

        inner[:, -2:] = integrals(_X)
        last = np.concatenate([end[0], end[1][e.free], integrals(np.array([1.0]))[0]])
        return Passage(np.array([time, *times, time + length]), np.vstack([y, inner, last]), state, np.nan, time)

    def _speeds(self, time: float, y: Array) -> Array:
        """All speeds, from those that the state contains."""
        n, free = len(self._sizes), self._model.equations.free
        v = np.zeros(n)
        v[free] = y[n:-2]
        if len(free) < n:
            G = self._model.jacobian(time, y[:n], self._p)
            given = [k for k in range(n) if k not in free]
            v[given] = np.linalg.solve(G[:, given], -G @ np.append(v, 1.0))
        return v

    def _closed(self, time: float, q: Array, v: Array, only: Sequence[int] = ()) -> tuple[Array, Array, float]:
        """The nearest coordinates that close the loops, speeds that keep them closed, and the largest move over its coordinate's size.

        `only`: the coordinates that may move; none: all.
        """
        n, begin = len(q), q
        sizes = self._sizes * np.isin(np.arange(n), only) if only else self._sizes
        for _ in range(10):
            gap, G = self._model.motion(time, q, v, self._p)[:2]
            step = sizes * np.linalg.lstsq(G[:, :n] * sizes, -gap, rcond=None)[0]
            q = q + step
            if np.max(np.abs(step) / self._sizes) < 1e-15:
                break
        opening = G @ np.append(v, 1.0)
        v = v - sizes * np.linalg.lstsq(G[:, :n] * sizes, opening, rcond=None)[0]
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
