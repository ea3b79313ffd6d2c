"""Watches how well the loops determine a motion, and ends it where they do not.

A position is singular where the Jacobian G of the loops loses rank: rods in line, or a dead point of the coordinates that the loops give.
There the equations of motion divide by zero, and a step across would lead to any other motion.
"""

from typing import Final, NoReturn

import numpy as np

from quickreturn.plugins.derive.compiled import CompiledEquations
from quickreturn.plugins.derive.units import Array, DescriptionError, in_si

#: Smallest singular value of the scaled Jacobian that counts as singular. The scales make the largest one about 1. The relative rounding of
#: an acceleration is 1e-16 over its square, so up to there it is below the usual tolerance.
SINGULAR: Final = 1e-3
#: Smallest singular value below which a method that finds no step is stuck at a singular position.
STUCK: Final = 0.05
#: Least part of the smallest singular value that a step must leave: a longer one may cross a singular position.
LEFT: Final = 0.3
#: Number of coordinates that tell the place, at most.
NAMED: Final = 6


class Watch:
    """The condition of a system's loops along a motion.

    Args:
        model: the compiled equations.
        p: values of the parameters, SI.
        y: the state at time 0, which is the first part of the integrated one.

    Raises:
        DescriptionError: the loops do not determine the motion at the start.
    """

    def __init__(self, model: CompiledEquations, p: Array, y: Array) -> None:
        self._model, self._p = model, p
        loops, e = model.system.loops, model.equations
        self._rows = np.repeat(np.arange(len(loops)), [loop.gap.numel() for loop in loops])
        n = e.q.numel()
        # of a projection the block that is inverted, otherwise all
        self._columns = [k for k in range(n) if k not in e.free] or list(range(n))
        self._reach, self._size = np.zeros(len(self._columns)), np.zeros(len(loops))
        if len(self._rows):
            self._look(self._block(0.0, y))
            if self._smallest <= SINGULAR:
                raise DescriptionError(
                    f"{self._losing()} of {model.system.name!r} cannot determine the motion at the start: the position is singular, or one"
                    " loop repeats another; start beside it, or leave out the loop that repeats"
                )

    def follows(self, time: float, y: Array) -> bool:
        """Whether the state y may replace the last one: not if a singular position may lie between.

        Raises:
            DescriptionError: the motion has come to a singular position.
        """
        if not len(self._rows):
            return True
        G = self._block(time, y)
        # the smallest singular value is u G v, which changes its sign in a singular position
        if not self._left @ (G / self._scales) @ self._right > LEFT * self._smallest:
            return False
        self._look(G)
        if self._smallest <= SINGULAR:
            self._end(time, y)
        return True

    def stuck(self, time: float, y: Array) -> None:
        """Raise DescriptionError if a method finds no step from the state y because a singular position is near."""
        if len(self._rows) and self._smallest < STUCK:
            self._end(time, y)

    def _end(self, time: float, y: Array) -> NoReturn:
        moved = self._model.jacobian(time, y[: self._model.equations.q.numel()], self._p)[np.isin(self._rows, self._lost()), :-1]
        coordinates = [(c, x) for c, x, column in zip(self._model.system.coordinates, y, moved.T, strict=False) if np.any(column)][:NAMED]
        place = ", ".join(f"{c.name} = {x / in_si(c.unit)[0]:.4g} {c.unit}" for c, x in coordinates)
        raise DescriptionError(
            f"the motion of {self._model.system.name!r} comes to a singular position at {time:.6g} s, with {place}: there {self._losing()}"
            " do not determine how it goes on; shorten the duration, or change a length, the start or the loops"
        )

    def _lost(self) -> list[int]:
        """Indices of the loops that lose rank."""
        shares = np.array([np.linalg.norm(self._left[self._rows == k]) for k in range(len(self._size))])
        return np.flatnonzero(shares > 0.1 * shares.max()).tolist()

    def _losing(self) -> str:
        names = [repr(self._model.system.loops[k].name) for k in self._lost()]
        return f"loop {names[0]}" if len(names) == 1 else f"loops {', '.join(names[:-1])} and {names[-1]}"

    def _block(self, time: float, y: Array) -> Array:
        """The Jacobian of the loops by the coordinates that count."""
        return self._model.jacobian(time, y[: self._model.equations.q.numel()], self._p)[:, self._columns]

    def _look(self, G: Array) -> None:
        """Find the smallest singular value of the scaled Jacobian, and its vectors.

        The scales are the largest norms of columns and of loops so far: in a singular position a loop's own may vanish.
        """
        self._reach = np.maximum(self._reach, np.linalg.norm(G, axis=0))
        reach = np.where(self._reach > 0.0, self._reach, 1.0)
        self._size = np.maximum(self._size, [np.linalg.norm((G / reach)[self._rows == k]) for k in range(len(self._size))])
        self._scales = np.outer(np.where(self._size > 0.0, self._size, 1.0)[self._rows], reach)
        left, singular, right = np.linalg.svd(G / self._scales)
        self._left, self._right = left[:, -1], right[min(G.shape) - 1]
        self._smallest = float(singular[-1]) if len(G) <= G.shape[1] else 0.0
