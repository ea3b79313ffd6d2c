"""A clamped uniform rod with a mistake: its sags and frequencies; and what a record of its free vibration says of both."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.cases.conformance.checks import Array
from quickreturn.reference_model.follower import Follower

#: Number of frequencies that are compared.
COUNT: Final = 3
#: b of the modes of a clamped beam, 1 + cos b cosh b = 0 (Blevins, Formulas for Natural Frequency and Mode Shape, table 8-1).
ROOTS: Final = np.array([1.875104068711961, 4.694091132974175, 7.854757438237613])
#: Number of finite elements: cubic ones leave 1e-5 in the third frequency.
_ELEMENTS: Final = 16
#: Part of the largest singular value of the table of shifted records below which there is no further vibration ...
_NOISE: Final = 1e-6
#: ... largest number of them, and smallest amplitude that counts, over that of the largest.
_MOST: Final = 24
_AUDIBLE: Final = 2e-4
#: Part by which a factor may miss that of a mistake with a name; and by which a share of half a piece may miss it.
_NEAR: Final = 0.02
_HALF: Final = 0.125


@dataclass(frozen=True)
class Rod:
    """What a clamped rod shows: its sags, m, under its weight and by a force at its end, its frequencies, Hz; and its length, m."""

    weight: float
    force: float
    frequencies: Array
    length: float

    def over(self, other: "Rod") -> Array:
        """Sags and frequencies over those of another rod."""
        n = min(len(self.frequencies), len(other.frequencies))
        ours, theirs = (np.array([rod.weight, rod.force, *rod.frequencies[:n]]) for rod in (self, other))
        return ours / theirs

    def decisive(self, other: "Rod") -> Array:
        """Logarithms of what tells mistakes apart, over those of another rod: length, sags, two frequencies; NaN for what is not there."""
        sizes = np.full(5, np.nan)
        shown = np.append(self.length / other.length, self.over(other))[: len(sizes)]
        sizes[: len(shown)] = np.log(np.where(shown > 0.0, shown, np.nan))
        return sizes


def right(follower: Follower, gravity: float, mass: float) -> Rod:
    """Closed forms for small deflections, under `gravity` (m/s^2) and the weight of a `mass` (kg) at the end."""
    stiffness, length = follower.bending_stiffness, follower.length
    unit = math.sqrt(stiffness / follower.mass_per_length) / (2.0 * math.pi * length**2)
    weight = follower.mass_per_length * gravity * length**4 / (8.0 * stiffness)
    return Rod(weight, mass * gravity * length**3 / (3.0 * stiffness), ROOTS**2 * unit, length)


@dataclass(frozen=True)
class Mistake:
    """A rod that is not as asked for: factors on what it is made of, and two faults of its ends."""

    stiffness: float = 1.0
    mass: float = 1.0
    length: float = 1.0
    clamp: float = 0.0  # turn of the clamped end under a moment, over that of the rod's end, L / EI; negative: a piece there is rigid
    end: float = 0.0  # mass at the free end that is too much, over the rod's
    tip: float = 1.0  # factor on the mass that hangs there, where only its weight counts

    def acts(self, follower: Follower, gravity: float, mass: float) -> Rod:
        """The rod with this mistake, by cubic finite elements."""
        length, stiffness = self.length * follower.length, self.stiffness * follower.bending_stiffness
        density, h = self.mass * follower.mass_per_length, length / _ELEMENTS
        bend = stiffness / h**3 * np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
        inert = density * h / 420.0 * np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
        load = density * gravity * h * np.array([1 / 2, 1 / 12, 1 / 2, -1 / 12])
        K, M, F = (np.zeros((2 * _ELEMENTS + 2,) * n) for n in (2, 2, 1))
        for k in range(0, 2 * _ELEMENTS, 2):  # coordinates: deflection, and slope times h
            part = slice(k, k + 4)
            K[part, part] += bend
            M[part, part] += inert
            F[part] += load
        added = self.end * follower.mass_per_length * follower.length
        M[-2, -2] += added
        F[-2] += added * gravity
        at_end = np.zeros_like(F)
        at_end[-2] = self.tip * mass * gravity
        flexible, arms = np.zeros_like(K), np.full_like(F, h)
        flexible[2:, 2:], arms[0::2] = np.linalg.inv(K[2:, 2:]), h * np.arange(_ELEMENTS + 1)
        # the clamp's turn adds a flexibility in series, so that a negative one may be added as well
        flexible += self.clamp * follower.length / follower.bending_stiffness * np.outer(arms, arms)
        squares = np.sort(np.linalg.eigvals(flexible @ M).real)[::-1]
        frequencies = 1.0 / np.sqrt(np.maximum(squares[:COUNT], 1e-300)) / (2.0 * math.pi)
        return Rod(float((flexible @ F)[-2]), float((flexible @ at_end)[-2]), frequencies, length)


@dataclass(frozen=True)
class Ring:
    """A free vibration: where it comes to rest, and its modes by frequency."""

    rest: float
    frequencies: Array  # Hz
    rates: Array  # of decay, 1/s


def ring(signal: Array, step: float) -> Ring:
    """The exponentials in a record, by the matrix pencil (Hua and Sarkar, IEEE Trans. Acoustics, Speech, Signal Proc. 38 (1990) 814-824).

    Args:
        signal: the record, shape (n,).
        step: between two values, s.
    """
    columns = len(signal) // 3
    shifted = np.lib.stride_tricks.sliding_window_view(signal, columns)
    _, sizes, right_vectors = np.linalg.svd(shifted, full_matrices=False)
    modes = right_vectors[: min(_MOST, int(np.sum(sizes > _NOISE * sizes[0])))].T
    poles = np.linalg.eigvals(np.linalg.pinv(modes[:-1]) @ modes[1:]).astype(complex)
    poles = poles[np.abs(poles) > 1e-9]
    exponents = np.log(poles) / step
    basis = np.exp(np.outer(step * np.arange(len(signal)), exponents))
    sizes = np.linalg.lstsq(basis, signal.astype(complex), rcond=None)[0]
    resting = np.abs(exponents) < 0.2 / (step * len(signal))
    turning = np.flatnonzero((exponents.imag > math.pi / (step * len(signal))) & (np.abs(sizes) > 0.0))  # half a vibration or more
    turning = turning[np.abs(sizes[turning]) > _AUDIBLE * np.max(np.abs(sizes[turning]), initial=0.0)]
    loudest = turning[np.argsort(-np.abs(sizes[turning]))][:COUNT]
    loudest = loudest[np.argsort(exponents[loudest].imag)]
    return Ring(float(np.sum(sizes[resting]).real), np.abs(exponents[loudest]) / (2.0 * math.pi), -exponents[loudest].real)


def _sections(follower: Follower) -> Iterator[tuple[str, float]]:
    """Mistakes of the section: words -> factor on its second moment of area."""
    part = 3.0 * math.pi / 16.0
    yield "its second moment of area is that of a round section (pi d^4 / 64) in place of a rectangle (w t^3 / 12)", part
    yield "its second moment of area is that of a rectangle (d^4 / 12) in place of a round section (pi d^4 / 64)", 1.0 / part
    if follower.thickness is not None and follower.width is not None:
        across = follower.width / follower.thickness
        yield "its second moment of area is that of a round section whose diameter is the thickness", part / across
        yield "its second moment of area is that of a round section of the same area", 3.0 / math.pi * across
        yield "thickness and width are exchanged", across**2
    yield "its second moment of area takes the radius for the diameter", 1.0 / 16.0
    yield "its second moment of area takes the diameter for the radius", 16.0
    yield "it is that of a plate, 1 / (1 - 0.3^2)", 1.0 / 0.91
    yield "it is half of what it should be", 0.5
    yield "it is twice what it should be", 2.0


def staying_words(kind: str, amount: float, follower: Follower) -> tuple[str, str]:
    """A mistake that does not depend on the resolution, in words, and what to do."""
    if kind == "stiffness":
        near = [words for words, factor in _sections(follower) if abs(math.log(amount / factor)) < _NEAR]
        words = f"the bending stiffness is {amount:.4g} times as large"
        return (f"{words}: {near[0]}", "take EI as the scene gives it") if near else (words, "look for such a factor in E, I and EI/h")
    if kind in ("mass", "length", "tip"):
        what = {"mass": "mass per length", "length": "length", "tip": "mass at the end"}[kind]
        parts = 1.0 / abs(amount - 1.0) if amount != 1.0 else math.inf
        whole = kind == "length" and abs(parts - round(parts)) < _NEAR * parts and parts < 50.0
        count = f": one segment too {'many' if amount > 1.0 else 'few'}, with {parts:.0f} of them?" if whole else ""
        return f"the {what} is {amount:.4g} times as large{count}", "look for such a factor where it enters"
    if kind == "clamp":
        return f"the clamped end turns by {amount:.3g} L/EI times its moment", "clamp its place and its direction"
    return (
        f"the free end has {abs(amount):.3g} of the rod's mass {'more' if amount > 0.0 else 'less'} than it should",
        "look at the mass there",
    )


def by_piece_words(kind: str, amount: float, pieces: float) -> tuple[str, str]:
    """A mistake in proportion to the length of a piece, h = L/N, in words, and what to do; the amount is that with so many `pieces`."""
    many = (amount - getattr(Mistake(), kind)) * pieces
    if kind in ("stiffness", "mass", "length"):
        what = {"stiffness": "bending stiffness", "mass": "mass", "length": "length"}[kind]
        count = f"{'one segment' if abs(abs(many) - 1.0) < 2.0 * _HALF else f'{abs(many):.2g} of a segment'}"
        rule = "N segments have the length L/N; a joint between two of them has EI/h, one at the clamp 2 EI/h"
        return f"{count} too {'many' if many > 0.0 else 'few'} in its {what}: it is off by {many:+.2g}/N", rule
    if kind == "clamp":
        rule = "the joint at the clamp stands for half a piece: 2 EI/h, those between pieces EI/h"
        halved = "stiffness halved at the ends: " if abs(many - 0.5) < _HALF else ""
        more = f"{halved}the clamped end turns as if {many:.2g} of a piece (h = L/N) more were to bend there"
        return more if many > 0.0 else f"the first {-many:.2g} of a piece (h = L/N) does not bend", rule
    if kind == "end":
        words = "half the mass at the end" if many < 0.0 else "too much mass at the end"
        which = "more" if many > 0.0 else "less"
        return f"{words}: {abs(many):.2g} of a piece's mass {which} than there should be", "its node carries half a piece's mass"
    return f"the mass at the end is off by {many:+.2g}/N", "it does not depend on the number of pieces"
