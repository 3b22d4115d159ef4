"""Costmap in Nav2's cost values; its layers are combined by maximum.

    0 free    1–252 graded    253 closer than the inscribed radius    254 obstacle    255 unknown

Unknown space blocks a wheelchair, so all values from ``INSCRIBED`` up block. The layers are in
``layers/``. The static part (map, inflation, keepout masks) is computed once and cached; a layer
that changes gives patches, and only the cells in their windows are computed again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from cohelm.arrays import (
    Annotated,
    Booleans,
    Bytes,
    Floats32,
    Shape,
    empty_for_copies,
    lazy_copy,
    value,
)
from cohelm.maps import CostmapFilter, OccupancyGrid, signed_distance
from cohelm.messages import LiveObstacles
from cohelm.planning.costmap.layers.inflation import Inflation, inflate
from cohelm.planning.costmap.layers.live import live_patch
from cohelm.planning.costmap.layers.static import keepout_costs, raise_to_static
from cohelm.planning.costmap.patch import LETHAL, Patch


@value
class Costmap:
    """Costs and clearances on a grid."""

    grid: OccupancyGrid
    """Static map; defines the cells."""
    cost: Annotated[Bytes, Shape("rows cols")]
    """Nav2's cost values."""
    clearance: Annotated[Floats32, Shape("rows cols")]
    """Distance from cell centres to the surface of what blocks, m; negative inside. Exact in the
    map; near live obstacles and zones exact up to the inflation distance."""
    walls: Annotated[Floats32, Shape("rows cols")]
    """Clearance from physical obstacles only, without keepout masks and zones to avoid, m; the same
    array as ``clearance`` if there are none."""
    radius: float
    """Distance up to which a cell is blocked, m."""
    base: Costmap | None = None
    """Cached static costmap below the patches; None if this costmap is not based on one."""
    patches: tuple[Patch, ...] = ()
    """Windows outside of which the costmap equals ``base``."""


def build_costmap(
    grid: OccupancyGrid,
    radius: float,
    inflation: Inflation,
    live: LiveObstacles | None = None,
    *,
    filters: tuple[CostmapFilter, ...] = (),
    patches: Iterable[Patch] = (),
) -> Costmap:
    """Build the costmap of a map and the obstacles in it.

    The static part is cached for the last two keys (grid, masks, radius, inflation); live obstacles
    and patches cost only the time for their windows.

    Args:
        grid: the static map.
        radius: cells closer than this to an obstacle's surface are blocked, m.
        inflation: decay of the costs beyond.
        live: detected obstacles that are not on the map.
        filters: masks over the map; only those of type ``keepout`` are used.
        patches: windows of the other layers.
    """
    keepout = tuple(f for f in filters if f.type == "keepout")
    base = _static_costmap(grid, keepout, radius, inflation)
    detected = live_patch(live, grid, radius, inflation) if live is not None else None
    return _patched(base, (*([detected] if detected is not None else []), *patches))


def combine(costmap: Costmap, layer: Bytes) -> Costmap:
    """Combine a costmap with one more layer (rows, cols) by maximum."""
    return Costmap(
        grid=costmap.grid,
        cost=_sealed(np.maximum(costmap.cost, layer)),
        clearance=costmap.clearance,
        walls=costmap.walls,
        radius=costmap.radius,
        patches=costmap.patches,
    )


def _patched(base: Costmap, patches: tuple[Patch, ...]) -> Costmap:
    if not patches:
        return base
    cost = lazy_copy(base.cost)
    for patch in patches:
        window = cost[patch.rows, patch.cols]
        np.maximum(window, patch.cost, out=window)
    physical = [patch for patch in patches if not patch.rule]
    ruled = any(patch.rule and patch.clearance is not None for patch in patches)
    walls = _min_clearance(base.walls, physical)
    same = base.clearance is base.walls and not ruled
    return Costmap(
        grid=base.grid,
        cost=_sealed(cost),
        clearance=walls if same else _min_clearance(base.clearance, patches),
        walls=walls,
        radius=base.radius,
        base=base.base,
        patches=patches,
    )


def _min_clearance(clearance: Floats32, patches: Iterable[Patch]) -> Floats32:
    """Combine the clearance with that of the patches by minimum."""
    blocking = [(p.rows, p.cols, p.clearance) for p in patches if p.clearance is not None]
    if not blocking:
        return clearance
    clearance = lazy_copy(clearance)
    for rows, cols, near in blocking:
        window = clearance[rows, cols]
        np.minimum(window, near, out=window)
    clearance.flags.writeable = False
    return clearance


@lru_cache(maxsize=2)
def _static_costmap(
    grid: OccupancyGrid, keepout: tuple[CostmapFilter, ...], radius: float, inflation: Inflation
) -> Costmap:
    masks = keepout_costs(keepout, grid) if keepout else None
    walls = _map_clearance(grid)
    clearance = walls
    if masks is not None and bool((masks == LETHAL).any()):
        clearance = _clearance(grid, grid.blocked() | (masks == LETHAL))
    cost = empty_for_copies(grid.shape, np.uint8)
    inflate(clearance, radius, inflation, out=cost)
    raise_to_static(cost, grid.data)
    if masks is not None:
        np.maximum(cost, masks, out=cost)
    made = Costmap(grid=grid, cost=_sealed(cost), clearance=clearance, walls=walls, radius=radius)
    return dataclasses.replace(made, base=made)


@lru_cache(maxsize=2)
def _map_clearance(grid: OccupancyGrid) -> Floats32:
    return _clearance(grid, grid.blocked())


def _clearance(grid: OccupancyGrid, blocked: Booleans) -> Floats32:
    clearance: Floats32 = empty_for_copies(grid.shape, np.float32)
    signed_distance(blocked, grid.resolution, out=clearance)
    clearance.flags.writeable = False
    return clearance


def _sealed(cost: Bytes) -> Bytes:
    """Make an array read-only that has no other owner, so that the value need not copy it."""
    cost.flags.writeable = False
    return cost
