"""`quickreturn linearise`: the linear model of a machine about rest or its settled cycle."""

from typing import Any, Final

import click

import quickreturn as qr
from quickreturn.commands import options
from quickreturn.commands.console import Call, check_file, write
from quickreturn.reports.output import PICTURES, OutputError

#: Readers of a crank angle, and of the number of modes.
DEGREES: Final = options.number(-1e6, 1e6, 180, of=" of degrees")
COUNT: Final = options.number(1, 40, 10, whole=True)


@options.command(
    options.case,
    options.several("--input", "inputs", metavar="NAME", required=True, help="Input: torque, tool_force, base_torque, or a key."),
    options.several("--output", "outputs", metavar="NAME", required=True, help="Column of a trajectory, such as tip_deflection."),
    options.single("--crank-angle", metavar="DEG", read=DEGREES, help="Angle of the crank at rest, degrees; default: that of the start."),
    click.option("--cycle", is_flag=True, help="Linearise about the settled cycle, from turn to turn."),
    options.single("--modes", metavar="N", read=COUNT, help="Number of natural modes; default: 10, with --cycle 5."),
    options.case_assignments,
    options.single("--output-file", metavar="FILE", help="File for A, B, C and D with names and units: .npz or .csv."),
    options.single("--plot", metavar="FILE", help=f"File for the Bode plot: {', '.join(PICTURES)}."),
    options.json,
)
def linearise(call: Call, output_file: str | None, plot: str | None, **given: Any) -> None:
    """Write the linear model of CASE with inputs and outputs: A, B, C, D, and a Bode plot.

    At rest the follower is straight, the motion small and gravity left out, as by `quickreturn modes`, but with the dampings of the scene.
    With --input torque the crank is free to turn; otherwise it is held. A follower alone is clamped at its base, or free to turn with
    --input base_torque. Input torque is all that the drive exerts on the crank [N m], tool_force acts on the flexible end across the
    follower, along b2 [N], and base_torque on the follower's base at P [N m]. All numbers are SI.

    With --cycle the model is discrete: the state as the slider passes its farthest place, a turn later. Inputs are then keys of the case
    file, such as crank.torque, constant over a turn. Exit code 3: there is no settled cycle.
    """
    loaded = call.case()
    for option, file, endings in (("--output-file", output_file, (".npz", ".csv")), ("--plot", plot, PICTURES)):
        try:
            check_file(file, loaded.source, endings)
        except OutputError as wrong:  # which the command line takes for that of --output
            raise click.UsageError(f"{option} {wrong}") from None
    model = qr.linearise(loaded, **given)
    write(output_file, model.content)
    if plot is not None:
        from quickreturn.reports.drawing.style import picture

        figure = model.plot()
        write(plot, lambda ending: picture(figure, ending))
    call.show({**model.document(), "output": output_file}, repr(model))
