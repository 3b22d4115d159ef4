"""Operations on arrays for kernels, where numba's own take long to compile.

``np.argsort`` takes a second for each type of array, and the assignment of an array to a part of
another one 0.15 s for each kernel.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.kernels import CACHED

ZERO = cast("int", np.int64(0))
"""0 as a variable: for numba, the constant 0 is a type of its own, and a kernel that gets it as
argument is compiled by itself."""
NONE = cast("int", np.int64(-1))
"""−1, likewise: no index."""


@njit(**CACHED, inline="always")
def copy_row(target: Floats | Integers, source: Floats | Integers) -> None:
    """Copy a row (n,) to the beginning of another one."""
    for index in range(source.shape[0]):
        target[index] = source[index]


@njit(**CACHED)
def stable_order(values: Floats | Integers) -> Integers:
    """Indices (n,) that sort values (n,), as ``np.argsort`` with ``kind="stable"``; NaN last.

    Merge sort. Pass contiguous values: every layout would be compiled by itself.
    """
    n = values.shape[0]
    order, merged = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    for i in range(n):
        order[i] = i
    width = 1
    while width < n:
        for start in range(0, n, 2 * width):
            middle, end = min(start + width, n), min(start + 2 * width, n)
            i, j = start, middle
            for k in range(start, end):
                right = i == middle
                if i < middle and j < end:
                    a, b = values[order[i]], values[order[j]]
                    right = b < a or (a != a and b == b)  # noqa: PLR0124  # NaN is the one that differs
                if right:
                    merged[k] = order[j]
                    j += 1
                else:
                    merged[k] = order[i]
                    i += 1
        order, merged = merged, order
        width *= 2
    return order


@njit(**CACHED)
def members_by_label(labels: Integers, count: int) -> tuple[Integers, Integers]:
    """Indices of the elements by their label: those of k are ``members[first[k]:first[k + 1]]``.

    Args:
        labels: label of each element (n,); < 0: none.
        count: number of labels.

    Returns:
        Members, in their order for each label, and ``first``, (count + 1,).
    """
    first, free = np.zeros(count + 1, dtype=np.int64), np.zeros(count + 1, dtype=np.int64)
    for i in range(labels.shape[0]):
        if labels[i] >= 0:
            first[labels[i] + 1] += 1
    for k in range(count):
        first[k + 1] += first[k]
        free[k + 1] = first[k + 1]
    members = np.empty(first[count], dtype=np.int64)
    for i in range(labels.shape[0]):
        if labels[i] >= 0:
            members[free[labels[i]]] = i
            free[labels[i]] += 1
    return members, first
