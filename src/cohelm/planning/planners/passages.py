"""Explanation of a missing path: the tightest passage, or the rule that closes all paths."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from cohelm.arrays import Floats, Floats32, Integers
from cohelm.errors import NoPath, Passage
from cohelm.geometry import transform
from cohelm.planning.api import RouteProblem
from cohelm.planning.grid_search.shortest_path import shortest_path
from cohelm.planning.grid_search.weights import Weights
from cohelm.planning.problem import (
    CostmapParameters,
    PreparedProblem,
    as_pair,
    avoided_zones,
    prepare,
)

_NARROW = 100.0
"""Weight of a cell without clearance, and in proportion to the missing clearance elsewhere: a door
that is a tenth too narrow is worth a detour of ten times its depth."""


def no_path(
    prepared: PreparedProblem, parameters: CostmapParameters, stuck: Sequence[Floats] = ()
) -> NoPath:
    """Create the error that explains why no path was found.

    Args:
        prepared: the problem.
        parameters: of the planner.
        stuck: points (2,) where the footprint cannot follow a path that is wide enough for its
            inscribed circle, grid's frame, m, the best path first; empty if there is none. The
            first that is really too narrow is named.
    """
    problem = prepared.problem
    because, passage = "", None
    end = _end_at(prepared, stuck[0]) if stuck else None
    if end is not None:
        because = f"the walls around the {end}"
    elif stuck:
        bends = [_bend(prepared, each) for each in stuck]
        passage = next((each for each in bends if each.width < each.needed), bends[0])
    elif closed_by_zones(prepared, parameters):
        because = "the zones to avoid"
    elif closed_by_keepout(prepared, parameters):
        because = "the keepout zones"
    else:
        passage = tightest_passage(prepared)
    return NoPath(
        start=as_pair(problem.start),
        goal=as_pair(problem.goal),
        needed=prepared.costmap.radius,
        passage=passage,
        because=because,
    )


def closed_by_zones(prepared: PreparedProblem, parameters: CostmapParameters) -> bool:
    """Check that a path exists without the hard zones to avoid; searches once more."""
    problem = prepared.problem
    if not any(wish.hard for wish in avoided_zones(problem)):
        return False
    wishes = tuple(w for w in problem.wishes if not (w.kind == "avoid" and w.hard))
    return _is_connected(dataclasses.replace(problem, wishes=wishes), parameters)


def closed_by_keepout(prepared: PreparedProblem, parameters: CostmapParameters) -> bool:
    """Check that a path exists without the keepout masks; searches once more."""
    if not any(f.type == "keepout" for f in prepared.problem.filters):
        return False
    return _is_connected(dataclasses.replace(prepared.problem, filters=()), parameters)


def _is_connected(problem: RouteProblem, parameters: CostmapParameters) -> bool:
    """Check that a path leads from the problem's start to its goal."""
    prepared = prepare(problem, parameters)
    return shortest_path(prepared.weights, prepared.start, prepared.goal) is not None


def tightest_passage(prepared: PreparedProblem) -> Passage | None:
    """Tightest passage on the path that would be best if it were wide enough.

    Narrow cells cost more, in proportion to the missing clearance. None if walls leave no path at
    all, or the path is nowhere too narrow.
    """
    walls, radius = prepared.costmap.walls, prepared.costmap.radius
    missing = np.clip(1.0 - walls / max(radius, 1e-6), 0.0, 1.0)
    weights = (1.0 + _NARROW * missing).astype(np.float32)
    weights[walls <= 0.0] = np.inf
    found = shortest_path(Weights.of(weights), prepared.start, prepared.goal)
    if found is None:
        return None
    clearance = walls[found.cells[:, 0], found.cells[:, 1]]
    at = _pinch(clearance)
    if clearance[at] > radius:
        return None
    ahead = found.cells[min(at + 3, len(clearance) - 1)] - found.cells[max(at - 3, 0)]
    return _passage(prepared, found.cells[at], np.arctan2(*ahead.astype(float)), turns=False)


def _bend(prepared: PreparedProblem, stuck: Floats) -> Passage:
    """Passage that is wide enough, but where the robot cannot turn."""
    cell = np.floor(stuck[::-1] / prepared.problem.grid.resolution).astype(np.int64)
    return _passage(prepared, cell, None, turns=True)


def _end_at(prepared: PreparedProblem, stuck: Floats) -> str | None:
    """``start`` or ``goal`` if a point (2,) in the grid's frame is that end; else None."""
    point = transform(prepared.problem.grid.X_MG, stuck)
    for name, end in (("start", prepared.problem.start), ("goal", prepared.problem.goal)):
        if np.hypot(*(point - end)) < 1e-6:
            return name
    return None


def _passage(
    prepared: PreparedProblem, cell: Integers, along: float | None, *, turns: bool
) -> Passage:
    problem = prepared.problem
    res, robot = problem.grid.resolution, problem.robot
    middle, width = gap_at(prepared.costmap.walls, res, cell, along, 2.0 * prepared.costmap.radius)
    return Passage(
        point=as_pair(transform(problem.grid.X_MG, middle)),
        width=width,
        needed=2.0 * (robot.circumscribed_radius if turns else prepared.costmap.radius),
        resolution=res,
        turns=turns,
        clearance=0.0 if turns else problem.clearance,
    )


def gap_at(
    walls: Floats32, resolution: float, cell: Integers, along: float | None, reach: float
) -> tuple[Floats, float]:
    """(midpoint (2,), width) of the gap at a cell, between the surfaces on either side, m.

    The width is the minimum distance between a blocked cell on the left and one on the right, each
    within 45° of the perpendicular. If none is near, it is twice the clearance.

    Args:
        walls: distance to physical obstacles, (rows, cols), m; negative inside.
        resolution: of the grid, m.
        cell: (row, column) in the gap.
        along: direction of the path, rad; None: perpendicular to that of the nearest obstacle.
        reach: distance from the cell up to which obstacles are considered, m.
    """
    row, col = (int(i) for i in cell)
    size = math.ceil(reach / resolution)
    r0, c0 = max(row - size, 0), max(col - size, 0)
    window = walls[r0 : row + size + 1, c0 : col + size + 1]
    offset = np.argwhere((window < 0.0) & (window > -1.5 * resolution))
    offset += np.array([r0 - row, c0 - col])
    here = (np.array([col, row]) + 0.5) * resolution
    alone = here, 2.0 * float(walls[row, col])
    if not len(offset):
        return alone
    if along is None:
        nearest = offset[np.argmin((offset**2).sum(axis=1))]
        along = math.atan2(nearest[0], nearest[1]) + 0.5 * math.pi
    tangent = np.array([math.sin(along), math.cos(along)])
    ahead = offset @ tangent
    aside = offset @ np.array([tangent[1], -tangent[0]])
    left = offset[(aside > 0.0) & (np.abs(ahead) <= aside)]
    right = offset[(aside < 0.0) & (np.abs(ahead) <= -aside)]
    if not (len(left) and len(right)):
        return alone
    apart = left[:, None, :] - right[None, :, :]
    gaps = np.hypot(*np.moveaxis(np.maximum(np.abs(apart) - 1.0, 0.0), -1, 0))
    a, b = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
    middle = here + 0.5 * (left[a] + right[b])[::-1] * resolution
    return middle, float(gaps[a, b]) * resolution


def _pinch(clearance: Floats32) -> int:
    """Index in the middle of the longest run of cells with the lowest clearance."""
    least = np.flatnonzero(clearance <= clearance.min() + 1e-6)
    runs = np.split(least, np.flatnonzero(np.diff(least) > 1) + 1)
    longest = max(runs, key=len)
    return int(longest[len(longest) // 2])
