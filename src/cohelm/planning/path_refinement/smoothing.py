"""Smoothing of a path over cells into a line that a wheelchair can follow.

1. Shorten: replace stretches by straight segments wherever that costs no more than the cells did
   and keeps the required clearance.
2. Smooth: pull every point toward the midpoint of its neighbours and a little back to its origin,
   and push it away from an obstacle that is too close. Where the line bends more than the robot
   can, nothing pulls it back, so that the bend spreads.

Too close means: closer than the replaced stretch was, and closer than the wanted clearance. So the
line stays in the corridor that the search chose, and the zigzag ends in free space. A taut line
around obstacles at a distance r has a curvature of at most 1/r.

A taut line that is held at a single point has a corner there, which the robot cannot drive. So if
the line turns at a waypoint by more than the robot can, a tangent disc with the smallest drivable
radius is put inside the corner, touching the waypoint: the line passes the waypoint on an arc.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.geometry import resample
from cohelm.kernels import CACHED, callee
from cohelm.maps.distance import sample
from cohelm.planning.path_refinement.shortening import (
    LineGrid,
    clearance_at,
    closed_by_rule,
    shorten,
)

_ORIGIN = np.zeros(3)
_NO_WAYPOINTS = np.empty(0, dtype=np.int64)
_CHORD = 0.003  # m that the chords between the points of a curve may cut into it
_BESIDE = 5  # points on either side whose clearance limits a point, and that let go with it
_SHARPEST = math.radians(120.0)  # beyond it the robot turns on the spot and drives back


class Smoothing(Model):
    """Parameters of smoothing; assumed."""

    spacing: float = Field(0.1, gt=0.0, le=1.0)
    """Distance between the points of the path, m."""
    iterations: int = Field(200, ge=0, le=10_000)
    """Smoothing iterations; 0 keeps the straight segments."""
    hold: float = Field(0.02, ge=0.0, le=1.0)
    """Pull back to the straight segments, against a pull of 1 to the neighbours' midpoint. Corners
    are rounded over about spacing / √hold."""


class LineLimits(NamedTuple):
    """Limits of a smoothed line besides the needed clearance."""

    wanted: float
    """Clearance above which the line may come closer to obstacles than the path did, m; at least
    the needed one."""
    straight: float = 0.0
    """Clearance that straight stretches keep if the path did, m."""
    curvature: float = math.inf
    """Upper bound of the curvature where space allows, 1/m."""


def smooth(
    points: Floats,
    grid: LineGrid,
    limits: LineLimits,
    smoothing: Smoothing,
    waypoints: Integers = _NO_WAYPOINTS,
) -> Floats:
    """Smooth line (m, 2) along an 8-connected path; both ends are kept.

    Args:
        points: the path, (k, 2), in the grid's frame (origin at its lower left corner), m; the ends
            may lie anywhere in their cells.
        grid: weights, clearance and the needed clearance.
        limits: the other limits of the line.
        smoothing: parameters.
        waypoints: indices of points that the line must pass within one cell.
    """
    stops = np.unique(np.concatenate([[0], waypoints, [len(points) - 1]]))
    straight = max(limits.straight, grid.needed)
    legs = [shorten(points[a : b + 1], grid, straight) for a, b in itertools.pairwise(stops)]
    line, held = resample_legs(legs or [points], smoothing.spacing)
    discs = tangent_discs(line, held, 0.9 * limits.curvature)
    pull = 1.0 / (1.0 + smoothing.hold)
    values = np.array([limits.wanted, 0.95 * limits.curvature, pull])
    _relax(line, held, discs, grid, values, smoothing.iterations)
    ends = np.flatnonzero(held)
    legs = [line[a : b + 1] for a, b in itertools.pairwise(ends)]
    return resample_legs(legs or [line], smoothing.spacing)[0]


def resample_legs(legs: list[Floats], spacing: float) -> tuple[Floats, Booleans]:
    """(polylines joined into one with points at most ``spacing`` apart, True at their ends)."""
    even = [resample(leg, spacing) for leg in legs]
    line = np.concatenate([even[0][:1], *(leg[1:] for leg in even)])
    fixed = np.zeros(len(line), dtype=np.bool_)
    fixed[np.cumsum([0, *(len(leg) - 1 for leg in even)])] = True
    return line, fixed


@njit(**CACHED)
def curvature_of(points: Floats) -> Floats:
    """Curvature (n,) of a polyline (n, 2) at each of its points, 1/m; 0 at the ends.

    The turn from one segment to the next over the mean of their lengths, which on an arc equals the
    arc's curvature for any spacing. Points must not repeat.
    """
    n = points.shape[0]
    out = np.zeros(n)
    for i in range(1, n - 1):
        out[i] = _bend(points, i)
    return out


@callee()
def _bend(line: Floats, i: int) -> float:
    ax, ay = line[i, 0] - line[i - 1, 0], line[i, 1] - line[i - 1, 1]
    bx, by = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
    turn = abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
    mean = 0.5 * (math.hypot(ax, ay) + math.hypot(bx, by))
    return turn / mean if turn > 0.0 else 0.0


@callee()
def _is_sharp(line: Floats, i: int, curvature: float) -> bool:
    """Check that the line bends more than allowed, to second order in the turn."""
    ax, ay = line[i, 0] - line[i - 1, 0], line[i, 1] - line[i - 1, 1]
    bx, by = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
    change = (bx - ax) ** 2 + (by - ay) ** 2
    return bool(change > curvature**2 * (ax * ax + ay * ay) * (bx * bx + by * by))


@njit(**CACHED)
def _relax(  # a kernel takes plain arrays
    line: Floats,
    held: Booleans,
    discs: Floats,
    grid: LineGrid,
    values: Floats,
    iterations: int,
) -> None:
    """Move the inner points of ``line`` in place, Gauss–Seidel, forward and backward in turn.

    ``values``: wanted clearance, m; curvature, 1/m; pull to the neighbours' midpoint.
    """
    n = line.shape[0]
    clearance, resolution = grid.clearance, grid.resolution
    wanted, curvature, pull = values
    fixed = line.copy()
    floor = _floors(line, grid, wanted)
    shares = np.full(n, pull)
    for round_ in range(iterations):
        moved = 0.0
        for k in range(1, n - 1):
            i = k if round_ % 2 == 0 else n - 1 - k
            # Where the line bends too much, it is no longer pulled back to its origin.
            if shares[i] < 1.0 and _is_sharp(line, i, curvature):
                shares[max(i - _BESIDE, 0) : i + _BESIDE + 1] = 1.0
            share = shares[i]
            x = share * 0.5 * (line[i - 1, 0] + line[i + 1, 0]) + (1.0 - share) * fixed[i, 0]
            y = share * 0.5 * (line[i - 1, 1] + line[i + 1, 1]) + (1.0 - share) * fixed[i, 1]
            if discs[i, 2] > 0.0:
                x, y = push_out_of_disc(discs[i], x, y)
            # Push the point along the clearance gradient until it is far enough from obstacles.
            near, gx, gy = sample(clearance, resolution, _ORIGIN, x, y)
            steep = gx * gx + gy * gy
            if near < floor[i] and steep > 0.25:
                off = (floor[i] - near + 1e-6) / steep
                x, y = x + off * gx, y + off * gy
                near = clearance_at(clearance, resolution, x, y)
            if near < floor[i]:
                continue
            # Zones block too; test the segments' midpoints, because the line may cut a corner.
            ax, ay = 0.5 * (x + line[i - 1, 0]), 0.5 * (y + line[i - 1, 1])
            bx, by = 0.5 * (x + line[i + 1, 0]), 0.5 * (y + line[i + 1, 1])
            if (
                closed_by_rule(grid, x, y)
                or closed_by_rule(grid, ax, ay)
                or closed_by_rule(grid, bx, by)
            ):
                continue
            if held[i] and math.hypot(x - fixed[i, 0], y - fixed[i, 1]) > 0.7 * resolution:
                continue
            moved = max(moved, abs(x - line[i, 0]) + abs(y - line[i, 1]))
            line[i, 0], line[i, 1] = x, y
        if moved < 1e-4:
            break


@callee()
def _floors(line: Floats, grid: LineGrid, wanted: float) -> Floats:
    """Minimum clearance (n,) that each point must keep, m."""
    n = line.shape[0]
    own, out = np.empty(n), np.empty(n)
    for i in range(n):
        own[i] = clearance_at(grid.clearance, grid.resolution, line[i, 0], line[i, 1])
    for i in range(n):
        near = own[max(i - _BESIDE, 0) : i + _BESIDE + 1].min()
        out[i] = min(own[i], max(grid.needed + _CHORD, min(near, wanted)))
    return out


@njit(**CACHED)
def tangent_discs(line: Floats, held: Booleans, curvature: float) -> Floats:
    """Disc (x, y, radius) that each point of a line must stay out of, (n, 3); radius 0: none.

    Args:
        line: (n, 2), m; its points must not repeat.
        held: True at the points that the line must pass, (n,).
        curvature: of the discs, 1/m.
    """
    n = line.shape[0]
    out = np.zeros((n, 3))
    stops = np.flatnonzero(held)
    radius = 1.0 / curvature
    for k in range(1, stops.shape[0] - 1):
        i = stops[k]
        ax, ay = line[i, 0] - line[i - 1, 0], line[i, 1] - line[i - 1, 1]
        bx, by = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
        before, after = math.hypot(ax, ay), math.hypot(bx, by)
        turn = abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
        if turn <= curvature * 0.5 * (before + after) or turn > _SHARPEST:
            continue
        nx, ny = bx / after - ax / before, by / after - ay / before
        inward = radius / math.hypot(nx, ny)
        # The disc holds for the points up to a diameter before and after the waypoint.
        for step in (-1, 1):
            j, far = i, 0.0
            while far <= 2.0 * radius and (j == i or not held[j]):
                out[j, 0], out[j, 1] = line[i, 0] + inward * nx, line[i, 1] + inward * ny
                out[j, 2] = radius
                j += step
                far += before if step < 0 else after
    return out


@callee()
def push_out_of_disc(disc: Floats, x: float, y: float) -> tuple[float, float]:
    """Nearest point outside a disc (x, y, radius)."""
    dx, dy = x - disc[0], y - disc[1]
    far = math.hypot(dx, dy)
    if far >= disc[2] or far == 0.0:
        return x, y
    return disc[0] + dx * disc[2] / far, disc[1] + dy * disc[2] / far
