"""The paper's global planner: A* over a costmap with the user preference field as a layer."""

from __future__ import annotations

from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.astar import lay_ground, without_wishes
from cohelm.planning.costmap import combine
from cohelm.planning.ground import weigh
from cohelm.planning.layers.preference import Preference, preference_costs, sources_of
from cohelm.planning.route import RouteParameters, find_route, score_on, to_path


class UserPreferenceField:
    """Xu et al., eqs. (1) and (2), Algorithm 1, with the corrections that ``Preference`` names.

    d_r of eq. (1) is the distance from ``RouteProblem.wished_from`` to the point. Points attract
    all at once: the field knows of no order.
    """

    class Parameters(RouteParameters):
        """Those of every grid planner, and the field's."""

        preference: Preference = Preference()

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`. Without wishes it is A*."""
        ground = lay_ground(problem, self.parameters)
        plain = find_route(ground, self.parameters)
        without = without_wishes(ground, self.parameters, plain)
        preference = self.parameters.preference
        origin = problem.start if problem.wished_from is None else problem.wished_from
        sources = sources_of(problem.wishes, origin, preference)
        if not sources:
            return to_path(ground, plain, without, method="upf")
        layer = preference_costs(problem.grid, sources, preference)
        weights = weigh(combine(ground.costmap, layer), ground.start, self.parameters)
        route = find_route(ground, self.parameters, weights)
        return to_path(ground, route, without, method="upf", score=score_on(ground, weights))
