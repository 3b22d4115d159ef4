"""User preference field: low costs about the points that the rider wants to pass.

Xu et al., eqs. (1) and (2), Algorithm 1. A drawn stroke, which the paper does not have, is a line
of such points.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numba import njit
from pydantic import Field, model_validator

from cohelm.arrays import Annotated, Bytes, Floats, Floats32, Shape, value
from cohelm.config import Model
from cohelm.geometry import arc_length, inverse, nearest_on_polyline, resample, transform
from cohelm.kernels import CACHED
from cohelm.maps import OccupancyGrid
from cohelm.messages import Wish
from cohelm.planning.costmap.patch import MAX_GRADED

SPREAD = 1.0 / math.sqrt(-2.0 * math.log(0.1))
"""σ / d_r of eq. (1): a circle of radius d_r about the point holds 90 % of the density. ≈ 0.466."""

_MAX_POINTS = 256  # of a stroke


class Preference(Model):
    """Shape of the field; assumed, because the paper gives no values."""

    density: Literal["gaussian", "rayleigh"] = "gaussian"
    """``gaussian``: the 2-D density of Algorithm 1, with the lowest cost at the point.
    ``rayleigh``: eq. (2) as printed, the density of the radius, with the highest cost at the point
    and the lowest on a circle at d = σ."""
    c_min: float = Field(0.0, ge=0.0, le=MAX_GRADED)
    """Cost at the highest density, 0…252."""
    c_max: float = Field(126.0, ge=0.0, le=MAX_GRADED)
    """Cost at the lowest density, 0…252; half the range, so that the inflation near walls remains
    above it."""
    sigma_min: float = Field(0.5, gt=0.0, le=100.0)
    """Lower bound of σ, m; d_r → 0 would divide by zero."""

    @model_validator(mode="after")
    def _costs_in_order(self) -> Preference:
        if self.c_min > self.c_max:
            raise ValueError("c_min must not be above c_max")
        return self


@value
class Source:
    """Points with one common density."""

    points: Annotated[Floats, Shape("k 2")]
    """Map frame, m; may lie off the map. Several points: a line of them, about evenly spaced."""
    sigma: float
    """σ of eq. (1), m, > 0."""


def sources_of(
    wishes: tuple[Wish, ...], origin: Floats, preference: Preference
) -> tuple[Source, ...]:
    """Create a source for each attracting point and each stroke.

    Args:
        wishes: of any kind.
        origin: position of the robot when they were set, (2,), m: d_r of eq. (1) is the distance
            from there to the point, or to the nearest point of the stroke.
        preference: contains the lower bound of σ.
    """
    out: list[Source] = []
    for wish in wishes:
        if wish.kind == "attract":
            sigmas = spread(np.hypot(*(wish.points - origin).T), preference)
            out.extend(
                Source(points=point[None], sigma=float(sigma))
                for point, sigma in zip(wish.points, sigmas, strict=True)
            )
        elif wish.kind == "stroke" and len(wish.points):
            _, distance = nearest_on_polyline(wish.points, float(origin[0]), float(origin[1]))
            sigma = float(spread(np.array(distance), preference))
            step = max(sigma, float(arc_length(wish.points)[-1]) / _MAX_POINTS)
            out.append(Source(points=resample(wish.points, step), sigma=sigma))
    return tuple(out)


def preference_costs(
    grid: OccupancyGrid, sources: tuple[Source, ...], preference: Preference
) -> Bytes:
    """Costs (rows, cols) of the field, 0…252.

    c = c_max − (p − p_min)(c_max − c_min) / (p_max − p_min)     Xu et al., eq. (2)
    p = exp(−d²/2σ²)  or  (d/σ²) exp(−d²/2σ²)

    with the extremes taken over the whole map. Each source's density is scaled to a maximum of 1 on
    the map before the sum, so that a far point counts as much as a near one.
    """
    field = preference_field(grid, sources, preference)
    low, high = float(field.min()), float(field.max())
    depth = (preference.c_max - preference.c_min) / (high - low) if high > low else 0.0
    return _costs(field, low, depth, preference.c_max)


def preference_field(
    grid: OccupancyGrid, sources: tuple[Source, ...], preference: Preference
) -> Floats32:
    """Sum of the sources' densities (rows, cols), each scaled to a maximum of 1 on the map."""
    total = np.zeros(grid.shape, dtype=np.float32)
    density = _gaussian if preference.density == "gaussian" else _rayleigh
    for source in sources:
        field = density(grid, source)
        if len(source.points) > 1:
            field /= field.max()
        total += field
    return total


def spread(distance: Floats, preference: Preference) -> Floats:
    """σ = d_r / √(−2 ln 0.1), eq. (1), with its lower bound; same shape as the distances d_r, m."""
    return np.maximum(SPREAD * distance, preference.sigma_min)


def _gaussian(grid: OccupancyGrid, source: Source) -> Floats32:
    """Σ exp(−d²/2σ²), scaled to a largest term of 1 on the map; separable, so a matrix product."""
    dy, dx = _offsets(grid, source.points)
    y, x = -0.5 * np.square(dy / source.sigma), -0.5 * np.square(dx / source.sigma)
    peak_y, peak_x = y.max(axis=1, keepdims=True), x.max(axis=1, keepdims=True)
    # A source far off the map has density 0 everywhere; relative to the maximum it has not.
    peak = peak_y + peak_x
    rows = np.exp(y - peak_y + peak - peak.max()).astype(np.float32)
    cols = np.exp(x - peak_x).astype(np.float32)
    density: Floats32 = rows.T @ cols
    return density


def _rayleigh(grid: OccupancyGrid, source: Source) -> Floats32:
    """Σ (d/σ²) exp(−d²/2σ²), scaled to a largest term of 1 on the map."""
    total, top = np.zeros(grid.shape, dtype=np.float32), -math.inf
    for dy, dx in zip(*_offsets(grid, source.points), strict=True):
        radius = np.hypot(dy[:, None], dx[None, :])
        log = np.log(np.maximum(radius, 1e-9)) - 0.5 * np.square(radius / source.sigma)
        peak = float(log.max())
        higher = max(top, peak)
        total *= np.float32(math.exp(top - higher))
        total += np.exp(log - higher).astype(np.float32)
        top = higher
    return total


def _offsets(grid: OccupancyGrid, points: Floats) -> tuple[Floats, Floats]:
    """Offsets (k, rows) and (k, cols) of cell centres from points, along the grid's axes, m."""
    local = transform(inverse(grid.X_MG), points)
    rows, cols = grid.shape
    return (
        (np.arange(rows) + 0.5) * grid.resolution - local[:, 1:],
        (np.arange(cols) + 0.5) * grid.resolution - local[:, :1],
    )


@njit(**CACHED)
def _costs(field: Floats32, low: float, depth: float, highest: float) -> Bytes:
    out = np.empty(field.shape, dtype=np.uint8)
    for r in range(field.shape[0]):
        for c in range(field.shape[1]):
            out[r, c] = np.uint8(np.rint(highest - depth * (np.float64(field[r, c]) - low)))
    return out
