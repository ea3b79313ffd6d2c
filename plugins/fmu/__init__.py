"""An FMU as an engine: a model that another tool exported, for co-simulation by FMI 2 or 3."""
