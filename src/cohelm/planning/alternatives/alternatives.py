"""Alternative routes: another corridor or door, not another side of a pillar.

With the cost g_s from the start to every cell and the cost g_t from there to the goal, the best
route through a cell v costs g_s(v) + g_t(v). At a local minimum of this sum, the route through v is
locally optimal: it has no unnecessary detour and enters no dead end. So the alternatives are the
routes through such cells away from the known routes, in order of their cost. Each must be short
enough, visit no place twice, share little with the known routes, and have an obstacle larger than a
pillar between (plateaus: Abraham et al., Alternative Routes in Road Networks, 2013). If wishes
attract, routes through the places where the planner's own route meets them come first, and then
routes that meet none.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise

import cv2
import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Booleans, Bytes, Floats, Floats32, Integers, Shape, value
from cohelm.config import Model
from cohelm.errors import NoPath
from cohelm.geometry import arc_length, nearest_on_polyline, resample
from cohelm.kernels import CACHED
from cohelm.messages import Path
from cohelm.planning.alternatives.features import FeatureParameters, RouteFeatures, route_features
from cohelm.planning.api import GlobalPlanner, RouteProblem
from cohelm.planning.costmap.patch import INSCRIBED
from cohelm.planning.grid_search.cost_field import cost_field
from cohelm.planning.grid_search.shortest_path import shortest_path
from cohelm.planning.grid_search.weights import GridPath, Weights
from cohelm.planning.planners.route import GridPlannerParameters, find_route, parameters_of, to_path
from cohelm.planning.planners.wishes import attracting_points, strokes
from cohelm.planning.problem import PreparedProblem, prepare

_SPACING = 0.2  # m between samples of lines


def overlap(a: Floats, b: Floats, corridor: float) -> float:
    """Share of a line's length that lies within ``corridor`` of another; the larger of both.

    Args:
        a, b: lines (k, 2) and (m, 2), m.
        corridor: m.
    """
    a, b = resample(a, _SPACING), resample(b, _SPACING)
    return max(_share_near(a, b, corridor), _share_near(b, a, corridor))


def between(prepared: PreparedProblem, a: Floats, b: Floats) -> float:
    """Length of the largest obstacle between two lines (k, 2) and (m, 2), m; 0 if there is none.

    The length is the longer side of its bounding box. Obstacles are the cells that the centre of
    the inscribed circle cannot enter, so obstacles without a passage between them count as one.
    """
    cost, grid = prepared.costmap.cost, prepared.costmap.grid
    cells = grid.cells(np.concatenate([a, b[::-1]]))
    cells = np.clip(cells, 0, np.array(cost.shape) - 1)
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    enclosed = np.zeros(high - low, dtype=np.uint8)
    cv2.fillPoly(enclosed, [(cells - low)[:, ::-1].astype(np.int32)], 1)
    enclosed &= cost[low[0] : high[0], low[1] : high[1]] >= INSCRIBED
    _, _, boxes, _ = cv2.connectedComponentsWithStats(enclosed)
    sides = boxes[1:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]]
    return float(sides.max(initial=0)) * grid.resolution


@njit(**CACHED)
def comes_back(line: Floats, radius: float) -> bool:
    """Check that a line (k, 2) returns to a place where it has been, with no obstacle between.

    Points closer than twice the blocked radius have no obstacle between them.
    """
    along = np.zeros(line.shape[0])
    for i in range(1, line.shape[0]):
        step = line[i] - line[i - 1]
        along[i] = along[i - 1] + np.hypot(step[0], step[1])
        for j in range(i):
            gap = np.hypot(line[i, 0] - line[j, 0], line[i, 1] - line[j, 1])
            if gap < 1.8 * radius and along[i] - along[j] > 6.0 * radius:
                return True
    return False


@njit(**CACHED)
def _share_near(a: Floats, b: Floats, corridor: float) -> float:
    """Share of the points of ``a`` (k, 2) within ``corridor`` of the line ``b`` (m, 2)."""
    near = 0.0
    for i in range(a.shape[0]):
        near += nearest_on_polyline(b, a[i, 0], a[i, 1])[1] <= corridor
    return near / float(a.shape[0])


Cell = tuple[int, int]


class AlternativeCriteria(Model):
    """Criteria for an alternative route; assumed."""

    overlap: float = Field(0.7, gt=0.0, lt=1.0)
    """Upper limit of the overlap: the share of one route's length that lies within ``corridor`` of
    the other, the larger of the two shares."""
    corridor: float = Field(1.0, gt=0.0, le=10.0)
    """Distance below which two routes overlap, m."""
    stretch: float = Field(1.6, ge=1.0, le=10.0)
    """Upper limit of a route's cost and length, as a multiple of the best one."""
    obstacle: float = Field(2.5, ge=0.0, le=100.0)
    """Minimum length of the obstacle between two routes, m; shorter ones are pillars. Obstacles are
    grown by the inscribed radius, and count as one if the robot does not fit between them."""
    pillar_stretch: float = Field(1.2, ge=1.0, le=10.0)
    """``stretch`` for the other side of a pillar, which is offered if there is nothing else."""
    reach: float = Field(0.75, gt=0.0, le=10.0)
    """Radius within which the route through a cell must be the best, m."""
    tries: int = Field(40, ge=1, le=1000)
    """Upper limit of the candidates."""
    closeness: float = Field(2.0, ge=0.0, le=100.0)
    """Cost of a metre of distance from each wish, for the order of the alternatives."""
    measuring: FeatureParameters = FeatureParameters()


@value
class Alternative:
    """One of several routes."""

    path: Path
    features: RouteFeatures
    price: float
    """Weighted length and the cost of the distance from the wishes, m: the default order."""
    overlap: float
    """Largest overlap with an earlier route, 0…1; see ``AlternativeCriteria.overlap``."""


def find_alternatives(
    problem: RouteProblem,
    planner: GlobalPlanner,
    k: int = 3,
    differing: AlternativeCriteria | None = None,
    *,
    first: Path | None = None,
) -> tuple[Alternative, ...]:
    """Find up to ``k`` different routes: the planner's own first, the others by their price.

    Args:
        problem: start, goal and wishes; every route avoids the zones to avoid, some meet the
            attracting wishes, and each path reports the distances.
        planner: a global planner; its ``parameters`` define the costs.
        k: number of routes, ≥ 1; the result may contain fewer.
        differing: criteria for an alternative.
        first: the planner's own route; None: it is planned.

    Raises:
        PlanningError: if there is no route at all, as for ``GlobalPlanner.plan``.
        ValueError: if k < 1.
    """
    if k < 1:
        raise ValueError(f"{k} routes were requested; at least one is needed")
    differing = differing or AlternativeCriteria()
    first = first or planner.plan(problem)
    parameters = parameters_of(planner)
    prepared = prepare(problem, parameters)
    chosen, beside_pillar = [first], list[Path]()
    candidates = _candidates(prepared, first, differing) if k > 1 else iter(())
    for candidate in candidates:
        if _obstacle_length(prepared, candidate.line, chosen, differing) <= 0.0:
            continue
        path = _built(prepared, parameters, candidate, first)
        if path is None or path.length > differing.stretch * first.length:
            continue
        if comes_back(resample(path.points, 0.25), prepared.costmap.radius):
            continue
        obstacle = _obstacle_length(prepared, path.points, chosen, differing)
        if obstacle >= differing.obstacle:
            chosen.append(path)
        elif obstacle > 0.0 and path.length <= differing.pillar_stretch * first.length:
            beside_pillar.append(path)
        if len(chosen) == 2 * k:
            break
    others = sorted(chosen[1:], key=lambda path: _price(path, differing)) or beside_pillar[:1]
    best = [first, *others[: k - 1]]
    return tuple(_alternative(prepared, path, best[:i], differing) for i, path in enumerate(best))


def wish_distance(path: Path) -> float:
    """Sum of a path's distances from the wishes, m."""
    report = path.wishes
    inside = np.maximum(-report.avoided, 0.0)
    return float(report.closest.sum() + report.along.sum() + inside.sum())


def most_shared(line: Floats, others: Sequence[Path], differing: AlternativeCriteria) -> float:
    """Largest overlap of a line (k, 2) with paths; 0 if there are none."""
    shares = (overlap(line, each.points, differing.corridor) for each in others)
    return max(shares, default=0.0)


def _price(path: Path, differing: AlternativeCriteria) -> float:
    return path.cost + differing.closeness * wish_distance(path)


def _alternative(
    prepared: PreparedProblem, path: Path, before: Sequence[Path], differing: AlternativeCriteria
) -> Alternative:
    return Alternative(
        path=path,
        features=route_features(prepared, path, differing.measuring),
        price=_price(path, differing),
        overlap=most_shared(path.points, before, differing),
    )


def _obstacle_length(
    prepared: PreparedProblem, line: Floats, others: Sequence[Path], differing: AlternativeCriteria
) -> float:
    """Minimum length of the obstacles between a line and each of the others, m.

    0 if it is not an alternative: nothing is between, or they overlap too much.
    """
    if most_shared(line, others, differing) > differing.overlap:
        return 0.0
    return min(between(prepared, line, each.points) for each in others)


@value
class _Candidate:
    """Candidate for an alternative."""

    stops: tuple[Cell, ...]
    """Cells that it passes in their order, by the cheapest path between them."""
    held: tuple[Cell, ...]
    """The cells of ``stops`` at which it meets a wish."""
    line: Annotated[Floats, Shape("k 2")]
    """Line from cell to cell, map frame, m."""


def _candidates(
    prepared: PreparedProblem, first: Path, differing: AlternativeCriteria
) -> Iterator[_Candidate]:
    """Locally optimal candidates without loops; those that meet the wishes first.

    They may still overlap too much with each other.
    """
    served = _met_cells(prepared, first)
    plain = (prepared.start, prepared.goal)
    for stops in [(prepared.start, *served, prepared.goal), plain] if served else [plain]:
        seen = np.zeros(prepared.costmap.cost.shape, dtype=np.uint8)
        _mark(seen, prepared.costmap.grid.cells(first.points), prepared, differing)
        for by in _plateaus(prepared, stops, seen, differing):
            path = _through(by, served, prepared.weights)
            if path is None:
                continue
            _mark(seen, path.cells, prepared, differing)
            line = resample(prepared.costmap.grid.centres(path.cells), 0.25)
            if not comes_back(line, prepared.costmap.radius):
                yield _Candidate(stops=by, held=served, line=line)


def _built(
    prepared: PreparedProblem,
    parameters: GridPlannerParameters,
    candidate: _Candidate,
    first: Path,
) -> Path | None:
    """Path for a candidate; None if the robot cannot follow it.

    Its report compares it with the planner's path without wishes.
    """
    try:
        route = find_route(
            prepared, parameters, search=partial(_through, candidate.stops, candidate.held)
        )
    except NoPath:
        return None
    path = to_path(prepared, route, route, method=first.method)
    report = dataclasses.replace(
        path.wishes,
        extra_length=path.length - (first.length - first.wishes.extra_length),
        extra_cost=path.cost - (first.cost - first.wishes.extra_cost),
    )
    return dataclasses.replace(path, wishes=report, without_wishes=first.without_wishes)


def _plateaus(
    prepared: PreparedProblem, stops: tuple[Cell, ...], seen: Bytes, differing: AlternativeCriteria
) -> Iterator[tuple[Cell, ...]]:
    """The stops with one more cell between two of them, so that the route is locally optimal.

    The cheapest come first. ``seen`` (rows, cols) is read at every step: marked cells are skipped.
    """
    legs = [shortest_path(prepared.weights, *leg) for leg in pairwise(stops)]
    costs = [np.inf if leg is None else leg.cost for leg in legs]
    limit = differing.stretch * sum(costs)
    if not np.isfinite(limit):
        return
    fields = [cost_field(prepared.weights, stop, limit=limit)[1:-1, 1:-1] for stop in stops]
    found: list[tuple[Floats32, Integers, Integers]] = []
    disc = _disc(differing.reach / prepared.costmap.grid.resolution)
    for leg, (there, back) in enumerate(pairwise(fields)):
        price = (there + back + (sum(costs) - costs[leg])).astype(np.float32)
        flat = (price <= cv2.erode(price, disc) + _LEVEL) & (price <= limit)
        at = np.flatnonzero(flat)
        found.append((price.ravel()[at], at, np.full(len(at), leg)))
    price, at, leg_of = (np.concatenate(each) for each in zip(*found, strict=True))
    order = np.argsort(price, kind="stable")
    at, leg_of = at[order], leg_of[order]
    for _ in range(differing.tries):
        left = seen.ravel()[at] == 0
        at, leg_of = at[left], leg_of[left]
        if not len(at):
            return
        row, col = divmod(int(at[0]), seen.shape[1])
        cut = int(leg_of[0]) + 1
        at, leg_of = at[1:], leg_of[1:]
        yield (*stops[:cut], (row, col), *stops[cut:])


_LEVEL = 0.01  # of a cell: rounding error of float32 on a plateau
_STROKE_SPACING = 3.0  # m between the points at which an alternative follows a stroke


def _disc(radius: float) -> Bytes:
    cells = max(int(radius), 1)
    shape = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * cells + 1, 2 * cells + 1))
    return shape.astype(np.uint8)


def _mark(
    seen: Bytes, cells: Integers, prepared: PreparedProblem, differing: AlternativeCriteria
) -> None:
    """Mark the cells within the corridor around a path (k, 2)."""
    width = max(round(2.0 * differing.corridor / prepared.costmap.grid.resolution), 1)
    cv2.polylines(seen, [cells[:, ::-1].astype(np.int32)], False, 1, thickness=width)


def _met_cells(prepared: PreparedProblem, first: Path) -> tuple[Cell, ...]:
    """Cells of the planner's own route nearest to each attracting wish, in its own order."""
    lines = [resample(line, _STROKE_SPACING) for line in strokes(prepared.problem)]
    points = np.concatenate([attracting_points(prepared.problem), *lines])
    along = sorted(nearest_on_polyline(first.points, x, y)[0] for x, y in points)
    s = arc_length(first.points)
    cells = prepared.costmap.grid.cells(first.points)
    packed = prepared.weights.packed
    open_: Booleans = np.isfinite(packed[cells[:, 0] + 1, cells[:, 1] + 1])
    s, cells = s[open_], cells[open_]
    nearest = [tuple(int(c) for c in cells[np.abs(s - each).argmin()]) for each in along]
    return tuple((row, col) for row, col in dict.fromkeys(nearest))


def _through(stops: tuple[Cell, ...], held: tuple[Cell, ...], weights: Weights) -> GridPath | None:
    """Cheapest path through all stops in order; those in ``held`` become waypoints."""
    legs = []
    for here, there in pairwise(stops):
        leg = shortest_path(weights, here, there)
        if leg is None:
            return None
        legs.append(leg)
    reached = np.cumsum([len(leg.cells) - 1 for leg in legs])[:-1]
    waypoints = [at for at, stop in zip(reached, stops[1:], strict=False) if stop in held]
    return GridPath(
        cells=np.concatenate([legs[0].cells[:1], *(leg.cells[1:] for leg in legs)]),
        cost=sum(leg.cost for leg in legs),
        expansions=sum(leg.expansions for leg in legs),
        waypoints=np.array(waypoints, dtype=np.int64),
    )
