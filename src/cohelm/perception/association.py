"""Which sighting is whose: optimal assignment, and what two people seen as one tell of each."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from scipy.optimize import linear_sum_assignment

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.perception.kalman import innovations

ALONE = -1
"""Index of nobody."""
_TENTATIVE = 3.0
"""What a match with a tentative track costs on top."""
_NEVER = 1e9


def associate(
    mean: Floats,
    covariance: Floats,
    confirmed: Booleans,
    position: Floats,
    deviation: Floats,
    *,
    gate: float,
    dearest: float,
    reach: Floats,
) -> tuple[Integers, Floats]:
    """The cheapest one-to-one matching of tracks and positions.

    The cost of a pair is eᵀ S⁻¹ e + ln det S, that is −2 ln of the innovation's likelihood, with a
    little on top for a tentative track; as many pairs as pass the gate are made. What is left over
    of the confirmed tracks may then take what is left over nearby, however unlikely: someone who
    turned on the spot.

    Args:
        mean, covariance: of m tracks, at the time of the positions.
        confirmed: (m,).
        position: (d, 2) m.
        deviation: (d,) m.
        gate: largest eᵀ S⁻¹ e of the first matching.
        dearest: its largest cost: beyond, the position is rather that of a stranger.
        reach: (m,) largest |e|, m; half of it in the second matching.

    Returns:
        (m,) index of each track's position, ``ALONE`` for none, and (m,) its eᵀ S⁻¹ e.
    """
    squared, log_det = innovations(mean, covariance, position, deviation)
    offset = position[None, :, :] - mean[:, None, :2]
    distance = np.sqrt(offset[..., 0] ** 2 + offset[..., 1] ** 2)
    cost = squared + log_det + _TENTATIVE * ~confirmed[:, None]
    usual = (squared <= gate) & (squared + log_det <= dearest) & (distance <= reach[:, None])
    match = np.full(len(mean), ALONE)
    rows, cols = _assign(np.where(usual, cost, _NEVER))
    match[rows] = cols
    free = confirmed[:, None] & (distance <= 0.5 * reach[:, None])
    free[rows] = False
    free[:, cols] = False
    if free.any():
        rows, cols = _assign(np.where(free, cost, _NEVER))
        match[rows] = cols
    at = np.zeros(len(mean))
    found = np.flatnonzero(match >= 0)
    at[found] = squared[found, match[found]]
    return match, at


def _assign(cost: Floats) -> tuple[Integers, Integers]:
    rows, cols = linear_sum_assignment(np.minimum(cost, _NEVER))
    made = cost[rows, cols] < _NEVER
    return rows[made], cols[made]


@njit(cache=True)
def merged(
    mean: Floats, lonely: Booleans, match: Integers, position: Floats, radius: Floats, near: float
) -> Integers:
    """Of each track that was not found, the one with which it was seen as one, or ``ALONE``.

    Two who come close make one cluster. It is both of them, and not the one that it was given to
    with the other hidden, where its centre lies nearer to the middle between the two expected
    places than to either of them.

    Args:
        mean: (m, 4) at the time of the positions.
        lonely: (m,) who looks for company: not found, and a person.
        match: (m,) from :func:`associate`.
        position: (d, 2) m.
        radius: (d,) m.
        near: how far beyond a cluster's radius one of the two may be expected, m.
    """
    m = mean.shape[0]
    partner = np.full(m, ALONE)
    taken = np.zeros(m, dtype=np.bool_)
    for u in range(m):
        if not lonely[u]:
            continue
        best = near
        for t in range(m):
            j = match[t]
            if j < 0 or taken[t]:
                continue
            x, y = position[j, 0], position[j, 1]
            own = math.hypot(mean[u, 0] - x, mean[u, 1] - y)
            other = math.hypot(mean[t, 0] - x, mean[t, 1] - y)
            middle = math.hypot(
                0.5 * (mean[u, 0] + mean[t, 0]) - x, 0.5 * (mean[u, 1] + mean[t, 1]) - y
            )
            if middle < min(own, other) and max(own, other) - radius[j] < best:
                best, partner[u] = max(own, other) - radius[j], t
        if partner[u] >= 0:
            taken[partner[u]] = True
    return partner


def measurements(
    mean: Floats, match: Integers, partner: Integers, position: Floats, deviation: Floats
) -> tuple[Integers, Floats, Floats]:
    """What each track is corrected by: its own sighting, or the one it shares.

    Of two who are seen as one the middle is measured, and each of them half the distance between
    them less surely than that.

    Args:
        mean: (m, 4) at the time of the positions.
        match: (m,) from :func:`associate`.
        partner: (m,) from :func:`merged`.
        position: (d, 2) m.
        deviation: (d,) m.

    Returns:
        Indices of the tracks (k,), measured places (k, 2), m, and their deviations (k,), m.
    """
    shared = np.flatnonzero(partner >= 0)
    other = partner[shared]
    place, spread = np.zeros((len(mean), 2)), np.zeros(len(mean))
    found = np.flatnonzero(match >= 0)
    place[found], spread[found] = position[match[found]], deviation[match[found]]
    apart = mean[shared, :2] - mean[other, :2]
    wide = np.hypot(0.5 * np.hypot(apart[:, 0], apart[:, 1]), spread[other])
    place[shared] = place[other] + 0.5 * apart
    place[other] -= 0.5 * apart
    spread[shared] = spread[other] = wide
    who = np.flatnonzero((match >= 0) | (partner >= 0))
    return who, place[who], spread[who]
