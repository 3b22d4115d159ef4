"""Local planners: the optimal-control problem, its terms and constraints, and who solves it."""

from cohelm.control.api import (
    Constraint,
    CostTerm,
    LocalPlanner,
    LocalProblem,
    Motion,
    Rows,
)
from cohelm.control.path_follower import PathFollower, without_people
from cohelm.control.social_mpc import SocialMpc
from cohelm.control.sqp import OptimalControl, Solution

__all__ = [
    "Constraint",
    "CostTerm",
    "LocalPlanner",
    "LocalProblem",
    "Motion",
    "OptimalControl",
    "PathFollower",
    "Rows",
    "SocialMpc",
    "Solution",
    "without_people",
]
