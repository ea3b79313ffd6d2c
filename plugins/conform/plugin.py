"""What the plugin adds: a command, a column of the report's table of engines, and a record."""

from quickreturn.engines.plugins import Plugin

_HERE = "quickreturn.plugins.conform"
_CONFORM = "Test ENGINE: rows, columns, quantities of the scene, ladder, estimates, frequencies, failures."
PLUGIN = Plugin(
    commands={"conform": (f"{_HERE}.command:conform", _CONFORM)},
    page=f"{_HERE}.records:PAGE",
    records={"conformance": f"{_HERE}.records:rows"},
)
