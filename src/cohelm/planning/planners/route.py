"""Steps that all grid planners share: from a prepared problem and a search to a path.

A missing path is explained by the tightest passage, or by the rule that closes all paths.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import field

import cv2
import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Floats32, Integers, Shape, value
from cohelm.errors import NoPath, Passage
from cohelm.geometry import arc_length, inverse, resample, transform
from cohelm.messages import Path
from cohelm.planning.api import GlobalPlanner, RouteProblem
from cohelm.planning.costmap.patch import INSCRIBED
from cohelm.planning.grid_search.shortest_path import shortest_path
from cohelm.planning.grid_search.weights import BLOCKED, GridPath, Weights, path_cost
from cohelm.planning.path_refinement.footprint_refinement import (
    RefinementParameters,
    block_passage,
    manoeuvre,
    refine,
    search_whole_map,
)
from cohelm.planning.path_refinement.local_repair import RefinedLine
from cohelm.planning.path_refinement.shortening import line_cost
from cohelm.planning.path_refinement.waypoint_chaining import PLACE, PoseBudget
from cohelm.planning.planners.wishes import report_wishes
from cohelm.planning.problem import (
    CostmapParameters,
    PreparedProblem,
    as_pair,
    avoided_zones,
    prepare,
)

_NARROW = 100.0
"""Weight of a cell without clearance, and in proportion to the missing clearance elsewhere: a door
that is a tenth too narrow is worth a detour of ten times its depth."""


def no_path(
    prepared: PreparedProblem, parameters: CostmapParameters, stuck: Sequence[Floats] = ()
) -> NoPath:
    """Create the error that explains why no path was found.

    Args:
        prepared: the problem.
        parameters: of the planner.
        stuck: points (2,) where the footprint cannot follow a path that is wide enough for its
            inscribed circle, grid's frame, m, the best path first; empty if there is none. The
            first that is really too narrow is named.
    """
    problem = prepared.problem
    because, passage = "", None
    end = _end_at(prepared, stuck[0]) if stuck else None
    if end is not None:
        because = f"the walls around the {end}"
    elif stuck:
        bends = [_bend(prepared, each) for each in stuck]
        passage = next((each for each in bends if each.width < each.needed), bends[0])
    elif closed_by_zones(prepared, parameters):
        because = "the zones to avoid"
    elif closed_by_keepout(prepared, parameters):
        because = "the keepout zones"
    else:
        passage = tightest_passage(prepared)
    return NoPath(
        start=as_pair(problem.start),
        goal=as_pair(problem.goal),
        needed=prepared.costmap.radius,
        passage=passage,
        because=because,
    )


def closed_by_zones(prepared: PreparedProblem, parameters: CostmapParameters) -> bool:
    """Check that a path exists without the hard zones to avoid; searches once more."""
    problem = prepared.problem
    if not any(wish.hard for wish in avoided_zones(problem)):
        return False
    wishes = tuple(w for w in problem.wishes if not (w.kind == "avoid" and w.hard))
    return _is_connected(dataclasses.replace(problem, wishes=wishes), parameters)


def closed_by_keepout(prepared: PreparedProblem, parameters: CostmapParameters) -> bool:
    """Check that a path exists without the keepout masks; searches once more."""
    if not any(f.type == "keepout" for f in prepared.problem.filters):
        return False
    return _is_connected(dataclasses.replace(prepared.problem, filters=()), parameters)


def _is_connected(problem: RouteProblem, parameters: CostmapParameters) -> bool:
    """Check that a path leads from the problem's start to its goal."""
    prepared = prepare(problem, parameters)
    return shortest_path(prepared.weights, prepared.start, prepared.goal) is not None


def tightest_passage(prepared: PreparedProblem) -> Passage | None:
    """Tightest passage on the path that would be best if it were wide enough.

    Narrow cells cost more, in proportion to the missing clearance. None if walls leave no path at
    all, or the path is nowhere too narrow.
    """
    walls, radius = prepared.costmap.walls, prepared.costmap.radius
    missing = np.clip(1.0 - walls / max(radius, 1e-6), 0.0, 1.0)
    weights = (1.0 + _NARROW * missing).astype(np.float32)
    weights[walls <= 0.0] = np.inf
    found = shortest_path(Weights.of(weights), prepared.start, prepared.goal)
    if found is None:
        return None
    clearance = walls[found.cells[:, 0], found.cells[:, 1]]
    at = _pinch(clearance)
    if clearance[at] > radius:
        return None
    ahead = found.cells[min(at + 3, len(clearance) - 1)] - found.cells[max(at - 3, 0)]
    return _passage(prepared, found.cells[at], np.arctan2(*ahead.astype(float)), turns=False)


def _bend(prepared: PreparedProblem, stuck: Floats) -> Passage:
    """Passage that is wide enough, but where the robot cannot turn."""
    cell = np.floor(stuck[::-1] / prepared.problem.grid.resolution).astype(np.int64)
    return _passage(prepared, cell, None, turns=True)


def _end_at(prepared: PreparedProblem, stuck: Floats) -> str | None:
    """``start`` or ``goal`` if a point (2,) in the grid's frame is that end; else None."""
    point = transform(prepared.problem.grid.X_MG, stuck)
    for name, end in (("start", prepared.problem.start), ("goal", prepared.problem.goal)):
        if np.hypot(*(point - end)) < 1e-6:
            return name
    return None


def _passage(
    prepared: PreparedProblem, cell: Integers, along: float | None, *, turns: bool
) -> Passage:
    problem = prepared.problem
    res, robot = problem.grid.resolution, problem.robot
    middle, width = gap_at(prepared.costmap.walls, res, cell, along, 2.0 * prepared.costmap.radius)
    return Passage(
        point=as_pair(transform(problem.grid.X_MG, middle)),
        width=width,
        needed=2.0 * (robot.circumscribed_radius if turns else prepared.costmap.radius),
        resolution=res,
        turns=turns,
        clearance=0.0 if turns else problem.clearance,
    )


def gap_at(
    walls: Floats32, resolution: float, cell: Integers, along: float | None, reach: float
) -> tuple[Floats, float]:
    """(midpoint (2,), width) of the gap at a cell, between the surfaces on either side, m.

    The width is the minimum distance between a blocked cell on the left and one on the right, each
    within 45° of the perpendicular. If none is near, it is twice the clearance.

    Args:
        walls: distance to physical obstacles, (rows, cols), m; negative inside.
        resolution: of the grid, m.
        cell: (row, column) in the gap.
        along: direction of the path, rad; None: perpendicular to that of the nearest obstacle.
        reach: distance from the cell up to which obstacles are considered, m.
    """
    row, col = (int(i) for i in cell)
    size = math.ceil(reach / resolution)
    r0, c0 = max(row - size, 0), max(col - size, 0)
    window = walls[r0 : row + size + 1, c0 : col + size + 1]
    offset = np.argwhere((window < 0.0) & (window > -1.5 * resolution))
    offset += np.array([r0 - row, c0 - col])
    here = (np.array([col, row]) + 0.5) * resolution
    alone = here, 2.0 * float(walls[row, col])
    if not len(offset):
        return alone
    if along is None:
        nearest = offset[np.argmin((offset**2).sum(axis=1))]
        along = math.atan2(nearest[0], nearest[1]) + 0.5 * math.pi
    tangent = np.array([math.sin(along), math.cos(along)])
    ahead = offset @ tangent
    aside = offset @ np.array([tangent[1], -tangent[0]])
    left = offset[(aside > 0.0) & (np.abs(ahead) <= aside)]
    right = offset[(aside < 0.0) & (np.abs(ahead) <= -aside)]
    if not (len(left) and len(right)):
        return alone
    apart = left[:, None, :] - right[None, :, :]
    gaps = np.hypot(*np.moveaxis(np.maximum(np.abs(apart) - 1.0, 0.0), -1, 0))
    a, b = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
    middle = here + 0.5 * (left[a] + right[b])[::-1] * resolution
    return middle, float(gaps[a, b]) * resolution


def _pinch(clearance: Floats32) -> int:
    """Index in the middle of the longest run of cells with the lowest clearance."""
    least = np.flatnonzero(clearance <= clearance.min() + 1e-6)
    runs = np.split(least, np.flatnonzero(np.diff(least) > 1) + 1)
    longest = max(runs, key=len)
    return int(longest[len(longest) // 2])


GridSearch = Callable[[Weights], GridPath | None]
"""Search for a path over some weights; None if there is none."""

LineScore = Callable[[Floats], float]
"""Objective of a method for a line (k, 2) in the map frame, m; ∞ if the line is blocked."""

_EXIT_WIDTH = 0.2  # m on either side of the path out of a zone that stay open, for a smooth line


class GridPlannerParameters(RefinementParameters):
    """Parameters of every grid planner."""

    max_expansions: int | None = Field(None, ge=1)
    """Budget of the search, cells; None: unlimited."""


def parameters_of(planner: GlobalPlanner) -> GridPlannerParameters:
    """Parameters of a planner; the default ones if it is not a grid planner."""
    parameters = getattr(planner, "parameters", None)
    return parameters if isinstance(parameters, GridPlannerParameters) else GridPlannerParameters()


@value
class DrivableRoute:
    """Path over the grid, refined for the footprint."""

    cost: float
    """Weighted length under the weights of the prepared problem, m."""
    points: Annotated[Floats, Shape("m 2")]
    """Smooth line, map frame, m."""
    cells: Annotated[Integers, Shape("k 2")]
    """(row, column) of the path before refinement."""
    pivots: Annotated[Integers, Shape("p")] = field(
        default_factory=lambda: np.empty(0, dtype=np.int64)
    )
    """Indices of the points where the robot turns on the spot."""
    cusps: Annotated[Integers, Shape("c")] = field(
        default_factory=lambda: np.empty(0, dtype=np.int64)
    )
    """Indices of the points where it changes its gear."""
    backs_out: bool = False
    """The first stretch is driven backwards."""


def find_route(
    prepared: PreparedProblem,
    parameters: GridPlannerParameters,
    weights: Weights | None = None,
    search: GridSearch | None = None,
) -> DrivableRoute:
    """Find the best path that the footprint can follow.

    If the footprint does not pass on the best path, that passage is blocked and another path is
    searched, a few times for each place; then the first path is driven in both gears, and at last
    hybrid A* searches the whole map. The cost is that under the weights of the prepared problem.
    The path leaves a zone that contains the start and does not enter it again.

    Args:
        prepared: the problem.
        parameters: of the planner.
        weights: for the search; those of the problem if None. They block at least the same cells.
        search: the cheapest path if None.

    Raises:
        PlanningError: NoPath or PlanningTimeout.
    """
    weights = prepared.weights if weights is None else weights
    search = search or cheapest_search(prepared, parameters)
    budget = PoseBudget(round(prepared.problem.effort * parameters.refinement.budget))
    stuck: list[Floats] = []
    first: tuple[GridPath, RefinedLine] | None = None
    in_zone = _starts_in_zone(prepared)
    while True:
        found = search(weights)
        if found is not None and in_zone:
            weights, again = _open_exit_only(prepared, weights, found.cells)
            found = search(weights) if again else found
        if found is None:
            break
        fitted = refine(prepared, weights, found, parameters, budget)
        if fitted.stuck is None:
            return _route(prepared, found.cells, manoeuvre(prepared, parameters, fitted))
        tried = sum(np.hypot(*(place - fitted.stuck)) < PLACE for place in stuck)
        stuck.append(fitted.stuck)
        first = first or (found, fitted)
        around = block_passage(prepared, weights, fitted)
        if around is None or tried >= parameters.refinement.detours:
            break
        weights = around
    if first is not None:
        found, fitted = first
        driven = manoeuvre(prepared, parameters, fitted)
        if driven.stuck is None:
            return _route(prepared, found.cells, driven)
        last = search_whole_map(prepared, parameters)
        if last is not None:
            return _route(prepared, _cells_of(prepared, last.points), last)
    raise no_path(prepared, parameters, stuck)


def route_without_wishes(
    prepared: PreparedProblem,
    parameters: GridPlannerParameters,
    plain: DrivableRoute | None = None,
) -> DrivableRoute:
    """Find the route without any wish, at its cost without them.

    Args:
        prepared: the problem.
        parameters: of the planner.
        plain: the cheapest route of the problem, if it is known already.

    Raises:
        PlanningError: NoPath or PlanningTimeout.
    """
    if any(wish.kind == "avoid" for wish in prepared.problem.wishes):
        free = prepare(dataclasses.replace(prepared.problem, wishes=()), parameters)
        return find_route(free, parameters)
    return plain or find_route(prepared, parameters)


def cheapest_search(prepared: PreparedProblem, parameters: GridPlannerParameters) -> GridSearch:
    """Create the search for the cheapest path from start to goal, within the planner's budget."""

    def search(weights: Weights) -> GridPath | None:
        budget = parameters.max_expansions
        return shortest_path(weights, prepared.start, prepared.goal, max_expansions=budget)

    return search


def score_on(prepared: PreparedProblem, weights: Weights) -> LineScore:
    """Create the score of a line that is its weighted length under some weights."""

    def score(points: Floats) -> float:
        line = transform(inverse(prepared.problem.grid.X_MG), points)
        return line_cost(line, weights, prepared.problem.grid.resolution)

    return score


def to_path(
    prepared: PreparedProblem,
    route: DrivableRoute,
    without: DrivableRoute,
    *,
    method: str,
) -> Path:
    """Convert ``route`` to a ``Path`` that reports the effect of the wishes.

    Args:
        prepared: the problem with the wishes.
        route: the route taken.
        without: the route without attracting wishes; may be ``route``.
        method: the planner's name.
    """
    length = float(arc_length(route.points)[-1])
    wishes = report_wishes(
        prepared.problem,
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
        pivots=route.pivots,
        cusps=route.cusps,
        backs_out=route.backs_out,
    )


def _starts_in_zone(prepared: PreparedProblem) -> bool:
    """Check that a rule, not an obstacle, closes the start."""
    costmap = prepared.costmap
    return bool(costmap.clearance[prepared.start] <= costmap.radius < costmap.walls[prepared.start])


def _open_exit_only(
    prepared: PreparedProblem, weights: Weights, cells: Integers
) -> tuple[Weights, bool]:
    """(weights with closed zones open along the exit only, True if the path enters a zone again).

    Args:
        prepared: a problem whose start is in a zone.
        weights: those of the search, in which the zone around the start is open.
        cells: the path (k, 2).
    """
    closed = prepared.costmap.cost >= INSCRIBED
    inside = closed[cells[:, 0], cells[:, 1]]
    left = int(np.argmin(inside)) if not inside.all() else len(cells)
    out = np.zeros(closed.shape, dtype=np.uint8)
    width = max(2 * round(_EXIT_WIDTH / prepared.costmap.grid.resolution) + 1, 3)
    cv2.polylines(out, [cells[: left + 1, ::-1].astype(np.int32)], False, 1, thickness=width)
    packed = weights.packed.copy()
    packed[1:-1, 1:-1][closed & (out == 0)] = BLOCKED
    packed.flags.writeable = False
    narrowed = Weights(packed=packed, lightest=weights.lightest, heaviest=weights.heaviest)
    return narrowed, bool(inside[left:].any())


def _route(prepared: PreparedProblem, cells: Integers, fitted: RefinedLine) -> DrivableRoute:
    """Route of a line in the grid's frame, from the exact start to the exact goal."""
    problem = prepared.problem
    line = transform(problem.grid.X_MG, fitted.points)
    line[0], line[-1] = problem.start, problem.goal
    line.flags.writeable = False
    cost = path_cost(prepared.weights.packed, np.array(cells)) * problem.grid.resolution
    if not np.isfinite(cost):  # a line between cells may lie in a blocked cell
        cost = prepared.weights.heaviest * float(arc_length(line)[-1])
    return DrivableRoute(
        cost=cost,
        points=line,
        cells=cells,
        pivots=fitted.pivots,
        cusps=fitted.cusps,
        backs_out=fitted.backs_out,
    )


def _cells_of(prepared: PreparedProblem, points: Floats) -> Integers:
    """Cells (k, 2) that a line in the grid's frame passes."""
    res = prepared.problem.grid.resolution
    cells: Integers = np.floor(resample(points, 0.5 * res)[:, ::-1] / res).astype(np.int64)
    new = np.concatenate([[True], np.diff(cells, axis=0).any(axis=1)])
    return np.ascontiguousarray(cells[new])
