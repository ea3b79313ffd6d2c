"""Every key of a case file: what it measures, which values make sense, and whether it may be left out."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

from cases import units
from cases.units import Dimension

Sign = Literal["any", "not negative", "positive"]


@dataclass(frozen=True)
class Key:
    """One key with a quantity, or a list of `count` quantities.

    Attributes:
        dimension: what it measures.
        sign: which signs make sense.
        default: SI value where the key may be left out, else None. A key that only another key makes superfluous has none.
        count: length of the list, or None for a single quantity.
        infinity_accepted: whether "inf" stands for a rigid part.
    """

    dimension: Dimension
    sign: Sign = "any"
    default: float | tuple[float, ...] | None = None
    count: int | None = None
    infinity_accepted: bool = False


#: Keys of the file by section. Tip and slider may be left out; so may crank, with slider and mechanism, where the base is spun up.
SECTIONS: Final = MappingProxyType(
    {
        "mechanism": {
            "pivot_distance": Key(units.LENGTH, "positive"),
            "gravity": Key(units.ACCELERATION, default=(0.0, 0.0), count=2),
        },
        "crank": {
            "length": Key(units.LENGTH, "positive"),
            "mass": Key(units.MASS, "not negative"),
            "center_of_mass": Key(units.LENGTH),
            "inertia": Key(units.MOMENT_OF_INERTIA, "not negative"),
            "torque": Key(units.TORQUE),
            "damping": Key(units.ROTARY_DAMPING, "not negative"),
            "initial_angle": Key(units.ANGLE),
            "initial_speed": Key(units.ANGULAR_SPEED),
            "prescribed_speed": Key(units.ANGULAR_SPEED),
        },
        "base": {
            "inertia": Key(units.MOMENT_OF_INERTIA, "not negative"),
            "damping": Key(units.ROTARY_DAMPING, "not negative"),
            "spin_up_speed": Key(units.ANGULAR_SPEED),
            "spin_up_time": Key(units.TIME, "positive"),
        },
        "follower": {
            "length": Key(units.LENGTH, "positive"),
            "mass_per_length": Key(units.MASS_PER_LENGTH, "positive"),
            "bending_stiffness": Key(units.BENDING_STIFFNESS, "positive", infinity_accepted=True),
            "thickness": Key(units.LENGTH, "positive"),
            "width": Key(units.LENGTH, "positive"),
            "damping": Key(units.DAMPING_PER_LENGTH, "not negative"),
            "strain_gauges": Key(units.LENGTH, "not negative", count=3),
        },
        "tip": {
            "mass": Key(units.MASS, "not negative"),
            "inertia": Key(units.MOMENT_OF_INERTIA, "not negative"),
            "center_of_mass": Key(units.LENGTH, default=0.0),
        },
        "slider": {
            "mass": Key(units.MASS, "not negative", default=0.0),
            "inertia": Key(units.MOMENT_OF_INERTIA, "not negative", default=0.0),
            "joint_stiffness": Key(units.STIFFNESS, "positive", default=float("inf"), infinity_accepted=True),
            "joint_damping": Key(units.DAMPING, "not negative", default=0.0),
        },
        "simulation": {
            "duration": Key(units.TIME, "positive"),
            "output_step": Key(units.TIME, "positive"),
        },
    }
)
OPTIONAL_SECTIONS: Final = frozenset({"tip", "slider"})
#: Sections that a follower alone need not have, or must not have.
SECTIONS_OF_MECHANISM: Final = frozenset({"mechanism", "crank", "slider"})
#: Keys that turn the base of a follower alone; a file with a crank must not have them.
SPIN_UP: Final = ("base.spin_up_speed", "base.spin_up_time")
#: Keys outside all sections, with the TOML type in words.
HEADER: Final = MappingProxyType({"name": "a string", "title": "a string", "tags": "a list of strings"})
#: The two ways of driving the crank exclude each other.
PRESCRIBED: Final = "crank.prescribed_speed"
TORQUE_DRIVEN: Final = ("crank.torque", "crank.damping", "crank.initial_speed")


def key_of(path: str) -> Key:
    """The key at a dotted path, e.g. "crank.length". Raises KeyError if there is none."""
    section, _, name = path.partition(".")
    return SECTIONS[section][name]


def all_paths() -> tuple[str, ...]:
    """Dotted paths of all keys with quantities, in the order of the file."""
    return tuple(f"{section}.{name}" for section, keys in SECTIONS.items() for name in keys)
