"""User preference field: a valley of cost about the points the rider wants to pass.

Xu et al., eqs. (1) and (2), Algorithm 1.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from cohelm.arrays import Bytes, Floats, Floats32
from cohelm.config import Model
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.planning.cost_values import MAX_GRADED

SPREAD = 1.0 / math.sqrt(-2.0 * math.log(0.1))
"""σ / d_r of eq. (1): a circle of radius d_r about the point holds 90 % of the density. ≈ 0.466."""


class Preference(Model):
    """The shape of the valley; the paper gives no figures, these are assumed."""

    density: Literal["gaussian", "rayleigh"] = "gaussian"
    """``gaussian``: the 2-D density that Algorithm 1 draws from, cheapest at the point.
    ``rayleigh``: eq. (2) as printed, the density of the radius, which is dearest at the point and
    cheapest on a ring at d = σ."""
    c_min: float = Field(0.0, ge=0.0, le=MAX_GRADED)
    """Cost where the density peaks, 0…252."""
    c_max: float = Field(126.0, ge=0.0, le=MAX_GRADED)
    """Cost where the density is least, 0…252; half the range, so that the inflation near walls
    still stands above it."""
    sigma_min: float = Field(0.5, gt=0.0, le=100.0)
    """Floor of σ, m: d_r → 0 would else divide by zero."""

    @model_validator(mode="after")
    def _costs_in_order(self) -> Preference:
        if self.c_min > self.c_max:
            raise ValueError("c_min must not be above c_max")
        return self


def preference_costs(
    grid: OccupancyGrid, points: Floats, spreads: Floats, preference: Preference
) -> Bytes:
    """Costs (rows, cols) of the field, 0…252.

    c = c_max − (p − p_min)(c_max − c_min) / (p_max − p_min)     Xu et al., eq. (2)
    p = exp(−d²/2σ²)  or  (d/σ²) exp(−d²/2σ²)

    with the extremes taken over the whole map. Each point's density is scaled to a peak of 1 on the
    map before they are added up, so that a far point counts as much as a near one.

    Args:
        grid: the map.
        points: (w, 2), map frame, m; anywhere.
        spreads: σ of each, (w,), m, > 0.
        preference: the shape.
    """
    total = np.zeros(grid.shape, dtype=np.float32)
    for point, sigma in zip(points, spreads, strict=True):
        density = _gaussian if preference.density == "gaussian" else _rayleigh
        total += density(grid, point, float(sigma))
    low, high = float(total.min()), float(total.max())
    depth = (preference.c_max - preference.c_min) / (high - low) if high > low else 0.0
    costs: Bytes = np.rint(preference.c_max - depth * (total - low)).astype(np.uint8)
    return costs


def spread(distance: Floats, preference: Preference) -> Floats:
    """σ = d_r / √(−2 ln 0.1), eq. (1), with its floor; same shape as the distances d_r, m."""
    return np.maximum(SPREAD * distance, preference.sigma_min)


def _gaussian(grid: OccupancyGrid, point: Floats, sigma: float) -> Floats32:
    """exp(−d²/2σ²) over its greatest value on the map; separable, hence an outer product."""
    y, x = (np.exp(_log_density(axis, sigma)) for axis in _offsets(grid, point))
    return np.outer(y.astype(np.float32), x.astype(np.float32))


def _rayleigh(grid: OccupancyGrid, point: Floats, sigma: float) -> Floats32:
    """(d/σ²) exp(−d²/2σ²) over its greatest value on the map."""
    dy, dx = _offsets(grid, point)
    radius = np.hypot(dy[:, None], dx[None, :])
    log = np.log(np.maximum(radius, 1e-9)) - 0.5 * np.square(radius / sigma)
    density: Floats32 = np.exp(log - log.max()).astype(np.float32)
    return density


def _log_density(offset: Floats, sigma: float) -> Floats:
    log = -0.5 * np.square(offset / sigma)
    relative: Floats = log - log.max()  # far off the map every density would else be 0
    return relative


def _offsets(grid: OccupancyGrid, point: Floats) -> tuple[Floats, Floats]:
    """Offsets (rows,) and (cols,) of cell centres from a point, along the grid's axes, m."""
    x, y = transform(inverse(grid.X_MG), point)
    rows, cols = grid.shape
    return (
        (np.arange(rows) + 0.5) * grid.resolution - y,
        (np.arange(cols) + 0.5) * grid.resolution - x,
    )
