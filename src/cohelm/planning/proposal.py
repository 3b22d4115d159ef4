"""Routes in the order in which they suit a rider, and in words why; the choice stays the rider's.

The order is the planner's own until enough is learned. After that it is the appeal of a route's
features under the rider's weights, less what its distance from the wishes counts: a wish said now
goes before habits, so two metres farther from it count as much as all habits together do where
routes differ by one unit.
"""

from __future__ import annotations

from collections.abc import Sequence

from cohelm.arrays import value
from cohelm.planning.alternatives import Alternative, Differing, alternatives, wish_distance
from cohelm.planning.api import GlobalPlanner, RouteProblem
from cohelm.planning.choices import Rider
from cohelm.planning.features import RouteFeatures
from cohelm.planning.learned import Liking, appeal
from cohelm.planning.traits import TRAITS

_WISH_UNIT = 2.0  # m
_MOST_WORDS = 4


@value
class Proposed:
    """A route with its place in the order."""

    alternative: Alternative
    appeal: float
    """The more, the better it suits; without unit."""
    words: str
    """How it compares with the planner's own route."""


@value
class Proposal:
    """Routes to choose from, the one that suits best first."""

    routes: tuple[Proposed, ...]
    learned: bool
    """Whether the order is the rider's; else it is the planner's."""
    why: str
    """What the order comes from, in words."""


def propose(
    problem: RouteProblem,
    planner: GlobalPlanner,
    k: int = 3,
    *,
    rider: Rider | None = None,
    differing: Differing | None = None,
) -> Proposal:
    """Up to ``k`` routes that really differ, ranked for a rider. Nothing is chosen or recorded.

    Args:
        problem, planner, k, differing: as :func:`cohelm.planning.alternatives.alternatives` has it.
        rider: whose choices to go by; None, or one with too few: the planner's order.

    Raises:
        PlanningError: if there is no route at all.
    """
    return rank(alternatives(problem, planner, k, differing), rider)


def rank(routes: Sequence[Alternative], rider: Rider | None = None) -> Proposal:
    """Routes, of which the first is the planner's own, ranked for a rider."""
    weights = rider.weights if rider is not None else None
    own = routes[0]
    proposed = [
        Proposed(
            alternative=each,
            appeal=-each.price if weights is None else _suits(each, weights),
            words=compared(each, own, weights) if each is not own else _of_the_own(own, routes),
        )
        for each in routes
    ]
    if weights is not None:
        proposed.sort(key=lambda each: -each.appeal)
    return Proposal(routes=tuple(proposed), learned=weights is not None, why=_why(rider))


def compared(route: Alternative, other: Alternative, weights: Liking | None = None) -> str:
    """What one notices of a route against another, as "quieter, 6 m longer".

    What counts most comes first: the wishes, then by the rider's weights, if any are known.
    """
    a, b = route.features, other.features
    said: list[tuple[float, str]] = []
    farther = wish_distance(route.path) - wish_distance(other.path)
    if abs(farther) >= 0.25:
        way = "farther from" if farther > 0.0 else "nearer to"
        said.append((float("inf"), f"{abs(farther):.1f} m {way} what was wished"))
    for name, trait in TRAITS.items():
        more = _number(a, name) - _number(b, name)
        if abs(more) >= trait.noticed:
            weight = 1.0 if weights is None else abs(getattr(weights, name))
            said.append((weight * abs(more) / trait.unit, trait.compared(more)))
    said.sort(key=lambda each: -each[0])
    return ", ".join(text for _, text in said[:_MOST_WORDS]) or "much the same"


def _suits(route: Alternative, weights: Liking) -> float:
    return appeal(Liking.of(route.features), weights) - wish_distance(route.path) / _WISH_UNIT


def _of_the_own(own: Alternative, routes: Sequence[Alternative]) -> str:
    """What the planner's own route is the best in."""
    said = ["the planner's own"]
    superlatives = (("length", "the shortest", -1.0), ("encounters", "the quietest", -1.0))
    for name, text, sign in (*superlatives, ("clearance", "with the most room", 1.0)):
        others = [_number(each.features, name) for each in routes if each is not own]
        mine = _number(own.features, name)
        if others and all(sign * (mine - each) >= TRAITS[name].noticed for each in others):
            said.append(text)
    return ", ".join(said)


def _number(features: RouteFeatures, name: str) -> float:
    return float(getattr(features, name))


def _why(rider: Rider | None) -> str:
    if rider is None:
        return "in the planner's order: no rider is named"
    if rider.weights is None:
        return f"in the planner's order: {rider.sentence()}"
    return f"in the order that suits {rider.name}: {rider.sentence()}"
