"""Robots: motion models, footprint, limits and sensor mounts."""

from cohelm.robots.kinematics import (
    Holonomic,
    InputBounds,
    Kinematics,
    TurnFirst,
    Unicycle,
    move,
)
from cohelm.robots.robot import (
    BlindSector,
    CloudMount,
    DepthCameraMount,
    LaserMount,
    LidarMount,
    Robot,
    load_robot,
    robot_names,
)

__all__ = [
    "BlindSector",
    "CloudMount",
    "DepthCameraMount",
    "Holonomic",
    "InputBounds",
    "Kinematics",
    "LaserMount",
    "LidarMount",
    "Robot",
    "TurnFirst",
    "Unicycle",
    "load_robot",
    "move",
    "robot_names",
]
