"""Pedestrians by optimal reciprocal collision avoidance (van den Berg, Guy, Lin, Manocha 2011).

Among people the algorithm is that of the RVO2 library, step by step: the nearest neighbours in
order of distance, one half-plane of velocities for each, the collision case with 1/dt, and the
linear programs of ``half_planes``. Walls are hard half-planes about the person (see ``walls``), by
which nobody ever walks through one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.simulation.api import Crowd, Scene
from cohelm.simulation.crowds.deadlock import go_back, lost_sight, share_stuck, sway, turned
from cohelm.simulation.crowds.steps import turned_towards
from cohelm.simulation.crowds.velocities import velocities
from cohelm.simulation.crowds.waypoints import advance_targets, towards_targets
from cohelm.simulation.walls import NO_WALLS, walls_of


class Orca:
    """People who avoid each other, the walls and, if they see it, the robot."""

    class Parameters(Model):
        """Those of RVO2 with CrowdNav's values, and what a building adds (assumed)."""

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
        robot_clearance: float = Field(0.15, ge=0.0, le=2.0)
        """What those who see the robot keep from it beyond its disc, m (assumed: nobody presses
        against a chair's metal as one does against a shoulder)."""
        perturbation: float = Field(1.0, ge=0.0, le=3.2)
        """How far those who get no further turn aside, to break deadlocks, rad; 0: never."""
        agility: float = Field(6.0, gt=0.0, le=1e6)
        """How fast what a person wants may change, m/s²: 6 turns a walk of 1.2 m/s about in 0.4 s,
        the paper's *distracted* person. Avoiding is as quick as in RVO2."""
        turn_time: float = Field(0.3, gt=0.0, le=5.0)
        """Time constant of turning the body to where one walks, s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def step(self, crowd: Crowd, scene: Scene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`.

        The people look at where all were at the beginning of the step.
        """
        p = self.parameters
        n = len(crowd.radius)
        target = advance_targets(crowd.position, crowd.waypoints, crowd.target, crowd.loop)
        wanted = towards_targets(
            crowd.position, crowd.waypoints, target, crowd.loop, crowd.preferred_speed
        )
        wanted = _within_reach(wanted, crowd.velocity, p.agility * dt)
        fastest = p.max_speed_factor * crowd.preferred_speed
        velocity = self.velocities(crowd, scene, wanted, fastest, dt)
        noise = rng.standard_normal(n)  # always drawn, so that no one's fate shifts another's
        stuck = share_stuck(wanted, velocity)
        if p.perturbation > 0.0 and stuck.any():
            walls = walls_of(scene.grid) if p.walls else NO_WALLS
            back = lost_sight(crowd.position, crowd.waypoints, target, crowd.loop, walls)
            wanted = go_back(wanted, crowd.position, back, stuck, crowd.preferred_speed)
            wanted = turned(wanted, p.perturbation * stuck * sway(scene.time, noise))
            velocity = self.velocities(crowd, scene, wanted, fastest, dt)
        return replace(
            crowd,
            position=crowd.position + dt * velocity,
            velocity=velocity,
            heading=turned_towards(crowd.heading, velocity, dt, p.turn_time),
            target=target,
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
        walls = walls_of(scene.grid) if p.walls else NO_WALLS
        return velocities(
            np.vstack([crowd.position, scene.robot_position]),
            np.vstack([crowd.velocity, scene.robot_velocity]),
            np.append(crowd.radius, scene.robot_radius + p.robot_clearance) + p.extra_radius,
            crowd.radius,
            wanted,
            max_speed,
            crowd.sees_robot,
            walls.centre,
            walls.start,
            walls.tiles,
            walls.half,
            walls.X_MG,
            p.neighbor_dist,
            p.max_neighbors,
            p.time_horizon,
            max(p.time_horizon_obstacles, dt),  # or a step could lead past a wall
            p.robot_responsibility,
            dt,
        )


def _within_reach(wanted: Floats, now: Floats, most: float) -> Floats:
    """``wanted`` (n, 2), or as much of the change from ``now`` to it as ``most`` allows, m/s."""
    change = wanted - now
    size = np.hypot(change[:, 0], change[:, 1])[:, None]
    return now + change * np.minimum(1.0, most / np.maximum(size, 1e-12))
