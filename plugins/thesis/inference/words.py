"""What the thesis says, as probabilities: how likely each statement is for a machine whose readings are known but for their errors.

A statement on the frequencies or amplitudes of several runs says that a ratio, simulation over machine, lies in a range in at least a share
of them. With independent errors of reading the number of runs that show it has the Poisson binomial distribution. What is read too high in
one half of every run, the bias between the halves, is common to all runs and is integrated out (Gauss and Hermite).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.polynomial.hermite_e import hermegauss
from scipy.special import ndtr

from quickreturn.plugins.thesis.experiment import Statement, axis_labels, statements
from quickreturn.plugins.thesis.inference.emulator import Emulated
from quickreturn.plugins.thesis.inference.study import EXAMPLE, RUNS
from quickreturn.reference_model.arrays import Array

#: Standard deviation of the reading of a frequency, and of the bias between the halves, relative (guesses; `weights.SETS` varies them).
READING: Final = 0.01
BIAS: Final = 0.01
#: Nodes of the integral over the bias.
NODES: Final = 7
#: Errors of the printed frequencies, Hz: of the fast vibration half of 1 / 63 ms, the resolution in a sixth of a turn of run 24; of 24 Hz.
RING: Final = 8.0
FIRST: Final = 1.5
#: Standard deviation of the logarithm of a peak over the largest label of its axis: the cubic's own peaks are 0.6 to 1.9 of the labels.
LABEL: Final = 0.4
#: Standard deviation of the reading of an amplitude, relative. Probability that a run, or a yes or no, was misread. Least likelihood.
AMPLITUDE: Final = 0.1
MISREAD: Final = 0.02
FLOOR: Final = 1e-9
#: Identifiers of the votes that are no relation over several runs: in the file of statements, or here.
FIRST_MODE: Final = "first-mode-range"
RING_FREQUENCY: Final = "second-mode"
RING_SIGNS: Final = "second-mode-signs"
RING_SEEN: Final = "second-mode-seen"
LABELS: Final = {"tip_acceleration": "figure-3.7", "strain": "figure-3.8"}
#: Votes by kind.
FREQUENCIES: Final = ("pre-frequency", "post-frequency", "post-excess", FIRST_MODE)
RINGING: Final = (RING_SEEN, RING_FREQUENCY, RING_SIGNS)
AMPLITUDES: Final = ("pre-amplitude", "pre-amplitude-long-crank", "post-amplitude", *LABELS.values())
VOTES: Final = (*FREQUENCIES, *RINGING, *AMPLITUDES)


@dataclass(frozen=True)
class Words:
    """The statements that vote."""

    relations: tuple[Statement, ...]
    first: float | None  # Hz, the greatest frequency of the first mode in run 24
    ring: float | None  # Hz, of the vibration seen at the return in run 24; None: none is seen
    signs: bool | None  # whether strains 1 and 3 move against strain 2 in it
    labels: Mapping[str, float]  # channel -> the largest label of a figure that shows measured curves alone, SI


@dataclass(frozen=True)
class Predicted:
    """The readings of machines: by the name that statements give a quantity, for each of `RUNS` or for run 24."""

    by_run: Mapping[str, Sequence[Emulated]]  # logarithm of the ratio simulation / machine
    single: Mapping[str, Emulated]  # of run 24: "first" and "ring" (Hz), "seen" and "signs" (probability), logarithms of peaks
    ring_with_mass: tuple[Array, Array]  # Hz, in either of the modes of `weights.moved_by_mass`


def published() -> Words:
    """What the thesis says."""
    by_id = {statement.id: statement for statement in statements()}
    alone = {axis.channel: axis.largest for axis in axis_labels(EXAMPLE) if axis.figure in ("3.7", "3.8")}
    return Words(
        tuple(each for each in by_id.values() if each.kind == "relation"), by_id[FIRST_MODE].high, by_id[RING_FREQUENCY].low, True, alone
    )


def least_number(share: float, count: int) -> int:
    """The least number of runs that a share means: all of `count` but the rest, and always more than half."""
    return max(math.ceil(share * count - 1e-9), count // 2 + 1)


def likelihoods(
    predicted: Predicted, words: Words, *, bias: float = BIAS, ring: float = RING, measured: Mapping[str, Mapping[int, float]] | None = None
) -> tuple[dict[str, Array], Array]:
    """Vote -> its probability for each machine and bias, shape (machines, `NODES`) or (machines, 1); and the weights of the biases.

    Args:
        predicted: the machines' readings.
        words: the statements.
        bias: standard deviation of the bias between the halves, relative.
        ring: error of the printed frequency of the fast vibration, Hz.
        measured: quantity -> run -> ratio simulation / experiment from recordings, which then stand in the place of the words on it.
    """
    nodes, weights = hermegauss(NODES)
    votes = dict[str, Array]()
    for statement in words.relations:
        frequency = statement.quantity.endswith("frequency")
        shift = bias * nodes if frequency and statement.quantity.startswith("post") else np.zeros(1)
        error = (READING if frequency else AMPLITUDE) * (math.sqrt(2.0) if "over" in statement.quantity else 1.0)
        of_runs = {run: each for run, each in zip(RUNS, predicted.by_run[statement.quantity], strict=True) if math.isfinite(each.error)}
        ratios = (measured or {}).get(statement.quantity, {})
        recorded = {run: ratio for run, ratio in ratios.items() if run in of_runs and run in statement.runs}
        if recorded and "over" in statement.quantity:
            continue  # its halves vote
        if recorded:
            parts = [_normal(of_runs[run], shift, error, math.log(ratio)) for run, ratio in recorded.items()]
            votes[statement.id] = np.prod(parts, axis=0)
            continue
        ends = [-math.inf if end <= 0.0 else math.log(end) if math.isfinite(end) else end for end in (statement.low, statement.high)]
        shown = [_within(of_runs[run], shift, error, ends[0], ends[1]) for run in of_runs if run in statement.runs]
        if shown:
            votes[statement.id] = at_least(least_number(statement.share, len(shown)), np.array(shown))
    return {name: np.maximum(vote, FLOOR) for name, vote in (votes | _of_example(predicted, words, ring)).items()}, weights / weights.sum()


def _of_example(predicted: Predicted, words: Words, ring: float) -> dict[str, Array]:
    """The votes of run 24."""
    single, votes = predicted.single, dict[str, Array]()
    if words.first is not None:
        error = math.hypot(FIRST, single["first"].error)
        votes[FIRST_MODE] = np.exp(-0.5 * ((single["first"].mean - words.first) / error) ** 2)
    seen = np.clip(single["seen"].mean, MISREAD, 1.0 - MISREAD)
    votes[RING_SEEN] = seen if words.ring is not None else 1.0 - seen
    if words.ring is not None:
        errors = [np.hypot(ring, single["ring"].error * mode) for mode in predicted.ring_with_mass]
        shares = [np.exp(-0.5 * ((mode - words.ring) / error) ** 2) for mode, error in zip(predicted.ring_with_mass, errors, strict=True)]
        votes[RING_FREQUENCY] = np.mean(shares, axis=0)
    if words.signs is not None:
        signs = np.clip(single["signs"].mean, MISREAD, 1.0 - MISREAD)
        votes[RING_SIGNS] = signs if words.signs else 1.0 - signs
    for channel, label in words.labels.items():
        error = math.hypot(LABEL, single[channel].error)
        votes[LABELS[channel]] = np.exp(-0.5 * ((single[channel].mean - math.log(label)) / error) ** 2)
    return {name: vote[:, None] for name, vote in votes.items()}


def _within(emulated: Emulated, shift: Array, error: float, low: float, high: float) -> Array:
    """Probability that a run shows a logarithm between two ends, shape (machines, biases)."""
    spread = math.hypot(error, emulated.error)
    centre = emulated.mean[:, None] + shift
    return MISREAD / 2.0 + (1.0 - MISREAD) * (ndtr((high - centre) / spread) - ndtr((low - centre) / spread))


def _normal(emulated: Emulated, shift: Array, error: float, value: float) -> Array:
    """Likelihood of a measured logarithm, over that of the best, shape (machines, biases)."""
    return np.exp(-0.5 * ((value - emulated.mean[:, None] - shift) / math.hypot(error, emulated.error)) ** 2)


def at_least(least: int, shown: Array) -> Array:
    """Probability that at least so many runs show it; `shown`: probability of each run, shape (runs, ...). Poisson binomial."""
    counts = np.zeros((len(shown) + 1, *shown.shape[1:]))
    counts[0] = 1.0
    for probability in shown:
        counts[1:] = counts[1:] * (1.0 - probability) + counts[:-1] * probability
        counts[0] *= 1.0 - probability
    return np.asarray(counts[least:].sum(axis=0))
