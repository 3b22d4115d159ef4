"""The paper's global planner: A* over a costmap with the user preference field as a layer."""

from __future__ import annotations

from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.by_field import path_by_field
from cohelm.planning.costmap import combine
from cohelm.planning.ground import Ground, weigh
from cohelm.planning.layers.preference import Preference, Source, preference_costs
from cohelm.planning.route import RouteParameters
from cohelm.planning.search import Weights


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
        parameters = self.parameters
        return path_by_field(
            problem, parameters, parameters.preference, self._reweighed, method="upf"
        )

    def _reweighed(self, ground: Ground, sources: tuple[Source, ...]) -> Weights:
        """With the field as a layer of the costmap, by maximum."""
        layer = preference_costs(ground.costmap.grid, sources, self.parameters.preference)
        return weigh(combine(ground.costmap, layer), ground.start, self.parameters)
