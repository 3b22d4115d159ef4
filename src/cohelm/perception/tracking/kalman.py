"""Constant-velocity Kalman filter of eq. (4), for many tracks at once.

A state is (x, y, v_x, v_y) with covariance (4, 4); the velocity is driven by white noise of
intensity q, m²/s³, so that it drifts by √(q t) in a time t; a measurement is a position with an
isotropic deviation. Arguments stay unchanged.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats


@njit(cache=True)
def predict(mean: Floats, covariance: Floats, dt: Floats, q: Floats) -> tuple[Floats, Floats]:
    """Predict states by ``dt``: x ← F x, P ← F P Fᵀ + Q.

    F = [[1, dt], [0, 1]] and Q = q [[dt³/3, dt²/2], [dt²/2, dt]] on each axis.

    Args:
        mean: (n, 4).
        covariance: (n, 4, 4).
        dt: (n,) s, ≥ 0.
        q: (n,) m²/s³.
    """
    n = mean.shape[0]
    x, P = mean.copy(), covariance.copy()
    for t in range(n):
        d = dt[t]
        for i in range(2):
            x[t, i] += d * mean[t, i + 2]
            for j in range(2):
                pv, vp = covariance[t, i, j + 2], covariance[t, i + 2, j]
                vv = covariance[t, i + 2, j + 2]
                P[t, i, j] += d * (pv + vp) + d * d * vv
                P[t, i, j + 2] += d * vv
                P[t, i + 2, j] += d * vv
            P[t, i, i] += q[t] * d**3 / 3.0
            P[t, i, i + 2] += q[t] * d**2 / 2.0
            P[t, i + 2, i] += q[t] * d**2 / 2.0
            P[t, i + 2, i + 2] += q[t] * d
    return x, P


@njit(cache=True)
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
    n = mean.shape[0]
    x, P = mean.copy(), covariance.copy()
    K, A, B = np.empty((4, 2)), np.empty((4, 4)), np.empty((4, 4))
    for t in range(n):
        C = covariance[t]
        r = deviation[t] * deviation[t]
        sxx, sxy, syy = C[0, 0] + r, C[0, 1], C[1, 1] + r
        det = sxx * syy - sxy * sxy
        e0, e1 = position[t, 0] - mean[t, 0], position[t, 1] - mean[t, 1]
        for i in range(4):
            K[i, 0] = (C[i, 0] * syy - C[i, 1] * sxy) / det
            K[i, 1] = (C[i, 1] * sxx - C[i, 0] * sxy) / det
            x[t, i] += K[i, 0] * e0 + K[i, 1] * e1
            for j in range(4):
                A[i, j] = (1.0 if i == j else 0.0) - (K[i, j] if j < 2 else 0.0)
        for i in range(4):
            for j in range(4):
                B[i, j] = 0.0
                for k in range(4):
                    B[i, j] += A[i, k] * C[k, j]
        for i in range(4):
            for j in range(4):
                total = r * (K[i, 0] * K[j, 0] + K[i, 1] * K[j, 1])
                for k in range(4):
                    total += B[i, k] * A[j, k]
                P[t, i, j] = total
    return x, P


@njit(cache=True)
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


@njit(cache=True)
def larger_deviation(covariance: Floats) -> Floats:
    """√ of the larger eigenvalue of symmetric matrices (n, 2, 2); (n,)."""
    out = np.empty(covariance.shape[0])
    for t in range(covariance.shape[0]):
        a, b, c = covariance[t, 0, 0], covariance[t, 0, 1], covariance[t, 1, 1]
        out[t] = np.sqrt(0.5 * (a + c) + np.hypot(0.5 * (a - c), b))
    return out
