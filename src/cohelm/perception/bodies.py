"""Which clusters of returns may be people: size, roundness, and the cut between two who touch.

The kernels work on arrays because they run over every cluster of every scan.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.perception.fits import clutter_evidence, disc_evidence, fit_disc, flat_evidence
from cohelm.perception.legs import LEAST, MOST, pair_legs, width_odds

LARGEST_LOG_ODDS = 4.0
"""What one look at a shape can say at most."""
A_RETURN = 0.85
"""What each return beyond three adds to the log-odds that a disc can have."""
SLACK = 0.03
"""Standard deviation of how much narrower than itself a disc looks, beside the beams' gaps, m."""
TWO_CLEAR_LEGS = 2.1
"""Log-odds of two legs seen from end to end with nothing else about: furniture has four."""
FLAT_LEGS = 1.6
"""What it costs two legs at most to look like a face: side by side they may."""
HALF_SEEN = 0.5
"""Log-odds that a width costs of which only a part is seen."""

A_BODY, ONE_LEG = 0, 1
"""What a run of returns is most like."""


@njit(cache=True)
def find_bodies(  # noqa: PLR0913, PLR0917  # a kernel takes arrays and numbers
    points: Floats,
    bearing: Floats,
    hidden: Integers,
    labels: Integers,
    origin: Floats,
    increment: float,
    size: Floats,
    prior: Floats,
    legs: Floats,
) -> tuple[Integers, Floats]:
    """People among clustered returns: torsos, legs that touch, and legs within a stride.

    Args:
        points: (p, 2), m, in beam order.
        bearing: (p,) rad, increasing.
        hidden: (p, 2) 1 where the beam before (after) a return is stopped by something nearer.
        labels: (p,) cluster of each return, −1: none.
        origin: (2,) the sensor, m.
        increment: angle between beams, rad.
        size: (narrowest, widest, width from which a cut is tried), m.
        prior: (r₀, σ_r, σ): the body's radius, its deviation, the range noise, m.
        legs: (width of a leg, its deviation, width of two that touch, its deviation, longest
            stride, deviation of a pair's centre, of one leg from the centre), m, and the log-odds
            of a person whose other leg is not seen.

    Returns:
        owner (p,), −1 for none, and bodies (d, 7) of (x, y of the disc, radius, deviation,
        log-odds of a person, x, y of the mean).
    """
    owner = np.full(points.shape[0], -1, dtype=np.int64)
    bodies = np.empty((points.shape[0], 7))
    single = np.empty((points.shape[0], 4))
    before, after = np.full(points.shape[0], -1), np.full(points.shape[0], -1)
    whose = np.full(points.shape[0], -1, dtype=np.int64)
    count = singles = 0
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
            gap, covered = _ends(points, run, hidden, origin, increment)
            if run.size < 2 or (width > size[1] + gap and not covered):
                continue
            what, body, one = _likest(points[run], origin, width, gap, covered, size, prior, legs)
            if what != ONE_LEG:
                bodies[count] = body
                owner[run] = count
                count += 1
                continue
            single[singles, :2], single[singles, 2] = body[5:7], one
            single[singles, 3] = 1.0 if run.size >= 5 and one > 0.0 else 0.0
            before[singles] = (run[0] - 1) % whose.size if hidden[run[0], 0] else -1
            after[singles] = (run[-1] + 1) % whose.size if hidden[run[-1], 1] else -1
            whose[run] = singles
            singles += 1
    hiders = np.stack((before[:singles], after[:singles]), axis=-1)
    of, count = _on_pairs(points, single[:singles], hiders, whose, prior[0], legs, bodies, count)
    for i in range(whose.size):
        if whose[i] >= 0:
            owner[i] = of[whose[i]]
    return owner, bodies[:count]


@njit(cache=True)
def _likest(  # noqa: PLR0917  # a kernel takes arrays and numbers
    points: Floats,
    origin: Floats,
    width: float,
    gap: float,
    covered: bool,
    size: Floats,
    prior: Floats,
    legs: Floats,
) -> tuple[int, Floats, float]:
    """What a run of returns is most like.

    Args:
        points: (m, 2) of the run, m.
        origin: (2,) the sensor, m.
        width, gap: of the run, and how much wider it may be, m.
        covered: whether something nearer hides an end.
        size, prior, legs: see :func:`find_bodies`.

    Returns:
        ``A_BODY`` or ``ONE_LEG``; the body (7,) as in :func:`find_bodies`; the log-odds of one leg.
    """
    body = _body(points, origin, prior, width, gap, covered)
    wide = width + gap >= size[0]
    torso = body[4] if covered or wide else -np.inf
    one = _width_odds(width, gap, covered, legs[0], legs[1])
    two = _width_odds(width, gap, covered, legs[2], legs[3])
    if wide:
        two -= min(max(body[7], 0.0), FLAT_LEGS)
    if covered and not wide:
        torso = body[4] = min(torso, MOST)
        if width + gap < legs[0] + 2.0 * legs[1]:
            torso = two = -np.inf
    half = HALF_SEEN if covered or gap > 0.5 * size[0] else 0.0
    if torso + half >= min(max(one + legs[7], two), MOST):
        return A_BODY, body[:7], one
    if two >= one + legs[7]:
        return A_BODY, _on_legs(body[5], body[6], prior[0], legs[5], min(two, MOST)), one
    return ONE_LEG, body[:7], one


@njit(cache=True)
def _on_pairs(  # noqa: PLR0917  # a kernel takes arrays and numbers
    points: Floats,
    single: Floats,
    hiders: Integers,
    whose: Integers,
    radius: float,
    legs: Floats,
    bodies: Floats,
    count: int,
) -> tuple[Integers, int]:
    """Put people who stand on single legs behind the ``count`` in ``bodies``.

    Args:
        points: (p, 2) m.
        single: (s, 4) legs of (x, y, log-odds of a leg, 1 where it is clear).
        hiders: (s, 2) return that hides either end of a leg, −1: none.
        whose: (p,) leg of each return, −1: none.
        radius: of a body, m.
        legs: see :func:`find_bodies`.
        bodies: filled in place.
        count: how many there are.

    Returns:
        The body of each leg (s,), −1: none; and how many bodies there are now.
    """
    pairs, odds = pair_legs(single[:, :2], single[:, 2], legs[4], legs[7])
    of = np.full(single.shape[0], -1, dtype=np.int64)
    for k in range(odds.size):
        a, b = pairs[k]
        if odds[k] <= LEAST:
            continue
        other = b if b >= 0 else a
        x, y = 0.5 * (single[a, 0] + single[other, 0]), 0.5 * (single[a, 1] + single[other, 1])
        spread = legs[5] if b >= 0 else legs[6]
        sure = odds[k]
        if b >= 0 and single[a, 3] * single[b, 3] > 0.0 and odds[k] >= MOST:
            apart = math.hypot(single[a, 0] - single[b, 0], single[a, 1] - single[b, 1])
            clear = _unhidden(hiders[a], whose, b) and _unhidden(hiders[b], whose, a)
            room = 0.6 * legs[4]
            if clear and apart < room and _lonely(points, whose, a, b, x, y, room):
                sure = TWO_CLEAR_LEGS
        bodies[count] = _on_legs(x, y, radius, spread, sure)
        of[a] = of[other] = count
        count += 1
    return of, count


@njit(cache=True)
def _unhidden(hiders: Integers, whose: Integers, other: int) -> bool:
    """Whether nothing hides an end of a leg but, perhaps, the ``other`` leg."""
    first, last = hiders
    return bool((first == -1 or whose[first] == other) and (last == -1 or whose[last] == other))


@njit(cache=True)
def _lonely(  # noqa: PLR0917  # a kernel takes arrays and numbers
    points: Floats, whose: Integers, a: int, b: int, x: float, y: float, room: float
) -> bool:
    """Whether nothing but the legs ``a`` and ``b`` came back from within ``room`` of (x, y), m."""
    for i in range(points.shape[0]):
        near = math.hypot(points[i, 0] - x, points[i, 1] - y) < room
        if near and whose[i] != a and whose[i] != b:
            return False
    return True


@njit(cache=True)
def _on_legs(x: float, y: float, radius: float, deviation: float, odds: float) -> Floats:
    return np.array([x, y, radius, deviation, odds, x, y])


@njit(cache=True)
def _width_odds(width: float, gap: float, covered: bool, mean: float, deviation: float) -> float:
    """Log-odds from the width; one that is covered in part may be wider than it seems."""
    seen = width + 0.5 * gap
    if covered:
        return width_odds(max(seen, mean), gap, mean, deviation) - HALF_SEEN
    return width_odds(seen, gap, mean, deviation)


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
def _ends(
    points: Floats, run: Integers, hidden: Integers, origin: Floats, increment: float
) -> tuple[float, bool]:
    """How much wider than its returns a run may be, one beam's gap at either end, m.

    Also whether something nearer hides an end, so that there is no bound to it.
    """
    total, covered = 0.0, False
    for side in range(2):
        i = run[0] if side == 0 else run[-1]
        covered |= hidden[i, side] > 0
        total += math.hypot(points[i, 0] - origin[0], points[i, 1] - origin[1]) * increment
    return total, covered


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
def _body(
    points: Floats, origin: Floats, prior: Floats, width: float, gap: float, covered: bool
) -> Floats:
    """The disc behind a run that is ``width`` wide, its ends' gaps included; a row of bodies.

    A disc that nothing covers is seen from tangent to tangent: what is much narrower than the disc
    that fits it best is a piece of something else. So is what fits a disc of another size.

    Returns a row of bodies, and the log-odds that it is flat or a corner.
    """
    m = points.shape[0]
    x, y, r, misfit, deviation = fit_disc(points, origin, prior[0], prior[1], prior[2])
    disc, clutter = disc_evidence(misfit, m), clutter_evidence(misfit, m)
    flat = flat_evidence(points, prior[2])
    odds = 0.5 * (min(clutter, flat) - disc)
    odds = min(max(odds, -LARGEST_LOG_ODDS), LARGEST_LOG_ODDS)
    if not covered:
        lacking = max(2.0 * r - width - 0.5 * gap, 0.0) / math.hypot(SLACK, 0.45 * gap)
        odds -= min(0.5 * lacking * lacking, LARGEST_LOG_ODDS)
    strange = (r - prior[0]) / (0.45 * prior[1])
    odds = max(odds - 0.5 * strange * strange, -LARGEST_LOG_ODDS)
    odds = min(odds, MOST + A_RETURN * max(m - 3, 0))
    mx, my = points[:, 0].mean(), points[:, 1].mean()
    return np.array([x, y, r, deviation, odds, mx, my, 0.5 * (min(disc, clutter) - flat)])
