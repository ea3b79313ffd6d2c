"""FMUs that are built once, and a folder to work in with them."""

import hashlib
import shutil
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from quickreturn.plugins.fmu.tests.build import CASE, MACHINE, Make, build_chain, build_machine
from quickreturn.plugins.fmu.tests.plain import COMPILER, DECLARED, build_plain
from quickreturn.reference_model.native import cache_folder


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fmus")
    build_machine(folder)
    build_chain(folder)
    for once in (False, True) if COMPILER else ():
        build_plain(folder, once=once)
    for fmu in folder.glob("*.fmu"):
        with zipfile.ZipFile(fmu, "a") as archive:
            archive.comment = str(folder).encode()  # another hash in each test process: none removes what another one has loaded
    return folder


@pytest.fixture
def make(built: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Make]:
    """Writes declarations with replacements beside the FMUs, and works in their folder; removes what the engine has unpacked."""
    for name in ("machine.fmu", "Chain.fmu"):
        shutil.copy(built / name, tmp_path)
    (tmp_path / "case.toml").write_text(CASE)
    monkeypatch.chdir(tmp_path)

    def made(text: str = MACHINE, *changes: tuple[str, str]) -> str:
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        Path("my.toml").write_text(text)
        return "my.toml"

    yield made
    for fmu in (*built.glob("*.fmu"), *tmp_path.rglob("*.fmu")):
        digest = hashlib.sha256(fmu.read_bytes()).hexdigest()[:12]
        shutil.rmtree(cache_folder.folder() / f"fmu-{digest}", ignore_errors=True)


@pytest.fixture
def make_plain(built: Path, make: Make) -> Make:
    """As `make`, for the compiled FMU; `once`: it allows one instance in a process. The case has its drive."""
    if COMPILER is None:
        pytest.skip("there is no C compiler")
    text = CASE.replace('torque = "0.6 N*m"\ndamping = "0.05 N*m*s/rad"', 'prescribed_speed = "12 rad/s"')
    Path("case.toml").write_text(text)

    def made(*changes: tuple[str, str], once: bool = False) -> str:
        shutil.copy(built / ("once.fmu" if once else "plain.fmu"), "plain.fmu")
        return make(DECLARED, *changes)

    return made
