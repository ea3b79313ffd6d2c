"""The engine `nodal-load`: standard finite elements with fixed nodes, the slider force shared between two of them (Buchanan)."""

from dataclasses import dataclass
from typing import Final

from quickreturn.engines.base import Comparison
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.own.beam_engine import BeamSettings, time_over_run_24
from quickreturn.engines.settings import setting
from quickreturn.plugins.methods.rivals.rival import Rival, RivalEngine
from quickreturn.reference_model.joint import CHORDS, LEVER, MULTIPLIER, SliderConstraint
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.shapes import ShapeSet, hermite_elements

_DISTRIBUTIONS: Final = {"lever": LEVER, "consistent": MULTIPLIER, "both linear": CHORDS}

#: Numbers of elements over that of the run with which the two coarser runs are compared, and the assumed error of a coarser run over that
#: of the run. With the lever rule the error changes its sign from one number of elements to the next but hardly its size, so that the
#: difference is about as large as the error.
COARSER: Final = (2.0 / 3.0, 0.8)
FACTOR: Final = 2.0
#: The same for finer runs, which take the place of coarser ones that break down or would have too few elements.
FINER: Final = (1.5, 1.25)
PART_OF_FINER: Final = 0.25
FEWEST_WITH_COARSER: Final = 6
_MOST_ELEMENTS: Final = 64


@dataclass(frozen=True, kw_only=True)
class NodalLoadSettings(BeamSettings):
    """Settings of `nodal-load`.

    Elements vibrate at tens of kHz. The explicit integration's error in that makes a third of a machine's slider force at a tolerance of
    1e-7, and a percent at 1e-9.
    """

    elements: int = setting(12, "cubic Hermite elements of equal length", low=1, high=64)
    distribution: str = setting(
        "lever",
        "slider force on the nodes by the lever rule, or as Hermite interpolation distributes it, or lever rule and slider on the chords",
        choices=tuple(_DISTRIBUTIONS),
    )
    stabilization: float = setting(100.0, "rate at which a gap decays (Baumgarte, critically damped)", unit="1/s", low=0.0, high=1e12)
    bending_damping: float = setting(
        3e-6,
        "damping moment over EI, per rate of curvature; only with the lever rule, which flutters without it",
        unit="s",
        low=0.0,
        high=1e6,
    )

    @property
    def shape_count(self) -> int:
        return 2 * self.elements


#: Error of the tip deflection in run 24 over 2 s, lever rule; with four and six elements it fails there.
_CLAIMS: Final = {4: 1.0, 6: 5e-1, 8: 3e-1, 12: 1e-1, 16: 6e-2, 24: 3e-2}
LADDER: Final = Ladder(
    tuple((NodalLoadSettings(elements=elements), claim) for elements, claim in _CLAIMS.items()), size="elements", tolerance="tolerance"
)


def shapes_of(settings: NodalLoadSettings, length: float) -> ShapeSet:
    """The elements of a flexible follower of this length (m)."""
    return hermite_elements(length, settings.elements)


def constraint(settings: NodalLoadSettings, scene: Scene) -> SliderConstraint:
    """The distribution, with damping for the lever rule, whose constraint does work; for a rigid follower a multiplier."""
    kind = MULTIPLIER if scene.follower.is_rigid else _DISTRIBUTIONS[settings.distribution]
    damping = settings.bending_damping if settings.distribution == "lever" else 0.0
    return SliderConstraint(kind=kind, stabilization=settings.stabilization, bending_damping=damping)


def joint_line(settings: NodalLoadSettings, scene: Scene) -> str:
    """The distribution in one line."""
    return f"slider on the elements (force on two nodes, {settings.distribution})"


def scaled(settings: NodalLoadSettings, mechanism: Mechanism) -> NodalLoadSettings:
    """Settings whose times are in proportion to the follower's."""
    time = time_over_run_24(mechanism)
    return settings.replaced(stabilization=settings.stabilization / time, bending_damping=time * settings.bending_damping)


def comparisons(settings: NodalLoadSettings, mechanism: Mechanism) -> tuple[Comparison, ...]:
    """Comparisons with two other numbers of elements, coarser ones where they run."""

    def with_elements(ratio: float, factor: float, instead: Comparison | None = None) -> Comparison:
        other = settings.elements + (1 if ratio > 1.0 else -1) * max(1, round(abs(ratio - 1.0) * settings.elements))
        return Comparison(settings, settings.replaced(elements=other), factor, instead=instead, of="space")

    if 2 * settings.elements > _MOST_ELEMENTS:
        return tuple(with_elements(ratio, FACTOR) for ratio in COARSER)
    finer = [with_elements(ratio, PART_OF_FINER) for ratio in FINER]
    if settings.elements < FEWEST_WITH_COARSER:
        return tuple(finer)
    return tuple(with_elements(ratio, FACTOR, instead) for ratio, instead in zip(COARSER, finer, strict=True))


#: The textbook's way. With the lever rule the constraint does work: the slider's force on the nodes has a spurious power.
ENGINE: Final = RivalEngine(
    Rival(
        name="nodal-load",
        method="Hermite elements, slider force shared between two nodes, index-1 form stabilized, exact planar geometry, Radau IIA",
        default_accuracy=1e-1,
        estimates="unverified",
        settings_type=NodalLoadSettings,
        ladder=LADDER,
        shapes=shapes_of,
        comparisons=comparisons,
        constraint=constraint,
        joint_line=joint_line,
        scaled=scaled,
    )
)
