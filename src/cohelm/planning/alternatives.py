"""Routes that really differ: another corridor, another door, not another side of a pillar.

With the cost g_s of reaching every cell from the start and g_t of going on to the goal, the best
route through a cell v costs g_s(v) + g_t(v). Where that is a local minimum, the route through v is
locally optimal about v: it neither bows out without a reason nor enters a dead end and comes back.
So the alternatives are the routes through such cells away from the routes known already, in order
of their cost, if they are no detour beyond bounds, cross no place twice, share little with those
known, and something larger than a pillar stands between (the plateaus of Abraham et al.,
Alternative Routes in Road Networks, 2013). Where wishes attract, the routes by the places at which
the planner's own route serves them are looked for first, and then those that serve none.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise

import cv2
import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Booleans, Bytes, Floats, Floats32, Integers, Shape, value
from cohelm.config import Model
from cohelm.errors import NoPath
from cohelm.geometry import arc_length, nearest_on_polyline, resample
from cohelm.messages import Path
from cohelm.planning.api import GlobalPlanner, RouteProblem
from cohelm.planning.features import Measuring, RouteFeatures, route_features
from cohelm.planning.fields import cost_field_from
from cohelm.planning.ground import Ground, ground_for
from cohelm.planning.overlap import between, comes_back, overlap
from cohelm.planning.route import RouteParameters, find_route, parameters_of, to_path
from cohelm.planning.search import GridPath, Weights, shortest_path
from cohelm.planning.wishes import attracting_points, strokes

Cell = tuple[int, int]


class Differing(Model):
    """What counts as another route; the figures are assumed."""

    overlap: float = Field(0.7, gt=0.0, lt=1.0)
    """Most that two routes may share: the share of either one's length that lies within
    ``corridor`` of the other, the larger of the two shares."""
    corridor: float = Field(1.0, gt=0.0, le=10.0)
    """Routes nearer than this to each other are the same there, m."""
    stretch: float = Field(1.6, ge=1.0, le=10.0)
    """Most that a route may cost and be long, as a multiple of the best one."""
    obstacle: float = Field(2.5, ge=0.0, le=100.0)
    """What stands between two routes must be this long, or they differ by the side of a pillar, m;
    obstacles between which the robot does not fit are one, and grown by its inscribed radius."""
    pillar_stretch: float = Field(1.2, ge=1.0, le=10.0)
    """``stretch`` for the other side of a pillar, which is offered where there is nothing else."""
    reach: float = Field(0.75, gt=0.0, le=10.0)
    """Radius within which the way through a cell must be the best, m."""
    tries: int = Field(40, ge=1, le=1000)
    """Ways looked at, at most."""
    closeness: float = Field(2.0, ge=0.0, le=100.0)
    """Extra cost that a metre closer to each wish is worth where alternatives are put in order."""
    measuring: Measuring = Measuring()


@value
class Alternative:
    """One of several routes."""

    path: Path
    features: RouteFeatures
    price: float
    """Weighted length and what the distance from the wishes is worth, m: the neutral order."""
    overlap: float
    """The largest that it shares with one before it, 0…1; see ``Differing.overlap``."""


def alternatives(
    problem: RouteProblem, planner: GlobalPlanner, k: int = 3, differing: Differing | None = None
) -> tuple[Alternative, ...]:
    """Up to ``k`` routes that really differ: the planner's own first, the others by their price.

    Args:
        problem: start, goal and all else; wishes to avoid hold for every route, attracting ones are
            served by some, and each path reports how well.
        planner: a global planner, built; its ``parameters`` say what a way costs.
        k: routes wanted, ≥ 1; fewer come back where there are no more.
        differing: what counts as another route.

    Raises:
        PlanningError: if there is no route at all, as ``GlobalPlanner.plan`` says.
        ValueError: if k < 1.
    """
    if k < 1:
        raise ValueError(f"{k} routes are wanted, at least one must be")
    differing = differing or Differing()
    first = planner.plan(problem)
    parameters = parameters_of(planner)
    ground = ground_for(problem, parameters)
    chosen, beside_pillar = [first], list[Path]()
    ways = _ways(ground, first, differing) if k > 1 else iter(())
    for way in ways:
        if _news(ground, way.line, chosen, differing) <= 0.0:
            continue
        path = _built(ground, parameters, way, first)
        if path is None or path.length > differing.stretch * first.length:
            continue
        if comes_back(resample(path.points, 0.25), ground.costmap.radius):
            continue
        obstacle = _news(ground, path.points, chosen, differing)
        if obstacle >= differing.obstacle:
            chosen.append(path)
        elif obstacle > 0.0 and path.length <= differing.pillar_stretch * first.length:
            beside_pillar.append(path)
        if len(chosen) == 2 * k:
            break
    others = sorted(chosen[1:], key=lambda path: _price(path, differing)) or beside_pillar[:1]
    best = [first, *others[: k - 1]]
    return tuple(_alternative(ground, path, best[:i], differing) for i, path in enumerate(best))


def wish_distance(path: Path) -> float:
    """How far a path stays from what was wished, summed over the wishes, m."""
    report = path.wishes
    inside = np.maximum(-report.avoided, 0.0)
    return float(report.closest.sum() + report.along.sum() + inside.sum())


def most_shared(line: Floats, others: Sequence[Path], differing: Differing) -> float:
    """The largest overlap of a line (k, 2) with paths; 0 where there are none."""
    shares = (overlap(line, each.points, differing.corridor) for each in others)
    return max(shares, default=0.0)


def _price(path: Path, differing: Differing) -> float:
    return path.cost + differing.closeness * wish_distance(path)


def _alternative(
    ground: Ground, path: Path, before: Sequence[Path], differing: Differing
) -> Alternative:
    return Alternative(
        path=path,
        features=route_features(ground, path, differing.measuring),
        price=_price(path, differing),
        overlap=most_shared(path.points, before, differing),
    )


def _news(ground: Ground, line: Floats, others: Sequence[Path], differing: Differing) -> float:
    """How long what stands between a line and each of the others is at least, m.

    0 where it is no other way: nothing stands between, or they share too much.
    """
    if most_shared(line, others, differing) > differing.overlap:
        return 0.0
    return min(between(ground, line, each.points) for each in others)


@value
class _Way:
    """A way that may become an alternative."""

    stops: tuple[Cell, ...]
    """Cells that it passes in their order, the cheapest way from one to the next."""
    pinned: tuple[Cell, ...]
    """Those of them at which it serves a wish."""
    line: Annotated[Floats, Shape("k 2")]
    """It from cell to cell, map frame, m."""


def _ways(ground: Ground, first: Path, differing: Differing) -> Iterator[_Way]:
    """Ways that are locally optimal and no loops; those that serve the wishes first.

    They may still share too much with each other.
    """
    served = _served(ground, first)
    plain = (ground.start, ground.goal)
    for stops in [(ground.start, *served, ground.goal), plain] if served else [plain]:
        seen = np.zeros(ground.costmap.cost.shape, dtype=np.uint8)
        _mark(seen, ground.costmap.grid.cells(first.points), ground, differing)
        for by in _plateaus(ground, stops, seen, differing):
            way = _through(by, served, ground.weights)
            if way is None:
                continue
            _mark(seen, way.cells, ground, differing)
            line = resample(ground.costmap.grid.centres(way.cells), 0.25)
            if not comes_back(line, ground.costmap.radius):
                yield _Way(stops=by, pinned=served, line=line)


def _built(ground: Ground, parameters: RouteParameters, way: _Way, first: Path) -> Path | None:
    """The way as a path that the robot can follow; None where it cannot.

    The path compares with what the planner would do without wishes.
    """
    try:
        route = find_route(ground, parameters, search=partial(_through, way.stops, way.pinned))
    except NoPath:
        return None
    path = to_path(ground, route, route, method=first.method)
    report = dataclasses.replace(
        path.wishes,
        extra_length=path.length - (first.length - first.wishes.extra_length),
        extra_cost=path.cost - (first.cost - first.wishes.extra_cost),
    )
    return dataclasses.replace(path, wishes=report, without_wishes=first.without_wishes)


def _plateaus(
    ground: Ground, stops: tuple[Cell, ...], seen: Bytes, differing: Differing
) -> Iterator[tuple[Cell, ...]]:
    """The stops with one more cell between two of them, such that the way by them is a good one.

    The cheapest first. ``seen`` (rows, cols) is read at every step: what it marks by then is left
    out.
    """
    legs = [shortest_path(ground.weights, *leg) for leg in pairwise(stops)]
    costs = [np.inf if leg is None else leg.cost for leg in legs]
    limit = differing.stretch * sum(costs)
    if not np.isfinite(limit):
        return
    fields = [cost_field_from(ground.weights, stop, limit=limit)[1:-1, 1:-1] for stop in stops]
    found: list[tuple[Floats32, Integers, Integers]] = []
    disc = _disc(differing.reach / ground.costmap.grid.resolution)
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


_LEVEL = 0.01  # of a cell: what rounding to float32 may do to a plateau
_STROKE_SPACING = 3.0  # m between the places at which an alternative keeps to a drawn line


def _disc(radius: float) -> Bytes:
    cells = max(int(radius), 1)
    shape = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * cells + 1, 2 * cells + 1))
    return shape.astype(np.uint8)


def _mark(seen: Bytes, cells: Integers, ground: Ground, differing: Differing) -> None:
    """Mark what lies within the corridor about a way (k, 2)."""
    width = max(round(2.0 * differing.corridor / ground.costmap.grid.resolution), 1)
    cv2.polylines(seen, [cells[:, ::-1].astype(np.int32)], False, 1, thickness=width)


def _served(ground: Ground, first: Path) -> tuple[Cell, ...]:
    """Where the planner's own route comes nearest to each attracting wish, in its own order."""
    lines = [resample(line, _STROKE_SPACING) for line in strokes(ground.problem)]
    points = np.concatenate([attracting_points(ground.problem), *lines])
    along = sorted(nearest_on_polyline(first.points, x, y)[0] for x, y in points)
    s = arc_length(first.points)
    cells = ground.costmap.grid.cells(first.points)
    packed = ground.weights.packed
    open_: Booleans = np.isfinite(packed[cells[:, 0] + 1, cells[:, 1] + 1])
    s, cells = s[open_], cells[open_]
    nearest = [tuple(int(c) for c in cells[np.abs(s - each).argmin()]) for each in along]
    return tuple((row, col) for row, col in dict.fromkeys(nearest))


def _through(
    stops: tuple[Cell, ...], pinned: tuple[Cell, ...], weights: Weights
) -> GridPath | None:
    """The cheapest way by all stops in their order, pinned to some; None where there is none."""
    legs = []
    for here, there in pairwise(stops):
        leg = shortest_path(weights, here, there)
        if leg is None:
            return None
        legs.append(leg)
    reached = np.cumsum([len(leg.cells) - 1 for leg in legs])[:-1]
    pins = [at for at, stop in zip(reached, stops[1:], strict=False) if stop in pinned]
    return GridPath(
        cells=np.concatenate([legs[0].cells[:1], *(leg.cells[1:] for leg in legs)]),
        cost=sum(leg.cost for leg in legs),
        expansions=sum(leg.expansions for leg in legs),
        pins=np.array(pins, dtype=np.int64),
    )
