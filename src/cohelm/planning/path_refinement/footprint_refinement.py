"""Footprint refinement: from a path over cells to a line that the robot's footprint can follow."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers, lazy_copy
from cohelm.config import Model
from cohelm.geometry import arc_length, inverse, resample, transform, wrap_angle
from cohelm.maps import DistanceField
from cohelm.planning.grid_search.weights import BLOCKED, GridPath, Weights
from cohelm.planning.path_refinement.configuration_space import (
    ConfigurationSpace,
    fits_at_some_heading,
    infeasible_points,
)
from cohelm.planning.path_refinement.footprint import (
    footprint_model,
    offset_outline,
    overlaps,
)
from cohelm.planning.path_refinement.hybrid_astar import SearchLimits, search_poses
from cohelm.planning.path_refinement.local_repair import RefinedLine, repair, widen_clearance
from cohelm.planning.path_refinement.loops import find_loop, reversal_points
from cohelm.planning.path_refinement.manoeuvres import Manoeuvring, add_manoeuvres
from cohelm.planning.path_refinement.shortening import LineGrid
from cohelm.planning.path_refinement.smoothing import LineLimits, Smoothing, smooth
from cohelm.planning.path_refinement.waypoint_chaining import PoseBudget, all_headings
from cohelm.planning.problem import CostmapParameters, PreparedProblem
from cohelm.robots import Robot
from cohelm.robots.turning_room import must_turn_elsewhere

_GROWN = 0.006
"""Margin of the footprint in the search over (x, y, heading), m, for a curvature of 1/m: the search
drives arcs, and the chords of the path cut them by some millimetres."""

_DROPPED = 8  # waypoints at most that are dropped for a line without loops
_WIDENING = 3_000  # poses expanded at each place to keep the requested clearance
_BESIDE = 1.0  # m from a waypoint within which a problem is attributed to it
_GAPS = (0.08, 0.05, 0.02)
"""Gaps of the footprint in manoeuvres, m: the widest that leaves a path is kept. The last is that
of the local planner's verification."""
_MANOEUVRING, _PART = 16_000, 0.35
"""Poses expanded for the manoeuvres of a line, and the share of them for the next search."""
_MARGIN, _ROUND = 0.03, 12
"""Gap of the capsule, m, which the local planner keeps clear, and corners of each of its ends."""
_ARRIVED = 0.13  # m before the goal, from which a slow chair has arrived
_LOOKAHEAD = 0.5  # m, at which the direction of a line's beginning is taken
_NO_PIVOTS = np.empty(0, dtype=np.int64)


class RefinementBudget(Model):
    """Budgets of the search for a path of the footprint; assumed."""

    budget: int = Field(12_000, ge=1, le=10_000_000)
    """Poses expanded at each place on all paths together, where smooth lines do not fit."""
    detours: int = Field(4, ge=0, le=100)
    """Number of other paths that are tried for each place where the footprint does not pass."""
    last_budget: int = Field(8_000, ge=1, le=10_000_000)
    """Poses expanded over the whole map, if no such path was found."""


class RefinementParameters(CostmapParameters):
    """Parameters of the line that is made from a path over cells; assumed."""

    wanted_clearance: float | None = Field(None, ge=0.0, le=10.0)
    """Clearance that smoothing keeps unless the path was closer to obstacles, m. None: the
    inflation radius, so that the line stays in the corridor of the path."""
    wanted_gap: float = Field(0.1, ge=0.0, le=5.0)
    """Gap on either side of the robot that is kept if the path allows it, m: doors are then passed
    straight rather than at an angle."""
    smoothing: Smoothing = Smoothing()
    refinement: RefinementBudget = RefinementBudget()

    @property
    def wanted(self) -> float:
        """``wanted_clearance`` or its default, m."""
        if self.wanted_clearance is None:
            return self.inflation.inflation_radius
        return self.wanted_clearance


def refine(
    prepared: PreparedProblem,
    weights: Weights,
    found: GridPath,
    parameters: RefinementParameters,
    budget: PoseBudget,
) -> RefinedLine:
    """Refine a path over cells into a smooth line that the footprint can follow, grid's frame.

    A waypoint is dropped if the line makes a loop or gets stuck near it. The wanted gap is dropped
    if the line gets stuck only with it.
    """
    res = prepared.problem.grid.resolution
    ends = _ends(prepared)
    inner = (found.cells[1:-1, ::-1] + 0.5) * res
    path = np.concatenate([ends[:1], inner, ends[1:]])
    if len(path) == 2 and bool((path[0] == path[1]).all()):
        return RefinedLine(points=path, pivots=_NO_PIVOTS)
    waypoints = found.waypoints[(found.waypoints > 0) & (found.waypoints < len(path) - 1)]
    fitted = _fitted(prepared, weights, parameters, path, waypoints, budget)
    if fitted.stuck is not None and parameters.wanted_gap > 0.0:
        closer = parameters.model_copy(update={"wanted_gap": 0.0})
        other = _fitted(prepared, weights, closer, path, waypoints, budget)
        if other.stuck is None:
            fitted = other
    for _ in range(_DROPPED):
        troubled = _troubled(prepared.problem.robot, path[waypoints], fitted)
        if not troubled.any():
            break
        waypoints = np.delete(waypoints, _least_isolated(path[waypoints], troubled))
        other = _fitted(prepared, weights, parameters, path, waypoints, budget)
        if other.stuck is None:
            fitted = other
    return fitted


def _fitted(
    prepared: PreparedProblem,
    weights: Weights,
    parameters: RefinementParameters,
    path: Floats,
    waypoints: Integers,
    budget: PoseBudget,
) -> RefinedLine:
    """Line along a path (k, 2) that passes the points with the indices ``waypoints``."""
    problem, costmap = prepared.problem, prepared.costmap
    robot, gap, radius = problem.robot, problem.clearance, costmap.radius
    grid = LineGrid(weights.packed, costmap.clearance, problem.grid.resolution, radius)
    limits = LineLimits(
        wanted=max(parameters.wanted, radius),
        straight=radius + parameters.wanted_gap,
        curvature=robot.max_curvature,
    )
    line = smooth(path, grid, limits, parameters.smoothing, waypoints)
    space = _space(prepared, weights, parameters)
    # Both ends must be free at some heading, but a start beside a wall is accepted.
    tight = costmap.walls[prepared.start] <= radius
    forgiven = 2.0 * robot.circumscribed_radius if tight else 0.0
    if not (forgiven or fits_at_some_heading(space, *line[0])):
        return RefinedLine(points=line, pivots=_NO_PIVOTS, stuck=line[0])
    if not fits_at_some_heading(space, *line[-1]):
        return RefinedLine(points=line, pivots=_NO_PIVOTS, stuck=line[-1])
    pivots = _NO_PIVOTS if robot.minimum_turning_radius is not None else reversal_points(line)
    fitted = RefinedLine(points=line, pivots=pivots)
    wide = tuple(
        _space(prepared, weights, parameters, wider=gap + share * parameters.wanted_gap)
        for share in (1.0, 0.5)
        if parameters.wanted_gap > 0.0
    )
    if gap > 0.0:
        wider = _space(prepared, weights, parameters, wider=gap)
        spare = PoseBudget(round(problem.effort * _WIDENING))
        fitted = widen_clearance(wider, fitted, path[waypoints], spare, wide=wide[1:])
    return repair(space, fitted, path[waypoints], budget, wide=wide, forgiven=forgiven)


def _troubled(robot: Robot, waypoints: Floats, fitted: RefinedLine) -> Booleans:
    """True for the waypoints (p, 2) near which the line is stuck or makes a loop."""
    if fitted.stuck is not None:
        places = fitted.stuck[None]
    elif robot.minimum_turning_radius is not None:
        places = np.empty((0, 2))  # it cannot turn without a loop
    else:
        first, last = find_loop(fitted.points, fitted.pivots)
        places = fitted.points[first : last + 1] if first >= 0 else np.empty((0, 2))
    if not len(places) or not len(waypoints):
        return np.zeros(len(waypoints), dtype=np.bool_)
    near: Booleans = np.hypot(*(waypoints[:, None] - places).T).min(axis=0) < _BESIDE
    return near


def _least_isolated(waypoints: Floats, troubled: Booleans) -> int:
    """Index of the troubled waypoint (p, 2) that is closest to another one."""
    apart = np.hypot(*(waypoints[:, None] - waypoints).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    if len(waypoints) < 2:
        return 0
    return int(np.nanargmin(np.where(troubled, apart.min(axis=1), np.nan)))


def search_whole_map(
    prepared: PreparedProblem, parameters: RefinementParameters
) -> RefinedLine | None:
    """Path by hybrid A* over the whole map; None if its budget is used up."""
    space = _space(prepared, prepared.weights, parameters)
    start, goal = (np.array([*end, math.nan]) for end in _ends(prepared))
    if not (fits_at_some_heading(space, *start[:2]) and fits_at_some_heading(space, *goal[:2])):
        return None
    budget = max(round(prepared.problem.effort * parameters.refinement.last_budget), 1)
    limits = SearchLimits(reach=math.inf, pivots=True, budget=budget)
    found, _ = search_poses(space, all_headings(start), goal, limits)
    if found is None or infeasible_points(space, found.points, found.pivots).any():
        return None
    return RefinedLine(points=found.points, pivots=found.pivots)


def manoeuvre(
    prepared: PreparedProblem, parameters: RefinementParameters, line: RefinedLine
) -> RefinedLine:
    """Add manoeuvres in both gears where the line is stuck or begins behind the robot.

    Returns the line itself if it needs none, or if none is found.
    """
    problem, costmap = prepared.problem, prepared.costmap
    robot, heading = problem.robot, problem.start_heading - float(problem.grid.X_MG[2])
    behind = False
    if len(line.points) > 1 and not math.isnan(heading):
        start, ahead = line.points[0], resample(line.points, _LOOKAHEAD)[1]
        walls = DistanceField(
            distance=costmap.walls, resolution=problem.grid.resolution, X_MG=np.zeros(3)
        )
        turn = float(wrap_angle(math.atan2(*(ahead - start)[::-1]) - heading))
        behind = must_turn_elsewhere(robot, np.array([*start, heading]), turn, walls)
    if robot.motion_model.translating > 1 or robot.max_reverse_speed <= 0.0:
        return line
    space = partial(_space, prepared, prepared.weights, parameters)
    round_ends = space(_capsule_outline(robot), wider=_MARGIN)
    wrong = np.zeros(len(line.points), dtype=np.bool_)
    spaces = (round_ends, *(space(robot.outline, wider=gap) for gap in _GAPS))
    if line.stuck is not None:
        wrong = infeasible_points(spaces[-1], line.points, line.pivots)
    elif not behind and _touches_at_end(round_ends, line.points):
        wrong[-1], spaces = True, spaces[:1]
    wrong[0] |= behind
    budget = PoseBudget(round(problem.effort * _MANOEUVRING))
    budget.part = _PART
    with_ = Manoeuvring(spaces, robot.minimum_turning_radius is None, budget)
    return add_manoeuvres(line, wrong, heading, with_) or line


def _touches_at_end(space: ConfigurationSpace, points: Floats) -> bool:
    """Check for a goal so close before a wall that the chair cannot arrive there forward."""
    if float(arc_length(points)[-1]) <= _ARRIVED:
        return False
    near, last = resample(points[::-1], _ARRIVED)[1::-1]
    heading = math.atan2(*(last - near)[::-1])
    return bool(overlaps(space.footprint, float(near[0]), float(near[1]), heading))


def block_passage(
    prepared: PreparedProblem, weights: Weights, fitted: RefinedLine
) -> Weights | None:
    """Block the passage where a line is stuck, from wall to wall.

    None if that would block start or goal.
    """
    stuck, res = fitted.stuck, prepared.problem.grid.resolution
    if stuck is None:
        return None
    row, col = (int(i) for i in np.floor(stuck[::-1] / res))
    clearance = prepared.costmap.clearance
    radius = max(float(clearance[row, col]), prepared.costmap.radius) / res + 1.5
    size = math.ceil(radius)
    rows = np.arange(max(row - size, 0), min(row + size + 1, clearance.shape[0]))
    cols = np.arange(max(col - size, 0), min(col + size + 1, clearance.shape[1]))
    disc = (rows[:, None] - row) ** 2 + (cols - col) ** 2 <= radius * radius
    packed = lazy_copy(weights.packed)
    window = packed[rows[0] + 1 : rows[-1] + 2, cols[0] + 1 : cols[-1] + 2]
    window[disc] = BLOCKED
    packed.flags.writeable = False
    ends = (prepared.start, prepared.goal)
    if any(packed[r + 1, c + 1] == BLOCKED for r, c in ends):
        return None
    return Weights(packed=packed, lightest=weights.lightest, heaviest=weights.heaviest)


def _ends(prepared: PreparedProblem) -> Floats:
    """Start and goal (2, 2) in the grid's frame, m."""
    problem = prepared.problem
    return transform(inverse(problem.grid.X_MG), np.stack([problem.start, problem.goal]))


def _capsule_outline(robot: Robot) -> Floats:
    """Corners (k, 2) of the capsule about the robot's discs, counter-clockwise, m."""
    ax, ay, bx, by, radius = robot.capsule
    along = math.atan2(by - ay, bx - ax)
    around = np.linspace(-0.5 * math.pi, 0.5 * math.pi, _ROUND)
    return np.concatenate(
        [
            np.array(end) + radius * np.column_stack([np.cos(angle), np.sin(angle)])
            for end, angle in (((bx, by), along + around), ((ax, ay), along + math.pi + around))
        ]
    )


def _space(
    prepared: PreparedProblem,
    weights: Weights,
    parameters: RefinementParameters,
    outline: Floats | None = None,
    *,
    wider: float = 0.0,
) -> ConfigurationSpace:
    """Configuration space of an outline, None: of the footprint, wider on every side."""
    costmap, problem = prepared.costmap, prepared.problem
    outline = problem.robot.outline if outline is None else outline
    outline, res = offset_outline(outline, wider), problem.grid.resolution
    larger = outline * (1.0 + _GROWN * problem.robot.max_curvature)
    # Clearance from live obstacles is exact up to the inflation distance, that from the map always.
    known = parameters.inflation.reach(costmap.radius)
    trust = math.inf if problem.live is None else known
    return ConfigurationSpace(
        footprint=footprint_model(outline, costmap.walls, res, trust),
        grown=footprint_model(larger, costmap.walls, res, trust),
        weights=weights.packed,
        heaviest=weights.heaviest,
        clearance=costmap.clearance,
        floor=costmap.radius + 0.003,  # chords cut into arcs by that
        radius=costmap.radius,
        curvature=problem.robot.max_curvature,
    )
