"""Local planners: the optimal-control problem, its terms and constraints, and who solves it."""

from cohelm.control.api import (
    Constraint,
    CostTerm,
    LocalPlanner,
    LocalProblem,
    Measure,
    Motion,
    Rows,
)
from cohelm.control.baselines import PathFollower, without_people
from cohelm.control.sqp import OptimalControl, Solution
from cohelm.control.ss_mpc_dcbf import SsMpcDcbf

__all__ = [
    "Constraint",
    "CostTerm",
    "LocalPlanner",
    "LocalProblem",
    "Measure",
    "Motion",
    "OptimalControl",
    "PathFollower",
    "Rows",
    "Solution",
    "SsMpcDcbf",
    "without_people",
]
