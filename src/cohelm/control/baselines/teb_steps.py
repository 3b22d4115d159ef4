"""What a round of the timed elastic band begins with, and the step that the solver takes."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats

ROWS, BAND = 60, 12
"""Most poses of a band; entries of a matrix row on and left of its diagonal."""


@njit(cache=True)
def resized(band: Floats, wanted: float, tolerance: float) -> Floats:
    """The band with a pose put into every interval that is too long, and short ones joined."""
    out = np.empty((ROWS, 4))
    count = 0
    n = band.shape[0]
    for k in range(n):
        last = k == n - 1
        joined = count > 0 and 0 < k < n - 1 and out[count - 1, 3] < wanted - tolerance
        if joined and n > 3 and out[count - 1, 3] + band[k, 3] < wanted + tolerance:
            out[count - 1, 3] += band[k, 3]
            continue
        for i in range(4):
            out[count, i] = band[k, i]
        count += 1
        if not last and band[k, 3] > wanted + tolerance and count + n - k < ROWS:
            out[count - 1, 3] = 0.5 * band[k, 3]
            for i in range(3):
                out[count, i] = 0.5 * (band[k, i] + band[k + 1, i])
            out[count, 3] = 0.5 * band[k, 3]
            count += 1
    return out[:count].copy()


@njit(cache=True)
def solved(matrix: Floats, right: Floats, damping: float) -> Floats:
    """(JᵀJ + λ)⁻¹ Jᵀr by a banded Cholesky; the first pose stays where it is."""
    n = matrix.shape[0]
    low, x = matrix.copy(), right.copy()
    for i in range(n):
        low[i, 0] += damping
    for i in range(3):
        x[i] = 0.0
        for d in range(1, BAND):
            low[i, d] = 0.0
        low[i, 0] = 1.0
    for i in range(3, min(n, 3 + BAND)):
        for j in range(3):
            if i - j < BAND:
                low[i, i - j] = 0.0
    for i in range(n):
        first = max(0, i - BAND + 1)
        for j in range(first, i + 1):
            total = low[i, i - j]
            for m in range(max(first, j - BAND + 1), j):
                total -= low[i, i - m] * low[j, j - m]
            low[i, i - j] = math.sqrt(max(total, 1e-12)) if i == j else total / low[j, 0]
    for i in range(n):
        for m in range(max(0, i - BAND + 1), i):
            x[i] -= low[i, i - m] * x[m]
        x[i] /= low[i, 0]
    for i in range(n - 1, -1, -1):
        for m in range(i + 1, min(n, i + BAND)):
            x[i] -= low[m, m - i] * x[m]
        x[i] /= low[i, 0]
    return x
