"""The inference: weights of the explanations under two priors and several sets of statements, and the number that would decide."""

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator
from scipy.linalg import eigh
from scipy.stats import qmc

from quickreturn.cases.library.thesis import run_case
from quickreturn.plugins.thesis.inference import words as spoken
from quickreturn.plugins.thesis.inference.emulator import Emulated, Emulator, features
from quickreturn.plugins.thesis.inference.study import EXAMPLE, RUNS, Row
from quickreturn.plugins.thesis.inference.unknowns import NAMES, changes_of_machine, points, preload_of, spread
from quickreturn.plugins.thesis.inference.words import Predicted
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.scene_values import changed

#: Crank angle in the middle of the return's first sixth, rad, and the number of modes there, of which the lowest are used.
RETURN: Final = math.radians(390.0)
MODES: Final = 12
USED: Final = 5
#: Place of the mode among those at the return that rings with a frequency within some 3 % of its own, in the machines computed.
RINGING: Final = 2
#: Grid of the table: stiffness over the arm's relative one, N/m, and mass beyond it, kg.
STIFFNESSES: Final = np.geomspace(2e3, 4e5, 16)
MASSES: Final = np.linspace(0.0, 0.1, 6)
#: Crank angles between which the greatest first frequency of run 24 lies, rad.
ANGLES: Final = np.linspace(0.6 * math.pi, math.pi, 5)


# The slider's mass in the model rides on the crank. A part of it, m, beyond the compliance k, moves with the follower, which then meets the
# dynamic stiffness k - m omega^2. With the mass-normalised modes phi_j of the follower on the spring alone as shapes, Rayleigh's quotient
# is q' diag(omega_j^2) q / q' (1 + m phi(s) phi(s)') q, whose stationary values are the squares of the new frequencies.
def with_mass(scene: Mechanism, crank_angle: float, mass: float, count: int = USED) -> Array:
    """The lowest natural frequencies (Hz) with the crank held and a mass (kg) on the follower at the slider, beyond a compliant joint."""
    modes = frozen_crank_modes(scene, crank_angle, MODES)
    shapes = modes.deflection(np.array([modes.slider_position]))[:, 0]
    squares = eigh(np.diag((2.0 * np.pi * modes.frequencies) ** 2), np.eye(MODES) + mass * np.outer(shapes, shapes), eigvals_only=True)
    return np.sqrt(squares[:count]) / (2.0 * np.pi)


def greatest_first_frequency(machine: Array) -> float:
    """The greatest first frequency (Hz) of a machine in run 24 over the crank angle, with the stiffer roller in contact."""
    changes = changes_of_machine(machine, EXAMPLE)
    rollers = [changes.get(f"slider.joint_stiffness_{side}", math.inf) for side in ("plus", "minus")]
    of_strip = {key: value for key, value in changes.items() if not key.startswith("slider.")}
    held = changed(run_case(EXAMPLE).mechanism, of_strip | {"slider.joint_stiffness": max(rollers)})
    return max(float(frozen_crank_modes(held, float(angle), 1).frequencies[0]) for angle in ANGLES)


@functools.cache
def _table() -> RegularGridInterpolator:
    """Frequencies at the return (Hz) over log stiffness and mass, with the printed bending stiffness, shape (..., `USED`)."""
    scene = run_case(EXAMPLE).mechanism
    rows = [
        [with_mass(changed(scene, {"slider.joint_stiffness": float(stiffness)}), RETURN, float(mass)) for mass in MASSES]
        for stiffness in STIFFNESSES
    ]
    return RegularGridInterpolator((np.log(STIFFNESSES), MASSES), np.array(rows), bounds_error=False, fill_value=None)


def at_return(stiffness: Array, plus: Array, mass: Array) -> Array:
    """Frequencies with the crank at 390 degrees (Hz, shape (n, `USED`)), which scale with the root of EI if k / EI and the mass stay.

    `stiffness`: bending stiffness over the printed one; `plus`: roller after the return, kN/m; `mass`: beyond it, kg; each of shape (n,).
    """
    scaled = np.log(np.minimum(1e3 * plus / stiffness, STIFFNESSES[-1]))
    return np.sqrt(stiffness)[:, None] * _table()(np.column_stack([scaled, mass]))


def moved_by_mass(frequency: Array, without: Array, having: Array) -> tuple[Array, Array]:
    """Where a vibration at the return goes (Hz, shape (n,)) by a mass: in the mode nearest to it, or in the next one.

    Which of the two rings the hand model cannot say. `frequency`: without the mass, Hz, shape (n,); `without`, `having`: of `at_return`.
    """
    nearest = np.argmin(np.abs(np.log(without / frequency[:, None])), axis=1)
    rows, following = np.arange(len(frequency)), np.minimum(nearest + 1, USED - 1)
    own = frequency * having[rows, nearest] / without[rows, nearest]
    return own, np.where(np.any(having != without, axis=1), having[rows, following], own)


#: Number of machines drawn from the ranges, as a power of two, and the seed.
POWER: Final = 13
SEED: Final = 54
#: Greatest mass of the slider beyond the compliance, kg; half of the machines have none.
MASS: Final = 0.1
#: Preload, N, above which a joint counts as tightened, and the share of such machines in the prior that takes section 3.2 at its word.
TIGHTENED: Final = 3.0
SHARE: Final = 0.9
#: Bending stiffness over the printed one below which it counts as the printed one, and what makes a roller soft: kN/m, and over the other.
PRINTED: Final = 1.1
SOFT: Final = 25.0
SOFTER: Final = 1.5
#: The explanations, in the order of their numbers: name -> words.
EXPLANATIONS: Final[Mapping[str, str]] = {
    "as_printed": "bending stiffness below 1.1 times the printed one, any joint",
    "soft_after": "stiffer strip; the roller after the return below 25 kN/m and softer than the other, preload up to 3 N",
    "soft_tightened": "the same with more preload",
    "clearance": "stiffer strip, other joints with clearance",
    "alike": "stiffer strip, other joints: nearly alike on both sides",
}
#: Number of the explanation that the words on the frequencies suggest.
SOFT_AFTER: Final = 1
#: Priors, and sets of votes with the errors that they assume.
PRIORS: Final = ("untold", "tightened")
COUNTED: Final = "frequencies, by counted extremes"
SETS: Final[Mapping[str, tuple[tuple[str, ...], dict[str, float]]]] = {
    "frequencies": (spoken.FREQUENCIES, {}),
    "frequencies, bias 0.3 %": (spoken.FREQUENCIES, {"bias": 0.003}),
    "frequencies, bias 2 %": (spoken.FREQUENCIES, {"bias": 0.02}),
    COUNTED: (spoken.FREQUENCIES, {}),
    "and the ring": ((*spoken.FREQUENCIES, *spoken.RINGING), {}),
    "and the ring, ± 20 Hz": ((*spoken.FREQUENCIES, *spoken.RINGING), {"ring": 20.0}),
    "all": (spoken.VOTES, {}),
}
MAIN: Final = "and the ring"
#: Runs with unlike slider forces, 15 and 8 N: a preload shows where the force exceeds it, a bias of reading in both.
HALVES: Final = (10, 18)


@dataclass(frozen=True, kw_only=True)
class Inference:
    """The result."""

    weights: dict[str, dict[str, tuple[float, ...]]]  # prior -> set of votes, or "" for none -> weight of each of `EXPLANATIONS`
    evidence: dict[str, dict[str, float]]  # prior -> set -> decades of evidence
    probabilities: dict[str, tuple[float, ...]]  # vote -> mean over the machines of each explanation in the prior "untold"
    costs: dict[str, tuple[float, ...]]  # vote -> decades that it takes from all others of its set, by prior: frequencies and ring, or all
    intervals: dict[str, tuple[float, ...]]  # unknown -> quantiles of 5, 50, 95 % by `MAIN`, prior "untold"
    deciding: dict[str, tuple[float, float]]  # number -> error of its measurement, and bits that it tells after the frequencies
    rings: tuple[tuple[float, ...], ...]  # of each explanation quantiles of 10, 50, 90 % of the ring, Hz, by the frequencies
    best: tuple[tuple[float, ...], ...]  # machines of the three likeliest explanations by `MAIN`: each the likeliest without a mass
    errors: dict[str, float]  # held-out error of emulated readings, relative, median over the runs
    judged: tuple[int, int]  # fits before and after the return that found a frequency, of all


@dataclass(frozen=True)
class Drawn:
    """Machines drawn from the ranges, with what they would show."""

    machines: Array  # shape (n, unknowns)
    mass: Array  # beyond the compliance, kg, shape (n,)
    predicted: Predicted
    counted: Predicted  # with frequencies by counted extremes rather than by fits

    @property
    def preload(self) -> Array:
        """N, shape (n,)."""
        return preload_of(self.column("joint"))

    def column(self, name: str) -> Array:
        """An unknown of all machines, shape (n,)."""
        return self.machines[:, NAMES.index(name)]

    @property
    def explanation(self) -> NDArray[np.intp]:
        """The number of each machine's explanation, shape (n,)."""
        plus, minus, joint = (self.column(name) for name in ("plus", "minus", "joint"))
        soft = (plus < SOFT) & (plus < minus / SOFTER)
        kinds = [self.column("stiffness") < PRINTED, soft & (self.preload <= TIGHTENED), soft, joint < 0.0]
        return np.select(kinds, range(4), 4)

    def prior(self, name: str) -> Array:
        """Weight of each machine before any statement, shape (n,)."""
        tight = self.preload > TIGHTENED
        if name == "untold":
            return np.full(len(tight), 1.0 / len(tight))
        return np.where(tight, SHARE / tight.sum(), (1.0 - SHARE) / (~tight).sum())


def drawn(rows: Sequence[Row], power: int = POWER) -> Drawn:
    """Machines of all ranges with their readings, interpolated between the study's."""
    shares = qmc.Sobol(len(NAMES) + 1, seed=SEED).random_base2(power)
    return readings(rows, spread(shares[:, :-1]), MASS * np.maximum(0.0, 2.0 * shares[:, -1] - 1.0))


def readings(rows: Sequence[Row], machines: Array, mass: Array) -> Drawn:
    """These machines with their readings."""
    computed = points()[[row.machine for row in rows]]
    emulator = Emulator(features(computed), features(machines, mass))
    seen = np.array([row.rings for row in rows])
    held, without = (at_return(each[:, 0], each[:, 1], np.zeros(len(each))) for each in (computed, machines))
    over = emulator(np.where(seen, np.log([row.ring[0] for row in rows] / held[:, RINGING]), np.nan), flat=True)
    single = {
        "first": emulator(np.array([greatest_first_frequency(machine) for machine in computed])),
        "seen": emulator(seen.astype(float), flat=True),
        "ring": replace(over, mean=over.mean + np.log(without[:, RINGING])),
        "signs": emulator(np.where(seen, [float(row.ring[2] < 0.0 < row.ring[3]) for row in rows], np.nan), flat=True),
        "tip_acceleration": emulator(np.log([row.peaks[0] for row in rows])),
        "strain": emulator(np.log([1e-6 * row.peaks[1] for row in rows])),
    }
    with_mass = moved_by_mass(np.exp(single["ring"].mean), without, at_return(machines[:, 0], machines[:, 1], mass))
    fitted, by_count = (Predicted(_by_run(rows, emulator, kind), single, with_mass) for kind in ("", "_counted"))
    return Drawn(machines, mass, fitted, by_count)


def _by_run(rows: Sequence[Row], emulator: Emulator, kind: str) -> dict[str, list[Emulated]]:
    """The ratios that statements name, for each run."""
    fields = {"pre_frequency": f"pre{kind}", "post_frequency": f"post{kind}"} | {name: name for name in ("pre_amplitude", "post_amplitude")}
    values = {name: np.array([row.logarithms(field) for row in rows]).T for name, field in fields.items()}
    values["post_over_pre_frequency"] = values["post_frequency"] - values["pre_frequency"]
    return {name: [emulator(of_run) for of_run in of_runs] for name, of_runs in values.items()}


def together(votes: Mapping[str, Array], names: Sequence[str], biases: Array) -> Array:
    """The probability of some votes together for each machine, the bias integrated out, shape (machines,)."""
    product = math.prod((votes[name] for name in names if name in votes), start=np.ones(1))
    return np.asarray(np.broadcast_to(product, (len(product), len(biases))) @ biases)


def infer(rows: tuple[Row, ...], measured: Mapping[str, Mapping[int, float]]) -> Inference:
    """The inference from the study's rows, and from recordings of the experiment where there are any (`words.likelihoods`)."""
    machines, said = drawn(rows), spoken.published()
    kinds, count = machines.explanation, len(EXPLANATIONS)
    priors = {name: machines.prior(name) for name in PRIORS}
    alone, biases = spoken.likelihoods(machines.predicted, said, measured=measured)
    posterior = {name: dict[str, Array]() for name in PRIORS}
    for words, (names, errors) in SETS.items():
        reading = machines.counted if words == COUNTED else machines.predicted
        likely, nodes = spoken.likelihoods(reading, said, measured=measured, **errors)
        for name, prior in priors.items():
            posterior[name][words] = prior * together(likely, names, nodes)

    def shares(weights: Array) -> tuple[float, ...]:
        return tuple((np.bincount(kinds, weights, count) / weights.sum()).tolist())

    def cost(prior: Array, vote: str) -> float:
        names = SETS[MAIN][0] if vote in SETS[MAIN][0] else spoken.VOTES
        rest = tuple(name for name in names if name != vote)
        return math.log10(float(prior @ together(alone, rest, biases)) / float(prior @ together(alone, names, biases)))

    def of_explanations(vote: str) -> tuple[float, ...]:
        likely, prior = (np.bincount(kinds, priors["untold"] * each, count) for each in (together(alone, (vote,), biases), 1.0))
        return tuple((likely / prior).tolist())

    votes = [vote for vote in spoken.VOTES if vote in alone]
    main, first = posterior["untold"][MAIN], posterior["untold"]["frequencies"]
    ring = np.exp(machines.predicted.single["ring"].mean)
    unknowns = dict(zip((*NAMES, "mass"), (*machines.machines.T, machines.mass), strict=True))

    def likeliest(kind: int) -> tuple[float, ...]:
        return tuple(machines.machines[np.argmax(np.where((kinds == kind) & (machines.mass == 0.0), main, 0.0))].tolist())

    return Inference(
        weights={name: {"": shares(priors[name])} | {words: shares(each) for words, each in posterior[name].items()} for name in PRIORS},
        evidence={name: {words: math.log10(each.sum()) for words, each in posterior[name].items()} for name in PRIORS},
        probabilities={vote: of_explanations(vote) for vote in votes},
        costs={vote: tuple(cost(priors[name], vote) for name in PRIORS) for vote in votes},
        intervals={name: quantiles(values, main) for name, values in unknowns.items()},
        deciding={
            name: (error, information(kinds, first, values, math.hypot(error, own)))
            for name, (values, error, own) in _numbers(machines, ring).items()
        },
        rings=tuple(quantiles(ring, np.where(kinds == kind, first, 0.0), (0.1, 0.5, 0.9)) for kind in range(count)),
        best=tuple(likeliest(int(kind)) for kind in np.argsort(np.bincount(kinds, main, count))[::-1][:3]),
        errors={name: float(np.median([each.error for each in of_runs])) for name, of_runs in machines.predicted.by_run.items()},
        judged=(sum(value is not None for row in rows for value in (*row.pre, *row.post)), 2 * len(rows) * len(RUNS)),
    )


def quantiles(values: Array, weights: Array, probabilities: tuple[float, ...] = (0.05, 0.5, 0.95)) -> tuple[float, ...]:
    """Quantiles of weighted values."""
    order = np.argsort(values)
    return tuple(np.interp(probabilities, (weights[order].cumsum() - 0.5 * weights[order]) / weights.sum(), values[order]).tolist())


def information(kinds: NDArray[np.intp], weights: Array, values: Array, error: float) -> float:
    """Bits that a number, measured with this error, tells about the explanation: their mutual information."""
    noise = error * np.random.default_rng(0).standard_normal(len(values))
    bins = np.unique(np.floor((values + noise) / error), return_inverse=True)[1]
    both = np.zeros((kinds.max() + 1, bins.max() + 1))
    np.add.at(both, (kinds, bins), weights / weights.sum())
    apart = both.sum(axis=1, keepdims=True) * both.sum(axis=0, keepdims=True)
    return float(np.sum(both[both > 0.0] * np.log2(both[both > 0.0] / apart[both > 0.0])))


def _numbers(machines: Drawn, ring: Array) -> dict[str, tuple[Array, float, float]]:
    """Numbers that a curve or a measurement would give: values for the machines, error of that, and error of the emulator."""
    halves = dict(zip(RUNS, machines.predicted.by_run["post_over_pre_frequency"], strict=True))
    after = "frequency after the return over that before it in run"
    of_halves = {f"{after} {run}": (-halves[run].mean, 0.007, halves[run].error) for run in HALVES}
    of_ring = float(np.median(ring)) * machines.predicted.single["ring"].error
    return {
        "frequency of the vibration after the return in run 24, Hz": (ring, 4.0, of_ring),
        **of_halves,
        "static stiffness of the roller after the return, decades": (np.log10(machines.column("plus")), 0.1, 0.0),
        "preload, N": (machines.preload, 1.0, 0.0),
    }
