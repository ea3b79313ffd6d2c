"""The documentation site is built without a warning, a lost link or an unknown name."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.package_copy import ROOT

#: As `make docs` has them.
OPTIONS = ("--builder", "html", "--conf-dir", "docs/site", "--fail-on-warning", "--keep-going", "--nitpicky")


@pytest.mark.verify
def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sphinx", "--quiet", *OPTIONS, "--doctree-dir", str(tmp_path / "trees"), ".", str(tmp_path / "site")]
    found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    assert (tmp_path / "site/index.html").is_file()
