"""Constant-velocity Kalman filter of eq. (4), for many tracks at once.

A state is (x, y, v_x, v_y) with covariance (4, 4); the velocity is driven by white noise of
intensity q, m²/s³, so that it drifts by √(q t) in a time t; a measurement is a position with an
isotropic deviation. Arguments stay unchanged.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED, callee


@njit(**CACHED)
def predict(mean: Floats, covariance: Floats, dt: Floats, q: Floats) -> tuple[Floats, Floats]:
    """Predict states by ``dt``: x ← F x, P ← F P Fᵀ + Q.

    F = [[1, dt], [0, 1]] and Q = q [[dt³/3, dt²/2], [dt²/2, dt]] on each axis.

    Args:
        mean: (n, 4).
        covariance: (n, 4, 4).
        dt: (n,) s, ≥ 0.
        q: (n,) m²/s³.
    """
    x, P = mean.copy(), covariance.copy()
    for t in range(mean.shape[0]):
        predict_state(x[t], P[t], dt[t], q[t])
    return x, P


@njit(**CACHED)
def update(
    mean: Floats, covariance: Floats, position: Floats, deviation: Floats
) -> tuple[Floats, Floats]:
    """Update each state with a measured position; eq. (4), the covariance in Joseph's form.

    K = P Hᵀ S⁻¹, S = H P Hᵀ + R;  x ← x + K (z − H x);  P ← (I − K H) P (I − K H)ᵀ + K R Kᵀ.

    Args:
        mean: (n, 4).
        covariance: (n, 4, 4).
        position: (n, 2) m.
        deviation: (n,) m, > 0.
    """
    x, P = mean.copy(), covariance.copy()
    for t in range(mean.shape[0]):
        update_state(x[t], P[t], position[t], deviation[t])
    return x, P


@callee()
def predict_state(x: Floats, P: Floats, dt: float, q: float) -> None:
    """:func:`predict` of one state (4,) and (4, 4), in place."""
    for i in range(2):
        x[i] += dt * x[i + 2]
        # Every entry is read before it changes.
        for j in range(2):
            pv, vp, vv = P[i, j + 2], P[i + 2, j], P[i + 2, j + 2]
            P[i, j] += dt * (pv + vp) + dt * dt * vv
            P[i, j + 2] += dt * vv
            P[i + 2, j] += dt * vv
        P[i, i] += q * dt**3 / 3.0
        P[i, i + 2] += q * dt**2 / 2.0
        P[i + 2, i] += q * dt**2 / 2.0
        P[i + 2, i + 2] += q * dt


@callee()
def update_state(x: Floats, P: Floats, position: Floats, deviation: float) -> None:
    """:func:`update` of one state (4,) and (4, 4) with a position (2,), in place."""
    K, A, B = np.empty((4, 2)), np.empty((4, 4)), np.empty((4, 4))
    r = deviation * deviation
    sxx, sxy, syy = P[0, 0] + r, P[0, 1], P[1, 1] + r
    det = sxx * syy - sxy * sxy
    e0, e1 = position[0] - x[0], position[1] - x[1]
    for i in range(4):
        K[i, 0] = (P[i, 0] * syy - P[i, 1] * sxy) / det
        K[i, 1] = (P[i, 1] * sxx - P[i, 0] * sxy) / det
        x[i] += K[i, 0] * e0 + K[i, 1] * e1
        # A = I − K H
        for j in range(4):
            A[i, j] = (1.0 if i == j else 0.0) - (K[i, j] if j < 2 else 0.0)
    for i in range(4):
        for j in range(4):
            B[i, j] = 0.0
            for k in range(4):
                B[i, j] += A[i, k] * P[k, j]
    for i in range(4):
        for j in range(4):
            total = r * (K[i, 0] * K[j, 0] + K[i, 1] * K[j, 1])
            for k in range(4):
                total += B[i, k] * A[j, k]
            P[i, j] = total


@njit(**CACHED)
def innovations(
    mean: Floats, covariance: Floats, position: Floats, deviation: Floats
) -> tuple[Floats, Floats]:
    """(eᵀ S⁻¹ e, ln det S) of each pair of track and measurement, (n, d) each."""
    n, d = mean.shape[0], position.shape[0]
    mahalanobis_sq, log_det = np.empty((n, d)), np.empty((n, d))
    for t in range(n):
        for j in range(d):
            r = deviation[j] * deviation[j]
            sxx, sxy = covariance[t, 0, 0] + r, covariance[t, 0, 1]
            syy = covariance[t, 1, 1] + r
            e0, e1 = position[j, 0] - mean[t, 0], position[j, 1] - mean[t, 1]
            det = sxx * syy - sxy * sxy
            mahalanobis_sq[t, j] = (e0 * e0 * syy - 2.0 * e0 * e1 * sxy + e1 * e1 * sxx) / det
            log_det[t, j] = np.log(det)
    return mahalanobis_sq, log_det


@njit(**CACHED, inline="always")
def larger_axis(a: float, b: float, c: float) -> float:
    """√ of the larger eigenvalue of [[a, b], [b, c]]."""
    deviation: float = np.sqrt(0.5 * (a + c) + np.hypot(0.5 * (a - c), b))
    return deviation
