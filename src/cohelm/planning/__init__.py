"""Global planning: costmap layers, the planners, and from path to reference."""

from cohelm.planning.api import GlobalPlanner, RouteProblem
from cohelm.planning.astar import AStar
from cohelm.planning.costmap import Costmap, Inflation, build_costmap, combine
from cohelm.planning.ground import costmap_for
from cohelm.planning.iterative_astar import IterativeAStar
from cohelm.planning.reference import Comfort, reference
from cohelm.planning.soft_via import SoftVia
from cohelm.planning.upf import UserPreferenceField
from cohelm.planning.upf_soft import SoftPreferenceField

__all__ = [
    "AStar",
    "Comfort",
    "Costmap",
    "GlobalPlanner",
    "Inflation",
    "IterativeAStar",
    "RouteProblem",
    "SoftPreferenceField",
    "SoftVia",
    "UserPreferenceField",
    "build_costmap",
    "combine",
    "costmap_for",
    "reference",
]
