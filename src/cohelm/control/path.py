"""The reference path, evenly sampled for compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED, INNER
from cohelm.messages import Reference

SPACING = 0.1
"""Between the samples of the path, m."""
_BEYOND = 2.5
"""Straight extension of the path beyond its end, m."""
_CREEP = 0.3
"""Arcs are tried up to this speed even where the reference stands, m/s."""
_SLACK = 1e-9
_AIM = round(2.0 / SPACING)
"""Lookahead of the final heading: 2 m, in samples."""


class PathTable(NamedTuple):
    """The path, evenly sampled, and the reference on it."""

    samples: Floats
    """(q, 4): x, y and the unit tangent."""
    reference: Floats
    """(L+1,) arc length of the reference at each step, m."""
    poses: Floats
    """(L+1, 3) of the reference."""
    speeds: Floats
    """(L+1,) of the reference, m/s."""
    heading: Floats
    """(q, 2) unit vector of the reference's heading."""
    max_speed: float
    """Highest speed of the reference, at least the creeping speed, m/s."""


def path_table(reference: Reference, top_speed: float, steps: int) -> PathTable:
    """Samples of a reference over ``steps``; beyond its end it keeps its speed and heading.

    top_speed: of the robot, m/s.
    """
    speeds = reference.speeds
    samples, progress, angle = _sampled(
        reference.poses, steps, reference.step * abs(float(speeds[-1]))
    )
    heading = np.empty((len(angle), 2))
    np.cos(angle, out=heading[:, 0])
    np.sin(angle, out=heading[:, 1])
    max_speed = max(float(speeds.max()), min(_CREEP, top_speed), 0.05)
    last = np.minimum(np.arange(steps + 1), len(speeds) - 1)
    return PathTable(samples, progress, reference.poses[last], speeds[last], heading, max_speed)


@njit(**CACHED)
def _sampled(poses: Floats, steps: int, stride: float) -> tuple[Floats, Floats, Floats]:
    """(samples, arc length of the reference, heading angle (q,)); see ``PathTable``.

    stride: distance per step beyond the reference's end, m.
    """
    # corners of the path, without repetitions
    given = min(poses.shape[0], steps + 1)
    s, x, y = np.empty(given + 1), np.empty(given + 1), np.empty(given + 1)
    theta, progress = np.empty(given + 1), np.empty(steps + 1)
    length, n = 0.0, 0
    for k in range(given):
        gap = 0.0
        if k > 0:
            gap = np.hypot(poses[k, 0] - poses[k - 1, 0], poses[k, 1] - poses[k - 1, 1])
            length += gap
        progress[k] = length
        if k == 0 or gap > _SLACK:
            s[n], x[n], y[n], theta[n] = length, poses[k, 0], poses[k, 1], poses[k, 2]
            n += 1
    for k in range(given, steps + 1):
        progress[k] = length + (k - given + 1) * stride
    # a straight extension beyond the end
    if n > 1:
        ahead_x, ahead_y = x[n - 1] - x[n - 2], y[n - 1] - y[n - 2]
    else:
        ahead_x, ahead_y = np.cos(poses[given - 1, 2]), np.sin(poses[given - 1, 2])
    norm = np.hypot(ahead_x, ahead_y)
    ahead_x, ahead_y = ahead_x / norm, ahead_y / norm
    tail = progress[steps] - length + _BEYOND
    s[n], x[n], y[n] = s[n - 1] + tail, x[n - 1] + tail * ahead_x, y[n - 1] + tail * ahead_y
    theta[n] = poses[given - 1, 2]
    # positions and headings, interpolated
    count = int(np.ceil(s[n] / SPACING)) + 1
    samples, angle = np.empty((count, 4)), np.empty(count)
    j = 0
    for i in range(count):
        at = SPACING * i
        while j < n and s[j + 1] <= at:
            j += 1
        if j == n:
            samples[i, 0], samples[i, 1], angle[i] = x[n], y[n], theta[n]
            continue
        rest, segment = at - s[j], s[j + 1] - s[j]
        samples[i, 0] = (x[j + 1] - x[j]) / segment * rest + x[j]
        samples[i, 1] = (y[j + 1] - y[j]) / segment * rest + y[j]
        angle[i] = (theta[j + 1] - theta[j]) / segment * rest + theta[j]
    # tangents
    for i in range(count):
        dx, dy = 0.0, 0.0
        if i < count - 1:
            dx, dy = samples[i + 1, 0] - samples[i, 0], samples[i + 1, 1] - samples[i, 1]
        if np.hypot(dx, dy) < 0.5 * SPACING:
            dx, dy = ahead_x, ahead_y
        norm = np.hypot(dx, dy)
        samples[i, 2], samples[i, 3] = dx / norm, dy / norm
    return samples, progress, angle


@njit(**INNER)
def project_on_path(samples: Floats, x: float, y: float, i: int) -> tuple[int, float, float]:
    """(i, s, d) of the nearest point of the path near sample ``i``: Frenet coordinates.

    The sample, the arc length s and the signed distance d, positive to the left of the path, m.
    """
    last, t, back = samples.shape[0] - 1, 0.0, False
    while True:
        t = (x - samples[i, 0]) * samples[i, 2] + (y - samples[i, 1]) * samples[i, 3]
        if t > SPACING and i < last and not back:
            i += 1
        elif t < 0.0 and i > 0:
            i -= 1
            back = True  # never forward again: outside a bend the loop would not end
        else:
            break
    d = samples[i, 2] * (y - samples[i, 1]) - samples[i, 3] * (x - samples[i, 0])
    return i, i * SPACING + min(max(t, 0.0), SPACING), d
