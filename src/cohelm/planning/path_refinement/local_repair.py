"""Local repair of a smooth line into one that the robot's footprint can follow.

The line is tested with the footprint. Where the footprint overlaps an obstacle, or the line bends
more than the robot can, the stretch is replaced by one found over (x, y, heading): first by a
curve, in larger and larger windows, then with turns on the spot. The new stretch is pulled straight
without an overlap. If that fails too, the line is stuck at that point.

String pulling: straighten a line that the footprint can follow, as far as it still can.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.geometry import wrap_angle
from cohelm.kernels import CACHED
from cohelm.maps.distance import sample
from cohelm.planning.path_refinement.configuration_space import (
    ConfigurationSpace,
    centre_is_free,
    infeasible_points,
)
from cohelm.planning.path_refinement.footprint import directions, overlaps_along
from cohelm.planning.path_refinement.hybrid_astar import HybridPath, SearchLimits
from cohelm.planning.path_refinement.loops import has_loop
from cohelm.planning.path_refinement.smoothing import curvature_of
from cohelm.planning.path_refinement.waypoint_chaining import (
    PLACE,
    PoseBudget,
    Stretch,
    chain_waypoints,
    nearest_index,
)

_ITERATIONS = 15


@njit(**CACHED)
def pull_string(
    space: ConfigurationSpace,
    line: Floats,
    fixed: Booleans,
    pivot: Booleans,
    first: int,
    last: int,
) -> None:
    """Move points first … last in place to their neighbours' midpoint where the footprint fits.

    Args:
        space: the configuration space.
        line: (n, 2), changed in place, m.
        fixed: (n,), points that must not move.
        pivot: (n,), points where the robot turns on the spot.
        first, last: inner points.
    """
    limit = space.curvature
    for round_ in range(_ITERATIONS):
        moved = 0.0
        for k in range(first, last + 1):
            i = k if round_ % 2 == 0 else first + last - k
            if fixed[i]:
                continue
            ox, oy = line[i, 0], line[i, 1]
            x = 0.5 * (line[i - 1, 0] + line[i + 1, 0])
            y = 0.5 * (line[i - 1, 1] + line[i + 1, 1])
            step = math.hypot(x - ox, y - oy)
            if step < 1e-4 or not centre_is_free(space, x, y):
                continue
            # Keep the move only if curvature and footprint allow it nearby.
            line[i, 0], line[i, 1] = x, y
            low, high = max(i - 2, 0), min(i + 3, line.shape[0])
            bends = curvature_of(line[low:high])
            good = True
            for j in range(1, bends.shape[0] - 1):
                if bends[j] > limit and not pivot[low + j]:
                    good = False
            if good and not overlaps_along(space.footprint, line[low:high]).any():
                moved = max(moved, step)
            else:
                line[i, 0], line[i, 1] = ox, oy
        if moved < 1e-3:
            break


class _Attempt(NamedTuple):
    margin: float
    """Length that is replaced before and after, m."""
    reach: float
    """Window around the stretch, m."""
    pivots: bool
    """Turns on the spot are allowed."""
    part: float
    """Share of the remaining poses that a search may use."""


_ATTEMPTS = (
    _Attempt(0.5, 1.0, False, 0.04),
    _Attempt(1.5, 2.0, False, 0.15),
    _Attempt(3.0, 3.0, False, 0.2),
    _Attempt(1.5, 2.0, True, 0.2),
    _Attempt(3.0, 4.0, True, 0.25),
)
_WIDE_ATTEMPTS = (
    _Attempt(0.5, 1.0, False, 0.1),
    _Attempt(1.5, 2.0, False, 0.4),
    _Attempt(3.0, 3.0, False, 0.6),
)
"""Attempts with a larger footprint, which may not fit at all."""
_MIN_POSES = 300  # below which a search is not worthwhile
_LOOP = 1.25 * math.pi  # rad that a curve may turn more than the stretch that it replaces
_CUSP = 2.5  # rad, above which a line reverses
_REPAIRS = 12  # of one place
_LONGER = 40  # points by which a stretch may be extended until both ends fit
_NEARBY = 0.5  # m


@value
class RefinedLine:
    """Line in the grid's frame, and whether the robot can follow it."""

    points: Annotated[Floats, Shape("k 2")]
    """m."""
    pivots: Annotated[Integers, Shape("p")]
    """Indices of the points where the robot turns on the spot."""
    cusps: Annotated[Integers, Shape("c")] = field(default_factory=lambda: np.empty(0, np.int64))
    """Indices of the points where the robot changes its gear."""
    backs_out: bool = False
    """The first stretch is driven backwards."""
    stuck: Annotated[Floats, Shape("2")] | None = None
    """Point where the robot cannot follow, m; None if it can."""


def repair(
    space: ConfigurationSpace,
    line: RefinedLine,
    waypoints: Floats,
    budget: PoseBudget,
    *,
    wide: tuple[ConfigurationSpace, ...] = (),
    forgiven: float = 0.0,
) -> RefinedLine:
    """Repair a smooth line for the footprint; both ends are kept.

    Args:
        space: the configuration space.
        line: the line, with the turns on the spot that it has already.
        waypoints: points (p, 2) that the line must still pass, in order, m.
        budget: poses that may be expanded; reduced.
        wide: spaces of larger footprints, the largest first; a replaced stretch keeps their
            clearance if possible.
        forgiven: distance from its start within which the line may overlap obstacles that the robot
            stood beside, if nothing else leads away, m.
    """
    fitted, places = line, list[Floats]()
    while True:
        wrong = infeasible_points(space, fitted.points, fitted.pivots)
        if not wrong.any():
            return fitted
        if _is_worn(places, fitted.points[first_run(wrong)[0]]):
            break
        attempts = _attempts(space, wide, _ATTEMPTS)
        repaired = _repaired(space, fitted, wrong, waypoints, budget, attempts)
        if repaired is None:
            break
        fitted = repaired
    points = fitted.points
    wrong = infeasible_points(space, points, fitted.pivots)
    if forgiven > 0.0:
        away = np.hypot(*(points - points[0]).T) > forgiven
        wrong &= away
    stuck = None
    if wrong.any():
        first, last = first_run(wrong)
        stuck = points[(first + last) // 2]
    return RefinedLine(points=points, pivots=fitted.pivots, stuck=stuck)


def widen_clearance(
    space: ConfigurationSpace,
    fitted: RefinedLine,
    waypoints: Floats,
    budget: PoseBudget,
    *,
    wide: tuple[ConfigurationSpace, ...] = (),
) -> RefinedLine:
    """Move the line to where a larger footprint fits, wherever a curve nearby allows it.

    Args:
        space: the configuration space of the larger footprint.
        fitted: the line.
        waypoints: points (p, 2) that the line must still pass, in order, m.
        budget: poses that may be expanded; reduced.
        wide: see :func:`repair`.
    """
    hopeless: list[Floats] = []
    places: list[Floats] = []
    while True:
        points = fitted.points
        wrong = infeasible_points(space, points, fitted.pivots)
        for stretch in hopeless:
            wrong &= np.hypot(*(points[:, None] - stretch).T).min(axis=0) > _NEARBY
        if not wrong.any():
            break
        first, last = first_run(wrong)
        attempts = _attempts(space, wide, _WIDE_ATTEMPTS)
        worn = _is_worn(places, points[first])
        repaired = None if worn else _repaired(space, fitted, wrong, waypoints, budget, attempts)
        if repaired is None:
            hopeless.append(points[first : last + 1])
        else:
            fitted = repaired
    return fitted


def _is_worn(places: list[Floats], point: Floats) -> bool:
    """Check that a place was repaired as often as is allowed; otherwise note one more repair."""
    repairs = sum(np.hypot(*(place - point)) < PLACE for place in places)
    places.append(point)
    return bool(repairs >= _REPAIRS)


def _attempts(
    space: ConfigurationSpace, wide: tuple[ConfigurationSpace, ...], attempts: tuple[_Attempt, ...]
) -> Iterator[tuple[ConfigurationSpace, _Attempt]]:
    yield from ((where, each) for where in wide for each in _ATTEMPTS[:2])
    yield from ((space, each) for each in attempts)


def _repaired(
    space: ConfigurationSpace,
    fitted: RefinedLine,
    wrong: Booleans,
    waypoints: Floats,
    budget: PoseBudget,
    attempts: Iterator[tuple[ConfigurationSpace, _Attempt]],
) -> RefinedLine | None:
    """Replace the first wrong stretch, by one without loops if possible; None if nothing fits."""
    points = fitted.points
    first, last = first_run(wrong)
    budget.enter(points[first])
    with_loop = None
    for where, attempt in attempts:
        if budget.left < _MIN_POSES:
            break
        budget.part = attempt.part
        margin = math.ceil(attempt.margin / 0.1)
        taken = wrong if where is space else infeasible_points(where, points, fitted.pivots)
        a, b = _ends_of(taken, fitted.pivots, first, last, margin)
        if b - a > last - first + 2 * margin + _LONGER:
            continue
        free = np.zeros(len(points), dtype=np.bool_)
        free[[0, -1]] = free[fitted.pivots] = True
        near = where._replace(floor=_floor(where, points[a], points[b]))
        limits = SearchLimits(reach=attempt.reach, pivots=attempt.pivots)
        found = chain_waypoints(near, Stretch(points, a, b, free), waypoints, limits, budget)
        if found is None or not (attempt.pivots or _is_direct(points[a : b + 1], found.points)):
            continue
        repaired = _inserted(near, fitted, found, a, b, waypoints)
        if repaired is None:
            continue
        if not has_loop(found.points, found.pivots):
            return repaired
        with_loop = with_loop or repaired
    if with_loop is None:
        budget.spend(points[first])
    return with_loop


def _ends_of(
    taken: Booleans, pivots: Integers, first: int, last: int, margin: int
) -> tuple[int, int]:
    """Ends of the stretch to be replaced for a wrong one.

    Turns on the spot beside it are kept. A single wrong point may be such a turn, where the heading
    jumps; then the stretch extends beyond it on both sides.
    """
    taken = taken.copy()
    taken[pivots] = True
    before, after = pivots[pivots <= first], pivots[pivots >= last]
    a, b = _fitting_before(taken, first - margin), _fitting_after(taken, last + margin)
    if first < last:
        a = max(a, int(before[-1]) if len(before) else 0)
        b = min(b, int(after[0]) if len(after) else len(taken) - 1)
    return a, b


def _inserted(
    space: ConfigurationSpace,
    fitted: RefinedLine,
    found: HybridPath,
    a: int,
    b: int,
    waypoints: Floats,
) -> RefinedLine | None:
    """Replace points a … b and pull the line straight there; None if it does not fit after all."""
    repaired = _spliced(fitted, found, a, b)
    window = slice(max(a - 1, 0), a + len(found.points) + 1)
    if infeasible_points(space, repaired.points, repaired.pivots)[window].any():
        return None
    pulled = _pulled(space, repaired, a, a + len(found.points) - 1, waypoints)
    window = slice(max(a - 5, 0), a + len(found.points) + 5)
    wrong = infeasible_points(space, pulled.points, pulled.pivots)[window].any()
    return repaired if wrong else pulled


def _is_direct(old: Floats, new: Floats) -> bool:
    """Check that a curve makes no loop that the replaced line does not make."""
    before, after = (np.diff(directions(line)) for line in (old, new))
    before, after = wrap_angle(before), wrap_angle(after)
    if len(before) and np.abs(before).max() > _CUSP:
        return True
    return bool(abs(after.sum() - before.sum()) < _LOOP)


def _spliced(fitted: RefinedLine, found: HybridPath, a: int, b: int) -> RefinedLine:
    """Replace points a … b of the line."""
    points, new = fitted.points, found.points.copy()
    new[0], new[-1] = points[a], points[b]
    grown = len(new) - (b - a + 1)
    old = fitted.pivots
    pivots = np.concatenate([old[old <= a], found.pivots + a, old[old >= b] + grown])
    joined = np.concatenate([points[:a], new, points[b + 1 :]])
    inner = (pivots > 0) & (pivots < len(joined) - 1)
    return RefinedLine(points=joined, pivots=np.unique(pivots[inner]))


def _pulled(
    space: ConfigurationSpace, fitted: RefinedLine, first: int, last: int, waypoints: Floats
) -> RefinedLine:
    """Pull a stretch of the line straight, as far as footprint and curvature allow."""
    points = fitted.points.copy()
    pivot = np.zeros(len(points), dtype=np.bool_)
    pivot[fitted.pivots] = True
    fixed = pivot.copy()
    for waypoint in waypoints:
        fixed[nearest_index(points, waypoint)] = True
    fixed[0] = fixed[-1] = True
    pull_string(space, points, fixed, pivot, max(first - 3, 1), min(last + 3, len(points) - 2))
    return RefinedLine(points=points, pivots=fitted.pivots)


def first_run(wrong: Booleans) -> tuple[int, int]:
    """First stretch of infeasible points; gaps of less than a metre belong to it."""
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


def _floor(space: ConfigurationSpace, *ends: Floats) -> float:
    """Clearance that the centre keeps on a stretch: at most that of its ends."""
    res = space.footprint.resolution
    clearances = [sample(space.clearance, res, np.zeros(3), x, y)[0] for x, y in ends]
    return min(space.floor, *clearances) - 1e-6
