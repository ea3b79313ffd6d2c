"""Recognises exceptions of libraries that get no memory."""

import re
from typing import Final

#: What libraries say: MuJoCo, C++, the system, numpy, LLVM.
_NO_MEMORY: Final = re.compile(r"(?:could not|cannot|can't|unable to|failed to) allocate|bad[_ ]alloc|(?:out of|insufficient) memory", re.I)


def lacks_memory(error: BaseException) -> bool:
    """Whether an exception says that memory could not be had: a `MemoryError`, its consequence, or a library's own words for it."""
    each: BaseException | None = error
    while each is not None:
        if isinstance(each, MemoryError) or _NO_MEMORY.search(str(each)):
            return True
        each = each.__cause__ or each.__context__
    return False
