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


def by_axis(covariance: Floats) -> Floats:
    """(P_pp, P_pv, P_vv) of states' covariances (n, 4, 4), averaged over the two axes; (n, 3)."""
    blocks = ((0, 0), (0, 2), (2, 2))
    return np.stack(
        [0.5 * (covariance[:, i, j] + covariance[:, i + 1, j + 1]) for i, j in blocks], axis=-1
    )


def unsmoothed(
    expected: Floats, before: Floats, position: Floats, after: Floats, dt: Floats, q: float
) -> tuple[Floats, Floats]:
    """The positions seen, (n, 2) m, and the variances that the tracker gave them, (n,) m².

    With P⁻ from ``kalman.predict``, K = 1 − P_pp / P⁻_pp on either axis, and z = p⁻ + (p − p⁻) / K
    of variance P_pp / K. Where position and velocity are not correlated there was no filter, and
    z = p.

    Args:
        expected: p⁻, where the state before led, (n, 2) m.
        before: its (P_pp, P_pv, P_vv), (n, 3).
        position: p, as it is told now, (n, 2) m.
        after: (P_pp, P_pv, P_vv) now, (n, 3).
        dt: between the two, (n,) s.
        q: of the filter, m²/s³.
    """
    wide = before[:, 0] + 2.0 * dt * before[:, 1] + dt**2 * before[:, 2] + q * dt**3 / 3.0
    share = 1.0 - after[:, 0] / np.maximum(wide, 1e-12)
    gain = np.where(after[:, 1] > 0.0, np.clip(share, _LEAST_GAIN, 1.0), 1.0)
    return expected + (position - expected) / gain[:, None], after[:, 0] / gain
