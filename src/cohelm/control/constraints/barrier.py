"""The discrete control barrier condition, for every series of barrier values alike.

Xu et al., eq. (9): h(X_{k+1}) − h(X_k) ≥ −γ h(X_k), 0 < γ ≤ 1. A series is one person, or one disc
of the footprint against the walls, over the horizon. Its rows are g_k = h_{k+1} − (1 − γ) h_k ≥ 0.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers

NEAR = 0.6
"""Rows with a margin above this cannot become active within one linearisation, m."""


@njit(cache=True)
def worst(h: Floats, gamma: float) -> tuple[Floats, float]:
    """(worst violation of each series' rows, (s,) ≥ 0; smallest h of all), from h (s, N+1)."""
    return worst_of(h, gamma, np.arange(h.shape[0]), h.shape[0])


@njit(cache=True)
def worst_of(h: Floats, gamma: float, owner: Integers, owners: int) -> tuple[Floats, float]:
    """The same by the owners (s,) of the series, which share what they need: (owners,) ≥ 0."""
    out = np.zeros(owners)
    smallest = np.inf
    for s in range(h.shape[0]):
        most = out[owner[s]]
        smallest = min(smallest, h[s, 0])
        for k in range(h.shape[1] - 1):
            most = max(most, (1.0 - gamma) * h[s, k] - h[s, k + 1])
            smallest = min(smallest, h[s, k + 1])
        out[owner[s]] = most
    return out, smallest


@njit(cache=True)
def near_states(h: Floats, gamma: float, near: float) -> Booleans:
    """Which values of h (s, N+1) a row with a margin below ``near`` needs."""
    out = np.zeros(h.shape, dtype=np.bool_)
    for s in range(h.shape[0]):
        for k in range(h.shape[1] - 1):
            if h[s, k + 1] - (1.0 - gamma) * h[s, k] < near:
                out[s, k] = out[s, k + 1] = True
    return out


@njit(cache=True)
def rows(
    h: Floats, gradient: Floats, sensitivity: Floats, gamma: float, near: float
) -> tuple[Floats, Floats, Integers, Integers]:
    """The rows with a margin below ``near``: margin (r,), jacobian (r, N·m), series (r,), key (r,).

    An input has no effect on the poses before it, so that half of the products are zero.
    h: (s, N+1).  gradient: (s, N+1, 3) of h in the pose.  sensitivity: (N+1, 3, N·m).
    """
    each = np.arange(h.shape[0])
    return rows_of(h, gradient, sensitivity, gamma, near, each, each)


@njit(cache=True)
def rows_of(  # noqa: PLR0917  # a kernel takes plain arrays
    h: Floats,
    gradient: Floats,
    sensitivity: Floats,
    gamma: float,
    near: float,
    owner: Integers,
    name: Integers,
) -> tuple[Floats, Floats, Integers, Integers]:
    """The same of series that have owners (s,), named instead of these, and names (s,) for keys."""
    series, steps, columns = h.shape[0], h.shape[1] - 1, sensitivity.shape[2]
    m = columns // steps if steps else 0
    keep = 1.0 - gamma
    count = 0
    for s in range(series):
        for k in range(steps):
            if h[s, k + 1] - keep * h[s, k] < near:
                count += 1
    margin = np.empty(count)
    jacobian = np.zeros((count, columns))
    owned = np.empty(count, dtype=np.int64)
    key = np.empty(count, dtype=np.int64)
    r = 0
    for s in range(series):
        for k in range(steps):
            g = h[s, k + 1] - keep * h[s, k]
            if g >= near:
                continue
            margin[r] = g
            owned[r] = owner[s]
            key[r] = name[s] * steps + k
            ahead = gradient[s, k + 1]
            gx, gy, ga = ahead[0], ahead[1], ahead[2]
            here = sensitivity[k + 1]
            for j in range(m * (k + 1)):
                jacobian[r, j] = gx * here[0, j] + gy * here[1, j] + ga * here[2, j]
            behind = gradient[s, k]
            gx, gy, ga = keep * behind[0], keep * behind[1], keep * behind[2]
            here = sensitivity[k]
            for j in range(m * k if keep > 0.0 else 0):
                jacobian[r, j] -= gx * here[0, j] + gy * here[1, j] + ga * here[2, j]
            r += 1
    return margin, jacobian, owned, key
