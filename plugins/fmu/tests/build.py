"""Builds the FMUs of the tests, and writes the files that make them engines."""

import re
import zipfile
from collections.abc import Callable
from pathlib import Path

from tests.quickreturn.program import ROOT

#: Writes declarations with replacements beside the FMUs; see the fixture `make`.
Make = Callable[..., str]

#: A mild machine, whose arm bends and hardly rings.
CASE = """
name = "mild"
title = "A mild machine"
[mechanism]
pivot_distance = "0.42 m"
[crank]
length = "0.11 m"
mass = "1.2 kg"
center_of_mass = "0.03 m"
inertia = "2e-3 kg*m^2"
torque = "0.6 N*m"
damping = "0.05 N*m*s/rad"
initial_angle = "180 deg"
[base]
inertia = "2e-5 kg*m^2"
damping = "0 N*m*s/rad"
[follower]
length = "0.6 m"
mass_per_length = "0.33 kg/m"
bending_stiffness = "20 N*m^2"
thickness = "3 mm"
width = "40 mm"
damping = "2 N*s/m^2"
strain_gauges = ["0.14 m", "0.29 m", "0.46 m"]
[tip]
mass = "0.05 kg"
inertia = "2e-6 kg*m^2"
[simulation]
duration = "0.2 s"
output_step = "1 ms"
"""

MACHINE = """
fmu = "machine.fmu"
method = "a beam of three bending modes, plain numpy"

[resolution]
steps = ["1 ms", "0.5 ms", "0.25 ms"]

[parameters]
mechanism.pivot_distance = "d [mm]"
crank.length = "r [mm]"
crank.mass = "m1"
crank.center_of_mass = "c1"
crank.inertia = "J1"
crank.initial_angle = "phi0"
crank.initial_speed = "w0"
crank.torque = "T"
crank.damping = "b"
base.inertia = "J2"
follower.length = "L"
follower.mass_per_length = "mu"
follower.bending_stiffness = "EI"
follower.damping = "c"
follower.extreme_fibre = "e"
follower.strain_gauges = ["g1", "g2", "g3"]
tip.mass = "mt"
tip.inertia = "Jt"

[outputs]
crank_angle = "phi [deg]"
crank_speed = "omega"
follower_angle = "q2"
slider_position = "s [mm]"
tip_x = "xt [mm]"
tip_y = "yt [mm]"
tip_deflection = "u [mm]"
tip_acceleration = "a"
strain_1 = "-eps1"
strain_2 = "-eps2"
strain_3 = "-1 * eps3"
slider_force = "F"
"""


def build_machine(folder: Path) -> Path:
    """The FMU of the mechanism (FMI 2), with its declarations beside it; returns these."""
    from pythonfmu.builder import FmuBuilder

    FmuBuilder.build_FMU(Path(__file__).with_name("machine.py"), dest=folder)
    (folder / "Machine.fmu").rename(folder / "machine.fmu")
    declared = folder / "machine.toml"
    declared.write_text(MACHINE)
    return declared


#: The file beside the chain's FMU, as the document shows it.
CHAIN = re.findall(r"^```toml chain.toml\n(.*?)^```$", (ROOT / "docs/engine.md").read_text("utf-8"), re.MULTILINE | re.DOTALL)[0]


def build_chain(folder: Path) -> Path:
    """The FMU of the follower alone (FMI 3), with its declarations beside it; returns these."""
    from pythonfmu3.builder import FmuBuilder

    declared = folder / "chain.toml"
    declared.write_text(CHAIN, "utf-8")
    FmuBuilder.build_FMU(Path(__file__).with_name("chain.py"), dest=folder)
    return declared


def rewritten(replace: Callable[[str, bytes], tuple[str, bytes]], fmu: str = "machine.fmu") -> None:
    """Write an FMU anew, each member by `replace`."""
    with zipfile.ZipFile(fmu) as old:
        members = [replace(name, old.read(name)) for name in old.namelist() if not name.endswith("/")]
    with zipfile.ZipFile(fmu, "w") as new:
        for name, content in members:
            new.writestr(name, content)


def described(*changes: tuple[str, str], fmu: str = "machine.fmu") -> None:
    """Change the text of an FMU's description."""

    def replace(name: str, content: bytes) -> tuple[str, bytes]:
        if name == "modelDescription.xml":
            text = content.decode()
            for old, new in changes:
                assert old in text, old
                text = text.replace(old, new)
            content = text.encode()
        return name, content

    rewritten(replace, fmu)
