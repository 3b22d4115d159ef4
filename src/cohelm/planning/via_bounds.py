"""What at least is left to pay from each layer: bounds as in :mod:`cohelm.planning.bounds`.

A layer's bound falls along no step by more than the step costs, and crediting a point at a cell
saves no more than its price there. Of the layers, from the last to the first, the values at the
nodes are the greatest that keep the first within the layer, and at every node v the second as

    h_layer(v) ≤ h_next(v) + price · max(|v − point| − e, 0).

On a triangle of nodes, with R the radius of the circle about it, the linear function of the last
factor must be no greater than the distance from the point, and that it is for two reasons: with
e = 2 R, which is how far the nodes are apart, no value at a node is greater than the distance from
anywhere on the triangle. And where all is at least r from the point, the linear function of the
distances themselves is greater than the distance by at most R² / 2r. On the triangles that h_next
is linear on, h_layer is therefore no greater than it and the price; on the two other ones that a
square can be cut into, h_layer would only be less where it is linear on those instead.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32, Integers
from cohelm.planning.bounds import COARSE, blank, cap, seed, settle

_SIDE = 1 << COARSE
_ACROSS = _SIDE * math.sqrt(2.0)  # 2 R


@njit(cache=True)
def layer_bounds(  # noqa: PLR0917  # a kernel takes plain arguments
    weights: Floats32,
    points: Floats,
    edges_from: Integers,
    edges: Integers,
    goal: tuple[int, int],
    lightest: float,
    heaviest: float,
    most: float,
) -> Floats:
    """Values at the nodes of each layer, to be read by :func:`cohelm.planning.bounds.bound_at`.

    The bounds are the same number too great everywhere, namely the last layer's at the goal.

    Args:
        weights: (rows, cols), with a blocked border.
        points, edges_from, edges: of :class:`cohelm.planning.via_layers.Layers`.
        goal: (row, column) in ``weights``.
        lightest, heaviest: what no passable weight is less or more than.
        most: values need not be right beyond.
    """
    squares, blanks = blank(weights, COARSE)
    layers = edges_from.shape[0] - 1
    nodes = np.full((layers, *blanks.shape), np.inf)
    room = blanks.size + 64
    for layer in range(layers - 1, -1, -1):
        reach = -np.inf
        while reach == -np.inf:
            here = nodes[layer]
            here[:] = np.inf
            if layer == layers - 1:
                seed(weights, squares, here, goal, COARSE)
            for k in range(edges_from[layer], edges_from[layer + 1]):
                _credit(nodes[edges[k, 0]], points[edges[k, 1]], here)
            reach = settle(weights, squares, here, -1, lightest, heaviest, most, room, COARSE)
            if reach == -np.inf:
                room *= 4
        cap(here, reach)
    return nodes


@njit(cache=True)
def _credit(then: Floats, point: Floats, here: Floats) -> None:
    """Lower a layer's nodes to the next one's and the price of a point."""
    row, col, price, beyond = point[0], point[1], point[2], point[3]
    for i in range(here.shape[0]):
        for j in range(here.shape[1] - 1):  # in the last column there are none
            far = math.hypot(i * _SIDE - 1 - row, j * _SIDE - 1 - col)
            error = _ACROSS
            if beyond == 0.0 and far > 2.0 * _ACROSS:
                error = 0.125 * _ACROSS * _ACROSS / (far - _ACROSS)
            paid = price * max(far - beyond - error, 0.0)
            here[i, j] = min(here[i, j], then[i, j] + paid)
