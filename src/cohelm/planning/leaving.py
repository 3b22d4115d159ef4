"""Out of a zone that is closed by a rule, for a robot that stands in it, and not into it again."""

from __future__ import annotations

import cv2
import numpy as np

from cohelm.arrays import Integers
from cohelm.planning.cost_values import INSCRIBED
from cohelm.planning.ground import Ground
from cohelm.planning.search import BLOCKED, Weights

_BESIDE = 0.2  # m beside the way out that stay open, for the line to be smooth


def starts_in_zone(ground: Ground) -> bool:
    """Whether a rule, not an obstacle, closes the place where the robot stands."""
    costmap = ground.costmap
    return bool(costmap.clearance[ground.start] <= costmap.radius < costmap.walls[ground.start])


def only_out(ground: Ground, weights: Weights, cells: Integers) -> tuple[Weights, bool]:
    """(the weights with closed zones open along the way out alone, whether the way enters one).

    Args:
        ground: of a problem whose start is in a zone.
        weights: those that the way was searched with, in which the zone about the start is open.
        cells: the way (k, 2).
    """
    closed = ground.costmap.cost >= INSCRIBED
    inside = closed[cells[:, 0], cells[:, 1]]
    left = int(np.argmin(inside)) if not inside.all() else len(cells)
    out = np.zeros(closed.shape, dtype=np.uint8)
    width = max(2 * round(_BESIDE / ground.costmap.grid.resolution) + 1, 3)
    cv2.polylines(out, [cells[: left + 1, ::-1].astype(np.int32)], False, 1, thickness=width)
    packed = weights.packed.copy()
    packed[1:-1, 1:-1][closed & (out == 0)] = BLOCKED
    packed.flags.writeable = False
    narrowed = Weights(packed=packed, lightest=weights.lightest, heaviest=weights.heaviest)
    return narrowed, bool(inside[left:].any())
