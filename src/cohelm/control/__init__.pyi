from .api import LocalPlanner, LocalProblem, Trajectory
from .baselines import PathFollower, without_people
from .optimal_control import OptimalControl, Solution
from .ss_mpc_dcbf import SsMpcDcbf

__all__ = [
    "LocalPlanner",
    "LocalProblem",
    "OptimalControl",
    "PathFollower",
    "Solution",
    "SsMpcDcbf",
    "Trajectory",
    "without_people",
]
