"""A way for the footprint from one point of a line to another, by the places to be passed between.

Leg by leg, each found over (x, y, heading). Where the line turns back on the spot, at its ends and
where no other direction leads on, a leg may begin or end in any.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.planning.footprint import backwards, directions, turn_between
from cohelm.planning.land import Land
from cohelm.planning.turning import Turned, turn_through


class Effort:
    """Poses that may still be looked at on the way to one answer; counted down as they are.

    Args:
        poses: that may be looked at altogether.
    """

    def __init__(self, poses: int) -> None:
        self.left = poses
        self.part = 1.0
        """Of those left, how much one search may take."""

    def share(self) -> int:
        """How many the next search may look at."""
        return max(int(self.part * self.left), 1)


def through(  # noqa: PLR0913  # each is one word of the question
    land: Land,
    points: Floats,
    a: int,
    b: int,
    pins: Floats,
    *,
    free: Booleans,
    reach: float,
    pivots: bool,
    effort: Effort,
) -> Turned | None:
    """A way from point a of a line (n, 2) to its point b, through the pins between.

    Args:
        land: where.
        points: the line, m.
        a, b: indices.
        pins: (p, 2), m.
        free: (n,), at which points any heading will do.
        reach: beyond the box about the ends of a leg that it may go, m.
        pivots: whether the robot may turn on the spot.
        effort: poses that may be looked at; what is used is taken off.
    """
    start = np.array([*points[a], math.nan if free[a] else _heading(points, a)])
    end = np.array([*points[b], math.nan if free[b] else _heading(points, b)])
    between = [(pin, at) for pin in pins if a + 1 < (at := nearest(points, pin)) < b - 1]
    if not between:
        return _chain(land, [start, end], reach=reach, pivots=pivots, effort=effort)
    # The line's own direction at a pin leads on; only where it cannot be had will any other do.
    for any_will_do in (False, True):
        passed = [
            np.array([*pin, math.nan if any_will_do else _heading(points, at)])
            for pin, at in between
        ]
        stops = [start, *passed, end]
        turned = _chain(land, stops, reach=reach, pivots=pivots, effort=effort)
        if turned is not None:
            return turned
    return None


def _chain(
    land: Land, stops: list[Floats], *, reach: float, pivots: bool, effort: Effort
) -> Turned | None:
    """A way by poses in a row."""
    legs: list[Turned] = []
    for here, there in itertools.pairwise(stops):
        begin = here.copy()
        if legs:
            begin[2] = legs[-1].heading
        leg = _leg(land, begin, there, reach=reach, pivots=pivots, effort=effort)
        if leg is None:
            return None
        legs.append(leg)
    return _chained(legs)


def _leg(
    land: Land, start: Floats, end: Floats, *, reach: float, pivots: bool, effort: Effort
) -> Turned | None:
    """A way between two poses, whose heading is free where it is NaN."""
    free_start, free_end = math.isnan(start[2]), math.isnan(end[2])
    if free_start or not free_end:
        seeds = all_round(start) if free_start else start[None]
        turned, looked = turn_through(
            land, seeds, end, reach=reach, pivots=pivots, budget=effort.share()
        )
        effort.left -= looked
        if turned is not None or not free_end:
            return turned
    # Where the end is tight and its heading free, leaving it backwards is easier than hitting it.
    back = land._replace(body=backwards(land.body), grown=backwards(land.grown))
    target = start + np.array([0.0, 0.0, math.pi])
    turned, looked = turn_through(
        back, all_round(end), target, reach=reach, pivots=pivots, budget=effort.share()
    )
    effort.left -= looked
    if turned is None:
        return None
    return Turned(
        points=turned.points[::-1],
        pivots=(len(turned.points) - 1 - turned.pivots)[::-1],
        begun=turned.heading + math.pi,
        heading=turned.begun + math.pi,
    )


def all_round(pose: Floats) -> Floats:
    """Poses (64, 3) at one place in all directions."""
    out = np.tile(pose, (64, 1))
    out[:, 2] = np.arange(64) * (2.0 * math.pi / 64)
    return out


def _chained(legs: list[Turned]) -> Turned:
    points, pivots = [legs[0].points[:1]], []
    count = 0
    for leg in legs:
        pivots.append(leg.pivots + count)
        points.append(leg.points[1:])
        count += len(leg.points) - 1
    return Turned(
        points=np.concatenate(points),
        pivots=np.unique(np.concatenate(pivots)),
        heading=legs[-1].heading,
        begun=legs[0].begun,
    )


def _heading(points: Floats, index: int) -> float:
    """The mean direction of a line at an inner point."""
    before, after = directions(points[index - 1 : index + 2])
    return float(before + 0.5 * turn_between(before, after))


def nearest(points: Floats, pin: Floats) -> int:
    """The index of the point of a line that is nearest to a place."""
    return int(np.argmin(np.hypot(*(points - pin).T)))
