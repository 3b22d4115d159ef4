"""Crowding layer: where people have been standing or walking lately, it is dearer to go."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Bytes, Floats, Floats32
from cohelm.config import Model
from cohelm.geometry import compose, inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import Crowding
from cohelm.planning.cost_values import MAX_GRADED
from cohelm.planning.layers.patch import Patch, window_about


class CrowdingCosts(Model):
    """What it costs to go where people are; assumed."""

    cost: float = Field(200.0, ge=0.0, le=MAX_GRADED)
    """Cost where it is as crowded as ``full`` and more, 0…252; in proportion below."""
    full: float = Field(0.5, gt=0.0, le=10.0)
    """Density from which on the cost grows no further, people per m²: above about 0.4 walkers can
    no longer choose their speed freely (Fruin's level of service C)."""


@lru_cache(maxsize=2)
def crowding_patches(
    crowding: Crowding, grid: OccupancyGrid, costs: CrowdingCosts
) -> tuple[Patch, ...]:
    """What the crowding says, a patch about each stretch of floor where it says anything.

    The density is taken as bilinear between the middles of its cells. What has faded until it costs
    less than 1 is gone. Kept for the last two, because a heat map stays as it is.

    Args:
        crowding: people per m² on a coarse grid of any pose.
        grid: the map.
        costs: what it costs.
    """
    cost = np.minimum(crowding.density / np.float32(costs.full), 1.0) * np.float32(costs.cost)
    felt = np.pad((cost >= 1.0).astype(np.uint8), 1)
    if not felt.any():
        return ()
    near = cv2.dilate(felt, np.ones((3, 3), dtype=np.uint8))  # as far as it is interpolated
    count, _, stats, _ = cv2.connectedComponentsWithStats(near)
    X_CG = compose(inverse(crowding.X_MG), grid.X_MG)
    patches = []
    for c0, r0, width, height in stats[1:count, :4]:  # a handful: stretches, not people
        c1, r1 = c0 + width, r0 + height
        corners = np.array([[c0, r0], [c1, r0], [c1, r1], [c0, r1]]) - 1  # less the padding
        outline = transform(crowding.X_MG, corners * crowding.resolution)
        window = window_about(outline, 0.0, grid)
        if window is not None:
            _, rows, cols = window
            box = (rows.start, rows.stop, cols.start, cols.stop)
            out = _interpolated(cost, crowding.resolution, X_CG, grid.resolution, box)
            patches.append(Patch(rows=rows, cols=cols, cost=out))
    return tuple(patches)


@njit(cache=True)
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
