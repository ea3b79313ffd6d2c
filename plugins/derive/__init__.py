"""Derives equations of planar mechanisms by computer; `quickreturn.derive` has the public names."""
