"""The paper's global planner: A* over a costmap with the user preference field as a layer."""

from __future__ import annotations

import numpy as np

from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.costmap import combine
from cohelm.planning.ground import ground_for, weigh
from cohelm.planning.layers.preference import Preference, preference_costs, spread
from cohelm.planning.route import RouteParameters, find_route, to_path
from cohelm.planning.wishes import attracting_points


class UserPreferenceField:
    """Xu et al., eqs. (1) and (2), Algorithm 1, with the corrections that ``Preference`` names.

    d_r of eq. (1) is the distance from ``RouteProblem.wished_from`` to the point.
    """

    class Parameters(RouteParameters):
        """Those of every grid planner, and the field's."""

        preference: Preference = Preference()

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`. Without wishes it is A*."""
        ground = ground_for(problem, self.parameters)
        without = find_route(ground, self.parameters)
        points = attracting_points(problem)
        if not len(points):
            return to_path(ground, without, without, method="upf")
        preference = self.parameters.preference
        origin = problem.start if problem.wished_from is None else problem.wished_from
        distance = np.hypot(*(points - origin).T)
        layer = preference_costs(problem.grid, points, spread(distance, preference), preference)
        weights = weigh(combine(ground.costmap, layer), ground.start, self.parameters)
        route = find_route(ground, self.parameters, weights)
        return to_path(ground, route, without, method="upf")
