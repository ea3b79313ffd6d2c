"""Quantities that the thesis does not print, as distributions, and the effect of their scatter on the 24 runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.library.thesis.runs import RUNS, run_name
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.studies.sweep.rows import MeasureRequest
from quickreturn.plugins.studies.uncertainty.propagation import planned
from quickreturn.plugins.studies.uncertainty.scatter import Quantile, Scatter, quantiles
from quickreturn.plugins.thesis.experiment import statements

#: Number of points of each run. In run 24 the outer quantiles agree with those of 512 points to 0.7 % for the frequency, to 8 % for the
#: peak strain.
SAMPLES: Final = 16
#: Probabilities of the quantiles.
PROBABILITIES: Final = (0.025, 0.5, 0.975)
#: Runs and points with an estimate of the simulation's own error, which takes twice the time.
CLAIMED_RUNS: Final = (10, 24)
CLAIMED_SAMPLES: Final = 8
#: The measures of a point.
MEASURES: Final = ("pre.frequency", "post.frequency", *(f"peak.{name}" for name in CHANNELS[1:]))


#: Least ratio of the frequency excess (simulation over machine) after the return to that before it for which the words count as true.
EXCESS: Final = next(each.low for each in statements() if each.id == "post-excess")


@dataclass(frozen=True)
class Unprinted:
    """A quantity that the thesis does not print: its key, its distribution, and the reason for it."""

    key: str
    distribution: str
    reason: str


#: The range of each is assumed; all conclusions hold for these ranges only.
UNPRINTED: Final = (
    Unprinted(
        "slider.mass", "uniform 0 kg .. 0.3 kg", "the coupler with its rollers, without a mass in print; 0.3 kg is a steel block of 34 mm"
    ),
    Unprinted(
        "tip.center_of_mass",
        "uniform 0 in .. 0.5 in",
        "an inch of the strip beyond the flexible length counts as tip: its middle, and the accelerometer's, lie up to 0.5 in out",
    ),
    Unprinted("mechanism.gravity[1]", "uniform -0.17 m/s^2 .. 0.17 m/s^2", "a table that is level to a degree"),
    Unprinted("mechanism.gravity[2]", "uniform -0.17 m/s^2 .. 0.17 m/s^2", "likewise"),
    Unprinted(
        "follower.bending_stiffness",
        "normal 2128.22 lbf*in^2 +- 4 %",
        "printed, but it grows with the cube of the strip's thickness, and a mill's tolerance of that is 1.3 %",
    ),
    Unprinted("follower.damping", "log-uniform 1e-5 lbf*s/in^2 .. 4e-5 lbf*s/in^2", "its unit is illegible: half to twice the value"),
)


@dataclass(frozen=True, kw_only=True)
class Band:
    """The effect of the scatter on a run: quantiles of 2.5, 50 and 97.5 %, over the points that have the number."""

    run: int  # number
    points: int  # number of computed points
    settled: int  # number of those that settled
    compared: int  # number of those with a frequency in both halves
    pre: tuple[float, ...]  # first-mode frequency before the return, Hz; empty where no point resolves it
    post: tuple[float, ...]  # likewise after it
    ratio: tuple[float, ...]  # frequency after the return over that before it: least, median and greatest of all points
    apart: int  # points at which the halves differ as the words require: the frequency after the return at most `1 / EXCESS` of that before
    strain: tuple[float, ...]  # largest of the three gauges' peak strains
    # standard errors of the outer quantiles from the number of points, relative, the larger of both: of `pre`, `post`, `strain`
    sampled: tuple[float, ...]
    # relative errors of the simulation's numbers by its own estimate and their measurement, medians over `CLAIMED_SAMPLES` points,
    # likewise; only for `CLAIMED_RUNS`
    claims: tuple[float, ...]


def bands(workshop: Workshop, runs: Sequence[int] = tuple(RUNS)) -> list[Band]:
    """All bands without a missing point in the workshop. KeyboardInterrupt: Ctrl-C; finished points are stored."""
    uncertain: Mapping[str, str] = {each.key: each.distribution for each in UNPRINTED}

    def scattered(run: int, samples: int, *, claims: bool) -> Scatter | None:
        points = planned(load_case(run_name(run)), uncertain, MeasureRequest(measures=MEASURES, claims=claims), samples, "thesis")
        missing = not workshop.computes and any(each.missing for each in workshop.outcomes(points.jobs, "points"))
        return None if missing else points.scatter(workshop)

    with_claims = {run: scattered(run, CLAIMED_SAMPLES, claims=True) for run in runs if run in CLAIMED_RUNS}
    claims = {run: claimed(scatter) for run, scatter in with_claims.items() if scatter}
    return [band(run, scatter, claims.get(run, ())) for run in runs if (scatter := scattered(run, SAMPLES, claims=False))]


def claimed(scatter: Scatter) -> tuple[float, ...]:
    """`Band.claims` of some points."""
    shares = scatter.errors / np.abs(scatter.values)
    return tuple(float(np.nanmedian(kind)) for kind in (shares[:, 0], shares[:, 1], shares[:, 2:]) if np.any(np.isfinite(kind)))


def band(run: int, scatter: Scatter, claims: tuple[float, ...] = ()) -> Band:
    """The band of a run from its points."""
    settled = np.array(scatter.statuses) == Ending.SETTLED
    columns = dict(zip(MEASURES, scatter.values.T, strict=True))
    pre, post = columns["pre.frequency"], columns["post.frequency"]
    strain = np.max([columns[name] for name in MEASURES[2:]], axis=0)
    both = settled & np.isfinite(pre) & np.isfinite(post)
    ratios = post[both] / pre[both]
    of_kinds = [quantiles(values[settled & np.isfinite(values)], PROBABILITIES) for values in (pre, post, strain)]
    return Band(
        run=run,
        points=len(settled),
        settled=int(settled.sum()),
        compared=int(both.sum()),
        pre=tuple(quantile.value for quantile in of_kinds[0]),
        post=tuple(quantile.value for quantile in of_kinds[1]),
        ratio=(float(ratios.min()), float(np.median(ratios)), float(ratios.max())) if len(ratios) else (),
        apart=int(np.sum(ratios <= 1.0 / EXCESS)),
        strain=tuple(quantile.value for quantile in of_kinds[2]),
        sampled=tuple(_sampled(kind) for kind in of_kinds),
        claims=claims,
    )


def _sampled(of_kind: list[Quantile]) -> float:
    """The larger relative standard error of the outer quantiles; 0 without any."""
    return max((quantile.error / quantile.value for quantile in of_kind if quantile.probability != PROBABILITIES[1]), default=0.0)
