"""Features of candidates for people in one scan, for the learned classifier.

A candidate has one segment of returns, or two: the legs. All features come from this one scan.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.kernels import CACHED, callee
from cohelm.perception.scan_detection.bodies import Beams
from cohelm.perception.scan_detection.body_candidates import BodyCandidates

FEATURES = (
    "returns",
    "range",
    "gap",
    "segments",
    "width",
    "wider_segment",
    "narrower_segment",
    "separation",
    "separation_along_view",
    "residual_first",
    "residual_last",
    "bulge_first",
    "bulge_last",
    "nearer_side",
    "farther_side",
    "between",
    "isolation",
    "returns_within_0.4",
    "returns_within_0.8",
    "candidates_within_1.2",
    "fill",
    "radius",
    "log_odds",
)
"""Names, in the order of the columns: ln n; m; m; 1 or 2; lengths in m; ``nearer_side`` and
``farther_side`` are the steps of range beyond both ends, ``between`` behind the gap between two
segments, m; ``isolation`` the distance of the nearest other return, m; counts of other returns
as ln(1 + n); the share of the beams across the candidate that hit it; the radius of the fitted
disc, m; the hand-made log-odds."""
_FAR = 2.0
"""Bound of steps of range and of beams without a return, m."""
_NEAR, _AROUND, _CROWD = 0.4, 0.8, 1.2


@njit(**CACHED)
def candidate_features(beams: Beams, body_of_return: Integers, bodies: BodyCandidates) -> Floats:
    """Features (d, ``len(FEATURES)``) of d candidates.

    Args:
        beams: returns of the scan.
        body_of_return: (p,) candidate of each return, −1: none.
        bodies: the candidates.
    """
    d = len(bodies.radius)
    out, members = np.zeros((d, 23)), _members(beams, body_of_return, d)
    first, order = members
    for k in range(d):
        index = order[first[k] : first[k + 1]]
        if index.size == 0:
            continue
        _shape(out[k], beams, index)
        _sides(out[k], beams, index)
        _surroundings(out[k], beams, body_of_return, k, bodies)
        out[k, 21], out[k, 22] = bodies.radius[k], bodies.log_odds[k]
    return out


@callee()
def _members(beams: Beams, body_of_return: Integers, d: int) -> tuple[Integers, Integers]:
    """(start of each candidate's returns (d + 1,), the returns in beam order)."""
    first, n = np.zeros(d + 1, dtype=np.int64), len(body_of_return)
    for i in range(n):
        if body_of_return[i] >= 0:
            first[body_of_return[i] + 1] += 1
    first = np.cumsum(first)
    order, fill = np.empty(first[d], dtype=np.int64), first.copy()
    for i in range(n):
        k = body_of_return[i]
        if k >= 0:
            order[fill[k]] = i
            fill[k] += 1
    for k in range(d):
        # Across the seam of the scan, the later part comes first.
        part = order[first[k] : first[k + 1]]
        for j in range(1, part.size):
            if beams.bearing[part[j]] - beams.bearing[part[j - 1]] > math.pi:
                order[first[k] : first[k + 1]] = np.concatenate((part[j:], part[:j]))
                break
    return first, order


@callee()
def _shape(row: Floats, beams: Beams, index: Integers) -> None:
    """Write the features of the candidate's own returns."""
    n, points = index.size, beams.points
    cut = n
    for j in range(1, n):
        if beams.cluster[index[j]] != beams.cluster[index[j - 1]]:
            cut = j
            break
    x, y = points[index, 0].mean() - beams.origin[0], points[index, 1].mean() - beams.origin[1]
    distance = max(math.hypot(x, y), 1e-6)
    row[0], row[1], row[2] = math.log(n), distance, distance * beams.increment
    row[3] = 2.0 if cut < n else 1.0
    row[4] = _length(points, index[0], index[-1])
    one = _length(points, index[0], index[cut - 1])
    row[9], row[11] = _residual(points, index[:cut], beams.origin)
    row[5] = row[6] = one
    row[10], row[12] = row[9], row[11]
    if cut < n:
        two = _length(points, index[cut], index[-1])
        row[5], row[6] = max(one, two), min(one, two)
        ax, ay = points[index[:cut], 0].mean(), points[index[:cut], 1].mean()
        bx, by = points[index[cut:], 0].mean(), points[index[cut:], 1].mean()
        row[7] = math.hypot(bx - ax, by - ay)
        row[8] = abs((bx - ax) * x + (by - ay) * y) / distance
        row[10], row[12] = _residual(points, index[cut:], beams.origin)
    span = (beams.bearing[index[-1]] - beams.bearing[index[0]]) % (2.0 * math.pi)
    row[20] = n / (span / beams.increment + 1.0) if beams.increment > 0.0 else 1.0


@callee()
def _length(points: Floats, i: int, j: int) -> float:
    return math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1])


@callee()
def _residual(points: Floats, index: Integers, origin: Floats) -> tuple[float, float]:
    """(root mean square distance from the chord, mean distance towards the sensor), m."""
    n, a, b = index.size, index[0], index[-1]
    length = _length(points, a, b)
    if n < 3 or length < 1e-6:
        return 0.0, 0.0
    nx = (points[b, 1] - points[a, 1]) / length
    ny = (points[a, 0] - points[b, 0]) / length
    towards = (origin[0] - points[a, 0]) * nx + (origin[1] - points[a, 1]) * ny
    sign = 1.0 if towards >= 0.0 else -1.0
    total = squares = 0.0
    for i in index[1:-1]:
        off = sign * ((points[i, 0] - points[a, 0]) * nx + (points[i, 1] - points[a, 1]) * ny)
        total += off
        squares += off * off
    return math.sqrt(squares / (n - 2)), total / (n - 2)


@callee()
def _sides(row: Floats, beams: Beams, index: Integers) -> None:
    """Write the steps of range beside the candidate and between its segments."""
    p = len(beams.points)
    before = _step(beams, index[0], (index[0] - 1) % p, -1.0)
    after = _step(beams, index[-1], (index[-1] + 1) % p, 1.0)
    row[13], row[14] = min(before, after), max(before, after)
    for j in range(1, index.size):
        if beams.cluster[index[j]] != beams.cluster[index[j - 1]]:
            first = _step(beams, index[j - 1], (index[j - 1] + 1) % p, 1.0)
            last = _step(beams, index[j], (index[j] - 1) % p, -1.0)
            row[15] = min(first, last)
            break


@callee()
def _step(beams: Beams, own: int, other: int, side: float) -> float:
    """Range of the return beside an end minus that of the end, m, at most ``_FAR`` either way."""
    turn = side * (beams.bearing[other] - beams.bearing[own]) % (2.0 * math.pi)
    if turn > 2.5 * beams.increment:
        return _FAR
    points, origin = beams.points, beams.origin
    far = math.hypot(points[other, 0] - origin[0], points[other, 1] - origin[1])
    near = math.hypot(points[own, 0] - origin[0], points[own, 1] - origin[1])
    return min(max(far - near, -_FAR), _FAR)


@callee()
def _surroundings(
    row: Floats, beams: Beams, body_of_return: Integers, k: int, bodies: BodyCandidates
) -> None:
    """Write isolation and the numbers of returns and candidates nearby."""
    x, y = bodies.mean[k]
    nearest, near, around, others = 1.0, 0, 0, 0
    for i in range(len(beams.points)):
        dx, dy = abs(beams.points[i, 0] - x), abs(beams.points[i, 1] - y)
        if dx > 1.0 or dy > 1.0 or body_of_return[i] == k:
            continue
        far = math.hypot(dx, dy)
        nearest = min(nearest, far)
        near += far < _NEAR
        around += far < _AROUND
    for j in range(len(bodies.radius)):
        apart = math.hypot(bodies.mean[j, 0] - x, bodies.mean[j, 1] - y)
        others += j != k and apart < _CROWD
    row[16], row[17], row[18] = nearest, math.log(1.0 + near), math.log(1.0 + around)
    row[19] = others
