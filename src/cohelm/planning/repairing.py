"""From a smooth line to one that the robot's footprint can follow.

The line is driven in thought. Where the footprint meets something, or the line bends more than the
robot can, the stretch is replaced by one found over (x, y, heading): first by a curve, in a wider
and wider window, then with turns on the spot. What is found is eased, never touching anything.
Where that fails too, the line is stuck, and the place is told.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.geometry import wrap_angle
from cohelm.maps.distance import sample
from cohelm.planning.chaining import Effort, nearest, through
from cohelm.planning.easing import ease
from cohelm.planning.footprint import directions
from cohelm.planning.land import Land, misfits
from cohelm.planning.rings import has_ring
from cohelm.planning.turning import Turned

_TRIES = (
    (0.5, 1.0, False, 0.04),
    (1.5, 2.0, False, 0.15),
    (3.0, 3.0, False, 0.2),
    (1.5, 2.0, True, 0.2),
    (3.0, 4.0, True, 0.25),
)
"""(stretch replaced before and after, window about it, m; turns on the spot; share of the poses
left that a search may look at)."""
_WIDE_TRIES = ((0.5, 1.0, False, 0.1), (1.5, 2.0, False, 0.4), (3.0, 3.0, False, 0.6))
"""The same where there is room at best for a larger footprint."""
_LEAST = 300  # poses below which it is not worth while
_LOOP = 1.25 * math.pi  # rad that a curve may turn more than what it replaces, without turns
_CUSP = 2.5  # rad, above which a line turns back
_REPAIRS = 12
_LONGER = 40  # points that a stretch may be longer than it should, to begin and end where it fits
_NEARBY = 0.5  # m

_NONE = np.empty(0, dtype=np.int64)
_Try = tuple[float, float, bool, float]


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
    pivots: Integers = _NONE,
    wide: tuple[Land, ...] = (),
    forgiven: float = 0.0,
) -> Fitted:
    """A line for the footprint along a smooth one (n, 2), both ends kept.

    Args:
        land: where, with the footprint.
        line: in the grid's frame, m.
        pins: points (p, 2) that it must keep passing, in order.
        effort: poses that may be looked at; what is used is taken off.
        pivots: indices at which the robot turns on the spot already.
        wide: with larger footprints, the largest first, for which the stretches that are replaced
            have room where they can.
        forgiven: how far from its start the line may touch what the robot stood beside, where
            nothing else leads away, m.
    """
    fitted = Fitted(points=line, pivots=pivots)
    for _ in range(_REPAIRS):
        wrong = misfits(land, fitted.points, fitted.pivots)
        if not wrong.any():
            return fitted
        repaired = _repaired(land, fitted, wrong, pins, effort, _attempts(land, wide, _TRIES))
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


def widen(
    land: Land, fitted: Fitted, *, pins: Floats, effort: Effort, wide: tuple[Land, ...] = ()
) -> Fitted:
    """The line with room for a larger footprint wherever a curve nearby has it.

    Args:
        land: where, with the larger footprint.
        fitted: the line.
        pins: points (p, 2) that it must keep passing, in order.
        effort: poses that may be looked at; what is used is taken off.
        wide: as for ``fit``.
    """
    hopeless: list[Floats] = []
    for _ in range(_REPAIRS):
        points = fitted.points
        wrong = misfits(land, points, fitted.pivots)
        for place in hopeless:
            wrong &= np.hypot(*(points[:, None] - place).T).min(axis=0) > _NEARBY
        if not wrong.any():
            break
        tries = _attempts(land, wide, _WIDE_TRIES)
        repaired = _repaired(land, fitted, wrong, pins, effort, tries)
        if repaired is None:
            first, last = _first_run(wrong)
            hopeless.append(points[first : last + 1])
        else:
            fitted = repaired
    return fitted


def _attempts(
    land: Land, wide: tuple[Land, ...], tries: tuple[_Try, ...]
) -> Iterator[tuple[Land, _Try]]:
    yield from ((where, each) for where in wide for each in _TRIES[:2])
    yield from ((land, each) for each in tries)


def _repaired(
    land: Land,
    fitted: Fitted,
    wrong: Booleans,
    pins: Floats,
    effort: Effort,
    attempts: Iterator[tuple[Land, _Try]],
) -> Fitted | None:
    """The line with its first wrong stretch replaced, or None where nothing fits.

    By one without rings, if there is any.
    """
    points = fitted.points
    first, last = _first_run(wrong)
    ringed = None
    for where, (margin, reach, pivots, part) in attempts:
        if effort.left < _LEAST:
            break
        effort.part = part
        spare = math.ceil(margin / 0.1)
        taken = wrong if where is land else misfits(where, points, fitted.pivots)
        a, b = _about(taken, fitted.pivots, first, last, spare)
        if b - a > last - first + 2 * spare + _LONGER:
            continue
        free = np.zeros(len(points), dtype=np.bool_)
        free[[0, -1]] = free[fitted.pivots] = True
        near = where._replace(floor=_floor(where, points[a], points[b]))
        turned = through(
            near, points, a, b, pins, free=free, reach=reach, pivots=pivots, effort=effort
        )
        if turned is None or not (pivots or _is_direct(points[a : b + 1], turned.points)):
            continue
        repaired = _settled(near, fitted, turned, a, b, pins)
        if repaired is None:
            continue
        if not has_ring(turned.points, turned.pivots):
            return repaired
        ringed = ringed or repaired
    return ringed


def _about(taken: Booleans, pivots: Integers, first: int, last: int, spare: int) -> tuple[int, int]:
    """The ends of the stretch to be replaced for one that is wrong.

    Pivots beside it stay; across one that is wrong itself, none begins or ends where the heading
    jumps.
    """
    taken = taken.copy()
    taken[pivots] = True
    before, after = pivots[pivots <= first], pivots[pivots >= last]
    a, b = _fitting_before(taken, first - spare), _fitting_after(taken, last + spare)
    if first < last:
        a = max(a, int(before[-1]) if len(before) else 0)
        b = min(b, int(after[0]) if len(after) else len(taken) - 1)
    return a, b


def _settled(
    land: Land, fitted: Fitted, turned: Turned, a: int, b: int, pins: Floats
) -> Fitted | None:
    """The line with its points a … b replaced and eased; None where it does not fit after all."""
    repaired = _spliced(fitted, turned, a, b)
    there = slice(max(a - 1, 0), a + len(turned.points) + 1)
    if misfits(land, repaired.points, repaired.pivots)[there].any():
        return None
    eased = _eased(land, repaired, a, a + len(turned.points) - 1, pins)
    there = slice(max(a - 5, 0), a + len(turned.points) + 5)
    return repaired if misfits(land, eased.points, eased.pivots)[there].any() else eased


def _is_direct(old: Floats, new: Floats) -> bool:
    """Whether a curve makes no loop that the line it replaces does not make."""
    before, after = (np.diff(directions(line)) for line in (old, new))
    before, after = wrap_angle(before), wrap_angle(after)
    if len(before) and np.abs(before).max() > _CUSP:
        return True
    return bool(abs(after.sum() - before.sum()) < _LOOP)


def _spliced(fitted: Fitted, turned: Turned, a: int, b: int) -> Fitted:
    """The line with its points a … b replaced."""
    points, new = fitted.points, turned.points.copy()
    new[0], new[-1] = points[a], points[b]
    grown = len(new) - (b - a + 1)
    old = fitted.pivots
    pivots = np.concatenate([old[old <= a], turned.pivots + a, old[old >= b] + grown])
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
        fixed[nearest(points, pin)] = True
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
