"""The cheapest path, whatever the rider would like: the baseline without preference."""

from __future__ import annotations

from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.ground import ground_for
from cohelm.planning.route import RouteParameters, find_route, to_path


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
        return to_path(ground, route, route, method="astar")
