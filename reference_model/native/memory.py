"""Tuples of numbers and arrays laid out in memory for compiled code, which reads them by address; the compiler has no part in this."""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array

#: Arrays by their number of dimensions, C-contiguous.
Vector = NDArray[np.float64]
ComplexVector = NDArray[np.complex128]
Matrix = NDArray[np.float64]
Cube = NDArray[np.float64]
ComplexMatrix = NDArray[np.complex128]
#: What a member of a tuple may be annotated with, other than a tuple or a record -> its number of dimensions, and type of its numbers.
KINDS: Final[dict[str, tuple[int, type]]] = {
    "float": (0, float),
    "int": (0, int),
    "bool": (0, bool),
    "Vector": (1, float),
    "ComplexVector": (1, complex),
    "Matrix": (2, float),
    "Cube": (3, float),
    "ComplexMatrix": (2, complex),
}


def annotations_of(named_tuple: Any) -> dict[str, str]:
    """The text of the annotation of each member."""
    return {name: getattr(text, "__forward_arg__", text) for name, text in named_tuple.__annotations__.items()}


def on_lines(shape: tuple[int, ...]) -> Array:
    """An array of zeros that begins at a cache line (64 bytes), so that the four numbers of one register lie in one line.

    Otherwise half of all groups of four lie across two lines, which costs the integrals a third to a half of their time.
    """
    memory = np.zeros(math.prod(shape) + 7)
    first = -memory.ctypes.data % 64 // 8
    return memory[first : first + math.prod(shape)].reshape(shape)


class Placed:
    """A tuple of constants and arrays laid out in memory for compiled code; the object keeps the arrays alive.

    A member takes words of eight bytes: a number one, an array its place and its shape, a record its place, a tuple its members.

    Args:
        value: the tuple.

    Attributes:
        address: of its memory.

    Raises:
        TypeError: a member is not what its annotation says.
    """

    def __init__(self, value: Any) -> None:
        self.value = value
        words = _words(value)
        self._memory = on_lines((len(words),))
        whole = self._memory.view(np.int64)
        for place, word in enumerate(words):
            (self._memory if isinstance(word, float) else whole)[place] = word
        self.address = int(self._memory.ctypes.data)


def _words(value: Any) -> list[float]:
    """The words of a tuple: numbers, and places as whole numbers."""
    found: list[float] = []
    for name, annotation in annotations_of(type(value)).items():
        member = getattr(value, name)
        dimensions, kind = KINDS.get(annotation, (0, np.record))
        if isinstance(member, tuple):
            good, words = type(member).__name__ == annotation, _words(member)
        elif dimensions == 0:
            good, words = isinstance(member, kind), [member.__array_interface__["data"][0] if isinstance(member, np.record) else member]
        else:
            good = isinstance(member, np.ndarray) and member.flags.carray and member.dtype == kind and member.ndim == dimensions
            words = [member.ctypes.data, *member.shape] if good else []
        if not good:  # compiled code would read numbers that are not there
            raise TypeError(f"not as annotated: {name} of {type(value).__name__}")
        found += words
    return found
