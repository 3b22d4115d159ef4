"""Prepared planning problem: costmap, weights and checked ends, independent of the method."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Floats32, lazy_copy, value
from cohelm.config import Model
from cohelm.errors import GoalBlocked, InvalidProblem, OutsideMap, StartBlocked
from cohelm.kernels import CACHED
from cohelm.maps import MAX_COORDINATE, CostmapFilter
from cohelm.messages import Crowding, Wish
from cohelm.planning.api import RouteProblem
from cohelm.planning.costmap.costmap import Costmap, build_costmap
from cohelm.planning.costmap.layers.inflation import Inflation
from cohelm.planning.costmap.layers.people import (
    CrowdingCosts,
    GroupCosts,
    crowding_patches,
    group_patch,
)
from cohelm.planning.costmap.layers.zones import ZoneCosts, distance_to_zone, zone_patch
from cohelm.planning.costmap.patch import INSCRIBED, MAX_GRADED, Patch
from cohelm.planning.grid_search.weights import BLOCKED, Weights, pack_costs


class CostmapParameters(Model):
    """Parameters of the costmap and its weights; assumed."""

    inflation: Inflation = Inflation()
    zones: ZoneCosts = ZoneCosts()
    crowding: CrowdingCosts = CrowdingCosts()
    groups: GroupCosts = GroupCosts()
    cost_weight: float = Field(4.0, ge=0.0, le=1000.0)
    """Weight of a cell is 1 + cost_weight · cost / 252: a metre beside a wall counts as at most
    1 + cost_weight free metres."""


@value
class PreparedProblem:
    """Problem with everything that does not depend on the method."""

    problem: RouteProblem
    costmap: Costmap
    """All layers except attracting wishes and strokes."""
    weights: Weights
    """Weights of the costmap, opened around a start that is too close to an obstacle."""
    start: tuple[int, int]
    """(row, column)."""
    goal: tuple[int, int]
    """(row, column)."""


def prepare(problem: RouteProblem, parameters: CostmapParameters) -> PreparedProblem:
    """Check a problem and compute its costmap, weights and end cells.

    Cells are blocked if the robot's inscribed circle with the problem's clearance does not fit.

    Raises:
        PlanningError: OutsideMap, StartBlocked, GoalBlocked or InvalidProblem.
    """
    check_problem(problem)
    costmap = costmap_for(problem, parameters)
    start, goal = _ends(problem, costmap)
    weights = weigh(costmap, start, parameters)
    return PreparedProblem(
        problem=problem, costmap=costmap, weights=weights, start=start, goal=goal
    )


def costmap_for(problem: RouteProblem, parameters: CostmapParameters) -> Costmap:
    """Costmap of a problem: map, keepout masks, live obstacles, zones, crowding and groups.

    Cells are blocked if the robot's inscribed circle with the problem's clearance does not fit.
    """
    radius = problem.robot.inscribed_radius + problem.clearance
    grid, inflation = problem.grid, parameters.inflation
    layers: list[Patch | None] = [
        zone_patch(wish, grid, radius, inflation, parameters.zones)
        for wish in avoided_zones(problem)
    ]
    layers.extend(group_patch(outline, grid, parameters.groups) for outline in problem.groups)
    if problem.crowding is not None:
        layers.extend(crowding_patches(problem.crowding, grid, parameters.crowding))
    return build_costmap(
        grid,
        radius,
        inflation,
        problem.live,
        filters=problem.filters,
        patches=[patch for patch in layers if patch is not None],
    )


def weight_table(cost_weight: float) -> Floats32:
    """Weights (256,) of Nav2's costs: 1 + cost_weight · cost / 252, blocked from 253."""
    table = np.full(256, BLOCKED, dtype=np.float32)
    table[:INSCRIBED] = 1.0 + cost_weight * np.arange(INSCRIBED) / MAX_GRADED
    return table


def weigh(costmap: Costmap, start: tuple[int, int], parameters: CostmapParameters) -> Weights:
    """Weights of the costmap with its extra costs, opened around a start in a blocked cell.

    A chair may have stopped close to a wall. Cells within a metre that are no closer to obstacles
    than the start are opened with the highest weight, so that the path leaves them soon. So are the
    cells of the zone, by a keepout mask or a hard wish, that contains the start.

    The weights of a cached costmap are cached too; with patches, only their windows are updated.
    """
    table = weight_table(parameters.cost_weight)
    if costmap.base is None:
        weights = Weights.of_costs(costmap.cost, table)
    else:
        weights = _base_weights(costmap.base, parameters.cost_weight)
    blocked = costmap.cost[start] >= INSCRIBED
    if not (blocked or costmap.patches):
        return weights
    packed = lazy_copy(weights.packed)
    heaviest = weights.heaviest
    if costmap.base is not None:
        for patch in costmap.patches:
            window = np.ascontiguousarray(costmap.cost[patch.rows, patch.cols])
            window.flags.writeable = False
            pack_costs(window, table, packed, patch.rows.start, patch.cols.start)
    for patch in costmap.patches:
        if patch.extra_cost is not None:
            heaviest = max(heaviest, float(patch.extra_cost.max()))
            _add_extra_cost(patch.extra_cost, packed, patch.rows.start, patch.cols.start)
    if blocked:
        heaviest *= 2.0
        cells = math.ceil(1.0 / costmap.grid.resolution)
        _open_around_start(
            packed, costmap.clearance, costmap.walls, costmap.radius, start, cells, heaviest
        )
    packed.flags.writeable = False
    return Weights(packed=packed, lightest=weights.lightest, heaviest=heaviest)


@lru_cache(maxsize=2)
def _base_weights(costmap: Costmap, cost_weight: float) -> Weights:
    return Weights.of_costs(costmap.cost, weight_table(cost_weight))


def _ends(problem: RouteProblem, costmap: Costmap) -> tuple[tuple[int, int], tuple[int, int]]:
    """Cells of start and goal, checked to be free."""
    grid = problem.grid
    for what, point in (("start", problem.start), ("goal", problem.goal)):
        if not (np.isfinite(point).all() and bool(grid.contains(point))):
            raise OutsideMap(what=what, point=as_pair(point), bounds=grid.bounds)
    start, goal = grid.cells(problem.start), grid.cells(problem.goal)
    # Map and localisation have errors of a cell, so a chair beside a wall may seem a cell too close
    # to it. An obstacle deeper in its inscribed circle blocks the start.
    clearance = float(costmap.walls[start[0], start[1]])
    if clearance < problem.robot.inscribed_radius - grid.resolution:
        needed = problem.robot.inscribed_radius
        raise StartBlocked(point=as_pair(problem.start), clearance=clearance, needed=needed)
    if costmap.cost[goal[0], goal[1]] >= INSCRIBED:
        rule = _rule_at_goal(problem, costmap, (int(goal[0]), int(goal[1])))
        gaps = costmap.clearance if rule else costmap.walls
        raise GoalBlocked(
            point=as_pair(problem.goal),
            clearance=float(gaps[goal[0], goal[1]]),
            needed=costmap.radius,
            because=rule,
        )
    return (int(start[0]), int(start[1])), (int(goal[0]), int(goal[1]))


def _rule_at_goal(problem: RouteProblem, costmap: Costmap, goal: tuple[int, int]) -> str:
    """Name of the rule that closes the goal; empty if an obstacle does."""
    if costmap.walls[goal] <= costmap.radius:
        return ""
    nearest = min(
        (distance_to_zone(wish, problem.goal) for wish in avoided_zones(problem) if wish.hard),
        default=math.inf,
    )
    reached = nearest <= costmap.radius + problem.grid.resolution
    return "a zone to avoid" if reached else "a keepout zone"


def avoided_zones(problem: RouteProblem) -> tuple[Wish, ...]:
    """Wishes to avoid a zone, hard or soft."""
    return tuple(wish for wish in problem.wishes if wish.kind == "avoid" and len(wish.points))


def as_pair(point: Floats) -> tuple[float, float]:
    """Point (2,) as plain numbers, for errors."""
    return float(point[0]), float(point[1])


@njit(**CACHED)
def _add_extra_cost(extra_cost: Floats32, packed: Floats32, row: int, col: int) -> None:
    """Raise passable packed weights to the extra cost of a window that begins at (row, col)."""
    for r in range(extra_cost.shape[0]):
        for c in range(extra_cost.shape[1]):
            weight = packed[row + r + 1, col + c + 1]
            if weight < extra_cost[r, c] and weight < np.inf:
                packed[row + r + 1, col + c + 1] = extra_cost[r, c]


@njit(**CACHED)
def _open_around_start(
    packed: Floats32,
    clearance: Floats32,
    walls: Floats32,
    radius: float,
    start: tuple[int, int],
    cells: int,
    weight: float,
) -> None:
    """Open blocked cells that are connected to the start and near it, or in the same zone.

    Near means within ``cells`` and no closer to walls and zones than the start.
    """
    row, col = start
    ruled = clearance[row, col] < walls[row, col]
    stack = [(row, col)]
    packed[row + 1, col + 1] = weight
    while len(stack) > 0:
        r0, c0 = stack.pop()
        for r in range(max(r0 - 1, 0), min(r0 + 2, walls.shape[0])):
            for c in range(max(c0 - 1, 0), min(c0 + 2, walls.shape[1])):
                if packed[r + 1, c + 1] < np.inf:
                    continue
                near = (r - row) ** 2 + (c - col) ** 2 <= cells * cells
                clear = walls[r, c] >= walls[row, col] and clearance[r, c] >= clearance[row, col]
                if (near and clear) or (ruled and walls[r, c] > radius):
                    packed[r + 1, c + 1] = weight
                    stack.append((r, c))


def check_problem(problem: RouteProblem) -> None:
    """Refuse a problem with invalid numbers; start and goal are checked with the map.

    Raises:
        PlanningError: OutsideMap if a point of a wish is not finite or farther than
            ``MAX_COORDINATE``, though it may lie off the map; InvalidProblem for other numbers that
            are not finite, or are negative.
    """
    for wish in problem.wishes:
        _check_wish(wish, problem)
    _require(_is_length(problem.clearance), f"the clearance is {problem.clearance}")
    if problem.wish_origin is not None:
        _require(_are_coordinates(problem.wish_origin), "the origin of the wishes is not a point")
    for outline in problem.groups:
        _require(_are_coordinates(outline), "a group has invalid points")
    if problem.crowding is not None:
        _check_crowding(problem.crowding)
    for each in problem.filters:
        _check_filter(each)


def _check_wish(wish: Wish, problem: RouteProblem) -> None:
    for point in wish.points:
        if not _are_coordinates(point):
            where = (float(point[0]), float(point[1]))
            raise OutsideMap(what=f"wish ({wish.kind})", point=where, bounds=problem.grid.bounds)
    _require(_is_length(wish.radius), f"the radius of a wish is {wish.radius}")


def _check_crowding(crowding: Crowding) -> None:
    _require(_is_size(crowding.resolution), f"crowding has cells of {crowding.resolution} m")
    _require(_are_coordinates(crowding.X_MG), "crowding has an invalid pose")
    _require(bool(np.isfinite(crowding.density).all()), "crowding has a density that is not finite")


def _check_filter(each: CostmapFilter) -> None:
    size, numbers = each.mask.resolution, (each.base, each.multiplier)
    _require(_is_size(size), f"a mask has cells of {size} m")
    _require(_are_coordinates(each.mask.X_MG), "a mask has an invalid pose")
    _require(
        all(map(math.isfinite, numbers)),
        f"a mask has base {numbers[0]} and multiplier {numbers[1]}",
    )


def _require(holds: bool, otherwise: str) -> None:
    if not holds:
        raise InvalidProblem(otherwise)


def _are_coordinates(numbers: Floats) -> bool:
    return bool((np.abs(numbers) <= MAX_COORDINATE).all())


def _is_length(number: float) -> bool:
    return 0.0 <= number <= MAX_COORDINATE


def _is_size(number: float) -> bool:
    return 0.0 < number <= MAX_COORDINATE
