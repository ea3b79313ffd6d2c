"""Public name of the plugin that derives equations of planar mechanisms: `from quickreturn.derive import Model, System, turned`."""

from quickreturn.plugins.derive import *  # noqa: F403
from quickreturn.plugins.derive import __all__ as __all__
