"""Exact distance to the nearest obstacle, as a field that can be sampled with its gradient."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Shape, value
from cohelm.maps.grid import OccupancyGrid


@value
class DistanceField:
    """Signed distance to the obstacles' surface at cell centres: negative inside them.

    Distances are exact between cell centres; half a cell is taken off, because an obstacle reaches
    to its cell's edge. Past a wall that is exact; past a corner, seen along the diagonal, it is up
    to 0.21 cell too much. Beyond the field's border the nearest cell's value holds.
    """

    distance: Annotated[Floats32, Shape("rows cols")]
    """m; capped at the field's diagonal where there is no obstacle at all."""
    resolution: float
    """m."""
    X_MG: Annotated[Floats, Shape("3")]
    """Pose of the field's lower left corner in the map frame."""

    def at(self, points: Floats) -> Floats:
        """Signed distance (...,) at map points (..., 2), interpolated, m."""
        p = np.asarray(points, dtype=float)
        return self.with_gradient(p)[..., 0]

    def with_gradient(self, points: Floats) -> Floats:
        """(distance, ∂/∂x, ∂/∂y) at map points (..., 2), as (..., 3)."""
        p = np.asarray(points, dtype=float)
        out = _sample_many(self.distance, self.resolution, self.X_MG, p.reshape(-1, 2))
        return out.reshape(*p.shape[:-1], 3)


def distance_field(grid: OccupancyGrid) -> DistanceField:
    """The distance field of a grid's blocked cells (occupied or unknown)."""
    return DistanceField(
        distance=signed_distance(grid.blocked(), grid.resolution),
        resolution=grid.resolution,
        X_MG=grid.X_MG,
    )


def signed_distance(blocked: Booleans, resolution: float) -> Floats32:
    """Signed distance (rows, cols), m, from cells to the surface of the ``blocked`` ones."""
    outside = _distance_to(blocked)
    inside = _distance_to(~blocked)
    signed = np.where(blocked, 0.5 - inside, outside - 0.5) * np.float32(resolution)
    return signed.astype(np.float32)


def _distance_to(target: Booleans) -> Floats32:
    """Exact distance (rows, cols), in cells, from each cell to the nearest target cell."""
    cap = math.hypot(*target.shape)
    if not target.any():
        return np.full(target.shape, cap, dtype=np.float32)
    image = np.where(target, 0, 255).astype(np.uint8)
    distance = cv2.distanceTransform(image, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.minimum(distance, np.float32(cap))


@njit(cache=True)
def sample(
    distance: Floats32, resolution: float, X_MG: Floats, x: float, y: float
) -> tuple[float, float, float]:
    """(distance, ∂/∂x, ∂/∂y) at a map point, bilinear between cell centres."""
    cos, sin = math.cos(X_MG[2]), math.sin(X_MG[2])
    dx, dy = x - X_MG[0], y - X_MG[1]
    rows, cols = distance.shape
    c = (cos * dx + sin * dy) / resolution - 0.5
    r = (-sin * dx + cos * dy) / resolution - 0.5
    c = min(max(c, 0.0), cols - 1.0)
    r = min(max(r, 0.0), rows - 1.0)
    c0, r0 = min(int(c), max(cols - 2, 0)), min(int(r), max(rows - 2, 0))
    c1, r1 = min(c0 + 1, cols - 1), min(r0 + 1, rows - 1)
    u, v = c - c0, r - r0
    d00, d01 = distance[r0, c0], distance[r0, c1]
    d10, d11 = distance[r1, c0], distance[r1, c1]
    value_ = (d00 * (1 - u) + d01 * u) * (1 - v) + (d10 * (1 - u) + d11 * u) * v
    gc = ((d01 - d00) * (1 - v) + (d11 - d10) * v) / resolution
    gr = ((d10 - d00) * (1 - u) + (d11 - d01) * u) / resolution
    return value_, cos * gc - sin * gr, sin * gc + cos * gr


@njit(cache=True)
def _sample_many(distance: Floats32, resolution: float, X_MG: Floats, points: Floats) -> Floats:
    out = np.empty((points.shape[0], 3))
    for i in range(points.shape[0]):
        d, gx, gy = sample(distance, resolution, X_MG, points[i, 0], points[i, 1])
        out[i, 0], out[i, 1], out[i, 2] = d, gx, gy
    return out
