"""How far the robot is from people: the barrier values of bodies and of social spaces.

The footprint is a capsule (``Robot.capsule``): all points within a radius of its spine, the segment
through the centres of its discs. Distances are smooth, and exact for the capsule.

    bodies   h = ‖c − p_i‖ − r_body − r_i − margin
    social   h = ‖c − p_i‖ − r_body − r_i − l_i(δ_i) − l(δ)        Xu et al., eq. (8), bodies added

c is the spine's point nearest to the person, δ_i the direction to it from the person's axis of
motion, δ the direction to the person from the robot's heading.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.robots.contact import nearest_on_spine
from cohelm.shapes import reach

_STEEPEST = 2.0
"""The gradient of h is cut to this, without unit: an egg's flank would else outweigh the rest."""


@njit(cache=True)
def body_barrier(  # noqa: PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    positions: Floats,
    radius: Floats,
    step: float,
    margin: float,
    growth: float,
    greatest: float,
) -> tuple[Floats, Floats]:
    """(h (n, N+1), gradient (n, N+1, 3)) against bodies.

    The margin grows with time, margin(t) = min(margin + growth·t, greatest).
    poses: (N+1, 3).  positions: (n, N+1, 2).  radius: (n,).
    """
    n, states = positions.shape[0], poses.shape[0]
    h = np.empty((n, states))
    gradient = np.empty((n, states, 3))
    for i in range(n):
        for k in range(states):
            d, nx, ny, ax, ay, _ = nearest_on_spine(
                capsule, poses[k], positions[i, k, 0], positions[i, k, 1]
            )
            h[i, k] = d - capsule[4] - radius[i] - min(margin + growth * k * step, greatest)
            gradient[i, k, 0] = -nx
            gradient[i, k, 1] = -ny
            gradient[i, k, 2] = -(nx * ax + ny * ay)
    return h, gradient


@njit(cache=True)
def social_barrier(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    positions: Floats,
    radius: Floats,
    kind: int,
    scale: float,
    axis: Floats,
    front: Floats,
    side: Floats,
    rear: Floats,
    floor: float,
    robot: Floats,
    robot_floor: float,
) -> tuple[Floats, Floats]:
    """(h (n, N+1), gradient (n, N+1, 3)) against social spaces; eq. (8).

    axis, front, side, rear: (n, N+1) of the people.  robot: (σ_h, σ_s, σ_r) of the robot's own.
    """
    n, states = positions.shape[0], poses.shape[0]
    h = np.empty((n, states))
    gradient = np.empty((n, states, 3))
    for i in range(n):
        for k in range(states):
            d, nx, ny, ax, ay, inside = nearest_on_spine(
                capsule, poses[k], positions[i, k, 0], positions[i, k, 1]
            )
            away = math.atan2(-ny, -nx)
            mine, my_slope = reach(
                kind, front[i, k], side[i, k], rear[i, k], scale, floor, away - axis[i, k]
            )
            own, own_slope = reach(
                kind,
                robot[0],
                robot[1],
                robot[2],
                scale,
                robot_floor,
                math.atan2(ny, nx) - poses[k, 2],
            )
            # how the direction turns with the pose: with the spine where the foot is inside it,
            # else about its fixed end
            if inside:
                tx, ty, ta = 0.0, 0.0, 1.0
            else:
                tx, ty = ny / d, -nx / d
                ta = (ny * ax - nx * ay) / d
            gx = -nx - my_slope * tx - own_slope * tx
            gy = -ny - my_slope * ty - own_slope * ty
            ga = -(nx * ax + ny * ay) - my_slope * ta - own_slope * (ta - 1.0)
            steep = math.sqrt(gx * gx + gy * gy)
            if steep > _STEEPEST:
                gx, gy, ga = (
                    gx * _STEEPEST / steep,
                    gy * _STEEPEST / steep,
                    ga * _STEEPEST / steep,
                )
            h[i, k] = d - capsule[4] - radius[i] - mine - own
            gradient[i, k, 0] = gx
            gradient[i, k, 1] = gy
            gradient[i, k, 2] = ga
    return h, gradient
