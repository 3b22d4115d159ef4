"""Groups as arcs meet them: their hulls over the whole lookahead, and discs about these."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.messages import GroupSpaces


class Hulls(NamedTuple):
    """Groups: their convex hulls, and discs about these."""

    support: Floats
    """(g, N+1, m)."""
    normal: Floats
    """(m, 2) unit vectors."""
    disc: Floats
    """(g, N+1, 3): centre and radius."""


def hulls_of(groups: GroupSpaces | None, steps: int) -> Hulls:
    """The hulls over ``steps``; beyond those that are known they go on as they last moved."""
    if groups is None or not len(groups.id):
        return Hulls(np.empty((0, 1, 1)), np.empty((0, 2)), np.empty((0, 1, 3)))
    normal = _unit_vectors(tuple(groups.direction.tolist()))
    support, centre = _centred(groups.support, normal, steps)
    radius = (support - centre @ normal.T).max(axis=2)
    return Hulls(support, normal, np.concatenate([centre, radius[..., None]], axis=-1))


@functools.lru_cache(maxsize=8)
def _unit_vectors(directions: tuple[float, ...]) -> Floats:
    """(m, 2)."""
    return np.stack([np.cos(directions), np.sin(directions)], axis=-1)


@njit(cache=True)
def _centred(known: Floats, normal: Floats, steps: int) -> tuple[Floats, Floats]:
    """(support (g, N+1, m), a point (g, N+1, 2) inside) of hulls known for some steps.

    Twice the mean of s(u) u is the centre of a disc, and lies inside any hull.
    """
    groups, states, m = known.shape
    support, centre = np.empty((groups, steps + 1, m)), np.zeros((groups, steps + 1, 2))
    for g in range(groups):
        for k in range(steps + 1):
            last, beyond = min(k, states - 1), max(k - states + 1, 0)
            for j in range(m):
                reach = known[g, last, j]
                if states > 1 and steps >= states:
                    reach += beyond * (known[g, -1, j] - known[g, -2, j])
                support[g, k, j] = reach
                centre[g, k, 0] += reach * normal[j, 0]
                centre[g, k, 1] += reach * normal[j, 1]
            for a in range(2):
                centre[g, k, a] = 2.0 * (centre[g, k, a] / m)
    return support, centre
