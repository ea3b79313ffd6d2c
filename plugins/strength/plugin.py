"""What the plugin adds: measures of loads and of the drive, what results say of loads, the command `explain`, and a chapter."""

from quickreturn.engines.plugins import Plugin

_HERE = "quickreturn.plugins.strength"
PLUGIN = Plugin(
    measures=f"{_HERE}.measures:MEASURES",
    readings={"loads": f"{_HERE}.reading:LOADS"},
    commands={
        "explain": (
            f"{_HERE}.commands:explain",
            "Say in about ten sentences what happens in a turn of CASE in its steady state, with numbers.",
        )
    },
    page=f"{_HERE}.page:PAGE",
)
