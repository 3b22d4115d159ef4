"""Manoeuvres in both gears, where a line cannot be driven forward from end to end.

A robot that faces into a lift, a niche or a dead end cannot turn to its path, some places can only
be entered backwards, and some corners only be turned in several moves. The stretch of the line is
replaced by a path over (x, y, heading) in both gears. It begins and ends where the robot can turn
on the spot and the line leads on forward, or at an end of the line.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.geometry import arc_length
from cohelm.planning.path_refinement.configuration_space import ConfigurationSpace
from cohelm.planning.path_refinement.footprint import directions, overlaps, turn_overlaps
from cohelm.planning.path_refinement.hybrid_astar import HybridPath, SearchLimits, search_poses
from cohelm.planning.path_refinement.local_repair import RefinedLine, first_run
from cohelm.planning.path_refinement.waypoint_chaining import PoseBudget, all_headings

_REACH = 3.0
"""Distance that a manoeuvre may leave the box around its ends, m."""
_NEAR = 8.0
"""Length up to which a manoeuvre may lead to the end of the line at once, m."""
_APART = 20
"""Points between a manoeuvre's ends and what is wrong for a robot that never turns on the spot."""
_BEYOND = 5
"""Points beyond the first place to turn at which a manoeuvre may end."""


class Manoeuvring(NamedTuple):
    """Robot and budget of the manoeuvres on one line."""

    spaces: tuple[ConfigurationSpace, ...]
    """Configuration spaces; the one with the largest footprint that has a path is used."""
    pivots: bool
    """The robot can turn on the spot."""
    budget: PoseBudget
    """Poses that may be expanded for the line; reduced."""


def add_manoeuvres(
    line: RefinedLine, wrong: Booleans, heading: float, with_: Manoeuvring
) -> RefinedLine | None:
    """Replace what cannot be driven forward; None if no manoeuvre is found.

    Args:
        line: in the grid's frame; it is driven forward.
        wrong: True (k,) at its points where it cannot be followed; at the first one, where the
            robot cannot turn to it.
        heading: of the robot at its start, rad; NaN: free.
        with_: robot and budget.
    """
    points = line.points
    if not wrong.any():
        return RefinedLine(points=points, pivots=line.pivots)
    first, last = first_run(wrong)
    apart = 0 if with_.pivots else _APART
    begin = next((i for i in range(first - apart, 0, -1) if _turns(with_, points, i)), 0)
    seeds = _seeds(points, begin, heading)
    found = _cheapest(with_, points, seeds, _ends(with_, points, last + apart))
    if found is None:
        return None
    manoeuvre, end = found
    rest = RefinedLine(points=points[end:], pivots=line.pivots[line.pivots > end] - end)
    further = wrong[end:].copy()
    further[0] = False
    led = add_manoeuvres(rest, further, math.nan, with_)
    if led is None:
        return None
    before = RefinedLine(points=points[: begin + 1], pivots=line.pivots[line.pivots < begin])
    middle = RefinedLine(
        points=manoeuvre.points,
        pivots=manoeuvre.pivots,
        cusps=manoeuvre.cusps,
        backs_out=manoeuvre.backs_out,
    )
    return _joined([before, middle, led])


def _turns(with_: Manoeuvring, points: Floats, i: int) -> bool:
    """Check that the robot can turn on the spot at a point; one that never can needs no place."""
    x, y = float(points[i, 0]), float(points[i, 1])
    return not (with_.pivots and turn_overlaps(with_.spaces[-1].grown, x, y, 0.0, 2.0 * math.pi))


def _seeds(points: Floats, begin: int, heading: float) -> Floats:
    """Poses (m, 3) from which a manoeuvre may begin."""
    if begin > 0:
        heading = float(directions(points[begin - 1 : begin + 1])[0])
    pose = np.array([*points[begin], heading])
    return all_headings(pose) if math.isnan(heading) else pose[None]


def _ends(with_: Manoeuvring, points: Floats, last: int) -> Iterator[tuple[int, Floats]]:
    """Index and pose of each place where the manoeuvre may end: the line's end, and on the line."""
    n = len(points)
    turning = next((i for i in range(last + 1, n - 1) if _turns(with_, points, i)), n)
    on_line = turning + _BEYOND
    if on_line >= n - 1 or float(arc_length(points[min(last, n - 1) :])[-1]) <= _NEAR:
        yield n - 1, np.array([*points[-1], math.nan])
    if on_line < n - 1:
        direction = float(directions(points[on_line : on_line + 2])[0])
        yield on_line, np.array([*points[on_line], direction])


def _cheapest(
    with_: Manoeuvring, points: Floats, seeds: Floats, ends: Iterator[tuple[int, Floats]]
) -> tuple[HybridPath, int] | None:
    """Cheapest manoeuvre with the rest of the line, and the index where it ends."""
    left = float(arc_length(points)[-1]) - arc_length(points)
    targets = list(ends)
    for space in with_.spaces:
        best, below = None, math.inf
        for end, goal in targets:
            rest = float(left[end])
            share = with_.budget.share()
            limits = SearchLimits(_REACH, with_.pivots, share, reverse=True, below=below - rest)
            if math.isnan(goal[2]) and _freedom(space, goal) < _freedom(space, seeds[0]):
                start, limits = seeds[0].copy(), limits._replace(from_end=True)
                start[2] = start[2] if len(seeds) == 1 else math.nan
                found, expansions = search_poses(space, all_headings(goal), start, limits)
            else:
                found, expansions = search_poses(space, seeds, goal, limits)
            with_.budget.left -= expansions
            if found is not None:
                best, below = (found, end), found.cost + rest
        if best is not None:
            return best
    return None


def _freedom(space: ConfigurationSpace, pose: Floats) -> int:
    """Number of headings at a place that overlap nothing; a search begins where there are fewer."""
    x, y = float(pose[0]), float(pose[1])
    return sum(not overlaps(space.footprint, x, y, float(a)) for a in all_headings(pose)[:, 2])


def _joined(lines: Sequence[RefinedLine]) -> RefinedLine:
    """One line of several, each of which begins where the one before ends."""
    points, pivots, cusps = [lines[0].points[:1]], [], []
    count, gear, backs_out = 0, 0, False
    for line in lines:
        if len(line.points) < 2:
            pivots.append(line.pivots + count)
            continue
        begins = -1 if line.backs_out else 1
        if gear == 0:
            backs_out = line.backs_out
        elif begins != gear:
            cusps.append(np.array([count]))
        gear = begins * (-1) ** len(line.cusps)
        pivots.append(line.pivots + count)
        cusps.append(line.cusps + count)
        points.append(line.points[1:])
        count += len(line.points) - 1
    return RefinedLine(
        points=np.concatenate(points),
        pivots=np.unique(np.concatenate(pivots)),
        cusps=np.concatenate([*cusps, np.empty(0, dtype=np.int64)]),
        backs_out=backs_out,
    )
