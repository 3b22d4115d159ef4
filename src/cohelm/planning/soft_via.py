"""The best compromise between the cheapest way and the rider's points: exact."""

from __future__ import annotations

import contextlib
import dataclasses
import math

from pydantic import Field

from cohelm.arrays import Floats
from cohelm.errors import NoPath, PlanningTimeout
from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.astar import without_wishes
from cohelm.planning.ground import Ground, ground_for
from cohelm.planning.route import (
    RouteParameters,
    Score,
    Search,
    cheapest,
    find_route,
    score_on,
    to_path,
)
from cohelm.planning.search import GridPath, Weights
from cohelm.planning.via import cheapest_via
from cohelm.planning.via_layers import Chain
from cohelm.planning.wishes import chains_of, has_wishes, on_grid, price_of, strokes


class SoftVia:
    """The exact minimum, over all paths x on the grid from start to goal, of a cost and a price.

        cost(x) + λ · Σ_wishes min_{s_1 ≤ s_2 ≤ …} Σ_k |x(s_k) − p_k| + λ · Σ_strokes ∫ |x − p| dp

    cost: length weighted by the costmap, m. The first sum is the closest distance to a wish of one
    point p_1; the points p_1, p_2, … of one wish are met in their order, wishes among themselves in
    whichever is best. A stroke is met along its own direction, its integral summed over pieces.

    In the open, and with λ above about 2, the path passes through the points; where they cannot be
    reached, or only by a long way round, it lands on the best compromise, and that is the same
    wherever the robot was when the rider pointed. Without wishes the path is that of ``astar``.
    """

    class Parameters(RouteParameters):
        """Those of every grid planner, and the price of the wishes; the figures are assumed."""

        closeness: float = Field(2.0, ge=0.0, le=1000.0)
        """λ: weighted metres accepted for a metre nearer to a point, m/m; for a stroke along each
        metre of it, 1/m. 2 pays for going somewhere and back."""
        stroke_spacing: float = Field(1.0, ge=0.05, le=100.0)
        """Length of a stroke's pieces, m; longer where there would be too many."""
        stroke_pieces: int = Field(32, ge=1, le=255)
        """Of a stroke at most; time and memory grow with it."""
        stroke_effort: int = Field(10_000_000, ge=3)
        """Cells of layers that may be looked at for strokes, for all ways that are tried. A third
        of those left is for the next: where they do not do, the strokes are cut into a quarter of
        the pieces, and into a quarter of those, and at last left out of the search."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`.

        Raises:
            PlanningError: also TooManyWishes.
        """
        parameters = self.parameters
        ground = ground_for(problem, parameters)
        plain = find_route(ground, parameters)
        without = without_wishes(ground, parameters, plain)
        if not has_wishes(problem):
            return to_path(ground, plain, without, method="soft_via")

        search = _compromise(ground, parameters)
        chains = _chains(problem, parameters, parameters.stroke_pieces)
        score = _score(ground, chains)
        routes = [plain]
        # The footprint may not pass there, or only by detours that are not worth it.
        with contextlib.suppress(NoPath):
            routes.append(find_route(ground, parameters, search=search))
        route = min(routes, key=lambda each: score(each.points))
        return to_path(ground, route, without, method="soft_via", score=score)


def _compromise(ground: Ground, parameters: SoftVia.Parameters) -> Search:
    """The search for the best way under the wishes, with as much effort as there is for strokes."""
    problem, plainly = ground.problem, cheapest(ground, parameters)
    left = parameters.stroke_effort if strokes(problem) else 0

    def search(weights: Weights) -> GridPath | None:
        nonlocal left
        way, pieces = plainly(weights), parameters.stroke_pieces
        while way and pieces and left >= 3:
            chains = on_grid(_chains(problem, parameters, pieces), problem.grid)
            try:
                found = cheapest_via(weights, way, chains, max_expansions=left // 3)
            except PlanningTimeout:
                left, pieces = left - left // 3, pieces // 4
            else:
                left -= found.expansions
                return found
        chains = on_grid(_chains(problem, parameters, 0), problem.grid)
        budget = parameters.max_expansions
        return way and cheapest_via(weights, way, chains, max_expansions=budget)

    return search


def _chains(
    problem: RouteProblem, parameters: SoftVia.Parameters, pieces: int
) -> tuple[Chain, ...]:
    """The wishes with strokes of so many pieces at most; without strokes where that is 0."""
    if not pieces:
        points = tuple(wish for wish in problem.wishes if wish.kind != "stroke")
        problem = dataclasses.replace(problem, wishes=points)
    return chains_of(
        problem,
        closeness=parameters.closeness,
        spacing=parameters.stroke_spacing,
        pieces=max(pieces, 1),
    )


def _score(ground: Ground, chains: tuple[Chain, ...]) -> Score:
    """What is minimised, of a line."""
    cost = score_on(ground, ground.weights)

    def score(points: Floats) -> float:
        length = cost(points)
        return length + price_of(points, chains) if math.isfinite(length) else length

    return score
