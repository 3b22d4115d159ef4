"""Motion between two sweeps of one scanner, point to line with projective association.

A point is associated with the beam of the reference sweep that points at it (Diosi and Kleeman,
Laser scan matching in polar coordinates, IROS 2005), which costs one look-up: cheap enough for
every sweep. ``perception.laser_odometry`` matches with maps of features instead, for recordings
without odometry.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats

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


@njit(cache=True)
def _match(  # noqa: PLR0915  # one kernel: each pass associates, weighs and solves
    earlier: Sweep, now: Sweep, guess: Floats
) -> tuple[Floats, float, float, int]:
    pose, b, m = guess.copy(), len(now.ranges), len(earlier.ranges)
    stride = max(b // 90, 1)
    at_guess, share, points = 0.0, 0.0, 0
    full = abs(m * earlier.increment) > 2.0 * math.pi - 1.5 * abs(earlier.increment)
    for k in range(len(_PASSES) + 1):
        reach, scale = _PASSES[min(k, len(_PASSES) - 1)]
        H = np.diag(np.array([4.0, 4.0, 4.0]))
        g = H @ (pose - guess)
        c, s = math.cos(pose[2]), math.sin(pose[2])
        inliers, points = 0, 0
        for i in range(0, b, stride):
            r = now.ranges[i]
            if not (0.05 < r < 1e3):
                continue
            a = now.first + now.increment * i
            px, py = r * math.cos(a), r * math.sin(a)
            rx, ry = c * px - s * py, s * px + c * py
            x, y = pose[0] + rx, pose[1] + ry
            index = (math.atan2(y, x) - earlier.first) / earlier.increment
            if full:
                index %= 2.0 * math.pi / abs(earlier.increment)
            j = math.floor(index)
            j1 = (j + 1) % m if full else j + 1
            if j < 0 or j >= m or j1 >= m:
                continue
            ra, rb = earlier.ranges[j], earlier.ranges[j1]
            if not (0.05 < ra < 1e3 and 0.05 < rb < 1e3):
                continue
            points += 1
            if abs(ra - rb) > _STEP or abs(math.hypot(x, y) - ra) > reach:
                continue
            # A longer chord where the surface goes on: neighbouring beams are too noisy a normal.
            ja, jb = j - _CHORD, j1 + _CHORD
            if full:
                ja, jb = ja % m, jb % m
            if ja >= 0 and jb < m:
                wide = abs(earlier.ranges[ja] - ra) < _STEP and abs(earlier.ranges[jb] - rb) < _STEP
                bend = abs(earlier.ranges[ja] + earlier.ranges[jb] - ra - rb)
                if wide and bend < _BEND:
                    j, j1, ra, rb = ja, jb, earlier.ranges[ja], earlier.ranges[jb]
            ta, tb = earlier.first + earlier.increment * j, earlier.first + earlier.increment * j1
            ax, ay = ra * math.cos(ta), ra * math.sin(ta)
            ex, ey = rb * math.cos(tb) - ax, rb * math.sin(tb) - ay
            length = math.hypot(ex, ey)
            if length < 1e-6:
                continue
            nx, ny = -ey / length, ex / length
            e = nx * (x - ax) + ny * (y - ay)
            inliers += abs(e) <= _INLIER
            w = 1.0 / (1.0 + (e / scale) ** 2) ** 2
            turn = -nx * ry + ny * rx
            H[0, 0] += w * nx * nx
            H[0, 1] += w * nx * ny
            H[1, 1] += w * ny * ny
            H[0, 2] += w * nx * turn
            H[1, 2] += w * ny * turn
            H[2, 2] += w * turn * turn
            g[0] += w * nx * e
            g[1] += w * ny * e
            g[2] += w * turn * e
        share = inliers / points if points else 0.0
        if k == 0:
            at_guess = share
        if k == len(_PASSES):
            break
        H[1, 0], H[2, 0], H[2, 1] = H[0, 1], H[0, 2], H[1, 2]
        pose -= np.linalg.solve(H, g)
        if abs(pose[0]) > 20.0 or abs(pose[1]) > 20.0:
            return guess, at_guess, at_guess, points
    return pose, share, at_guess, points
