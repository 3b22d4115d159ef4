"""From a way over cells to a line for the robot's true shape, and what to do where it is stuck."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, lazy_copy
from cohelm.config import Model
from cohelm.geometry import inverse, transform
from cohelm.planning.footprint import body_on
from cohelm.planning.ground import Ground, GroundParameters
from cohelm.planning.land import Land, misfits, stands
from cohelm.planning.repairing import Effort, Fitted, all_round, fit
from cohelm.planning.search import BLOCKED, GridPath, Weights
from cohelm.planning.smoothing import Smoothing, smooth
from cohelm.planning.turning import turn_through

_GROWN = 0.006
"""The search over (x, y, heading) takes the footprint for so much larger on each side, m: it drives
arcs, and the path's chords cut them by some millimetres."""


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
    """A way over some weights as a smooth line that the footprint can follow, grid's frame."""
    res = ground.problem.grid.resolution
    ends = _ends(ground)
    inner = (found.cells[1:-1, ::-1] + 0.5) * res
    way = np.concatenate([ends[:1], inner, ends[1:]])
    if len(way) == 2 and bool((way[0] == way[1]).all()):
        return Fitted(points=way, pivots=_NONE)
    pins = found.pins[(found.pins > 0) & (found.pins < len(way) - 1)]
    radius = ground.costmap.radius
    land = _land(ground, weights, parameters)
    line = smooth(
        way,
        weights,
        ground.costmap.clearance,
        res,
        needed=radius,
        wanted=max(parameters.wanted, radius),
        smoothing=parameters.smoothing,
        curvature=land.curvature,
        pins=pins,
    )
    tight = ground.costmap.walls[ground.start] <= radius
    forgiven = 2.0 * ground.problem.robot.circumscribed_radius if tight else 0.0
    if not (forgiven or stands(land, *line[0])):
        return Fitted(points=line, pivots=_NONE, stuck=line[0])
    if not stands(land, *line[-1]):
        return Fitted(points=line, pivots=_NONE, stuck=line[-1])
    return fit(land, line, pins=way[pins], effort=effort, forgiven=forgiven)


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
        budget=parameters.fitting.last_budget,
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


def _land(ground: Ground, weights: Weights, parameters: LineParameters) -> Land:
    costmap, problem = ground.costmap, ground.problem
    outline, res = problem.robot.outline, problem.grid.resolution
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
