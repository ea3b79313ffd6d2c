"""The points of a study of uncertainty: quasi-random values of uncertain parameters, measured.

The points are those of a scrambled Sobol' sequence (A. B. Owen, Journal of Complexity 14, 1998, 466): twice as many contain the first ones.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.motion.catalogue import measure
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.studies.sweep.grid import OF_START, job
from quickreturn.plugins.studies.sweep.rows import MeasureRequest, Row
from quickreturn.plugins.studies.sweep.study import computed, joined
from quickreturn.plugins.studies.uncertainty.chaos import cube
from quickreturn.plugins.studies.uncertainty.parameters import Distribution, Parameter, changes, distribution
from quickreturn.plugins.studies.uncertainty.scatter import Scatter

Array = NDArray[np.float64]

#: Least and largest number of points; a power of two keeps a Sobol' sequence balanced.
FEWEST: Final = 8
MOST: Final = 65536


@dataclass(frozen=True, eq=False)
class Points:
    """Quasi-random points to compute."""

    case: Case
    distributions: Mapping[Parameter, Distribution]
    asked: MeasureRequest
    inputs: Array

    @cached_property
    def jobs(self) -> list[Job[Row]]:
        """A job for each point: neighbours in the sequence are none in the machine, so no point begins in the motion of another."""
        scene, name = self.case.mechanism, f"{self.asked.engine}, point {{}} of {len(self.inputs)}"
        points = (changes(scene, dict(zip(self.distributions, point, strict=True))) for point in self.inputs)
        return [replace(job(self.case, [point], self.asked), name=name.format(number)) for number, point in enumerate(points, 1)]

    def scatter(self, workshop: Workshop) -> Scatter:
        """Compute the points that are not stored. KeyboardInterrupt: Ctrl-C; finished points are stored."""
        asked, row = self.asked, joined(computed(self.jobs, workshop))
        numbers = row.values, row.errors, row.statuses, row.sentences
        return Scatter(self.case, self.distributions, asked.measures, self.inputs, *numbers, engine=asked.engine)


def check_samples(samples: int, source: str, key: str | None = "samples") -> None:
    """CaseError, which names `source`: it is no number of points."""
    if not FEWEST <= samples <= MOST or samples & (samples - 1):
        raise CaseError(source, key, str(samples), "is no power of two", f"from {FEWEST} to {MOST} are accepted, such as 256")


def planned(case: Case, uncertain: Mapping[str, Any], asked: MeasureRequest, samples: int, source: str) -> Points:
    """Quasi-random points, `samples` of them (a power of two), of distributions as texts by key (`uncertain`).

    CaseError, which names `source`: an unknown key or measure, an invalid distribution or number of points.
    """
    if not uncertain:
        raise CaseError(source, "uncertain", None, "names no parameter", 'write KEY = "uniform A .. B"')
    check_samples(samples, source)
    for name in asked.measures:
        measure(name)
    given = {Parameter.of_key(key, source): text for key, text in uncertain.items()}
    if of_start := next((parameter.key for parameter in given if parameter.key in OF_START), None):
        raise CaseError(source, of_start, None, "changes no steady motion", "leave its distribution or tolerance out")
    distributions = {parameter: distribution(text, parameter, source) for parameter, text in given.items()}
    points = cube(len(distributions), samples)
    inputs = np.column_stack([each.quantile(points[:, place]) for place, each in enumerate(distributions.values())])
    return Points(case, distributions, asked, inputs)
