"""From a way over cells to a line for the robot's true shape, and what to do where it is stuck."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers, lazy_copy
from cohelm.config import Model
from cohelm.geometry import inverse, transform
from cohelm.planning.chaining import Effort, all_round
from cohelm.planning.footprint import body_on, widened
from cohelm.planning.ground import Ground, GroundParameters
from cohelm.planning.land import Land, misfits, stands
from cohelm.planning.repairing import Fitted, fit, widen
from cohelm.planning.rings import ring_in, turns_back
from cohelm.planning.search import BLOCKED, GridPath, Weights
from cohelm.planning.smoothing import Smoothing, smooth
from cohelm.planning.turning import turn_through
from cohelm.robots import Robot

_GROWN = 0.006
"""The search over (x, y, heading) takes the footprint for so much larger on each side, m: it drives
arcs, and the path's chords cut them by some millimetres."""


_FEWER = 8  # pins at most that are given up for a line without rings
_WIDENING = 3_000  # poses looked at to keep the clearance asked for
_BESIDE = 1.0  # m from a pin that trouble is its doing

_NONE = np.empty(0, dtype=np.int64)


class Fitting(Model):
    """How hard a way for the footprint is looked for; assumed."""

    budget: int = Field(12_000, ge=1, le=10_000_000)
    """Poses looked at on all ways together, where smooth lines do not fit."""
    detours: int = Field(4, ge=0, le=100)
    """Times that another way is sought where the footprint does not pass."""
    last_budget: int = Field(8_000, ge=1, le=10_000_000)
    """Poses looked at over the whole map, where no such way was found."""


class LineParameters(GroundParameters):
    """How a way over cells becomes a line; the figures are assumed."""

    wanted_clearance: float | None = Field(None, ge=0.0, le=10.0)
    """Smoothing may come this near to obstacles and no nearer, unless the way did, m. None: the
    inflation radius, so that the line stays where the way has paid to be."""
    wanted_gap: float = Field(0.1, ge=0.0, le=5.0)
    """Gap that is kept on either side of the robot where the way leaves as much, m: so doors are
    passed straight rather than aslant."""
    smoothing: Smoothing = Smoothing()
    fitting: Fitting = Fitting()

    @property
    def wanted(self) -> float:
        """``wanted_clearance``, or what stands for it, m."""
        if self.wanted_clearance is None:
            return self.inflation.inflation_radius
        return self.wanted_clearance


def fit_way(
    ground: Ground, weights: Weights, found: GridPath, parameters: LineParameters, effort: Effort
) -> Fitted:
    """A way over some weights as a smooth line that the footprint can follow, grid's frame.

    Where a pin makes it go round in a ring, or get stuck, it need not be passed; and where the gap
    that is wanted leads it to where it gets stuck, that is not sought.
    """
    res = ground.problem.grid.resolution
    ends = _ends(ground)
    inner = (found.cells[1:-1, ::-1] + 0.5) * res
    way = np.concatenate([ends[:1], inner, ends[1:]])
    if len(way) == 2 and bool((way[0] == way[1]).all()):
        return Fitted(points=way, pivots=_NONE)
    pins = found.pins[(found.pins > 0) & (found.pins < len(way) - 1)]
    fitted = _fitted(ground, weights, parameters, way, pins, effort)
    if fitted.stuck is not None and parameters.wanted_gap > 0.0:
        closer = parameters.model_copy(update={"wanted_gap": 0.0})
        other = _fitted(ground, weights, closer, way, pins, effort)
        if other.stuck is None:
            fitted = other
    for _ in range(_FEWER):
        troubled = _troubled(ground.problem.robot, way[pins], fitted)
        if not troubled.any():
            break
        pins = np.delete(pins, _least_of(way[pins], troubled))
        other = _fitted(ground, weights, parameters, way, pins, effort)
        if other.stuck is None:
            fitted = other
    return fitted


def _fitted(
    ground: Ground,
    weights: Weights,
    parameters: LineParameters,
    way: Floats,
    pins: Integers,
    effort: Effort,
) -> Fitted:
    """The line along a way (k, 2) that passes some of its points."""
    problem, radius = ground.problem, ground.costmap.radius
    robot, gap = problem.robot, problem.clearance
    line = smooth(
        way,
        weights,
        ground.costmap.clearance,
        problem.grid.resolution,
        needed=radius,
        wanted=max(parameters.wanted, radius),
        kept=radius + parameters.wanted_gap,
        smoothing=parameters.smoothing,
        curvature=robot.max_curvature,
        pins=pins,
    )
    land = _land(ground, weights, parameters)
    tight = ground.costmap.walls[ground.start] <= radius
    forgiven = 2.0 * robot.circumscribed_radius if tight else 0.0
    if not (forgiven or stands(land, *line[0])):
        return Fitted(points=line, pivots=_NONE, stuck=line[0])
    if not stands(land, *line[-1]):
        return Fitted(points=line, pivots=_NONE, stuck=line[-1])
    pivots = _NONE if robot.minimum_turning_radius is not None else turns_back(line)
    fitted = Fitted(points=line, pivots=pivots)
    wide = tuple(
        _land(ground, weights, parameters, wider=gap + share * parameters.wanted_gap)
        for share in (1.0, 0.5)
        if parameters.wanted_gap > 0.0
    )
    if gap > 0.0:
        roomy = _land(ground, weights, parameters, wider=gap)
        spare = Effort(round(problem.effort * _WIDENING))
        fitted = widen(roomy, fitted, pins=way[pins], effort=spare, wide=wide[1:])
    return fit(
        land,
        fitted.points,
        pins=way[pins],
        effort=effort,
        pivots=fitted.pivots,
        wide=wide,
        forgiven=forgiven,
    )


def _troubled(robot: Robot, pins: Floats, fitted: Fitted) -> Booleans:
    """Which pins (p, 2) the line is stuck at or makes a ring by."""
    if fitted.stuck is not None:
        places = fitted.stuck[None]
    elif robot.minimum_turning_radius is not None:
        places = np.empty((0, 2))  # it has no other way to turn
    else:
        first, last = ring_in(fitted.points, fitted.pivots)
        places = fitted.points[first : last + 1] if first >= 0 else np.empty((0, 2))
    if not len(places) or not len(pins):
        return np.zeros(len(pins), dtype=np.bool_)
    near: Booleans = np.hypot(*(pins[:, None] - places).T).min(axis=0) < _BESIDE
    return near


def _least_of(pins: Floats, troubled: Booleans) -> int:
    """Which of the troubled pins (p, 2) is missed least: that with another one nearest to it."""
    apart = np.hypot(*(pins[:, None] - pins).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    return int(np.nanargmin(np.where(troubled, apart.min(axis=1), np.nan)) if len(pins) > 1 else 0)


def fit_anyhow(ground: Ground, parameters: LineParameters) -> Fitted | None:
    """A way by the search over (x, y, heading) alone; None where its budget shows none."""
    land = _land(ground, ground.weights, parameters)
    start, goal = (np.array([*end, math.nan]) for end in _ends(ground))
    if not (stands(land, *start[:2]) and stands(land, *goal[:2])):
        return None
    turned, _ = turn_through(
        land,
        all_round(start),
        goal,
        reach=math.inf,
        pivots=True,
        budget=max(round(ground.problem.effort * parameters.fitting.last_budget), 1),
    )
    if turned is None or misfits(land, turned.points, turned.pivots).any():
        return None
    return Fitted(points=turned.points, pivots=turned.pivots)


def without_passage(ground: Ground, weights: Weights, fitted: Fitted) -> Weights | None:
    """The weights with the place closed where a line is stuck, from wall to wall.

    None where that would close start or goal.
    """
    stuck, res = fitted.stuck, ground.problem.grid.resolution
    if stuck is None:
        return None
    row, col = (int(i) for i in np.floor(stuck[::-1] / res))
    clearance = ground.costmap.clearance
    radius = max(float(clearance[row, col]), ground.costmap.radius) / res + 1.5
    size = math.ceil(radius)
    rows = np.arange(max(row - size, 0), min(row + size + 1, clearance.shape[0]))
    cols = np.arange(max(col - size, 0), min(col + size + 1, clearance.shape[1]))
    disc = (rows[:, None] - row) ** 2 + (cols - col) ** 2 <= radius * radius
    packed = lazy_copy(weights.packed)
    window = packed[rows[0] + 1 : rows[-1] + 2, cols[0] + 1 : cols[-1] + 2]
    window[disc] = BLOCKED
    packed.flags.writeable = False
    ends = (ground.start, ground.goal)
    if any(packed[r + 1, c + 1] == BLOCKED for r, c in ends):
        return None
    return Weights(packed=packed, lightest=weights.lightest, heaviest=weights.heaviest)


def _ends(ground: Ground) -> Floats:
    """Start and goal (2, 2) in the grid's frame, m."""
    problem = ground.problem
    return transform(inverse(problem.grid.X_MG), np.stack([problem.start, problem.goal]))


def _land(
    ground: Ground, weights: Weights, parameters: LineParameters, *, wider: float = 0.0
) -> Land:
    """The ground for the footprint, or for one that is wider on every side, m."""
    costmap, problem = ground.costmap, ground.problem
    outline, res = widened(problem.robot.outline, wider), problem.grid.resolution
    larger = outline * (1.0 + _GROWN * problem.robot.max_curvature)
    # What the sensors see is known as far as it inflates, the map everywhere.
    known = parameters.inflation.reach(costmap.radius)
    trust = math.inf if problem.live is None else known
    return Land(
        body=body_on(outline, costmap.walls, res, trust),
        grown=body_on(larger, costmap.walls, res, trust),
        weights=weights.packed,
        heaviest=weights.heaviest,
        clearance=costmap.clearance,
        floor=costmap.radius + 0.003,  # chords cut into arcs by that
        radius=costmap.radius,
        curvature=problem.robot.max_curvature,
    )
