"""Legs of the path between changes of gear, and the remaining part of path and wishes."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.geometry import arc_length, inverse, nearest_on_polyline, transform
from cohelm.messages import Path, Wish

_LOOKAHEAD = 0.5
"""Distance ahead on the path at which its direction is taken, m."""

_AT_CUSP, _SLOW = 0.1, 0.05
"""Remaining length, m, and speed, m/s, below which a chair at the end of a leg changes its gear."""


class Leg(NamedTuple):
    """Stretch of a path that is driven in one gear."""

    path: Path
    """The stretch; the whole path if it has no cusps."""
    begin: float
    """Arc length of its beginning on the whole path, m."""
    backward: bool
    is_last: bool


@lru_cache(maxsize=16)
def leg_of(path: Path, index: int) -> Leg:
    """Leg of a path between two changes of gear."""
    backward = path.backs_out ^ (index % 2 == 1)
    if not len(path.cusps):
        return Leg(path, 0.0, backward, is_last=True)
    ends = [0, *path.cusps.tolist(), len(path.points) - 1]
    first, last = ends[index], ends[index + 1]
    points = np.ascontiguousarray(path.points[first : last + 1])
    inside = (path.pivots >= first) & (path.pivots <= last)
    stretch = replace(
        path,
        points=points,
        length=float(arc_length(points)[-1]),
        pivots=path.pivots[inside] - first,
        cusps=path.cusps[:0],
        backs_out=backward,
    )
    begin = float(arc_length(path.points)[first])
    return Leg(stretch, begin, backward, is_last=index == len(path.cusps))


def next_leg(path: Path, index: int, progress: float, twist: Floats) -> int:
    """Index of the leg to follow from now on: the next one for a chair that stands at its end.

    Args:
        path: the whole path.
        index: of the present leg.
        progress: arc length of the chair on the whole path, m.
        twist: of the chair (3,).
    """
    leg = leg_of(path, index)
    left = leg.begin + leg.path.length - progress
    at_end = left <= _AT_CUSP and float(np.hypot(*twist[:2])) <= _SLOW
    return index + 1 if at_end and not leg.is_last else index


def remaining_path(path: Path, progress: float) -> Floats:
    """Points (k, 2) of the path from arc length ``progress`` on, m; at least two."""
    along = arc_length(path.points)
    here = _point_at(path.points, along, min(progress, float(along[-1])))
    ahead = path.points[along > progress]
    return np.concatenate([here[None], ahead if len(ahead) else path.points[-1:]])


def turn_to_path(pose: Floats, path: Path, progress: float, goal: Floats) -> float:
    """Angle from the heading to a point ahead on the path, or to the goal if it is nearer, rad.

    Args:
        pose: X_MR, (3,).
        path: to the goal.
        progress: arc length of the chair's projection on it, m.
        goal: (2,), m.
    """
    along = arc_length(path.points)
    s = progress + _LOOKAHEAD
    ahead = goal
    if s < along[-1]:
        ahead = np.array([np.interp(s, along, path.points[:, i]) for i in (0, 1)])
    x, y = transform(inverse(pose), ahead)
    return math.atan2(y, x)


def remaining_wishes(wishes: tuple[Wish, ...], path: Path, progress: float) -> tuple[Wish, ...]:
    """Remove what the chair has passed on ``path``; unchanged wishes stay the same objects.

    Points of one wish are passed in their order, each where the path comes nearest to it. A stroke
    keeps the point passed last, because the segment that begins there is still ahead; it is removed
    once its end is passed. Zones to avoid are never passed.
    """
    left = [_remaining(wish, path, progress) for wish in wishes]
    return tuple(wish for wish in left if wish is not None)


def trim_strokes(wishes: tuple[Wish, ...], path: Path, progress: float) -> tuple[Wish, ...]:
    """Let each stroke in progress begin beside the chair, for planning from there."""
    along = arc_length(path.points)
    here = _point_at(path.points, along, min(progress, float(along[-1])))
    return tuple(_trimmed(wish, path, progress, here) for wish in wishes)


def _remaining(wish: Wish, path: Path, progress: float) -> Wish | None:
    if wish.kind == "avoid":
        return wish
    passed = 0
    while passed < len(wish.points) and _is_passed(wish.points[passed], path, progress):
        passed += 1
    if passed == len(wish.points):
        return None
    first = max(passed - 1, 0) if wish.kind == "stroke" else passed
    return wish if first == 0 else replace(wish, points=wish.points[first:])


def _trimmed(wish: Wish, path: Path, progress: float, here: Floats) -> Wish:
    if wish.kind != "stroke" or not _is_passed(wish.points[0], path, progress):
        return wish
    a, b = wish.points[:2] if len(wish.points) > 1 else wish.points[[0, 0]]
    length2 = float((b - a) @ (b - a))
    share = min(max(float((here - a) @ (b - a)) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
    return replace(wish, points=np.concatenate([(a + share * (b - a))[None], wish.points[1:]]))


def _is_passed(point: Floats, path: Path, progress: float) -> bool:
    along, _ = nearest_on_polyline(path.points, float(point[0]), float(point[1]))
    return bool(along <= progress)


def _point_at(points: Floats, along: Floats, s: float) -> Floats:
    return np.array([np.interp(s, along, points[:, i]) for i in (0, 1)])
