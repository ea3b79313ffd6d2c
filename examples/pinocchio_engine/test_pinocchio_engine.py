"""Does the engine do what it says? Run by pytest where the package is installed; takes minutes."""

import numpy as np
import pytest

import quickreturn as qr


def test_it_is_announced_under_its_name() -> None:
    engine = qr.engine("pinocchio")
    assert engine.unavailable() is None
    assert engine.version().startswith("pin 4")


def test_it_conforms() -> None:
    found = qr.conform("pinocchio")
    assert found.conforms, found.failed


@pytest.mark.parametrize(("links", "error"), [(8, 0.012), (16, 0.003)])
def test_the_error_falls_with_the_number_of_links(links: int, error: float) -> None:
    reference = qr.simulate("thesis-24", "reference", accuracy=1e-3)["tip_deflection"]
    chain = qr.simulate("thesis-24", "pinocchio", settings={"resolution": links})["tip_deflection"]
    assert np.sqrt(np.mean((chain - reference) ** 2) / np.mean(reference**2)) < error
