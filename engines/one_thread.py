"""Linear algebra on one thread: the eigenproblems of the shapes are small.

A second thread makes them use up to thirty times the processor time, and saves none.
"""

import scipy.linalg  # noqa: F401  it has a BLAS of its own, and the limit holds only for libraries that are loaded by then
from threadpoolctl import threadpool_limits

#: Decorator of a function.
on_one_thread = threadpool_limits.wrap(limits=1, user_api="blas")
