"""What the plugin adds: MuJoCo's machine with contact in place of a joint."""

from quickreturn.engines.plugins import Plugin

PLUGIN = Plugin(engines={"mujoco-contact": "quickreturn.plugins.as_built.contact.engine:MujocoContactEngine"})
