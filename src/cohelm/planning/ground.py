"""The ground of a problem: where the robot can go and what that costs, for every method alike."""

from __future__ import annotations

import dataclasses
import math
from functools import lru_cache

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Floats32, lazy_copy, value
from cohelm.config import Model
from cohelm.errors import GoalBlocked, OutsideMap, StartBlocked
from cohelm.messages import Wish
from cohelm.planning.api import RouteProblem
from cohelm.planning.checks import check_problem
from cohelm.planning.cost_values import INSCRIBED, MAX_GRADED
from cohelm.planning.costmap import Costmap, Inflation, build_costmap
from cohelm.planning.layers.crowding import CrowdingCosts, crowding_patches
from cohelm.planning.layers.groups import GroupCosts, group_patch
from cohelm.planning.layers.patch import Patch
from cohelm.planning.layers.zones import ZoneCosts, distance_to_zone, zone_patch
from cohelm.planning.search import BLOCKED, Weights, pack_costs, shortest_path


class GroundParameters(Model):
    """What every grid planner makes of the map; the figures are assumed."""

    inflation: Inflation = Inflation()
    zones: ZoneCosts = ZoneCosts()
    crowding: CrowdingCosts = CrowdingCosts()
    groups: GroupCosts = GroupCosts()
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
        PlanningError: OutsideMap, StartBlocked, GoalBlocked or InvalidProblem.
    """
    check_problem(problem)
    costmap = costmap_for(problem, parameters)
    start, goal = _ends(problem, costmap)
    weights = weigh(costmap, start, parameters)
    return Ground(problem=problem, costmap=costmap, weights=weights, start=start, goal=goal)


def closed_by_zones(ground: Ground, parameters: GroundParameters) -> bool:
    """Whether a way from start to goal is there but for the hard zones to avoid.

    To be asked where no way was found: it searches once more.
    """
    if not any(wish.hard for wish in _avoided(ground.problem)):
        return False
    return _leads(_without_zones(ground.problem), parameters)


def closed_by_keepout(ground: Ground, parameters: GroundParameters) -> bool:
    """The same of the keepout masks."""
    if not any(f.type == "keepout" for f in ground.problem.filters):
        return False
    return _leads(dataclasses.replace(ground.problem, filters=()), parameters)


def costmap_for(problem: RouteProblem, parameters: GroundParameters) -> Costmap:
    """The costmap of a problem: map, keepout masks, live obstacles, zones, crowding and groups.

    Cells are blocked where the robot's inscribed circle with the problem's clearance does not fit.
    """
    radius = problem.robot.inscribed_radius + problem.clearance
    grid, inflation = problem.grid, parameters.inflation
    said: list[Patch | None] = [
        zone_patch(wish, grid, radius, inflation, parameters.zones) for wish in _avoided(problem)
    ]
    said.extend(group_patch(outline, grid, parameters.groups) for outline in problem.groups)
    if problem.crowding is not None:
        said.extend(crowding_patches(problem.crowding, grid, parameters.crowding))
    return build_costmap(
        grid,
        radius,
        inflation,
        problem.live,
        filters=problem.filters,
        patches=[patch for patch in said if patch is not None],
    )


def weight_table(cost_weight: float) -> Floats32:
    """Weights (256,) of Nav2's costs: 1 + cost_weight · cost / 252, blocked from 253."""
    table = np.full(256, BLOCKED, dtype=np.float32)
    table[:INSCRIBED] = 1.0 + cost_weight * np.arange(INSCRIBED) / MAX_GRADED
    return table


def weigh(costmap: Costmap, start: tuple[int, int], parameters: GroundParameters) -> Weights:
    """The costmap's weights with its tolls, opened about a start where planning allows none.

    A chair may have stopped close to a wall. Cells within a metre that are no nearer to obstacles
    than the start are opened, dearer than any other, so that the way leaves them soon. So are those
    of the zone, by a keepout mask or a hard wish, in which the chair stands.

    The weights of a kept costmap are kept too, and of one with patches only these are made anew.
    """
    table = weight_table(parameters.cost_weight)
    if costmap.kept is None:
        weights = Weights.of_costs(costmap.cost, table)
    else:
        weights = _kept_weights(costmap.kept, parameters.cost_weight)
    blocked = costmap.cost[start] >= INSCRIBED
    if not (blocked or costmap.patches):
        return weights
    packed = lazy_copy(weights.packed)
    heaviest = weights.heaviest
    if costmap.kept is not None:
        for patch in costmap.patches:
            window = costmap.cost[patch.rows, patch.cols]
            pack_costs(window, table, packed, patch.rows.start, patch.cols.start)
    for patch in costmap.patches:
        if patch.toll is not None:
            heaviest = max(heaviest, float(patch.toll.max()))
            _charge(patch.toll, packed, patch.rows.start, patch.cols.start)
    if blocked:
        heaviest *= 2.0
        cells = math.ceil(1.0 / costmap.grid.resolution)
        _open(packed, costmap.clearance, costmap.walls, costmap.radius, start, cells, heaviest)
    packed.flags.writeable = False
    return Weights(packed=packed, lightest=weights.lightest, heaviest=heaviest)


@lru_cache(maxsize=2)
def _kept_weights(costmap: Costmap, cost_weight: float) -> Weights:
    return Weights.of_costs(costmap.cost, weight_table(cost_weight))


def _ends(problem: RouteProblem, costmap: Costmap) -> tuple[tuple[int, int], tuple[int, int]]:
    """The cells of start and goal, where the robot can stand."""
    grid = problem.grid
    for what, point in (("start", problem.start), ("goal", problem.goal)):
        if not (np.isfinite(point).all() and bool(grid.contains(point))):
            raise OutsideMap(what=what, point=pair(point), bounds=grid.bounds)
    start, goal = grid.cells(problem.start), grid.cells(problem.goal)
    # A map knows an edge to a cell and a localiser a pose to some centimetres, so a chair that
    # stands beside a wall may look a cell too near; what is deeper in its inscribed circle blocks.
    room = float(costmap.walls[start[0], start[1]])
    if room < problem.robot.inscribed_radius - grid.resolution:
        needed = problem.robot.inscribed_radius
        raise StartBlocked(point=pair(problem.start), clearance=room, needed=needed)
    if costmap.cost[goal[0], goal[1]] >= INSCRIBED:
        raise GoalBlocked(
            point=pair(problem.goal),
            clearance=float(costmap.clearance[goal[0], goal[1]]),
            needed=costmap.radius,
            because=_rule_at_goal(problem, costmap, (int(goal[0]), int(goal[1]))),
        )
    return (int(start[0]), int(start[1])), (int(goal[0]), int(goal[1]))


def _rule_at_goal(problem: RouteProblem, costmap: Costmap, goal: tuple[int, int]) -> str:
    """What closes the goal, in words; nothing where it is an obstacle."""
    if costmap.walls[goal] <= costmap.radius:
        return ""
    nearest = min(
        (distance_to_zone(wish, problem.goal) for wish in _avoided(problem) if wish.hard),
        default=math.inf,
    )
    reached = nearest <= costmap.radius + problem.grid.resolution
    return "a zone to avoid" if reached else "a keepout zone"


def _avoided(problem: RouteProblem) -> tuple[Wish, ...]:
    return tuple(wish for wish in problem.wishes if wish.kind == "avoid" and len(wish.points))


def _without_zones(problem: RouteProblem) -> RouteProblem:
    """The problem without its hard zones."""
    wishes = tuple(w for w in problem.wishes if not (w.kind == "avoid" and w.hard))
    return dataclasses.replace(problem, wishes=wishes)


def _leads(problem: RouteProblem, parameters: GroundParameters) -> bool:
    """Whether a way leads from the problem's start to its goal."""
    ground = ground_for(problem, parameters)
    return shortest_path(ground.weights, ground.start, ground.goal) is not None


def pair(point: Floats) -> tuple[float, float]:
    """A point (2,) as plain numbers, for errors."""
    return float(point[0]), float(point[1])


@njit(cache=True)
def _charge(toll: Floats32, packed: Floats32, row: int, col: int) -> None:
    """Raise packed weights that can be passed to the toll, which begins at (row, col)."""
    for r in range(toll.shape[0]):
        for c in range(toll.shape[1]):
            weight = packed[row + r + 1, col + c + 1]
            if weight < toll[r, c] and weight < np.inf:
                packed[row + r + 1, col + c + 1] = toll[r, c]


@njit(cache=True)
def _open(  # noqa: PLR0917  # a kernel takes plain arguments
    packed: Floats32,
    clearance: Floats32,
    walls: Floats32,
    radius: float,
    start: tuple[int, int],
    cells: int,
    dear: float,
) -> None:
    """Open what is blocked and joined to the start: near it, or closed by the rule that it is in.

    Near is within ``cells`` and no nearer to walls and zones than the start is.
    """
    row, col = start
    ruled = clearance[row, col] < walls[row, col]
    stack = [(row, col)]
    packed[row + 1, col + 1] = dear
    while len(stack) > 0:
        r0, c0 = stack.pop()
        for r in range(max(r0 - 1, 0), min(r0 + 2, walls.shape[0])):
            for c in range(max(c0 - 1, 0), min(c0 + 2, walls.shape[1])):
                if packed[r + 1, c + 1] < np.inf:
                    continue
                near = (r - row) ** 2 + (c - col) ** 2 <= cells * cells
                roomy = walls[r, c] >= walls[row, col] and clearance[r, c] >= clearance[row, col]
                if (near and roomy) or (ruled and walls[r, c] > radius):
                    packed[r + 1, c + 1] = dear
                    stack.append((r, c))
