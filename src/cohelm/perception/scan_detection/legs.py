"""Legs among clusters of returns: single legs, two that touch, and pairs within a stride.

A scanner below the hips sees legs only. Chairs and tables have legs as well and look the same, so
legs alone are weak evidence of a person: at most ``MAX_LOG_ODDS``, until something moves. The only
exception are two clearly visible legs with nothing around them (``CLEAR_PAIR_LOG_ODDS``), which the
tracker may confirm at rest (``TrackerParameters.static_shape``).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import ZERO
from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED, callee
from cohelm.perception.scan_detection.body_candidates import (
    Body,
    BodyCandidates,
    empty_candidates,
    first_rows,
    store,
)

CLUTTER_DECADES = 3.4
"""ln of the range of widths over which clutter is uniform in the logarithm (2 to 60 cm)."""
MAX_LOG_ODDS, MIN_LOG_ODDS = 0.5, -3.0
"""Bounds of the log-odds of legs from their shape alone."""
CLEAR_PAIR_LOG_ODDS = 2.1
"""Log-odds of two fully visible legs with nothing else nearby: furniture has four."""
OCCLUSION_COST = 0.5
"""Decrease of the log-odds of a width of which only a part is visible."""
_ISOLATION = 0.6
"""Radius around a clear pair of legs in which nothing else may stand, as a share of the stride; the
legs are nearer to each other than this, too."""


class LegModel(NamedTuple):
    """Sizes of legs, m."""

    width: float
    """Width of one leg."""
    width_deviation: float
    pair_width: float
    """Width of two legs that touch."""
    pair_width_deviation: float
    stride: float
    """Longest stride."""
    pair_deviation: float
    """Standard deviation of a person's centre from the middle of two legs."""
    single_deviation: float
    """Standard deviation of a person's centre from one leg."""
    single_log_odds: float
    """Log-odds that only one leg of a person is visible."""


class SingleLegs(NamedTuple):
    """Legs found in the p returns of a scan; s of them."""

    centre: Floats
    """(s, 2) mean of the returns, m."""
    log_odds: Floats
    """(s,) of a leg, from its width."""
    is_clear: Booleans
    """(s,) True for a leg with enough returns and positive log-odds."""
    occluder: Integers
    """(s, 2) return that occludes either end, −1: none."""
    leg_of_return: Integers
    """(p,) leg of each return, −1: none."""


@njit(**CACHED)
def width_log_odds(width: float, blur: float, mean: float, deviation: float) -> float:
    """Log-likelihood ratio of an object of known size to clutter for an observed width.

    The size is normal, blurred by the gap between beams; clutter's density is 1 / (w ln(w₁/w₀)).

    Args:
        width: between the outermost returns plus half a gap at either end, m.
        blur: the gap, m.
        mean, deviation: of the size, m.
    """
    spread = math.hypot(deviation, 0.5 * blur)
    off = (width - mean) / spread
    peak = max(width, 0.01) * CLUTTER_DECADES / (spread * math.sqrt(2.0 * math.pi))
    return math.log(peak) - 0.5 * off * off


@callee()
def occluded_width_log_odds(
    width: float, gap: float, occluded: bool, mean: float, deviation: float
) -> float:
    """Compute :func:`width_log_odds` of a run; a partly occluded one may be wider than it seems."""
    seen = width + 0.5 * gap
    if occluded:
        return width_log_odds(max(seen, mean), gap, mean, deviation) - OCCLUSION_COST
    return width_log_odds(seen, gap, mean, deviation)


@njit(**CACHED)
def stride_log_odds(distance: float, stride: float) -> float:
    """Log-likelihood ratio of two legs to two unrelated objects at a distance, m.

    Legs: a Rayleigh distribution with its mode at two fifths of the longest stride w. Unrelated
    objects: a density that grows with the distance, 2d / w².
    """
    mode = stride / 2.5
    return math.log(0.5 * (stride / mode) ** 2) - 0.5 * (distance / mode) ** 2


@njit(**CACHED)
def pair_legs(
    centre: Floats, log_odds: Floats, stride: float, single_log_odds: float
) -> tuple[Integers, Floats]:
    """Pair legs greedily, the most probable pair first.

    Two legs make a pair if that is more probable than two people with one visible leg each.

    Args:
        centre: (k, 2) of legs, m.
        log_odds: (k,) of each leg.
        stride: the longest, m.
        single_log_odds: of a person with one visible leg.

    Returns:
        legs (d, 2): their indices, the second −1 for a single leg; log-odds (d,).
    """
    k = centre.shape[0]
    legs = np.full((k, 2), -1, dtype=np.int64)
    total = np.empty(k)
    unpaired = np.ones(k, dtype=np.bool_)
    count = 0
    while True:
        best, a, b = -np.inf, -1, -1
        for i in range(k):
            for j in range(i + 1, k):
                if not (unpaired[i] and unpaired[j]):
                    continue
                d = math.hypot(centre[i, 0] - centre[j, 0], centre[i, 1] - centre[j, 1])
                if d > stride:
                    continue
                apart = stride_log_odds(d, stride)
                both = 0.5 * (log_odds[i] + log_odds[j]) + apart
                if both > best and apart > single_log_odds:
                    best, a, b = both, i, j
        if a < 0:
            break
        legs[count, 0], legs[count, 1], total[count] = a, b, best
        unpaired[a] = unpaired[b] = False
        count += 1
    for i in range(k):
        if unpaired[i]:
            legs[count, 0], total[count] = i, log_odds[i] + single_log_odds
            count += 1
    return legs[:count], np.minimum(np.maximum(total[:count], MIN_LOG_ODDS), MAX_LOG_ODDS)


@callee()
def pair_legs_into_people(
    points: Floats, found: SingleLegs, radius: float, model: LegModel
) -> tuple[Integers, BodyCandidates]:
    """Pair single legs into candidates for people.

    Args:
        points: (p, 2) returns, m.
        found: the legs.
        radius: of a body, m.
        model: sizes of legs.

    Returns:
        Index of the person of each leg (s,), −1: none; and the people.
    """
    centre = found.centre
    pairs, odds = pair_legs(centre, found.log_odds, model.stride, model.single_log_odds)
    person = np.full(centre.shape[0], -1, dtype=np.int64)
    bodies = empty_candidates(odds.size)
    count = ZERO
    for k in range(odds.size):
        a, b = pairs[k]
        if odds[k] <= MIN_LOG_ODDS:
            continue
        other = b if b >= 0 else a
        x = 0.5 * (centre[a, 0] + centre[other, 0])
        y = 0.5 * (centre[a, 1] + centre[other, 1])
        deviation = model.pair_deviation if b >= 0 else model.single_deviation
        log_odds = odds[k]
        # Two clear legs with nothing around them are more than furniture can show.
        if b >= 0 and found.is_clear[a] and found.is_clear[b] and odds[k] >= MAX_LOG_ODDS:
            apart = math.hypot(centre[a, 0] - centre[b, 0], centre[a, 1] - centre[b, 1])
            isolation = _ISOLATION * model.stride
            if (
                apart < isolation
                and _is_visible(found, a, b)
                and _is_visible(found, b, a)
                and _is_isolated(points, found.leg_of_return, pairs[k], x, y, isolation)
            ):
                log_odds = CLEAR_PAIR_LOG_ODDS
        store(bodies, count, body_on_legs(x, y, radius, deviation, log_odds))
        person[a] = person[other] = count
        count += 1
    return person, first_rows(bodies, count)


@callee()
def body_on_legs(x: float, y: float, radius: float, deviation: float, log_odds: float) -> Body:
    """Body about the middle (x, y) of legs."""
    return Body(x, y, radius, deviation, log_odds, x, y)


@callee()
def _is_visible(found: SingleLegs, leg: int, other: int) -> bool:
    """Check that nothing occludes an end of a leg except, perhaps, the ``other`` leg."""
    first, last = found.occluder[leg]
    leg_of = found.leg_of_return
    return bool((first == -1 or leg_of[first] == other) and (last == -1 or leg_of[last] == other))


@callee()
def _is_isolated(
    points: Floats, leg_of: Integers, pair: Integers, x: float, y: float, radius: float
) -> bool:
    """Check that all returns within ``radius`` of (x, y), m, belong to the pair of legs."""
    for i in range(points.shape[0]):
        near = math.hypot(points[i, 0] - x, points[i, 1] - y) < radius
        if near and leg_of[i] != pair[0] and leg_of[i] != pair[1]:
            return False
    return True
