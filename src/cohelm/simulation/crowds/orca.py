"""Pedestrians by optimal reciprocal collision avoidance (van den Berg, Guy, Lin, Manocha 2011).

Among people the algorithm is that of the RVO2 library, step by step: the nearest neighbours in
order of distance, one half-plane of velocities for each, the collision case with 1/dt, and the
linear programs of ``half_planes``. Walls are hard half-planes about the person (see ``walls``), by
which nobody ever walks through one.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.geometry import wrap_angle
from cohelm.simulation.api import Crowd, Scene
from cohelm.simulation.crowds.half_planes import best_velocity
from cohelm.simulation.crowds.waypoints import advance_targets, towards_targets
from cohelm.simulation.walls import free_region, near_cells, walls_of

_WALKING = 0.1
"""Speed above which a person turns to where they walk, m/s."""
_GOLDEN = 0.6180339887498949


class Orca:
    """People who avoid each other, the walls and, if they see it, the robot."""

    class Parameters(Model):
        """Those of RVO2, and what a building adds."""

        neighbor_dist: float = Field(10.0, gt=0.0, le=100.0)
        """How far others are taken notice of, m."""
        max_neighbors: int = Field(10, ge=0, le=100)
        """How many others at most, the nearest."""
        time_horizon: float = Field(5.0, gt=0.0, le=30.0)
        """For how long a velocity must stay free of other people, s."""
        time_horizon_obstacles: float = Field(0.5, ge=0.1, le=30.0)
        """For how long it must stay free of walls, s; longer makes people timid in doors."""
        max_speed_factor: float = Field(1.3, ge=1.0, le=3.0)
        """Greatest speed as a multiple of the preferred one; RVO2's maxSpeed."""
        extra_radius: float = Field(0.01, ge=0.0, le=1.0)
        """Added to each body, m; CrowdNav's 0.01."""
        walls: bool = True
        """Whether the grid stands in the way."""
        robot_responsibility: float = Field(0.5, ge=0.0, le=1.0)
        """Share of the avoiding taken on towards the robot; RVO2 gives each agent half."""
        perturbation: float = Field(1.0, ge=0.0, le=3.2)
        """How far those who get no further turn aside, to break a deadlock, rad; 0: never."""
        turn_time: float = Field(0.3, gt=0.0, le=5.0)
        """Time constant of turning the body to where one walks, s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def step(self, crowd: Crowd, scene: Scene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`.

        The people look at where all were at the beginning of the step; ``dt`` must not exceed
        ``time_horizon_obstacles``, or a wall could be passed.
        """
        p = self.parameters
        n = len(crowd.radius)
        target = advance_targets(crowd.position, crowd.waypoints, crowd.target, crowd.loop)
        wanted = towards_targets(
            crowd.position, crowd.waypoints, target, crowd.loop, crowd.preferred_speed
        )
        noise = rng.standard_normal(n)  # always drawn, so that no one's fate shifts another's
        wanted = _perturbed(wanted, crowd.velocity, noise, scene.time, p.perturbation)
        fastest = p.max_speed_factor * crowd.preferred_speed
        velocity = self.velocities(crowd, scene, wanted, fastest, dt)
        speed = np.hypot(velocity[:, 0], velocity[:, 1])
        turn = wrap_angle(np.arctan2(velocity[:, 1], velocity[:, 0]) - crowd.heading)
        turn = np.where(speed > _WALKING, turn * (1.0 - math.exp(-dt / p.turn_time)), 0.0)
        return Crowd(
            position=crowd.position + dt * velocity,
            velocity=velocity,
            heading=wrap_angle(crowd.heading + turn),
            radius=crowd.radius,
            preferred_speed=crowd.preferred_speed,
            waypoints=crowd.waypoints,
            target=target,
            loop=crowd.loop,
            sees_robot=crowd.sees_robot,
        )

    def velocities(
        self, crowd: Crowd, scene: Scene, wanted: Floats, max_speed: Floats, dt: float
    ) -> Floats:
        """The velocities (n, 2) that people choose who want ``wanted`` (n, 2), m/s.

        Args:
            crowd: where they are now.
            scene: walls and robot.
            wanted: (n, 2) preferred velocities, m/s.
            max_speed: (n,) m/s.
            dt: how long the velocities will be kept, s.
        """
        p = self.parameters
        walls = walls_of(scene.grid)
        return _velocities(
            np.vstack([crowd.position, scene.robot_position]),
            np.vstack([crowd.velocity, scene.robot_velocity]),
            np.append(crowd.radius, scene.robot_radius) + p.extra_radius,
            crowd.radius,
            wanted,
            max_speed,
            crowd.sees_robot,
            walls.centre if p.walls else walls.centre[:0],
            walls.start if p.walls else np.zeros_like(walls.start),
            walls.tiles,
            walls.half,
            walls.X_MG,
            p.neighbor_dist,
            p.max_neighbors,
            p.time_horizon,
            p.time_horizon_obstacles,
            p.robot_responsibility,
            dt,
        )


def _perturbed(
    wanted: Floats, velocity: Floats, noise: Floats, time: float, amount: float
) -> Floats:
    """``wanted`` (n, 2), turned aside for those who make less than a third of the way they want.

    The turn sways slowly, out of step from person to person, so that of two who block each other
    one gives way for a while; the noise keeps any symmetry from lasting.
    """
    speed = np.hypot(wanted[:, 0], wanted[:, 1])
    progress = np.sum(wanted * velocity, axis=1) / np.maximum(speed, 1e-9) ** 2
    stuck = np.clip(1.0 - 3.0 * progress, 0.0, 1.0)
    phase = np.arange(len(speed)) * _GOLDEN
    sway = np.sin(2.0 * np.pi * (time * (0.12 + 0.06 * (phase % 1.0)) + phase))
    angle = amount * stuck * np.clip(sway + 0.3 * noise, -1.5, 1.5)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack(
        [cos * wanted[:, 0] - sin * wanted[:, 1], sin * wanted[:, 0] + cos * wanted[:, 1]], axis=1
    )


@njit(cache=True)
def _velocities(  # noqa: PLR0913, PLR0917  # a kernel takes arrays and scalars
    position: Floats,
    velocity: Floats,
    radius: Floats,
    body: Floats,
    wanted: Floats,
    max_speed: Floats,
    sees_robot: Booleans,
    cells: Floats,
    start: Integers,
    tiles: Integers,
    half: float,
    X_MG: Floats,
    neighbor_dist: float,
    max_neighbors: int,
    horizon: float,
    horizon_walls: float,
    robot_share: float,
    dt: float,
) -> Floats:
    """Velocities (n, 2) of the n people; row n of the first three arrays is the robot."""
    n = wanted.shape[0]
    out = np.empty((n, 2))
    for i in range(n):
        reach = body[i] + max_speed[i] * horizon_walls + 2.0 * half
        walls = _wall_planes(
            cells, start, tiles, half, X_MG, position[i], body[i], reach, horizon_walls
        )
        others = _neighbours(position, i, sees_robot[i], neighbor_dist, max_neighbors)
        hard = walls.shape[0]
        planes = np.empty((hard + others.shape[0], 4))
        planes[:hard] = walls
        for k in range(others.shape[0]):
            j = others[k]
            share = robot_share if j == n else 0.5
            planes[hard + k] = _plane(position, velocity, radius, i, j, horizon, dt, share)
        vx, vy = best_velocity(planes, hard, max_speed[i], wanted[i, 0], wanted[i, 1])
        keep = _within(walls, vx, vy)
        out[i, 0], out[i, 1] = keep * vx, keep * vy
    return out


@njit(cache=True)
def _neighbours(position: Floats, i: int, sees_robot: bool, reach: float, most: int) -> Integers:
    """The ``most`` nearest others within ``reach``, nearest first; the last row is the robot."""
    m = position.shape[0]
    found = np.empty(most, dtype=np.int64)
    near = np.empty(most)
    count = 0
    limit = reach * reach
    for j in range(m):
        if j == i or (j == m - 1 and not sees_robot) or most == 0:
            continue
        dx, dy = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
        d2 = dx * dx + dy * dy
        if d2 >= limit:
            continue
        if count < most:
            count += 1
        k = count - 1
        while k > 0 and d2 < near[k - 1]:
            near[k], found[k] = near[k - 1], found[k - 1]
            k -= 1
        near[k], found[k] = d2, j
        if count == most:
            limit = near[count - 1]
    return found[:count]


@njit(cache=True)
def _plane(  # noqa: PLR0917  # a kernel takes arrays and scalars
    position: Floats,
    velocity: Floats,
    radius: Floats,
    i: int,
    j: int,
    horizon: float,
    dt: float,
    share: float,
) -> tuple[float, float, float, float]:
    """The half-plane of velocities of ``i`` induced by ``j``; van den Berg et al., eq. (4)–(6).

    u is the least change of the relative velocity that leaves the velocity obstacle, truncated at
    the horizon; ``i`` takes ``share`` of it on. Bodies that overlap must part within ``dt``.
    """
    px, py = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
    vx, vy = velocity[i, 0] - velocity[j, 0], velocity[i, 1] - velocity[j, 1]
    d2 = px * px + py * py
    r = radius[i] + radius[j]
    apart = d2 > r * r
    rate = 1.0 / horizon if apart else 1.0 / dt
    wx, wy = vx - rate * px, vy - rate * py
    w2 = wx * wx + wy * wy
    dot = wx * px + wy * py
    if not apart or (dot < 0.0 and dot * dot > r * r * w2):  # the cut-off circle is nearest
        w = math.sqrt(w2)
        nx, ny = (wx / w, wy / w) if w > 0.0 else (-1.0, 0.0)
        dx, dy = ny, -nx
        ux, uy = (r * rate - w) * nx, (r * rate - w) * ny
    else:  # a leg of the cone
        leg = math.sqrt(d2 - r * r)
        if px * wy - py * wx > 0.0:
            dx, dy = (px * leg - py * r) / d2, (px * r + py * leg) / d2
        else:
            dx, dy = -(px * leg + py * r) / d2, -(-px * r + py * leg) / d2
        along = vx * dx + vy * dy
        ux, uy = along * dx - vx, along * dy - vy
    return velocity[i, 0] + share * ux, velocity[i, 1] + share * uy, dx, dy


@njit(cache=True)
def _wall_planes(  # noqa: PLR0913, PLR0917  # a kernel takes arrays and scalars
    cells: Floats,
    start: Integers,
    tiles: Integers,
    half: float,
    X_MG: Floats,
    position: Floats,
    body: float,
    reach: float,
    horizon: float,
) -> Floats:
    """Hard half-planes (k, 4): v·u ≤ max(distance − body, 0) / horizon towards each wall.

    Standing still is always among what they allow.
    """
    cos, sin = math.cos(X_MG[2]), math.sin(X_MG[2])
    ox, oy = position[0] - X_MG[0], position[1] - X_MG[1]
    x, y = cos * ox + sin * oy, -sin * ox + cos * oy
    region = free_region(near_cells(cells, start, tiles, half, x, y, reach), half, x, y)
    out = np.empty((region.shape[0], 4))
    for k in range(region.shape[0]):
        ux = cos * region[k, 0] - sin * region[k, 1]
        uy = sin * region[k, 0] + cos * region[k, 1]
        speed = max(region[k, 2] - body, 0.0) / horizon
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = speed * ux, speed * uy, -uy, ux
    return out


@njit(cache=True)
def _within(planes: Floats, vx: float, vy: float) -> float:
    """The share of a velocity that half-planes about 0 allow; 1 but for rounding."""
    keep = 1.0
    for k in range(planes.shape[0]):
        px, py, dx, dy = planes[k]
        towards = vx * dy - vy * dx
        allowed = max(px * dy - py * dx, 0.0)
        if towards > allowed:
            keep = min(keep, allowed / towards)
    return keep
