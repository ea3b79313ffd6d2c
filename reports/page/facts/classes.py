"""Facts of the chapter on the fastest method in each class of machines."""

import math
from typing import Any

from quickreturn.cases.classes.grid import ROWS, TURNS, grid
from quickreturn.cases.classes.groups import MEANINGS
from quickreturn.cases.classes.map import TIMES, Map
from quickreturn.cases.classes.measurement import LEVELS, LIMIT
from quickreturn.reports.page.answer import is_own
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import classes as tables
from quickreturn.reports.words import percent


def classes(content: Content) -> dict[str, Any] | None:
    """The facts for `chapters/classes.html`; None if no map was recorded."""
    class_map = content.classes
    if not class_map.scenes:
        return None
    contests = [_contest(class_map, level, by) for level in LEVELS for by in TIMES]
    differences = [scene.difference for scene in class_map.scenes if scene.difference is not None]
    return {
        "of_record": content.of_record.get("classes"),
        "scenes": len(class_map.scenes),
        "missing": len(list(grid())) - len(class_map.scenes),
        "contests": contests,
        "own": [name for name in dict.fromkeys(reach.engine for reach in class_map.reaches) if is_own(name)],
        "meanings": MEANINGS,
        "sharp": max(differences, default=None),
        "blunt": [scene.name for scene in class_map.scenes if scene.difference is None or scene.difference > 0.1 * LEVELS[-1]],
        "turns": TURNS,
        "rows": ROWS,
        "limit": LIMIT,
        "maps": [(f"{by}, to {percent(level, 'g')}", tables.class_map(class_map, level, by)) for by in TIMES for level in LEVELS],
        "failing": tables.failing(class_map),
        "cells": tables.cells(class_map),
    }


def _contest(class_map: Map, level: float, by: str) -> dict[str, Any]:
    """Wins of each engine, and how many times as long the runner-up takes where the most frequent winner is first."""
    factors_of = class_map.factors(level, by)
    factors = [factor for factor in next(iter(factors_of.values()), []) if factor < math.inf]
    return {"level": level, "by": by, "wins": {name: len(lead) for name, lead in factors_of.items()}, "factors": factors}
