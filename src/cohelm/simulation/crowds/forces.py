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

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.simulation.walls import free_region, near_cells


@njit(cache=True)
def pair_forces(  # noqa: PLR0913, PLR0917  # a kernel takes arrays and scalars
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
    """What people do for the sake of each other, (n, 2); Moussaïd et al. 2009.

    With D = λ(v_i − v_j) + e_ij, t = D/‖D‖, n to its left, B = γ‖D‖, θ the angle from t to e_ij
    plus Bε:
    f_ij = −A e^(−d/B) (e^(−(n'Bθ)²) t + sgn θ · e^(−(nBθ)²) n).

    So f_ji = −f_ij. d is the distance between centres, less what the two bodies are wider than two
    like person i. Who is in the same group has no force of this kind.

    Args:
        position, velocity, radius: (n + 1, 2), (n + 1, 2), (n + 1,); the last is the robot.
        group: (n,), −1: nobody's.
        sees_robot: (n,).
        reach: beyond which there is no force, m.
        strength, gamma, narrow, wide, weight, bias: A, γ, n', n, λ, ε.
    """
    n = group.shape[0]
    out = np.zeros((n, 2))
    order = np.argsort(position[:, 0], kind="mergesort")
    for a in range(n + 1):
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


@njit(cache=True)
def wall_forces(  # noqa: PLR0913, PLR0917  # a kernel takes arrays and scalars
    position: Floats,
    body: Floats,
    cells: Floats,
    start: Integers,
    tiles: Integers,
    half: float,
    X_MG: Floats,
    strength: float,
    decay: float,
) -> Floats:
    """Away from the nearest wall, a e^(−d/b) with d from the body's surface, (n, 2).

    Args:
        position, body: (n, 2), (n,).
        cells, start, tiles, half, X_MG: of ``Walls``.
        strength, decay: a, m/s², and b, m.
    """
    out = np.zeros((position.shape[0], 2))
    cos, sin = math.cos(X_MG[2]), math.sin(X_MG[2])
    for i in range(position.shape[0]):
        ox, oy = position[i, 0] - X_MG[0], position[i, 1] - X_MG[1]
        x, y = cos * ox + sin * oy, -sin * ox + cos * oy
        near = near_cells(cells, start, tiles, half, x, y, body[i] + 7.0 * decay)
        region = free_region(near, half, x, y)
        if region.shape[0] == 0:
            continue
        f = -strength * math.exp(-max(region[0, 2] - body[i], 0.0) / decay)
        out[i, 0] = f * (cos * region[0, 0] - sin * region[0, 1])
        out[i, 1] = f * (sin * region[0, 0] + cos * region[0, 1])
    return out


@njit(cache=True)
def group_forces(  # noqa: PLR0913, PLR0917  # a kernel takes arrays and scalars
    position: Floats,
    velocity: Floats,
    wanted: Floats,
    group: Integers,
    gaze: float,
    attraction: float,
    repulsion: float,
    sight: float,
    near: float,
) -> Floats:
    """What people do for the sake of their group, (n, 2); Moussaïd et al. 2010.

    Slower, so that the others come into sight: −β₁ α v, where α is how far the centre of the group
    lies outside of the field of sight; to the centre with β₂, if it is farther than (N − 1)/2 m;
    away from each who is too near, with β₃.

    Args:
        position, velocity, wanted: (n, 2); people look where they want to go.
        group: (n,), −1: nobody's.
        gaze, attraction, repulsion: β₁, 1/(rad s), β₂ and β₃, m/s².
        sight: half the field of sight, rad.
        near: who is nearer than this is too near, m.
    """
    n = group.shape[0]
    out = np.zeros((n, 2))
    order = np.argsort(group, kind="mergesort")
    a = 0
    while a < n:
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
                if away > 0.0 and (wanted[i, 0] != 0.0 or wanted[i, 1] != 0.0):
                    cross = wanted[i, 0] * cy - wanted[i, 1] * cx
                    angle = abs(math.atan2(cross, wanted[i, 0] * cx + wanted[i, 1] * cy))
                    slow = gaze * max(angle - sight, 0.0)
                    out[i, 0] -= slow * velocity[i, 0]
                    out[i, 1] -= slow * velocity[i, 1]
        a = b
    return out
