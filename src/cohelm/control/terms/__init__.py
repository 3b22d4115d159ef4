"""Cost terms (``costs``) and constraints (``constraints``) of the optimal-control problem."""

from cohelm.control.terms.constraints.group_barrier import GroupBarrier
from cohelm.control.terms.constraints.input_limits import InputLimits
from cohelm.control.terms.constraints.person_barrier import PersonBarrier
from cohelm.control.terms.constraints.social_space_barrier import SocialSpaceBarrier
from cohelm.control.terms.constraints.wall_barrier import WallBarrier
from cohelm.control.terms.costs.gauss_newton import gauss_newton
from cohelm.control.terms.costs.input_effort import InputEffort
from cohelm.control.terms.costs.smooth_input import SeatComfort, SmoothInput
from cohelm.control.terms.costs.track_reference import PathProgress, TrackReference

__all__ = [
    "GroupBarrier",
    "InputEffort",
    "InputLimits",
    "PathProgress",
    "PersonBarrier",
    "SeatComfort",
    "SmoothInput",
    "SocialSpaceBarrier",
    "TrackReference",
    "WallBarrier",
    "gauss_newton",
]
