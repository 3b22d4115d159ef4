from .floor_relief import LEVEL, FloorSurface
from .grid_raycast import cast
from .human_bodies import HumanBodies
from .laser import sweep
from .localisation import Localisation, Odometry
from .planar_bodies import BodyKind, outline_of, planar_discs
from .point_cloud import (
    LabelledCloud,
    scan_cloud,
    sweep_cloud,
)
from .static_scene import StaticScene

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
]
