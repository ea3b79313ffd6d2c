"""The range of accuracies that a caller may ask for."""

from numbers import Real
from typing import Final

LOWEST: Final = 1e-4
HIGHEST: Final = 0.05


def checked(accuracy: float | None) -> float | None:
    """The accuracy. ValueError: it cannot be asked for."""
    if accuracy is not None and not (isinstance(accuracy, Real) and LOWEST <= accuracy <= HIGHEST):
        raise ValueError(f"accuracy={accuracy!r}: numbers from {LOWEST:g} to {HIGHEST:g} can be asked for")
    return accuracy
