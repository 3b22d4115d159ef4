"""Hybrid A* over (x, y, heading) for the robot's footprint, where no smoothed line fits.

The robot drives arcs and straight lines of 0.1 m, and, if that is allowed, turns on the spot and
drives backwards. The cost field over the plane guides the search. From every few poses it tries a
Dubins path (arc, straight line, arc) to the goal in each gear, so that it ends exactly there; a
goal without a heading is reached by arc and line. Poses are in the grid's frame.

A leg of a path is a row: the pose at its start, its curvature and its length, negative backwards;
for a turn on the spot the curvature is infinite and the length is the turn.

Arcs and straight lines that lead to a pose are those of Dubins (1957). Reached poses are kept in a
hash table.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import field
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import NONE, ZERO, copy_row
from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.kernels import CACHED, callee
from cohelm.planning.grid_search.cost_field import cost_field
from cohelm.planning.grid_search.weights import Weights
from cohelm.planning.path_refinement.configuration_space import (
    ConfigurationSpace,
    motion_is_free,
    weight_at,
)
from cohelm.planning.path_refinement.footprint import turn_overlaps

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


@callee()
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


@callee()
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


@callee()
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


@njit(**CACHED)
def drive_arc(pose: Floats, kappa: float, length: float, out: Floats) -> None:
    """Write the pose after an arc of curvature ``kappa`` (1/m) and a length (m) into ``out``."""
    turn = kappa * length
    half = 0.5 * turn
    chord = length * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
    out[0] = pose[0] + chord * math.cos(pose[2] + half)
    out[1] = pose[1] + chord * math.sin(pose[2] + half)
    out[2] = pose[2] + turn


@njit(**CACHED)
def dubins_words(pose: Floats, goal: Floats, radius: float) -> Floats:
    """Words (w, 3, 2) of (curvature, length): arc, line, arc to a pose; arc, line to a point.

    With centres of turning circles c, side σ = 1 left and −1 right, and headings φ of the line of
    length L: c₂ − c₁ = e^{iφ} L on the same side, e^{iφ} (L − 2iσ₁r) across; to a point,
    p − c₁ = e^{iφ} (L − iσ₁r). A goal whose heading is NaN is a point.
    """
    to_point = math.isnan(goal[2])
    out = np.full((4, 3, 2), np.inf)
    for w in range(2 if to_point else 4):
        # Sides of the first and the last circle: LL, RR, LR, RL.
        first = 1.0 if w % 2 == 0 else -1.0
        second = first if w < 2 else -first
        dx = goal[0] - (pose[0] - first * radius * math.sin(pose[2]))
        dy = goal[1] - (pose[1] + first * radius * math.cos(pose[2]))
        aside = first * radius
        if not to_point:
            dx -= second * radius * math.sin(goal[2])
            dy += second * radius * math.cos(goal[2])
            aside = 0.0 if w < 2 else 2.0 * first * radius
        square = dx * dx + dy * dy - aside * aside
        if square < 0.0:
            continue
        line = math.sqrt(square)
        phi = math.atan2(dy, dx) + math.atan2(aside, line)
        out[w, 0] = first / radius, radius * _full(first * (phi - pose[2]))
        out[w, 1] = 0.0, line
        out[w, 2] = second / radius, 0.0
        if not to_point:
            out[w, 2, 1] = radius * _full(second * (goal[2] - phi))
    return out


@callee()
def _full(angle: float) -> float:
    """``angle`` in [0, 2π); a full turn except for rounding becomes 0."""
    turn = angle % (2.0 * math.pi)
    return turn if turn < 2.0 * math.pi - 1e-7 else 0.0


STEP = 0.1
"""Length of a motion of the search, and distance between poses of a path, m."""


@callee()
def joined_legs(nodes: PoseNodes, last: int, word: Floats) -> Floats:
    """Legs (k, 5) from the seed to ``last`` and along the word."""
    pose, parent, bend = nodes.pose, nodes.parent, nodes.bend
    back = [last]
    while parent[back[-1]] >= 0:
        back.append(parent[back[-1]])
    n = len(back) - 1
    out = np.empty((n + 4, 5))
    for i in range(n):
        u, v = back[n - i], back[n - i - 1]
        copy_row(out[i], pose[u])
        out[i, 3], out[i, 4] = bend[v], nodes.length[v]
    copy_row(out[n], pose[last])
    for k in range(3):
        out[n + k, 3], out[n + k, 4] = word[k, 0], word[k, 1]
        drive_arc(out[n + k, :3], word[k, 0], word[k, 1], out[n + k + 1, :3])
    out[n + 3, 3] = out[n + 3, 4] = 0.0
    return out


@njit(**CACHED)
def sampled_poses(legs: Floats) -> tuple[Floats, Integers, Integers]:
    """(poses (m, 3) along legs, indices of turns on the spot, and of changes of gear).

    Poses are evenly spaced between these places.
    """
    n = legs.shape[0]
    poses = [legs[0, :3].copy()]
    pivots, cusps = [0], [0]
    pivots.pop()
    cusps.pop()
    first, gear = 0, 0.0
    while first < n:
        if legs[first, 3] == np.inf:
            if len(pivots) == 0 or pivots[-1] != len(poses) - 1:
                pivots.append(len(poses) - 1)
            first += 1
            continue
        # A stretch in one gear.
        stop, length = first, 0.0
        while stop < n and legs[stop, 3] != np.inf and legs[stop, 4] * length >= 0.0:
            length += legs[stop, 4]
            stop += 1
        if length * gear < 0.0:
            cusps.append(len(poses) - 1)
        if length != 0.0:
            gear = length
        count = math.ceil(abs(length) / STEP - 1e-6)
        leg, before = first, 0.0
        for k in range(1, count + 1):
            at = abs(length) * k / count
            while leg < stop - 1 and before + abs(legs[leg, 4]) < at:
                before += abs(legs[leg, 4])
                leg += 1
            part = math.copysign(min(at - before, abs(legs[leg, 4])), length)
            fresh = np.empty(3)
            drive_arc(legs[leg, :3], legs[leg, 3], part, fresh)
            poses.append(fresh)
        first = stop
    out = np.empty((len(poses), 3))
    for i in range(len(poses)):
        copy_row(out[i], poses[i])
    return out, np.array(pivots, dtype=np.int64), np.array(cusps, dtype=np.int64)


_GENTLE = 0.97  # share of the largest curvature that is used: chords bend more than their arcs
_ARCS, _TURNS, _MOTIONS = 7, 9, 16
"""The motions of a step end there: seven arcs, a turn on the spot to either side, the same seven
arcs backwards."""
_PIVOT = math.pi / 16.0  # rad turned on the spot at a time
_PIVOT_COST, _PIVOT_STOP = 0.15, 1.0  # m for each such turn, and for the stop before
_BACKWARD = 2.0  # metres forward that a metre backwards is worth
_CUSP = 1.0  # m for the stop at a change of gear
_WIGGLE = 0.2  # extra cost of the sharpest arc, as a share of its length
_EAGER, _EAGER_BOTH = 1.2, 2.0
"""Weight of the heuristic, and in a search in both gears, in which a metre may cost two."""
_POLISH = 100  # poses, besides as many again as it took, to improve the first path
_SHOTS = 4  # poses between two attempts to reach the goal directly


@value
class HybridPath:
    """Path that the footprint can follow."""

    points: Annotated[Floats, Shape("k 2")]
    """m; a turn on the spot is one point."""
    pivots: Annotated[Integers, Shape("p")]
    """Indices of the points where the robot turns on the spot."""
    cusps: Annotated[Integers, Shape("c")] = field(default_factory=lambda: np.empty(0, np.int64))
    """Indices of the points where the robot changes its gear."""
    backs_out: bool = False
    """The first stretch is driven backwards."""
    start_heading: float
    """Heading at the start, rad."""
    end_heading: float
    """Heading at the end, rad."""
    cost: float = math.nan
    """Weighted length and the cost of stops, turns and driving backwards, m."""


class SearchLimits(NamedTuple):
    """Limits of one search."""

    reach: float
    """Distance that the path may leave the box around start and goal, m."""
    pivots: bool
    """Turns on the spot are allowed."""
    budget: int = 1
    """Poses that may be expanded."""
    reverse: bool = False
    """Driving backwards is allowed."""
    below: float = math.inf
    """Cost that the path must not reach, m."""
    from_end: bool = False
    """The seeds are where the path ends and the goal is where it begins: a narrow end is easier to
    leave than to find."""


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
    legs, cost, expansions = _search(space, guide, corner, seeds, goal, limits)
    if not len(legs):
        return None, expansions
    poses, pivots, cusps = sampled_poses(legs)
    driven = legs[(legs[:, 3] != np.inf) & (legs[:, 4] != 0.0), 4]
    if limits.from_end:
        poses, driven, last = poses[::-1], -driven[::-1], len(poses) - 1
        pivots, cusps = last - pivots[::-1], last - cusps[::-1]
    path = HybridPath(
        points=poses[:, :2],
        pivots=pivots,
        cusps=cusps,
        backs_out=bool(len(driven) and driven[0] < 0.0),
        start_heading=float(poses[0, 2]),
        end_heading=float(poses[-1, 2]),
        cost=cost,
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
    limits: SearchLimits,
) -> tuple[Floats, float, int]:
    """(legs (k, 5) from a seed to the goal, none if no path was found; cost; expansions).

    A leg is its start pose, its curvature and its length, negative backwards; for a turn on the
    spot the curvature is infinite and the length is the turn.
    """
    budget, eager = limits.budget, _EAGER_BOTH if limits.reverse else _EAGER
    nodes = empty_nodes(
        _MOTIONS * budget + seeds.shape[0] + 1, 24 * budget, 2 if limits.reverse else 1
    )
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
        add_node(nodes, count, slot_of(nodes, seeds[s]), seeds[s], 0.0, NONE, (0.0, 0.0))
        heapq.heappush(heap, (eager * ahead, count))
        count += 1
    best, best_node, best_word = limits.below, -1, np.zeros((3, 2))
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
            word, price = _best_shot(space, nodes, u, goal, limits, best)
            if price < best:
                best, best_node, best_word = price, u, word
                enough = min(enough, 2 * expansions + _POLISH)
        # Queue the poses after each motion that are cheaper than before.
        for k in range(_MOTIONS if limits.reverse else _TURNS):
            if _ARCS <= k < _TURNS and not limits.pivots:
                continue
            motion, price = _move(space, limits, nodes, u, k, fresh)
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
            add_node(nodes, count, slot, fresh, there, u, motion)
            heapq.heappush(heap, (there + eager * ahead, count))
            count += 1
    if best_node < 0:
        return np.empty((0, 5)), np.inf, expansions
    return joined_legs(nodes, best_node, best_word), best, expansions


@callee()
def _move(
    space: ConfigurationSpace, limits: SearchLimits, nodes: PoseNodes, u: int, k: int, out: Floats
) -> tuple[tuple[float, float], float]:
    """Write the pose after motion k from node u into ``out``; return ((curvature, length), cost).

    A turn on the spot, of infinite curvature, costs more after a motion that is none.
    """
    pose = nodes.pose[u]
    if _ARCS <= k < _TURNS:
        turn = _PIVOT if k == _ARCS else -_PIVOT
        out[0], out[1], out[2] = pose[0], pose[1], pose[2] + turn
        return (np.inf, turn), _PIVOT_COST + (0.0 if nodes.bend[u] == np.inf else _PIVOT_STOP)
    gear, bend = (1.0, k) if k < _ARCS else (-1.0, k - _TURNS)
    sharpest = _GENTLE * space.curvature
    kappa = sharpest * (-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0)[bend]
    drive_arc(pose, kappa, gear * STEP, out)
    cost = STEP * weight_at(space, out[0], out[1]) * (1.0 + _WIGGLE * (kappa / sharpest) ** 2)
    cost *= _scale(limits, gear)
    return (kappa, gear * STEP), cost + _gear_cost(nodes, u, gear)


@callee()
def _scale(limits: SearchLimits, gear: float) -> float:
    """Metres forward that a metre in a gear of the search is worth."""
    return _BACKWARD if (gear < 0.0) != limits.from_end else 1.0


@callee()
def _gear_cost(nodes: PoseNodes, u: int, gear: float) -> float:
    """Cost of the stop if a motion in a gear after node u changes the gear, m.

    A robot that turns on the spot stands already.
    """
    return _CUSP if nodes.bend[u] < np.inf and gear * nodes.length[u] < 0.0 else 0.0


@callee()
def _is_free(space: ConfigurationSpace, pose: Floats, k: int, after: Floats) -> bool:
    """Check that motion k from a pose overlaps nothing."""
    if _ARCS <= k < _TURNS:
        return not turn_overlaps(space.grown, after[0], after[1], pose[2], after[2] - pose[2])
    return motion_is_free(space, pose, after)


@callee()
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


@callee()
def _is_near(pose: Floats, goal: Floats) -> bool:
    return math.hypot(pose[0] - goal[0], pose[1] - goal[1]) < 0.5


@callee()
def _best_shot(
    space: ConfigurationSpace,
    nodes: PoseNodes,
    u: int,
    goal: Floats,
    limits: SearchLimits,
    most: float,
) -> tuple[Floats, float]:
    """(word (3, 2) from node u in the better gear, cost with it from a seed); ∞ from ``most``."""
    found, price = np.zeros((3, 2)), np.inf
    for gear in (1.0, -1.0):
        if gear < 0.0 and not limits.reverse:
            break
        begun = nodes.cost[u] + _gear_cost(nodes, u, gear)
        word, more = _shot(space, nodes.pose[u], goal, gear, _scale(limits, gear), most - begun)
        if begun + more < most:
            most = price = begun + more
            found = word
    return found, price


@callee()
def _shot(
    space: ConfigurationSpace, pose: Floats, goal: Floats, gear: float, scale: float, most: float
) -> tuple[Floats, float]:
    """(cheapest free Dubins word (3, 2) to the goal, its cost below ``most``); ∞ if none.

    Backwards, with a gear of −1, it is the word of the robot that is turned about, with negative
    curvatures and lengths.
    """
    sharpest = _GENTLE * space.curvature
    about = 0.0 if gear > 0.0 else math.pi
    ahead = np.array([0.0, 0.0, about])
    tried = dubins_words(pose + ahead, goal + ahead, 1.0 / sharpest)
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
            kappa, part = gear * tried[w, k, 0], tried[w, k, 1]
            count = math.ceil(part / STEP - 1e-6)
            for _ in range(count):
                drive_arc(here, kappa, gear * part / count, there)
                bend = scale * (1.0 + _WIGGLE * (kappa / sharpest) ** 2)
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
                found[k, 0], found[k, 1] = gear * tried[w, k, 0], gear * tried[w, k, 1]
    return found, price
