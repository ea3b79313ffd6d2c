"""The range of accuracies (relative errors of the tip deflection) that a caller may ask for."""

from numbers import Real
from typing import Final

LOWEST: Final = 1e-4
HIGHEST: Final = 0.05


def checked(accuracy: float | None) -> float | None:
    """The accuracy itself, which may be None. ValueError: it is no number in the range."""
    if accuracy is not None and not (isinstance(accuracy, Real) and LOWEST <= accuracy <= HIGHEST):
        raise ValueError(f"accuracy={accuracy!r}: numbers from {LOWEST:g} to {HIGHEST:g} can be asked for")
    return accuracy
