"""A case: one scene, and what to simulate of it."""

from dataclasses import dataclass

from reference_model.mechanism import Mechanism


@dataclass(frozen=True, kw_only=True)
class Case:
    """A named scene in SI units with its simulation times.

    Attributes:
        name: as used on the command line.
        title: one line for people.
        tags: groups that the case belongs to, e.g. "thesis".
        mechanism: the scene.
        duration: s, a whole multiple of `output_step`.
        output_step: s.
        notes: what a reader of results must know, e.g. which published value was replaced and why. Empty for case files.
        source: the file's path, or "library".
    """

    name: str
    title: str
    tags: tuple[str, ...]
    mechanism: Mechanism
    duration: float
    output_step: float
    notes: tuple[str, ...] = ()
    source: str = ""
