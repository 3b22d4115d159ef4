"""Which clusters of returns may be people: size, roundness, and the cut between two who touch.

The kernels work on arrays because they run over every cluster of every scan.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.perception.fits import clutter_evidence, disc_evidence, fit_disc, flat_evidence

LARGEST_LOG_ODDS = 4.0
"""What one look at a shape can say at most."""


@njit(cache=True)
def find_bodies(  # noqa: PLR0917  # a kernel takes arrays and numbers
    points: Floats,
    bearing: Floats,
    hidden: Integers,
    labels: Integers,
    origin: Floats,
    increment: float,
    size: Floats,
    prior: Floats,
) -> tuple[Integers, Floats]:
    """People among clustered returns.

    Args:
        points: (p, 2), m, in beam order.
        bearing: (p,) rad, increasing.
        hidden: (p, 2) 1 where the beam before (after) a return is stopped by something nearer.
        labels: (p,) cluster of each return, −1: none.
        origin: (2,) the sensor, m.
        increment: angle between beams, rad.
        size: (narrowest, widest, width from which a cut is tried), m.
        prior: (r₀, σ_r, σ): the body's radius, its deviation, the range noise, m.

    Returns:
        owner (p,), −1 for none, and bodies (d, 7) of (x, y of the disc, radius, deviation,
        log-odds of a person, x, y of the mean).
    """
    owner = np.full(points.shape[0], -1, dtype=np.int64)
    bodies = np.empty((points.shape[0], 7))
    count = 0
    todo = np.empty((points.shape[0] + 1, 2), dtype=np.int64)
    for cluster in range(labels.max() + 1 if labels.size else 0):
        members = _in_beam_order(labels, cluster, bearing)
        todo[0, 0], todo[0, 1], left = 0, members.size, 1
        while left > 0:
            left -= 1
            start, stop = todo[left, 0], todo[left, 1]
            run = members[start:stop]
            width = _extent(points[run])
            if width > size[2] and run.size >= 4 and width < 3.0 * size[1]:
                cut = _cut(points[run], origin, prior)
                if cut > 0:
                    todo[left, 0], todo[left, 1] = start, start + cut
                    todo[left + 1, 0], todo[left + 1, 1] = start + cut, stop
                    left += 2
                    continue
            gaps = _gaps(points, run, hidden, origin, increment)
            if run.size < 2 or width > size[1] + gaps or width + gaps < size[0]:
                continue
            bodies[count] = _body(points[run], origin, prior)
            owner[run] = count
            count += 1
    return owner, bodies[:count]


@njit(cache=True)
def _in_beam_order(labels: Integers, cluster: int, bearing: Floats) -> Integers:
    """The cluster's members; where it lies across the scan's seam, the later part comes first."""
    members = np.flatnonzero(labels == cluster)
    widest, at = math.pi, 0
    for i in range(1, members.size):
        gap = bearing[members[i]] - bearing[members[i - 1]]
        if gap > widest:
            widest, at = gap, i
    return np.concatenate((members[at:], members[:at]))


@njit(cache=True)
def _extent(points: Floats) -> float:
    """The largest distance of a point from either end of a run, m."""
    widest = 0.0
    last = points.shape[0] - 1
    for i in range(points.shape[0]):
        for end in (0, last):
            d = math.hypot(points[i, 0] - points[end, 0], points[i, 1] - points[end, 1])
            widest = max(widest, d)
    return widest


@njit(cache=True)
def _gaps(
    points: Floats, run: Integers, hidden: Integers, origin: Floats, increment: float
) -> float:
    """How much wider than its returns a run may be: one beam's gap at either end, m.

    Unbounded where something nearer hides an end.
    """
    total = 0.0
    for side in range(2):
        i = run[0] if side == 0 else run[-1]
        if hidden[i, side]:
            return 1e9
        total += math.hypot(points[i, 0] - origin[0], points[i, 1] - origin[1]) * increment
    return total


@njit(cache=True)
def _cut(points: Floats, origin: Floats, prior: Floats) -> int:
    """Where two people touch in one run of returns; 0 where one thing explains it as well."""
    m = points.shape[0]
    _, _, _, misfit, _ = fit_disc(points, origin, prior[0], prior[1], prior[2])
    single = min(disc_evidence(misfit, m), clutter_evidence(misfit, m))
    single = min(single, flat_evidence(points, prior[2]))
    best, where = single - 2.0 * LARGEST_LOG_ODDS, 0
    stride = max(1, m // 24)
    for cut in range(2, m - 1, stride):
        _, _, _, a, _ = fit_disc(points[:cut], origin, prior[0], prior[1], prior[2])
        _, _, _, b, _ = fit_disc(points[cut:], origin, prior[0], prior[1], prior[2])
        both = a + b + 5.0 * math.log(m)
        if both < best:
            best, where = both, cut
    return where


@njit(cache=True)
def _body(points: Floats, origin: Floats, prior: Floats) -> Floats:
    m = points.shape[0]
    x, y, r, misfit, deviation = fit_disc(points, origin, prior[0], prior[1], prior[2])
    other = min(clutter_evidence(misfit, m), flat_evidence(points, prior[2]))
    odds = 0.5 * (other - disc_evidence(misfit, m))
    odds = min(max(odds, -LARGEST_LOG_ODDS), LARGEST_LOG_ODDS)
    mx, my = points[:, 0].mean(), points[:, 1].mean()
    return np.array([x, y, r, deviation, odds, mx, my])
