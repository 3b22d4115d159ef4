"""Local planners: the optimal-control problem, its terms and constraints, and its solvers.

The entrance is ``ss_mpc_dcbf``, the default planner. One plan is made in these steps:

1. ``validation`` checks the problem, ``warm_start`` estimates the current input.
2. ``sampling`` samples candidate trajectories and ranks them by one cost in seconds.
3. ``sqp`` refines a few of them: it assembles ``terms.costs`` and ``terms.constraints`` into
   quadratic programs, which ``qp`` solves.
4. ``verification`` accepts the cheapest safe one, or the planner brakes (``trajectories``).
5. The first input becomes the command; ``planner_memory`` keeps the sides on which people are
   passed, so that the next plan does not change its mind.

``api`` has the interfaces, ``baselines`` the published planners for comparison.
"""

from cohelm.control.api import (
    Constraint,
    ConstraintRows,
    ConstraintValues,
    CostTerm,
    LocalPlanner,
    LocalProblem,
    Trajectory,
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
    "OptimalControl",
    "PathFollower",
    "Solution",
    "SsMpcDcbf",
    "Trajectory",
    "without_people",
]
