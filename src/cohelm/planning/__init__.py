"""Global planning: costmap layers, the planners, and from path to reference.

A map in, a path out. A hall of 16 × 10 m with a block in its middle, and a rider who would like to
pass by a point above it:

>>> import numpy as np
>>> from cohelm.maps import OccupancyGrid
>>> from cohelm.messages import Wish
>>> from cohelm.planning import RouteProblem
>>> from cohelm.plugins import build
>>> from cohelm.robots import load_robot
>>> cells = np.zeros((200, 320), dtype=np.int8)  # free; read_map(file) gives a real one
>>> cells[70:130, 120:200] = 100  # occupied
>>> problem = RouteProblem(
...     grid=OccupancyGrid(data=cells, resolution=0.05, X_MG=[0.0, 0.0, 0.0]),
...     robot=load_robot("quantum_q6_edge"),
...     start=[2.0, 4.8],
...     goal=[14.0, 4.8],
...     wishes=(Wish(points=[[8.0, 8.5]]),),
... )
>>> path = build("global_planners", "soft_via").plan(problem)
>>> path.points[[0, -1]].tolist()
[[2.0, 4.8], [14.0, 4.8]]
>>> print(f"{path.length:.0f} m, past the point: {path.wishes.closest[0] < 0.1}")
14 m, past the point: True
>>> path.wishes.extra_length > 0.0  # m, against the path without the wish
True

What cannot be planned is an error that says why:

>>> build("global_planners", "astar").plan(
...     RouteProblem(grid=problem.grid, robot=problem.robot, start=[2.0, 4.8], goal=[8.0, 5.0])
... )
Traceback (most recent call last):
cohelm.errors.GoalBlocked: the goal (8.00, 5.00) has 0.00 m of clearance, the robot needs 0.30 m
"""

from cohelm.planning.alternatives import Alternative, Differing, alternatives
from cohelm.planning.api import GlobalPlanner, RouteProblem
from cohelm.planning.astar import AStar
from cohelm.planning.costmap import Costmap, Inflation, build_costmap, combine
from cohelm.planning.features import Measuring, RouteFeatures, route_features
from cohelm.planning.ground import costmap_for
from cohelm.planning.iterative_astar import IterativeAStar
from cohelm.planning.proposal import Proposal, propose
from cohelm.planning.reference import Comfort, reference
from cohelm.planning.soft_via import SoftVia
from cohelm.planning.upf import UserPreferenceField
from cohelm.planning.upf_soft import SoftPreferenceField

__all__ = [
    "AStar",
    "Alternative",
    "Comfort",
    "Costmap",
    "Differing",
    "GlobalPlanner",
    "Inflation",
    "IterativeAStar",
    "Measuring",
    "Proposal",
    "RouteFeatures",
    "RouteProblem",
    "SoftPreferenceField",
    "SoftVia",
    "UserPreferenceField",
    "alternatives",
    "build_costmap",
    "combine",
    "costmap_for",
    "propose",
    "reference",
    "route_features",
]
