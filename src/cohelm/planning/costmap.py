"""The costmap: what it costs to be where, in Nav2's values, as layers combined by maximum.

    0 free    1–252 graded    253 nearer than the robot is wide    254 an obstacle    255 unknown

Unknown blocks a wheelchair, so everything from ``INSCRIBED`` up does. Layers live in ``layers/``,
one file each. What stays as it is (the map, its inflation, the keepout masks) is made once and
kept; a layer that changes speaks of windows, in patches, and only these are made anew.
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
from cohelm.planning.cost_values import FREE, INSCRIBED, LETHAL, UNKNOWN
from cohelm.planning.layers.inflation import Inflation, inflate
from cohelm.planning.layers.keepout import keepout_costs
from cohelm.planning.layers.live import live_patch
from cohelm.planning.layers.patch import Patch
from cohelm.planning.layers.static import raise_to_static

__all__ = ["FREE", "INSCRIBED", "LETHAL", "UNKNOWN", "Costmap", "Inflation", "build_costmap"]


@value
class Costmap:
    """Costs and clearances on a grid."""

    grid: OccupancyGrid
    """The static map below; says where the cells are."""
    cost: Annotated[Bytes, Shape("rows cols")]
    """Nav2's values."""
    clearance: Annotated[Floats32, Shape("rows cols")]
    """Distance from cell centres to the surface of what blocks, m; negative inside. Exact in the
    map; about live obstacles and zones exact as far as they inflate."""
    walls: Annotated[Floats32, Shape("rows cols")]
    """The same to what bodily stands there, without what a rule closes (keepout masks and zones to
    avoid), m; the same array where no rule does."""
    radius: float
    """The distance up to which a cell is blocked, m."""
    kept: Costmap | None = None
    """The costmap below the patches, which is kept between plans; None: it is none of these."""
    patches: tuple[Patch, ...] = ()
    """In whose windows alone it differs from the kept one."""


def build_costmap(
    grid: OccupancyGrid,
    radius: float,
    inflation: Inflation,
    live: LiveObstacles | None = None,
    *,
    filters: tuple[CostmapFilter, ...] = (),
    patches: Iterable[Patch] = (),
) -> Costmap:
    """The costmap of a map and what stands in it.

    What the map and the keepout masks say is kept for the last two (grid, masks, radius,
    inflation); live obstacles and patches change only their windows, at the price of these.

    Args:
        grid: the static map.
        radius: cells nearer than this to an obstacle's surface are blocked, m.
        inflation: how costs fall off beyond.
        live: what the sensors see that the map does not know.
        filters: masks over the map, of which those for keepout count.
        patches: what the other layers say.
    """
    keepout = tuple(f for f in filters if f.type == "keepout")
    base = _kept_costmap(grid, keepout, radius, inflation)
    seen = live_patch(live, grid, radius, inflation) if live is not None else None
    return _patched(base, (*([seen] if seen is not None else []), *patches))


def combine(costmap: Costmap, layer: Bytes) -> Costmap:
    """The costmap with one more layer (rows, cols), by maximum."""
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
        there = cost[patch.rows, patch.cols]
        np.maximum(there, patch.cost, out=there)
    bodily = [patch for patch in patches if not patch.rule]
    ruled = any(patch.rule and patch.clearance is not None for patch in patches)
    walls = _nearest(base.walls, bodily)
    same = base.clearance is base.walls and not ruled
    return Costmap(
        grid=base.grid,
        cost=_sealed(cost),
        clearance=walls if same else _nearest(base.clearance, patches),
        walls=walls,
        radius=base.radius,
        kept=base.kept,
        patches=patches,
    )


def _nearest(clearance: Floats32, patches: Iterable[Patch]) -> Floats32:
    """The clearance with that of the patches, by minimum."""
    said = [(p.rows, p.cols, p.clearance) for p in patches if p.clearance is not None]
    if not said:
        return clearance
    clearance = lazy_copy(clearance)
    for rows, cols, near in said:
        there = clearance[rows, cols]
        np.minimum(there, near, out=there)
    clearance.flags.writeable = False
    return clearance


@lru_cache(maxsize=2)
def _kept_costmap(
    grid: OccupancyGrid, keepout: tuple[CostmapFilter, ...], radius: float, inflation: Inflation
) -> Costmap:
    rules = keepout_costs(keepout, grid) if keepout else None
    walls = _map_clearance(grid)
    clearance = walls
    if rules is not None and bool((rules == LETHAL).any()):
        clearance = _clearance(grid, grid.blocked() | (rules == LETHAL))
    cost = empty_for_copies(grid.shape, np.uint8)
    inflate(clearance, radius, inflation, out=cost)
    raise_to_static(cost, grid.data)
    if rules is not None:
        np.maximum(cost, rules, out=cost)
    kept = Costmap(grid=grid, cost=_sealed(cost), clearance=clearance, walls=walls, radius=radius)
    return dataclasses.replace(kept, kept=kept)


@lru_cache(maxsize=2)
def _map_clearance(grid: OccupancyGrid) -> Floats32:
    return _clearance(grid, grid.blocked())


def _clearance(grid: OccupancyGrid, blocked: Booleans) -> Floats32:
    clearance: Floats32 = empty_for_copies(grid.shape, np.float32)
    signed_distance(blocked, grid.resolution, out=clearance)
    clearance.flags.writeable = False
    return clearance


def _sealed(cost: Bytes) -> Bytes:
    """The array, read-only from now on; nobody else holds it, so the value need not copy it."""
    cost.flags.writeable = False
    return cost
