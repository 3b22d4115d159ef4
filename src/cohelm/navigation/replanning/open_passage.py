"""Passages of a path: blocked, or open a little beside it.

When a path is planned round an obstacle, only one side of it may have been seen. Once the next side
is seen, the obstacle may be some centimetres larger, and the path too close to it. The path round
its other side can then be the cheaper one. A chair that is close to the obstacle and has no space
to turn cannot follow that path. So a path whose passage is open is replaced by paths through the
same passage only.
"""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.geometry import arc_length, resample
from cohelm.messages import Path
from cohelm.navigation.replanning.path_switching import distances_to
from cohelm.navigation.replanning.remaining_path import remaining_path
from cohelm.navigation.replanning.route_query import RouteQuery

_ASIDE = np.linspace(-0.25, 0.25, 11)
"""Displacements of a path at which the local planner may pass beside it, m; assumed."""
_SAME_PASSAGE = 0.5
"""Distance up to which a new path leads through the same passage, m: two passages beside one
obstacle are apart by the chair's width at least; assumed."""
_SPACING = 0.1
"""Spacing of points of paths that are checked, m."""


def is_blocked(path: Path, progress: float, query: RouteQuery, lookahead: float) -> bool:
    """Check for a passage ahead on the path that is narrower than the chair.

    Args:
        path: followed now.
        progress: arc length of the chair on it, m.
        query: pose, walls and robot.
        lookahead: distance ahead of the chair over which the path is checked, m.
    """
    near = _ahead(path, progress, query, lookahead)
    return bool((query.walls.at(near) < query.robot.inscribed_radius).any())


def leaves_open_passage(
    path: Path, current: Path, progress: float, query: RouteQuery, lookahead: float
) -> bool:
    """Check that a new path takes another passage while the current one is open.

    False for a chair that has left its path: the new one then begins elsewhere in any case.

    Args:
        path: the new one.
        current: path followed now.
        progress: arc length of the chair on it, m.
        query: pose, walls and robot.
        lookahead: distance ahead of the chair over which both are checked, m.
    """
    kept = remaining_path(current, progress)
    if distances_to(query.pose[None, :2], kept)[0] > _SAME_PASSAGE:
        return False
    near = path.points[np.hypot(*(path.points - query.pose[:2]).T) < lookahead]
    leaves = bool((distances_to(near, kept) > _SAME_PASSAGE).any())
    return leaves and _is_open(current, progress, query, lookahead)


def _is_open(path: Path, progress: float, query: RouteQuery, lookahead: float) -> bool:
    """Check that the chair fits along the path, or along a line close beside it."""
    near = _ahead(path, progress, query, lookahead)
    if len(near) < 2:
        return False
    near = resample(near, _SPACING)
    tangent = np.gradient(near, axis=0)
    tangent /= np.maximum(np.hypot(*tangent.T), 1e-9)[:, None]
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    beside = near[:, None] + _ASIDE[:, None] * normal[:, None]
    free: Booleans = query.walls.at(beside) >= query.robot.inscribed_radius
    reached = free[0]
    for here in free[1:]:  # from point to point by one displacement more or less
        reached = here & (np.convolve(reached, np.ones(3), mode="same") > 0.0)
    return bool(reached.any())


def _ahead(path: Path, progress: float, query: RouteQuery, lookahead: float) -> Floats:
    """Points (k, 2) of the path within the lookahead, m."""
    along = arc_length(path.points)
    ahead = path.points[(along >= progress) & (along <= progress + lookahead)]
    near: Floats = ahead[np.hypot(*(ahead - query.pose[:2]).T) < lookahead]
    return near
