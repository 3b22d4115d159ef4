"""Knowledge and wishes of a rider that the chair lacks, and the rider's route that follows."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.maps import OccupancyGrid
from cohelm.planning import RouteProblem
from cohelm.scenarios.pedestrian_spec import Point
from cohelm.simulation import GoalChange

Planner = Callable[[RouteProblem], Floats]
"""Route (k, 2) of a problem, m."""


class NewGoal(Model):
    """Destination that the rider decides for on the way, without telling the chair."""

    near: Point
    """Place on the way at which the rider decides, m."""
    within: float = Field(1.0, gt=0.0, le=20.0)
    """Distance from it at which the rider decides, m."""
    goal: Point
    """New destination, m."""


class RiderPlan(Model):
    """Knowledge and wishes of the rider beyond the chair: its route is planned on the true world.

    With a plan, a ride is over where the rider wants to be, not at the goal of the chair.
    """

    goal_told: bool = True
    """Tell the chair the goal; otherwise it has none."""
    past: tuple[Point, ...] = ()
    """Places that the rider wants to come past, in order, m."""
    past_distance: float = Field(1.2, gt=0.0, le=20.0)
    """Distance at which a place counts as passed, m."""
    new_goal: NewGoal | None = None
    """Change of the destination on the way."""


def route_past(plan: RiderPlan, problem: RouteProblem, world: OccupancyGrid, by: Planner) -> Floats:
    """Route (k, 2) of the rider over the true floor, past all wanted places.

    Args:
        plan: of the rider.
        problem: start and goal of the rider.
        world: obstacles and avoided floor as the rider knows them.
        by: planner of each leg.

    Raises:
        PlanningError: if there is no such route.
    """
    stops = [problem.start, *(np.array(point) for point in plan.past), problem.goal]
    legs = [
        by(replace(problem, grid=world, start=a, goal=b, wishes=()))
        for a, b in itertools.pairwise(stops)
    ]
    return np.vstack([legs[0], *(leg[1:] for leg in legs[1:])])


def goal_change(
    plan: RiderPlan, problem: RouteProblem, world: OccupancyGrid, by: Planner
) -> GoalChange | None:
    """Change of the rider's destination, with its route; arguments as for :func:`route_past`."""
    new = plan.new_goal
    if new is None:
        return None
    near, goal = np.array(new.near), np.array(new.goal)
    route = by(replace(problem, grid=world, start=near, goal=goal, wishes=()))
    return GoalChange(near=near, within=new.within, goal=goal, route=route)
