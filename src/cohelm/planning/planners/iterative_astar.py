"""Planner that repeats A* with virtual obstacles at the largest deviation from the wishes."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Floats32
from cohelm.geometry import inverse, nearest_on_polyline, transform
from cohelm.kernels import CACHED
from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.grid_search.weights import BLOCKED, Weights
from cohelm.planning.planners.route import (
    DrivableRoute,
    GridPlannerParameters,
    cheapest_search,
    find_route,
    route_without_wishes,
    to_path,
)
from cohelm.planning.planners.wishes import has_wishes, wished_line
from cohelm.planning.problem import PreparedProblem, prepare

_SPACING = 0.1  # between samples of a line, m


class IterativeAStar:
    """Iterative A* after Chang (2017), as far as Xu et al. describe it: a baseline.

    Plan; while the path deviates from the wished line, put a virtual disc obstacle at the largest
    deviation, and plan again. The wished line leads from the start through all points and strokes,
    in the given order, to the goal; the deviation is the distance of a point of the path to it. The
    iteration ends when the path is close enough, after ``rounds``, or when no path is left, which
    is frequent; the path with the smallest deviation is taken.
    """

    class Parameters(GridPlannerParameters):
        """Parameters of every grid planner, and of the discs; assumed except for ``rounds``."""

        rounds: int = Field(20, ge=1, le=1000)
        """Upper limit of the plans; from the paper."""
        near_enough: float = Field(0.5, gt=0.0, le=100.0)
        """Accepted deviation, m."""
        disc_radius: float = Field(0.5, gt=0.0, le=100.0)
        """Radius of a virtual obstacle that the path must not enter, m; less near start and goal,
        which stay free."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`. Without wishes it is A*."""
        parameters = self.parameters
        prepared = prepare(problem, parameters)
        plain = find_route(prepared, parameters)
        without = route_without_wishes(prepared, parameters, plain)
        if not has_wishes(problem):
            return to_path(prepared, plain, without, method="iterative_astar")
        wanted = wished_line(problem)
        route = _iterate(prepared, plain, wanted, parameters)
        return to_path(prepared, route, without, method="iterative_astar")


def _iterate(
    prepared: PreparedProblem,
    plain: DrivableRoute,
    wanted: Floats,
    parameters: IterativeAStar.Parameters,
) -> DrivableRoute:
    """Route with the smallest deviation of all rounds."""
    grid, search = prepared.problem.grid, cheapest_search(prepared, parameters)
    weights, cells = prepared.weights, plain.cells
    least, best = math.inf, weights
    for left in range(parameters.rounds - 1, -1, -1):
        places = grid.centres(cells)
        deviation = _distances(wanted, places)
        worst = int(deviation.argmax())
        if deviation[worst] < least:
            least, best = float(deviation[worst]), weights
        if least <= parameters.near_enough or not left:
            break
        weights = _with_disc(prepared, weights, places[worst], parameters.disc_radius)
        found = search(weights)
        if found is None:
            break
        cells = found.cells
    return plain if best is prepared.weights else find_route(prepared, parameters, best)


def _with_disc(
    prepared: PreparedProblem, weights: Weights, place: Floats, radius: float
) -> Weights:
    """Block a disc that leaves start and goal free."""
    grid = prepared.problem.grid
    ends = grid.centres(np.array([prepared.start, prepared.goal]))
    free = float(np.hypot(*(ends - place).T).min())
    reach = min(radius, free - 0.5 * grid.resolution) / grid.resolution
    x, y = transform(inverse(grid.X_MG), place) / grid.resolution
    packed = weights.packed.copy()
    _block(packed, float(y), float(x), reach)
    packed.flags.writeable = False
    return Weights(packed=packed, lightest=weights.lightest, heaviest=weights.heaviest)


@njit(**CACHED)
def _distances(line: Floats, points: Floats) -> Floats:
    """Distances (m,) of points (m, 2) to a line."""
    out = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        out[i] = nearest_on_polyline(line, points[i, 0], points[i, 1])[1]
    return out


@njit(**CACHED)
def _block(packed: Floats32, row: float, col: float, reach: float) -> None:
    """Block the cells whose centres lie within ``reach`` of a point, all in cells."""
    rows, cols = packed.shape[0] - 2, packed.shape[1] - 2
    for r in range(max(int(row - reach) - 1, 0), min(int(row + reach) + 2, rows)):
        for c in range(max(int(col - reach) - 1, 0), min(int(col + reach) + 2, cols)):
            if (r + 0.5 - row) ** 2 + (c + 0.5 - col) ** 2 <= reach * reach:
                packed[r + 1, c + 1] = BLOCKED
