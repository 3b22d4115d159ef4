"""Simulated sensors: laser scanners, LiDARs and depth cameras, localisation, odometry."""

from cohelm.simulation.sensors.grid_raycast import cast
from cohelm.simulation.sensors.human_bodies import HumanBodies
from cohelm.simulation.sensors.laser import sweep
from cohelm.simulation.sensors.localisation import Localisation, Odometry
from cohelm.simulation.sensors.planar_bodies import BodyKind, outline_of, planar_discs
from cohelm.simulation.sensors.point_cloud import (
    LabelledCloud,
    scan_cloud,
    sweep_cloud,
    visible_shares,
)
from cohelm.simulation.sensors.static_scene import LEVEL, FloorSurface, StaticScene

__all__ = [
    "LEVEL",
    "BodyKind",
    "FloorSurface",
    "HumanBodies",
    "LabelledCloud",
    "Localisation",
    "Odometry",
    "StaticScene",
    "cast",
    "outline_of",
    "planar_discs",
    "scan_cloud",
    "sweep",
    "sweep_cloud",
    "visible_shares",
]
