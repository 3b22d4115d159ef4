"""Plan, forbid where the plan strays most from what the rider wants, and plan again."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Floats32
from cohelm.geometry import inverse, nearest_on_polyline, resample, transform
from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.astar import without_wishes
from cohelm.planning.ground import Ground, ground_for
from cohelm.planning.route import (
    Route,
    RouteParameters,
    Score,
    cheapest,
    find_route,
    score_on,
    to_path,
)
from cohelm.planning.search import BLOCKED, Weights
from cohelm.planning.wishes import has_wishes, wished_line

_SPACING = 0.1  # between places of a line that is compared, m


class IterativeAStar:
    """Iterative A* after Chang (2017), as far as Xu et al. describe it: a baseline.

    Plan; while the path strays from what the rider wants, put a virtual disc obstacle where it
    strays most, and plan again. The rider gives points or strokes, so what the rider wants is taken
    to be the line from the start past all of them, in the order given, to the goal, and straying is
    the distance of a place of the path to that line. It ends when the path is near enough, after
    ``rounds``, or when no path is left, which happens often; the path that strayed least is taken.
    """

    class Parameters(RouteParameters):
        """Those of every grid planner, and the discs'; all assumed but ``rounds``."""

        rounds: int = Field(20, ge=1, le=1000)
        """Plans at most; the paper's."""
        near_enough: float = Field(0.5, gt=0.0, le=100.0)
        """Straying that is put up with, m."""
        disc_radius: float = Field(0.5, gt=0.0, le=100.0)
        """Of a virtual obstacle that the path's centre line must not enter, m; less beside start
        and goal, which stay free."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`. Without wishes it is A*."""
        parameters = self.parameters
        ground = ground_for(problem, parameters)
        plain = find_route(ground, parameters)
        without = without_wishes(ground, parameters, plain)
        if not has_wishes(problem):
            return to_path(ground, plain, without, method="iterative_astar")
        wanted = wished_line(problem)
        route = _iterate(ground, plain, wanted, parameters)
        score = _score(ground, wanted, parameters.near_enough)
        return to_path(ground, route, without, method="iterative_astar", score=score)


def _iterate(
    ground: Ground, plain: Route, wanted: Floats, parameters: IterativeAStar.Parameters
) -> Route:
    """The route that strays least among those of all rounds."""
    grid, search = ground.problem.grid, cheapest(ground, parameters)
    weights, cells = ground.weights, plain.cells
    least, best = math.inf, weights
    for left in range(parameters.rounds - 1, -1, -1):
        places = grid.centres(cells)
        stray = _distances(wanted, places)
        worst = int(stray.argmax())
        if stray[worst] < least:
            least, best = float(stray[worst]), weights
        if least <= parameters.near_enough or not left:
            break
        weights = _with_disc(ground, weights, places[worst], parameters.disc_radius)
        found = search(weights)
        if found is None:
            break
        cells = found.cells
    return plain if best is ground.weights else find_route(ground, parameters, best)


def _with_disc(ground: Ground, weights: Weights, place: Floats, radius: float) -> Weights:
    """The weights with a disc blocked that leaves start and goal free."""
    grid = ground.problem.grid
    ends = grid.centres(np.array([ground.start, ground.goal]))
    room = float(np.hypot(*(ends - place).T).min())
    reach = min(radius, room - 0.5 * grid.resolution) / grid.resolution
    x, y = transform(inverse(grid.X_MG), place) / grid.resolution
    packed = weights.packed.copy()
    _block(packed, float(y), float(x), reach)
    packed.flags.writeable = False
    return Weights(packed=packed, lightest=weights.lightest, heaviest=weights.heaviest)


def _score(ground: Ground, wanted: Floats, near_enough: float) -> Score:
    """Weighted length, and how far a line strays beyond what is put up with, m."""
    cost = score_on(ground, ground.weights)

    def score(points: Floats) -> float:
        stray = float(_distances(wanted, resample(points, _SPACING)).max())
        return cost(points) + max(stray - near_enough, 0.0)

    return score


@njit(cache=True)
def _distances(line: Floats, points: Floats) -> Floats:
    """Distances (m,) of points (m, 2) to a line."""
    out = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        out[i] = nearest_on_polyline(line, points[i, 0], points[i, 1])[1]
    return out


@njit(cache=True)
def _block(packed: Floats32, row: float, col: float, reach: float) -> None:
    """Block the cells whose centres lie within ``reach`` of a place, all in cells."""
    rows, cols = packed.shape[0] - 2, packed.shape[1] - 2
    for r in range(max(int(row - reach) - 1, 0), min(int(row + reach) + 2, rows)):
        for c in range(max(int(col - reach) - 1, 0), min(int(col + reach) + 2, cols)):
            if (r + 0.5 - row) ** 2 + (c + 0.5 - col) ** 2 <= reach * reach:
                packed[r + 1, c + 1] = BLOCKED
