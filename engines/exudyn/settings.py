"""Settings of the `exudyn` engine and the ladder from accuracy to settings."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

from quickreturn.engines.base import Comparison
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.settings import Settings, setting

ALE, SLIDING = JOINTS = ("ale", "sliding")
#: Unit of mass of a model with a sliding joint, over the scene's own. Exudyn adds to the joint's force one along the tangent, of as many
#: units of force as the slider travels units of length in a step: with small units it is nothing (LADDERS.md, section 3).
LIGHT: Final = 2.0**-30
FEWEST_ELEMENTS: Final = 4
LARGEST_STEP: Final = 5e-2  # s
LEAST_STEP: Final = 1e-7  # s
MOST_ROWS: Final = 8  # output steps in a time step: a run that passes two is compared with one that passes eight
SOFTEST: Final = 0.25
STIFFEST: Final = 100.0


@dataclass(frozen=True, kw_only=True)
class ExudynSettings(Settings):
    """Discretization in space and time, second order in both, and how near the cable is to one that cannot stretch."""

    elements: int = setting(16, "ANCF cable elements along the follower", low=FEWEST_ELEMENTS, high=96)
    step: float = setting(2.5e-4, "largest time step; the output step is divided evenly", unit="s", low=LEAST_STEP, high=LARGEST_STEP)
    rows: int = setting(1, "most output steps in a time step; rows within one are interpolated", low=1, high=MOST_ROWS)
    extrapolated: bool = setting(False, "the table is extrapolated from these steps and steps of about twice their size")
    joint: str = setting("ale", "Exudyn's joint of the slider: along ALE cables, or its sliding joint", choices=JOINTS)
    spectral_radius: float = setting(0.9, "generalized-alpha: damping of the highest frequencies, 1 is none", low=0.5, high=0.95)
    axial_factor: float = setting(1.0, "axial stiffness over that of the section; more is nearer to no stretch", low=SOFTEST, high=STIFFEST)
    newton_tolerance: float = setting(1e-4, "change by an iteration over the step's first one that ends it", low=1e-10, high=1e-4)

    def steps_in(self, output_step: float) -> int:
        """Steps from one output to the next, `output_step` (s) later."""
        return max(1, math.ceil(output_step / self.step - 1e-9))

    def rows_in_step(self, output_step: float) -> int:
        """Output steps in a time step where it passes some, otherwise 1."""
        return min(self.rows, max(1, math.floor(self.step / output_step + 1e-9)))

    def step_taken(self, output_step: float) -> float:
        """The time step (s) by which `output_step` or a multiple of it is divided."""
        return self.rows_in_step(output_step) * output_step / self.steps_in(output_step)

    def fewer_steps_in(self, output_step: float) -> int:
        """Steps of the coarser of two runs that are extrapolated; it takes a single one to two rows, where the finer run has one a row."""
        return max(1, self.steps_in(output_step) // 2)


#: Accuracy -> elements, step in s, whether extrapolated (LADDERS.md, section 3, has what was measured for this and all that follows).
_RUNGS: Final = (
    (8e-2, 4, 1e-3, False),
    (3.5e-2, 8, 1e-3, False),
    (1e-2, 9, 5e-4, False),
    (7e-3, 12, 5e-4, False),
    (3e-3, 16, 2.5e-4, False),
    (1e-3, 16, 5e-4, True),
    (3e-4, 32, 2.5e-4, True),
    (1e-4, 48, 2e-4, True),
)
LADDER: Final = Ladder(
    tuple((ExudynSettings(elements=n, step=step, extrapolated=extrapolated), claim) for claim, n, step, extrapolated in _RUNGS),
    size="elements",
)

#: Accuracy -> Newton's tolerance; 1e-4 only for a `stiffness_ratio` up to SLOW: what moves little ends its iteration too early by it.
_NEWTON: Final = ((3e-3, 1e-4), (1e-3, 1e-5), (0.0, 1e-6))
SLOW: Final = 10.0

#: Accuracy from which on an arm that moves much begins with so many elements: the slider shakes fewer by 2e-3 to 5e-3 as it passes them.
SHAKEN: Final = (3e-3, 14)

#: Energy that steps leave in the balance, over the largest bending energy and the square of step times lowest natural frequency (rad/s): in
#: a plain table and in an extrapolated one.
LEFT_BY_STEPS: Final = (0.8, 0.045)
#: Shortest step (s) that is taken for the balance's sake: shorter ones cost more than four times what the deflection needs.
SHORTEST_FOR_BALANCE: Final = 2.5e-4
#: Largest `stiffness_ratio` of an arm whose balance is kept: in stiffer ones the vibration of a straight start leaves more than all else.
STIFFEST_BALANCED: Final = 300.0

#: Orders of convergence.
ORDER_IN_TIME: Final = 2.0
ORDER_IN_SPACE: Final = 3.0

#: Orders that the estimate counts on, less than those: what just does is not fine enough for the full order, and strains converge more
#: slowly than the deflection.
SAFE_IN_TIME: Final = 1.6
SAFE_IN_SPACE: Final = 1.6

#: The order that it counts on where a run of four times the step shows how fast the differences fall.
CHECKED_IN_TIME: Final = 2.0

#: The orders that it counts on where it compares with a finer run: two runs that do not converge differ by more than the error of either.
FINER_IN_TIME: Final = 2.0
FINER_IN_SPACE: Final = 2.5

#: The order in time that it counts on where rollers touch and part: a blow of run 24 lasts a few steps, and errors then fall irregularly.
SAFE_WITH_BLOWS: Final = 1.0

#: Parts of the elements, fewer and more, that show what the slider excites as it passes them, and a factor that counts on hardly any order.
#: A cubic element is too stiff under the slider's force, but for its ends; where it passes elements at the rate of a natural frequency that
#: vibration grows, whatever their number, and the other number that is compared may by accident be shaken alike.
PASSING: Final = (0.75, 1.25, 1.8)

#: Fewer elements than these have no order yet and are compared with more.
FEWEST_WITH_ORDER: Final = 24

#: A scene's follower does not stretch, a cable does. It is compared with one of this part of its axial stiffness.
SOFTER: Final = 0.25

#: Finest settings: beyond them a run of two seconds takes minutes. 16 times the axial stiffness costs a third more time.
MOST_ELEMENTS: Final = 96
SMALLEST_STEP: Final = 2e-5  # s
STIFFER: Final = (1.0, 4.0, 16.0)  # factors of the axial stiffness from one rung to the next; the last is the most that gains anything

#: Sum of the parts over the accuracy that climbing aims at: below one, for the orders are not exactly those.
AIM: Final = 0.95
#: Where no rung gets there, one is enough that leaves up to this factor of the least that any leaves, and is worth its time ...
NEAREST: Final = 1.2
#: ... and none is worth its time if the least is more than this part of what there is.
WORTHWHILE: Final = 0.9
#: Cost of a rung that can share none of its comparisons with the one before, over one that can: it changes the cable.
NEW_CABLE: Final = 2.0


def rung_for(accuracy: float, gain: float, moves_much: bool) -> ExudynSettings:
    """Settings to begin with.

    Args:
        accuracy: error of the tip deflection asked for.
        gain: see `Ladder.pick`.
        moves_much: whether the follower does, as in run 24.
    """
    newton, rung = next(tolerance for least, tolerance in _NEWTON if accuracy >= least), LADDER.pick(accuracy, gain)
    if not moves_much:
        return rung.replaced(newton_tolerance=min(newton, 1e-5))
    coarsest, fewest = SHAKEN
    return rung.replaced(newton_tolerance=newton, elements=max(rung.elements, fewest if accuracy <= coarsest else 0))


def balanced(own: ExudynSettings, accuracy: float, frequency: float) -> ExudynSettings:
    """The settings with an extrapolated table, and smaller steps if need be, where their steps leave too much in the energy balance.

    The crank's and the arm's energy of motion is many times the bending energy of a stiff arm. What steps leave of it counts as an error of
    the deflection, with whose square the bending energy grows.

    Args:
        own: the rung that the accuracy asks for.
        accuracy: error of the tip deflection asked for.
        frequency: lowest natural frequency with the crank held, rad/s.
    """
    plain, extrapolated = (math.sqrt(2.0 * accuracy / left) / frequency for left in LEFT_BY_STEPS)
    if own.step <= (extrapolated if own.extrapolated else plain):
        return own
    return own.replaced(extrapolated=True, step=min(own.step, float(f"{max(extrapolated, SHORTEST_FOR_BALANCE):.2g}")))


def in_time(own: ExudynSettings, output_step: float, blows: bool = False) -> Comparison:
    """Twice the step and four times the step, which is cheap; of an extrapolated table half the step, which shows more.

    The other way round where the run to compare with breaks down.
    """

    def pair(run: ExudynSettings, other: ExudynSettings, order: float, before: Comparison | None = None) -> Comparison:
        ratio = other.step_taken(output_step) / run.step_taken(output_step)
        return Comparison(run, other, ratio ** (SAFE_WITH_BLOWS if blows else order), before, of="time")

    half, twice = _smaller_step(own, output_step), _larger_step(own, output_step, blows)
    smaller = pair(own, half or own, FINER_IN_TIME)
    if twice is None:
        return smaller
    fourfold = _larger_step(twice, output_step, blows)
    order = CHECKED_IN_TIME if fourfold else SAFE_IN_TIME
    larger = pair(own, twice, order, pair(twice, fourfold, order) if fourfold else None)
    if half is None:
        return larger
    return replace(smaller, instead=larger) if own.extrapolated else replace(larger, instead=smaller)


def _smaller_step(own: ExudynSettings, output_step: float) -> ExudynSettings | None:
    """About half the step; None if that is below the least."""
    rows, steps = own.rows_in_step(output_step), own.steps_in(output_step)
    step = (rows // 2) * output_step if rows > 1 else output_step / (2 * steps)
    return own.replaced(step=step) if step >= LEAST_STEP else None


def _larger_step(own: ExudynSettings, output_step: float, blows: bool) -> ExudynSettings | None:
    """Twice or three times the step; None if that is above the largest, or passes too many rows: none where there are blows."""
    rows, steps = own.rows_in_step(output_step), own.steps_in(output_step)
    if steps == 1:
        rows *= 2
    step = rows * output_step / max(1, steps // 2)
    return None if step > LARGEST_STEP or rows > (1 if blows else MOST_ROWS) else own.replaced(step=step, rows=max(own.rows, rows))


def in_space(own: ExudynSettings, time: Comparison) -> Comparison:
    """Half the elements (half as many again where half are too few), both at the coarsest of the steps compared in time: that is cheaper.

    Where that breaks down half as many again at the run's own step, then at a smaller one.
    """
    more = math.ceil(1.5 * own.elements)
    more = more if more <= MOST_ELEMENTS else own.elements // 2
    fewer = own.elements // 2 if own.elements >= FEWEST_WITH_ORDER else more
    coarsest, *finer = _steps_compared(own, time)
    pairs = [(coarsest, fewer), *((run, more) for run in finer)]

    def pair(run: ExudynSettings, other: int) -> Comparison:
        order = SAFE_IN_SPACE if other < own.elements else FINER_IN_SPACE
        return Comparison(run, run.replaced(elements=other), (own.elements / other) ** order, of="space")

    return _first_to_run([pair(*each) for each in pairs])


def in_passing(own: ExudynSettings, time: Comparison) -> Comparison:
    """Three quarters of the elements, or five quarters where half are too few for an order, at the coarsest of the steps, see `PASSING`."""
    fewer, more, factor = PASSING
    other, factor = (fewer * own.elements, factor) if own.elements >= FEWEST_WITH_ORDER else (more * own.elements, 1.0 / factor)
    runs = _steps_compared(own, time)
    return _first_to_run([Comparison(run, run.replaced(elements=math.ceil(other)), factor, of="passing") for run in runs])


def in_elements(own: ExudynSettings, time: Comparison) -> tuple[Comparison, ...]:
    """The pairs in space and for the passing; one whose larger difference counts where both are with more elements.

    More elements show the whole error of few ones, that of the passing among it, and two such pairs would count it twice.
    """
    space, passing = in_space(own, time), in_passing(own, time)
    return (space, passing) if own.elements >= FEWEST_WITH_ORDER else (replace(space, besides=passing),)


def in_stretch(own: ExudynSettings, time: Comparison) -> Comparison:
    """A softer cable, or a stiffer one where it is soft already; with half the elements if those have an order, at the coarsest step.

    Stiffer cables of few elements are too stiff in bending; softer ones stretch as with many elements.
    """
    few = own.elements // 2 if own.elements >= FEWEST_WITH_ORDER else own.elements
    part = SOFTER if SOFTER * own.axial_factor >= SOFTEST else 1.0 / SOFTER
    runs = [run.replaced(elements=few) for run in _steps_compared(own, time)]
    return _first_to_run([Comparison(run, run.replaced(axial_factor=part * own.axial_factor), 1.0 / part, of="stretch") for run in runs])


def _steps_compared(own: ExudynSettings, time: Comparison) -> list[ExudynSettings]:
    """Plain runs with the steps compared in time, large to small: what hardly depends on the step may be seen in any that runs through."""
    known = [each.other for each in (time, time.before, time.instead) if each is not None]
    runs = sorted((run for run in (own, *known) if isinstance(run, ExudynSettings)), key=lambda run: -run.step)
    return [run.replaced(extrapolated=False) for run in runs]


def _first_to_run(pairs: list[Comparison]) -> Comparison:
    """The first pair, with those behind it to fall back on."""
    found = pairs[-1]
    for pair in reversed(pairs[:-1]):
        found = replace(pair, instead=found)
    return found


def finer(own: ExudynSettings, excess: Mapping[str, float], output_step: float) -> ExudynSettings | None:
    """The cheapest steps, elements and axial stiffness that suffice by the orders; half the step where nothing is known.

    At most four times as many steps and twice the elements at once.

    Args:
        own: the settings that do not suffice.
        excess: see `Engine.finer`; a scene may lack parts.
        output_step: s.
    """
    steps, elements = own.steps_in(output_step), own.elements
    most_steps = max(steps, min(4 * steps, math.floor(output_step / SMALLEST_STEP + 1e-9)))
    if not excess:
        return own.replaced(step=output_step / min(2 * steps, most_steps)) if most_steps > steps else None
    most_elements = max(elements, min(2 * elements, MOST_ELEMENTS))
    stiffer = [factor for factor in STIFFER if factor == 1.0 or factor * own.axial_factor <= STIFFER[-1]]
    numbers_of_steps = range(steps, most_steps + 1, 1 + steps // 100)  # 1 % apart where there are hundreds
    rungs = list(itertools.product(numbers_of_steps, range(elements, most_elements + 1, 2), stiffer))[1:]

    def left(rung: tuple[int, int, float]) -> float:
        """Parts of the error over the accuracy asked for that the orders leave of `excess`."""
        in_time, in_space = excess["time"] * (steps / rung[0]) ** ORDER_IN_TIME, excess.get("space", 0.0) + excess.get("passing", 0.0)
        return in_time + in_space * (elements / rung[1]) ** ORDER_IN_SPACE + excess.get("stretch", 0.0) / rung[2]

    def cost(rung: tuple[int, int, float]) -> float:
        return rung[0] * rung[1] * (1.0 if rung[1:] == (elements, 1.0) else NEW_CABLE)

    least, worthwhile = min(map(left, rungs), default=math.inf), WORTHWHILE * sum(excess.values())
    if least > worthwhile:
        return None
    enough = max(AIM, min(NEAREST * least, worthwhile))
    chosen = min((rung for rung in rungs if left(rung) <= enough), key=cost)
    return own.replaced(elements=chosen[1], step=output_step / chosen[0], axial_factor=chosen[2] * own.axial_factor)
