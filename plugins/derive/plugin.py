"""What the plugin adds: an engine whose equations the computer derives."""

from quickreturn.engines.plugins import Plugin

PLUGIN = Plugin(engines={"derived": "quickreturn.plugins.derive.witness.engine:DerivedEngine"})
