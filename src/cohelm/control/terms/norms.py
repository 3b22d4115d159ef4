"""Distances to people in other norms than the Euclidean one, for the linear MPC of Turri et al.

The vector from the robot's spine to the person is taken along and across the reference, so that its
norms do not depend on the map's axes. The largest component is a box about the person with a linear
constraint: pass beside it, or stay behind it. The 1-norm is a diamond, √2 as wide so that it
contains the disc of the 2-norm.
"""

from __future__ import annotations

import math

from numba import njit

from cohelm.control.terms.stage import Encounter
from cohelm.kernels import INNER, KERNEL


@njit(**INNER)
def norm_gap(e: Encounter, axis: float, size: float, norm: int) -> float:
    """‖q‖ − size in norm 1, or 0 for the largest component, m; axis: the reference's heading."""
    cos, sin = math.cos(axis), math.sin(axis)
    qx = abs(e.distance * (cos * e.nx + sin * e.ny))
    qy = abs(e.distance * (cos * e.ny - sin * e.nx))
    return qx + qy - math.sqrt(2.0) * size if norm == 1 else max(qx, qy) - size


@njit(**KERNEL)
def norm_gradient(
    e: Encounter, stage_cos: float, stage_sin: float, axis: float, norm: int
) -> tuple[float, float, float]:
    """∂‖q‖/∂(x, y, θ) of the robot."""
    cos, sin = math.cos(axis), math.sin(axis)
    qx, qy = e.distance * (cos * e.nx + sin * e.ny), e.distance * (cos * e.ny - sin * e.nx)
    gx, gy = math.copysign(1.0, qx), math.copysign(1.0, qy)
    if norm != 1:
        gx, gy = (gx, 0.0) if abs(qx) > abs(qy) else (0.0, gy)
    ux, uy = cos * gx - sin * gy, sin * gx + cos * gy
    arm_x, arm_y = -(stage_sin * e.sx + stage_cos * e.sy), stage_cos * e.sx - stage_sin * e.sy
    turned = 0.0
    if e.inside:  # the nearest point slides: q stays normal to the spine and turns with it
        turned = e.distance * (uy * e.nx - ux * e.ny)
        share = ux * e.nx + uy * e.ny
        ux, uy = share * e.nx, share * e.ny
    return -ux, -uy, turned - (ux * arm_x + uy * arm_y)
