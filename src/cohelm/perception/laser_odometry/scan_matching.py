"""Scan matching: the pose of a reading relative to known surroundings.

Face points are matched point to line (Censi, An ICP variant using a point-to-line metric, ICRA
2008), point features point to point, with robust weights that discount what does not fit: static
objects outvote walking people. A direction without constraints, as along a corridor, keeps the
initial guess (Zhang et al., ICRA 2016).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.geometry import compose, wrap_angle
from cohelm.kernels import CACHED
from cohelm.perception.laser_odometry.local_map import CELL, Cells, FeatureMap, nearest
from cohelm.perception.laser_odometry.scan_features import ScanFeatures
from cohelm.planar_fit import add_row, newton_step

CAP = 9.0
"""Squared misfit of a point, in standard deviations, above which it is unmatched."""
_PASSES = ((0.5, 0.2, 6), (0.25, 0.08, 8), (0.15, 0.04, 12))
"""From coarse to fine: largest distance of a neighbour, misfit with weight ¼, m, and iterations."""
_MIN_STEP = 1e-5
"""Shorter steps end a pass, m and rad."""
_MIN_SUPPORT = (4.0, 0.012)
"""Sum, and share, of the weights of the points that must constrain a direction."""
_LEVER_SQ = 4.0
"""Mean squared lever arm of so many points that constrain the heading, m²."""


@value
class ScanMatch:
    """Result of matching a reading."""

    pose: Annotated[Floats, Shape("3")]
    """Pose of the reading in the frame of the map."""
    overlap: float
    """Share of the weight of its points that lie on known features, 0…1."""
    misfit: float
    """Weighted mean of the squared distances in standard deviations, at most ``CAP`` each."""
    constrained: int
    """Number of directions that the surroundings constrain: 2, along a smooth corridor 1, and one
    less if they do not constrain the heading."""


def match_scan(known: FeatureMap, features: ScanFeatures, guess: Floats, noise: float) -> ScanMatch:
    """Find the pose near ``guess`` (3,) at which features fit best.

    Args:
        known: the surroundings.
        features: of the reading, in the robot's frame.
        guess: initial pose.
        noise: standard deviation of the misfit of one object seen twice, m.
    """
    if not len(features) or not len(known.features):
        return ScanMatch(pose=guess, overlap=0.0, misfit=CAP, constrained=0)
    pose, constrained = _align(known.cells, features.rows, guess)
    return evaluate_pose(known, features, pose, noise, int(constrained))


def evaluate_pose(
    known: FeatureMap, features: ScanFeatures, pose: Floats, noise: float, constrained: int = 2
) -> ScanMatch:
    """Evaluate the fit of features at a given pose; arguments as for :func:`match_scan`."""
    if not len(features) or not len(known.features):
        return ScanMatch(pose=pose, overlap=0.0, misfit=CAP, constrained=0)
    squared, weights = _misfits(known.cells, features.rows, pose, noise), features.rows[:, 4]
    return ScanMatch(
        pose=np.array([pose[0], pose[1], float(wrap_angle(pose[2]))]),
        overlap=float(np.average(squared < CAP, weights=weights)),
        misfit=float(np.average(squared, weights=weights)),
        constrained=constrained,
    )


def search_pose(
    known: FeatureMap, features: ScanFeatures, guess: Floats, reach: float, turn: float
) -> Floats:
    """Search a coarse grid about a guess for the pose (3,) with most points in occupied cells.

    Args:
        known: the surroundings.
        features: of the reading.
        guess: middle of the grid.
        reach: half its breadth, m.
        turn: half the range of its headings, rad.
    """
    if not len(features) or not len(known.features):
        return guess
    points = features.points[:: max(len(features) // 150, 1)]
    occupied = np.diff(known.cell_start).reshape(-1, known.n_cols) > 0
    best = _search(occupied, known.origin, points, guess, (reach, turn))
    pose: Floats = compose(
        np.array([guess[0] + best[0], guess[1] + best[1], guess[2]]), [0, 0, best[2]]
    )
    return pose


@njit(**CACHED)
def _align(cells: Cells, seen: Floats, guess: Floats) -> tuple[Floats, int]:
    """(pose (3,), constrained directions) by reweighted least squares, Geman-McClure weights."""
    known, pose = cells.known, guess.copy()
    k, place, constrained = seen.shape[0], np.empty(4), 0
    support = max(_MIN_SUPPORT[0], _MIN_SUPPORT[1] * seen[:, 4].sum())
    for radius, scale, most in _PASSES:
        for _ in range(most):
            c, s = math.cos(pose[2]), math.sin(pose[2])
            # Normal equations of all matched points.
            H, g = np.zeros((3, 3)), np.zeros(3)
            for i in range(k):
                rx, ry = c * seen[i, 0] - s * seen[i, 1], s * seen[i, 0] + c * seen[i, 1]
                place[0], place[1] = pose[0] + rx, pose[1] + ry
                place[2] = c * seen[i, 2] - s * seen[i, 3]
                place[3] = s * seen[i, 2] + c * seen[i, 3]
                j = nearest(cells, place, radius)
                if j < 0:
                    continue
                dx, dy = place[0] - known[j, 0], place[1] - known[j, 1]
                nx, ny = known[j, 2], known[j, 3]
                is_point = nx == 0.0 and ny == 0.0
                error = dx * dx + dy * dy if is_point else (nx * dx + ny * dy) ** 2
                weight = seen[i, 4] / (1.0 + error / (scale * scale)) ** 2
                for axis in range(2 if is_point else 1):
                    if is_point:
                        nx, ny = 1.0 - axis, 1.0 * axis
                    across = -nx * ry + ny * rx
                    e = nx * dx + ny * dy
                    add_row(H, g, nx, ny, across, e, weight)
            constrained = _hold_unconstrained(H, g, pose, guess, support)
            step = newton_step(H + 1e-6 * np.eye(3), g)
            pose += step
            if np.abs(step).max() < _MIN_STEP:
                break
    return pose, constrained


@njit(**CACHED)
def _hold_unconstrained(H: Floats, g: Floats, pose: Floats, guess: Floats, support: float) -> int:
    """Fix directions with too little support to the guess; return the number of the others."""
    half = math.hypot(0.5 * (H[0, 0] - H[1, 1]), H[0, 1])
    middle = 0.5 * (H[0, 0] + H[1, 1])
    along = 0.5 * math.atan2(2.0 * H[0, 1], H[0, 0] - H[1, 1])
    constrained, stiff = 2, 1e4
    for large in range(2):
        eigenvalue = middle + half if large else middle - half
        if eigenvalue >= support:
            continue
        constrained -= 1
        angle = along if large else along + 0.5 * math.pi
        vx, vy = math.cos(angle), math.sin(angle)
        off = vx * (pose[0] - guess[0]) + vy * (pose[1] - guess[1])
        H[0, 0] += stiff * vx * vx
        H[0, 1] += stiff * vx * vy
        H[1, 1] += stiff * vy * vy
        g[0] += stiff * vx * off
        g[1] += stiff * vy * off
    # What is left for the heading after the position has been fitted.
    a, b, c, d, e = H[0, 0], H[0, 1], H[1, 1], H[0, 2], H[1, 2]
    explained = (c * d * d - 2.0 * b * d * e + a * e * e) / (a * c - b * b)
    if H[2, 2] - explained < support * _LEVER_SQ:
        H[2, 2] += stiff
        g[2] += stiff * (pose[2] - guess[2])
        constrained = max(constrained - 1, 0)
    return constrained


@njit(**CACHED)
def _misfits(cells: Cells, seen: Floats, pose: Floats, noise: float) -> Floats:
    """(k,) squared distances to the nearest face or point feature, in ``noise``, up to ``CAP``."""
    known, out = cells.known, np.full(seen.shape[0], CAP)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    place = np.empty(4)
    for i in range(seen.shape[0]):
        place[0] = pose[0] + c * seen[i, 0] - s * seen[i, 1]
        place[1] = pose[1] + s * seen[i, 0] + c * seen[i, 1]
        place[2] = c * seen[i, 2] - s * seen[i, 3]
        place[3] = s * seen[i, 2] + c * seen[i, 3]
        j = nearest(cells, place, 0.25)
        if j < 0:
            continue
        dx, dy = place[0] - known[j, 0], place[1] - known[j, 1]
        nx, ny = known[j, 2], known[j, 3]
        is_point = nx == 0.0 and ny == 0.0
        squared = dx * dx + dy * dy if is_point else (nx * dx + ny * dy) ** 2
        out[i] = min(squared / (noise * noise), CAP)
    return out


@njit(**CACHED)
def _search(
    occupied: Booleans, origin: Floats, points: Floats, guess: Floats, limits: tuple[float, float]
) -> Floats:
    """(dx, dy, turn) with the most points in occupied cells; the smallest among equals."""
    rows, columns = occupied.shape
    step, turn = 0.8 * CELL, 0.03
    reach, turns = int(limits[0] / step + 0.5), int(limits[1] / turn + 0.5)
    best, found = -np.inf, np.zeros(3)
    n = points.shape[0]
    x, y = np.empty(n), np.empty(n)
    for t in range(-turns, turns + 1):
        c, s = math.cos(guess[2] + t * turn), math.sin(guess[2] + t * turn)
        for i in range(n):
            x[i] = (guess[0] + c * points[i, 0] - s * points[i, 1] - origin[0]) / CELL
            y[i] = (guess[1] + s * points[i, 0] + c * points[i, 1] - origin[1]) / CELL
        for a in range(-reach, reach + 1):
            for b in range(-reach, reach + 1):
                dx, dy = a * step / CELL, b * step / CELL
                score = -1e-3 * (abs(t) + abs(a) + abs(b))
                for i in range(n):
                    column, row = math.floor(x[i] + dx), math.floor(y[i] + dy)
                    inside = 0 <= column < columns and 0 <= row < rows
                    if inside and occupied[int(row), int(column)]:
                        score += 1.0
                if score > best:
                    best = score
                    found[0], found[1], found[2] = a * step, b * step, t * turn
    return found
