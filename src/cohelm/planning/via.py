"""The way that is cheapest when coming near to points counts too: exact, one compiled A*.

Minimised over all ways from start to goal is

    cost(way) + Σ_chains min_{i_1 ≤ i_2 ≤ …} Σ_k price · |cell(i_k) − p_k|

where the points p_1, p_2, … of one chain are credited in their order, each at a cell of the way,
and the chains do not heed each other. So a chain of one point pays for its closest distance, and
single points are passed in whatever order is best.

The search (:mod:`cohelm.planning.via_search`) runs on layers of the grid: crediting a point steps
to another layer at the same cell. The plain way and its price bound it: what cannot be on a better
way is cut off the grid beforehand and never entered.
"""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats, Floats32, Integers
from cohelm.errors import PlanningTimeout, TooManyWishes
from cohelm.geometry import nearest_on_polyline
from cohelm.planning.bounds import COARSE, bound_at
from cohelm.planning.search import BLOCKED, GridPath, Weights, path_cost
from cohelm.planning.via_bounds import layer_bounds
from cohelm.planning.via_layers import Chain, count_layers, layers_of, price_along, unavoidable
from cohelm.planning.via_search import OUT_OF_BUDGET, search

__all__ = ["MAX_STATES", "Chain", "cheapest_via", "price_along"]

MAX_STATES = 1 << 29
"""Layers times cells, eight bytes each; only what the search reaches is ever taken from memory."""


def cheapest_via(
    weights: Weights,
    plain: GridPath,
    chains: tuple[Chain, ...],
    *,
    max_expansions: int | None = None,
) -> GridPath:
    """The way that minimises cost and prices; ``pins`` are where points were credited.

    A pin that lies within a cell of the straight line between others is left out.

    Args:
        weights: of the grid's cells.
        plain: the cheapest way under them: from where to where, and what is too dear.
        chains: what to come near to; without any, the plain way is the answer.
        max_expansions: the budget, cells of layers; None: as many as it takes.

    Raises:
        TooManyWishes: if the layers are more than ``MAX_LAYERS``, or too many for so large a map.
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
    moved = tuple(Chain(points=chain.points - low, price=chain.price) for chain in chains)
    shape = (int(high[0] - low[0]), int(high[1] - low[1]))
    worth = (_worth(plain, chains) - unavoidable(moved, shape)) * (1.0 + 1e-9) + 1e-9
    graph, light = layers_of(moved, shape), (weights.lightest, weights.heaviest)
    begin, end = ((int(row) + 1, int(col) + 1) for row, col in plain.cells[[0, -1]] - low)
    most = worth + 2.0 * weights.heaviest * (1 << COARSE)  # more than the value at the goal
    nodes = layer_bounds(packed, graph.points, graph.edges_from, graph.edges, end, *light, most)
    at_goal = bound_at(nodes[-1].reshape(-1), nodes.shape[2], *end, COARSE)
    stride = packed.shape[1]
    states, expansions = search(
        packed.ravel(),
        np.zeros(layers * cells),  # pages that the search never touches are never made
        nodes,
        stride,
        begin[0] * stride + begin[1],
        end[0] * stride + end[1],
        weights.lightest,
        worth + at_goal,
        graph.edges_from,
        graph.edges,
        graph.points,
        np.iinfo(np.int64).max if max_expansions is None else max_expansions,
    )
    if expansions == OUT_OF_BUDGET:
        raise PlanningTimeout(f"no path within {max_expansions} expanded cells")
    way, pins = _way(states % cells, packed.shape[1])
    way += low
    cost = path_cost(weights.packed, way)
    return GridPath(cells=way, cost=cost, expansions=expansions, pins=pins)


def _worth(way: GridPath, chains: tuple[Chain, ...]) -> float:
    return way.cost + price_along(way.cells.astype(float), chains)


def _window(
    weights: Weights, plain: GridPath, chains: tuple[Chain, ...]
) -> tuple[Integers, Integers]:
    """(first, last + 1) row and column that a way no dearer than the plain one can reach."""
    shape = (weights.packed.shape[0] - 2, weights.packed.shape[1] - 2)
    longest = (_worth(plain, chains) - unavoidable(chains, shape)) / weights.lightest
    ends = plain.cells[[0, -1]]
    spare = np.ceil((longest - np.ptp(ends, axis=0)) / 2.0 + 1.0)
    low = np.maximum(ends.min(axis=0) - spare, 0).astype(np.int64)
    high = np.minimum(ends.max(axis=0) + spare + 1, shape).astype(np.int64)
    return low, high


def _cut(packed: Floats32, low: Integers, high: Integers) -> Floats32:
    """The packed weights of a window, with a blocked border of its own."""
    (r0, c0), (r1, c1) = low, high + 2
    if (r0, c0) == (0, 0) and (r1, c1) == packed.shape:
        return packed
    out = packed[r0:r1, c0:c1].copy()
    out[[0, -1], :] = out[:, [0, -1]] = BLOCKED
    out.flags.writeable = False  # as the whole of it, or kernels are compiled twice
    return out


def _way(places: Integers, stride: int) -> tuple[Integers, Integers]:
    """(cells (k, 2), inner ones where points were credited) of the cells of the states passed."""
    stays = np.diff(places) == 0
    at = np.cumsum(np.concatenate([[0], ~stays]))
    kept = np.concatenate([[True], ~stays])
    cells = np.stack(np.divmod(places[kept], stride), axis=-1) - 1
    stops = np.unique(np.concatenate([[0], at[1:][stays], [len(cells) - 1]]))
    return cells, stops[_corners(cells[stops].astype(float), 1.0)][1:-1]


def _corners(points: Floats, tolerance: float) -> Integers:
    """Which points of a line (k, 2) to keep so that no other is farther than that from the rest."""
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
