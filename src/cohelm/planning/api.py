"""Interface of global planners and the problem that they solve."""

from __future__ import annotations

import math
from typing import Protocol

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.maps import CostmapFilter, OccupancyGrid
from cohelm.messages import Crowding, LiveObstacles, Path, Wish
from cohelm.robots import Robot


@value
class RouteProblem:
    """Everything that a global planner may use."""

    grid: OccupancyGrid
    robot: Robot
    start: Annotated[Floats, Shape("2")]
    """(x, y), m."""
    goal: Annotated[Floats, Shape("2")]
    """(x, y), m."""
    start_heading: float = math.nan
    """Heading of the robot at the start, rad: where it cannot turn to a path it backs out. NaN:
    any."""
    wishes: tuple[Wish, ...] = ()
    wish_origin: Annotated[Floats, Shape("2")] | None = None
    """Position of the robot when the wishes were set, m. The distance d_r of Xu et al., eq. (1), is
    measured from there, so that the field does not change during the ride. None: the start."""
    live: LiveObstacles | None = None
    """Detected obstacles that are not on the map."""
    crowding: Crowding | None = None
    """Usual density of people."""
    groups: tuple[Floats, ...] = ()
    """Outline (k, 2) of each standing group, m; crossed only if no other route is left."""
    filters: tuple[CostmapFilter, ...] = ()
    """Masks over the map. Keepout masks change the route, speed limits do not."""
    clearance: float = 0.0
    """Distance to keep beyond the footprint, m."""
    effort: float = 1.0
    """Share of the search budget for the footprint; small if the planner is called again soon."""


class GlobalPlanner(Protocol):
    """An entry point of ``cohelm.global_planners``: a class with ``Parameters``."""

    def plan(self, problem: RouteProblem) -> Path:
        """Plan a path from start to goal.

        Raises:
            PlanningError: StartBlocked, GoalBlocked, OutsideMap, NoPath or PlanningTimeout.
        """
        ...
