"""The inference in words and tables."""

from collections.abc import Sequence
from typing import Final

from quickreturn.plugins.thesis.experiment import statements
from quickreturn.plugins.thesis.inference.study import ENGINES, Confirmation
from quickreturn.plugins.thesis.inference.unknowns import NAMES, PRINTED, UNKNOWNS
from quickreturn.plugins.thesis.inference.weights import EXPLANATIONS, MAIN, MASS, PRIORS, SETS, SOFT_AFTER, Inference
from quickreturn.plugins.thesis.inference.words import LABELS, RING_FREQUENCY, RING_SEEN
from quickreturn.reports.tables import Column, Table
from quickreturn.reports.words import HALF, number, percent, percents, span

_QUANTILES: Final = ("quantile_5", "quantile_50", "quantile_95")
#: Votes that are no statement of the file.
_WORDS: Final = {
    RING_SEEN: "In the tip acceleration of run 24 a fast vibration is seen about the return.",
    LABELS["tip_acceleration"]: "The largest label of figure 3.7, tip acceleration of run 24, is 10,000 in/s².",
    LABELS["strain"]: "The largest label of figure 3.8, strain of run 24, is 0.015 %.",
}


def headline(inference: Inference) -> str:
    """What survives, what speaks against it, and what would decide, as sentences without the last full stop."""
    low, _, high = inference.intervals["stiffness"]
    (first, with_ring), tightened = (
        [inference.weights["untold"][words][SOFT_AFTER] for words in ("frequencies", MAIN)],
        inference.weights["tightened"]["frequencies"][SOFT_AFTER],
    )
    ring = span(inference.rings[SOFT_AFTER][0], inference.rings[SOFT_AFTER][2], ".0f")
    return (
        f"Every machine that fits the words has a strip stiffer than printed ({span(low, high, '.2f')} times, 90 %). Why the halves differ"
        f" is open: by the frequencies a roller that is soft after the return and hardly preloaded leads with {percent(first, '.0f')} of"
        f" the weight, {percent(tightened, '.0f')} if it is taken at its word that the rollers were tightened (section 3.2); but it rings"
        f" at {ring} Hz where 132 Hz is printed, which leaves it {percent(with_ring, '.1f')}. That frequency in run 24 would decide"
    )


def against(inference: Inference) -> str:
    """What the fast vibration says, in sentences."""
    rings = [span(of[0], of[2], ".0f") for of in inference.rings]
    found, count = inference.judged
    after, before = sorted(inference.errors[f"{half}_frequency"] for half in HALF)
    return (
        f"By the frequencies alone, run 24 would ring after the return at {rings[SOFT_AFTER]} Hz with such a roller, at {rings[3]} Hz with"
        f" clearance, at {rings[4]} Hz with a joint nearly alike on both sides (80 %, if it rings at all). The printed 132 Hz takes"
        f" {number(inference.costs[RING_FREQUENCY][0], '.1f')} decades of evidence, that the amplitudes before the return were very good"
        f" {number(inference.costs['pre-amplitude'][0], '.1f')}: no machine has them. Fits found a frequency in {found} of {count} halves;"
        f" the others have the emulator’s value. Its error at machines that it has not seen is {percents(after, before, '.1f')} of a"
        f" frequency and {percent(inference.errors['pre_amplitude'], '.0f')} of an amplitude, and counts in every probability."
    )


def weights(inference: Inference) -> Table:
    """The weight of each explanation by each set of statements, under both priors."""
    columns = [Column(name, unit="%", form=".1f", group="weight", meaning=words) for name, words in EXPLANATIONS.items()]
    table = Table(
        "finding_weights",
        """The weight of each explanation under two priors: untold, or with nine of ten machines tightened by more than 3 N as section 3.2
        says. Each bias is the standard deviation of a reading error common to all runs between the halves. Evidence: decades, larger is
        better; only lines of one set compare.""",
        ("prior", Column("statements", "by"), *columns, Column("evidence", unit="decades", form=".1f")),
    )
    for prior in PRIORS:
        for words in ("", *SETS):
            cells = dict(zip(EXPLANATIONS, inference.weights[prior][words], strict=True))
            table.add(prior=prior, statements=words or "no statement", evidence=inference.evidence[prior].get(words), **cells)
    return table


def votes(inference: Inference) -> Table:
    """The probability of each statement under each explanation, and what it costs."""
    columns = [Column(name, unit="%", form=".1f", group="probability") for name in EXPLANATIONS]
    costs = [Column(f"cost_{prior}", prior, "decades", ".2f", group="cost") for prior in PRIORS]
    table = Table(
        "finding_statements",
        """The probability of each statement under each explanation, mean over its machines before any statement; and the decades of
        evidence that the statement takes from all others: of frequencies and the ring, or with the amplitudes of all.""",
        (Column("id", in_page=False), "statement", *columns, *costs),
    )
    words = {each.id: each.words for each in statements()} | _WORDS
    for vote, probabilities in inference.probabilities.items():
        cells = dict(zip(EXPLANATIONS, probabilities, strict=True))
        cells |= {f"cost_{prior}": cost for prior, cost in zip(PRIORS, inference.costs[vote], strict=True)}
        table.add(id=vote, statement=words[vote], **cells)
    return table


def deciding(inference: Inference) -> Table:
    """What a number would tell about the explanation."""
    table = Table(
        "finding_deciding",
        "What one more number tells about the explanation after the statements on frequencies; two bits single out one of four.",
        ("number", Column("error", "its error", "", ".3g"), Column("bits", form=".2f")),
    )
    for name, (error, bits) in sorted(inference.deciding.items(), key=lambda each: -each[1][1]):
        table.add(number=name, error=error, bits=bits)
    return table


def unknowns(inference: Inference) -> Table:
    """The unknowns, their ranges, and what the statements leave of them."""
    table = Table(
        "finding_unknowns",
        """What the thesis leaves open, the range in which machines are drawn (evenly, or evenly in the logarithm), and the quantiles that
        the statements on frequencies and ring leave under the prior untold.""",
        (
            "unknown",
            "range",
            "reason",
            *(Column(name, name.replace("quantile_", "") + " %", "", ".3g", group="quantile") for name in _QUANTILES),
        ),
    )
    for unknown in UNKNOWNS:
        ends = dict(zip(_QUANTILES, inference.intervals[unknown.name], strict=True))
        table.add(unknown=unknown.words, range=span(unknown.low, unknown.high, ".3g"), reason=unknown.reason, **ends)
    ends = dict(zip(_QUANTILES, inference.intervals["mass"], strict=True))
    reason = "half of the machines have none; by a hand model (rollers, coupler)"
    table.add(unknown="mass of the slider beyond the compliance, kg", range=span(0.0, MASS, ".3g"), reason=reason, **ends)
    return table


def confirmed(rows: Sequence[Confirmation]) -> Table:
    """Two engines on the likeliest machines and the printed one."""
    columns = [Column(f"{half}_{name}", name, "Hz", ".2f", group=f"f₁, {HALF[half]}") for half in HALF for name in ENGINES]
    table = Table(
        "finding_confirmed",
        """The printed machine and the likeliest one of three explanations by two engines, compared within their claims as in every
        cross-check.""",
        ("machine", Column("run", form="d"), *columns, Column("compared", form="d"), Column("missed", form="d")),
    )
    for row in rows:
        cells = {f"{half}_{name}": value for half in HALF for name, value in zip(ENGINES, getattr(row, half), strict=True)}
        of = dict(zip(NAMES, row.machine, strict=True))
        text = ", ".join(f"{name} {value:g}" for name, value in of.items() if value != PRINTED[name])
        table.add(row, machine=text or "as printed", **cells)
    return table
