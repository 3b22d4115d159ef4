from .api import InputBounds, Kinematics
from .holonomic import Holonomic
from .motion import move, slowed, within_limits
from .unicycle import TurnFirst, Unicycle

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
