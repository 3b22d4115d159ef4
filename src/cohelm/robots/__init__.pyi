from .kinematics import (
    Holonomic,
    InputBounds,
    Kinematics,
    TurnFirst,
    Unicycle,
    move,
)
from .robot import (
    NO_DROP_PROTECTION,
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
    "NO_DROP_PROTECTION",
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
