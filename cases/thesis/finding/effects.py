"""The effects by which the machine may differ from its simulation, as `cases/thesis/data/effects.toml` declares them."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from quickreturn.cases.case_file import load_case
from quickreturn.cases.thesis.data import read_toml
from quickreturn.reference_model.mechanism import Mechanism


@dataclass(frozen=True)
class Effect:
    """One effect; `cases/thesis/data/effects.toml` says what its values mean."""

    id: str
    name: str
    set: str
    strengths: tuple[Any, ...]
    choices: tuple[str, ...]
    words: tuple[str, ...] = ()
    also: Mapping[str, str] = field(default_factory=dict)
    engine: str = "reference"
    symmetric: bool = False

    def scene(self, run: int, strength: int) -> Mechanism:
        """A run of the thesis, changed."""
        own = {self.set: self.strengths[strength]} if "." in self.set else {}
        return load_case(f"thesis-{run:02d}", {**own, **self.also}).mechanism

    def settings(self, strength: int) -> dict[str, str]:
        """Settings of the engine, as texts."""
        return {} if "." in self.set else {self.set: self.strengths[strength]}


#: The runs without any effect.
PUBLISHED: Final = Effect("published", "none", "", ("",), (), ("as published",))


@functools.cache
def effects() -> tuple[Effect, ...]:
    """All of them; `words` are filled."""
    found = []
    for entry in read_toml("effects.toml")["effect"]:
        lists = {key: tuple(entry.get(key, entry["strengths"])) for key in ("strengths", "choices", "words")}
        found.append(Effect(**entry | lists))
    return tuple(found)


def name_of(effect: str) -> str:
    """An effect's name for people."""
    return next(each.name for each in (PUBLISHED, *effects()) if each.id == effect)
