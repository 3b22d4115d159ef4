"""Planner of the cheapest path without preference: the baseline."""

from __future__ import annotations

from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.planners.route import (
    GridPlannerParameters,
    find_route,
    route_without_wishes,
    to_path,
)
from cohelm.planning.problem import prepare


class AStar:
    """A* over the inflated map; attracting wishes are reported but do not change the path."""

    class Parameters(GridPlannerParameters):
        """Parameters of every grid planner."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`."""
        prepared = prepare(problem, self.parameters)
        route = find_route(prepared, self.parameters)
        without = route_without_wishes(prepared, self.parameters, route)
        return to_path(prepared, route, without, method="astar")
