"""Association of tracks and detections: optimal assignment, merged people, visibility."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.optimize import linear_sum_assignment

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.perception.tracking.kalman import innovations

NO_MATCH = -1
_TENTATIVE_COST = 3.0
"""Extra cost of a match with a tentative track."""
_FORBIDDEN = 1e9


class Visibility(IntEnum):
    """Visibility of a place in one scan."""

    UNCLEAR = 0
    """Beams towards it end at various distances."""
    SEEN_THROUGH = 1
    """All beams pass through it."""
    OCCLUDED = 2
    """Something nearer stops the beams."""
    OCCUPIED = 3
    """Beams end there."""
    OUT_OF_VIEW = 4
    """No beam points there."""


class Gates(NamedTuple):
    """Limits of a match."""

    max_mahalanobis_sq: float
    """Largest eᵀ S⁻¹ e of the first matching."""
    max_cost: float
    """Largest cost of the first matching: above it, the detection is rather a new person."""
    max_distance: Floats
    """(m,) largest |e|, m; half of it in the second matching."""


class Measurements(NamedTuple):
    """Measured positions of k detected tracks."""

    track: Integers
    """(k,) index."""
    position: Floats
    """(k, 2) m."""
    deviation: Floats
    """(k,) m."""


def associate(
    mean: Floats,
    covariance: Floats,
    confirmed: Booleans,
    position: Floats,
    deviation: Floats,
    gates: Gates,
) -> tuple[Integers, Floats]:
    """Match tracks and detections one to one at the least total cost.

    The cost of a pair is eᵀ S⁻¹ e + ln det S, −2 ln of the innovation's likelihood, plus a constant
    for a tentative track; as many pairs as pass the gates are made. The remaining confirmed tracks
    may then take remaining detections nearby, however unlikely: a person who turned on the spot.

    Args:
        mean, covariance: of m tracks, at the time of the detections.
        confirmed: (m,).
        position: (d, 2) m.
        deviation: (d,) m.
        gates: limits of a match.

    Returns:
        (m,) index of each track's detection, ``NO_MATCH`` for none, and (m,) its eᵀ S⁻¹ e.
    """
    mahalanobis_sq, log_det = innovations(mean, covariance, position, deviation)
    offset = position[None, :, :] - mean[:, None, :2]
    distance = np.sqrt(offset[..., 0] ** 2 + offset[..., 1] ** 2)
    cost = mahalanobis_sq + log_det + _TENTATIVE_COST * ~confirmed[:, None]
    allowed = mahalanobis_sq <= gates.max_mahalanobis_sq
    allowed &= mahalanobis_sq + log_det <= gates.max_cost
    allowed &= distance <= gates.max_distance[:, None]
    match = np.full(len(mean), NO_MATCH)
    rows, cols = _assign(np.where(allowed, cost, _FORBIDDEN))
    match[rows] = cols
    # Second matching: near detections that no track has, for confirmed tracks.
    unmatched = confirmed[:, None] & (distance <= 0.5 * gates.max_distance[:, None])
    unmatched[rows] = False
    unmatched[:, cols] = False
    if unmatched.any():
        rows, cols = _assign(np.where(unmatched, cost, _FORBIDDEN))
        match[rows] = cols
    of_match = np.zeros(len(mean))
    matched = np.flatnonzero(match >= 0)
    of_match[matched] = mahalanobis_sq[matched, match[matched]]
    return match, of_match


def _assign(cost: Floats) -> tuple[Integers, Integers]:
    rows, cols = linear_sum_assignment(np.minimum(cost, _FORBIDDEN))
    made = cost[rows, cols] < _FORBIDDEN
    return rows[made], cols[made]


@njit(cache=True)
def merged_partners(
    mean: Floats, missing: Booleans, match: Integers, position: Floats, radius: Floats, near: float
) -> Integers:
    """Find the track with which each missing track shares a cluster, or ``NO_MATCH``; (m,).

    Two people close together make one cluster. It shows both, and not only the matched one, where
    its centre is nearer to the middle between the two expected positions than to either of them.

    Args:
        mean: (m, 4) at the time of the detections.
        missing: (m,) True for unmatched people.
        match: (m,) from :func:`associate`.
        position: (d, 2) m.
        radius: (d,) m.
        near: largest distance of either person beyond a cluster's radius, m.
    """
    m = mean.shape[0]
    partner = np.full(m, NO_MATCH)
    taken = np.zeros(m, dtype=np.bool_)
    for u in range(m):
        if not missing[u]:
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


def measured_positions(
    mean: Floats, match: Integers, partner: Integers, position: Floats, deviation: Floats
) -> Measurements:
    """Compute the measured position of each detected track.

    Two people in one cluster share its detection, which measures their middle: each position gets
    half their distance as additional deviation.

    Args:
        mean: (m, 4) at the time of the detections.
        match: (m,) from :func:`associate`.
        partner: (m,) from :func:`merged_partners`.
        position: (d, 2) m.
        deviation: (d,) m.
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
    track = np.flatnonzero((match >= 0) | (partner >= 0))
    return Measurements(track, place[track], spread[track])


@njit(cache=True)
def visibility(origin: Floats, points: Floats, free_ends: Floats, discs: Floats) -> Integers:
    """Visibility (n,) of each disc (x, y, radius) from ``origin``, a :class:`Visibility` each.

    Beams towards the disc's inner half count, if they reach it. ``OCCLUDED`` if at least half end
    before it, ``SEEN_THROUGH`` if all of at least two end 0.3 m or more behind it, ``OCCUPIED`` if
    at least half end in it or within 0.1 m, ``OUT_OF_VIEW`` without a beam, else ``UNCLEAR``.

    Args:
        origin: (2,) m.
        points: (p, 2) returns, m.
        free_ends: (q, 2) ends of beams without a return, m.
        discs: (n, 3) m.
    """
    out = np.zeros(discs.shape[0], dtype=np.int64)  # UNCLEAR
    beams = points.shape[0] + free_ends.shape[0]
    ends = np.empty((beams, 3))
    for i in range(beams if discs.shape[0] else 0):
        end = points[i] if i < points.shape[0] else free_ends[i - points.shape[0]]
        ends[i, 0], ends[i, 1] = end[0] - origin[0], end[1] - origin[1]
        ends[i, 2] = math.sqrt(ends[i, 0] ** 2 + ends[i, 1] ** 2)
    for t in range(discs.shape[0]):
        dx, dy = discs[t, 0] - origin[0], discs[t, 1] - origin[1]
        distance, radius = math.hypot(dx, dy), discs[t, 2]
        if distance < 1e-6:
            continue
        ux, uy = dx / distance, dy / distance
        slope = 0.5 * radius / distance
        count = before = within = behind = 0
        for i in range(beams):
            length = ends[i, 2]
            if abs(ends[i, 0] * uy - ends[i, 1] * ux) > slope * length:
                continue
            if ends[i, 0] * ux + ends[i, 1] * uy <= 0.0:
                continue
            # A free beam that does not reach the place says nothing about it.
            if i >= points.shape[0] and length <= distance + radius + 0.3:
                continue
            count += 1
            before += length < distance - radius - 0.1
            within += abs(length - distance) <= radius + 0.1
            behind += length > distance + radius + 0.3
        if count == 0:
            out[t] = Visibility.OUT_OF_VIEW
        elif 2 * before >= count:
            out[t] = Visibility.OCCLUDED
        elif 2 * within >= count:
            out[t] = Visibility.OCCUPIED
        elif count >= 2 and behind == count:
            out[t] = Visibility.SEEN_THROUGH
    return out
