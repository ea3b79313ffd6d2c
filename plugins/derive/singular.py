"""Watches how well the loops determine the motion, and passes positions where they do not.

A position is singular where the Jacobian G of the loops loses rank: rods in line, or a dead point of the coordinates that the loops give.
There the equations of motion divide by zero, although the motion itself is smooth: it goes on as its velocity points. A passage is one step
of Gauss collocation from one side to the other. Its nodes lie beside the singular position, and each is put on the loops; so no equation
is solved where it has no solution, and a motion that turns off, or ends there, is told from one that passes.
"""

from collections.abc import Callable, Sequence
from typing import Any, Final, NoReturn

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator

from quickreturn.plugins.derive.collocation import Collocation, Passage
from quickreturn.plugins.derive.compiled import CompiledEquations
from quickreturn.plugins.derive.units import DescriptionError, in_si

Array = NDArray[np.float64]

#: Smallest singular value of the scaled Jacobian below which a passage is tried. The scales make the largest one about 1.
NEAR: Final = 0.05
#: Factor between one trial and the next, nearer one: a fast vibration is smooth over short passages only.
NEARER: Final = 0.3
#: Smallest singular value at which the motion ends. The relative rounding of an acceleration is 1e-16 over its square.
SINGULAR: Final = 1e-6
#: Smallest singular value of a start below which the motion begins with a step away from it.
BESIDE: Final = 1e-3
#: Part of its size by which the fastest coordinate moves in the shortest step away from a start.
FIRST: Final = 1e-4
#: Part of a step away from a start within which a singular position counts as the start itself, for its time.
ROUNDED: Final = 1e-6
#: Number of coordinates that tell the place, at most.
NAMED: Final = 6


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
        self._model, self._p, self._passes, self._steps = model, p, passes, Collocation(model, p, tolerance)
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
        if self._begins_at(y) <= SINGULAR:
            self._refuse_start("the position is singular, or one loop repeats another; start beside it, or leave out the loop that repeats")

    def departure(self, y: Array, v: Array, seek: Sequence[int], turn: Sequence[int]) -> Passage | None:
        """A step away from a start in a singular position or close beside it; None if no such step is needed.

        Which way the motion goes on is seen at the nodes, not at the start: rates that no motion has cannot keep the loops closed there.

        Args:
            y: the state at time 0.
            v: all rates there.
            seek: coordinates that were not given, but found from the loops.
            turn: rates that were not given.

        Raises:
            DescriptionError: the position is singular, and no motion begins with these rates, or they are not all given.
        """
        beside = self._begins_at(y)
        if beside > BESIDE:
            return None
        still = float(np.max(np.abs(v) / self._sizes)) == 0.0
        missing = [c.name for k, c in enumerate(self._model.system.coordinates) if k in seek and not self._determined(y, seek)]
        missing += [c.rate_name for k, c in enumerate(self._model.system.coordinates) if k in turn and not self._determined(y, turn)]
        if self._passes and not still and (beside > SINGULAR or not missing):
            corrected = (seek, turn) if beside > SINGULAR and len(seek) >= len(self._rows) else ((), ())
            if found := self._away(y, v, *corrected):
                return found
        if beside > SINGULAR:
            return None
        why = "no smooth motion passes it with these rates; give those of one motion, or start beside it"
        if missing:
            why = f"give {', '.join(missing)} as well, or start beside it"
        if still or not self._passes:
            why = "nothing moves there; give rates, or start beside it" if still else "start beside it"
        if self._repeats(y):
            self._refuse_start("one loop repeats another; leave out the loop that repeats")
        return self._refuse_start(f"the position is singular; {why}")

    def _determined(self, y: Array, which: Sequence[int]) -> bool:
        """Whether the loops determine some coordinates, or their rates, from all others even in this state."""
        G = self._model.jacobian(0.0, y[: len(self._sizes)], self._p)[:, list(which)] * self._sizes[list(which)]
        singular = np.linalg.svd(G)[1]
        return len(which) <= len(G) and bool(singular[-1] > BESIDE * singular[0])

    def _refuse_start(self, why: str) -> NoReturn:
        raise DescriptionError(f"{self.loops()} of {self._model.system.name!r} cannot determine the motion at the start: {why}")

    def _begins_at(self, y: Array) -> float:
        """The smallest singular value at the start, 1 without loops."""
        if len(self._rows):
            self._grow(G := self._block(0.0, y))
            self._look(G / self._scales)
        return self.smallest

    def _repeats(self, y: Array) -> bool:
        """Whether the loops lose rank beside the start as well."""
        random = np.random.default_rng(0)
        beside = np.concatenate([y[: len(self._sizes)] + 0.1 * self._sizes * random.normal(size=len(self._sizes)), y[len(self._sizes) :]])
        singular = np.linalg.svd(self._block(0.0, beside) / self._scales)[1]
        return len(self._rows) > len(self._columns) or not singular[-1] > SINGULAR

    def _away(self, y: Array, v: Array, seek: Sequence[int], turn: Sequence[int]) -> Passage | None:
        """A step that begins in the state y and ends where the loops determine the motion."""
        q, found = y[: len(self._sizes)], None
        length = FIRST / float(np.max(np.abs(v) / self._sizes))
        for _ in range(30):  # until the loops' condition is good, or a coordinate has moved by half its size
            self._grow(G := self._block(length, np.concatenate([q + length * v, y[len(q) :]])))
            if np.linalg.svd(G / self._scales)[1][-1] > 2.0 * NEAR or length * float(np.max(np.abs(v) / self._sizes)) > 0.5:
                break
            length *= 2.0
        for _ in range(6):
            self._look(self._block(0.1 * length, np.concatenate([q + 0.1 * length * v, y[len(q) :]])) / self._scales)
            found = self._across(0.0, y, length, v, seek, turn)
            if found:
                break
            length *= NEARER
        if found:
            self._look(self._block(found.times[-1], found.states[-1]) / self._scales)
            here = 0.0 if abs(found.singular) < ROUNDED * found.times[-1] else found.singular
            found = found._replace(times=found.times[1:], states=found.states[1:], singular=here, since=-np.inf)
        else:
            self._begins_at(y)
        return found

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

    def _across(self, time: float, y: Array, length: float, *begin: Any) -> Passage | None:
        """A step of collocation, with the time of the singular position, or None if the motion is not smooth over it."""
        found = self._steps.step(time, y, length, *begin)
        if found is None:
            return None
        nodes = slice(1, -1)
        for _ in range(2):  # the second time with the singular vectors of the node that is nearest
            signed = [self._signed(t, each) for t, each in zip(found.times[nodes], found.states[nodes], strict=True)]
            nearest = 1 + int(np.argmin(np.abs(signed)))
            self._look(self._block(found.times[nearest], found.states[nearest]) / self._scales)
        return found._replace(singular=float(BarycentricInterpolator(signed, found.times[nodes])(0.0)))
