"""A way for the robot's true shape: A* over (x, y, heading), where no smoothed line fits.

The robot drives arcs and straight lines, 0.1 m at a time, and where nothing else helps it turns on
the spot. What a way costs over the plane alone guides the search; from every few poses it tries to
reach the goal by arc, straight line and arc in one go (Dubins, 1957), so that it ends exactly
there. A goal without a heading is reached by arc and line. Poses in the grid's frame.
"""

from __future__ import annotations

import heapq
import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.planning.dubins import advance, words
from cohelm.planning.fields import cost_field_from
from cohelm.planning.footprint import turn_overlaps
from cohelm.planning.land import Land, drives, weight_at
from cohelm.planning.search import Weights

_STEP = 0.1  # m
_GENTLE = 0.97  # share of the sharpest curvature that is driven: chords bend more than their arcs
_CELL = 0.05  # m; poses in one such square and one sector are taken as one
_SECTORS = 128
_PIVOT = math.pi / 16.0  # rad turned on the spot at a time
_PIVOT_COST, _PIVOT_STOP = 0.15, 1.0  # m for each such turn, and for stopping to turn
_WIGGLE = 0.2  # share by which the sharpest arc is dearer than a straight line
_EAGER = 1.2  # weight of the guide
_POLISH = 100  # poses more, beside as many as it took, that may better a way once one is found
_SHOTS = 4  # every so many poses a shot at the goal


@value
class Turned:
    """A way that the footprint can follow."""

    points: Annotated[Floats, Shape("k 2")]
    """m; where the robot turns on the spot, one point."""
    pivots: Annotated[Integers, Shape("p")]
    """Indices of those."""
    begun: float
    """Heading at the start, rad."""
    heading: float
    """Heading at the end, rad."""


def turn_through(
    land: Land, seeds: Floats, goal: Floats, *, reach: float, pivots: bool, budget: int
) -> tuple[Turned | None, int]:
    """A way from any of some poses to a goal, and how many poses were looked at.

    Args:
        land: where.
        seeds: (m, 3), poses to start from, all at one place.
        goal: (x, y, heading); heading NaN: any.
        reach: beyond the box about start and goal that the way may go, m.
        pivots: whether the robot may turn on the spot.
        budget: poses to look at.
    """
    corner, guide = _guide(land, seeds[0, :2], goal[:2], reach)
    legs, looked = _search(land, guide, corner, seeds, goal, pivots, budget)
    if not len(legs):
        return None, looked
    poses, still = _sampled(legs)
    begun, heading = float(poses[0, 2]), float(poses[-1, 2])
    return Turned(points=poses[:, :2], pivots=still, begun=begun, heading=heading), looked


def _guide(land: Land, start: Floats, goal: Floats, reach: float) -> tuple[Integers, Floats]:
    """(first packed row and column of a window, cost to go to the goal from its cells, m)."""
    res = land.body.resolution
    size = np.array(land.weights.shape) - 2
    reach = min(reach, res * float(size.max()))
    low = np.floor((np.minimum(start, goal) - reach) / res).astype(np.int64)[::-1]
    high = np.floor((np.maximum(start, goal) + reach) / res).astype(np.int64)[::-1] + 1
    low, high = np.clip(low, 0, size - 1), np.clip(high, 1, size)
    window = land.weights[low[0] + 1 : high[0] + 1, low[1] + 1 : high[1] + 1]
    row, col = np.floor(goal[::-1] / res).astype(np.int64) - low
    # A line between cells may pass where its own cell is blocked; its neighbour is not.
    near = window[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2]
    dr, dc = np.unravel_index(int(np.argmin(near)), near.shape)
    cell = (int(max(row - 1, 0) + dr), int(max(col - 1, 0) + dc))
    return low, cost_field_from(Weights.of(window), cell) * res


@njit(cache=True)
def _search(  # noqa: PLR0912, PLR0915, PLR0917  # one hot loop over its own arrays
    land: Land,
    guide: Floats,
    corner: Integers,
    seeds: Floats,
    goal: Floats,
    pivots: bool,
    budget: int,
) -> tuple[Floats, int]:
    """(legs (k, 5) from a seed to the goal, none where no way was found; poses looked at).

    A leg is the pose that it starts from, its curvature and its length; where the robot turns on
    the spot the curvature is infinite and the length is the turn.
    """
    size = 64
    while size < 24 * budget:
        size *= 2
    table = np.full(size, -1, dtype=np.int64)
    keys = np.empty(size, dtype=np.int64)
    pool = 9 * budget + seeds.shape[0] + 1
    pose = np.empty((pool, 3))
    cost = np.empty(pool)
    parent = np.empty(pool, dtype=np.int64)
    bend = np.empty(pool)
    heap = [(0.0, -1)]
    heap.pop()
    count = 0
    for s in range(seeds.shape[0]):
        ahead = _ahead(land, guide, corner, seeds[s, 0], seeds[s, 1])
        if ahead == np.inf or turn_overlaps(land.grown, seeds[s, 0], seeds[s, 1], seeds[s, 2], 0.0):
            continue
        pose[count], cost[count], parent[count], bend[count] = seeds[s], 0.0, -1, 0.0
        table[_slot(table, keys, pose[count])] = count
        heapq.heappush(heap, (_EAGER * ahead, count))
        count += 1
    sharpest = _GENTLE * land.curvature
    best, best_node, best_word = np.inf, -1, np.zeros((3, 2))
    looked, enough = 0, budget
    fresh = np.empty(3)
    while len(heap) > 0 and looked < enough:
        f, u = heapq.heappop(heap)
        if f >= best:
            break
        if table[_slot(table, keys, pose[u])] != u:
            continue
        looked += 1
        if looked % _SHOTS == 1 or _near(pose[u], goal):
            word, price = _shot(land, pose[u], goal, best - cost[u])
            if cost[u] + price < best:
                best, best_node, best_word = cost[u] + price, u, word
                enough = min(enough, 2 * looked + _POLISH)
        for k in range(9 if pivots else 7):
            if k < 7:
                kappa = sharpest * (-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0)[k]
                advance(pose[u], kappa, _STEP, fresh)
                weight = weight_at(land, fresh[0], fresh[1])
                price = _STEP * weight * (1.0 + _WIGGLE * (kappa / sharpest) ** 2)
            else:
                turn = _PIVOT if k == 7 else -_PIVOT
                fresh[0], fresh[1], fresh[2] = pose[u, 0], pose[u, 1], pose[u, 2] + turn
                kappa = np.inf
                weight = 1.0
                price = _PIVOT_COST + (0.0 if bend[u] == np.inf else _PIVOT_STOP)
            there = cost[u] + price
            if not there < best:
                continue
            slot = _slot(table, keys, fresh)
            if table[slot] >= 0 and cost[table[slot]] <= there:
                continue
            ahead = _ahead(land, guide, corner, fresh[0], fresh[1])
            if ahead == np.inf:
                continue
            if k < 7 and not drives(land, pose[u], fresh):
                continue
            if k >= 7 and turn_overlaps(land.grown, fresh[0], fresh[1], pose[u, 2], turn):
                continue
            pose[count], cost[count], parent[count], bend[count] = fresh, there, u, kappa
            table[slot] = count
            heapq.heappush(heap, (there + _EAGER * ahead, count))
            count += 1
    if best_node < 0:
        return np.empty((0, 5)), looked
    return _joined(pose, bend, parent, best_node, best_word), looked


@njit(cache=True)
def _slot(table: Integers, keys: Integers, pose: Floats) -> int:
    """Where the table keeps the pose's square and sector; its key is noted there."""
    x, y = math.floor(pose[0] / _CELL), math.floor(pose[1] / _CELL)
    sector = round(pose[2] * _SECTORS / (2.0 * math.pi)) % _SECTORS
    key = ((y + (1 << 24)) << 32) + ((x + (1 << 20)) << 7) + sector
    mask = table.shape[0] - 1
    slot: int = ((key * 0x9E3779B97F4A7C1) >> 20) & mask
    while table[slot] >= 0 and keys[slot] != key:
        slot = (slot + 1) & mask
    keys[slot] = key
    return slot


@njit(cache=True)
def _ahead(land: Land, guide: Floats, corner: Integers, x: float, y: float) -> float:
    """What the way to the goal costs from a point over the plane alone; ∞ where none leads, m."""
    res = land.body.resolution
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


@njit(cache=True)
def _near(pose: Floats, goal: Floats) -> bool:
    return math.hypot(pose[0] - goal[0], pose[1] - goal[1]) < 0.5


@njit(cache=True)
def _shot(land: Land, pose: Floats, goal: Floats, most: float) -> tuple[Floats, float]:
    """(the cheapest free word (3, 2) of curvature and length to the goal, its cost); ∞ if none."""
    sharpest = _GENTLE * land.curvature
    tried = words(pose, goal, 1.0 / sharpest)
    best, found = most, np.zeros((3, 2))
    price = np.inf
    here, there = np.empty(3), np.empty(3)
    for w in range(tried.shape[0]):
        length = tried[w, 0, 1] + tried[w, 1, 1] + tried[w, 2, 1]
        if not length < best:
            continue
        total = 0.0
        here[:] = pose
        for k in range(3):
            kappa, part = tried[w, k, 0], tried[w, k, 1]
            count = math.ceil(part / _STEP - 1e-6)
            for _ in range(count):
                advance(here, kappa, part / count, there)
                bend = 1.0 + _WIGGLE * (kappa / sharpest) ** 2
                weight = weight_at(land, there[0], there[1])
                total += part / count * bend * weight
                if total < best and not drives(land, here, there):
                    total = np.inf
                here[:] = there
                if total >= best:
                    break
            if total >= best:
                break
        if total < best:
            best = price = total
            found[:] = tried[w]
    return found, price


@njit(cache=True)
def _joined(pose: Floats, bend: Floats, parent: Integers, last: int, word: Floats) -> Floats:
    """The legs (k, 5) from the seed to ``last`` and along the word; see _search."""
    back = [last]
    while parent[back[-1]] >= 0:
        back.append(parent[back[-1]])
    n = len(back) - 1
    out = np.empty((n + 4, 5))
    for i in range(n):
        u, v = back[n - i], back[n - i - 1]
        out[i, :3], out[i, 3] = pose[u], bend[v]
        out[i, 4] = pose[v, 2] - pose[u, 2] if bend[v] == np.inf else _STEP
    out[n, :3] = pose[last]
    for k in range(3):
        out[n + k, 3:] = word[k]
        advance(out[n + k, :3], word[k, 0], word[k, 1], out[n + k + 1, :3])
    out[n + 3, 3:] = 0.0
    return out


@njit(cache=True)
def _sampled(legs: Floats) -> tuple[Floats, Integers]:
    """(poses (m, 3) along legs, evenly spaced between the turns on the spot; indices of those)."""
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
            advance(legs[leg, :3], legs[leg, 3], min(at - before, legs[leg, 4]), fresh)
            poses.append(fresh)
        first = stop
    out = np.empty((len(poses), 3))
    for i in range(len(poses)):
        out[i] = poses[i]
    return out, np.array(pivots, dtype=np.int64)
