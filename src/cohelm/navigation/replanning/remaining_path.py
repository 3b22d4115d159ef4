"""Remaining part of the path and of the wishes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.messages import Path, Wish


def remaining_path(path: Path, progress: float) -> Floats:
    """Points (k, 2) of the path from arc length ``progress`` on, m; at least two."""
    along = arc_length(path.points)
    here = _point_at(path.points, along, min(progress, float(along[-1])))
    ahead = path.points[along > progress]
    return np.concatenate([here[None], ahead if len(ahead) else path.points[-1:]])


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
