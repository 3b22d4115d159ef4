"""Pedestrians by social forces, alone and in groups (Helbing and Molnár 1995; Moussaïd 2009, 2010).

dv/dt = (v⁰e − v)/τ + Σ f_ij + f_wall + f_group, at most 1.3 v⁰. Forces alone let
bodies overlap in a press, so the velocity is limited, see ``velocity_constraints``.

Forces are accelerations, m/s². Between people: Moussaïd, Helbing, Garnier, Johansson, Combe,
Theraulaz, "Experimental study of the behavioural mechanisms underlying self-organization in human
crowds", Proc. R. Soc. B 276 (2009). Within groups: Moussaïd, Perozo, Garnier, Helbing, Theraulaz,
"The walking behaviour of pedestrian social groups and its impact on crowd dynamics", PLoS ONE 5
(2010). Both after Helbing and Molnár, "Social force model for pedestrian dynamics", Phys. Rev. E 51
(1995).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.array_kernels import stable_order
from cohelm.arrays import Booleans, Floats, Integers, replace
from cohelm.config import Model
from cohelm.kernels import CACHED
from cohelm.simulation.api import Crowd, CrowdScene
from cohelm.simulation.crowds.motion import (
    advance_targets,
    last_of,
    towards_targets,
    turned_towards,
)
from cohelm.simulation.crowds.velocity_constraints import without_contact
from cohelm.simulation.wall_geometry import (
    NO_WALLS,
    SurfaceCells,
    free_region,
    near_cells,
    to_grid_frame,
    walls_of,
)


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


_ALONE = -1
"""Group of people without a group."""


class SocialForce:
    """People who avoid each other, walls and a visible robot, and stay with their group."""

    class Parameters(Model):
        """Values of Moussaïd et al., measured on people in a corridor, except where noted."""

        relaxation: float = Field(0.54, gt=0.05, le=5.0)
        """τ, relaxation time to the preferred velocity, s (2009)."""
        strength: float = Field(4.5, ge=0.0, le=100.0)
        """A, m/s² (2009)."""
        gamma: float = Field(0.35, gt=0.0, le=5.0)
        """γ, range of the force per m/s of approach, m (2009)."""
        narrow: float = Field(3.0, ge=0.0, le=20.0)
        """n', angular width of deceleration (2009)."""
        wide: float = Field(2.0, ge=0.0, le=20.0)
        """n, angular width of turning (2009)."""
        weight: float = Field(2.0, ge=0.0, le=20.0)
        """λ, weight of relative velocity, s/m (2009)."""
        bias: float = Field(0.005, ge=-0.1, le=0.1)
        """ε, bias to the right when people meet head-on (2009); 0: symmetric."""
        reach: float = Field(8.0, gt=0.5, le=50.0)
        """Range of forces between people, m (assumed: 2 % of A remain for two who meet)."""
        wall_strength: float = Field(3.0, ge=0.0, le=100.0)
        """a, at a wall, m/s² (2009)."""
        wall_decay: float = Field(0.1, gt=0.01, le=2.0)
        """b, m (2009)."""
        gaze: float = Field(4.0, ge=0.0, le=50.0)
        """β₁, 1/(rad s) (2010)."""
        attraction: float = Field(3.0, ge=0.0, le=50.0)
        """β₂, m/s² (2010)."""
        repulsion: float = Field(1.0, ge=0.0, le=50.0)
        """β₃, m/s² (2010)."""
        sight: float = Field(1.57, gt=0.0, le=3.15)
        """φ, half the field of view, rad (2010)."""
        near: float = Field(0.8, ge=0.0, le=3.0)
        """d₀, distance below which members of a group are too near, m (2010)."""
        max_speed_factor: float = Field(1.3, ge=1.0, le=2.0)
        """Maximum speed as a multiple of the preferred one (1995)."""
        walls: bool = True
        """Avoid occupied cells of the grid."""
        robot_clearance: float = Field(0.15, ge=0.0, le=2.0)
        """Clearance from the robot's disc of people who see it, m (assumed, as for ORCA)."""
        turn_time: float = Field(0.3, gt=0.0, le=5.0)
        """Time constant of turning the body to the direction of motion, s (assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def step(self, crowd: Crowd, scene: CrowdScene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`; the model is deterministic."""
        p = self.parameters
        target = advance_targets(crowd.position, crowd.waypoints, crowd.target, crowd.loop)
        preferred = towards_targets(
            crowd.position, crowd.waypoints, target, crowd.loop, crowd.preferred_speed
        )
        preferred = _or_return(preferred, replace(crowd, target=target))
        fastest = p.max_speed_factor * crowd.preferred_speed
        forces = self.forces(crowd, scene, preferred)
        walls = walls_of(scene.grid) if p.walls else NO_WALLS
        position, velocity, radius = _with_robot(crowd, scene, p.robot_clearance)
        possible = without_contact(
            position,
            velocity,
            radius,
            crowd.velocity + dt * forces,
            fastest,
            crowd.sees_robot,
            walls.cells,
            dt,
        )
        return replace(
            crowd,
            position=crowd.position + dt * possible,
            velocity=possible,
            heading=turned_towards(crowd.heading, possible, dt, p.turn_time),
            target=target,
        )

    def forces(self, crowd: Crowd, scene: CrowdScene, preferred: Floats) -> Floats:
        """Accelerations (n, 2) for preferred velocities (n, 2) in m/s, m/s²."""
        p = self.parameters
        group = _ALONE * np.ones_like(crowd.target) if crowd.group is None else crowd.group
        walls = walls_of(scene.grid) if p.walls else NO_WALLS
        total: Floats = (preferred - crowd.velocity) / p.relaxation
        position, velocity, radius = _with_robot(crowd, scene, p.robot_clearance)
        total += pair_forces(
            position,
            velocity,
            radius,
            group,
            crowd.sees_robot,
            p.reach,
            p.strength,
            p.gamma,
            p.narrow,
            p.wide,
            p.weight,
            p.bias,
        )
        total += wall_forces(
            crowd.position,
            crowd.radius,
            walls.cells,
            p.wall_strength,
            p.wall_decay,
        )
        total += group_forces(
            crowd.position, crowd.velocity, preferred, group,
            p.gaze, p.attraction, p.repulsion, p.sight, p.near,
        )  # fmt: skip
        return total


def _or_return(preferred: Floats, crowd: Crowd) -> Floats:
    """Preferred velocities (n, 2); people who are done and were pushed away return within 1 s."""
    offset = last_of(crowd.waypoints, crowd.target) - crowd.position
    away = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), crowd.preferred_speed)
    back = offset * (crowd.preferred_speed / away)[:, None]
    return np.where(np.isfinite(offset), back, preferred)


def _with_robot(crowd: Crowd, scene: CrowdScene, clearance: float) -> tuple[Floats, Floats, Floats]:
    """Positions, velocities and radii of all bodies, the robot last."""
    return (
        np.vstack([crowd.position, scene.robot_position]),
        np.vstack([crowd.velocity, scene.robot_velocity]),
        np.append(crowd.radius, scene.robot_radius + clearance),
    )
