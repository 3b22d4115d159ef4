"""Exact motion under a constant twist."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats


def move(pose: Floats, twist: Floats, dt: float) -> Floats:
    """The pose (3,) after ``dt`` of a constant twist (3,), exactly (an arc); heading wrapped.

    For the simulator, whose physics must not share the planner's discretisation error.
    """
    return _arc(np.asarray(pose, dtype=float), np.asarray(twist, dtype=float), dt)


@njit(cache=True)
def _arc(pose: Floats, twist: Floats, dt: float) -> Floats:
    vx, vy, w = twist[0], twist[1], twist[2]
    angle = w * dt
    if abs(angle) < 1e-9:
        s, c = dt, 0.5 * w * dt * dt
    else:
        s, c = math.sin(angle) / w, (1.0 - math.cos(angle)) / w
    dx, dy = s * vx - c * vy, c * vx + s * vy
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    heading = (pose[2] + angle + math.pi) % (2.0 * math.pi) - math.pi
    return np.array([pose[0] + cos * dx - sin * dy, pose[1] + sin * dx + cos * dy, heading])
