"""Barrier values of social spaces and their gradients.

    h = ‖c − p_i‖ − r_robot − r_i − margin − l_i(δ_i) − l(δ)     Xu et al., eq. (8), with radii and
                                                                 margin added

c is the point of the capsule's spine nearest to the person, δ_i the direction to it from the
person's axis of motion, δ the direction to the person from the robot's heading. Cosines and sines
of both are inner and outer products of unit vectors, so no angle is computed.

Values and gradients are separate kernels: values are needed at every trial trajectory, gradients
only where a row may become active (``barrier.near_states``).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.robots.capsule import nearest_on_spine
from cohelm.shapes import ELLIPSE, PRINTED

_STEEPEST = 2.0
"""Upper bound on the norm of h's gradient, without unit: the flank of a narrow space would
otherwise dominate."""


class SpaceShapes(NamedTuple):
    """Social spaces of people and robot for compiled code."""

    kind: int
    """As in ``shapes``."""
    axis: Floats
    """(q, N+1, 2) unit vectors along the people's motion."""
    people: Floats
    """(q, N+1, 3) ``coefficients``."""
    floor: float
    """Smallest extent of a person's space, m."""
    robot: Floats
    """(3,) ``coefficients`` of the robot's own space."""
    robot_floor: float
    """Smallest extent of that space, m."""


def coefficients(kind: int, scale: float, front: Floats, side: Floats, rear: Floats) -> Floats:
    """(..., 3) factors of cos² ahead, cos² behind and sin² in q / c of ``shapes``, from σ (...)."""
    behind = front if kind == ELLIPSE else rear
    sigma = np.stack([front, behind, side], axis=-1)
    return np.asarray(0.5 / (scale * sigma * sigma))


def max_extent(
    kind: int, scale: float, front: Floats, side: Floats, rear: Floats, floor: float
) -> float:
    """Largest extent of any of some spaces, m."""
    sigma = max(float(part.max(initial=0.0)) for part in (front, side, rear))
    return max(
        2.0 * scale * sigma * sigma if kind == PRINTED else sigma * math.sqrt(2.0 * scale), floor
    )


@njit(cache=True)
def social_barrier(
    capsule: Floats, poses: Floats, positions: Floats, clearance: Floats, spaces: SpaceShapes
) -> Floats:
    """Values h (q, N+1) against social spaces; eq. (8).

    poses: (N+1, 3).  positions: (q, N+1, 2).  clearance: (q, N+1), person's radius plus margin.
    """
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    h = np.empty((positions.shape[0], poses.shape[0]))
    for i in range(h.shape[0]):
        for k in range(h.shape[1]):
            dx, dy = positions[i, k, 0] - poses[k, 0], positions[i, k, 1] - poses[k, 1]
            d, ex, ey, _, _, _ = nearest_on_spine(capsule, cos[k], sin[k], dx, dy)
            nx, ny = cos[k] * ex - sin[k] * ey, sin[k] * ex + cos[k] * ey
            ahead = -(nx * spaces.axis[i, k, 0] + ny * spaces.axis[i, k, 1])
            theirs = _extent(spaces.kind, spaces.people[i, k], spaces.floor, ahead)
            own = _extent(spaces.kind, spaces.robot, spaces.robot_floor, ex)
            h[i, k] = d - capsule[4] - clearance[i, k] - theirs - own
    return h


@njit(cache=True)
def social_gradient(
    capsule: Floats, poses: Floats, positions: Floats, spaces: SpaceShapes, near: Booleans
) -> Floats:
    """∂h/∂pose (q, N+1, 3) of ``social_barrier``, bounded, 0 except at ``near`` (q, N+1)."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    out = np.zeros((positions.shape[0], poses.shape[0], 3))
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            if not near[i, k]:
                continue
            dx, dy = positions[i, k, 0] - poses[k, 0], positions[i, k, 1] - poses[k, 1]
            d, ex, ey, sx, sy, inside = nearest_on_spine(capsule, cos[k], sin[k], dx, dy)
            nx, ny = cos[k] * ex - sin[k] * ey, sin[k] * ex + cos[k] * ey
            ahead = -(nx * spaces.axis[i, k, 0] + ny * spaces.axis[i, k, 1])
            aside = nx * spaces.axis[i, k, 1] - ny * spaces.axis[i, k, 0]
            theirs = _slope(spaces.kind, spaces.people[i, k], spaces.floor, ahead, aside)
            own = _slope(spaces.kind, spaces.robot, spaces.robot_floor, ex, ey)
            # turn of the direction with the pose: with the spine where the nearest point is inside
            # it, else about its fixed end
            tx, ty, ta = 0.0, 0.0, 1.0
            if not inside:
                tx, ty, ta = ny / d, -nx / d, -(ex * sx + ey * sy) / d
            gx = -nx - (theirs + own) * tx
            gy = -ny - (theirs + own) * ty
            ga = ex * sy - ey * sx - theirs * ta - own * (ta - 1.0)
            steep = math.sqrt(gx * gx + gy * gy)
            cut = _STEEPEST / steep if steep > _STEEPEST else 1.0
            out[i, k, 0], out[i, k, 1], out[i, k, 2] = cut * gx, cut * gy, cut * ga
    return out


@njit(cache=True, inline="always")
def _extent(kind: int, shape: Floats, floor: float, cos: float) -> float:
    """``shapes.extent`` from ``coefficients`` and the direction's cosine."""
    along = shape[0] if cos > 0.0 else shape[1]
    q = shape[2] + (along - shape[2]) * cos * cos
    length: float = 1.0 / q if kind == PRINTED else 1.0 / math.sqrt(q)
    return max(length, floor)


@njit(cache=True, inline="always")
def _slope(kind: int, shape: Floats, floor: float, cos: float, sin: float) -> float:
    """dl/dδ of ``_extent``; 0 at the floor."""
    along = shape[0] if cos > 0.0 else shape[1]
    q: float = shape[2] + (along - shape[2]) * cos * cos
    dq: float = 2.0 * (shape[2] - along) * sin * cos
    length: float = 1.0 / q if kind == PRINTED else 1.0 / math.sqrt(q)
    if length < floor:
        return 0.0
    return -length * length * dq if kind == PRINTED else -0.5 * length * length * length * dq
