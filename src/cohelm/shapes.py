"""Radial shapes: how far a space reaches in each direction from its centre.

A shape is (kind, front, side, rear, scale, floor). Its reach in direction δ from the axis of motion

    printed   l = c / q(δ)         Xu et al., eq. (5); c in 1/m; not convex at speed
    contour   l = √(c / q(δ))      the Gaussian's own contour; c without unit; convex
    q(δ) = cos²δ / 2σ² + sin²δ / 2σ_s²,   σ = σ_h where cos δ > 0, else σ_r

and never less than the floor. The printed front test, 0 < δ < π, tells left from right; front is
cos δ > 0, which makes l continuously differentiable at the side. A circle is σ_h = σ_s = σ_r.
``social`` chooses shapes, ``control`` evaluates them, ``pictures`` draws them.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats

PRINTED = 0
CONTOUR = 1
KINDS = {"printed": PRINTED, "contour": CONTOUR}


@njit(cache=True, inline="always")
def reach(  # noqa: PLR0917  # a scalar kernel takes scalars
    kind: int, front: float, side: float, rear: float, scale: float, floor: float, delta: float
) -> tuple[float, float]:
    """(l, dl/dδ) in direction ``delta``, rad from the axis of motion; m and m/rad.

    Where the floor holds, the slope is 0.
    """
    cos, sin = math.cos(delta), math.sin(delta)
    sigma = front if cos > 0.0 else rear
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
