"""Layers about people: usual crowding, and the gaps between members of standing groups."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Bytes, Floats, Floats32
from cohelm.config import Model
from cohelm.geometry import compose, inverse, transform
from cohelm.kernels import CACHED
from cohelm.maps import OccupancyGrid
from cohelm.messages import Crowding
from cohelm.planning.costmap.layers.zones import distances_to_area
from cohelm.planning.costmap.patch import MAX_GRADED, Patch, window_around


class CrowdingCosts(Model):
    """Costs of crowded floor; assumed."""

    cost: float = Field(200.0, ge=0.0, le=MAX_GRADED)
    """Cost at the density ``full`` and above, 0…252; in proportion below."""
    full: float = Field(0.5, gt=0.0, le=10.0)
    """Density above which the cost stays constant, people per m²: above about 0.4, pedestrians can
    no longer choose their speed freely (Fruin's level of service C)."""


class GroupCosts(Model):
    """Costs of crossing between the members of a group; assumed."""

    detour: float = Field(30.0, ge=0.0, le=1000.0)
    """Detour over free floor that costs as much as crossing between two members, m."""
    reach: float = Field(0.4, gt=0.0, le=2.0)
    """Half width of the strip about the line or outline between the members' centres, m: about a
    body, so that smoothing cannot pull the path across."""


@lru_cache(maxsize=2)
def crowding_patches(
    crowding: Crowding, grid: OccupancyGrid, costs: CrowdingCosts
) -> tuple[Patch, ...]:
    """Patches of the crowding layer, one for each connected crowded area.

    The density is interpolated bilinearly between its cell centres; costs below 1 are dropped. The
    last two results are cached, because a heat map does not change.

    Args:
        crowding: people per m² on a coarse grid of any pose.
        grid: the map.
        costs: cost parameters.
    """
    cost = np.minimum(crowding.density / np.float32(costs.full), 1.0) * np.float32(costs.cost)
    crowded = np.pad((cost >= 1.0).astype(np.uint8), 1)
    if not crowded.any():
        return ()
    near = cv2.dilate(crowded, np.ones((3, 3), dtype=np.uint8))  # the reach of the interpolation
    count, _, stats, _ = cv2.connectedComponentsWithStats(near)
    X_CG = compose(inverse(crowding.X_MG), grid.X_MG)
    patches = []
    for c0, r0, width, height in stats[1:count, :4]:  # few: areas, not people
        c1, r1 = c0 + width, r0 + height
        corners = np.array([[c0, r0], [c1, r0], [c1, r1], [c0, r1]]) - 1  # less the padding
        outline = transform(crowding.X_MG, corners * crowding.resolution)
        window = window_around(outline, 0.0, grid)
        if window is not None:
            _, rows, cols = window
            box = (rows.start, rows.stop, cols.start, cols.stop)
            out = _interpolated(cost, crowding.resolution, X_CG, grid.resolution, box)
            patches.append(Patch(rows=rows, cols=cols, cost=out))
    return tuple(patches)


def group_patch(outline: Floats, grid: OccupancyGrid, groups: GroupCosts) -> Patch | None:
    """Patch of one group; None if it does not touch the grid.

    The gap between members is not closed, but its cost is above Nav2's scale. A strip 2 · reach
    wide lies over the line between two members, so a weight of detour / (2 · reach) makes crossing
    it as expensive as the detour. It is crossed only if every other route is longer than that.

    Args:
        outline: (k, 2), the members or the outline about them, map frame, m.
        grid: the map.
        groups: cost parameters.
    """
    window = window_around(outline, groups.reach, grid) if len(outline) > 1 else None
    if window is None:
        return None
    local, rows, cols = window
    between = distances_to_area(local, grid.resolution, rows, cols) <= groups.reach
    weight = groups.detour / (2.0 * groups.reach)
    return Patch(
        rows=rows,
        cols=cols,
        cost=np.where(between, np.uint8(MAX_GRADED), np.uint8(0)),
        extra_cost=np.where(between, np.float32(weight), np.float32(0.0)),
    )


@njit(**CACHED)
def _interpolated(
    cost: Floats32, side: float, X_CG: Floats, resolution: float, box: tuple[int, int, int, int]
) -> Bytes:
    """Costs of a window (first row, end, first column, end), bilinear, 0 beyond the coarse grid."""
    r0, r1, c0, c1 = box
    out = np.zeros((r1 - r0, c1 - c0), dtype=np.uint8)
    cos, sin = np.cos(X_CG[2]), np.sin(X_CG[2])
    rows, cols = cost.shape
    for r in range(r0, r1):
        for c in range(c0, c1):
            # Centre of the cell in cells of the coarse grid, whose centres are whole numbers.
            x, y = (c + 0.5) * resolution, (r + 0.5) * resolution
            u = (X_CG[0] + cos * x - sin * y) / side - 0.5
            v = (X_CG[1] + sin * x + cos * y) / side - 0.5
            left, low = int(np.floor(u)), int(np.floor(v))
            total = 0.0
            for i in range(2):
                for j in range(2):
                    row, col = low + i, left + j
                    if 0 <= row < rows and 0 <= col < cols:
                        share_v = v - low if i else 1.0 - (v - low)
                        share_u = u - left if j else 1.0 - (u - left)
                        total += share_v * share_u * cost[row, col]
            out[r - r0, c - c0] = np.uint8(total)
    return out
