"""What every grid planner shares: from the ground and a search to a path to be followed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.errors import NoPath
from cohelm.geometry import arc_length, inverse, transform
from cohelm.messages import Path
from cohelm.planning.ground import Ground, GroundParameters, pair
from cohelm.planning.search import GridPath, Weights, path_cost, shortest_path
from cohelm.planning.smoothing import Smoothing, line_cost, smooth
from cohelm.planning.wishes import report

Search = Callable[[Weights], GridPath | None]
"""A way over some weights, or None where there is none."""

Score = Callable[[Floats], float]
"""What a method holds against a line (k, 2) in the map frame, m; ∞ where it is blocked."""


class RouteParameters(GroundParameters):
    """What every grid planner needs; the figures are assumed."""

    wanted_clearance: float = Field(0.6, ge=0.0, le=10.0)
    """Smoothing may come this near to obstacles and no nearer, unless the way did, m; that is about
    what the corners of the chair sweep in a turn."""
    smoothing: Smoothing = Smoothing()
    max_expansions: int | None = Field(None, ge=1)
    """Budget of the search, cells; none: as many as it takes."""


@value
class Route:
    """A way found on the grid."""

    cost: float
    """Weighted length under the ground's weights, m."""
    points: Annotated[Floats, Shape("m 2")]
    """Smoothed, map frame, m."""
    cells: Annotated[Integers, Shape("k 2")]
    """(row, column) of the way before it was smoothed."""


def find_route(
    ground: Ground,
    parameters: RouteParameters,
    weights: Weights | None = None,
    search: Search | None = None,
) -> Route:
    """The best way by a search over some weights, smoothed; its cost is that on the ground.

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
    found = (search or cheapest(ground, parameters))(weights)
    if found is None:
        start, goal = pair(ground.problem.start), pair(ground.problem.goal)
        raise NoPath(start=start, goal=goal, needed=ground.costmap.radius)
    cost = path_cost(ground.weights.packed, found.cells)
    return Route(
        cost=cost * ground.problem.grid.resolution,
        points=_line(ground, weights, found, parameters),
        cells=found.cells,
    )


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
    )


def _line(ground: Ground, weights: Weights, found: GridPath, parameters: RouteParameters) -> Floats:
    """The way as a smooth line (m, 2) in the map frame from the very start to the very goal."""
    problem, costmap = ground.problem, ground.costmap
    grid = problem.grid
    ends = transform(inverse(grid.X_MG), np.stack([problem.start, problem.goal]))
    inner = (found.cells[1:-1, ::-1] + 0.5) * grid.resolution
    line = smooth(
        np.concatenate([ends[:1], inner, ends[1:]]),
        weights,
        costmap.clearance,
        grid.resolution,
        needed=costmap.radius,
        wanted=max(parameters.wanted_clearance, costmap.radius),
        smoothing=parameters.smoothing,
    )
    line = transform(grid.X_MG, line)
    line[0], line[-1] = problem.start, problem.goal
    line.flags.writeable = False
    return line
