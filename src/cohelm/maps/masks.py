"""Masks over a map: where not to go, where to go slowly; Nav2's costmap filters."""

from __future__ import annotations

from typing import Literal

from cohelm.arrays import value
from cohelm.maps.grid import OccupancyGrid

FilterType = Literal["keepout", "speed_percent", "speed_absolute"]


@value
class CostmapFilter:
    """A mask and what its numbers mean, after nav2_msgs/CostmapFilterInfo.

    A cell's number is ``base + multiplier · mask``, with the mask's occupancy 0…100: for
    ``keepout`` 100 is closed, 0 is free and what lies between costs in proportion; for
    ``speed_percent`` it is a share of the robot's full speed in percent and for ``speed_absolute``
    a speed in m/s, and 0 is no limit. Where the mask is unknown (−1) it says nothing.
    """

    type: FilterType
    mask: OccupancyGrid
    """Of any resolution and pose; nothing is said beyond it."""
    base: float = 0.0
    multiplier: float = 1.0
