"""The best compromise between the cheapest way and the rider's points: exact."""

from __future__ import annotations

import contextlib
import math

from pydantic import Field

from cohelm.arrays import Floats
from cohelm.errors import NoPath
from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.astar import without_wishes
from cohelm.planning.ground import Ground, ground_for
from cohelm.planning.route import RouteParameters, Score, cheapest, find_route, score_on, to_path
from cohelm.planning.search import GridPath, Weights
from cohelm.planning.via import cheapest_via
from cohelm.planning.via_layers import Chain
from cohelm.planning.wishes import chains_of, has_wishes, on_grid, price_of


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

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`.

        Raises:
            PlanningError: also TooManyWishes.
        """
        parameters = self.parameters
        ground = ground_for(problem, parameters)
        chains = chains_of(
            problem,
            closeness=parameters.closeness,
            spacing=parameters.stroke_spacing,
            pieces=parameters.stroke_pieces,
        )
        plain = find_route(ground, parameters)
        without = without_wishes(ground, parameters, plain)
        if not has_wishes(problem):
            return to_path(ground, plain, without, method="soft_via")

        cells, cheapest_way = on_grid(chains, problem.grid), cheapest(ground, parameters)

        def search(weights: Weights) -> GridPath | None:
            way, budget = cheapest_way(weights), parameters.max_expansions
            return way and cheapest_via(weights, way, cells, max_expansions=budget)

        score = _score(ground, chains)
        routes = [plain]
        # The footprint may not pass there, or only by detours that are not worth it.
        with contextlib.suppress(NoPath):
            routes.append(find_route(ground, parameters, search=search))
        route = min(routes, key=lambda each: score(each.points))
        return to_path(ground, route, without, method="soft_via", score=score)


def _score(ground: Ground, chains: tuple[Chain, ...]) -> Score:
    """What is minimised, of a line."""
    cost = score_on(ground, ground.weights)

    def score(points: Floats) -> float:
        length = cost(points)
        return length + price_of(points, chains) if math.isfinite(length) else length

    return score
