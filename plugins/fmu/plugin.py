"""What the plugin adds: engines from FMUs, each by the file beside it."""

from quickreturn.engines.plugins import Plugin

PLUGIN = Plugin(engine_files={"toml": "quickreturn.plugins.fmu.engine_file:engine_of"})
