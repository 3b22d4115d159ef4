"""Radial shapes: how far a space reaches in each direction from its centre.

A shape is (kind, front, side, rear, scale, floor). Its reach in direction δ from the axis of motion

    printed   l = c / q(δ)         Xu et al., eq. (5); c in 1/m; not convex at speed
    contour   l = √(c / q(δ))      the Gaussian's own contour; c without unit; convex
    ellipse   the contour with σ = σ_h behind as well: the least ellipse about the person that
              bounds it; with c = ½ its half axes are σ_h and σ_s
    q(δ) = cos²δ / 2σ² + sin²δ / 2σ_s²,   σ = σ_h where cos δ > 0, else σ_r

and never less than the floor. The printed front test, 0 < δ < π, tells left from right; front is
cos δ > 0, which makes l continuously differentiable at the side. A circle is σ_h = σ_s = σ_r.
``social`` chooses shapes, ``control`` evaluates them, ``pictures`` draws them.

A convex hull of such shapes is told by its support function s, the greatest p·u over the hull, for
evenly spaced directions u. A point is outside where p·u > s for some u; :func:`distance_to_hull`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats

PRINTED = 0
CONTOUR = 1
ELLIPSE = 2
KINDS = {"printed": PRINTED, "contour": CONTOUR, "ellipse": ELLIPSE}


@njit(cache=True, inline="always")
def reach(  # noqa: PLR0917  # a scalar kernel takes scalars
    kind: int, front: float, side: float, rear: float, scale: float, floor: float, delta: float
) -> tuple[float, float]:
    """(l, dl/dδ) in direction ``delta``, rad from the axis of motion; m and m/rad.

    Where the floor holds, the slope is 0.
    """
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


@njit(cache=True)
def outline(  # noqa: PLR0913, PLR0917  # a scalar kernel takes scalars
    kind: int,
    front: float,
    side: float,
    rear: float,
    scale: float,
    floor: float,
    margin: float,
    pose: Floats,
    count: int,
) -> Floats:
    """The closed outline (count + 1, 2) of a shape at a pose (x, y, axis), ``margin`` added."""
    out = np.empty((count + 1, 2))
    for i in range(count + 1):
        delta = 2.0 * math.pi * i / count - math.pi
        length, _ = reach(kind, front, side, rear, scale, floor, delta)
        out[i, 0] = pose[0] + (length + margin) * math.cos(pose[2] + delta)
        out[i, 1] = pose[1] + (length + margin) * math.sin(pose[2] + delta)
    return out


@njit(cache=True)
def support(  # noqa: PLR0917  # a scalar kernel takes scalars
    kind: int,
    front: float,
    side: float,
    rear: float,
    scale: float,
    floor: float,
    cos: float,
    sin: float,
) -> float:
    """How far a shape reaches in a direction, the greatest p·u over it, from its centre; m.

    The contour is two half ellipses that meet at the side (an ellipse is one), so
    s = √(2c (σ² cos²φ + σ_s² sin²φ)) in closed form. As printed it is not convex: the greatest of
    ``_SAMPLES`` points, some tenths of a per cent less than the whole. With a floor the shape is
    the union with a disc.

    Args:
        kind, front, side, rear, scale, floor: the shape.
        cos, sin: of the angle φ of u from the axis of motion.
    """
    if kind != PRINTED:
        sigma = front if cos > 0.0 or kind == ELLIPSE else rear
        best = math.sqrt(2.0 * scale * (sigma * sigma * cos * cos + side * side * sin * sin))
        return max(best, floor)
    best = floor
    for k in range(_SAMPLES):
        delta = 2.0 * math.pi * k / _SAMPLES
        length, _ = reach(kind, front, side, rear, scale, floor, delta)
        best = max(best, length * (math.cos(delta) * cos + math.sin(delta) * sin))
    return best


@njit(cache=True)
def nearest_support(direction: Floats, far: Floats, x: float, y: float) -> tuple[float, int]:
    """(distance, k) of a point to a hull: the greatest p·u − s, and of which direction.

    Negative inside. Outside it is never more than the true distance, and at least cos(π / m) of
    it, exact as the directions grow in number. Its gradient with respect to the point is u.

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


@njit(cache=True)
def distance_to_hull(direction: Floats, far: Floats, points: Floats) -> tuple[Floats, Floats]:
    """(distance (k,) m, its gradient (k, 2)) of points (k, 2) to a hull; see nearest_support."""
    distance = np.empty(points.shape[0])
    gradient = np.empty((points.shape[0], 2))
    for i in range(points.shape[0]):
        distance[i], at = nearest_support(direction, far, points[i, 0], points[i, 1])
        gradient[i, 0], gradient[i, 1] = math.cos(direction[at]), math.sin(direction[at])
    return distance, gradient


def hull_outline(direction: Floats, far: Floats) -> Floats:
    """The closed polygon (m + 1, 2) in which neighbouring support lines meet, m.

    It encloses the hull and touches it once on each edge.
    """
    turn = np.roll(direction, -1) - direction
    along = (np.roll(far, -1) - far * np.cos(turn)) / np.sin(turn)
    cos, sin = np.cos(direction), np.sin(direction)
    corners = np.stack([far * cos - along * sin, far * sin + along * cos], axis=-1)
    return np.concatenate([corners, corners[:1]])


_SAMPLES = 72
"""Directions in which a shape that is not convex is looked at."""
