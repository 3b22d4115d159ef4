"""Global planning: costmap layers, global planners, and the reference along a path.

The input is a map, the output a path. In this example, a hall of 16 × 10 m has a block in its
middle, and the rider wants to pass a point above it:

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

A problem without a solution is an error with the reason:

>>> build("global_planners", "astar").plan(
...     RouteProblem(grid=problem.grid, robot=problem.robot, start=[2.0, 4.8], goal=[8.0, 6.7])
... )
Traceback (most recent call last):
cohelm.errors.GoalBlocked: the goal (8.00, 6.70) has 0.23 m of clearance, the robot needs 0.30 m
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
