"""The methods that a benchmark compares: an engine, its ladder of settings, and variants that differ in one setting."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.cases.case import Case
from quickreturn.engines.base import AnyEngine
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings

#: Name of an engine -> its variants: name, and the settings that distinguish it.
VARIANTS: Final[Mapping[str, tuple[tuple[str, Mapping[str, str]], ...]]] = {
    "multiplier": (("multiplier, elements", {"family": "hermite"}),),
    "nodal-load": (("nodal-load, linear", {"distribution": "both linear"}),),
    "moving-boundaries": (("moving-boundaries, foreshortening", {"foreshortening": "true"}),),
}


@dataclass(frozen=True)
class Method:
    """A method: its name (that of its engine, or of a variant), the engine, and its settings from coarse to fine."""

    name: str
    engine: AnyEngine
    ladder: tuple[Settings, ...]

    def changing(self, settings: Settings) -> dict[str, Any]:
        """The settings that differ on the ladder; all settings if it has only one rung."""
        values = settings.as_dict()
        rungs = [rung.as_dict() for rung in self.ladder]
        return {name: value for name, value in values.items() if len(rungs) < 2 or any(rung[name] != rungs[0][name] for rung in rungs)}


def methods(names: Sequence[str], case: Case) -> list[Method]:
    """All methods of some engines; an engine that cannot be used on this machine has one method with an empty ladder.

    Raises:
        UnknownEngine: no engine has this name.
    """
    methods = []
    for name in names:
        chosen = engine(name)
        ladder = () if chosen.unavailable() else chosen.ladder(case.mechanism)
        methods.append(Method(name, chosen, ladder))
        for variant, texts in VARIANTS.get(name, ()):
            methods.append(Method(variant, chosen, tuple(settings.with_texts(dict(texts)) for settings in ladder)))
    return methods
