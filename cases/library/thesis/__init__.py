"""The 24 runs of the thesis, with their published numbers as tables in `data/`."""

import csv
import functools
import tomllib
from importlib.resources import files
from types import MappingProxyType
from typing import Any


@functools.cache
def read_table(name: str) -> tuple[MappingProxyType[str, str], ...]:
    """The rows of a CSV file of the folder `data`, column -> text. Lines that begin with # are remarks."""
    lines = (files(__name__) / "data" / name).read_text("utf-8").splitlines()
    return tuple(MappingProxyType(row) for row in csv.DictReader(line for line in lines if not line.startswith("#")))


@functools.cache
def read_toml(name: str) -> MappingProxyType[str, Any]:
    """The content of a TOML file of the folder `data`."""
    return MappingProxyType(tomllib.loads((files(__name__) / "data" / name).read_text("utf-8")))
