"""Cheapest path with prices on the distance to via points: exact, one compiled A*.

Minimised over all paths from start to goal is

    cost(path) + Σ_chains min_{i_1 ≤ i_2 ≤ …} Σ_k price · |cell(i_k) − p_k|

where the points p_1, p_2, … of one chain are passed in their order, each at a cell of the path, and
the chains are independent. So a chain of one point pays for its closest distance, and single points
are passed in the best order.

The search (:mod:`cohelm.planning.grid_search.via_search`) runs on layers of the grid: passing a
point leads to another layer at the same cell. A layer is a number of points passed of each chain,
so there are n + 1 for a chain of n points and 2ⁿ for n single ones; passing a point leads to a
layer with a higher number. The cheapest path without the points gives an upper bound: cells
that cannot be on a better path are cut off and never entered.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Floats32, Integers, Shape, value
from cohelm.errors import PlanningTimeout, TooManyWishes
from cohelm.geometry import nearest_on_polyline
from cohelm.kernels import CACHED
from cohelm.planning.grid_search.lower_bound import COARSE_SHIFT, bound_at
from cohelm.planning.grid_search.via_search import (
    OUT_OF_BUDGET,
    ViaGraph,
    layer_bounds,
    search_layers,
)
from cohelm.planning.grid_search.weights import BLOCKED, GridPath, Weights, path_cost

MAX_LAYERS = 256
"""Upper limit of the layers: 2⁸ for eight single points."""
MAX_STATES = 1 << 29
"""Upper limit of layers times cells, eight bytes each; only pages that are reached use memory."""


@value
class ViaChain:
    """Via points with a common price, in their order."""

    points: Annotated[Floats, Shape("n 2")]
    """(row, column) in cells: cell centres have whole numbers. May lie off the grid."""
    price: float
    """Price of one cell of distance from each point, in the cost of a cell of weight 1; ≥ 0."""


def cheapest_via_path(
    weights: Weights,
    plain: GridPath,
    chains: tuple[ViaChain, ...],
    *,
    max_expansions: int | None = None,
) -> GridPath:
    """Find the path with the lowest sum of cost and prices; its waypoints are the cells of passing.

    A waypoint that lies within a cell of the straight line between others is left out.

    Args:
        weights: weights of the grid's cells.
        plain: cheapest path without via points; gives start, goal and an upper bound.
        chains: the via points; if there are none, the plain path is returned.
        max_expansions: budget, cells of layers; None: unlimited.

    Raises:
        TooManyWishes: if there are more than ``MAX_LAYERS`` layers, or too many for the map's size.
        PlanningTimeout: if the budget is used up first.
    """
    chains = tuple(chain for chain in chains if len(chain.points) and chain.price > 0.0)
    if not chains:
        return plain
    layers = count_layers(len(chain.points) for chain in chains)
    low, high = _window(weights, plain, chains)
    cells = math.prod(high - low + 2)
    if layers * cells > MAX_STATES:
        raise TooManyWishes(layers=layers, most=MAX_STATES // cells)
    packed = _cut(weights.packed, low, high)
    moved = tuple(ViaChain(points=chain.points - low, price=chain.price) for chain in chains)
    shape = (int(high[0] - low[0]), int(high[1] - low[1]))
    worth = (_worth(plain, chains) - unavoidable_price(moved, shape)) * (1.0 + 1e-9) + 1e-9
    graph, light = via_graph(moved, shape), (weights.lightest, weights.heaviest)
    begin, end = ((int(row) + 1, int(col) + 1) for row, col in plain.cells[[0, -1]] - low)
    most = worth + 2.0 * weights.heaviest * (1 << COARSE_SHIFT)  # more than the value at the goal
    nodes = layer_bounds(packed, graph, end, *light, most)
    at_goal = bound_at(nodes[-1].reshape(-1), nodes.shape[2], *end, COARSE_SHIFT)
    stride = packed.shape[1]
    states, expansions = search_layers(
        packed.ravel(),
        np.zeros(layers * cells),  # pages that the search never reaches use no memory
        nodes,
        stride,
        begin[0] * stride + begin[1],
        end[0] * stride + end[1],
        weights.lightest,
        worth + at_goal,
        graph,
        np.iinfo(np.int64).max if max_expansions is None else max_expansions,
    )
    if expansions == OUT_OF_BUDGET:
        raise PlanningTimeout(f"no path within {max_expansions} expanded cells")
    path, waypoints = _path(states % cells, packed.shape[1])
    path += low
    cost = path_cost(weights.packed, path)
    return GridPath(cells=path, cost=cost, expansions=expansions, waypoints=waypoints)


def via_graph(chains: tuple[ViaChain, ...], shape: tuple[int, int]) -> ViaGraph:
    """Layers of non-empty chains on a grid (rows, columns)."""
    edges = _edges(chains)
    return ViaGraph(
        edges_from=np.concatenate([[0], np.cumsum([len(row) for row in edges])]),
        edges=np.array(list(itertools.chain.from_iterable(edges))).reshape(-1, 2),
        points=np.concatenate([_rows(chain, shape) for chain in chains]),
    )


def count_layers(lengths: Iterable[int]) -> int:
    """Number of layers for chains of these lengths.

    Raises:
        TooManyWishes: if there are more than ``MAX_LAYERS``.
    """
    layers = math.prod(length + 1 for length in lengths)
    if layers > MAX_LAYERS:
        raise TooManyWishes(layers=layers, most=MAX_LAYERS)
    return layers


def unavoidable_price(chains: tuple[ViaChain, ...], shape: tuple[int, int]) -> float:
    """Price that every path on a grid pays for points off the grid."""
    rows = [_rows(chain, shape) for chain in chains]
    return float(sum((row[:, 2] * row[:, 3]).sum() for row in rows))


def via_price(places: Floats, chains: tuple[ViaChain, ...]) -> float:
    """Price of a path through ``places`` (m, 2), with each chain's points passed in their order.

    Σ_chains min_{i_1 ≤ i_2 ≤ …} Σ_k price · |place(i_k) − p_k|; in the units of the chains.
    """
    return sum(chain.price * _least_distances(places, chain.points) for chain in chains)


def _rows(chain: ViaChain, shape: tuple[int, int]) -> Floats:
    inside = np.clip(chain.points, 0.0, np.array(shape) - 1.0)
    beyond = np.hypot(*(chain.points - inside).T)
    return np.column_stack([chain.points, np.full(len(beyond), chain.price), beyond])


def _edges(chains: tuple[ViaChain, ...]) -> list[list[tuple[int, int]]]:
    """For each layer, its edges (next layer, point passed)."""
    lengths = [len(chain.points) for chain in chains]
    first = np.concatenate([[0], np.cumsum(lengths)])
    dims = [length + 1 for length in lengths]
    strides = [math.prod(dims[i + 1 :]) for i in range(len(dims))]
    return [
        [
            (layer + strides[i], int(first[i]) + done)
            for i, done in enumerate(passed)
            if done < lengths[i]
        ]
        for layer, passed in enumerate(itertools.product(*(range(dim) for dim in dims)))
    ]


@njit(**CACHED)
def _least_distances(places: Floats, points: Floats) -> float:
    """Least sum of distances to ``points`` (n, 2), each passed no earlier than the one before."""
    best = np.full(points.shape[0], np.inf)
    for i in range(places.shape[0]):
        before = 0.0
        for k in range(points.shape[0]):
            far = math.hypot(places[i, 0] - points[k, 0], places[i, 1] - points[k, 1])
            best[k] = min(best[k], before + far)
            before = best[k]
    return float(best[-1])


def _worth(path: GridPath, chains: tuple[ViaChain, ...]) -> float:
    return path.cost + via_price(path.cells.astype(float), chains)


def _window(
    weights: Weights, plain: GridPath, chains: tuple[ViaChain, ...]
) -> tuple[Integers, Integers]:
    """(first, last + 1) row and column that a path not above the plain path's worth can reach."""
    shape = (weights.packed.shape[0] - 2, weights.packed.shape[1] - 2)
    longest = (_worth(plain, chains) - unavoidable_price(chains, shape)) / weights.lightest
    ends = plain.cells[[0, -1]]
    spare = np.ceil((longest - np.ptp(ends, axis=0)) / 2.0 + 1.0)
    low = np.maximum(ends.min(axis=0) - spare, 0).astype(np.int64)
    high = np.minimum(ends.max(axis=0) + spare + 1, shape).astype(np.int64)
    return low, high


def _cut(packed: Floats32, low: Integers, high: Integers) -> Floats32:
    """Packed weights of a window, with their own blocked border."""
    (r0, c0), (r1, c1) = low, high + 2
    if (r0, c0) == (0, 0) and (r1, c1) == packed.shape:
        return packed
    out = packed[r0:r1, c0:c1].copy()
    out[[0, -1], :] = out[:, [0, -1]] = BLOCKED
    out.flags.writeable = False  # like the whole array, or kernels are compiled twice
    return out


def _path(places: Integers, stride: int) -> tuple[Integers, Integers]:
    """(cells (k, 2), inner ones at which points are passed) from the cells of the states."""
    stays = np.diff(places) == 0
    at = np.cumsum(np.concatenate([[0], ~stays]))
    kept = np.concatenate([[True], ~stays])
    cells = np.stack(np.divmod(places[kept], stride), axis=-1) - 1
    stops = np.unique(np.concatenate([[0], at[1:][stays], [len(cells) - 1]]))
    return cells, stops[_corners(cells[stops].astype(float), 1.0)][1:-1]


def _corners(points: Floats, tolerance: float) -> Integers:
    """Indices of the points to keep so that no other point of a line (k, 2) is farther away.

    Douglas-Peucker: distances are measured to the simplified line.
    """
    kept, spans = {0, len(points) - 1}, [(0, len(points) - 1)]
    while spans:
        a, b = spans.pop()
        chord = points[[a, b]]
        far = [nearest_on_polyline(chord, *points[i])[1] for i in range(a + 1, b)]
        if far and max(far) > tolerance:
            middle = a + 1 + int(np.argmax(far))
            kept.add(middle)
            spans += [(a, middle), (middle, b)]
    return np.array(sorted(kept))
