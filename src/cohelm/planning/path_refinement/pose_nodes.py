"""Nodes of the search over (x, y, heading): reached poses, and a hash table of them, compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import copy_row
from cohelm.arrays import Floats, Integers
from cohelm.kernels import CACHED

_CELL = 0.05  # m; poses in one such square and one sector count as one
_SECTORS = 128


class PoseNodes(NamedTuple):
    """Reached poses, and a hash table of them; for kernels."""

    table: Integers
    """Cheapest node of a square and a sector, −1: none, (size,)."""
    keys: Integers
    """Square and sector of each slot of the table, (size,)."""
    pose: Floats
    """(nodes, 3)."""
    cost: Floats
    """Cost from a seed, m, (nodes,)."""
    parent: Integers
    """Node before, −1: a seed, (nodes,)."""
    bend: Floats
    """Curvature of the motion from there, 1/m; ∞: a turn on the spot, (nodes,)."""
    coarse: int
    """Squares and sectors are larger by this factor."""
    length: Floats
    """Length of that motion, m, negative backwards; angle of a turn on the spot, rad, (nodes,)."""


@njit(**CACHED)
def empty_nodes(capacity: int, slots: int, coarse: int) -> PoseNodes:
    """Return no nodes, with space for ``capacity`` of them and for ``slots`` in the table."""
    size = 64
    while size < slots:
        size *= 2
    return PoseNodes(
        np.full(size, -1, dtype=np.int64),
        np.empty(size, dtype=np.int64),
        np.empty((capacity, 3)),
        np.empty(capacity),
        np.empty(capacity, dtype=np.int64),
        np.empty(capacity),
        coarse,
        np.empty(capacity),
    )


@njit(**CACHED)
def slot_of(nodes: PoseNodes, pose: Floats) -> int:
    """Slot of the table for the pose's square and sector; writes its key there."""
    cell, sectors = nodes.coarse * _CELL, _SECTORS // nodes.coarse
    x, y = math.floor(pose[0] / cell), math.floor(pose[1] / cell)
    sector = round(pose[2] * sectors / (2.0 * math.pi)) % sectors
    key = ((y + (1 << 24)) << 32) + ((x + (1 << 20)) << 7) + sector
    mask = nodes.table.shape[0] - 1
    slot: int = ((key * 0x9E3779B97F4A7C1) >> 20) & mask
    while nodes.table[slot] >= 0 and nodes.keys[slot] != key:
        slot = (slot + 1) & mask
    nodes.keys[slot] = key
    return slot


@njit(**CACHED)
def add_node(
    nodes: PoseNodes,
    node: int,
    slot: int,
    pose: Floats,
    cost: float,
    parent: int,
    motion: tuple[float, float],
) -> None:
    """Write a node that a motion (curvature, length) leads to, and put it into the table."""
    copy_row(nodes.pose[node], pose)
    nodes.cost[node] = cost
    nodes.parent[node] = parent
    nodes.bend[node], nodes.length[node] = motion
    nodes.table[slot] = node
