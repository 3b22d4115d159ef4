"""Relief of a floor: a ramp and thresholds. The planar simulation drives over them unnoticed."""

from __future__ import annotations

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.simulation.sensors.static_scene import LEVEL, FloorSurface


@value
class ThresholdEdge:
    """Bar on the floor, as under a door."""

    at: Annotated[Floats, Shape("2")]
    """Centre, m."""
    size: Annotated[Floats, Shape("2")]
    """Width and depth, m."""
    angle: float
    """Rotation, rad."""
    height: float
    """Over the floor, m."""


@value
class FloorRelief:
    """Heights of a floor that wheels drive over."""

    floor: FloorSurface = LEVEL
    thresholds: tuple[ThresholdEdge, ...] = ()


FLAT = FloorRelief()
"""Level floor without thresholds."""
