"""From the staircase of cells to a line a chair can follow.

1. Shorten: replace stretches by straight segments wherever that costs no more than the cells did
   and comes no nearer to obstacles than allowed.
2. Smooth: pull every point toward the middle of its neighbours and a little back to where it was,
   and push it off an obstacle that it would come too near to. Where the line bends more than the
   robot can, nothing pulls it back, so that the bend spreads.

Too near is: nearer than the stretch replaced was, and nearer than the clearance wanted. So the line
stays in the corridor that the search chose, and free space ends the zigzag. A taut line about
obstacles at a distance r bends by 1/r at most.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Floats32, Integers
from cohelm.config import Model
from cohelm.geometry import resample
from cohelm.maps.distance import sample
from cohelm.planning.pinning import discs_at, pushed_out
from cohelm.planning.search import Weights
from cohelm.planning.shortening import barred, clearance_at, shorten

_ORIGIN = np.zeros(3)
_NO_PINS = np.empty(0, dtype=np.int64)
_CHORD = 0.003  # m that the chords between the points of a curve may cut into it
_BESIDE = 5  # points on either side whose clearance a point may come down to, or let go with it


class Smoothing(Model):
    """How a path is smoothed; assumed."""

    spacing: float = Field(0.1, gt=0.0, le=1.0)
    """Distance between the points of the path, m."""
    iterations: int = Field(200, ge=0, le=10_000)
    """Rounds of smoothing; 0 leaves the straight segments."""
    hold: float = Field(0.02, ge=0.0, le=1.0)
    """Pull back to the straight segments, against a pull of 1 to the neighbours' middle. Corners
    are rounded over about spacing / √hold."""


def smooth(  # noqa: PLR0913  # each is one word of the question
    points: Floats,
    weights: Weights,
    clearance: Floats32,
    resolution: float,
    *,
    needed: float,
    wanted: float,
    smoothing: Smoothing,
    kept: float = 0.0,
    curvature: float = math.inf,
    pins: Integers = _NO_PINS,
) -> Floats:
    """A smooth line (m, 2) along an 8-connected way, both ends kept.

    Args:
        points: the way, (k, 2), in the grid's frame (origin at its lower left corner), m; the ends
            may lie anywhere in their cells.
        weights: those that the way was searched with.
        clearance: distance from cell centres to obstacles (rows, cols), m.
        resolution: of the grid, m.
        needed: clearance below which the line comes only where the way did, m.
        wanted: clearance above which it may come nearer than the way did, m; ≥ needed.
        smoothing: parameters.
        kept: clearance that straight stretches keep where the way did, m; at least what is needed.
        curvature: the line bends less where there is room, 1/m.
        pins: indices of points that the line keeps passing within a cell of.
    """
    stops = np.unique(np.concatenate([[0], pins, [len(points) - 1]]))
    legs = [
        shorten(points[a : b + 1], weights.packed, clearance, resolution, needed, max(kept, needed))
        for a, b in itertools.pairwise(stops)
    ]
    line, pinned = spaced(legs or [points], smoothing.spacing)
    pull = 1.0 / (1.0 + smoothing.hold)
    _relax(
        line,
        pinned,
        discs_at(line, pinned, 0.9 * curvature),
        weights.packed,
        clearance,
        resolution,
        np.array([needed, wanted, 0.95 * curvature, pull]),
        smoothing.iterations,
    )
    ends = np.flatnonzero(pinned)
    return spaced(
        [line[a : b + 1] for a, b in itertools.pairwise(ends)] or [line],
        smoothing.spacing,
    )[0]


def spaced(legs: list[Floats], spacing: float) -> tuple[Floats, Booleans]:
    """(polylines as one line with points ``spacing`` or less apart, which are their ends)."""
    even = [resample(leg, spacing) for leg in legs]
    line = np.concatenate([even[0][:1], *(leg[1:] for leg in even)])
    fixed = np.zeros(len(line), dtype=np.bool_)
    fixed[np.cumsum([0, *(len(leg) - 1 for leg in even)])] = True
    return line, fixed


@njit(cache=True)
def curvature_of(points: Floats) -> Floats:
    """How sharply a polyline (n, 2) bends at each of its points, 1/m; (n,), 0 at the ends.

    The turn from one segment to the next over the mean of their lengths, which on an arc is the
    arc's curvature however the points are spaced. Points do not repeat.
    """
    n = points.shape[0]
    out = np.zeros(n)
    for i in range(1, n - 1):
        out[i] = _bend(points, i)
    return out


@njit(cache=True)
def _bend(line: Floats, i: int) -> float:
    ax, ay = line[i, 0] - line[i - 1, 0], line[i, 1] - line[i - 1, 1]
    bx, by = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
    turn = abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
    mean = 0.5 * (math.hypot(ax, ay) + math.hypot(bx, by))
    return turn / mean if turn > 0.0 else 0.0


@njit(cache=True)
def _sharp(line: Floats, i: int, curvature: float) -> bool:
    """Whether the line bends more than allowed, to second order in the turn."""
    ax, ay = line[i, 0] - line[i - 1, 0], line[i, 1] - line[i - 1, 1]
    bx, by = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
    change = (bx - ax) ** 2 + (by - ay) ** 2
    return bool(change > curvature**2 * (ax * ax + ay * ay) * (bx * bx + by * by))


@njit(cache=True)
def _relax(  # noqa: PLR0917  # a kernel takes plain arguments
    line: Floats,
    pinned: Booleans,
    discs: Floats,
    weights: Floats32,
    clearance: Floats32,
    resolution: float,
    limits: Floats,
    iterations: int,
) -> None:
    """Move the inner points of ``line`` in place, Gauss–Seidel, there and back.

    ``limits``: clearance needed and wanted, m; curvature, 1/m; pull to the neighbours' middle.
    """
    n = line.shape[0]
    needed, wanted, curvature, pull = limits
    fixed = line.copy()
    floor = _floors(line, clearance, resolution, needed, wanted)
    shares = np.full(n, pull)
    for round_ in range(iterations):
        moved = 0.0
        for k in range(1, n - 1):
            i = k if round_ % 2 == 0 else n - 1 - k
            if shares[i] < 1.0 and _sharp(line, i, curvature):
                shares[max(i - _BESIDE, 0) : i + _BESIDE + 1] = 1.0
            share = shares[i]
            x = share * 0.5 * (line[i - 1, 0] + line[i + 1, 0]) + (1.0 - share) * fixed[i, 0]
            y = share * 0.5 * (line[i - 1, 1] + line[i + 1, 1]) + (1.0 - share) * fixed[i, 1]
            if discs[i, 2] > 0.0:
                x, y = pushed_out(discs[i], x, y)
            room, gx, gy = sample(clearance, resolution, _ORIGIN, x, y)
            steep = gx * gx + gy * gy
            if room < floor[i] and steep > 0.25:
                off = (floor[i] - room + 1e-6) / steep
                x, y = x + off * gx, y + off * gy
                room = clearance_at(clearance, resolution, x, y)
            if room < floor[i]:
                continue
            # By a zone; the middles of the segments too, for the line cuts its corners otherwise.
            ax, ay = 0.5 * (x + line[i - 1, 0]), 0.5 * (y + line[i - 1, 1])
            bx, by = 0.5 * (x + line[i + 1, 0]), 0.5 * (y + line[i + 1, 1])
            if (
                barred(weights, clearance, resolution, needed, x, y)
                or barred(weights, clearance, resolution, needed, ax, ay)
                or barred(weights, clearance, resolution, needed, bx, by)
            ):
                continue
            if pinned[i] and math.hypot(x - fixed[i, 0], y - fixed[i, 1]) > 0.7 * resolution:
                continue
            moved = max(moved, abs(x - line[i, 0]) + abs(y - line[i, 1]))
            line[i, 0], line[i, 1] = x, y
        if moved < 1e-4:
            break


@njit(cache=True)
def _floors(
    line: Floats, clearance: Floats32, resolution: float, needed: float, wanted: float
) -> Floats:
    """The clearance (n,) that each point may come down to, m."""
    n = line.shape[0]
    own, out = np.empty(n), np.empty(n)
    for i in range(n):
        own[i] = clearance_at(clearance, resolution, line[i, 0], line[i, 1])
    for i in range(n):
        near = own[max(i - _BESIDE, 0) : i + _BESIDE + 1].min()
        out[i] = min(own[i], max(needed + _CHORD, min(near, wanted)))
    return out
