from .alternatives.alternatives import (
    Alternative,
    AlternativeCriteria,
    find_alternatives,
)
from .alternatives.features import FeatureParameters, RouteFeatures, route_features
from .api import GlobalPlanner, RouteProblem
from .cost_fields import CostToGo, cost_to_go
from .costmap.costmap import Costmap, build_costmap, combine
from .costmap.layers.inflation import Inflation
from .planners.astar import AStar
from .planners.iterative_astar import IterativeAStar
from .planners.soft_via import SoftVia
from .planners.upf import SoftPreferenceField, UserPreferenceField
from .problem import costmap_for
from .reference import ComfortLimits, ReferenceSettings, make_reference

__all__ = [
    "AStar",
    "Alternative",
    "AlternativeCriteria",
    "ComfortLimits",
    "CostToGo",
    "Costmap",
    "FeatureParameters",
    "GlobalPlanner",
    "Inflation",
    "IterativeAStar",
    "ReferenceSettings",
    "RouteFeatures",
    "RouteProblem",
    "SoftPreferenceField",
    "SoftVia",
    "UserPreferenceField",
    "build_costmap",
    "combine",
    "cost_to_go",
    "costmap_for",
    "find_alternatives",
    "make_reference",
    "route_features",
]
