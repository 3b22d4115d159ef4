"""Inflation layer: costs that decay with the distance from obstacles, by Nav2's formula."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Bytes, Floats32
from cohelm.config import Model
from cohelm.kernels import CACHED
from cohelm.planning.costmap.patch import INSCRIBED, LETHAL, MAX_GRADED


class Inflation(Model):
    """Decay of costs; names as in nav2_costmap_2d's InflationLayer, values assumed."""

    inflation_radius: float = Field(1.0, gt=0.0, le=10.0)
    """Distance from an obstacle's surface beyond which the cost is 0, m. Where space allows, the
    chair then keeps the 0.7 m that its corners sweep in a turn."""
    cost_scaling_factor: float = Field(3.0, gt=0.0, le=100.0)
    """Decay rate k, 1/m; chosen with ``inflation_radius``."""

    def reach(self, radius: float) -> float:
        """Distance within which an obstacle changes costs, m."""
        return max(self.inflation_radius, radius)


def inflate(
    clearance: Floats32, radius: float, inflation: Inflation, *, out: Bytes | None = None
) -> Bytes:
    """Costs (rows, cols) of cells from their clearance (rows, cols), m; into ``out`` if given.

    254 inside an obstacle; 253 for d ≤ r; 252 exp(−k (d − r)) up to ``inflation_radius``; else 0.
    d is the distance to the obstacle's surface (half a cell less than Nav2's, which is measured to
    the cell's centre), r the ``radius`` that blocks, m.
    """
    k, reach = inflation.cost_scaling_factor, inflation.reach(radius)
    if out is None:
        out = np.empty(clearance.shape, dtype=np.uint8)
    _inflate(clearance, radius, k, reach, out)
    return out


@njit(**CACHED)
def _inflate(clearance: Floats32, radius: float, k: float, reach: float, out: Bytes) -> None:
    rows, cols = clearance.shape
    for r in range(rows):
        for c in range(cols):
            d = clearance[r, c]
            if d > reach:
                out[r, c] = 0
            elif d < 0.0:
                out[r, c] = LETHAL
            elif d <= radius:
                out[r, c] = INSCRIBED
            else:
                out[r, c] = np.uint8(MAX_GRADED * math.exp(-k * (d - radius)))
