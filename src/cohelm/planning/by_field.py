"""What the methods with a user preference field share: all but the weights that it leads to."""

from __future__ import annotations

from collections.abc import Callable

from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.astar import without_wishes
from cohelm.planning.ground import Ground, ground_for
from cohelm.planning.layers.preference import Preference, Source, sources_of
from cohelm.planning.route import RouteParameters, find_route, score_on, to_path
from cohelm.planning.search import Weights

Reweigh = Callable[[Ground, tuple[Source, ...]], Weights]
"""The ground's weights with what attracts put in."""


def path_by_field(
    problem: RouteProblem,
    parameters: RouteParameters,
    preference: Preference,
    reweigh: Reweigh,
    *,
    method: str,
) -> Path:
    """The cheapest way under weights made of a preference field; without wishes that of A*.

    d_r of Xu et al., eq. (1), is the distance from ``RouteProblem.wished_from`` to the point.

    Args:
        problem: with the wishes.
        parameters: of the planner.
        preference: the shape of the field.
        reweigh: what the field makes of the weights.
        method: the planner's name.

    Raises:
        PlanningError: as ``GlobalPlanner.plan`` says.
    """
    ground = ground_for(problem, parameters)
    plain = find_route(ground, parameters)
    without = without_wishes(ground, parameters, plain)
    origin = problem.start if problem.wished_from is None else problem.wished_from
    sources = sources_of(problem.wishes, origin, preference)
    if not sources:
        return to_path(ground, plain, without, method=method)
    weights = reweigh(ground, sources)
    route = find_route(ground, parameters, weights)
    return to_path(ground, route, without, method=method, score=score_on(ground, weights))
