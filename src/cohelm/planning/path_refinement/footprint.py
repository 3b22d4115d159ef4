"""Exact overlap test of the robot's footprint at a pose with the blocked cells of a map.

A polygon, convex or not, is tested against the squares of cells; touching is not an overlap. A pose
is (x, y, heading) in the grid's frame, whose origin is the lower left corner. Space beyond the
grid's border is free, as for the clearance.

A polyline (n, 2) is driven with the heading of each segment, and with headings that turn evenly
from the mean direction at one point to that at the next; at each point the robot turns by the
smaller angle from one segment's direction to that of the next. Tested poses are at most half a cell
apart, and so are those of the farthest corner in a turn.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Floats32, read_only
from cohelm.geometry import distance_to_polygon
from cohelm.kernels import CACHED, callee

_TOUCH = 1e-9
_APART, _APART_TURNING = (
    0.5,
    0.2,
)  # cells between tested poses, and between farthest corners in turns


class FootprintModel(NamedTuple):
    """Footprint of a robot and the map's clearance; for kernels."""

    clearance: Floats32
    """Signed distance from cell centres to obstacles, (rows, cols), m; negative cells block."""
    resolution: float
    """m."""
    trust: float
    """The clearance is exact up to this value, m; a larger clearance is at least this."""
    pieces: Floats
    """Triangles of the footprint, (p, 3, 2), robot frame, m."""
    bound: Floats
    """(x, y, radius) of a disc around the footprint, robot frame, m."""
    discs: Floats
    """Smaller discs that cover the footprint together, (d, 3), m."""
    reach: float
    """Distance from the centre of the drive axle to the farthest corner, m."""


def footprint_model(
    outline: Floats, clearance: Floats32, resolution: float, trust: float = math.inf
) -> FootprintModel:
    """Create the model of an outline (k, 2), counter-clockwise, robot frame, on a map."""
    middle = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
    radius = float(np.hypot(*(outline - middle).T).max())
    pieces, discs = _parts(tuple(map(tuple, outline.tolist())))
    return FootprintModel(
        clearance=read_only(clearance),
        resolution=resolution,
        trust=trust,
        pieces=pieces,
        bound=read_only(np.array([*middle, radius])),
        discs=discs,
        reach=float(np.hypot(*outline.T).max()),
    )


@lru_cache(maxsize=16)  # every plan of a ride has the same few outlines
def _parts(corners: tuple[tuple[float, float], ...]) -> tuple[Floats, Floats]:
    """(triangles (p, 3, 2), covering discs (d, 3)) of an outline."""
    outline = np.array(corners)
    return read_only(triangulate(outline)), read_only(_covering(outline))


def reversed_footprint(footprint: FootprintModel) -> FootprintModel:
    """Footprint rotated by 180°, for driving backwards."""
    bound = footprint.bound * np.array([-1.0, -1.0, 1.0])
    discs = footprint.discs * np.array([-1.0, -1.0, 1.0])
    pieces = -footprint.pieces
    bound.flags.writeable = discs.flags.writeable = pieces.flags.writeable = False
    return footprint._replace(pieces=pieces, bound=bound, discs=discs)


def triangulate(outline: Floats) -> Floats:
    """Triangles (k - 2, 3, 2) of a simple polygon (k, 2), counter-clockwise, by ear clipping.

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


def offset_outline(outline: Floats, by: float) -> Floats:
    """Outline (k, 2), counter-clockwise, with its edges moved outward, m; corners stay sharp."""
    edges = np.roll(outline, -1, axis=0) - outline
    after = np.stack([edges[:, 1], -edges[:, 0]], axis=-1) / np.hypot(*edges.T)[:, None]
    before = np.roll(after, 1, axis=0)
    share: Floats = 1.0 + (before * after).sum(axis=1, keepdims=True)
    return np.asarray(outline + by * (before + after) / share)


@njit(**CACHED)
def overlaps(footprint: FootprintModel, x: float, y: float, heading: float) -> bool:
    """Check that the footprint at a pose overlaps a blocked cell."""
    cos, sin = math.cos(heading), math.sin(heading)
    if _is_clear(footprint, x, y, cos, sin):
        return False
    # For each triangle, visit the cells of each row that it covers.
    rows, cols = footprint.clearance.shape
    res = footprint.resolution
    corners = np.empty((3, 2))
    for p in range(footprint.pieces.shape[0]):
        low, high = np.inf, -np.inf
        for k in range(3):
            px, py = footprint.pieces[p, k, 0], footprint.pieces[p, k, 1]
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
                clearance = min(np.float64(footprint.clearance[r, c]), footprint.trust)
                if clearance < 0.0:
                    return True
                c += max(1, int(clearance / res))  # no cell within that distance blocks
    return False


@njit(**CACHED)
def segment_overlaps(
    footprint: FootprintModel, ax: float, ay: float, bx: float, by: float, start: float, end: float
) -> bool:
    """Check for an overlap on the segment a–b while the heading turns from ``start`` to ``end``."""
    length = math.hypot(bx - ax, by - ay)
    if clear_within(footprint, 0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * length):
        return False
    # Once with the heading of the segment, once with the turning one.
    along = math.atan2(by - ay, bx - ax) if length > 0.0 else start
    turn = turn_between(start, end)
    count = max(math.ceil(length / (_APART * footprint.resolution)), 1)
    for k in range(count + 1):
        t = k / count
        if overlaps(footprint, ax + t * (bx - ax), ay + t * (by - ay), along):
            return True
    if abs(turn) < 1e-9:
        return False
    count = math.ceil(
        (length + abs(turn) * footprint.reach) / (_APART_TURNING * footprint.resolution)
    )
    for k in range(count + 1):
        t = k / count
        if overlaps(footprint, ax + t * (bx - ax), ay + t * (by - ay), start + t * turn):
            return True
    return False


@njit(**CACHED)
def turn_overlaps(footprint: FootprintModel, x: float, y: float, start: float, turn: float) -> bool:
    """Check for an overlap while the robot turns on the spot from heading ``start``."""
    if clear_within(footprint, x, y, 0.0):
        return False
    count = max(math.ceil(abs(turn) * footprint.reach / (_APART_TURNING * footprint.resolution)), 1)
    for k in range(count + 1):  # noqa: SIM110  # numba compiles no generators
        if overlaps(footprint, x, y, start + turn * k / count):
            return True
    return False


@njit(**CACHED)
def overlaps_along(footprint: FootprintModel, points: Floats) -> Booleans:
    """True (n,) where the footprint overlaps at a point of a polyline (n, 2) or beside it.

    Beside means on the two adjacent segments. Points must not repeat.
    """
    n = points.shape[0]
    hit = np.zeros(n, dtype=np.bool_)
    if n < 2:
        return hit
    heading = directions(points)
    for i in range(n - 1):
        before = heading[max(i - 1, 0)]
        after = heading[min(i + 1, n - 2)]
        start = heading[i] - 0.5 * turn_between(before, heading[i])
        end = heading[i] + 0.5 * turn_between(heading[i], after)
        ax, ay, bx, by = points[i, 0], points[i, 1], points[i + 1, 0], points[i + 1, 1]
        if segment_overlaps(footprint, ax, ay, bx, by, start, end):
            hit[i] = hit[i + 1] = True
        if i > 0 and turn_overlaps(footprint, ax, ay, before, turn_between(before, heading[i])):
            hit[i] = True
    return hit


@callee()
def clear_within(footprint: FootprintModel, x: float, y: float, beside: float) -> bool:
    """Check that every motion within ``beside`` (m) of a point is free."""
    return bool(_clearance_bound(footprint, x, y) >= footprint.reach + beside)


@njit(**CACHED)
def directions(points: Floats) -> Floats:
    """Direction (n - 1,) of each segment of a polyline (n, 2), rad."""
    out = np.empty(max(points.shape[0] - 1, 0))
    for i in range(out.shape[0]):
        out[i] = math.atan2(points[i + 1, 1] - points[i, 1], points[i + 1, 0] - points[i, 0])
    return out


@njit(**CACHED)
def turn_between(start: float, end: float) -> float:
    """Smaller turn from one heading to another, in (−π, π]."""
    return float(math.pi - (math.pi - (end - start)) % (2.0 * math.pi))


@callee()
def gap_lower_bound(footprint: FootprintModel, x: float, y: float, heading: float) -> float:
    """Lower bound of the gap between the footprint at a pose and obstacles, m."""
    cos, sin = math.cos(heading), math.sin(heading)
    least = np.inf
    for k in range(footprint.discs.shape[0]):
        bx, by = footprint.discs[k, 0], footprint.discs[k, 1]
        clearance = _clearance_bound(footprint, x + cos * bx - sin * by, y + sin * bx + cos * by)
        least = min(least, clearance - footprint.discs[k, 2])
    return least


@callee()
def _is_clear(footprint: FootprintModel, x: float, y: float, cos: float, sin: float) -> bool:
    bx, by = footprint.bound[0], footprint.bound[1]
    if (
        _clearance_bound(footprint, x + cos * bx - sin * by, y + sin * bx + cos * by)
        >= footprint.bound[2]
    ):
        return True
    for k in range(footprint.discs.shape[0]):
        bx, by = footprint.discs[k, 0], footprint.discs[k, 1]
        if (
            _clearance_bound(footprint, x + cos * bx - sin * by, y + sin * bx + cos * by)
            < footprint.discs[k, 2]
        ):
            return False
    return True


@callee()
def _clearance_bound(footprint: FootprintModel, x: float, y: float) -> float:
    """Lower bound of the distance to obstacles: that of the cell, less its largest error."""
    rows, cols = footprint.clearance.shape
    r = min(max(math.floor(y / footprint.resolution), 0), rows - 1)
    c = min(max(math.floor(x / footprint.resolution), 0), cols - 1)
    cx = min(max(x, 0.0), cols * footprint.resolution) - (c + 0.5) * footprint.resolution
    cy = min(max(y, 0.0), rows * footprint.resolution) - (r + 0.5) * footprint.resolution
    clearance = min(np.float64(footprint.clearance[r, c]), footprint.trust)
    return float(clearance - math.hypot(cx, cy) - 0.21 * footprint.resolution)


@callee()
def _between(corners: Floats, low: float, high: float) -> tuple[float, float]:
    """(lowest, highest x) of a triangle (3, 2) strictly between two heights; (∞, −∞) if none."""
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
    """Discs (4, 3) around the quarters of the bounding rectangle along its longer side."""
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
