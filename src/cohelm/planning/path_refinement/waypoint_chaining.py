"""Paths for the footprint from one point of a line to another through the waypoints between.

Each leg is found by hybrid A*. Where the line reverses on the spot, at its ends, and where no other
direction leads on, a leg may begin or end with any heading.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.planning.path_refinement.configuration_space import ConfigurationSpace
from cohelm.planning.path_refinement.footprint import directions, reversed_footprint, turn_between
from cohelm.planning.path_refinement.hybrid_astar import HybridPath, SearchLimits, search_poses

PLACE = 2.0
"""Points closer than this belong to one place, m."""


class PoseBudget:
    """Poses that may still be expanded, for each place of a map; reduced by each search.

    Args:
        poses: number of poses for all searches at one place.
    """

    def __init__(self, poses: int) -> None:
        self.poses = self.left = poses
        self.part = 1.0
        """Share of the remaining poses that one search may use."""
        self._places: list[tuple[Floats, int]] = []

    def share(self) -> int:
        """Number of poses for the next search."""
        return max(int(self.part * self.left), 1)

    def enter(self, point: Floats) -> None:
        """Take what is left at the place of a point (2,), m."""
        left = [n for place, n in self._places if np.hypot(*(place - point)) < PLACE]
        self.left = min(left, default=self.poses)

    def spend(self, point: Floats) -> None:
        """Keep what is left at the place of a point (2,), where nothing was found."""
        self._places.append((point, self.left))


class Stretch(NamedTuple):
    """Stretch of a line that is to be replaced."""

    points: Floats
    """The whole line, (n, 2), m."""
    first: int
    last: int
    """Indices of its ends."""
    free: Booleans
    """Points at which any heading is allowed, (n,)."""


def chain_waypoints(
    space: ConfigurationSpace,
    stretch: Stretch,
    waypoints: Floats,
    limits: SearchLimits,
    budget: PoseBudget,
) -> HybridPath | None:
    """Path over a stretch of a line through the waypoints (p, 2) on it; None if none is found.

    Args:
        space: the configuration space.
        stretch: the stretch to be replaced.
        waypoints: points to pass, m; those elsewhere on the line are ignored.
        limits: of each search; their budget is replaced.
        budget: poses that may be expanded; reduced.
    """
    points, a, b, free = stretch
    start = np.array([*points[a], math.nan if free[a] else _heading(points, a)])
    end = np.array([*points[b], math.nan if free[b] else _heading(points, b)])
    between = [(p, at) for p in waypoints if a + 1 < (at := nearest_index(points, p)) < b - 1]
    if not between:
        return _chain(space, [start, end], limits, budget)
    # Try the line's own direction at each waypoint first, then any.
    for any_heading in (False, True):
        passed = [
            np.array([*waypoint, math.nan if any_heading else _heading(points, at)])
            for waypoint, at in between
        ]
        found = _chain(space, [start, *passed, end], limits, budget)
        if found is not None:
            return found
    return None


def _chain(
    space: ConfigurationSpace, stops: list[Floats], limits: SearchLimits, budget: PoseBudget
) -> HybridPath | None:
    """Path through poses in their order."""
    legs: list[HybridPath] = []
    for here, there in itertools.pairwise(stops):
        begin = here.copy()
        if legs:
            begin[2] = legs[-1].end_heading
        leg = _leg(space, begin, there, limits, budget)
        if leg is None:
            return None
        legs.append(leg)
    return _joined(legs)


def _leg(
    space: ConfigurationSpace,
    start: Floats,
    end: Floats,
    limits: SearchLimits,
    budget: PoseBudget,
) -> HybridPath | None:
    """Path between two poses; a heading of NaN is free."""
    free_start, free_end = math.isnan(start[2]), math.isnan(end[2])
    if free_start or not free_end:
        seeds = all_headings(start) if free_start else start[None]
        found = _searched(space, seeds, end, limits, budget)
        if found is not None or not free_end:
            return found
    # At a narrow end with a free heading, leaving it backwards is easier than reaching it.
    back = space._replace(
        footprint=reversed_footprint(space.footprint), grown=reversed_footprint(space.grown)
    )
    target = start + np.array([0.0, 0.0, math.pi])
    found = _searched(back, all_headings(end), target, limits, budget)
    if found is None:
        return None
    return HybridPath(
        points=found.points[::-1],
        pivots=(len(found.points) - 1 - found.pivots)[::-1],
        start_heading=found.end_heading + math.pi,
        end_heading=found.start_heading + math.pi,
    )


def _searched(
    space: ConfigurationSpace,
    seeds: Floats,
    goal: Floats,
    limits: SearchLimits,
    budget: PoseBudget,
) -> HybridPath | None:
    found, expansions = search_poses(space, seeds, goal, limits._replace(budget=budget.share()))
    budget.left -= expansions
    return found


def all_headings(pose: Floats) -> Floats:
    """Poses (64, 3) at one point with evenly spaced headings."""
    out = np.tile(pose, (64, 1))
    out[:, 2] = np.arange(64) * (2.0 * math.pi / 64)
    return out


def _joined(legs: list[HybridPath]) -> HybridPath:
    points, pivots = [legs[0].points[:1]], []
    count = 0
    for leg in legs:
        pivots.append(leg.pivots + count)
        points.append(leg.points[1:])
        count += len(leg.points) - 1
    return HybridPath(
        points=np.concatenate(points),
        pivots=np.unique(np.concatenate(pivots)),
        end_heading=legs[-1].end_heading,
        start_heading=legs[0].start_heading,
    )


def _heading(points: Floats, index: int) -> float:
    """Mean direction of a line at an inner point."""
    before, after = directions(points[index - 1 : index + 2])
    return float(before + 0.5 * turn_between(before, after))


def nearest_index(points: Floats, point: Floats) -> int:
    """Index of the point of a line that is nearest to a point."""
    return int(np.argmin(np.hypot(*(points - point).T)))
