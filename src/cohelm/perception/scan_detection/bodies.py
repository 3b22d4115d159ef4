"""Body candidates among clusters of returns, and the split of two people who touch."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import ZERO
from cohelm.arrays import Floats, Integers
from cohelm.kernels import CACHED, callee
from cohelm.perception.clustering.shape_fits import (
    DiscPrior,
    clutter_evidence,
    disc_evidence,
    fit_disc,
    flat_evidence,
    split_discs,
)
from cohelm.perception.scan_detection.body_candidates import (
    Body,
    BodyCandidates,
    empty_candidates,
    first_rows,
    join,
    store,
)
from cohelm.perception.scan_detection.legs import (
    MAX_LOG_ODDS,
    OCCLUSION_COST,
    LegModel,
    SingleLegs,
    body_on_legs,
    occluded_width_log_odds,
    pair_legs_into_people,
)

MAX_SHAPE_LOG_ODDS = 4.0
"""Bound of the log-odds from one observation of a shape."""
LOG_ODDS_PER_RETURN = 0.85
"""Increase of the bound of a disc's log-odds per return beyond three."""
WIDTH_NOISE = 0.03
"""Standard deviation of the difference between a disc's diameter and its visible width, besides the
gaps between beams, m."""
MAX_FLAT_COST = 1.6
"""Bound of the cost of two legs that look like a flat face, as legs side by side may."""
_MIN_CLEAR_RETURNS = 5
"""Least number of returns of a clearly visible leg."""


class Beams(NamedTuple):
    """Returns of a scan in beam order; p of them."""

    points: Floats
    """(p, 2), m."""
    bearing: Floats
    """(p,) rad, increasing."""
    occluded: Integers
    """(p, 2) 1 where the beam before (after) a return ends at something nearer."""
    cluster: Integers
    """(p,) −1: none."""
    origin: Floats
    """(2,) the sensor, m."""
    increment: float
    """Angle between beams, rad."""


class BodySizes(NamedTuple):
    """Widths of bodies, m."""

    narrowest: float
    widest: float
    split_from: float
    """Width from which a split into two people is tried."""


class _Run(NamedTuple):
    """Consecutive returns of one cluster, (m, 2) m; widths in m."""

    points: Floats
    origin: Floats
    width: float
    gap: float
    """Largest excess of the true width over that of the returns: one beam's gap at either end."""
    occluded: bool
    """True if something nearer hides an end, so that the width is unbounded."""


@njit(**CACHED)
def find_bodies(
    beams: Beams, sizes: BodySizes, prior: DiscPrior, legs: LegModel
) -> tuple[Integers, BodyCandidates]:
    """Find people among clustered returns: torsos, legs that touch, and legs within a stride.

    Returns:
        The candidate of each return (p,), −1 for none, and the candidates.
    """
    n = beams.points.shape[0]
    body_of_return = np.full(n, -1, dtype=np.int64)
    bodies = empty_candidates(n)
    single = SingleLegs(
        np.empty((n, 2)),
        np.empty(n),
        np.zeros(n, dtype=np.bool_),
        np.full((n, 2), -1),
        np.full(n, -1, dtype=np.int64),
    )
    count = singles = ZERO
    todo = np.empty((n + 1, 2), dtype=np.int64)
    for cluster in range(beams.cluster.max() + 1 if n else 0):
        members = _in_beam_order(beams, cluster)
        todo[0, 0], todo[0, 1], left = 0, members.size, 1
        while left > 0:
            left -= 1
            start, stop = todo[left, 0], todo[left, 1]
            index = members[start:stop]
            run = _run(beams, index)
            # A wide run is split as long as two discs explain it much better than one shape.
            if run.width > sizes.split_from and index.size >= 4 and run.width < 3.0 * sizes.widest:
                cut = split_discs(run.points, run.origin, prior)
                if cut > 0:
                    todo[left, 0], todo[left, 1] = start, start + cut
                    todo[left + 1, 0], todo[left + 1, 1] = start + cut, stop
                    left += 2
                    continue
            if index.size < 2 or (run.width > sizes.widest + run.gap and not run.occluded):
                continue
            is_body, body, leg_log_odds = _classify(run, sizes, prior, legs)
            if is_body:
                store(bodies, count, body)
                body_of_return[index] = count
                count += 1
            else:
                # Single legs are paired below, once all are known.
                _store_leg(single, singles, beams, index, body, leg_log_odds)
                singles += 1
    found = SingleLegs(
        single.centre[:singles],
        single.log_odds[:singles],
        single.is_clear[:singles],
        single.occluder[:singles],
        single.leg_of_return,
    )
    person, on_legs = pair_legs_into_people(beams.points, found, prior.radius, legs)
    for i in range(n):
        leg = single.leg_of_return[i]
        if leg >= 0 and person[leg] >= 0:
            body_of_return[i] = count + person[leg]
    return body_of_return, join(first_rows(bodies, count), on_legs)


@callee()
def _store_leg(
    single: SingleLegs, k: int, beams: Beams, index: Integers, body: Body, log_odds: float
) -> None:
    """Write the run of returns ``index`` into row ``k`` of the single legs, in place."""
    n = beams.points.shape[0]
    single.centre[k, 0], single.centre[k, 1] = body.mean_x, body.mean_y
    single.log_odds[k] = log_odds
    single.is_clear[k] = index.size >= _MIN_CLEAR_RETURNS and log_odds > 0.0
    if beams.occluded[index[0], 0]:
        single.occluder[k, 0] = (index[0] - 1) % n
    if beams.occluded[index[-1], 1]:
        single.occluder[k, 1] = (index[-1] + 1) % n
    single.leg_of_return[index] = k


@callee()
def _classify(
    run: _Run, sizes: BodySizes, prior: DiscPrior, legs: LegModel
) -> tuple[bool, Body, float]:
    """(True for a body and False for one leg, the body, log-odds of one leg) of a run."""
    width, gap, occluded = run.width, run.gap, run.occluded
    body, flatness = _disc_body(run, prior)
    wide = width + gap >= sizes.narrowest
    torso = body.log_odds if occluded or wide else -np.inf
    one = occluded_width_log_odds(width, gap, occluded, legs.width, legs.width_deviation)
    two = occluded_width_log_odds(width, gap, occluded, legs.pair_width, legs.pair_width_deviation)
    if wide:
        two -= min(max(flatness, 0.0), MAX_FLAT_COST)
    # A narrow, partly occluded run is weak evidence for a torso, and none if one leg explains it.
    if occluded and not wide:
        torso = min(torso, MAX_LOG_ODDS)
        body = _with_log_odds(body, torso)
        if width + gap < legs.width + 2.0 * legs.width_deviation:
            torso = two = -np.inf
    # An occluded run, and one of few beams, may be much wider than it looks: in favour of a torso.
    bonus = OCCLUSION_COST if occluded or gap > 0.5 * sizes.narrowest else 0.0
    if torso + bonus >= min(max(one + legs.single_log_odds, two), MAX_LOG_ODDS):
        return True, body, one
    if two >= one + legs.single_log_odds:
        odds = min(two, MAX_LOG_ODDS)
        on_legs = body_on_legs(body.mean_x, body.mean_y, prior.radius, legs.pair_deviation, odds)
        return True, on_legs, one
    return False, body, one


@callee()
def _with_log_odds(body: Body, log_odds: float) -> Body:
    return Body(body.x, body.y, body.radius, body.deviation, log_odds, body.mean_x, body.mean_y)


@callee()
def _disc_body(run: _Run, prior: DiscPrior) -> tuple[Body, float]:
    """(body for the disc behind a run, log-odds of a flat face or a corner).

    A disc that nothing occludes is seen from tangent to tangent: a run much narrower than the disc
    that fits it best is part of another object. So is a run that fits a disc of another size.
    """
    points, m = run.points, run.points.shape[0]
    fit = fit_disc(points, run.origin, prior)
    disc, clutter = disc_evidence(fit.misfit, m), clutter_evidence(fit.misfit, m)
    flat = flat_evidence(points, prior.noise)
    odds = 0.5 * (min(clutter, flat) - disc)
    odds = min(max(odds, -MAX_SHAPE_LOG_ODDS), MAX_SHAPE_LOG_ODDS)
    if not run.occluded:
        lacking = max(2.0 * fit.radius - run.width - 0.5 * run.gap, 0.0)
        lacking /= math.hypot(WIDTH_NOISE, 0.45 * run.gap)
        odds -= min(0.5 * lacking * lacking, MAX_SHAPE_LOG_ODDS)
    unusual = (fit.radius - prior.radius) / (0.45 * prior.radius_deviation)
    odds = max(odds - 0.5 * unusual * unusual, -MAX_SHAPE_LOG_ODDS)
    odds = min(odds, MAX_LOG_ODDS + LOG_ODDS_PER_RETURN * max(m - 3, 0))
    mx, my = points[:, 0].mean(), points[:, 1].mean()
    flatness = 0.5 * (min(disc, clutter) - flat)
    return Body(fit.x, fit.y, fit.radius, fit.deviation, odds, mx, my), flatness


@callee()
def _in_beam_order(beams: Beams, cluster: int) -> Integers:
    """Members of a cluster; across the scan's seam, the later part comes first."""
    members = np.flatnonzero(beams.cluster == cluster)
    widest, at = math.pi, 0
    for i in range(1, members.size):
        gap = beams.bearing[members[i]] - beams.bearing[members[i - 1]]
        if gap > widest:
            widest, at = gap, i
    return np.concatenate((members[at:], members[:at]))


@callee()
def _run(beams: Beams, index: Integers) -> _Run:
    """The run of some returns; its width is the largest distance of a point from either end."""
    points, origin = beams.points[index], beams.origin
    width, last = 0.0, points.shape[0] - 1
    for i in range(points.shape[0]):
        for end in (0, last):
            d = math.hypot(points[i, 0] - points[end, 0], points[i, 1] - points[end, 1])
            width = max(width, d)
    gap, occluded = 0.0, False
    for side in range(2):
        i = index[0] if side == 0 else index[-1]
        occluded |= beams.occluded[i, side] > 0
        x, y = beams.points[i, 0], beams.points[i, 1]
        gap += math.hypot(x - origin[0], y - origin[1]) * beams.increment
    return _Run(points, origin, width, gap, occluded)
