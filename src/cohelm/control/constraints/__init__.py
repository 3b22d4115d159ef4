"""The constraints of the optimal-control problem, one file each."""

from cohelm.control.constraints.bodies import Bodies
from cohelm.control.constraints.group_space import GroupSpace
from cohelm.control.constraints.input_limits import InputLimits
from cohelm.control.constraints.social_space import SocialSpace
from cohelm.control.constraints.wall_clearance import WallClearance

__all__ = ["Bodies", "GroupSpace", "InputLimits", "SocialSpace", "WallClearance"]
