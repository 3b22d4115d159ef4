"""From a smooth line to one that the robot's footprint can follow.

The line is driven in thought. Where the footprint meets something, or the line bends more than the
robot can, the stretch is replaced by one found over (x, y, heading): first by a curve, in a wider
and wider window, then with turns on the spot. What is found is eased, never touching anything.
Where that fails too, the line is stuck, and the place is told.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.geometry import wrap_angle
from cohelm.maps.distance import sample
from cohelm.planning.easing import ease
from cohelm.planning.footprint import backwards, directions, turn_between
from cohelm.planning.land import Land, misfits
from cohelm.planning.turning import Turned, turn_through

_TRIES = (
    (0.5, 1.0, False, 0.04),
    (1.5, 2.0, False, 0.15),
    (3.0, 3.0, False, 0.2),
    (1.5, 2.0, True, 0.2),
    (3.0, 4.0, True, 0.25),
)
"""(stretch replaced before and after, window about it, m; turns on the spot; share of the poses
left that a search may look at)."""
_LEAST = 500  # poses below which it is not worth while
_LOOP = 1.25 * math.pi  # rad that a curve may turn more than what it replaces, without turns
_CUSP = 2.5  # rad, above which a line turns back
_REPAIRS = 12


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


@value
class Fitted:
    """A line, and whether the robot can follow it."""

    points: Annotated[Floats, Shape("k 2")]
    """Grid's frame, m."""
    pivots: Annotated[Integers, Shape("p")]
    """Indices of the points where the robot turns on the spot."""
    stuck: Annotated[Floats, Shape("2")] | None = None
    """Where it cannot follow; None: it can."""


def fit(
    land: Land,
    line: Floats,
    *,
    pins: Floats,
    effort: Effort,
    forgiven: float = 0.0,
) -> Fitted:
    """A line for the footprint along a smooth one (n, 2), both ends kept.

    Args:
        land: where, with the footprint.
        line: in the grid's frame, m.
        pins: points (p, 2) that it must keep passing, in order.
        effort: poses that may be looked at; what is used is taken off.
        forgiven: how far from its start the line may touch what the robot stood beside, where
            nothing else leads away, m.
    """
    pivots = np.empty(0, dtype=np.int64)
    fitted = Fitted(points=line, pivots=pivots)
    for _ in range(_REPAIRS):
        wrong = misfits(land, fitted.points, fitted.pivots)
        if not wrong.any():
            return fitted
        repaired = _repaired(land, fitted, wrong, pins, effort)
        if repaired is None:
            break
        fitted = repaired
    points = fitted.points
    wrong = misfits(land, points, fitted.pivots)
    if forgiven > 0.0:
        away = np.hypot(*(points - points[0]).T) > forgiven
        wrong &= away
    if not wrong.any():
        return fitted
    first, last = _first_run(wrong)
    return Fitted(points=points, pivots=fitted.pivots, stuck=points[(first + last) // 2])


def _repaired(
    land: Land, fitted: Fitted, wrong: Booleans, pins: Floats, effort: Effort
) -> Fitted | None:
    """The line with its first wrong stretch replaced, or None where nothing fits."""
    points = fitted.points
    first, last = _first_run(wrong)
    taken = wrong.copy()
    taken[fitted.pivots] = True  # no stretch begins or ends where the heading jumps
    for margin, reach, pivots, part in _TRIES:
        if effort.left < _LEAST:
            break
        effort.part = part
        spare = math.ceil(margin / 0.1)
        a, b = _fitting_before(taken, first - spare), _fitting_after(taken, last + spare)
        near = land._replace(floor=_floor(land, points[a], points[b]))
        turned = _through(near, points, a, b, pins, reach=reach, pivots=pivots, effort=effort)
        if turned is None or not (pivots or _is_direct(points[a : b + 1], turned.points)):
            continue
        repaired = _spliced(fitted, turned, a, b)
        there = slice(max(a - 1, 0), a + len(turned.points) + 1)
        if not misfits(land, repaired.points, repaired.pivots)[there].any():
            eased = _eased(near, repaired, a, a + len(turned.points) - 1, pins)
            there = slice(max(a - 5, 0), a + len(turned.points) + 5)
            return repaired if misfits(land, eased.points, eased.pivots)[there].any() else eased
    return None


def _is_direct(old: Floats, new: Floats) -> bool:
    """Whether a curve makes no loop that the line it replaces does not make."""
    before, after = (np.diff(directions(line)) for line in (old, new))
    before, after = wrap_angle(before), wrap_angle(after)
    if len(before) and np.abs(before).max() > _CUSP:
        return True
    return bool(abs(after.sum() - before.sum()) < _LOOP)


def _through(
    land: Land,
    points: Floats,
    a: int,
    b: int,
    pins: Floats,
    *,
    reach: float,
    pivots: bool,
    effort: Effort,
) -> Turned | None:
    """A way from point a of a line to its point b, through the pins between."""
    last = len(points) - 1
    start = np.array([*points[a], math.nan if a == 0 else _heading(points, a)])
    end = np.array([*points[b], math.nan if b == last else _heading(points, b)])
    between = [(pin, at) for pin in pins if a + 1 < (at := _nearest(points, pin)) < b - 1]
    if not between:
        return _chain(land, [start, end], reach=reach, pivots=pivots, effort=effort)
    # The line's own direction at a pin leads on; only where it cannot be had will any other do.
    for free in (False, True):
        passed = [
            np.array([*pin, math.nan if free else _heading(points, at)]) for pin, at in between
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


def _spliced(fitted: Fitted, turned: Turned, a: int, b: int) -> Fitted:
    """The line with its points a … b replaced."""
    points, new = fitted.points, turned.points.copy()
    new[0], new[-1] = points[a], points[b]
    grown = len(new) - (b - a + 1)
    old = fitted.pivots
    pivots = np.concatenate([old[old < a], turned.pivots + a, old[old > b] + grown])
    joined = np.concatenate([points[:a], new, points[b + 1 :]])
    inner = (pivots > 0) & (pivots < len(joined) - 1)
    return Fitted(points=joined, pivots=np.unique(pivots[inner]))


def _eased(land: Land, fitted: Fitted, first: int, last: int, pins: Floats) -> Fitted:
    """The line with a stretch pulled straight as far as footprint and curvature allow."""
    points = fitted.points.copy()
    pivot = np.zeros(len(points), dtype=np.bool_)
    pivot[fitted.pivots] = True
    fixed = pivot.copy()
    for pin in pins:
        fixed[_nearest(points, pin)] = True
    fixed[0] = fixed[-1] = True
    ease(land, points, fixed, pivot, max(first - 3, 1), min(last + 3, len(points) - 2))
    return Fitted(points=points, pivots=fitted.pivots)


def _first_run(wrong: Booleans) -> tuple[int, int]:
    """The first stretch of points that do not fit, gaps of under a metre included."""
    at = np.flatnonzero(wrong)
    gaps = np.flatnonzero(np.diff(at) > 10)
    return int(at[0]), int(at[gaps[0]] if len(gaps) else at[-1])


def _fitting_before(wrong: Booleans, index: int) -> int:
    while index > 0 and wrong[index]:
        index -= 1
    return index if index > 2 else 0


def _fitting_after(wrong: Booleans, index: int) -> int:
    last = len(wrong) - 1
    while index < last and wrong[index]:
        index += 1
    return index if index < last - 2 else last


def _floor(land: Land, *ends: Floats) -> float:
    """The clearance that the centre keeps on a stretch: no more than its ends have."""
    res = land.body.resolution
    rooms = [sample(land.clearance, res, np.zeros(3), x, y)[0] for x, y in ends]
    return min(land.floor, *rooms) - 1e-6


def _heading(points: Floats, index: int) -> float:
    """The mean direction of a line at an inner point."""
    before, after = directions(points[index - 1 : index + 2])
    return float(before + 0.5 * turn_between(before, after))


def _nearest(points: Floats, pin: Floats) -> int:
    return int(np.argmin(np.hypot(*(points - pin).T)))
