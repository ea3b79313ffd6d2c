"""The description of a case for another tool, as a text: values, conventions, the start, and the columns to record."""

import math
import textwrap
from importlib.resources import files
from typing import Any, Final

import jinja2

from quickreturn.cases.comparison.first_row import standard_row
from quickreturn.cases.comparison.tables import LARGEST_GAP, LEFT_OUT, ROWS_PER_PERIOD
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.keys import SECTIONS
from quickreturn.cases.motion.time_scale import TURN, time_scale
from quickreturn.reference_model.columns import AXIAL, BENDING, COLUMNS
from quickreturn.reference_model.joint import rollers
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import crank_pace, rigid_motion
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.tip import WHOLE, Tip

#: Largest number of letters in a line of prose.
WIDTH: Final = 110
#: Size, in SI units, below which a number of the start is zero except for rounding.
ROUNDING: Final = 1e-12
#: Columns that another tool need not record: they do not describe a closed mechanism, or their convention depends on the engine.
_NOT_ASKED: Final = (*LEFT_OUT, *BENDING, *AXIAL, "base_torque", "axial_stretch", "gravity_energy", "dissipated_energy", "drive_work")


def for_other_tools(case: Case, given: str) -> str:
    """The description.

    Args:
        case: a closed mechanism.
        given: the name or path of the case, as on the command line.

    Raises:
        CaseError: there is no crank.
    """
    mechanism = case.mechanism
    pace = crank_pace(mechanism)
    not_asked = _NOT_ASKED if mechanism.acting_spring is not None else (*_NOT_ASKED, "spring_force")
    columns = [(name, column.unit.replace(" ", "*"), column.meaning) for name, column in COLUMNS.items() if name not in not_asked]
    follower, tip = mechanism.follower, mechanism.tip_body
    template = jinja2.Environment(undefined=jinja2.StrictUndefined, keep_trailing_newline=False).from_string(
        (files("quickreturn.reports") / "templates" / "other_tools.jinja").read_text("utf-8")
    )
    text = template.render(
        case=case,
        given=given,
        parts=_parts(case),
        follower=follower,
        slider=mechanism.slider,
        friction_torque=mechanism.base.friction_torque,
        pivot_rate=mechanism.base.friction_rate,
        drive=mechanism.crank.drive,
        axial_stiffness=0.0 if follower.is_rigid else follower.axial_stiffness,
        law=rollers(mechanism.slider),
        gravity=any(mechanism.gravity),
        spring=mechanism.acting_spring,
        tip=tip,
        tip_force=tip.is_forced,
        whole_turn=tip.force_to - tip.force_from >= WHOLE,
        start=_start(mechanism),
        columns=columns,
        gap=_gap(mechanism, pace),
        turn=2.0 * math.pi / pace if pace > 0.0 else math.inf,
        header=",".join(f"{name} [{unit}]" for name, unit, _ in columns),
        value=_value,
    )
    return "\n".join(_wrapped(line) for line in text.splitlines())


def _wrapped(line: str) -> str:
    """Prose in lines of limited length; tables and the line of headings stay as they are."""
    if line.startswith(("  ", "time [", "Then: ")):
        return line
    return textwrap.fill(
        line, WIDTH, subsequent_indent="  " if line.startswith("- ") else "", break_long_words=False, break_on_hyphens=False
    )


def _parts(case: Case) -> dict[str, list[tuple[str, str, str, str]]]:
    """Section of the case file -> name, value, unit and meaning of each of its quantities that affects the motion."""
    parts: dict[str, list[tuple[str, str, str, str]]] = {}
    for section, values in case.values.items():
        if section == "simulation" or (section == "slider" and case.mechanism.slider == Slider()):
            continue  # a slider that is only a point on the follower
        keys, hidden = SECTIONS[section], _idle_keys(case.mechanism.tip_body) if section == "tip" else set()
        parts[section] = [
            (name, _value(value), keys[name].unit, keys[name].meaning)
            for name, value in values.items()
            if keys[name].moves
            and not keys[name].in_file  # a table stands with the forces
            and name not in hidden
            and not ((section in ("slider", "spring") or name in ("friction_torque", "material_damping")) and value == keys[name].default)
        ]
    return parts


def _idle_keys(tip: Tip) -> set[str]:
    """Keys of a tip that say nothing about its motion."""
    idle = {key for key in ("force", "force_following") if not any(getattr(tip, key))}
    if tip.force_scale == 1.0:
        idle.add("force_scale")
    if not tip.is_forced or tip.force_table:
        idle |= {"force_from", "force_to", "force_ramp"}
    return idle if tip.friction_force > 0.0 else idle | {"friction_force", "friction_speed"}


def _start(mechanism: Mechanism) -> list[tuple[str, str, str]]:
    """Place and rates at the start: name, value, unit."""
    row = standard_row(mechanism)
    motion = rigid_motion(mechanism, row["crank_angle"], row["crank_speed"])  # type: ignore[arg-type]  # a number is an array, too
    rates = {"follower_speed": (float(motion.follower_speed), "rad/s"), "slider_speed": (float(motion.slider_speed), "m/s")}
    places = {name: (number, COLUMNS[name].unit) for name, number in row.items() if name != "time" and not name.startswith("strain")}
    return [(name, _value(number if abs(number) > ROUNDING else 0.0), unit) for name, (number, unit) in (places | rates).items()]


def _gap(mechanism: Mechanism, pace: float) -> float:
    """Largest time between rows, s, that resolves both the turn and the first mode; `pace` is the mean crank speed, rad/s."""
    scale = time_scale(mechanism)
    shortest = 1.0 / float(scale.frequencies(TURN)[:, 0].max()) if scale else math.inf
    return min(LARGEST_GAP * 2.0 * math.pi / pace if pace > 0.0 else math.inf, shortest / ROWS_PER_PERIOD)


def _value(number: Any) -> str:
    """A number, or a list of numbers, in digits that read back as the same number."""
    return ", ".join(map(_value, number)) if isinstance(number, (list, tuple)) else repr(float(number))
