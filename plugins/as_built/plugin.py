"""What the plugin adds: MuJoCo's machine with contact in place of a joint, a chapter, and a record."""

from quickreturn.engines.plugins import Plugin

_HERE = "quickreturn.plugins.as_built"
PLUGIN = Plugin(
    engines={"mujoco-contact": f"{_HERE}.contact.engine:MujocoContactEngine"},
    page=f"{_HERE}.chapter:PAGE",
    records={"as built": f"{_HERE}.chapter:rows"},
)
