"""Local planners: the optimal-control problem, its terms and constraints, and its solvers."""

from cohelm.control.api import (
    Constraint,
    ConstraintRows,
    ConstraintValues,
    CostTerm,
    LocalPlanner,
    LocalProblem,
    Motion,
)
from cohelm.control.baselines import PathFollower, without_people
from cohelm.control.sqp import OptimalControl, Solution
from cohelm.control.ss_mpc_dcbf import SsMpcDcbf

__all__ = [
    "Constraint",
    "ConstraintRows",
    "ConstraintValues",
    "CostTerm",
    "LocalPlanner",
    "LocalProblem",
    "Motion",
    "OptimalControl",
    "PathFollower",
    "Solution",
    "SsMpcDcbf",
    "without_people",
]
