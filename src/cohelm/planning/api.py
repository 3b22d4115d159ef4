"""What a global planner is."""

from __future__ import annotations

from typing import Protocol

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.maps import CostmapFilter, OccupancyGrid
from cohelm.messages import Crowding, LiveObstacles, Path, Wish
from cohelm.robots import Robot


@value
class RouteProblem:
    """Everything a global planner may use."""

    grid: OccupancyGrid
    robot: Robot
    start: Annotated[Floats, Shape("2")]
    """(x, y), m."""
    goal: Annotated[Floats, Shape("2")]
    """(x, y), m."""
    wishes: tuple[Wish, ...] = ()
    wished_from: Annotated[Floats, Shape("2")] | None = None
    """Where the robot was when the wishes were set, m: d_r of Xu et al., eq. (1), is measured from
    there, so that the field stays as it was. None: at the start."""
    live: LiveObstacles | None = None
    """What stands where the map knows of nothing."""
    crowding: Crowding | None = None
    """Where people have been lately."""
    groups: tuple[Floats, ...] = ()
    """The outline (k, 2) between the members of each group that stands together, m: not to be cut
    through while another way is left."""
    filters: tuple[CostmapFilter, ...] = ()
    """Masks over the map: keepout zones. Speed limits do not move the route."""
    kept: Annotated[Floats, Shape("k 2")] | None = None
    """The rest of a path that is followed already, m: the answer says what it is worth now."""
    clearance: float = 0.0
    """Distance to keep beyond the footprint, m."""
    effort: float = 1.0
    """Share of what it may spend that the planner spends on a way for the footprint: less where the
    question comes again soon, and the answer must come at once."""


class GlobalPlanner(Protocol):
    """An entry point of ``cohelm.global_planners``; a class with ``Parameters``."""

    def plan(self, problem: RouteProblem) -> Path:
        """A path from start to goal.

        Raises:
            PlanningError: StartBlocked, GoalBlocked, OutsideMap, NoPath or PlanningTimeout.
        """
        ...
