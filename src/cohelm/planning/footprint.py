"""Does the footprint fit: the robot's outline at a pose against the cells that block.

The test is exact: a polygon, convex or not, overlaps a cell's square or it does not. A pose is
(x, y, heading) in the grid's frame, whose origin is the lower left corner. Touching is no overlap.
Beyond the grid's border nothing is known to stand, as for the clearance.

A polyline (n, 2) is driven with the heading of each segment, and with headings that turn evenly
from the mean direction at one point to that at the next; at each point the robot turns the short
way from one segment's direction to the next one's. Poses on the way are at most half a cell apart,
and so are those of the farthest corner in a turn.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Floats32, read_only
from cohelm.geometry import distance_to_polygon

_TOUCH = 1e-9
_APART, _APART_TURNING = 0.5, 0.2  # cells that poses, and farthest corners in turns, are apart


class Body(NamedTuple):
    """A robot on a map; plain, so that kernels take it."""

    clearance: Floats32
    """(rows, cols), m: signed distance from cell centres to what blocks; negative blocks."""
    resolution: float
    """m."""
    trust: float
    """The clearance is exact up to this, m; where it says more, it is at least this."""
    pieces: Floats
    """(p, 3, 2), triangles that make up the footprint, robot frame, m."""
    bound: Floats
    """(x, y, radius) of a disc about the footprint, robot frame, m."""
    discs: Floats
    """(d, 3) of smaller ones that cover it together, m."""
    reach: float
    """From the drive axle's centre to the farthest corner, m."""


def body_on(
    outline: Floats, clearance: Floats32, resolution: float, trust: float = math.inf
) -> Body:
    """The body with a footprint's outline (k, 2), counter-clockwise, robot frame, on a map."""
    middle = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
    radius = float(np.hypot(*(outline - middle).T).max())
    return Body(
        clearance=read_only(clearance),
        resolution=resolution,
        trust=trust,
        pieces=read_only(triangles(outline)),
        bound=read_only(np.array([*middle, radius])),
        discs=read_only(_covering(outline)),
        reach=float(np.hypot(*outline.T).max()),
    )


def backwards(body: Body) -> Body:
    """The body driving backwards."""
    bound = body.bound * np.array([-1.0, -1.0, 1.0])
    discs = body.discs * np.array([-1.0, -1.0, 1.0])
    pieces = -body.pieces
    bound.flags.writeable = discs.flags.writeable = pieces.flags.writeable = False
    return body._replace(pieces=pieces, bound=bound, discs=discs)


def triangles(outline: Floats) -> Floats:
    """A simple polygon (k, 2), counter-clockwise, cut into triangles (k - 2, 3, 2), ear by ear.

    Raises:
        ValueError: if the outline crosses itself, so that no ear is left.
    """
    left = [np.asarray(corner, dtype=float) for corner in outline]
    cut: list[Floats] = []
    while len(left) > 3:
        for i in range(len(left)):
            ear = np.stack([left[i - 1], left[i], left[(i + 1) % len(left)]])
            others = [p for j, p in enumerate(left) if (j - i + 1) % len(left) > 2]
            if _turns_left(ear) and not any(_covers(ear, p) for p in others):
                cut.append(ear)
                del left[i]
                break
        else:
            raise ValueError("the footprint's outline crosses itself")
    return np.stack([*cut, np.stack(left)])


def widened(outline: Floats, by: float) -> Floats:
    """An outline (k, 2), counter-clockwise, with its edges moved outward, m; corners stay sharp."""
    edges = np.roll(outline, -1, axis=0) - outline
    after = np.stack([edges[:, 1], -edges[:, 0]], axis=-1) / np.hypot(*edges.T)[:, None]
    before = np.roll(after, 1, axis=0)
    share: Floats = 1.0 + (before * after).sum(axis=1, keepdims=True)
    return np.asarray(outline + by * (before + after) / share)


@njit(cache=True)
def overlaps(body: Body, x: float, y: float, heading: float) -> bool:
    """Whether the footprint at a pose overlaps a cell that blocks."""
    cos, sin = math.cos(heading), math.sin(heading)
    if _clear_about(body, x, y, cos, sin):
        return False
    rows, cols = body.clearance.shape
    res = body.resolution
    corners = np.empty((3, 2))
    for p in range(body.pieces.shape[0]):
        low, high = np.inf, -np.inf
        for k in range(3):
            px, py = body.pieces[p, k, 0], body.pieces[p, k, 1]
            corners[k, 0] = x + cos * px - sin * py
            corners[k, 1] = y + sin * px + cos * py
            low, high = min(low, corners[k, 1]), max(high, corners[k, 1])
        first = max(math.floor((low + _TOUCH) / res), 0)
        last = min(math.ceil((high - _TOUCH) / res), rows)
        for r in range(first, last):
            left, right = _between(corners, r * res, (r + 1) * res)
            c = max(math.floor((left + _TOUCH) / res), 0)
            stop = min(math.ceil((right - _TOUCH) / res), cols)
            while c < stop:
                room = min(np.float64(body.clearance[r, c]), body.trust)
                if room < 0.0:
                    return True
                c += max(1, int(room / res))
    return False


@njit(cache=True)
def drive_overlaps(  # noqa: PLR0917  # a kernel takes plain arguments
    body: Body, ax: float, ay: float, bx: float, by: float, start: float, end: float
) -> bool:
    """Whether anything is met on the segment a–b, headings turning from ``start`` to ``end``."""
    length = math.hypot(bx - ax, by - ay)
    if roomy(body, 0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * length):
        return False
    along = math.atan2(by - ay, bx - ax) if length > 0.0 else start
    turn = turn_between(start, end)
    count = max(math.ceil(length / (_APART * body.resolution)), 1)
    for k in range(count + 1):
        t = k / count
        if overlaps(body, ax + t * (bx - ax), ay + t * (by - ay), along):
            return True
    if abs(turn) < 1e-9:
        return False
    count = math.ceil((length + abs(turn) * body.reach) / (_APART_TURNING * body.resolution))
    for k in range(count + 1):
        t = k / count
        if overlaps(body, ax + t * (bx - ax), ay + t * (by - ay), start + t * turn):
            return True
    return False


@njit(cache=True)
def turn_overlaps(body: Body, x: float, y: float, start: float, turn: float) -> bool:
    """Whether anything is met while the robot turns on the spot from heading ``start``."""
    if roomy(body, x, y, 0.0):
        return False
    count = max(math.ceil(abs(turn) * body.reach / (_APART_TURNING * body.resolution)), 1)
    for k in range(count + 1):  # noqa: SIM110  # numba compiles no generators
        if overlaps(body, x, y, start + turn * k / count):
            return True
    return False


@njit(cache=True)
def met_along(body: Body, points: Floats) -> Booleans:
    """At which points (n, 2) of a polyline, or on the segments beside them, anything is met; (n,).

    Points do not repeat.
    """
    n = points.shape[0]
    met = np.zeros(n, dtype=np.bool_)
    if n < 2:
        return met
    heading = directions(points)
    for i in range(n - 1):
        before = heading[max(i - 1, 0)]
        after = heading[min(i + 1, n - 2)]
        start = heading[i] - 0.5 * turn_between(before, heading[i])
        end = heading[i] + 0.5 * turn_between(heading[i], after)
        ax, ay, bx, by = points[i, 0], points[i, 1], points[i + 1, 0], points[i + 1, 1]
        if drive_overlaps(body, ax, ay, bx, by, start, end):
            met[i] = met[i + 1] = True
        if i > 0 and turn_overlaps(body, ax, ay, before, turn_between(before, heading[i])):
            met[i] = True
    return met


@njit(cache=True)
def roomy(body: Body, x: float, y: float, beside: float) -> bool:
    """Whether the robot can do what it likes within ``beside`` of a place."""
    return bool(_room(body, x, y) >= body.reach + beside)


@njit(cache=True)
def directions(points: Floats) -> Floats:
    """Direction (n - 1,) of each segment of a polyline (n, 2), rad."""
    out = np.empty(max(points.shape[0] - 1, 0))
    for i in range(out.shape[0]):
        out[i] = math.atan2(points[i + 1, 1] - points[i, 1], points[i + 1, 0] - points[i, 0])
    return out


@njit(cache=True)
def turn_between(start: float, end: float) -> float:
    """The turn from one heading to another, the short way, in (−π, π]."""
    return float(math.pi - (math.pi - (end - start)) % (2.0 * math.pi))


@njit(cache=True)
def spare(body: Body, x: float, y: float, heading: float) -> float:
    """A lower bound of the gap between the footprint at a pose and what blocks, m."""
    cos, sin = math.cos(heading), math.sin(heading)
    least = np.inf
    for k in range(body.discs.shape[0]):
        bx, by = body.discs[k, 0], body.discs[k, 1]
        room = _room(body, x + cos * bx - sin * by, y + sin * bx + cos * by)
        least = min(least, room - body.discs[k, 2])
    return least


@njit(cache=True)
def _clear_about(body: Body, x: float, y: float, cos: float, sin: float) -> bool:
    bx, by = body.bound[0], body.bound[1]
    if _room(body, x + cos * bx - sin * by, y + sin * bx + cos * by) >= body.bound[2]:
        return True
    for k in range(body.discs.shape[0]):
        bx, by = body.discs[k, 0], body.discs[k, 1]
        if _room(body, x + cos * bx - sin * by, y + sin * bx + cos * by) < body.discs[k, 2]:
            return False
    return True


@njit(cache=True)
def _room(body: Body, x: float, y: float) -> float:
    """A lower bound of the distance to what blocks: the cell's own, less what that may be off."""
    rows, cols = body.clearance.shape
    r = min(max(math.floor(y / body.resolution), 0), rows - 1)
    c = min(max(math.floor(x / body.resolution), 0), cols - 1)
    cx = min(max(x, 0.0), cols * body.resolution) - (c + 0.5) * body.resolution
    cy = min(max(y, 0.0), rows * body.resolution) - (r + 0.5) * body.resolution
    room = min(np.float64(body.clearance[r, c]), body.trust)
    return float(room - math.hypot(cx, cy) - 0.21 * body.resolution)


@njit(cache=True)
def _between(corners: Floats, low: float, high: float) -> tuple[float, float]:
    """(least, greatest x) of a triangle (3, 2) strictly between two heights; (∞, −∞) if none."""
    left, right = np.inf, -np.inf
    for k in range(3):
        ax, ay = corners[k, 0], corners[k, 1]
        bx, by = corners[(k + 1) % 3, 0], corners[(k + 1) % 3, 1]
        if ay > by:
            ax, ay, bx, by = bx, by, ax, ay
        if by <= low + _TOUCH or ay >= high - _TOUCH:
            continue
        slope = (bx - ax) / (by - ay) if by > ay else 0.0
        x0 = ax + slope * (max(ay, low) - ay)
        x1 = bx - slope * (by - min(by, high))
        left = min(left, x0, x1)
        right = max(right, x0, x1)
    return left, right


def _covering(outline: Floats) -> Floats:
    """Discs (4, 3) through the corners of quarters of the bounding rectangle, cut across."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    long = int(np.argmax(high - low))
    part = (high - low)[long] / 4.0
    discs = np.empty((4, 3))
    discs[:, long] = low[long] + part * (np.arange(4) + 0.5)
    discs[:, 1 - long] = 0.5 * (low + high)[1 - long]
    discs[:, 2] = 0.5 * np.hypot(part, (high - low)[1 - long])
    return discs


def _turns_left(corner: Floats) -> bool:
    (ax, ay), (bx, by), (cx, cy) = corner
    return bool((bx - ax) * (cy - by) - (by - ay) * (cx - bx) > 0.0)


def _covers(ear: Floats, point: Floats) -> bool:
    same = (np.abs(ear - point).max(axis=1) == 0.0).any()
    return not same and distance_to_polygon(ear, point[0], point[1]) <= 0.0
