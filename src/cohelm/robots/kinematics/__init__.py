"""Motion models: from inputs to poses, shared by control and simulation."""

from cohelm.robots.kinematics.api import InputBounds, Kinematics
from cohelm.robots.kinematics.holonomic import Holonomic
from cohelm.robots.kinematics.motion import move, slowed, within_limits
from cohelm.robots.kinematics.unicycle import TurnFirst, Unicycle

__all__ = [
    "Holonomic",
    "InputBounds",
    "Kinematics",
    "TurnFirst",
    "Unicycle",
    "move",
    "slowed",
    "within_limits",
]
