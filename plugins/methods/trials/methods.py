"""Plans of what to try: a method is an engine with a ladder of settings, or a variant of it that differs in one setting."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.cases.files.case import Case
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

    def plans(self, case: Case) -> Iterator["Plan"]:
        """Its ladder on a case."""
        return (Plan(case, self, settings) for settings in self.ladder)


@dataclass(frozen=True)
class Plan:
    """A trial to be carried out."""

    case: Case
    method: Method
    settings: Settings

    @property
    def about(self) -> dict[str, Any]:
        """The fields of its trial that are known before."""
        engine, method = self.method.engine.name, self.method.name
        variant = "" if method == engine else method
        return {"scene": self.case.name, "engine": engine, "variant": variant, "settings": self.settings.as_dict()}


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
