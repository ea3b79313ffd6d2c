"""What the plugin adds: a command, a column of the report's table of engines, and a record."""

from quickreturn.engines.plugins import Plugin

PLUGIN = Plugin(
    page="quickreturn.plugins.conform.records:PAGE",
    records={"conformance": "quickreturn.plugins.conform.records:rows"},
)
