"""What the plugin adds: a command."""

from quickreturn.engines.plugins import Plugin

PLUGIN = Plugin(
    commands={
        "linearise": (
            "quickreturn.plugins.linear.command:linearise",
            "Write the linear model of CASE with inputs and outputs: A, B, C, D, and a Bode plot.",
        )
    }
)
