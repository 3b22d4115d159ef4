"""What a tracker must have seen, from what it made of it.

A tracker smooths: it takes a share K of what surprises it, so that what it tells lags behind who
stops or turns, and errs in the same way for some time. From two states, one the next look after
the other, what was seen can be found again.
"""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats

_LEAST_GAIN = 0.25
"""K is never taken for less: a small difference must not become a large one."""
_STEEPEST = 1.4
"""P_pv dt / P_pp is never taken for more: 3/2 is what noise without end would make it."""
_TINY = 1e-18


def by_axis(covariance: Floats) -> Floats:
    """(P_pp, P_pv, P_vv) of states' covariances (n, 4, 4), averaged over the two axes; (n, 3)."""
    blocks = ((0, 0), (0, 2), (2, 2))
    return np.stack(
        [0.5 * (covariance[:, i, j] + covariance[:, i + 1, j + 1]) for i, j in blocks], axis=-1
    )


def unsmoothed(
    expected: Floats, before: Floats, position: Floats, after: Floats, dt: Floats
) -> tuple[Floats, Floats]:
    """The positions seen, (n, 2) m, and the variances that the tracker gave them, (n,) m².

    What the filter was agitated by is found, too, so that nothing needs to be known of it: seeing a
    position changes the information P⁻¹ in its first element only. Of P⁻ = s (F P Fᵀ + q Q₁), Q₁ as
    in ``kalman.predict`` for q = 1, therefore ::

        P⁻_pv / P⁻_pp = P_pv / P_pp           which is linear in q
        P⁻_pp / det P⁻ = P_pp / det P         which then gives s

    where s ≥ 1 is by how much the filter doubted itself. Then K = 1 − P_pp / P⁻_pp on either axis,
    and z = p⁻ + (p − p⁻) / K of variance P_pp / K. Where position and velocity are not correlated
    there was no filter, and z = p.

    Args:
        expected: p⁻, where the state before led, (n, 2) m.
        before: its (P_pp, P_pv, P_vv), (n, 3).
        position: p, as it is told now, (n, 2) m.
        after: (P_pp, P_pv, P_vv) now, (n, 3).
        dt: between the two, (n,) s, > 0.
    """
    pp, pv, vv = after.T
    wide_pv = before[:, 1] + dt * before[:, 2]
    wide = before[:, 0] + dt * (before[:, 1] + wide_pv)
    ratio = pv / np.maximum(pp, _TINY)
    stiff = dt**2 * (0.5 - dt * np.minimum(ratio, _STEEPEST / dt) / 3.0)
    q = np.maximum(ratio * wide - wide_pv, 0.0) / stiff
    wide, wide_pv = wide + q * dt**3 / 3.0, wide_pv + 0.5 * q * dt**2
    wide_vv = before[:, 2] + q * dt
    doubt = wide * (pp * vv - pv**2) / np.maximum(pp * (wide * wide_vv - wide_pv**2), _TINY)
    share = 1.0 - pp / np.maximum(wide * np.maximum(doubt, 1.0), _TINY)
    gain = np.where(pv > 0.0, np.clip(share, _LEAST_GAIN, 1.0), 1.0)
    return expected + (position - expected) / gain[:, None], pp / gain
