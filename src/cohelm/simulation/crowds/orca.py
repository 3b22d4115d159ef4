"""Pedestrians by optimal reciprocal collision avoidance (van den Berg, Guy, Lin, Manocha 2011).

Among people the algorithm is that of the RVO2 library, step by step: the nearest neighbours in
order of distance, one half-plane of velocities for each, the collision case with 1/dt, and the
linear programs of ``half_planes``. Walls are hard half-planes about the person (``wall_geometry``),
so that no person walks through one.

Deadlocks are broken as in RVO2's examples, by a disturbance of people who make no progress. That
needs no memory: the lack of progress shows in the velocity that ORCA allows.
"""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers, replace
from cohelm.config import Model
from cohelm.simulation.api import Crowd, CrowdScene
from cohelm.simulation.crowds.motion import (
    GOLDEN_RATIO,
    advance_targets,
    current_targets,
    last_passed,
    towards_targets,
    turned_towards,
)
from cohelm.simulation.crowds.velocity_constraints import orca_velocities
from cohelm.simulation.sensors.grid_raycast import in_sight
from cohelm.simulation.wall_geometry import NO_WALLS, GridWalls, walls_of


class Orca:
    """People who avoid each other, walls and, if they see it, the robot."""

    class Parameters(Model):
        """Parameters of RVO2 with CrowdNav's values, and additions for buildings (assumed)."""

        neighbor_dist: float = Field(10.0, gt=0.0, le=100.0)
        """Distance up to which others are considered, m."""
        max_neighbors: int = Field(10, ge=0, le=100)
        """Maximum number of others, the nearest first."""
        time_horizon: float = Field(5.0, gt=0.0, le=30.0)
        """Time for which a velocity must be free of other people, s."""
        time_horizon_obstacles: float = Field(0.5, ge=0.1, le=30.0)
        """Time for which it must be free of walls, s; longer makes people timid in doors."""
        max_speed_factor: float = Field(1.3, ge=1.0, le=3.0)
        """Maximum speed as a multiple of the preferred one; RVO2's maxSpeed."""
        extra_radius: float = Field(0.01, ge=0.0, le=1.0)
        """Added to each body, m; CrowdNav's 0.01."""
        walls: bool = True
        """Avoid occupied cells of the grid."""
        robot_responsibility: float = Field(0.5, ge=0.0, le=1.0)
        """Share of the avoidance of the robot; RVO2 gives each agent half."""
        robot_clearance: float = Field(0.15, ge=0.0, le=2.0)
        """Clearance from the robot's disc of people who see it, m (assumed: larger for a
        chair's metal than for a shoulder)."""
        robot_headway: float = Field(0.5, ge=0.0, le=5.0)
        """People prefer to leave the distance that the robot approaches in this time, s (chosen on
        8 of the 13 recordings of ``cohelm bench simulation``); 0: none."""
        robot_outline: bool = False
        """Avoid a row of discs that covers the robot's outline, instead of the disc around it."""
        perturbation: float = Field(1.0, ge=0.0, le=3.2)
        """Angle by which people without progress turn, to break deadlocks, rad; 0: never."""
        agility: float = Field(6.0, gt=0.0, le=1e6)
        """Maximum rate of change of the preferred velocity, m/s²: 6 reverses a walk of 1.2 m/s in
        0.4 s, the paper's *distracted* person. Avoidance is as fast as in RVO2."""
        turn_time: float = Field(0.3, gt=0.0, le=5.0)
        """Time constant of turning the body to the direction of motion, s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def step(self, crowd: Crowd, scene: CrowdScene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`.

        All people react to the positions at the beginning of the step.
        """
        p = self.parameters
        target = advance_targets(crowd.position, crowd.waypoints, crowd.target, crowd.loop)
        preferred = towards_targets(
            crowd.position, crowd.waypoints, target, crowd.loop, crowd.preferred_speed
        )
        preferred = _limit_change(preferred, crowd.velocity, p.agility * dt)
        fastest = p.max_speed_factor * crowd.preferred_speed
        velocity = self.velocities(crowd, scene, preferred, fastest, dt)
        # Always drawn, so that a deadlock of one person does not change the draws of others.
        noise = rng.standard_normal(len(crowd.radius))
        stuck = _stuck_share(preferred, velocity)
        if p.perturbation > 0.0 and stuck.any():
            walls = walls_of(scene.grid) if p.walls else NO_WALLS
            back = _lost_waypoint(crowd.position, crowd.waypoints, target, crowd.loop, walls)
            preferred = _return(preferred, crowd.position, back, stuck, crowd.preferred_speed)
            preferred = _rotated(
                preferred, p.perturbation * stuck * _oscillation(scene.time, noise)
            )
            velocity = self.velocities(crowd, scene, preferred, fastest, dt)
        return replace(
            crowd,
            position=crowd.position + dt * velocity,
            velocity=velocity,
            heading=turned_towards(crowd.heading, velocity, dt, p.turn_time),
            target=target,
        )

    def velocities(
        self, crowd: Crowd, scene: CrowdScene, preferred: Floats, max_speed: Floats, dt: float
    ) -> Floats:
        """Compute the velocities (n, 2) nearest to the preferred ones, m/s.

        Args:
            crowd: current state.
            scene: walls and robot.
            preferred: (n, 2), m/s.
            max_speed: (n,) m/s.
            dt: time for which the velocities are kept, s.
        """
        p = self.parameters
        walls = walls_of(scene.grid) if p.walls else NO_WALLS
        one = np.array([[*scene.robot_position, scene.robot_radius]])
        discs = scene.robot_discs() if p.robot_outline else one
        return orca_velocities(
            np.concatenate([crowd.position, discs[:, :2]]),
            np.concatenate([crowd.velocity, [scene.robot_velocity] * len(discs)]),
            np.concatenate([crowd.radius, discs[:, 2] + p.robot_clearance]) + p.extra_radius,
            crowd.radius,
            preferred,
            max_speed,
            crowd.sees_robot,
            walls.cells,
            p.neighbor_dist,
            p.max_neighbors,
            p.time_horizon,
            # A shorter horizon would allow a step past a wall.
            max(p.time_horizon_obstacles, dt),
            p.robot_responsibility,
            p.robot_headway,
            dt,
        )


def _limit_change(preferred: Floats, now: Floats, limit: float) -> Floats:
    """Limit the change from ``now`` to the preferred velocities (n, 2), m/s."""
    change = preferred - now
    size = np.hypot(change[:, 0], change[:, 1])[:, None]
    return now + change * np.minimum(1.0, limit / np.maximum(size, 1e-12))


# --- deadlocks -----------------------------------------------------------------------------------


def _stuck_share(preferred: Floats, velocity: Floats) -> Floats:
    """Share of stuckness (n,): 0 from a third of the preferred progress on, 1 without any.

    Args:
        preferred: (n, 2) preferred velocities, m/s.
        velocity: (n, 2) the possible ones, m/s.
    """
    (px, py), (vx, vy) = preferred.T, velocity.T
    speed2 = px * px + py * py
    progress = (px * vx + py * vy) / np.maximum(speed2, 1e-9)
    return np.where(speed2 > 0.0, np.clip(1.0 - 3.0 * progress, 0.0, 1.0), 0.0)


def _oscillation(time: float, noise: Floats) -> Floats:
    """Slow oscillation (n,) within ±1.5 with noise, out of phase from person to person.

    Of two people who block each other one then gives way for a while, and no symmetry lasts.
    """
    phase = np.arange(len(noise)) * GOLDEN_RATIO
    wave = np.sin(2.0 * np.pi * (time * (0.12 + 0.06 * (phase % 1.0)) + phase))
    return np.clip(wave + 0.3 * noise, -1.5, 1.5)


def _rotated(velocity: Floats, angle: Floats) -> Floats:
    """Rotate each velocity (n, 2) by its angle (n,)."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = velocity[:, 0], velocity[:, 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def _lost_waypoint(
    position: Floats, waypoints: Floats, target: Integers, loop: Booleans, walls: GridWalls
) -> Floats:
    """Previous way-point (n, 2) of people pushed out of sight of their target, else NaN.

    A person who has passed the way-point of a door may be pushed back through the door, and would
    then walk against the wall without end.
    """
    grid = (walls.solid, 2.0 * walls.cells.half, walls.cells.X_MG)
    ahead = current_targets(waypoints, target)
    behind = last_passed(waypoints, target, loop)
    lost = np.isfinite(behind[:, 0])
    lost[lost] &= ~in_sight(*grid, position[lost], ahead[lost])
    lost[lost] &= in_sight(*grid, position[lost], behind[lost])
    return np.where(lost[:, None], behind, np.nan)


def _return(
    preferred: Floats, position: Floats, back: Floats, stuck: Floats, speed: Floats
) -> Floats:
    """Preferred velocities (n, 2), but to ``back`` (n, 2) at ``speed`` (n,) for stuck people."""
    offset = back - position
    distance = np.hypot(offset[:, 0], offset[:, 1])
    returns = (stuck > 0.0) & (distance > 1e-6)
    rate = np.where(returns, speed / np.where(returns, distance, 1.0), 0.0)
    return np.where(returns[:, None], rate[:, None] * offset, preferred)
