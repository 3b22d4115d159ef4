"""Motion shared by all models: an exact arc, derivatives, and inputs within limits."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED


def move(pose: Floats, twist: Floats, dt: float) -> Floats:
    """The pose (3,) after ``dt`` of a constant twist (3,), exactly (an arc); heading wrapped.

    The simulator uses it, so that its physics does not share the planner's discretisation error.
    """
    # Copies can be written to: of read-only arrays, the kernel would be compiled once more.
    return _arc(np.array(pose, dtype=float), np.array(twist, dtype=float), dt)


@njit(**CACHED)
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


def slowed(inputs: Floats, speed: float, translating: int) -> Floats:
    """Inputs (..., m) with the speed over the floor reduced to ``speed`` in the same direction."""
    inputs = np.array(inputs, dtype=float)
    velocity = inputs[..., :translating]
    norm = np.linalg.norm(velocity, axis=-1, keepdims=True)
    velocity *= np.minimum(1.0, speed / np.maximum(norm, 1e-12))
    return inputs


@njit(**CACHED)
def within_limits(
    inputs: Floats,
    now: Floats,
    low: Floats,
    high: Floats,
    rise: Floats,
    fall: Floats,
    translating: int,
    speed: float,
) -> Floats:
    """Inputs (N, m) that follow the requested ones as fast as the limits allow.

    A velocity with two components changes along a straight line. If each component changed by
    itself, the speed could become greater than at either end.

    Args:
        inputs: requested, (N, m).
        now: current input, (m,).
        low, high: bounds of every input, (m,).
        rise, fall: largest change at each step, (N, m) or (1, m); the last row holds for the rest.
        translating: as ``Kinematics.translating``.
        speed: largest norm of the translating inputs, m/s.
    """
    steps, m = inputs.shape
    joint = translating if translating > 1 else 0
    out = np.empty_like(inputs)
    before, wanted = now.astype(np.float64), np.empty(m)
    for k in range(steps):
        up, down = rise[min(k, rise.shape[0] - 1)], fall[min(k, fall.shape[0] - 1)]
        # each input within its bounds, then the speed
        square = 0.0
        for i in range(m):
            wanted[i] = min(max(inputs[k, i], low[i]), high[i])
            if i < joint:
                square += wanted[i] * wanted[i]
        shorter = min(1.0, speed / math.sqrt(square)) if square > 0.0 else 1.0
        # the share of a joint change that keeps every component within its acceleration
        share = 1.0
        for i in range(joint):
            wanted[i] *= shorter
            change = wanted[i] - before[i]
            most = up[i] if change > 0.0 else down[i]
            if abs(change) > most:
                share = min(share, most / abs(change))
        for i in range(m):
            if i < joint:
                before[i] += share * (wanted[i] - before[i])
            else:
                before[i] = min(max(wanted[i], before[i] - down[i]), before[i] + up[i])
            out[k, i] = before[i]
    return out


@njit(**CACHED)
def rollout_sensitivity(poses: Floats, inputs: int, dt: float, early: int) -> Floats:
    """∂poses/∂inputs along a rollout (N+1, 3), (N+1, 3, N·m); see ``Kinematics.sensitivity``.

    inputs: m, 2 or 3.  early: 1 if a step turns before it moves, else 0.
    """
    n, m = poses.shape[0] - 1, inputs
    out = np.zeros((n + 1, 3, m * n))
    for j in range(n):
        # a later pose moves along the heading of step j, and turns about the end of that step
        pivot, first, last = poses[j + 1 - early], m * j, m * j + m - 1
        cos, sin = math.cos(poses[j + early, 2]), math.sin(poses[j + early, 2])
        for k in range(j + 1, n + 1):
            out[k, 0, first] = dt * cos
            out[k, 1, first] = dt * sin
            if m == 3:
                out[k, 0, first + 1] = -dt * sin
                out[k, 1, first + 1] = dt * cos
            out[k, 0, last] = -dt * (poses[k, 1] - pivot[1])
            out[k, 1, last] = dt * (poses[k, 0] - pivot[0])
            out[k, 2, last] = dt
    return out
