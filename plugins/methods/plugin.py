"""What the plugin adds: rival methods, commands that compare methods, chapters on them, and records of their studies."""

from quickreturn.engines.plugins import Plugin

_HERE = "quickreturn.plugins.methods"
_BENCHMARK = "Find what each method needs for an error, in seconds and evaluations, from the standard start of each CASE."
_ADVISE = "Say where CASE lies on the map of classes, and which methods were the fastest there to an error."
PLUGIN = Plugin(
    engines={
        "fixed-shapes": f"{_HERE}.rivals.fixed_shapes:ENGINE",
        "multiplier": f"{_HERE}.rivals.multiplier:ENGINE",
        "stiff-spring": f"{_HERE}.rivals.stiff_spring:ENGINE",
        "nodal-load": f"{_HERE}.rivals.nodal_load:ENGINE",
        "moving-boundaries": f"{_HERE}.rivals.moving_boundaries:MovingBoundariesEngine",
    },
    commands={"benchmark": (f"{_HERE}.commands:benchmark", _BENCHMARK), "advise": (f"{_HERE}.commands:advise", _ADVISE)},
    page=f"{_HERE}.page:PAGE",
    records={
        "benchmark": f"{_HERE}.studies:front_rows",
        "hard scenes": f"{_HERE}.studies:hard_scene_rows",
        "classes": f"{_HERE}.studies:class_rows",
    },
)
