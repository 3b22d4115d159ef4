"""Social forces, accelerations in m/s²: between people, of walls, and within groups.

Between people: Moussaïd, Helbing, Garnier, Johansson, Combe, Theraulaz, "Experimental study of the
behavioural mechanisms underlying self-organization in human crowds", Proc. R. Soc. B 276 (2009).
Within groups: Moussaïd, Perozo, Garnier, Helbing, Theraulaz, "The walking behaviour of pedestrian
social groups and its impact on crowd dynamics", PLoS ONE 5 (2010). Both after Helbing and Molnár,
"Social force model for pedestrian dynamics", Phys. Rev. E 51 (1995).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.array_kernels import stable_order
from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED
from cohelm.simulation.wall_geometry import SurfaceCells, free_region, near_cells, to_grid_frame


@njit(**CACHED)
def pair_forces(
    position: Floats,
    velocity: Floats,
    radius: Floats,
    group: Integers,
    sees_robot: Booleans,
    reach: float,
    strength: float,
    gamma: float,
    narrow: float,
    wide: float,
    weight: float,
    bias: float,
) -> Floats:
    """Accelerations (n, 2) between people; Moussaïd et al. 2009.

    With D = λ(v_i − v_j) + e_ij, t = D/‖D‖, n to its left, B = γ‖D‖, θ the angle from t to e_ij
    plus Bε:
    f_ij = −A e^(−d/B) (e^(−(n'Bθ)²) t + sgn θ · e^(−(nBθ)²) n).

    So f_ji = −f_ij. d is the distance between centres, corrected for bodies wider than that of
    person i. Members of the same group have no force of this kind.

    Args:
        position, velocity, radius: (n + 1, 2), (n + 1, 2), (n + 1,); the last is the robot.
        group: (n,), −1: alone.
        sees_robot: (n,).
        reach: range of the force, m.
        strength, gamma, narrow, wide, weight, bias: A, γ, n', n, λ, ε.
    """
    n = group.shape[0]
    out = np.zeros((n, 2))
    order = stable_order(position[:, 0].copy())
    for a in range(n + 1):
        # Sorted by x, so the inner loop ends at the range of the force.
        i = order[a]
        for b in range(a + 1, n + 1):
            j = order[b]
            dx, dy = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            if dx > reach:
                break
            d2 = dx * dx + dy * dy
            if d2 > reach * reach or d2 == 0.0:
                continue
            if i < n and j < n and group[i] >= 0 and group[i] == group[j]:
                continue
            # Interaction vector D, and the angle θ to the line of sight.
            d = math.sqrt(d2)
            ex, ey = dx / d, dy / d
            rx = weight * (velocity[i, 0] - velocity[j, 0]) + ex
            ry = weight * (velocity[i, 1] - velocity[j, 1]) + ey
            size = math.hypot(rx, ry)
            if size < 1e-9:
                continue
            tx, ty = rx / size, ry / size
            B = gamma * size
            theta = math.atan2(tx * ey - ty * ex, tx * ex + ty * ey) + B * bias
            # Deceleration along t, turning along n; equal and opposite for both.
            ahead = math.exp(-((narrow * B * theta) ** 2))
            aside = math.exp(-((wide * B * theta) ** 2))
            aside = math.copysign(aside, theta) if theta != 0.0 else 0.0
            fx, fy = ahead * tx - aside * ty, ahead * ty + aside * tx
            if i < n and (j < n or sees_robot[i]):
                f = strength * math.exp(-(d - radius[j] + radius[i]) / B)
                out[i, 0] -= f * fx
                out[i, 1] -= f * fy
            if j < n and (i < n or sees_robot[j]):
                f = strength * math.exp(-(d - radius[i] + radius[j]) / B)
                out[j, 0] += f * fx
                out[j, 1] += f * fy
    return out


@njit(**CACHED)
def wall_forces(
    position: Floats,
    body: Floats,
    walls: SurfaceCells,
    strength: float,
    decay: float,
) -> Floats:
    """Accelerations (n, 2) away from the nearest wall, a e^(−d/b) with d from the body's surface.

    Args:
        position, body: (n, 2), (n,).
        walls: surface cells of the grid.
        strength, decay: a, m/s², and b, m.
    """
    out = np.zeros((position.shape[0], 2))
    cos, sin = math.cos(walls.X_MG[2]), math.sin(walls.X_MG[2])
    for i in range(position.shape[0]):
        x, y = to_grid_frame(walls, position[i, 0], position[i, 1])
        near = near_cells(walls, x, y, body[i] + 7.0 * decay)
        region = free_region(near, walls.half, x, y)
        if region.shape[0] == 0:
            continue
        f = -strength * math.exp(-max(region[0, 2] - body[i], 0.0) / decay)
        out[i, 0] = f * (cos * region[0, 0] - sin * region[0, 1])
        out[i, 1] = f * (sin * region[0, 0] + cos * region[0, 1])
    return out


@njit(**CACHED)
def group_forces(
    position: Floats,
    velocity: Floats,
    preferred: Floats,
    group: Integers,
    gaze: float,
    attraction: float,
    repulsion: float,
    sight: float,
    near: float,
) -> Floats:
    """Accelerations (n, 2) within groups; Moussaïd et al. 2010.

    −β₁ α v, where α is the angle of the group's centre outside of the field of view: people slow
    down until they see the others; β₂ to the centre, if it is farther than (N − 1)/2 m; β₃ away
    from each member who is too near.

    Args:
        position, velocity, preferred: (n, 2); people look in the direction of ``preferred``.
        group: (n,), −1: alone.
        gaze, attraction, repulsion: β₁, 1/(rad s), β₂ and β₃, m/s².
        sight: half the field of view, rad.
        near: minimum distance between members, m.
    """
    n = group.shape[0]
    out = np.zeros((n, 2))
    order = stable_order(group)
    a = 0
    while a < n:
        # Members of one group are contiguous in the order.
        b = a
        while b < n and group[order[b]] == group[order[a]]:
            b += 1
        if group[order[a]] >= 0 and b - a > 1:
            for k in range(a, b):
                i, size = order[k], b - a
                cx, cy = 0.0, 0.0
                for m in range(a, b):
                    j = order[m]
                    dx, dy = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
                    cx, cy = cx + dx / size, cy + dy / size
                    d = math.hypot(dx, dy)
                    if 0.0 < d < near:
                        out[i, 0] -= repulsion * dx / d
                        out[i, 1] -= repulsion * dy / d
                away = math.hypot(cx, cy)
                if away > 0.5 * (size - 1):
                    out[i, 0] += attraction * cx / away
                    out[i, 1] += attraction * cy / away
                if away > 0.0 and (preferred[i, 0] != 0.0 or preferred[i, 1] != 0.0):
                    cross = preferred[i, 0] * cy - preferred[i, 1] * cx
                    angle = abs(math.atan2(cross, preferred[i, 0] * cx + preferred[i, 1] * cy))
                    slow = gaze * max(angle - sight, 0.0)
                    out[i, 0] -= slow * velocity[i, 0]
                    out[i, 1] -= slow * velocity[i, 1]
        a = b
    return out
