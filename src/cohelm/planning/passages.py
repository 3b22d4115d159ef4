"""Why no way leads there: the tightest passage on the way that would be best if it were wider."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats, Floats32, Integers
from cohelm.errors import NoPath, Passage
from cohelm.geometry import transform
from cohelm.planning.ground import (
    Ground,
    GroundParameters,
    closed_by_keepout,
    closed_by_zones,
    pair,
)
from cohelm.planning.search import Weights, shortest_path

_NARROW = 100.0
"""Weight of a cell that has no clearance at all, and what is missing elsewhere in proportion: a
door that lacks a tenth of its width is worth a detour of ten times its depth."""


def no_path(ground: Ground, parameters: GroundParameters, stuck: Floats | None = None) -> NoPath:
    """The error that says why no way was found.

    Args:
        ground: of the problem.
        parameters: of the planner.
        stuck: where (2,) the footprint cannot follow a way that is wide enough for its inscribed
            circle, grid's frame, m; None where there is no such way.
    """
    problem = ground.problem
    because, passage = "", None
    end = None if stuck is None else _end_at(ground, stuck)
    if end is not None:
        because = f"the walls about the {end}"
    elif stuck is not None:
        passage = _bend(ground, stuck)
    elif closed_by_zones(ground, parameters):
        because = "the zones to avoid"
    elif closed_by_keepout(ground, parameters):
        because = "the keepout zones"
    else:
        passage = tightest_passage(ground)
    return NoPath(
        start=pair(problem.start),
        goal=pair(problem.goal),
        needed=ground.costmap.radius,
        passage=passage,
        because=because,
    )


def tightest_passage(ground: Ground) -> Passage | None:
    """The tightest place on the way that would be best if it were wide enough.

    Narrow places are passed at a price that grows with what is missing. None where walls leave no
    way at all, or the way is nowhere too narrow.
    """
    walls, radius = ground.costmap.walls, ground.costmap.radius
    missing = np.clip(1.0 - walls / max(radius, 1e-6), 0.0, 1.0)
    weights = (1.0 + _NARROW * missing).astype(np.float32)
    weights[walls <= 0.0] = np.inf
    found = shortest_path(Weights.of(weights), ground.start, ground.goal)
    if found is None:
        return None
    room = walls[found.cells[:, 0], found.cells[:, 1]]
    at = _pinch(room)
    if room[at] > radius:
        return None
    ahead = found.cells[min(at + 3, len(room) - 1)] - found.cells[max(at - 3, 0)]
    return _passage(ground, found.cells[at], np.arctan2(*ahead.astype(float)), turns=False)


def _bend(ground: Ground, stuck: Floats) -> Passage:
    """The place where the robot, though narrow enough, cannot turn."""
    cell = np.floor(stuck[::-1] / ground.problem.grid.resolution).astype(np.int64)
    return _passage(ground, cell, None, turns=True)


def _end_at(ground: Ground, stuck: Floats) -> str | None:
    """Which end of the way a point (2,) in the grid's frame is; None: neither."""
    point = transform(ground.problem.grid.X_MG, stuck)
    for name, end in (("start", ground.problem.start), ("goal", ground.problem.goal)):
        if np.hypot(*(point - end)) < 1e-6:
            return name
    return None


def _passage(ground: Ground, cell: Integers, along: float | None, *, turns: bool) -> Passage:
    problem = ground.problem
    res, robot = problem.grid.resolution, problem.robot
    middle, width = gap_at(ground.costmap.walls, res, cell, along, 2.0 * ground.costmap.radius)
    return Passage(
        point=pair(transform(problem.grid.X_MG, middle)),
        width=width,
        needed=2.0 * (robot.circumscribed_radius if turns else ground.costmap.radius),
        resolution=res,
        turns=turns,
        clearance=0.0 if turns else problem.clearance,
    )


def gap_at(
    walls: Floats32, resolution: float, cell: Integers, along: float | None, reach: float
) -> tuple[Floats, float]:
    """(middle (2,), width) of the gap about a cell, between the surfaces on either side, m.

    The least distance between a blocked cell on the left and one on the right, each within 45° of
    abeam. Where none is near, twice the clearance.

    Args:
        walls: distance to what bodily stands there, (rows, cols), m; negative inside.
        resolution: of the grid, m.
        cell: (row, column) in the gap.
        along: direction of the way through it, rad; None: across the nearest obstacle's.
        reach: how far from the cell obstacles are looked for, m.
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


def _pinch(room: Floats32) -> int:
    """The middle of the longest run of cells with the least clearance."""
    least = np.flatnonzero(room <= room.min() + 1e-6)
    runs = np.split(least, np.flatnonzero(np.diff(least) > 1) + 1)
    longest = max(runs, key=len)
    return int(longest[len(longest) // 2])
