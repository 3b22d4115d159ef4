"""Where people have been lately, for the global planner: a coarse grid that fades.

Each tracked person counts as their confidence spread evenly over a disc. A cell's density rises to
what is there now within seconds, so that one who walks past leaves little and a queue or a steady
flow all of it, and falls with a half-life of half a minute. A heat map from a file is a floor below
which nothing falls.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Floats32, Shape, read_only, value
from cohelm.config import Model
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import Crowding, People

_ROUNDING = 1e-9  # s; times are sums of float steps


class CrowdingParameters(Model):
    """How people's presence is remembered; all assumed."""

    resolution: float = Field(0.5, ge=0.1, le=10.0)
    """Side of a cell, m."""
    reach: float = Field(1.0, ge=0.1, le=10.0)
    """Radius of the disc over which one person counts, m."""
    rise: float = Field(3.0, ge=0.0, le=600.0)
    """Half-life of the way up to the density that is there now, s."""
    fade: float = Field(30.0, gt=0.0, le=36000.0)
    """Half-life of what was there, s."""
    every: float = Field(0.5, ge=0.0, le=60.0)
    """Time from count to count, s."""
    notice: float = Field(0.1, gt=0.0, le=10.0)
    """Change of the density anywhere that routes are to be told of, people/m²; a fifth of it is
    enough where half of what they know is gone."""


@value
class CrowdingState:
    """What is remembered."""

    time: float
    """Of the last count, s."""
    density: Annotated[Floats32, Shape("rows cols")]
    """Then, people/m²."""
    told: Crowding
    """What routes know: the same object until there is something to tell."""


def crowding(
    memory: CrowdingState | None,
    people: People,
    grid: OccupancyGrid,
    prior: Crowding | None,
    parameters: CrowdingParameters,
) -> CrowdingState:
    """The memory after another look at who is there; ``memory`` itself between two counts.

    Args:
        memory: of the last call, None at first.
        people: tracked ones, now.
        grid: the map that the memory covers.
        prior: a heat map from a file, which holds where nobody has been seen.
        parameters: how it is remembered.
    """
    p = parameters
    if memory is None:
        density = _floor(grid, prior, p)
        first = Crowding(density=density, resolution=p.resolution, X_MG=grid.X_MG)
        memory = CrowdingState(time=people.time, density=density, told=first)
    elapsed = people.time - memory.time
    if elapsed < max(p.every, _ROUNDING) - _ROUNDING:
        return memory
    there = np.zeros(memory.density.shape, dtype=np.float32)
    xy = transform(inverse(grid.X_MG), people.mean[:, :2])
    _count(there, xy, people.confidence, p.resolution, p.reach)
    risen = 1.0 - 0.5 ** (elapsed / p.rise) if p.rise > 0.0 else 1.0
    faded = memory.density * np.float32(0.5 ** (elapsed / p.fade))
    rising = memory.density + np.float32(risen) * (there - memory.density)
    density = np.where(there > memory.density, rising, np.maximum(faded, there))
    if prior is not None:
        density = np.maximum(density, _floor(grid, prior, p))
    return _told(CrowdingState(time=people.time, density=density, told=memory.told), p.notice)


def _told(state: CrowdingState, notice: float) -> CrowdingState:
    """With news for routes where the density has changed enough since they were told."""
    known = state.told.density
    rise, fall = state.density - known, known - state.density
    enough = np.minimum(np.maximum(0.5 * known, 0.2 * notice), notice)
    if not ((rise >= notice) | (fall >= enough)).any():
        return state
    told = replace(state.told, density=state.density, version=state.told.version + 1)
    return replace(state, told=told)


@lru_cache(maxsize=4)
def _floor(grid: OccupancyGrid, prior: Crowding | None, p: CrowdingParameters) -> Floats32:
    """The prior at the memory's cells (rows, cols), people/m², read-only; 0 beyond it."""
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


@njit(cache=True)
def _count(
    there: Floats32, people: Floats, confidence: Floats, resolution: float, reach: float
) -> None:
    """Add each person (n, 2), in the grid's frame, to the cells about them; in place.

    A cell counts by its centre; the shares of one person add up to their confidence.
    """
    rows, cols = there.shape
    for i in range(people.shape[0]):
        x, y = people[i, 0] / resolution - 0.5, people[i, 1] / resolution - 0.5
        far = max(reach / resolution, 0.75)  # at least the nearest cell's centre
        r0, r1 = max(math.ceil(y - far), 0), min(math.floor(y + far), rows - 1)
        c0, c1 = max(math.ceil(x - far), 0), min(math.floor(x + far), cols - 1)
        cells = 0
        for r in range(math.ceil(y - far), math.floor(y + far) + 1):
            for c in range(math.ceil(x - far), math.floor(x + far) + 1):
                cells += (r - y) ** 2 + (c - x) ** 2 <= far * far
        share = confidence[i] / (max(cells, 1) * resolution * resolution)
        for r in range(r0, r1 + 1):
            for c in range(c0, c1 + 1):
                if (r - y) ** 2 + (c - x) ** 2 <= far * far:
                    there[r, c] += share
