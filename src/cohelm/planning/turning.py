"""A way for the robot's true shape: A* over (x, y, heading), where no smoothed line fits.

The robot drives arcs and straight lines, 0.1 m at a time, and where nothing else helps it turns on
the spot. What a way costs over the plane alone guides the search; from every few poses it tries to
reach the goal by arc, straight line and arc in one go (Dubins, 1957), so that it ends exactly
there. A goal without a heading is reached by arc and line. Poses in the grid's frame.
"""

from __future__ import annotations

import heapq
import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Floats32, Integers, Shape, value
from cohelm.maps.distance import sample
from cohelm.planning.fields import cost_field_from
from cohelm.planning.footprint import Body, overlaps, roomy, turn_overlaps
from cohelm.planning.search import Weights

_ORIGIN = np.zeros(3)
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


class Land(NamedTuple):
    """Where the search goes on; plain, so that kernels take it."""

    body: Body
    grown: Body
    """A little larger: what the search keeps free."""
    weights: Floats32
    """Packed, of the whole grid."""
    clearance: Floats32
    """(rows, cols), m: of the drive axle's centre, to obstacles and zones."""
    heaviest: float
    floor: float
    """Clearance that the drive axle's centre keeps, m."""
    radius: float
    """Cells with more clearance are blocked by something else, m."""
    curvature: float
    """The sharpest that the robot can drive, 1/m."""


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


@njit(cache=True)
def centre_fits(land: Land, x: float, y: float) -> bool:
    """Whether the drive axle's centre may be at a point, whatever the footprint does there."""
    body = land.body
    rows, cols = body.clearance.shape
    r, c = math.floor(y / body.resolution), math.floor(x / body.resolution)
    if not (0 <= r < rows and 0 <= c < cols):
        return False
    if land.weights[r + 1, c + 1] == np.inf and land.clearance[r, c] > land.radius:
        return False
    room, _, _ = sample(land.clearance, body.resolution, _ORIGIN, x, y)
    return room >= land.floor


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
def _search(  # noqa: PLR0915  # one hot loop over the kernel's own arrays
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
                _advance(pose[u], kappa, _STEP, fresh)
                weight = _weight(land, fresh[0], fresh[1])
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
            if k < 7 and not _drives(land, pose[u], fresh):
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
    slot = ((key * 0x9E3779B97F4A7C1) >> 20) & mask
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
    best = guide[r, c]
    if best == np.inf:
        for i in range(r - 1, r + 2):
            for j in range(c - 1, c + 2):
                best = min(best, guide[i, j] + res)
    return best


@njit(cache=True)
def _near(pose: Floats, goal: Floats) -> bool:
    return math.hypot(pose[0] - goal[0], pose[1] - goal[1]) < 0.5


@njit(cache=True)
def _advance(pose: Floats, kappa: float, length: float, out: Floats) -> None:
    """The pose after an arc of some curvature; into ``out``."""
    turn = kappa * length
    half = 0.5 * turn
    chord = length * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
    out[0] = pose[0] + chord * math.cos(pose[2] + half)
    out[1] = pose[1] + chord * math.sin(pose[2] + half)
    out[2] = pose[2] + turn


@njit(cache=True)
def _weight(land: Land, x: float, y: float) -> float:
    """The weight at a point; ∞ where the drive axle's centre must not be."""
    if not centre_fits(land, x, y):
        return np.inf
    res = land.body.resolution
    weight = np.float64(land.weights[math.floor(y / res) + 1, math.floor(x / res) + 1])
    return min(weight, land.heaviest)


@njit(cache=True)
def _drives(land: Land, a: Floats, b: Floats) -> bool:
    """Whether the robot, a little larger, can drive from a pose where it fits to one a step on."""
    body = land.grown
    length = math.hypot(b[0] - a[0], b[1] - a[1])
    if roomy(body, b[0], b[1], length):
        return True
    count = max(math.ceil(2.0 * length / body.resolution), 2)
    along = math.atan2(b[1] - a[1], b[0] - a[0])
    bends = abs(b[2] - a[2]) > 1e-9
    for k in range(count, -1, -1):
        t = k / count
        x, y = a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])
        if k > 0 and overlaps(body, x, y, a[2] + t * (b[2] - a[2])):
            return False
        if bends and overlaps(body, x, y, along):
            return False
    return True


@njit(cache=True)
def _shot(land: Land, pose: Floats, goal: Floats, most: float) -> tuple[Floats, float]:
    """(the cheapest free word (3, 2) of curvature and length to the goal, its cost); ∞ if none."""
    sharpest = _GENTLE * land.curvature
    words = _words(pose, goal, 1.0 / sharpest)
    best, found = most, np.zeros((3, 2))
    price = np.inf
    here, there = np.empty(3), np.empty(3)
    for w in range(words.shape[0]):
        length = words[w, 0, 1] + words[w, 1, 1] + words[w, 2, 1]
        if not length < best:
            continue
        total = 0.0
        here[:] = pose
        for k in range(3):
            kappa, part = words[w, k, 0], words[w, k, 1]
            count = math.ceil(part / _STEP - 1e-6)
            for _ in range(count):
                _advance(here, kappa, part / count, there)
                bend = 1.0 + _WIGGLE * (kappa / sharpest) ** 2
                weight = _weight(land, there[0], there[1])
                total += part / count * bend * weight
                if total < best and not _drives(land, here, there):
                    total = np.inf
                here[:] = there
                if total >= best:
                    break
            if total >= best:
                break
        if total < best:
            best = price = total
            found[:] = words[w]
    return found, price


@njit(cache=True)
def _words(pose: Floats, goal: Floats, radius: float) -> Floats:
    """Words (w, 3, 2) of (curvature, length): arc, line and arc to a pose, arc and line to a point.

    With centres of turning circles c, side σ = 1 left and −1 right, and headings φ of the line of
    length L: c₂ − c₁ = e^{iφ} L on the same side, e^{iφ} (L − 2iσ₁r) across; to a point,
    p − c₁ = e^{iφ} (L − iσ₁r).
    """
    to_point = math.isnan(goal[2])
    words = np.full((4, 3, 2), np.inf)
    for w in range(2 if to_point else 4):
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
        words[w, 0] = first / radius, radius * _full(first * (phi - pose[2]))
        words[w, 1] = 0.0, line
        words[w, 2] = second / radius, 0.0
        if not to_point:
            words[w, 2, 1] = radius * _full(second * (goal[2] - phi))
    return words


@njit(cache=True)
def _full(angle: float) -> float:
    """``angle`` in [0, 2π); a full turn less rounding is none."""
    turn = angle % (2.0 * math.pi)
    return turn if turn < 2.0 * math.pi - 1e-7 else 0.0


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
        _advance(out[n + k, :3], word[k, 0], word[k, 1], out[n + k + 1, :3])
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
            _advance(legs[leg, :3], legs[leg, 3], min(at - before, legs[leg, 4]), fresh)
            poses.append(fresh)
        first = stop
    out = np.empty((len(poses), 3))
    for i in range(len(poses)):
        out[i] = poses[i]
    return out, np.array(pivots, dtype=np.int64)
