"""Motion between two sweeps of one scanner, point to line with projective association.

A point is associated with the beam of the reference sweep that points at it (Diosi and Kleeman,
Laser scan matching in polar coordinates, IROS 2005), which costs one look-up: cheap enough for
every sweep.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED, callee
from cohelm.planar_fit import add_row, newton_step

_PASSES = ((0.6, 0.3), (0.5, 0.2), (0.4, 0.15), (0.3, 0.1), (0.2, 0.08), (0.2, 0.06), (0.2, 0.05))
"""Largest misfit, m, and scale of the weights, m, from coarse to fine."""
_INLIER = 0.06
"""Misfit of an inlier, m: several standard deviations of the noise."""
_CHORD = 2
"""Beams by which the chord of a smooth surface is longer at either end."""
_BEND = 0.1
"""Largest bend of a surface that counts as smooth, m."""
_STEP = 0.3
"""Largest step of the range between neighbouring beams of one surface, m."""
_PRIOR = 4.0
"""Weight of the initial guess: an unconstrained direction keeps it."""
_TOO_FAR = 20.0
"""Motion that no sweep shows, m."""


class Sweep(NamedTuple):
    """Geometry of a sweep in the sensor's frame."""

    ranges: Floats
    """(b,), m."""
    first: float
    """Direction of the first beam, rad."""
    increment: float
    """rad."""


class ScanMotion(NamedTuple):
    """Result of :func:`scan_motion`."""

    motion: Floats
    """Pose (3,) of the sensor now in its earlier frame."""
    inliers: float
    """Share of the points that fit with it."""
    inliers_guess: float
    """Share of the points that fit at the initial guess."""
    points: int
    """Points compared."""


def scan_motion(earlier: Sweep, now: Sweep, guess: Floats) -> ScanMotion:
    """Estimate the motion near ``guess`` (3,); an unconstrained direction keeps the guess."""
    motion, inliers, at_guess, points = _match(earlier, now, np.array(guess, dtype=float))
    return ScanMotion(motion, inliers, at_guess, points)


class _Surface(NamedTuple):
    """Stretch of the earlier sweep that a point is compared with."""

    kind: int
    """``_NOWHERE``, ``_ELSEWHERE`` or ``_NEAR``."""
    nx: float
    """Unit normal, earlier frame."""
    ny: float
    misfit: float
    """Distance of the point from the line, m."""


_NOWHERE, _ELSEWHERE, _NEAR = 0, 1, 2
"""No beam sees the point's direction; the surface there is too far or not smooth; it is near."""


@njit(**CACHED)
def _match(earlier: Sweep, now: Sweep, guess: Floats) -> tuple[Floats, float, float, int]:
    """(motion, share of inliers with it and with the guess, points) of robust Gauss-Newton."""
    pose, points = guess.copy(), _points(now)
    at_guess, share, compared = 0.0, 0.0, 0
    for k in range(len(_PASSES) + 1):
        reach, scale = _PASSES[min(k, len(_PASSES) - 1)]
        H, g, inliers, compared = _normal_equations(earlier, points, pose, reach, scale)
        share = inliers / compared if compared else 0.0
        if k == 0:
            at_guess = share
        if k == len(_PASSES):
            break
        H += np.diag(np.full(3, _PRIOR))
        g += _PRIOR * (pose - guess)
        pose += newton_step(H, g)
        if abs(pose[0]) > _TOO_FAR or abs(pose[1]) > _TOO_FAR:
            return guess, at_guess, at_guess, compared
    return pose, share, at_guess, compared


@callee()
def _points(now: Sweep) -> Floats:
    """Returns (n, 2) of about 90 beams in the sensor's frame, m."""
    b = len(now.ranges)
    stride, n = max(b // 90, 1), 0
    out = np.empty((b, 2))
    for i in range(0, b, stride):
        r = now.ranges[i]
        if 0.05 < r < 1e3:
            a = now.first + now.increment * i
            out[n, 0], out[n, 1] = r * math.cos(a), r * math.sin(a)
            n += 1
    return out[:n]


@callee()
def _normal_equations(
    earlier: Sweep, points: Floats, pose: Floats, reach: float, scale: float
) -> tuple[Floats, Floats, int, int]:
    """Weighted (upper triangle of H, g, inliers, points compared) of points moved by ``pose``."""
    H, g = np.zeros((3, 3)), np.zeros(3)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    inliers, compared = 0, 0
    for i in range(len(points)):
        px, py = points[i, 0], points[i, 1]
        rx, ry = c * px - s * py, s * px + c * py
        surface = _surface(earlier, pose[0] + rx, pose[1] + ry, reach)
        compared += surface.kind != _NOWHERE
        if surface.kind != _NEAR:
            continue
        nx, ny, e = surface.nx, surface.ny, surface.misfit
        inliers += abs(e) <= _INLIER
        w = 1.0 / (1.0 + (e / scale) ** 2) ** 2
        turn = ny * rx - nx * ry
        add_row(H, g, nx, ny, turn, e, w)
    return H, g, inliers, compared


@callee()
def _surface(earlier: Sweep, x: float, y: float, reach: float) -> _Surface:
    """Surface of the earlier sweep in the direction of a point (x, y), m."""
    m = len(earlier.ranges)
    full = abs(m * earlier.increment) > 2.0 * math.pi - 1.5 * abs(earlier.increment)
    index = (math.atan2(y, x) - earlier.first) / earlier.increment
    if full:
        index %= 2.0 * math.pi / abs(earlier.increment)
    j = math.floor(index)
    j1 = (j + 1) % m if full else j + 1
    if j < 0 or j >= m or j1 >= m:
        return _Surface(_NOWHERE, 0.0, 0.0, 0.0)
    ra, rb = earlier.ranges[j], earlier.ranges[j1]
    if not (0.05 < ra < 1e3 and 0.05 < rb < 1e3):
        return _Surface(_NOWHERE, 0.0, 0.0, 0.0)
    if abs(ra - rb) > _STEP or abs(math.hypot(x, y) - ra) > reach:
        return _Surface(_ELSEWHERE, 0.0, 0.0, 0.0)
    j, j1 = _chord(earlier, j, j1, full)
    ra, rb = earlier.ranges[j], earlier.ranges[j1]
    ta, tb = earlier.first + earlier.increment * j, earlier.first + earlier.increment * j1
    ax, ay = ra * math.cos(ta), ra * math.sin(ta)
    ex, ey = rb * math.cos(tb) - ax, rb * math.sin(tb) - ay
    length = math.hypot(ex, ey)
    if length < 1e-6:
        return _Surface(_ELSEWHERE, 0.0, 0.0, 0.0)
    nx, ny = -ey / length, ex / length
    return _Surface(_NEAR, nx, ny, nx * (x - ax) + ny * (y - ay))


@callee()
def _chord(earlier: Sweep, j: int, j1: int, full: bool) -> tuple[int, int]:
    """Beams of a longer chord where the surface goes on smoothly, else ``j`` and ``j1``.

    Neighbouring beams are too noisy a normal.
    """
    ranges, m = earlier.ranges, len(earlier.ranges)
    ja, jb = j - _CHORD, j1 + _CHORD
    if full:
        ja, jb = ja % m, jb % m
    if ja < 0 or jb >= m:
        return j, j1
    goes_on = abs(ranges[ja] - ranges[j]) < _STEP and abs(ranges[jb] - ranges[j1]) < _STEP
    bend = abs(ranges[ja] + ranges[jb] - ranges[j] - ranges[j1])
    return (ja, jb) if goes_on and bend < _BEND else (j, j1)
