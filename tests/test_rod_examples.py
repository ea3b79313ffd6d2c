"""The rod of `examples/rods/` that docs/engine.md offers to copy."""

import importlib
from pathlib import Path

import pytest

from quickreturn.plugins.conform.contract import conform

ROOT = Path(__file__).resolve().parents[1]


def test_the_adapter_is_as_short_as_the_page_says() -> None:
    lines = (ROOT / "examples" / "rods" / "mujoco_engine.py").read_text("utf-8").splitlines()
    assert f"in {len(lines)} lines" in (ROOT / "docs" / "engine.md").read_text("utf-8")


@pytest.mark.verify
def test_mujoco_conforms(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "rods"))
    found = conform(importlib.import_module("mujoco_engine").MyRod(), quiet=True)
    assert found.conforms, found.failed
