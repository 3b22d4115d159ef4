"""Routes ranked for a rider, with reasons in words; the rider chooses.

The order is the planner's own until enough is learned. Then it is the utility of a route's features
under the rider's weights, less a term for its distance from the wishes. A present wish is more
important than habits: two metres of distance count as much as all weights for one unit.
"""

from __future__ import annotations

from collections.abc import Sequence

from cohelm.arrays import value
from cohelm.planning.alternatives.alternatives import (
    Alternative,
    AlternativeCriteria,
    find_alternatives,
    wish_distance,
)
from cohelm.planning.alternatives.features import RouteFeatures
from cohelm.planning.alternatives.learned_preference import FEATURE_WORDS, FeatureVector, utility
from cohelm.planning.alternatives.rider_file import RiderChoices
from cohelm.planning.api import GlobalPlanner, RouteProblem

_WISH_UNIT = 2.0  # m
_MOST_WORDS = 4


@value
class ProposedRoute:
    """Route of a proposal with its rank."""

    alternative: Alternative
    utility: float
    """Higher for a better route; without unit."""
    words: str
    """Comparison with the planner's own route."""


@value
class Proposal:
    """Routes to choose from, the best first."""

    routes: tuple[ProposedRoute, ...]
    learned: bool
    """The order is the rider's; otherwise the planner's."""
    why: str
    """Reason of the order, in words."""


def propose(
    problem: RouteProblem,
    planner: GlobalPlanner,
    k: int = 3,
    *,
    rider: RiderChoices | None = None,
    differing: AlternativeCriteria | None = None,
) -> Proposal:
    """Find up to ``k`` different routes, ranked for a rider. Nothing is chosen or recorded.

    Args:
        problem, planner, k, differing: see :func:`cohelm.planning.find_alternatives`.
        rider: choices for the order; None, or too few choices: the planner's order.

    Raises:
        PlanningError: if there is no route at all.
    """
    return rank_routes(find_alternatives(problem, planner, k, differing), rider)


def rank_routes(routes: Sequence[Alternative], rider: RiderChoices | None = None) -> Proposal:
    """Rank routes for a rider; the first one given is the planner's own."""
    weights = rider.weights if rider is not None else None
    own, order = routes[0], preferred_order(routes, weights)
    proposed = [
        ProposedRoute(
            alternative=each,
            utility=-each.price if weights is None else _utility_for(each, weights),
            words=compare_routes(each, own, weights)
            if each is not own
            else _own_words(own, routes),
        )
        for each in routes
    ]
    ranked = tuple(proposed[k] for k in order)
    return Proposal(routes=ranked, learned=weights is not None, why=_why(rider))


def preferred_order(
    routes: Sequence[Alternative], weights: FeatureVector | None
) -> tuple[int, ...]:
    """Return the indices of routes, the best first; without weights their own order."""
    order = range(len(routes))
    if weights is None:
        return tuple(order)
    return tuple(sorted(order, key=lambda k: -_utility_for(routes[k], weights)))


def compare_routes(
    route: Alternative, other: Alternative, weights: FeatureVector | None = None
) -> str:
    """Noticeable differences between two routes in words, for example "quieter, 6 m longer".

    The wishes come first, then the others by the rider's weights, if they are known.
    """
    said: list[str] = []
    farther = wish_distance(route.path) - wish_distance(other.path)
    if abs(farther) >= 0.25:
        side = "farther from" if farther > 0.0 else "nearer to"
        said.append(f"{abs(farther):.1f} m {side} the wishes")
    said += [
        FEATURE_WORDS[name].compared(more) for name, more in differences(route, other, weights)
    ]
    return ", ".join(said[:_MOST_WORDS]) or "nearly equal"


def differences(
    route: Alternative, other: Alternative, weights: FeatureVector | None = None
) -> tuple[tuple[str, float], ...]:
    """Return (name, difference) of the figures in which two routes noticeably differ.

    The order is by the rider's weights, if they are known, else by the size of the difference.
    """
    found: list[tuple[float, str, float]] = []
    for name, trait in FEATURE_WORDS.items():
        more = _number(route.features, name) - _number(other.features, name)
        if abs(more) >= trait.noticed:
            weight = 1.0 if weights is None else abs(getattr(weights, name))
            found.append((weight * abs(more) / trait.unit, name, more))
    found.sort(key=lambda each: -each[0])
    return tuple((name, more) for _, name, more in found[:_MOST_WORDS])


def _utility_for(route: Alternative, weights: FeatureVector) -> float:
    return (
        utility(FeatureVector.of(route.features), weights) - wish_distance(route.path) / _WISH_UNIT
    )


def _own_words(own: Alternative, routes: Sequence[Alternative]) -> str:
    """Words for the planner's own route and its best figures."""
    said = ["the planner's own"]
    superlatives = (("length", "the shortest", -1.0), ("encounters", "the quietest", -1.0))
    for name, text, sign in (*superlatives, ("clearance", "with the most clearance", 1.0)):
        others = [_number(each.features, name) for each in routes if each is not own]
        mine = _number(own.features, name)
        if others and all(sign * (mine - each) >= FEATURE_WORDS[name].noticed for each in others):
            said.append(text)
    return ", ".join(said)


def _number(features: RouteFeatures, name: str) -> float:
    return float(getattr(features, name))


def _why(rider: RiderChoices | None) -> str:
    if rider is None:
        return "in the planner's order: no rider is named"
    if rider.weights is None:
        return f"in the planner's order: {rider.sentence()}"
    return f"in the order that suits {rider.name}: {rider.sentence()}"
