"""The layers of a search that credits points: which sets of points, and what leads where.

A layer is a number of points credited of each chain, so n + 1 for a chain of n points and 2ⁿ for n
single ones; they are numbered so that crediting a point leads to a higher number.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.errors import TooManyWishes

MAX_LAYERS = 256
"""More are refused: 2⁸ for eight single points."""


@value
class Chain:
    """Points to come near to, in their order."""

    points: Annotated[Floats, Shape("n 2")]
    """(row, column) in cells: cell centres have whole numbers. Anywhere, also off the grid."""
    price: float
    """Of a cell's length of distance from each point, in the cost of a cell of weight 1; ≥ 0."""


@value
class Layers:
    """The graph of the layers; ``*_from`` say where each layer's rows begin."""

    edges_from: Annotated[Integers, Shape("l+1")]
    edges: Annotated[Integers, Shape("e 2")]
    """(layer led to, point credited)."""
    points: Annotated[Floats, Shape("p 4")]
    """(row, column, price, distance to the grid, for which every way pays alike)."""


def layers_of(chains: tuple[Chain, ...], shape: tuple[int, int]) -> Layers:
    """The layers of chains, none of them empty, on a grid (rows, columns)."""
    edges = _edges(chains)
    return Layers(
        edges_from=np.concatenate([[0], np.cumsum([len(row) for row in edges])]),
        edges=np.array(list(itertools.chain.from_iterable(edges))).reshape(-1, 2),
        points=np.concatenate([_rows(chain, shape) for chain in chains]),
    )


def count_layers(lengths: Iterable[int]) -> int:
    """How many layers chains of these lengths need.

    Raises:
        TooManyWishes: if that is more than ``MAX_LAYERS``.
    """
    layers = math.prod(length + 1 for length in lengths)
    if layers > MAX_LAYERS:
        raise TooManyWishes(layers=layers, most=MAX_LAYERS)
    return layers


def unavoidable(chains: tuple[Chain, ...], shape: tuple[int, int]) -> float:
    """What every way on a grid pays for points that lie off it."""
    rows = [_rows(chain, shape) for chain in chains]
    return float(sum((row[:, 2] * row[:, 3]).sum() for row in rows))


def price_along(places: Floats, chains: tuple[Chain, ...]) -> float:
    """What a way past ``places`` (m, 2) pays: each chain's points are credited in order, at best.

    Σ_chains min_{i_1 ≤ i_2 ≤ …} Σ_k price · |place(i_k) − p_k|; in the units of the chains.
    """
    return sum(chain.price * _credited(places, chain.points) for chain in chains)


def _rows(chain: Chain, shape: tuple[int, int]) -> Floats:
    inside = np.clip(chain.points, 0.0, np.array(shape) - 1.0)
    beyond = np.hypot(*(chain.points - inside).T)
    return np.column_stack([chain.points, np.full(len(beyond), chain.price), beyond])


def _edges(chains: tuple[Chain, ...]) -> list[list[tuple[int, int]]]:
    """For each layer, (layer led to, point credited)."""
    lengths = [len(chain.points) for chain in chains]
    first = np.concatenate([[0], np.cumsum(lengths)])
    dims = [length + 1 for length in lengths]
    strides = [math.prod(dims[i + 1 :]) for i in range(len(dims))]
    return [
        [
            (layer + strides[i], int(first[i]) + done)
            for i, done in enumerate(credited)
            if done < lengths[i]
        ]
        for layer, credited in enumerate(itertools.product(*(range(dim) for dim in dims)))
    ]


@njit(cache=True)
def _credited(places: Floats, points: Floats) -> float:
    """The least sum of distances to ``points`` (n, 2), each met no earlier than the one before."""
    best = np.full(points.shape[0], np.inf)
    for i in range(places.shape[0]):
        before = 0.0
        for k in range(points.shape[0]):
            far = math.hypot(places[i, 0] - points[k, 0], places[i, 1] - points[k, 1])
            best[k] = min(best[k], before + far)
            before = best[k]
    return float(best[-1])
