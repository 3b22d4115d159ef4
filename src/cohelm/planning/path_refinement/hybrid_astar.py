"""Hybrid A* over (x, y, heading) for the robot's footprint, where no smoothed line fits.

The robot drives arcs and straight lines of 0.1 m, and turns on the spot if that is allowed. The
cost field over the plane guides the search. From every few poses it tries a Dubins path (arc,
straight line, arc) to the goal, so that it ends exactly there; a goal without a heading is reached
by arc and line. Poses are in the grid's frame.
"""

from __future__ import annotations

import heapq
import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import NONE, ZERO, copy_row
from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.kernels import CACHED
from cohelm.planning.grid_search.cost_field import cost_field
from cohelm.planning.grid_search.weights import Weights
from cohelm.planning.path_refinement.configuration_space import (
    ConfigurationSpace,
    motion_is_free,
    weight_at,
)
from cohelm.planning.path_refinement.dubins import drive_arc, dubins_words
from cohelm.planning.path_refinement.footprint import turn_overlaps
from cohelm.planning.path_refinement.pose_nodes import PoseNodes, add_node, empty_nodes, slot_of

_STEP = 0.1  # m
_GENTLE = 0.97  # share of the largest curvature that is used: chords bend more than their arcs
_ARCS, _MOTIONS = 7, 9  # the motions of a step: seven arcs, then a turn on the spot to either side
_PIVOT = math.pi / 16.0  # rad turned on the spot at a time
_PIVOT_COST, _PIVOT_STOP = 0.15, 1.0  # m for each such turn, and for the stop before
_WIGGLE = 0.2  # extra cost of the sharpest arc, as a share of its length
_EAGER = 1.2  # weight of the heuristic
_POLISH = 100  # poses, besides as many again as it took, to improve the first path
_SHOTS = 4  # poses between two attempts to reach the goal directly


@value
class HybridPath:
    """Path that the footprint can follow."""

    points: Annotated[Floats, Shape("k 2")]
    """m; a turn on the spot is one point."""
    pivots: Annotated[Integers, Shape("p")]
    """Indices of the points where the robot turns on the spot."""
    start_heading: float
    """Heading at the start, rad."""
    end_heading: float
    """Heading at the end, rad."""


class SearchLimits(NamedTuple):
    """Limits of one search."""

    reach: float
    """Distance that the path may leave the box around start and goal, m."""
    pivots: bool
    """Turns on the spot are allowed."""
    budget: int = 1
    """Poses that may be expanded."""


def search_poses(
    space: ConfigurationSpace, seeds: Floats, goal: Floats, limits: SearchLimits
) -> tuple[HybridPath | None, int]:
    """Find a path from one of several poses to a goal; also return the number of expansions.

    Args:
        space: the configuration space.
        seeds: start poses (m, 3), all at one point.
        goal: (x, y, heading); a heading of NaN is free.
        limits: window, turns on the spot and budget.
    """
    corner, guide = _guide(space, seeds[0, :2], goal[:2], limits.reach)
    legs, expansions = _search(space, guide, corner, seeds, goal, limits.pivots, limits.budget)
    if not len(legs):
        return None, expansions
    poses, pivots = _sampled(legs)
    path = HybridPath(
        points=poses[:, :2],
        pivots=pivots,
        start_heading=float(poses[0, 2]),
        end_heading=float(poses[-1, 2]),
    )
    return path, expansions


def _guide(
    space: ConfigurationSpace, start: Floats, goal: Floats, reach: float
) -> tuple[Integers, Floats]:
    """(first packed row and column of a window, cost from its cells to the goal, m)."""
    res = space.footprint.resolution
    size = np.array(space.weights.shape) - 2
    reach = min(reach, res * float(size.max()))
    low = np.floor((np.minimum(start, goal) - reach) / res).astype(np.int64)[::-1]
    high = np.floor((np.maximum(start, goal) + reach) / res).astype(np.int64)[::-1] + 1
    low, high = np.clip(low, 0, size - 1), np.clip(high, 1, size)
    window = space.weights[low[0] + 1 : high[0] + 1, low[1] + 1 : high[1] + 1]
    row, col = np.floor(goal[::-1] / res).astype(np.int64) - low
    # A line between cells may lie in a blocked cell; start from its cheapest neighbour.
    near = window[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2]
    dr, dc = np.unravel_index(int(np.argmin(near)), near.shape)
    cell = (int(max(row - 1, 0) + dr), int(max(col - 1, 0) + dc))
    return low, cost_field(Weights.of(window), cell) * res


@njit(**CACHED)
def _search(
    space: ConfigurationSpace,
    guide: Floats,
    corner: Integers,
    seeds: Floats,
    goal: Floats,
    pivots: bool,
    budget: int,
) -> tuple[Floats, int]:
    """(legs (k, 5) from a seed to the goal, none if no path was found; expansions).

    A leg is its start pose, its curvature and its length; for a turn on the spot the curvature is
    infinite and the length is the turn.
    """
    nodes = empty_nodes(_MOTIONS * budget + seeds.shape[0] + 1, 24 * budget)
    heap = [(0.0, -1)]
    heap.pop()
    count = ZERO
    # Queue the free seeds.
    for s in range(seeds.shape[0]):
        ahead = _ahead(space, guide, corner, seeds[s, 0], seeds[s, 1])
        if ahead == np.inf or turn_overlaps(
            space.grown, seeds[s, 0], seeds[s, 1], seeds[s, 2], 0.0
        ):
            continue
        add_node(nodes, count, slot_of(nodes, seeds[s]), seeds[s], 0.0, NONE, 0.0)
        heapq.heappush(heap, (_EAGER * ahead, count))
        count += 1
    best, best_node, best_word = np.inf, -1, np.zeros((3, 2))
    expansions, enough = 0, budget
    fresh = np.empty(3)
    while len(heap) > 0 and expansions < enough:
        # Take the node with the lowest f, unless a cheaper one has taken its place in the table.
        f, u = heapq.heappop(heap)
        if f >= best:
            break
        here, so_far = nodes.pose[u], nodes.cost[u]
        if nodes.table[slot_of(nodes, here)] != u:
            continue
        expansions += 1
        # Try to reach the goal directly; after the first success, only some more poses.
        if expansions % _SHOTS == 1 or _is_near(here, goal):
            word, price = _shot(space, here, goal, best - so_far)
            if so_far + price < best:
                best, best_node, best_word = so_far + price, u, word
                enough = min(enough, 2 * expansions + _POLISH)
        # Queue the poses after each motion that are cheaper than before.
        for k in range(_MOTIONS if pivots else _ARCS):
            kappa, price = _move(space, here, k, nodes.bend[u], fresh)
            there = so_far + price
            if not there < best:
                continue
            slot = slot_of(nodes, fresh)
            if nodes.table[slot] >= 0 and nodes.cost[nodes.table[slot]] <= there:
                continue
            # The overlap tests are expensive, so they come last.
            ahead = _ahead(space, guide, corner, fresh[0], fresh[1])
            if ahead == np.inf or not _is_free(space, here, k, fresh):
                continue
            add_node(nodes, count, slot, fresh, there, u, kappa)
            heapq.heappush(heap, (there + _EAGER * ahead, count))
            count += 1
    if best_node < 0:
        return np.empty((0, 5)), expansions
    return _joined(nodes, best_node, best_word), expansions


@njit(**CACHED)
def _move(
    space: ConfigurationSpace, pose: Floats, k: int, bend: float, out: Floats
) -> tuple[float, float]:
    """Write the pose after motion k into ``out``; return (curvature, cost).

    ``bend`` is the curvature of the motion that led to ``pose``. A turn on the spot, of infinite
    curvature, costs more after a motion that is none.
    """
    if k < _ARCS:
        sharpest = _GENTLE * space.curvature
        kappa = sharpest * (-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0)[k]
        drive_arc(pose, kappa, _STEP, out)
        weight = weight_at(space, out[0], out[1])
        return kappa, _STEP * weight * (1.0 + _WIGGLE * (kappa / sharpest) ** 2)
    out[0], out[1], out[2] = pose[0], pose[1], pose[2] + _turn(k)
    return np.inf, _PIVOT_COST + (0.0 if bend == np.inf else _PIVOT_STOP)


@njit(**CACHED)
def _turn(k: int) -> float:
    """Angle of the turn on the spot k, rad."""
    return _PIVOT if k == _ARCS else -_PIVOT


@njit(**CACHED)
def _is_free(space: ConfigurationSpace, pose: Floats, k: int, after: Floats) -> bool:
    """Check that motion k from a pose overlaps nothing."""
    if k < _ARCS:
        return motion_is_free(space, pose, after)
    return not turn_overlaps(space.grown, after[0], after[1], pose[2], _turn(k))


@njit(**CACHED)
def _ahead(space: ConfigurationSpace, guide: Floats, corner: Integers, x: float, y: float) -> float:
    """Cost from a point to the goal over the plane, without the footprint; ∞ if unreachable, m."""
    res = space.footprint.resolution
    r = math.floor(y / res) - corner[0] + 1
    c = math.floor(x / res) - corner[1] + 1
    rows, cols = guide.shape
    if not (1 <= r < rows - 1 and 1 <= c < cols - 1):
        return np.inf
    best = float(guide[r, c])
    if best == np.inf:
        for i in range(r - 1, r + 2):
            for j in range(c - 1, c + 2):
                best = min(best, float(guide[i, j]) + res)
    return best


@njit(**CACHED)
def _is_near(pose: Floats, goal: Floats) -> bool:
    return math.hypot(pose[0] - goal[0], pose[1] - goal[1]) < 0.5


@njit(**CACHED)
def _shot(
    space: ConfigurationSpace, pose: Floats, goal: Floats, most: float
) -> tuple[Floats, float]:
    """(cheapest free Dubins word (3, 2) to the goal, its cost below ``most``); ∞ if none."""
    sharpest = _GENTLE * space.curvature
    tried = dubins_words(pose, goal, 1.0 / sharpest)
    best, found = most, np.zeros((3, 2))
    price = np.inf
    here, there = np.empty(3), np.empty(3)
    # Drive along each word, and stop where it is blocked or too expensive.
    for w in range(tried.shape[0]):
        length = tried[w, 0, 1] + tried[w, 1, 1] + tried[w, 2, 1]
        if not length < best:
            continue
        total = 0.0
        copy_row(here, pose)
        for k in range(3):
            kappa, part = tried[w, k, 0], tried[w, k, 1]
            count = math.ceil(part / _STEP - 1e-6)
            for _ in range(count):
                drive_arc(here, kappa, part / count, there)
                bend = 1.0 + _WIGGLE * (kappa / sharpest) ** 2
                weight = weight_at(space, there[0], there[1])
                total += part / count * bend * weight
                if total < best and not motion_is_free(space, here, there):
                    total = np.inf
                copy_row(here, there)
                if total >= best:
                    break
            if total >= best:
                break
        if total < best:
            best = price = total
            for k in range(3):
                copy_row(found[k], tried[w, k])
    return found, price


@njit(**CACHED)
def _joined(nodes: PoseNodes, last: int, word: Floats) -> Floats:
    """Legs (k, 5) from the seed to ``last`` and along the word; see _search."""
    pose, parent, bend = nodes.pose, nodes.parent, nodes.bend
    back = [last]
    while parent[back[-1]] >= 0:
        back.append(parent[back[-1]])
    n = len(back) - 1
    out = np.empty((n + 4, 5))
    for i in range(n):
        u, v = back[n - i], back[n - i - 1]
        copy_row(out[i], pose[u])
        out[i, 3] = bend[v]
        out[i, 4] = pose[v, 2] - pose[u, 2] if bend[v] == np.inf else _STEP
    copy_row(out[n], pose[last])
    for k in range(3):
        out[n + k, 3], out[n + k, 4] = word[k, 0], word[k, 1]
        drive_arc(out[n + k, :3], word[k, 0], word[k, 1], out[n + k + 1, :3])
    out[n + 3, 3] = out[n + 3, 4] = 0.0
    return out


@njit(**CACHED)
def _sampled(legs: Floats) -> tuple[Floats, Integers]:
    """(poses (m, 3) along legs, evenly spaced between turns on the spot; indices of the turns)."""
    n = legs.shape[0]
    poses = [legs[0, :3].copy()]
    pivots = [0]
    pivots.pop()
    first = 0
    while first < n:
        if legs[first, 3] == np.inf:
            if len(pivots) == 0 or pivots[-1] != len(poses) - 1:
                pivots.append(len(poses) - 1)
            first += 1
            continue
        stop, length = first, 0.0
        while stop < n and legs[stop, 3] != np.inf:
            length += legs[stop, 4]
            stop += 1
        count = math.ceil(length / _STEP - 1e-6)
        leg, before = first, 0.0
        for k in range(1, count + 1):
            at = length * k / count
            while leg < stop - 1 and before + legs[leg, 4] < at:
                before += legs[leg, 4]
                leg += 1
            fresh = np.empty(3)
            drive_arc(legs[leg, :3], legs[leg, 3], min(at - before, legs[leg, 4]), fresh)
            poses.append(fresh)
        first = stop
    out = np.empty((len(poses), 3))
    for i in range(len(poses)):
        copy_row(out[i], poses[i])
    return out, np.array(pivots, dtype=np.int64)
