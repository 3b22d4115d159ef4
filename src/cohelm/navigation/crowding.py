"""Recent crowding for the global planner: a coarse grid of people's density that fades.

Each tracked person contributes their confidence, spread evenly over a disc. The density of a cell
rises to its present value within seconds, so that a person who walks past changes it little, but a
queue or a steady flow fully. It falls with a half-life of half a minute. A heat map from a file is
a lower bound.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Floats32, Shape, read_only, replace, value
from cohelm.config import Model
from cohelm.geometry import inverse, transform
from cohelm.kernels import CACHED
from cohelm.maps import OccupancyGrid
from cohelm.messages import Crowding, People

_ROUNDING = 1e-9  # s; times are sums of float steps


class CrowdingParameters(Model):
    """Time constants and resolution; all assumed."""

    resolution: float = Field(0.5, ge=0.1, le=10.0)
    """Side of a cell, m."""
    radius: float = Field(1.0, ge=0.1, le=10.0)
    """Radius of the disc of one person, m."""
    rise: float = Field(3.0, ge=0.0, le=600.0)
    """Half-life of the rise to the present density, s."""
    fade: float = Field(30.0, gt=0.0, le=36000.0)
    """Half-life of past density, s."""
    interval: float = Field(0.5, ge=0.0, le=60.0)
    """Time between updates, s."""
    threshold: float = Field(0.1, gt=0.0, le=10.0)
    """Change of the density of any cell that is published, people/m²; a fifth of it is enough if
    half of the published density is gone."""


@value
class CrowdingState:
    """Density, and its last published version."""

    time: float
    """Time of the last update, s."""
    density: Annotated[Floats32, Shape("rows cols")]
    """At that time, people/m²."""
    published: Crowding
    """Density for the global planner: the same object until it changes enough."""


def update_crowding(
    memory: CrowdingState | None,
    people: People,
    grid: OccupancyGrid,
    prior: Crowding | None,
    parameters: CrowdingParameters,
) -> CrowdingState:
    """Update the density; returns ``memory`` itself between two updates.

    Args:
        memory: of the last call, None at first.
        people: tracked people.
        grid: the map that the memory covers.
        prior: heat map from a file, a lower bound.
        parameters: time constants.
    """
    p = parameters
    if memory is None:
        density = _floor(grid, prior, p)
        first = Crowding(density=density, resolution=p.resolution, X_MG=grid.X_MG)
        memory = CrowdingState(time=people.time, density=density, published=first)
    elapsed = people.time - memory.time
    if elapsed < max(p.interval, _ROUNDING) - _ROUNDING:
        return memory
    present = np.zeros(memory.density.shape, dtype=np.float32)
    xy = transform(inverse(grid.X_MG), people.mean[:, :2])
    _count(present, xy, people.confidence, p.resolution, p.radius)
    risen = 1.0 - 0.5 ** (elapsed / p.rise) if p.rise > 0.0 else 1.0
    faded = memory.density * np.float32(0.5 ** (elapsed / p.fade))
    rising = memory.density + np.float32(risen) * (present - memory.density)
    density = np.where(present > memory.density, rising, np.maximum(faded, present))
    if prior is not None:
        density = np.maximum(density, _floor(grid, prior, p))
    state = CrowdingState(time=people.time, density=density, published=memory.published)
    return _publish(state, p.threshold)


def _publish(state: CrowdingState, threshold: float) -> CrowdingState:
    """Publish the density if it has changed enough since the last time."""
    known = state.published.density
    rise, fall = state.density - known, known - state.density
    enough = np.minimum(np.maximum(0.5 * known, 0.2 * threshold), threshold)
    if not ((rise >= threshold) | (fall >= enough)).any():
        return state
    version = state.published.version + 1
    published = replace(state.published, density=state.density, version=version)
    return replace(state, published=published)


@lru_cache(maxsize=4)
def _floor(grid: OccupancyGrid, prior: Crowding | None, p: CrowdingParameters) -> Floats32:
    """Prior at the cells of the memory (rows, cols), people/m², read-only; 0 beyond it."""
    rows, cols = (math.ceil(side * grid.resolution / p.resolution) for side in grid.shape)
    if prior is None:
        return read_only(np.zeros((rows, cols), dtype=np.float32))
    out = np.zeros((rows, cols), dtype=np.float32)
    col, row = np.meshgrid(np.arange(cols) + 0.5, np.arange(rows) + 0.5)
    centres = transform(grid.X_MG, np.stack([col, row], axis=-1) * p.resolution)
    at = np.floor(transform(inverse(prior.X_MG), centres) / prior.resolution).astype(np.int64)
    inside = ((at >= 0) & (at < np.array(prior.density.shape[::-1]))).all(axis=-1)
    out[inside] = prior.density[at[inside, 1], at[inside, 0]]
    return read_only(out)


@njit(**CACHED)
def _count(
    density: Floats32, people: Floats, confidence: Floats, resolution: float, radius: float
) -> None:
    """Add each person (n, 2), in the grid's frame, to the cells about them; in place.

    A cell belongs to the disc by its centre; the shares of one person sum to their confidence.
    """
    rows, cols = density.shape
    for i in range(people.shape[0]):
        x, y = people[i, 0] / resolution - 0.5, people[i, 1] / resolution - 0.5
        # At least the centre of the nearest cell lies within.
        far = max(radius / resolution, 0.75)
        r0, r1 = max(math.ceil(y - far), 0), min(math.floor(y + far), rows - 1)
        c0, c1 = max(math.ceil(x - far), 0), min(math.floor(x + far), cols - 1)
        # Cells outside of the grid take their share, too.
        cells = 0
        for r in range(math.ceil(y - far), math.floor(y + far) + 1):
            for c in range(math.ceil(x - far), math.floor(x + far) + 1):
                cells += (r - y) ** 2 + (c - x) ** 2 <= far * far
        share = confidence[i] / (max(cells, 1) * resolution * resolution)
        for r in range(r0, r1 + 1):
            for c in range(c0, c1 + 1):
                if (r - y) ** 2 + (c - x) ** 2 <= far * far:
                    density[r, c] += share
