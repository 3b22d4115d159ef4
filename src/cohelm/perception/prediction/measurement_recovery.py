"""Recovery of measurements; valid only for a tracker whose estimates follow a Kalman update.

A tracker smooths: it takes a share K of each innovation, so that its estimate lags when a person
stops or turns, with correlated errors. From two states at successive observations, the measured
position can be computed.
"""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats

_MIN_GAIN = 0.25
"""Lower bound of K: a small difference must not become a large one."""
_MAX_RATIO = 1.4
"""Upper bound of P_pv dt / P_pp: 3/2 is its limit for infinite noise."""
_TINY = 1e-18


def axis_covariance(covariance: Floats) -> Floats:
    """(P_pp, P_pv, P_vv) of states' covariances (n, 4, 4), averaged over the two axes; (n, 3)."""
    blocks = ((0, 0), (0, 2), (2, 2))
    return np.stack(
        [0.5 * (covariance[:, i, j] + covariance[:, i + 1, j + 1]) for i, j in blocks], axis=-1
    )


def recover_measurements(
    expected: Floats, before: Floats, position: Floats, after: Floats, dt: Floats
) -> tuple[Floats, Floats]:
    """Compute the measured positions, (n, 2) m, and the tracker's variances of them, (n,) m².

    Valid only for a tracker with a Kalman update of a constant-velocity state.

    The filter's process noise is found as well, so that no parameter of it is needed: a position
    measurement changes the information P⁻¹ in its first element only. With P⁻ = s (F P Fᵀ + q Q₁),
    Q₁ as in ``kalman.predict`` for q = 1, therefore ::

        P⁻_pv / P⁻_pp = P_pv / P_pp           which is linear in q
        P⁻_pp / det P⁻ = P_pp / det P         which then gives s

    where s ≥ 1 is the filter's covariance inflation. Then K = 1 − P_pp / P⁻_pp on either axis, and
    z = p⁻ + (p − p⁻) / K of variance P_pp / K. Without correlation of position and velocity
    there was no filter, and z = p. Any other tracker gives a wrong z.

    Args:
        expected: p⁻, predicted from the earlier state, (n, 2) m.
        before: (P_pp, P_pv, P_vv) of the earlier state, (n, 3).
        position: p, the present estimate, (n, 2) m.
        after: (P_pp, P_pv, P_vv) now, (n, 3).
        dt: time between the states, (n,) s, > 0.
    """
    pp, pv, vv = after.T
    wide_pv = before[:, 1] + dt * before[:, 2]
    wide = before[:, 0] + dt * (before[:, 1] + wide_pv)
    ratio = pv / np.maximum(pp, _TINY)
    stiff = dt**2 * (0.5 - dt * np.minimum(ratio, _MAX_RATIO / dt) / 3.0)
    q = np.maximum(ratio * wide - wide_pv, 0.0) / stiff
    wide, wide_pv = wide + q * dt**3 / 3.0, wide_pv + 0.5 * q * dt**2
    wide_vv = before[:, 2] + q * dt
    doubt = wide * (pp * vv - pv**2) / np.maximum(pp * (wide * wide_vv - wide_pv**2), _TINY)
    share = 1.0 - pp / np.maximum(wide * np.maximum(doubt, 1.0), _TINY)
    gain = np.where(pv > 0.0, np.clip(share, _MIN_GAIN, 1.0), 1.0)
    return expected + (position - expected) / gain[:, None], pp / gain
