"""How far the robot is from people: the barrier values of bodies and of social spaces.

The footprint is a capsule (``Robot.capsule``): all points within a radius of its spine, the segment
through the centres of its discs. Distances are smooth, and exact for the capsule.

    bodies   h = ‖c − p_i‖ − r_body − r_i − margin
    social   h = ‖c − p_i‖ − r_body − r_i − margin − l_i(δ_i) − l(δ)   Xu et al., eq. (8), bodies
                                                                       and margin added

c is the spine's point nearest to the person, δ_i the direction to it from the person's axis of
motion, δ the direction to the person from the robot's heading. Cosines and sines of both are inner
and outer products of unit vectors, so that no angle is ever computed.

Values and gradients are kernels apart: values are wanted at every motion that is tried, gradients
only where a row may become active (``barrier.near_states``).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.robots.spine import foot_on_spine
from cohelm.shapes import ELLIPSE, PRINTED

_STEEPEST = 2.0
"""The gradient of h is cut to this, without unit: an egg's flank would else outweigh the rest."""


def coefficients(kind: int, scale: float, front: Floats, side: Floats, rear: Floats) -> Floats:
    """(..., 3) factors of cos² ahead, cos² behind and sin² in q / c of ``shapes``, from σ (...)."""
    behind = front if kind == ELLIPSE else rear
    sigma = np.stack([front, behind, side], axis=-1)
    return np.asarray(0.5 / (scale * sigma * sigma))


@njit(cache=True)
def body_barrier(capsule: Floats, poses: Floats, positions: Floats, kept: Floats) -> Floats:
    """Values h (q, N+1) against bodies.

    poses: (N+1, 3).  positions: (q, N+1, 2).  kept: (q, N+1), the body's radius and the margin.
    """
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    h = np.empty((positions.shape[0], poses.shape[0]))
    for i in range(h.shape[0]):
        for k in range(h.shape[1]):
            dx, dy = positions[i, k, 0] - poses[k, 0], positions[i, k, 1] - poses[k, 1]
            d = foot_on_spine(capsule, cos[k], sin[k], dx, dy)[0]
            h[i, k] = d - capsule[4] - kept[i, k]
    return h


@njit(cache=True)
def body_gradient(capsule: Floats, poses: Floats, positions: Floats, near: Booleans) -> Floats:
    """∂h/∂pose (q, N+1, 3) of ``body_barrier``, 0 but where ``near`` (q, N+1)."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    out = np.zeros((positions.shape[0], poses.shape[0], 3))
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            if not near[i, k]:
                continue
            dx, dy = positions[i, k, 0] - poses[k, 0], positions[i, k, 1] - poses[k, 1]
            _, ex, ey, sx, sy, _ = foot_on_spine(capsule, cos[k], sin[k], dx, dy)
            out[i, k, 0] = -(cos[k] * ex - sin[k] * ey)
            out[i, k, 1] = -(sin[k] * ex + cos[k] * ey)
            out[i, k, 2] = ex * sy - ey * sx
    return out


@njit(cache=True)
def social_barrier(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    positions: Floats,
    kept: Floats,
    kind: int,
    axis: Floats,
    eggs: Floats,
    floor: float,
    robot: Floats,
    robot_floor: float,
) -> Floats:
    """Values h (q, N+1) against social spaces; eq. (8).

    axis: (q, N+1, 2) unit vectors.  eggs: (q, N+1, 3) ``coefficients``.  robot: (3,), the same.
    """
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    h = np.empty((positions.shape[0], poses.shape[0]))
    for i in range(h.shape[0]):
        for k in range(h.shape[1]):
            dx, dy = positions[i, k, 0] - poses[k, 0], positions[i, k, 1] - poses[k, 1]
            d, ex, ey, _, _, _ = foot_on_spine(capsule, cos[k], sin[k], dx, dy)
            nx, ny = cos[k] * ex - sin[k] * ey, sin[k] * ex + cos[k] * ey
            ahead = -(nx * axis[i, k, 0] + ny * axis[i, k, 1])
            mine = _reach(kind, eggs[i, k], floor, ahead)
            h[i, k] = d - capsule[4] - kept[i, k] - mine - _reach(kind, robot, robot_floor, ex)
    return h


@njit(cache=True)
def social_gradient(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    positions: Floats,
    kind: int,
    axis: Floats,
    eggs: Floats,
    floor: float,
    robot: Floats,
    robot_floor: float,
    near: Booleans,
) -> Floats:
    """∂h/∂pose (q, N+1, 3) of ``social_barrier``, 0 but where ``near`` (q, N+1); cut if steep."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    out = np.zeros((positions.shape[0], poses.shape[0], 3))
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            if not near[i, k]:
                continue
            dx, dy = positions[i, k, 0] - poses[k, 0], positions[i, k, 1] - poses[k, 1]
            d, ex, ey, sx, sy, inside = foot_on_spine(capsule, cos[k], sin[k], dx, dy)
            nx, ny = cos[k] * ex - sin[k] * ey, sin[k] * ex + cos[k] * ey
            ahead = -(nx * axis[i, k, 0] + ny * axis[i, k, 1])
            aside = nx * axis[i, k, 1] - ny * axis[i, k, 0]
            mine = _slope(kind, eggs[i, k], floor, ahead, aside)
            own = _slope(kind, robot, robot_floor, ex, ey)
            # how the direction turns with the pose: with the spine where the foot is inside it,
            # else about its fixed end
            tx, ty, ta = 0.0, 0.0, 1.0
            if not inside:
                tx, ty, ta = ny / d, -nx / d, -(ex * sx + ey * sy) / d
            gx = -nx - (mine + own) * tx
            gy = -ny - (mine + own) * ty
            ga = ex * sy - ey * sx - mine * ta - own * (ta - 1.0)
            steep = math.sqrt(gx * gx + gy * gy)
            cut = _STEEPEST / steep if steep > _STEEPEST else 1.0
            out[i, k, 0], out[i, k, 1], out[i, k, 2] = cut * gx, cut * gy, cut * ga
    return out


@njit(cache=True, inline="always")
def _reach(kind: int, egg: Floats, floor: float, cos: float) -> float:
    """``shapes.reach`` from ``coefficients`` and the direction's cosine."""
    along = egg[0] if cos > 0.0 else egg[1]
    q = egg[2] + (along - egg[2]) * cos * cos
    length: float = 1.0 / q if kind == PRINTED else 1.0 / math.sqrt(q)
    return max(length, floor)


@njit(cache=True, inline="always")
def _slope(kind: int, egg: Floats, floor: float, cos: float, sin: float) -> float:
    """dl/dδ of ``_reach``; 0 where the floor holds."""
    along = egg[0] if cos > 0.0 else egg[1]
    q: float = egg[2] + (along - egg[2]) * cos * cos
    dq: float = 2.0 * (egg[2] - along) * sin * cos
    length: float = 1.0 / q if kind == PRINTED else 1.0 / math.sqrt(q)
    if length < floor:
        return 0.0
    return -length * length * dq if kind == PRINTED else -0.5 * length * length * length * dq


def greatest_reach(
    kind: int, scale: float, front: Floats, side: Floats, rear: Floats, floor: float
) -> float:
    """The farthest that any of some shapes reaches, m."""
    sigma = max(float(part.max(initial=0.0)) for part in (front, side, rear))
    return max(
        2.0 * scale * sigma * sigma if kind == PRINTED else sigma * math.sqrt(2.0 * scale), floor
    )
