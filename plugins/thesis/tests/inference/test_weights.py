"""The inference finds invented machines again, from statements on them in the thesis' vocabulary."""

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from quickreturn.plugins.thesis.inference.emulator import Emulated
from quickreturn.plugins.thesis.inference.study import CONFIRMED_IN, RUNS, Confirmation, Row
from quickreturn.plugins.thesis.inference.unknowns import NAMES, spread
from quickreturn.plugins.thesis.inference.weights import (
    MAIN,
    PRIORS,
    SOFT_AFTER,
    Drawn,
    Inference,
    drawn,
    infer,
    information,
    quantiles,
    readings,
    together,
)
from quickreturn.plugins.thesis.inference.words import AMPLITUDE, BIAS, FIRST, READING, RING, Words, least_number, likelihoods, published
from quickreturn.reports.long_studies import table

ROWS = tuple(table("finding", Row))
INVENTED = 20
FOUND = ("stiffness", "plus", "joint")


@cache
def machines() -> Drawn:
    return drawn(ROWS, power=12)


def words_on(by_run: Mapping[str, np.ndarray], first: float, ring: float | None) -> Words:
    """What an author would say of these readings, in the thesis' vocabulary; `by_run`: ratio simulation / machine for each of `RUNS`."""
    relations = []
    for statement in published().relations:
        here = [at for at, run in enumerate(RUNS) if run in statement.runs]
        ratios = by_run[statement.quantity][here]
        ends = {end for each in published().relations if each.quantity == statement.quantity for end in (each.low, each.high)}
        if statement.quantity == "post_over_pre_frequency":
            ends = {1.0 / statement.low, statement.low}
        edges = [-math.inf, *sorted(end for end in ends if math.isfinite(end)), math.inf]
        counts = [(int(np.sum((ratios >= low) & (ratios <= high))), low, high) for low, high in pairwise(edges)]
        count, low, high = max(counts)
        shares = [share for share in (1.0, 0.9, 0.75, 0.5) if count >= least_number(share, len(here))]
        if shares:
            relations.append(replace(statement, low=low, high=high, share=shares[0]))
    return Words(tuple(relations), first, ring, None, {})


def invented(truth: Drawn, at: int, generator: np.random.Generator) -> Words:
    """Words on one machine: its emulated readings with the emulator's error, errors of reading and a bias between the halves."""

    def read(each: Emulated, error: float) -> float:
        return float(each.mean[at] + math.hypot(each.error, error) * generator.standard_normal())

    of = truth.predicted.by_run
    bias, before, after, apart = BIAS * generator.standard_normal(), "pre_frequency", "post_frequency", "post_over_pre_frequency"
    ratios = {name: np.array([read(each, READING if name in (before, after) else AMPLITUDE) for each in of[name]]) for name in of}
    ratios[apart] = np.array([read(each, READING * math.sqrt(2.0)) for each in of[apart]])
    ratios[after], ratios[apart] = ratios[after] + bias, ratios[apart] + bias
    first = read(truth.predicted.single["first"], FIRST)
    seen = truth.predicted.single["seen"].mean[at] > generator.random()
    ring = math.exp(read(truth.predicted.single["ring"], 0.0)) + RING * generator.standard_normal()
    return words_on({name: np.exp(values) for name, values in ratios.items()}, first, ring if seen else None)


def posterior(words: Words) -> np.ndarray:
    votes, biases = likelihoods(machines().predicted, words)
    return machines().prior("untold") * together(votes, tuple(votes), biases)


@pytest.mark.verify
def test_twenty_invented_machines_lie_in_the_intervals_of_ninety_per_cent() -> None:
    """For at least eight in ten of the unknowns that the statements bear on."""
    generator = np.random.default_rng(3)
    truth = readings(ROWS, spread(generator.random((INVENTED, len(NAMES)))), np.zeros(INVENTED))
    within, narrower = list[bool](), list[float]()
    for at in range(INVENTED):
        weights = posterior(invented(truth, at, generator))
        for name in FOUND:
            low, _, high = quantiles(machines().column(name), weights)
            within.append(low <= truth.column(name)[at] <= high)
            if name == "stiffness":
                narrower.append(high - low)
    assert np.mean(within) >= 0.8, np.mean(within)
    assert np.median(narrower) < 0.5 * 0.9 * (1.35 - 0.9)  # the statements tell something


@pytest.mark.verify
def test_the_machine_that_an_opponent_would_invent_is_found() -> None:
    """A stiffer strip with a soft roller after the return and little preload, of which the ring and the halves tell."""
    machine = dict(zip(NAMES, (1.15, 12.0, 200.0, math.sqrt(2.0 / 30.0), 0.1, 1.0, 0.8, 0.5), strict=True))
    truth = readings(ROWS, np.array([list(machine.values())]), np.zeros(1))
    assert truth.explanation[0] == SOFT_AFTER
    weights = posterior(invented(truth, 0, np.random.default_rng(4)))
    for name in FOUND:
        low, _, high = quantiles(machines().column(name), weights)
        assert low <= machine[name] <= high, name


@cache
def inferred() -> Inference:
    return infer(ROWS, {})


@pytest.mark.verify
def test_a_recorded_curve_takes_the_place_of_words_and_decides() -> None:
    """Measured halves that are alike leave nothing for the soft roller."""
    alike = {name: dict.fromkeys(RUNS, 1.02) for name in ("pre_frequency", "post_frequency")}
    alike["post_over_pre_frequency"] = dict.fromkeys(RUNS, 1.0)
    found = infer(ROWS, alike)
    assert found.weights["untold"]["frequencies"][SOFT_AFTER] < 0.2 * inferred().weights["untold"]["frequencies"][SOFT_AFTER]


def test_a_number_that_is_the_explanation_tells_all_of_it_and_a_constant_nothing() -> None:
    kinds = np.repeat(np.arange(4), 500)
    weights = np.ones(len(kinds))
    assert information(kinds, weights, 10.0 * kinds, 0.5) == pytest.approx(2.0, abs=0.1)
    # 2000 samples in a dozen bins feign (4 - 1) (12 - 1) / (2 * 2000 ln 2) bits
    assert information(kinds, weights, np.zeros(len(kinds)), 1.0) < 0.03


def test_quantiles_of_equal_weights_are_those_of_the_sample() -> None:
    values = np.random.default_rng(5).standard_normal(4001)
    assert quantiles(values, np.ones(4001)) == pytest.approx(np.quantile(values, (0.05, 0.5, 0.95)), abs=2e-3)


def test_the_documents_say_what_the_record_says() -> None:
    found = inferred()
    root = Path(__file__).parents[4]
    readme, document = (" ".join((root / name).read_text("utf-8").split()) for name in ("README.md", "docs/thesis.md"))
    untold, tightened = (found.weights[prior]["frequencies"][SOFT_AFTER] for prior in PRIORS)
    assert f"({100.0 * untold:.0f} % of the weight; {100.0 * tightened:.0f} % if the rollers were tightened" in readme
    low, _, high = found.intervals["stiffness"]
    assert f"a strip {low:.2f} to {high:.2f} times as stiff as printed" in document
    ring = found.rings[SOFT_AFTER]
    assert f"rings at {ring[0]:.0f} to {ring[2]:.0f} Hz after the return" in document
    assert ring[2] < 100.0
    lines = [
        ("untold", "frequencies"),
        ("tightened", "frequencies"),
        ("untold", MAIN),
        ("tightened", MAIN),
        ("untold", "and the ring, ± 20 Hz"),
    ]
    printed = re.findall(r"\| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|", document)
    for (prior, words), cells in zip(lines, printed, strict=True):
        assert [float(cell) for cell in cells] == pytest.approx([100.0 * each for each in found.weights[prior][words][1:]], abs=0.5)
    assert f"takes {found.costs['pre-amplitude'][0]:.1f} decades" in document
    assert f"a probability of {100.0 * found.probabilities['post-excess'][3]:.0f} % there" in document
    assert f"It tells {max(bits for name, (_, bits) in found.deciding.items() if 'run' in name):.1f} bits" in document


def test_two_engines_agree_on_the_likeliest_machines() -> None:
    rows = table("finding_confirmed", Confirmation)
    assert {row.run for row in rows} == set(CONFIRMED_IN)
    machines = {row.machine for row in rows}
    best = {tuple(float(f"{number:.3g}") for number in machine) for machine in inferred().best}
    assert best < machines
    assert sum(row.missed for row in rows) == 0
    document = " ".join((Path(__file__).parents[4] / "docs/thesis.md").read_text("utf-8").split())
    assert f"of {sum(row.compared for row in rows)} numbers none differs" in document
    assert f"up to {100.0 * max(row.slower for row in ROWS):.1f} % slower" in document
