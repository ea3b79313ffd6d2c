"""The chapters on the thesis: each is a module and a template of the same name."""
