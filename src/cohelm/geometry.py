"""Plane geometry on arrays: poses, angles, polylines, polygons.

A pose is (x, y, θ) in metres and radians. ``X_AB`` is the pose of frame B in frame A; frames cancel
in :func:`compose`: ``X_AC = compose(X_AB, X_BC)``. Frames: M map, R robot (drive axle centre,
x forward, y left), L sensor, G grid.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from cohelm.arrays import Booleans, Floats
from cohelm.kernels import CACHED


def wrap_angle(angle: Any) -> Any:
    """Wrap ``angle`` to (−π, π], elementwise."""
    if isinstance(angle, float):
        return -((-angle + math.pi) % (2.0 * math.pi) - math.pi)
    return -((-np.asarray(angle) + np.pi) % (2.0 * np.pi) - np.pi)


def compose(X_AB: ArrayLike, X_BC: ArrayLike) -> Floats:
    """Return X_AC; shapes (..., 3) and (..., 3) are broadcast, and the heading is wrapped."""
    a, b = np.asarray(X_AB, dtype=float), np.asarray(X_BC, dtype=float)
    if a.ndim == b.ndim == 1:
        x, y, heading = a.tolist()
        ahead, left, turn = b.tolist()
        cos, sin = float(np.cos(heading)), float(np.sin(heading))
        turned = -((-(heading + turn) + math.pi) % (2.0 * math.pi) - math.pi)
        return np.array([x + cos * ahead - sin * left, y + sin * ahead + cos * left, turned])
    xy = transform(a, b[..., :2])
    return np.concatenate([xy, wrap_angle(a[..., 2] + b[..., 2])[..., None]], axis=-1)


def inverse(X_AB: ArrayLike) -> Floats:
    """Return X_BA, shape (..., 3)."""
    a = np.asarray(X_AB, dtype=float)
    if a.ndim == 1:
        x, y, heading = a.tolist()
        cos, sin = float(np.cos(heading)), float(np.sin(heading))
        turned = -((heading + math.pi) % (2.0 * math.pi) - math.pi)
        return np.array([-cos * x - sin * y, sin * x - cos * y, turned])
    cos, sin = np.cos(a[..., 2]), np.sin(a[..., 2])
    x, y = a[..., 0], a[..., 1]
    return np.stack([-cos * x - sin * y, sin * x - cos * y, wrap_angle(-a[..., 2])], axis=-1)


def between(X_AB: ArrayLike, X_AC: ArrayLike) -> Floats:
    """Return X_BC of two poses (3,) in one frame: ``compose(inverse(X_AB), X_AC)``, but faster."""
    x, y, heading = np.asarray(X_AB, dtype=float).tolist()
    ahead, left, turn = np.asarray(X_AC, dtype=float).tolist()
    # Frame A in B, then C in it, with the rounding of the two functions.
    cos, sin = float(np.cos(heading)), float(np.sin(heading))
    x, y = -cos * x - sin * y, sin * x - cos * y
    heading = -((heading + math.pi) % (2.0 * math.pi) - math.pi)
    cos, sin = float(np.cos(heading)), float(np.sin(heading))
    turned = -((-(heading + turn) + math.pi) % (2.0 * math.pi) - math.pi)
    return np.array([x + cos * ahead - sin * left, y + sin * ahead + cos * left, turned])


def transform(X_AB: ArrayLike, p_B: ArrayLike) -> Floats:
    """Transform points (..., 2) from frame B to frame A."""
    a, p = np.asarray(X_AB, dtype=float), np.asarray(p_B, dtype=float)
    if a.ndim == 1:
        # Plain floats are faster than arrays of one element. Their cosine is NumPy's, as that of
        # many poses, so that both give the same bits.
        x, y, heading = a[:3].tolist()
        cos, sin = float(np.cos(heading)), float(np.sin(heading))
        if p.ndim == 1:
            ahead, left = p[:2].tolist()
            return np.array([x + cos * ahead - sin * left, y + sin * ahead + cos * left])
    else:
        x, y = a[..., 0], a[..., 1]
        cos, sin = np.cos(a[..., 2]), np.sin(a[..., 2])
    x = x + cos * p[..., 0] - sin * p[..., 1]
    # np.stack takes several times as long for a few points.
    out = np.empty((*x.shape, 2))
    out[..., 0] = x
    out[..., 1] = y + sin * p[..., 0] + cos * p[..., 1]
    return out


def arc_length(points: Floats) -> Floats:
    """Distance along a polyline (n, 2) at each of its points, (n,), starting at 0."""
    along = np.zeros(max(len(points), 1))
    if len(points) > 1:
        steps = points[1:] - points[:-1]
        np.add.accumulate(np.hypot(steps[:, 0], steps[:, 1]), out=along[1:])
    return along


def resample(points: Floats, spacing: float) -> Floats:
    """Resample a polyline (n, 2) to points (m, 2) about ``spacing`` apart, with both ends."""
    s = arc_length(points)
    count = max(math.ceil(s[-1] / spacing), 1) + 1
    at = np.linspace(0.0, s[-1], count)
    return np.stack([np.interp(at, s, points[:, 0]), np.interp(at, s, points[:, 1])], axis=-1)


@njit(**CACHED)
def nearest_on_polyline(points: Floats, x: float, y: float) -> tuple[float, float]:
    """Return the arc length of the nearest point of a polyline (n, 2), and its distance."""
    best, where, along = np.inf, 0.0, 0.0
    if points.shape[0] == 1:
        return 0.0, math.hypot(points[0, 0] - x, points[0, 1] - y)
    for i in range(points.shape[0] - 1):
        ax, ay = points[i, 0], points[i, 1]
        dx, dy = points[i + 1, 0] - ax, points[i + 1, 1] - ay
        length2 = dx * dx + dy * dy
        t = 0.0
        if length2 > 0.0:
            t = min(max(((x - ax) * dx + (y - ay) * dy) / length2, 0.0), 1.0)
        distance = math.hypot(ax + t * dx - x, ay + t * dy - y)
        length = math.sqrt(length2)
        if distance < best:
            best, where = distance, along + t * length
        along += length
    return where, best


@njit(**CACHED)
def distance_to_polygon(polygon: Floats, x: float, y: float) -> float:
    """Signed distance of a point to a simple polygon (n, 2): negative inside."""
    best, inside = np.inf, False
    n = polygon.shape[0]
    for i in range(n):
        j = i - 1 if i > 0 else n - 1
        ax, ay = polygon[j, 0], polygon[j, 1]
        bx, by = polygon[i, 0], polygon[i, 1]
        dx, dy = bx - ax, by - ay
        # Nearest point of the edge.
        length2 = dx * dx + dy * dy
        t = 0.0
        if length2 > 0.0:
            t = min(max(((x - ax) * dx + (y - ay) * dy) / length2, 0.0), 1.0)
        best = min(best, math.hypot(ax + t * dx - x, ay + t * dy - y))
        # Even-odd rule.
        if (ay > y) != (by > y) and x < (bx - ax) * (y - ay) / (by - ay) + ax:
            inside = not inside
    return -best if inside else best


@njit(**CACHED)
def inside_polygon(polygon: Floats, points: Floats) -> Booleans:
    """Mask (m,) of the points (m, 2) inside a simple polygon (n, 2)."""
    out = np.empty(points.shape[0], dtype=np.bool_)
    for i in range(points.shape[0]):
        out[i] = distance_to_polygon(polygon, points[i, 0], points[i, 1]) < 0.0
    return out
