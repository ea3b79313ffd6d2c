"""Which engines are found, and what a broken or missing one does to the others."""

import re
import sys
from pathlib import Path

import pytest

from quickreturn.engines import registry
from quickreturn.engines.base import Refusal
from quickreturn.engines.exudyn import engine as exudyn
from quickreturn.engines.registry import MAIN, UnknownEngine, engine, engine_names, usable_engine
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.reference_model.scene_values import NAMED
from tests.engines.fake_package import FAKE_ENGINE, install
from tests.engines.scenes import run_24


def test_main_engines_come_first_and_are_always_listed() -> None:
    assert engine_names()[:4] == MAIN == ("thesis", "reference", "exudyn", "mujoco")


def test_unknown_name_is_answered_with_the_nearest_known() -> None:
    words = '"exudin": no such engine (perhaps exudyn is meant); accepted: thesis, reference, exudyn'
    with pytest.raises(UnknownEngine, match=re.escape(words) + r".* a file that declares one \(\.toml\)$"):
        engine("exudin")


def test_third_party_engine_is_found_by_entry_point(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, "fakes", {"registry_fake": FAKE_ENGINE}, {"fake": "registry_fake:FakeEngine"})
    monkeypatch.syspath_prepend(tmp_path)
    assert "fake" in engine_names()
    assert usable_engine("fake").version() == "fake 1.0"


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("crash", "registry_crash:Engine", "ZeroDivisionError"),
        ("absent", "registry_no_such_module:Engine", "No module named 'registry_no_such_module'"),
        ("lacks", "registry_good:Nothing", "Nothing"),
        ("no_class", "registry_good:error_of", "not a class derived from engines.base.Engine"),
        ("abstract", "quickreturn.engines.base:Engine", "abstract"),
        ("renamed", "registry_good:FakeEngine", 'calls itself "fake"'),
        ("older", "registry_older:Engine", "version 0 of the engines' interface"),
        ("boaster", "registry_boaster:Engine", 'estimates = "everything"; accepted: total, integration, unverified'),
    ],
)
def test_broken_third_party_engine_is_listed_with_the_reason(
    name: str, value: str, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    boaster = "from registry_good import FakeEngine\nclass Engine(FakeEngine):\n    name = 'boaster'\n    estimates = 'everything'\n"
    older = "from registry_good import FakeEngine\nclass Engine(FakeEngine):\n    name = 'older'\n    interface = 0\n"
    modules = {"registry_crash": "1 / 0\n", "registry_good": FAKE_ENGINE, "registry_boaster": boaster, "registry_older": older}
    install(tmp_path, "broken", modules, {name: value})
    monkeypatch.syspath_prepend(tmp_path)
    assert name in engine_names()
    assert reason in str(engine(name).unavailable())
    with pytest.raises(Refusal, match=f"engine {name} is not available"):
        usable_engine(name)
    with pytest.raises(Refusal, match=f"engine {name} is not available"):
        engine(name).check(run_24())


def test_two_packages_with_one_engine_name_are_not_chosen_between(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package in ("first", "second"):
        install(tmp_path, package, {f"registry_{package}": FAKE_ENGINE}, {"fake": f"registry_{package}:FakeEngine"})
    monkeypatch.syspath_prepend(tmp_path)
    reason = str(engine("fake").unavailable())
    assert "2 packages" in reason
    assert "first" in reason
    assert "second" in reason


def test_third_party_engine_cannot_replace_a_main_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, "thief", {"registry_thief": "1 / 0\n"}, {"reference": "registry_thief:Engine"})
    monkeypatch.syspath_prepend(tmp_path)
    assert engine_names().count("reference") == 1
    engine("reference")
    assert "registry_thief" not in sys.modules


def test_missing_library_disables_its_own_engine_only(monkeypatch: pytest.MonkeyPatch) -> None:
    # An engine whose module cannot be imported because the library behind it is absent; the registry's table is what leads to it.
    monkeypatch.setattr(registry, "_MODULES", {**registry._MODULES, "exudyn": "quickreturn.engines.no_such_library:ExudynEngine"})
    assert "No module named 'quickreturn.engines.no_such_library'" in str(engine("exudyn").unavailable())
    assert engine_names()[:4] == MAIN


def test_what_estimates_are_of() -> None:
    # how far the models of `thesis` and `moving-boundaries` are off no run of their own can show; of `nodal-load` coarser and finer
    # runs break down
    found = {name: engine(name).estimates for name in (*MAIN, *RIVALS)}
    others = {"thesis": "integration", "nodal-load": "unverified", "moving-boundaries": "integration"}
    assert found == {**dict.fromkeys((*MAIN, *RIVALS), "total"), **others}


def test_quantities_of_all_engines_are_known() -> None:
    assert {name for each in engine_names() for name in engine(each).quantities} <= set(NAMED)


def test_an_old_exudyn_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exudyn, "installed", lambda name: "1.11.0")
    assert exudyn.ExudynEngine().unavailable() == "exudyn 1.11.0 is installed, 1.13.6 or later is needed"
