"""What the plugin adds: the content of reports on runs of the thesis, and records of its studies."""

from quickreturn.engines.plugins import Plugin

_HERE = "quickreturn.plugins.thesis"
PLUGIN = Plugin(
    page=f"{_HERE}.content:PAGE",
    records={
        "finding": f"{_HERE}.records:finding_rows",
        "planted": f"{_HERE}.records:planted_rows",
        "starts": f"{_HERE}.records:start_rows",
    },
)
