"""The rider's wishes as via points for the search, and the report of how a path meets them."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.errors import TooManyWishes
from cohelm.geometry import arc_length, inverse, nearest_on_polyline, resample, transform
from cohelm.kernels import CACHED
from cohelm.maps import OccupancyGrid
from cohelm.messages import Wish, WishReport
from cohelm.planning.api import RouteProblem
from cohelm.planning.costmap.layers.zones import distance_to_zone
from cohelm.planning.grid_search.via_points import MAX_LAYERS, ViaChain, count_layers, via_price

_REPORT_SPACING = 0.05
"""Distance between the samples of paths and strokes in a report, m."""
_REPORT_PIECES = 2000
"""Upper limit of the samples of a stroke."""


def attracting_points(problem: RouteProblem) -> Floats:
    """Points (w, 2) that attract the path, m, in the given order."""
    points = [wish.points for wish in problem.wishes if wish.kind == "attract"]
    return np.concatenate(points) if points else np.empty((0, 2))


def strokes(problem: RouteProblem) -> tuple[Floats, ...]:
    """Drawn lines (k, 2) that the path should follow, m; none is empty."""
    kinds = [wish.points for wish in problem.wishes if wish.kind == "stroke"]
    return tuple(points for points in kinds if len(points))


def has_wishes(problem: RouteProblem) -> bool:
    """Check that a point or a stroke attracts the path."""
    return len(attracting_points(problem)) > 0 or len(strokes(problem)) > 0


def chains_of(
    problem: RouteProblem, *, closeness: float, visiting: float, spacing: float, pieces: int
) -> tuple[ViaChain, ...]:
    """Wishes as chains of via points in the map frame, m.

    The points of a wish are a chain with the price ``closeness`` or ``visiting``. A stroke of
    length L is cut into n pieces whose midpoints are a chain with the price closeness · L / n, so
    that their sum is about closeness · ∫ distance ds.

    Args:
        problem: with the wishes.
        closeness: weighted metres per metre of distance (for a stroke: per metre of its length).
        visiting: the same for points to visit.
        spacing: distance between the points of a stroke, m; larger if there would be too many.
        pieces: upper limit for each stroke.

    Raises:
        PlanningError: TooManyWishes.
    """
    single = tuple(
        ViaChain(points=wish.points, price=visiting if wish.visit else closeness)
        for wish in problem.wishes
        if wish.kind == "attract" and len(wish.points)
    )
    drawn = strokes(problem)
    lengths = [max(float(arc_length(line)[-1]), spacing) for line in drawn]
    taken = count_layers(len(chain.points) for chain in single)
    wanted_counts = [min(math.ceil(length / spacing - 1e-9), pieces) for length in lengths]
    counts = _thinned(wanted_counts, taken)
    return single + tuple(
        ViaChain(points=_middles(line, count), price=closeness * length / count)
        for line, count, length in zip(drawn, counts, lengths, strict=True)
    )


def on_grid(chains: tuple[ViaChain, ...], grid: OccupancyGrid) -> tuple[ViaChain, ...]:
    """Convert chains from the map frame to cells of a grid, (row, column)."""
    frame = inverse(grid.X_MG)
    return tuple(
        ViaChain(
            points=transform(frame, chain.points)[:, ::-1] / grid.resolution - 0.5,
            price=chain.price,
        )
        for chain in chains
    )


def price_of(line: Floats, chains: tuple[ViaChain, ...]) -> float:
    """Price of a line (k, 2) for chains in the same frame, weighted metres."""
    return via_price(resample(line, _REPORT_SPACING / 2.0), chains) if chains else 0.0


def report_wishes(
    problem: RouteProblem, line: Floats, *, extra_length: float, extra_cost: float
) -> WishReport:
    """Report the distance of a path (k, 2) to each wish, m, and the cost of the wishes.

    Args:
        problem: with the wishes.
        line: the path, m.
        extra_length, extra_cost: difference from the path without wishes.
    """
    close = resample(line, _REPORT_SPACING)
    zones = [wish for wish in problem.wishes if wish.kind == "avoid" and len(wish.points)]
    return WishReport(
        closest=np.array([_to_line(line, point[None]) for point in attracting_points(problem)]),
        along=np.array([_to_line(line, _places_on(s)) for s in strokes(problem)]),
        avoided=np.array([min(distance_to_zone(zone, place) for place in close) for zone in zones]),
        extra_length=extra_length,
        extra_cost=extra_cost,
    )


def wished_line(problem: RouteProblem) -> Floats:
    """Line (k, 2) from the start through points and strokes in the given order to the goal."""
    drawn: list[Wish] = [wish for wish in problem.wishes if wish.kind != "avoid"]
    return np.concatenate([problem.start[None], *(w.points for w in drawn), problem.goal[None]])


def _thinned(counts: list[int], taken: int) -> list[int]:
    """Reduce the largest counts of strokes' points until the number of layers is allowed."""
    counts = counts.copy()
    while taken * math.prod(count + 1 for count in counts) > MAX_LAYERS:
        most = max(counts)
        if most <= 1:
            raise TooManyWishes(layers=taken * 2 ** len(counts), most=MAX_LAYERS)
        counts[counts.index(most)] -= 1
    return counts


def _middles(line: Floats, count: int) -> Floats:
    """Midpoints (count, 2) of equal pieces of a line."""
    along = arc_length(line)
    at = (np.arange(count) + 0.5) / count * along[-1]
    return np.stack([np.interp(at, along, line[:, i]) for i in (0, 1)], axis=-1)


def _places_on(stroke: Floats) -> Floats:
    """Evenly spaced points (m, 2) on a stroke."""
    length = float(arc_length(stroke)[-1])
    return resample(stroke, max(_REPORT_SPACING, length / _REPORT_PIECES))


@njit(**CACHED)
def _to_line(line: Floats, points: Floats) -> float:
    """Mean distance of points (m, 2) to a line."""
    total = 0.0
    for i in range(points.shape[0]):
        total += nearest_on_polyline(line, points[i, 0], points[i, 1])[1]
    return float(total / points.shape[0])
