"""Discrete control barrier condition for all series of barrier values.

Xu et al., eq. (9): h(X_{k+1}) − h(X_k) ≥ −γ h(X_k), 0 < γ ≤ 1. A series is one person, or one disc
of the footprint against the walls, over the horizon. Its rows are g_k = h_{k+1} − (1 − γ) h_k ≥ 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.control.api import ConstraintRows

NEAR = 0.6
"""Rows with a margin above this cannot become active within one linearisation, m."""


class Series(NamedTuple):
    """Slacks and identifiers of the series of a barrier."""

    owner: Integers
    """(s,) index of the slack; several series may share one."""
    name: Integers
    """(s,) identifier, the same from tick to tick."""
    owners: int
    names: int


def separate(count: int) -> Series:
    """A slack of its own for each of ``count`` series."""
    each = np.arange(count)
    return Series(each, each, count, count)


def constraint_rows(
    rows: tuple[Floats, Floats, Integers, Integers], series: Series, states: int
) -> ConstraintRows:
    """Result of :func:`linearised`, or of a kernel around it, over ``states`` = N+1."""
    return ConstraintRows(*rows, series.names * (states - 1), groups=series.owners)


@njit(cache=True)
def worst(h: Floats, gamma: float, series: Series) -> tuple[Floats, float]:
    """(largest violation of each owner's rows, (owners,) ≥ 0; smallest h), from h (s, N+1)."""
    out = np.zeros(series.owners)
    smallest = np.inf
    for s in range(h.shape[0]):
        most = out[series.owner[s]]
        smallest = min(smallest, h[s, 0])
        for k in range(h.shape[1] - 1):
            most = max(most, (1.0 - gamma) * h[s, k] - h[s, k + 1])
            smallest = min(smallest, h[s, k + 1])
        out[series.owner[s]] = most
    return out, smallest


@njit(cache=True)
def near_states(h: Floats, gamma: float, near: float) -> Booleans:
    """Mask of the values of h (s, N+1) in rows with a margin below ``near``."""
    out = np.zeros(h.shape, dtype=np.bool_)
    for s in range(h.shape[0]):
        for k in range(h.shape[1] - 1):
            if h[s, k + 1] - (1.0 - gamma) * h[s, k] < near:
                out[s, k] = out[s, k + 1] = True
    return out


@njit(cache=True)
def linearised(
    h: Floats, gradient: Floats, sensitivity: Floats, gamma: float, near: float, series: Series
) -> tuple[Floats, Floats, Integers, Integers]:
    """Rows with a margin below ``near``: margin (r,), jacobian (r, N·m), owner (r,), key (r,).

    An input has no effect on earlier poses, which saves half of the products.
    h: (s, N+1).  gradient: (s, N+1, 3) of h in the pose.  sensitivity: (N+1, 3, N·m).
    """
    count, steps, columns = 0, h.shape[1] - 1, sensitivity.shape[2]
    m = columns // steps if steps else 0
    keep = 1.0 - gamma
    for s in range(h.shape[0]):
        for k in range(steps):
            if h[s, k + 1] - keep * h[s, k] < near:
                count += 1
    margin = np.empty(count)
    jacobian = np.zeros((count, columns))
    owned = np.empty(count, dtype=np.int64)
    key = np.empty(count, dtype=np.int64)
    r = 0
    for s in range(h.shape[0]):
        for k in range(steps):
            g = h[s, k + 1] - keep * h[s, k]
            if g >= near:
                continue
            margin[r] = g
            owned[r] = series.owner[s]
            key[r] = series.name[s] * steps + k
            # ∂h_{k+1}/∂u
            ahead = gradient[s, k + 1]
            gx, gy, ga = ahead[0], ahead[1], ahead[2]
            here = sensitivity[k + 1]
            for j in range(m * (k + 1)):
                jacobian[r, j] = gx * here[0, j] + gy * here[1, j] + ga * here[2, j]
            # −(1 − γ) ∂h_k/∂u
            behind = gradient[s, k]
            gx, gy, ga = keep * behind[0], keep * behind[1], keep * behind[2]
            here = sensitivity[k]
            for j in range(m * k if keep > 0.0 else 0):
                jacobian[r, j] -= gx * here[0, j] + gy * here[1, j] + ga * here[2, j]
            r += 1
    return margin, jacobian, owned, key
