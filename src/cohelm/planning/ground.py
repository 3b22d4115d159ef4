"""The ground of a problem: where the robot can go and what that costs, for every method alike."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Floats32, value
from cohelm.config import Model
from cohelm.errors import GoalBlocked, OutsideMap, StartBlocked
from cohelm.planning.api import RouteProblem
from cohelm.planning.cost_values import INSCRIBED, MAX_GRADED
from cohelm.planning.costmap import Costmap, Inflation, build_costmap
from cohelm.planning.search import BLOCKED, Weights


class GroundParameters(Model):
    """What every grid planner makes of the map; the figures are assumed."""

    inflation: Inflation = Inflation()
    cost_weight: float = Field(4.0, ge=0.0, le=1000.0)
    """Weight of a cell is 1 + cost_weight · cost / 252: a metre beside a wall counts as at most
    1 + cost_weight free metres."""


@value
class Ground:
    """A problem with everything that does not depend on the method."""

    problem: RouteProblem
    costmap: Costmap
    """All layers but what attracting wishes and strokes say."""
    weights: Weights
    """Those of the costmap, opened about a start that is too near to an obstacle."""
    start: tuple[int, int]
    """(row, column)."""
    goal: tuple[int, int]
    """(row, column)."""


def ground_for(problem: RouteProblem, parameters: GroundParameters) -> Ground:
    """Costmap, weights and checked ends of a problem.

    Cells are blocked where the robot's inscribed circle with the problem's clearance does not fit.

    Raises:
        PlanningError: OutsideMap, StartBlocked or GoalBlocked.
    """
    costmap = costmap_for(problem, parameters.inflation)
    start, goal = _ends(problem, costmap)
    weights = weigh(costmap, start, parameters)
    return Ground(problem=problem, costmap=costmap, weights=weights, start=start, goal=goal)


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


def weigh(costmap: Costmap, start: tuple[int, int], parameters: GroundParameters) -> Weights:
    """The costmap's weights, opened about a start nearer to an obstacle than planning allows.

    A chair may have stopped close to a wall. Cells within a metre that are no nearer to obstacles
    than the start are opened, dearer than any other, so that the way leaves them soon.
    """
    weights = Weights.of_costs(costmap.cost, weight_table(parameters.cost_weight))
    row, col = start
    if np.isfinite(weights.packed[row + 1, col + 1]):
        return weights
    cells = math.ceil(1.0 / costmap.grid.resolution)
    packed = weights.packed.copy()
    dear = 2.0 * weights.heaviest
    _open(packed, costmap.clearance, row, col, cells, dear)
    packed.flags.writeable = False
    return Weights(packed=packed, lightest=weights.lightest, heaviest=dear)


def _ends(problem: RouteProblem, costmap: Costmap) -> tuple[tuple[int, int], tuple[int, int]]:
    """The cells of start and goal, where the robot can stand."""
    grid = problem.grid
    for what, point in (("start", problem.start), ("goal", problem.goal)):
        if not (np.isfinite(point).all() and bool(grid.contains(point))):
            raise OutsideMap(what=what, point=pair(point), bounds=grid.bounds)
    start, goal = grid.cells(problem.start), grid.cells(problem.goal)
    # A map knows an edge to a cell and a localiser a pose to some centimetres, so a chair that
    # stands beside a wall may look a cell too near; what is deeper in its inscribed circle blocks.
    room = float(costmap.clearance[start[0], start[1]])
    if room < problem.robot.inscribed_radius - grid.resolution:
        needed = problem.robot.inscribed_radius
        raise StartBlocked(point=pair(problem.start), clearance=room, needed=needed)
    if costmap.cost[goal[0], goal[1]] >= INSCRIBED:
        room = float(costmap.clearance[goal[0], goal[1]])
        raise GoalBlocked(point=pair(problem.goal), clearance=room, needed=costmap.radius)
    return (int(start[0]), int(start[1])), (int(goal[0]), int(goal[1]))


def pair(point: Floats) -> tuple[float, float]:
    """A point (2,) as plain numbers, for errors."""
    return float(point[0]), float(point[1])


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
