"""The effects by which the machine may differ from its simulation, as `cases/library/thesis/data/effects.toml` declares them."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from quickreturn.cases.files.reading import changes_of
from quickreturn.cases.library.thesis.data import read_toml
from quickreturn.cases.library.thesis.runs import run_case
from quickreturn.reference_model.mechanism import Mechanism

FILE: Final = "effects.toml"


@dataclass(frozen=True)
class Effect:
    """An effect at several strengths."""

    id: str  # short name
    name: str  # name for people
    set: str  # key of a case file that takes each strength in turn, or a setting of the engine
    strengths: tuple[Any, ...]  # values of that key or setting, from weak to strong
    choices: tuple[str, ...]  # quantities whose value is chosen, not published
    words: tuple[str, ...] = ()  # the strengths in words
    also: Mapping[str, str] = field(default_factory=dict)  # key -> value at all strengths
    engine: str = "reference"
    symmetric: bool = False  # whether it cannot make the halves of a cycle differ

    def scene(self, run: int, strength: int) -> Mechanism:
        """The scene of a run of the thesis with this effect; `strength`: its place among `strengths`."""
        texts = {self.set: self.strengths[strength]} if "." in self.set else {}
        return run_case(run).mechanism_with(changes_of({**texts, **self.also}, FILE))

    def settings(self, strength: int) -> dict[str, str]:
        """Settings of the engine, as texts."""
        return {} if "." in self.set else {self.set: self.strengths[strength]}


#: The runs without any effect.
PUBLISHED: Final = Effect("published", "none", "", ("",), (), ("as published",))


@functools.cache
def effects() -> tuple[Effect, ...]:
    """All effects; `words` default to the strengths."""
    listed = []
    for entry in read_toml(FILE)["effect"]:
        lists = {key: tuple(entry.get(key, entry["strengths"])) for key in ("strengths", "choices", "words")}
        listed.append(Effect(**entry | lists))
    return tuple(listed)


def name_of(effect: str) -> str:
    """An effect's name for people."""
    return next(each.name for each in (PUBLISHED, *effects()) if each.id == effect)
