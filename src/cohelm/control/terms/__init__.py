"""Cost terms and constraints of the optimal-control problem."""

from cohelm.control.terms.bodies import BodyClearance
from cohelm.control.terms.gauss_newton import gauss_newton
from cohelm.control.terms.group_space import GroupSpace
from cohelm.control.terms.input_effort import InputEffort
from cohelm.control.terms.input_limits import InputLimits
from cohelm.control.terms.smooth_input import SeatComfort, SmoothInput
from cohelm.control.terms.social_space import SocialSpace
from cohelm.control.terms.track_reference import PathProgress, TrackReference
from cohelm.control.terms.wall_clearance import WallClearance

__all__ = [
    "BodyClearance",
    "GroupSpace",
    "InputEffort",
    "InputLimits",
    "PathProgress",
    "SeatComfort",
    "SmoothInput",
    "SocialSpace",
    "TrackReference",
    "WallClearance",
    "gauss_newton",
]
