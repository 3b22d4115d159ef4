"""Keepout layer: masks over the map that say where not to go; after Nav2's KeepoutFilter.

A mask's number of 100 closes a cell, what lies between 0 and 100 costs in proportion, and an
unknown cell says nothing. A closed cell counts as an obstacle: it inflates and the chair's body
stays out of it, as with an inflation layer among Nav2's filters. A robot that stands in a closed
zone may leave it, as with Nav2's ``override_lethal_cost``.
"""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Bytes, Floats
from cohelm.maps import CostmapFilter, OccupancyGrid
from cohelm.maps.masks import CLOSED, project
from cohelm.planning.cost_values import FREE, LETHAL, MAX_GRADED


def keepout_costs(filters: tuple[CostmapFilter, ...], grid: OccupancyGrid) -> Bytes:
    """Costs (rows, cols) of the masks of type ``keepout``, the dearest where several overlap."""
    costs = np.full(grid.shape, FREE, dtype=np.uint8)
    for f in filters:
        if f.type == "keepout":
            project(f, _costs_of_numbers, grid, costs)
    return costs


def _costs_of_numbers(numbers: Floats) -> Bytes:
    """Nav2's costs of a mask's numbers (n,): 2.54 of each, and none in between blocks."""
    graded = np.clip(np.rint(numbers * (LETHAL / CLOSED)), FREE, MAX_GRADED)
    costs: Bytes = np.where(numbers >= CLOSED, LETHAL, graded).astype(np.uint8)
    return costs
