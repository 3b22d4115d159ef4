"""What every grid planner shares: from the ground and a search to a path to be followed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.geometry import arc_length, inverse, resample, transform
from cohelm.messages import Path
from cohelm.planning.api import GlobalPlanner
from cohelm.planning.chaining import Effort
from cohelm.planning.fitting import LineParameters, fit_anyhow, fit_way, without_passage
from cohelm.planning.ground import Ground
from cohelm.planning.leaving import only_out, starts_in_zone
from cohelm.planning.passages import no_path
from cohelm.planning.repairing import Fitted
from cohelm.planning.search import GridPath, Weights, path_cost, shortest_path
from cohelm.planning.shortening import line_cost
from cohelm.planning.wishes import report

Search = Callable[[Weights], GridPath | None]
"""A way over some weights, or None where there is none."""

Score = Callable[[Floats], float]
"""What a method holds against a line (k, 2) in the map frame, m; ∞ where it is blocked."""


class RouteParameters(LineParameters):
    """What every grid planner needs."""

    max_expansions: int | None = Field(None, ge=1)
    """Budget of the search, cells; none: as many as it takes."""


def parameters_of(planner: GlobalPlanner) -> RouteParameters:
    """What a planner says that a way costs; the usual where it is no grid planner."""
    parameters = getattr(planner, "parameters", None)
    return parameters if isinstance(parameters, RouteParameters) else RouteParameters()


@value
class Route:
    """A way found on the grid that the footprint can follow."""

    cost: float
    """Weighted length under the ground's weights, m."""
    points: Annotated[Floats, Shape("m 2")]
    """Smoothed, map frame, m."""
    cells: Annotated[Integers, Shape("k 2")]
    """(row, column) of the way before it was smoothed."""
    pivots: Annotated[Integers, Shape("p")] = field(
        default_factory=lambda: np.empty(0, dtype=np.int64)
    )
    """Indices of the points where the robot turns on the spot."""


def find_route(
    ground: Ground,
    parameters: RouteParameters,
    weights: Weights | None = None,
    search: Search | None = None,
) -> Route:
    """The best way by a search over some weights that the footprint can follow, smoothed.

    Where the footprint does not pass on the best way, the place is blocked and another way sought,
    a few times; then one over (x, y, heading), on the whole map. The cost is that on the ground.
    Out of a zone that the robot stands in it leads once, and not in again.

    Args:
        ground: of the problem.
        parameters: of the planner.
        weights: what the search is to go by; the ground's own where None. They block what the
            ground's do.
        search: the cheapest way where None.

    Raises:
        PlanningError: NoPath or PlanningTimeout.
    """
    weights = ground.weights if weights is None else weights
    search = search or cheapest(ground, parameters)
    effort = Effort(round(ground.problem.effort * parameters.fitting.budget))
    stuck: list[Floats] = []
    in_zone = starts_in_zone(ground)
    for _ in range(parameters.fitting.detours + 1):
        found = search(weights)
        if found is not None and in_zone:
            weights, again = only_out(ground, weights, found.cells)
            found = search(weights) if again else found
        if found is None:
            break
        fitted = fit_way(ground, weights, found, parameters, effort)
        if fitted.stuck is None:
            return _route(ground, found.cells, fitted)
        stuck.append(fitted.stuck)
        around = without_passage(ground, weights, fitted)
        if around is None:
            break
        weights = around
    if stuck:
        last = fit_anyhow(ground, parameters)
        if last is not None:
            return _route(ground, _cells_of(ground, last.points), last)
    raise no_path(ground, parameters, stuck[0] if stuck else None)


def cheapest(ground: Ground, parameters: RouteParameters) -> Search:
    """The search for the cheapest way between the ground's ends, within the planner's budget."""

    def search(weights: Weights) -> GridPath | None:
        budget = parameters.max_expansions
        return shortest_path(weights, ground.start, ground.goal, max_expansions=budget)

    return search


def score_on(ground: Ground, weights: Weights) -> Score:
    """The weighted length of a line under some weights."""

    def score(points: Floats) -> float:
        line = transform(inverse(ground.problem.grid.X_MG), points)
        return line_cost(line, weights, ground.problem.grid.resolution)

    return score


def to_path(
    ground: Ground, route: Route, without: Route, *, method: str, score: Score | None = None
) -> Path:
    """``route`` as a ``Path`` that says what the wishes did to it.

    Args:
        ground: of the problem with the wishes.
        route: the way taken.
        without: the way that would be taken without attracting wishes; may be ``route``.
        method: the planner's name.
        score: what the method minimises; the weighted length on the ground where None.
    """
    score = score or score_on(ground, ground.weights)
    kept = ground.problem.kept
    length = float(arc_length(route.points)[-1])
    wishes = report(
        ground.problem,
        route.points,
        extra_length=length - float(arc_length(without.points)[-1]),
        extra_cost=route.cost - without.cost,
    )
    return Path(
        points=route.points,
        length=length,
        cost=route.cost,
        method=method,
        wishes=wishes,
        without_wishes=without.points,
        score=score(route.points),
        kept_score=score(kept) if kept is not None else None,
        pivots=route.pivots,
    )


def _route(ground: Ground, cells: Integers, fitted: Fitted) -> Route:
    """The route of a line in the grid's frame, from the very start to the very goal."""
    problem = ground.problem
    line = transform(problem.grid.X_MG, fitted.points)
    line[0], line[-1] = problem.start, problem.goal
    line.flags.writeable = False
    cost = path_cost(ground.weights.packed, cells) * problem.grid.resolution
    if not np.isfinite(cost):  # between cells, it passes where one of them is blocked
        cost = ground.weights.heaviest * float(arc_length(line)[-1])
    return Route(cost=cost, points=line, cells=cells, pivots=fitted.pivots)


def _cells_of(ground: Ground, points: Floats) -> Integers:
    """The cells (k, 2) that a line in the grid's frame comes through."""
    res = ground.problem.grid.resolution
    cells: Integers = np.floor(resample(points, 0.5 * res)[:, ::-1] / res).astype(np.int64)
    new = np.concatenate([[True], np.diff(cells, axis=0).any(axis=1)])
    return np.ascontiguousarray(cells[new])
