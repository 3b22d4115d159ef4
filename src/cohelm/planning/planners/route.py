"""Steps that all grid planners share: from a prepared problem and a search to a path."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import field

import cv2
import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.geometry import arc_length, inverse, resample, transform
from cohelm.messages import Path
from cohelm.planning.api import GlobalPlanner
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
from cohelm.planning.planners.passages import no_path
from cohelm.planning.planners.wishes import report_wishes
from cohelm.planning.problem import PreparedProblem, prepare

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
    score: LineScore | None = None,
) -> Path:
    """Convert ``route`` to a ``Path`` that reports the effect of the wishes.

    Args:
        prepared: the problem with the wishes.
        route: the route taken.
        without: the route without attracting wishes; may be ``route``.
        method: the planner's name.
        score: objective of the method; the weighted length under the problem's weights if None.
    """
    score = score or score_on(prepared, prepared.weights)
    previous = prepared.problem.previous_path
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
        score=score(route.points),
        previous_score=score(previous) if previous is not None else None,
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
