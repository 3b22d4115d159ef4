"""Exact distance to the nearest obstacle, as a field that can be sampled with its gradient."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.array_kernels import ZERO
from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Integers, Shape, value
from cohelm.kernels import CACHED, callee
from cohelm.maps.grid import OccupancyGrid

_FAR = np.float32(1 << 20)
"""Cells; farther than any map is wide, and its square is exact."""
_STEP = np.float32(1.0)


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
        return self.with_gradient(points)[..., 0]

    def with_gradient(self, points: Floats) -> Floats:
        """(distance, ∂/∂x, ∂/∂y) at map points (..., 2), as (..., 3)."""
        p = np.array(points, dtype=float, order="C")  # a copy: one type of array for the kernel
        out = _sample_many(self.distance, self.resolution, self.X_MG, p.reshape(-1, 2))
        return out.reshape(*p.shape[:-1], 3)


def distance_field(grid: OccupancyGrid) -> DistanceField:
    """The distance field of a grid's blocked cells (occupied or unknown)."""
    return DistanceField(
        distance=signed_distance(grid.blocked(), grid.resolution),
        resolution=grid.resolution,
        X_MG=grid.X_MG,
    )


def signed_distance(
    blocked: Booleans, resolution: float, *, out: Floats32 | None = None
) -> Floats32:
    """Signed distance (rows, cols), m, from cells to the surface of the ``blocked`` ones.

    Exact between cell centres, in time proportional to the cells: distances down and up the columns
    first, then along each row the lower envelope of the parabolas that they raise
    (Felzenszwalb and Huttenlocher, Distance transforms of sampled functions, 2012). The nearest
    cell of the other kind never lies beyond the end of a run of one kind, so one envelope per run
    gives the distances inside and outside at once.

    Args:
        blocked: (rows, cols).
        resolution: side of a cell, m.
        out: array for the result, (rows, cols); None: a new array.
    """
    if out is None:
        out = np.empty(blocked.shape, dtype=np.float32)
    if blocked.size:
        _signed_distance(np.ascontiguousarray(blocked), resolution, out)
    return out


@njit(**CACHED)
def _signed_distance(blocked: Booleans, resolution: float, out: Floats32) -> None:
    rows, cols = blocked.shape
    _distance_upward(blocked, out)
    downward = np.full(cols, _FAR, dtype=np.float32)
    height = np.empty(cols)  # squared distance along the column
    squared = np.empty(cols)
    at, bound = np.empty(cols + 1, dtype=np.int64), np.empty(cols + 2)
    halves = 0.5 / np.maximum(np.arange(cols + 1), 1)  # a product is faster than a quotient
    cap, half, side = np.float32(math.hypot(rows, cols)), np.float32(0.5), np.float32(resolution)
    for r in range(rows - 1, -1, -1):
        if r < rows - 1:
            for c in range(cols):
                same = blocked[r, c] == blocked[r + 1, c]
                downward[c] = downward[c] + _STEP if same else _STEP
        for c in range(cols):
            height[c] = np.float64(min(downward[c], out[r, c])) ** 2
        a = ZERO
        while a < cols:
            b = a + 1
            while b < cols and blocked[r, b] == blocked[r, a]:
                b += 1
            _along_run(height, a, b, at, bound, halves, squared)
            a = b
        for c in range(cols):
            d = min(np.float32(math.sqrt(np.float32(squared[c]))), cap)
            out[r, c] = ((half - d) if blocked[r, c] else (d - half)) * side


@callee()
def _distance_upward(blocked: Booleans, out: Floats32) -> None:
    """Cells from each cell up its column to the first one of the other kind."""
    rows, cols = blocked.shape
    out[0] = _FAR
    for r in range(1, rows):
        for c in range(cols):
            out[r, c] = out[r - 1, c] + _STEP if blocked[r, c] == blocked[r - 1, c] else _STEP


@callee()
def _along_run(
    height: Floats, a: int, b: int, at: Integers, bound: Floats, halves: Floats, squared: Floats
) -> None:
    """``squared`` of the cells a ≤ x < b of one kind: the least (x − q)² + height over q.

    The cells just before and after are of the other kind, so they have no height.

    Args:
        height: squared distance along the columns, (cols,).
        a, b: the run.
        at, bound: working space: the parabolas of the envelope and their beginnings.
        halves: 1 / 2n of each n, (cols + 1,).
        squared: (cols,), filled.
    """
    k, q = 0, max(a - 1, 0)
    at[0], bound[0] = q, -np.inf
    raised = (0.0 if q < a else height[q]) + q * q
    for new in range(q + 1, min(b + 1, height.shape[0])):
        rising = (0.0 if new == b else height[new]) + np.float64(new) * new
        meet = (rising - raised) * halves[new - q]
        while meet <= bound[k]:
            k -= 1
            q = at[k]
            raised = (0.0 if q < a else height[q]) + np.float64(q) * q
            meet = (rising - raised) * halves[new - q]
        k += 1
        at[k], bound[k], q, raised = new, meet, new, rising
    bound[k + 1] = np.inf
    k = 0
    for x in range(a, b):
        while bound[k + 1] < x:
            k += 1
        q = at[k]
        squared[x] = np.float64(x - q) ** 2 + (height[q] if a <= q < b else 0.0)


@njit(**CACHED)
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


@njit(**CACHED)
def _sample_many(distance: Floats32, resolution: float, X_MG: Floats, points: Floats) -> Floats:
    out = np.empty((points.shape[0], 3))
    for i in range(points.shape[0]):
        d, gx, gy = sample(distance, resolution, X_MG, points[i, 0], points[i, 1])
        out[i, 0], out[i, 1], out[i, 2] = d, gx, gy
    return out
