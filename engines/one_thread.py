"""Linear algebra on one thread: the eigenproblems of the shapes are small.

A second thread makes them take up to thirty times as much of the processors, and no less time.
"""

import scipy.linalg  # noqa: F401  it has a BLAS of its own, and the limit holds for what is loaded when a function is called
from threadpoolctl import threadpool_limits

#: Decorator of a function.
on_one_thread = threadpool_limits.wrap(limits=1, user_api="blas")
