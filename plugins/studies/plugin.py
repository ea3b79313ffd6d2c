"""What the plugin adds: commands that study a machine, and which quantities of a scene would explain a table."""

from quickreturn.engines.plugins import Plugin

_HERE = "quickreturn.plugins.studies"
PLUGIN = Plugin(
    commands={
        "sweep": (f"{_HERE}.commands:sweep", "Measure the settled motion of every machine of a grid."),
        "uncertainty": (
            f"{_HERE}.commands:uncertainty",
            "Say how much measures scatter because quantities do: bands, and the share of each quantity.",
        ),
        "resonance": (f"{_HERE}.commands:resonance", "Follow the periodic motion of CASE over the crank's speed or another key."),
        "calibrate": (f"{_HERE}.commands:calibrate", "Find parameters of CASE from a recorded table by least squares."),
    },
    leads=f"{_HERE}.uncertainty.quantities:explanations",
)
