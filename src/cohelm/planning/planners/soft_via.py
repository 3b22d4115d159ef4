"""Planner of the exact optimum between path cost and closeness to the rider's points."""

from __future__ import annotations

import contextlib
import dataclasses
import math

from pydantic import Field

from cohelm.arrays import Floats
from cohelm.errors import NoPath, PlanningTimeout
from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.grid_search.via_points import ViaChain, cheapest_via_path
from cohelm.planning.grid_search.weights import GridPath, Weights
from cohelm.planning.planners.route import (
    GridPlannerParameters,
    GridSearch,
    LineScore,
    cheapest_search,
    find_route,
    route_without_wishes,
    score_on,
    to_path,
)
from cohelm.planning.planners.wishes import chains_of, has_wishes, on_grid, price_of, strokes
from cohelm.planning.problem import PreparedProblem, prepare


class SoftVia:
    """Exact minimum, over all paths x on the grid from start to goal, of a cost and a price.

        cost(x) + λ · Σ_wishes min_{s_1 ≤ s_2 ≤ …} Σ_k |x(s_k) − p_k| + λ · Σ_strokes ∫ |x − p| dp

    cost: length weighted by the costmap, m. For a wish of one point p_1, the first sum is the
    closest distance. The points p_1, p_2, … of one wish are passed in their order, different wishes
    in the best order. A stroke is followed in its direction; its integral is a sum over pieces.

    A point to visit has its own, larger λ: the path goes there wherever the robot can stand. For
    the others, in open space and with λ above about 2, the path passes through the points. If they
    cannot be reached, or only by a long detour, the path is the best compromise, which does not
    depend on the robot's position when the wish was set. Without wishes it is that of ``astar``.
    """

    class Parameters(GridPlannerParameters):
        """Parameters of every grid planner, and the price of the wishes; assumed."""

        closeness: float = Field(2.0, ge=0.0, le=1000.0)
        """λ: weighted metres accepted for a metre closer to a point, m/m; for a stroke per metre of
        its length, 1/m. A detour to the point and back is accepted from a value of 2 on."""
        visiting: float = Field(20.0, ge=0.0, le=1000.0)
        """λ of a point to visit, m/m. It exceeds the cost of a detour to the point and back, which
        is 2 · (1 + ``cost_weight``) beside walls."""
        stroke_spacing: float = Field(1.0, ge=0.05, le=100.0)
        """Length of a stroke's pieces, m; longer if there would be too many."""
        stroke_pieces: int = Field(32, ge=1, le=255)
        """Upper limit of a stroke's pieces; time and memory grow with it."""
        stroke_effort: int = Field(10_000_000, ge=3)
        """Cells of layers that may be expanded for strokes, for all searches together. Each search
        may use a third of the rest. If that is not enough, the strokes are cut into a quarter of
        the pieces, then into a quarter of those, and at last left out of the search."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`.

        Raises:
            PlanningError: also TooManyWishes.
        """
        parameters = self.parameters
        prepared = prepare(problem, parameters)
        plain = find_route(prepared, parameters)
        without = route_without_wishes(prepared, parameters, plain)
        if not has_wishes(problem):
            return to_path(prepared, plain, without, method="soft_via")

        search = _via_search(prepared, parameters)
        chains = _chains(problem, parameters, parameters.stroke_pieces)
        score = _score(prepared, chains)
        routes = [plain]
        # The footprint may not pass there, or only by detours that cost too much.
        with contextlib.suppress(NoPath):
            routes.append(find_route(prepared, parameters, search=search))
        route = min(routes, key=lambda each: score(each.points))
        return to_path(prepared, route, without, method="soft_via")


def _via_search(prepared: PreparedProblem, parameters: SoftVia.Parameters) -> GridSearch:
    """Create the search for the best path under the wishes, within the budget for strokes."""
    problem, cheapest = prepared.problem, cheapest_search(prepared, parameters)
    left = parameters.stroke_effort if strokes(problem) else 0

    def search(weights: Weights) -> GridPath | None:
        nonlocal left
        path, pieces = cheapest(weights), parameters.stroke_pieces
        while path and pieces and left >= 3:
            chains = on_grid(_chains(problem, parameters, pieces), problem.grid)
            try:
                found = cheapest_via_path(weights, path, chains, max_expansions=left // 3)
            except PlanningTimeout:
                left, pieces = left - left // 3, pieces // 4
            else:
                left -= found.expansions
                return found
        chains = on_grid(_chains(problem, parameters, 0), problem.grid)
        budget = parameters.max_expansions
        return path and cheapest_via_path(weights, path, chains, max_expansions=budget)

    return search


def _chains(
    problem: RouteProblem, parameters: SoftVia.Parameters, pieces: int
) -> tuple[ViaChain, ...]:
    """Chains of the wishes with at most ``pieces`` per stroke; without strokes if that is 0."""
    if not pieces:
        points = tuple(wish for wish in problem.wishes if wish.kind != "stroke")
        problem = dataclasses.replace(problem, wishes=points)
    return chains_of(
        problem,
        closeness=parameters.closeness,
        visiting=parameters.visiting,
        spacing=parameters.stroke_spacing,
        pieces=max(pieces, 1),
    )


def _score(prepared: PreparedProblem, chains: tuple[ViaChain, ...]) -> LineScore:
    """Create the objective of a line."""
    cost = score_on(prepared, prepared.weights)

    def score(points: Floats) -> float:
        length = cost(points)
        return length + price_of(points, chains) if math.isfinite(length) else length

    return score
