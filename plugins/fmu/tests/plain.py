"""Compiles the FMU of plain.c, with a description whose flags a test chooses, and declares it as an engine."""

import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Final

COMPILER: Final = shutil.which("gcc") or shutil.which("cc")
_PARAMETERS: Final = ("d", "r", "w", "phi0", "L", "unused")
_OUTPUTS: Final = ("phi", "omega", "q2", "s", "xt", "yt", "u", "a", "eps", "F")
#: Other parameters: type, name, value reference, start.
_OTHERS: Final = (("Integer", "mode", 0, "0"), ("Integer", "count", 1, "0"), ("Boolean", "flag", 0, "false"), ("String", "label", 0, ""))
_UNITS: Final = {"xt": "length", "u": "thou", "phi": "rad"}

DECLARED: Final = """
fmu = "plain.fmu"
[parameters]
mechanism.pivot_distance = "d"
crank.length = "r"
crank.prescribed_speed = "w"
crank.initial_angle = "phi0"
follower.length = "L"
[fixed]
crank.mass = "1.2 kg"
crank.center_of_mass = "0.03 m"
crank.inertia = "2e-3 kg*m^2"
base.inertia = "2e-5 kg*m^2"
follower.mass_per_length = "0.33 kg/m"
follower.bending_stiffness = "20 N*m^2"
follower.damping = "2 N*s/m^2"
follower.extreme_fibre = "1.5 mm"
follower.strain_gauges = ["0.14 m", "0.29 m", "0.46 m"]
tip.mass = "0.05 kg"
tip.inertia = "2e-6 kg*m^2"
[set]
mode = 0
[outputs]
crank_angle = "phi"
crank_speed = "omega"
follower_angle = "q2"
slider_position = "s"
tip_x = "xt"
tip_y = "yt"
tip_deflection = "u"
tip_acceleration = "a"
strain_1 = "eps"
strain_2 = "eps"
strain_3 = "eps"
slider_force = "F"
"""


def build_plain(folder: Path, *, once: bool = False) -> None:
    """Write plain.fmu into a folder; or, with `once`, once.fmu, which allows one instance in a process."""
    import fmpy

    assert COMPILER is not None
    library = folder / f"plain{fmpy.sharedLibraryExtension}"
    source = Path(__file__).with_name("plain.c")
    once_defined = ["-DONCE"] if once else []
    subprocess.run([COMPILER, "-shared", "-fPIC", "-O1", "-w", *once_defined, str(source), "-o", str(library), "-lm"], check=True)
    with zipfile.ZipFile(folder / ("once.fmu" if once else "plain.fmu"), "w") as fmu:
        fmu.write(library, f"binaries/{fmpy.platform}/{library.name}")
        fmu.writestr("modelDescription.xml", _description(once))


def _description(once: bool) -> str:
    parameters = [("Real", name, place, "0") for place, name in enumerate(_PARAMETERS)]
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{place}" causality="parameter" variability="fixed"><{kind} start="{start}"/>'
        "</ScalarVariable>"
        for kind, name, place, start in (*parameters, *_OTHERS)
    ) + "".join(
        f'<ScalarVariable name="{name}" valueReference="{place}" causality="output"><Real unit="{_UNITS.get(name, "")}"/></ScalarVariable>'
        for place, name in enumerate(_OUTPUTS, len(_PARAMETERS))
    )
    units = {"length": 'm="1"', "thou": 'm="1" factor="0.001"', "rad": 'rad="1"'}
    return f"""<fmiModelDescription fmiVersion="2.0" modelName="plain" guid="plain">
<CoSimulation modelIdentifier="plain" canBeInstantiatedOnlyOncePerProcess="{str(once).lower()}"/>
<UnitDefinitions>{"".join(f'<Unit name="{name}"><BaseUnit {base}/></Unit>' for name, base in units.items())}</UnitDefinitions>
<ModelVariables>{variables}</ModelVariables>
<ModelStructure/>
</fmiModelDescription>"""
