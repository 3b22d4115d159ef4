"""What every grid planner shares: from a problem to checked ends, from cells to a path."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Floats32, Shape, value
from cohelm.config import Model
from cohelm.errors import GoalBlocked, NoPath, OutsideMap, StartBlocked
from cohelm.geometry import arc_length, inverse, nearest_on_polyline, transform
from cohelm.messages import Path, WishReport
from cohelm.planning.api import RouteProblem
from cohelm.planning.cost_values import INSCRIBED, MAX_GRADED
from cohelm.planning.costmap import Costmap, Inflation, build_costmap
from cohelm.planning.search import BLOCKED, GridPath, Weights, path_cost, shortest_path
from cohelm.planning.smoothing import Smoothing, smooth


class RouteParameters(Model):
    """What every grid planner needs; the figures are assumed."""

    inflation: Inflation = Inflation()
    cost_weight: float = Field(4.0, ge=0.0, le=1000.0)
    """Weight of a cell is 1 + cost_weight · cost / 252: a metre beside a wall counts as at most
    1 + cost_weight free metres."""
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
    """Weighted length under the costmap without wishes, m."""
    points: Annotated[Floats, Shape("m 2")]
    """Smoothed, map frame, m."""


def costmap_for(problem: RouteProblem, inflation: Inflation) -> Costmap:
    """The costmap of map and live obstacles for the problem's robot.

    Cells are blocked where the robot's inscribed circle with the problem's clearance does not fit.
    """
    radius = problem.robot.inscribed_radius + problem.clearance
    return build_costmap(problem.grid, radius, inflation, problem.live)


def weight_table(cost_weight: float) -> Floats32:
    """Weights (256,) of Nav2's costs: 1 + cost_weight · cost / 252, blocked from 253."""
    table = np.full(256, BLOCKED, dtype=np.float32)
    table[:INSCRIBED] = 1.0 + cost_weight * np.arange(INSCRIBED) / MAX_GRADED
    return table


def find_route(
    problem: RouteProblem, base: Costmap, chosen: Costmap, parameters: RouteParameters
) -> Route:
    """The optimal way over the costmap ``chosen``, smoothed; its cost is that under ``base``.

    Args:
        problem: start, goal and robot.
        base: costs without wishes.
        chosen: costs with them; blocks what ``base`` blocks.
        parameters: of the planner.

    Raises:
        PlanningError: OutsideMap, StartBlocked, GoalBlocked, NoPath or PlanningTimeout.
    """
    start, goal = _ends(problem, base)
    table = weight_table(parameters.cost_weight)
    weights = _weights(chosen, table, start)
    found = shortest_path(weights, start, goal, max_expansions=parameters.max_expansions)
    if found is None:
        raise NoPath(start=_pair(problem.start), goal=_pair(problem.goal), needed=base.radius)
    cost = found.cost
    if chosen is not base:
        cost = path_cost(_weights(base, table, start).packed, found.cells)
    return Route(
        cost=cost * base.grid.resolution,
        points=_line(problem, base, weights, found, parameters),
    )


def to_path(problem: RouteProblem, route: Route, without: Route, *, method: str) -> Path:
    """``route`` as a ``Path`` that says what the wishes did to it.

    Args:
        problem: with the wishes.
        route: the way taken.
        without: the way that would be taken without wishes; may be ``route``.
        method: the planner's name.
    """
    length = float(arc_length(route.points)[-1])
    attracting = attracting_points(problem)
    return Path(
        points=route.points,
        length=length,
        cost=route.cost,
        method=method,
        wishes=WishReport(
            closest=np.array([_closest(route.points, p) for p in attracting]),
            extra_length=length - float(arc_length(without.points)[-1]),
            extra_cost=route.cost - without.cost,
        ),
        without_wishes=without.points,
    )


def attracting_points(problem: RouteProblem) -> Floats:
    """The points (w, 2) that the rider wants the path to come near to, m, in the order given."""
    points = [wish.points for wish in problem.wishes if wish.kind == "attract"]
    return np.concatenate(points) if points else np.empty((0, 2))


def _ends(problem: RouteProblem, costmap: Costmap) -> tuple[tuple[int, int], tuple[int, int]]:
    """The cells of start and goal, where the robot can stand."""
    grid = problem.grid
    for what, point in (("start", problem.start), ("goal", problem.goal)):
        if not (np.isfinite(point).all() and bool(grid.contains(point))):
            raise OutsideMap(what=what, point=_pair(point), bounds=grid.bounds)
    start, goal = grid.cells(problem.start), grid.cells(problem.goal)
    # A map knows an edge to a cell and a localiser a pose to some centimetres, so a chair that
    # stands beside a wall may look a cell too near; what is deeper in its inscribed circle blocks.
    room = float(costmap.clearance[start[0], start[1]])
    if room < problem.robot.inscribed_radius - grid.resolution:
        needed = problem.robot.inscribed_radius
        raise StartBlocked(point=_pair(problem.start), clearance=room, needed=needed)
    if costmap.cost[goal[0], goal[1]] >= INSCRIBED:
        room = float(costmap.clearance[goal[0], goal[1]])
        raise GoalBlocked(point=_pair(problem.goal), clearance=room, needed=costmap.radius)
    return (int(start[0]), int(start[1])), (int(goal[0]), int(goal[1]))


def _weights(costmap: Costmap, table: Floats32, start: tuple[int, int]) -> Weights:
    """The costmap's weights, opened about a start nearer to an obstacle than planning allows.

    A chair may have stopped close to a wall. Cells within a metre that are no nearer to obstacles
    than the start are opened, dearer than any other, so that the way leaves them soon.
    """
    weights = Weights.of_costs(costmap.cost, table)
    row, col = start
    if np.isfinite(weights.packed[row + 1, col + 1]):
        return weights
    cells = math.ceil(1.0 / costmap.grid.resolution)
    packed = weights.packed.copy()
    dear = 2.0 * weights.heaviest
    _open(packed, costmap.clearance, row, col, cells, dear)
    packed.flags.writeable = False
    return Weights(packed=packed, lightest=weights.lightest, heaviest=dear)


@njit(cache=True)
def _open(
    packed: Floats32, clearance: Floats32, row: int, col: int, cells: int, dear: float
) -> None:
    room = clearance[row, col]
    for r in range(max(row - cells, 0), min(row + cells + 1, clearance.shape[0])):
        for c in range(max(col - cells, 0), min(col + cells + 1, clearance.shape[1])):
            near = (r - row) ** 2 + (c - col) ** 2 <= cells * cells
            if near and packed[r + 1, c + 1] == np.inf and clearance[r, c] >= room:
                packed[r + 1, c + 1] = dear


def _line(
    problem: RouteProblem,
    costmap: Costmap,
    weights: Weights,
    found: GridPath,
    parameters: RouteParameters,
) -> Floats:
    """The way as a smooth line (m, 2) in the map frame from the very start to the very goal."""
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


def _closest(points: Floats, target: Floats) -> float:
    return float(nearest_on_polyline(points, target[0], target[1])[1])


def _pair(point: Floats) -> tuple[float, float]:
    return float(point[0]), float(point[1])
