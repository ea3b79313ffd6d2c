"""Changes of the hand-derived equations that the derived ones notice: `python -m quickreturn.plugins.derive.tests.mutation.mutants`."""

from typing import Final

from quickreturn.plugins.derive.tests.mutation import beam_mutants, joint_mutants, thesis_mutants
from quickreturn.plugins.derive.tests.mutation.mutation import Hunt

HUNTS: Final[dict[str, Hunt]] = {"beam": beam_mutants.HUNT, "joint": joint_mutants.HUNT, "thesis": thesis_mutants.HUNT}


def main() -> None:
    """Print for each set of equations the number of changes, of those without effect, and of those noticed; then those that are missed."""
    for name, hunt in HUNTS.items():
        changes = hunt.sites[0]
        missed = hunt.survivors(changes)
        without_effect = sum((site.function, site.flip) in hunt.equivalent for site in changes)
        noticed = len(changes) - without_effect - len(missed)
        print(f"{name}: {len(changes)} changes, {without_effect} without effect, {noticed} noticed, {len(missed)} missed")
        for site in missed:
            print(f"  {site}")


if __name__ == "__main__":
    main()
