"""Radial shapes: the extent of a personal space in each direction from its centre.

The extent of a :class:`RadialShape` in direction δ from the axis of motion is

    printed   l = c / q(δ)         Xu et al., eq. (5); c in 1/m; not convex at speed
    contour   l = √(c / q(δ))      the Gaussian's own contour; c without unit; convex
    ellipse   the contour with σ = σ_h behind as well: the smallest ellipse about the person that
              bounds it; with c = ½ its half axes are σ_h and σ_s
    q(δ) = cos²δ / 2σ² + sin²δ / 2σ_s²,   σ = σ_h where cos δ > 0, else σ_r

and never less than the floor. The printed front test, 0 < δ < π, distinguishes left from right; the
front is cos δ > 0, which makes l continuously differentiable at the side. A circle is
σ_h = σ_s = σ_r. ``social`` chooses shapes, ``control`` evaluates them, ``plotting`` draws them.

``control.terms.encounter`` evaluates l from precomputed coefficients of q and the cosine of δ: its
loops have no angles, and rounding differs from :func:`extent`.

A convex hull of such shapes is represented by its support function s, the maximum of p·u over the
hull, for evenly spaced directions u. A point is outside where p·u > s for some u.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable

from cohelm.arrays import Floats
from cohelm.kernels import CACHED, callee

PRINTED = 0
CONTOUR = 1
ELLIPSE = 2
KINDS = {"printed": PRINTED, "contour": CONTOUR, "ellipse": ELLIPSE}


_SAMPLES = 72
"""Directions for the support of a shape that is not convex."""


class RadialShape(NamedTuple):
    """Shape about a person or the robot."""

    kind: int
    """``PRINTED``, ``CONTOUR`` or ``ELLIPSE``."""
    front: float
    """σ_h, m."""
    side: float
    """σ_s, m."""
    rear: float
    """σ_r, m."""
    scale: float
    """c."""
    floor: float
    """Minimum extent, m."""


@register_jitable
def gaussian_deviations(speed: Any) -> tuple[Any, Any, Any]:
    """(σ_h, σ_s, σ_r) of eq. (5), m: max(1/2, 2|v|), 2/3 σ_h and 1/2 σ_h; of one speed or many."""
    front = np.maximum(0.5, 2.0 * speed)
    return front, front * 2.0 / 3.0, front / 2.0


@njit(**CACHED, inline="always")
def extent(shape: RadialShape, delta: float) -> tuple[float, float]:
    """(l, dl/dδ) in direction ``delta``, rad from the axis of motion; m and m/rad.

    The slope is 0 where the floor applies.
    """
    kind, front, side, rear, scale, floor = shape
    cos, sin = math.cos(delta), math.sin(delta)
    sigma = front if cos > 0.0 or kind == ELLIPSE else rear
    a, b = 0.5 / (sigma * sigma), 0.5 / (side * side)
    q = a * cos * cos + b * sin * sin
    dq = 2.0 * (b - a) * sin * cos
    if kind == PRINTED:
        length = scale / q
        slope = -length * dq / q
    else:
        length = math.sqrt(scale / q)
        slope = -0.5 * length * dq / q
    if length < floor:
        return floor, 0.0
    return length, slope


@njit(**CACHED)
def outline(shape: RadialShape, margin: float, pose: Floats, count: int) -> Floats:
    """Closed outline (count + 1, 2) of a shape at a pose (x, y, axis), grown by ``margin``, m."""
    out = np.empty((count + 1, 2))
    for i in range(count + 1):
        delta = 2.0 * math.pi * i / count - math.pi
        length, _ = extent(shape, delta)
        out[i, 0] = pose[0] + (length + margin) * math.cos(pose[2] + delta)
        out[i, 1] = pose[1] + (length + margin) * math.sin(pose[2] + delta)
    return out


@njit(**CACHED)
def support(shape: RadialShape, cos: float, sin: float) -> float:
    """Support of a shape, the maximum of p·u over it, from its centre; m.

    The contour is two half ellipses that meet at the side (an ellipse is one), so
    s = √(2c (σ² cos²φ + σ_s² sin²φ)) in closed form. The printed shape is not convex: the maximum
    of ``_SAMPLES`` points, less by some tenths of a per cent. With a floor the shape is the union
    with a disc. cos, sin: of the angle φ of u from the axis of motion.
    """
    kind, front, side, rear, scale, floor = shape
    if kind != PRINTED:
        sigma = front if cos > 0.0 or kind == ELLIPSE else rear
        best = math.sqrt(2.0 * scale * (sigma * sigma * cos * cos + side * side * sin * sin))
        return max(best, floor)
    best = floor
    for k in range(_SAMPLES):
        delta = 2.0 * math.pi * k / _SAMPLES
        length, _ = extent(shape, delta)
        best = max(best, length * (math.cos(delta) * cos + math.sin(delta) * sin))
    return best


@callee()
def nearest_support(direction: Floats, far: Floats, x: float, y: float) -> tuple[float, int]:
    """(distance, k) of a point to a hull: the maximum of p·u − s, and its direction's index.

    Negative inside. Outside it is at most the true distance, and at least cos(π / m) of it. Its
    gradient with respect to the point is u.

    Args:
        direction: (m,) of the normals u, rad.
        far: (m,) the support s, m.
        x, y: the point, m.
    """
    best, at = -math.inf, 0
    for k in range(direction.shape[0]):
        excess = x * math.cos(direction[k]) + y * math.sin(direction[k]) - far[k]
        if excess > best:
            best, at = excess, k
    return best, at


@njit(**CACHED)
def distance_to_hull(direction: Floats, far: Floats, points: Floats) -> tuple[Floats, Floats]:
    """(distance (k,) m, its gradient (k, 2)) of points (k, 2); see :func:`nearest_support`."""
    distance = np.empty(points.shape[0])
    gradient = np.empty((points.shape[0], 2))
    for i in range(points.shape[0]):
        distance[i], at = nearest_support(direction, far, points[i, 0], points[i, 1])
        gradient[i, 0], gradient[i, 1] = math.cos(direction[at]), math.sin(direction[at])
    return distance, gradient


def hull_outline(direction: Floats, far: Floats) -> Floats:
    """Closed polygon (m + 1, 2) of the intersections of neighbouring support lines, m.

    It encloses the hull and touches it on each edge.
    """
    turn = np.roll(direction, -1) - direction
    along = (np.roll(far, -1) - far * np.cos(turn)) / np.sin(turn)
    cos, sin = np.cos(direction), np.sin(direction)
    corners = np.stack([far * cos - along * sin, far * sin + along * cos], axis=-1)
    return np.concatenate([corners, corners[:1]])
