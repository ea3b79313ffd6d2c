"""Engines whose answer depends on an earlier scene, or on the process: in a module of their own, so that another process can have them."""

import dataclasses
import os
from typing import Any, ClassVar

import numpy as np

from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import Start
from quickreturn.plugins.conform.tests.mutants import Around, Columns
from quickreturn.reference_model.mechanism import Mechanism


class Keeps(ReferenceEngine):
    """Keeps a part of the first scene that it sees."""

    name = "keeps"
    part: ClassVar[str]
    kept: ClassVar[dict[str, Any]] = {}

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        self.kept.setdefault(self.name, getattr(mechanism, self.part))
        return super().prepare(dataclasses.replace(mechanism, **{self.part: self.kept[self.name]}), start, settings)


KeepsCrank, KeepsTip, KeepsFollower = (
    type(f"Keeps{part.title()}", (Keeps,), {"name": f"keeps-{part}", "part": part, "__module__": __name__})
    for part in ("crank", "tip", "follower")
)


class BuiltForAFollower(ReferenceEngine):
    """Builds its model anew where the follower is another one, and only there."""

    name = "built-for-a-follower"
    built: ClassVar[dict[Any, Mechanism]] = {}

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        self.built.setdefault(mechanism.follower, mechanism)
        return super().prepare(self.built[mechanism.follower], start, settings)


class Threaded(ReferenceEngine):
    """Its last digits depend on how many threads add its sums: here, on whether the process is one with a single thread."""

    name = "threaded"

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        def change(c: Columns) -> Columns:
            noise = 1e-4 * (os.environ.get("OPENBLAS_NUM_THREADS") != "1") * np.random.default_rng(1).normal(size=len(c["time"]))
            return {"slider_force": c["slider_force"] * (1.0 + noise)}

        return Around(super().prepare(mechanism, start, settings), change)
