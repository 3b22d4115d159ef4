"""The cheapest path, whatever the rider would like: the baseline without preference."""

from __future__ import annotations

import dataclasses

from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.ground import Ground, ground_for
from cohelm.planning.route import Route, RouteParameters, find_route, to_path


class AStar:
    """A* over the inflated map; attracting wishes are reported on but do not move the path."""

    class Parameters(RouteParameters):
        """Those of every grid planner."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`."""
        ground = ground_for(problem, self.parameters)
        route = find_route(ground, self.parameters)
        return to_path(
            ground, route, without_wishes(ground, self.parameters, route), method="astar"
        )


def without_wishes(
    ground: Ground, parameters: RouteParameters, plain: Route | None = None
) -> Route:
    """The way that would be taken without any wish, at its cost without them.

    Args:
        ground: of the problem.
        parameters: of the planner.
        plain: the cheapest way over the ground, where it is known already.

    Raises:
        PlanningError: NoPath or PlanningTimeout.
    """
    if any(wish.kind == "avoid" for wish in ground.problem.wishes):
        free = ground_for(dataclasses.replace(ground.problem, wishes=()), parameters)
        return find_route(free, parameters)
    return plain or find_route(ground, parameters)
