"""Discrete-time control barrier condition (DCBF), shared by all barriers.

Xu et al., eq. (9): h(X_{k+1}) − h(X_k) ≥ −γ h(X_k), 0 < γ ≤ 1. A series is one person, or one disc
of the footprint against the walls, over the horizon. Its rows are

    g_k = h_{k+1} − (1 − γ) h_k ≥ 0.

A barrier evaluates h and ∂h/∂pose. This module makes of them the slacks
(:func:`largest_violations`) and the linearised rows (:func:`linearise_dcbf`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.control.api import ConstraintRows

NEAR = 0.6
"""Rows with g above this cannot become active within one linearisation, m."""


class BarrierLayout(NamedTuple):
    """Slack and identifier of each series of a barrier."""

    slack_index: Integers
    """(s,) index of the slack; several series may share one."""
    series_id: Integers
    """(s,) identifier, the same from tick to tick."""
    num_slacks: int
    num_series_ids: int


class LinearisedRows(NamedTuple):
    """Rows of :func:`linearise_dcbf`; see ``ConstraintRows``."""

    margin: Floats
    """g, (r,)."""
    jacobian: Floats
    """dg/du, (r, N·m)."""
    slack_index: Integers
    """(r,)."""
    row_id: Integers
    """(r,)."""


def separate_slacks(count: int) -> BarrierLayout:
    """The layout of ``count`` series, each with a slack of its own."""
    each = np.arange(count)
    return BarrierLayout(each, each, count, count)


def constraint_rows(rows: LinearisedRows, layout: BarrierLayout, states: int) -> ConstraintRows:
    """The rows of a barrier over ``states`` = N+1 for the quadratic program."""
    return ConstraintRows(
        margin=rows.margin,
        jacobian=rows.jacobian,
        slack_index=rows.slack_index,
        row_id=rows.row_id,
        num_row_ids=layout.num_series_ids * (states - 1),
        num_slacks=layout.num_slacks,
    )


@njit(cache=True)
def largest_violations(h: Floats, gamma: float, layout: BarrierLayout) -> tuple[Floats, float]:
    """(largest −g of the rows of each slack, (num_slacks,) ≥ 0; smallest h), from h (s, N+1)."""
    violations = np.zeros(layout.num_slacks)
    smallest = np.inf
    for s in range(h.shape[0]):
        largest = violations[layout.slack_index[s]]
        smallest = min(smallest, h[s, 0])
        for k in range(h.shape[1] - 1):
            largest = max(largest, (1.0 - gamma) * h[s, k] - h[s, k + 1])
            smallest = min(smallest, h[s, k + 1])
        violations[layout.slack_index[s]] = largest
    return violations, smallest


@njit(cache=True, inline="always")
def _dcbf_residual(h: Floats, s: int, k: int, gamma: float) -> float:
    """g_k of series s."""
    residual: float = h[s, k + 1] - (1.0 - gamma) * h[s, k]
    return residual


@njit(cache=True)
def near_states(h: Floats, gamma: float, near: float) -> Booleans:
    """Mask of the values of h (s, N+1) that occur in rows with g below ``near``."""
    out = np.zeros(h.shape, dtype=np.bool_)
    for s in range(h.shape[0]):
        for k in range(h.shape[1] - 1):
            if _dcbf_residual(h, s, k, gamma) < near:
                out[s, k] = out[s, k + 1] = True
    return out


@njit(cache=True)
def linearise_dcbf(
    h: Floats,
    gradient: Floats,
    sensitivity: Floats,
    gamma: float,
    near: float,
    layout: BarrierLayout,
) -> LinearisedRows:
    """Rows with g below ``near``, and their derivatives by the inputs.

    An input has no effect on earlier poses, which saves half of the products.

    Args:
        h: (s, N+1) barrier values.
        gradient: (s, N+1, 3) ∂h/∂pose.
        sensitivity: (N+1, 3, N·m) ∂poses/∂inputs.
        gamma: γ of eq. (9).
        near: see ``NEAR``, m.
        layout: slacks and identifiers of the series.
    """
    count, steps, columns = 0, h.shape[1] - 1, sensitivity.shape[2]
    m = columns // steps if steps else 0
    keep = 1.0 - gamma
    for s in range(h.shape[0]):
        for k in range(steps):
            if _dcbf_residual(h, s, k, gamma) < near:
                count += 1
    margin = np.empty(count)
    jacobian = np.zeros((count, columns))
    slack_index = np.empty(count, dtype=np.int64)
    row_id = np.empty(count, dtype=np.int64)
    r = 0
    for s in range(h.shape[0]):
        for k in range(steps):
            g = _dcbf_residual(h, s, k, gamma)
            if g >= near:
                continue
            margin[r] = g
            slack_index[r] = layout.slack_index[s]
            row_id[r] = layout.series_id[s] * steps + k
            # ∂h_{k+1}/∂u
            dh = gradient[s, k + 1]
            gx, gy, ga = dh[0], dh[1], dh[2]
            dpose = sensitivity[k + 1]
            for j in range(m * (k + 1)):
                jacobian[r, j] = gx * dpose[0, j] + gy * dpose[1, j] + ga * dpose[2, j]
            # −(1 − γ) ∂h_k/∂u
            dh = gradient[s, k]
            gx, gy, ga = keep * dh[0], keep * dh[1], keep * dh[2]
            dpose = sensitivity[k]
            for j in range(m * k if keep > 0.0 else 0):
                jacobian[r, j] -= gx * dpose[0, j] + gy * dpose[1, j] + ga * dpose[2, j]
            r += 1
    return LinearisedRows(margin, jacobian, slack_index, row_id)
