"""How inputs move a robot: used by control and by simulation, so that they cannot drift apart."""

from cohelm.robots.kinematics.api import Kinematics
from cohelm.robots.kinematics.arc import move
from cohelm.robots.kinematics.holonomic import Holonomic
from cohelm.robots.kinematics.limits import slowed, within_limits
from cohelm.robots.kinematics.turn_first import TurnFirst
from cohelm.robots.kinematics.unicycle import Unicycle

__all__ = ["Holonomic", "Kinematics", "TurnFirst", "Unicycle", "move", "slowed", "within_limits"]
