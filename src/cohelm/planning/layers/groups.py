"""Group layer: a path does not cut between people who stand together while another way is left.

The gap between members is not closed but dear, out of the scale of costs: crossing it counts as a
long way round, and where no way round is left, or a longer one only, it is crossed all the same.
"""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.maps import OccupancyGrid
from cohelm.planning.cost_values import MAX_GRADED
from cohelm.planning.layers.patch import Patch, window_about
from cohelm.planning.layers.zones import distances_to_area


class GroupCosts(Model):
    """What it costs to cut between the members of a group; assumed."""

    detour: float = Field(30.0, ge=0.0, le=1000.0)
    """The way round, over free floor, that is as good as crossing between two members, m."""
    reach: float = Field(0.4, gt=0.0, le=2.0)
    """Distance from the line or outline between the members' middles that still counts as between
    them, m: about a body, so that smoothing cannot pull the path across."""


def group_patch(outline: Floats, grid: OccupancyGrid, groups: GroupCosts) -> Patch | None:
    """What one group says; None where nothing of it is on the grid.

    A strip 2 · reach wide lies over the line between two members, so a weight of
    detour / (2 · reach) makes crossing it as dear as the detour.

    Args:
        outline: (k, 2), the members or the outline about them, map frame, m.
        grid: the map.
        groups: what it costs.
    """
    window = window_about(outline, groups.reach, grid) if len(outline) > 1 else None
    if window is None:
        return None
    local, rows, cols = window
    between = distances_to_area(local, grid.resolution, rows, cols) <= groups.reach
    weight = groups.detour / (2.0 * groups.reach)
    return Patch(
        rows=rows,
        cols=cols,
        cost=np.where(between, np.uint8(MAX_GRADED), np.uint8(0)),
        toll=np.where(between, np.float32(weight), np.float32(0.0)),
    )
