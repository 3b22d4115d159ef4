"""Zone layer: areas that the rider wants to avoid.

A zone is the set of points within ``Wish.radius`` of a point, of a segment of two points or of a
polygon of three and more. A soft zone has a cost, which decides the length of an acceptable detour.
A hard zone is an obstacle added by the rider: the chair's footprint stays out of it as of a wall,
so its centre keeps the inscribed radius, and costs decay beyond as they do near walls.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Bytes, Floats, Floats32
from cohelm.config import Model
from cohelm.geometry import distance_to_polygon, nearest_on_polyline
from cohelm.kernels import CACHED
from cohelm.maps import OccupancyGrid, signed_distance
from cohelm.messages import Wish
from cohelm.planning.costmap.layers.inflation import Inflation, inflate
from cohelm.planning.costmap.patch import MAX_GRADED, Patch, window_around


class ZoneCosts(Model):
    """Costs of a soft zone; assumed."""

    cost: float = Field(252.0, ge=1.0, le=MAX_GRADED)
    """Cost inside, 0…252: with the usual weights a metre inside counts as five."""
    margin: float = Field(0.5, gt=0.0, le=10.0)
    """Distance beyond the zone's edge over which the cost falls linearly to 0, m."""


@lru_cache(maxsize=16)
def zone_patch(
    wish: Wish, grid: OccupancyGrid, radius: float, inflation: Inflation, zones: ZoneCosts
) -> Patch | None:
    """Patch of one ``avoid`` wish, cached; None if it does not touch the grid.

    Args:
        wish: of kind ``avoid``.
        grid: the map.
        radius: a hard zone blocks up to this distance from its edge, m.
        inflation: decay of the costs beyond a hard zone.
        zones: costs of a soft zone.
    """
    reach = inflation.reach(radius) if wish.hard else zones.margin
    window = window_around(wish.points, wish.radius + reach, grid)
    if window is None:
        return None
    local, rows, cols = window
    if wish.hard:
        clearance = _clearance(local, wish.radius, grid.resolution, rows, cols, reach)
        cost = inflate(clearance, radius, inflation)
        return Patch(rows=rows, cols=cols, cost=cost, clearance=clearance)
    distance = distances_to_area(local, grid.resolution, rows, cols) - np.float32(wish.radius)
    return Patch(rows=rows, cols=cols, cost=_graded(distance, zones))


def distance_to_zone(wish: Wish, point: Floats) -> float:
    """Signed distance of a point (2,) of the map frame to an avoided zone, m; negative inside."""
    return float(_distance_to_area(wish.points, point[0], point[1])) - wish.radius


def distances_to_zone(wish: Wish, points: Floats) -> Floats:
    """Signed distances (n,) of map points (n, 2) to an avoided zone, m; negative inside."""
    return _distances(wish.points, points) - wish.radius


def distances_to_area(points: Floats, resolution: float, rows: slice, cols: slice) -> Floats32:
    """Signed distance, m, of a window's cell centres to a point, a segment or a polygon.

    Args:
        points: (k, 2) in the grid's frame, m: one, two, or the polygon's corners.
        resolution: of the grid, m.
        rows, cols: the window.

    Returns:
        (rows, cols); negative within a polygon.
    """
    return _distances_to_area(points, resolution, rows.start, rows.stop, cols.start, cols.stop)


def _clearance(
    local: Floats, radius: float, resolution: float, rows: slice, cols: slice, reach: float
) -> Floats32:
    """Clearance from the cells whose centre lies in a zone.

    A point or a segment covers at least the cells that it crosses. Parts off the grid count too.
    """
    pad = math.ceil(reach / resolution) + 1
    r0, c0 = rows.start - pad, cols.start - pad
    distance = distances_to_area(
        local, resolution, slice(r0, rows.stop + pad), slice(c0, cols.stop + pad)
    )
    thinnest = math.sqrt(0.5) * resolution if len(local) < 3 else 0.0
    clearance = signed_distance(distance <= max(radius, thinnest), resolution)
    return np.ascontiguousarray(clearance[pad:-pad, pad:-pad])


def _graded(distance: Floats32, zones: ZoneCosts) -> Bytes:
    share = np.clip(1.0 - distance / np.float32(zones.margin), 0.0, 1.0)
    cost: Bytes = np.rint(np.float32(zones.cost) * share).astype(np.uint8)
    return cost


@njit(**CACHED)
def _distances_to_area(
    points: Floats, resolution: float, r0: int, r1: int, c0: int, c1: int
) -> Floats32:
    out = np.empty((r1 - r0, c1 - c0), dtype=np.float32)
    for r in range(r0, r1):
        for c in range(c0, c1):
            x, y = (c + 0.5) * resolution, (r + 0.5) * resolution
            out[r - r0, c - c0] = _distance_to_area(points, x, y)
    return out


@njit(**CACHED)
def _distances(area: Floats, points: Floats) -> Floats:
    out = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        out[i] = _distance_to_area(area, points[i, 0], points[i, 1])
    return out


@njit(**CACHED)
def _distance_to_area(points: Floats, x: float, y: float) -> float:
    if points.shape[0] < 3:
        _, distance = nearest_on_polyline(points, x, y)
        return distance
    return distance_to_polygon(points, x, y)
