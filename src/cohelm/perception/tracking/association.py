"""Association of tracks and detections: optimal assignment, merged people, visibility.

The optimal assignment, pairs of rows and columns at the least total cost, is compiled code.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED, callee
from cohelm.perception.tracking.kalman import innovations

NO_MATCH = -1
FORBIDDEN = 1e9
"""Cost from which a pair is not made."""


@njit(**CACHED)
def assign(cost: Floats) -> Integers:
    """Column (n,) of each row of ``cost`` (n, d), or ``NO_MATCH``.

    As many pairs as possible are made, at the least total cost; those that cost ``FORBIDDEN`` or
    more are then dropped. Equal totals are resolved as by SciPy's ``linear_sum_assignment``.
    """
    n, d = cost.shape
    column = np.full(n, NO_MATCH)
    # The shorter side looks for partners.
    wide = np.empty((min(n, d), max(n, d)))
    for i in range(n):
        for j in range(d):
            wide[(i, j) if n <= d else (j, i)] = min(cost[i, j], FORBIDDEN)
    partner = _shortest_paths(wide)
    for k in range(len(partner)):
        i, j = (k, partner[k]) if n <= d else (partner[k], k)
        if cost[i, j] < FORBIDDEN:
            column[i] = j
    return column


@callee()
def _shortest_paths(cost: Floats) -> Integers:
    """Column (n,) of each row of ``cost`` (n, d), n ≤ d, by shortest augmenting paths.

    Crouse, On implementing 2D rectangular assignment algorithms, 2016; u and v are dual variables.
    """
    n, d = cost.shape
    u, v = np.zeros(n), np.zeros(d)
    column, row = np.full(n, -1), np.full(d, -1)
    # Of the search from one row: predecessors, path costs, columns left, and what it reached.
    path, length = np.full(d, -1), np.empty(d)
    left = np.empty(d, dtype=np.int64)
    row_seen, column_seen = np.empty(n, dtype=np.bool_), np.empty(d, dtype=np.bool_)
    for first in range(n):
        length[:], row_seen[:], column_seen[:] = np.inf, False, False
        # From the last column on, so that equal costs give the identity.
        for j in range(d):
            left[j] = d - j - 1
        count, least, i, sink = d, 0.0, first, -1
        while sink < 0:
            row_seen[i] = True
            lowest, at = np.inf, 0
            for k in range(count):
                j = left[k]
                reduced = least + cost[i, j] - u[i] - v[j]
                if reduced < length[j]:
                    path[j], length[j] = i, reduced
                # Among equals, a free column ends the path.
                if length[j] < lowest or (length[j] == lowest and row[j] < 0):
                    lowest, at = length[j], k
            least, j = lowest, left[at]
            column_seen[j] = True
            if row[j] < 0:
                sink = j
            else:
                i = row[j]
            count -= 1
            left[at] = left[count]
        _update_duals(u, v, least, first, length, column, row_seen, column_seen)
        # Exchange the pairs along the path.
        j = sink
        while j >= 0:
            i = path[j]
            row[j], column[i], j = i, j, column[i]
    return column


@callee()
def _update_duals(
    u: Floats,
    v: Floats,
    least: float,
    first: int,
    length: Floats,
    column: Integers,
    row_seen: Booleans,
    column_seen: Booleans,
) -> None:
    """Update the dual variables u (n,) and v (d,) after the search from row ``first``, in place."""
    u[first] += least
    for i in range(len(u)):
        if row_seen[i] and i != first:
            u[i] += least - length[column[i]]
    for j in range(len(v)):
        if column_seen[j]:
            v[j] -= least - length[j]


_TENTATIVE_COST = 3.0
"""Extra cost of a match with a tentative track."""


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
    max_distance: float
    """Largest |e|, m; half of it in the second matching."""


class Measurements(NamedTuple):
    """Measured positions of k detected tracks."""

    track: Integers
    """(k,) index."""
    position: Floats
    """(k, 2) m."""
    deviation: Floats
    """(k,) m."""


@njit(**CACHED)
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
    m, d = mean.shape[0], position.shape[0]
    mahalanobis_sq, log_det = innovations(mean, covariance, position, deviation)
    distance, cost = np.empty((m, d)), np.full((m, d), FORBIDDEN)
    for t in range(m):
        for j in range(d):
            e0, e1 = position[j, 0] - mean[t, 0], position[j, 1] - mean[t, 1]
            distance[t, j] = math.sqrt(e0 * e0 + e1 * e1)
            likely = mahalanobis_sq[t, j] + log_det[t, j]
            if (
                mahalanobis_sq[t, j] <= gates.max_mahalanobis_sq
                and likely <= gates.max_cost
                and distance[t, j] <= gates.max_distance
            ):
                cost[t, j] = likely + (0.0 if confirmed[t] else _TENTATIVE_COST)
    match = assign(cost)
    # Second matching: near detections that no track has, for confirmed tracks.
    taken, unmatched = np.zeros(d, dtype=np.bool_), False
    for t in range(m):
        if match[t] >= 0:
            taken[match[t]] = True
    for t in range(m):
        for j in range(d):
            cost[t, j] = FORBIDDEN
            free = confirmed[t] and match[t] < 0 and not taken[j]
            if free and distance[t, j] <= 0.5 * gates.max_distance:
                cost[t, j] = mahalanobis_sq[t, j] + log_det[t, j]
                unmatched = True
    second = assign(cost) if unmatched else match
    of_match = np.zeros(m)
    for t in range(m):
        match[t] = max(match[t], second[t])
        if match[t] >= 0:
            of_match[t] = mahalanobis_sq[t, match[t]]
    return match, of_match


@njit(**CACHED)
def merged_partners(
    mean: Floats,
    missing: Booleans,
    confirmed: Booleans,
    match: Integers,
    position: Floats,
    radius: Floats,
    near: float,
) -> Integers:
    """Find the person with whom each missing track shares a cluster, or ``NO_MATCH``; (m,).

    Two people close together make one cluster. It shows both, and not only the matched one, where
    its centre is nearer to the middle between the two expected positions than to either of them.

    Args:
        mean: (m, 4) at the time of the detections.
        missing: (m,) True for unmatched people.
        confirmed: (m,) True for people; an object shares no cluster with a person.
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
            if j < 0 or taken[t] or not confirmed[t]:
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


@njit(**CACHED)
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
    m, count = len(match), 0
    place, spread = np.zeros((m, 2)), np.zeros(m)
    for t in range(m):
        if match[t] >= 0:
            place[t], spread[t] = position[match[t]], deviation[match[t]]
    for t in range(m):
        other = partner[t]
        if other < 0:
            continue
        half_x, half_y = 0.5 * (mean[t, 0] - mean[other, 0]), 0.5 * (mean[t, 1] - mean[other, 1])
        place[t, 0], place[t, 1] = place[other, 0] + half_x, place[other, 1] + half_y
        place[other, 0] -= half_x
        place[other, 1] -= half_y
        spread[t] = math.hypot(math.hypot(half_x, half_y), spread[other])
        spread[other] = spread[t]
    track = np.empty(m, dtype=np.int64)
    for t in range(m):
        if match[t] >= 0 or partner[t] >= 0:
            track[count], place[count], spread[count] = t, place[t], spread[t]
            count += 1
    return Measurements(track[:count], place[:count], spread[:count])


@njit(**CACHED)
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
