"""Pedestrians by social forces, alone and in groups (Helbing and Molnár 1995; Moussaïd 2009, 2010).

dv/dt = (v⁰e − v)/τ + Σ f_ij + f_wall + f_group, see ``forces``; at most 1.3 v⁰. Forces alone let
bodies overlap in a press, so what is left of the velocity is what bodies allow, see ``bodies``.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.simulation.api import Crowd, Scene
from cohelm.simulation.crowds.bodies import without_contact
from cohelm.simulation.crowds.forces import group_forces, pair_forces, wall_forces
from cohelm.simulation.crowds.steps import turned_towards
from cohelm.simulation.crowds.waypoints import advance_targets, last_of, towards_targets
from cohelm.simulation.walls import NO_WALLS, walls_of

_ALONE = -1
"""Whose group is nobody's."""


class SocialForce:
    """People who keep off each other, walls and, if they see it, the robot, and to their group."""

    class Parameters(Model):
        """Moussaïd et al.'s values, measured on people in a corridor, unless a line says more."""

        relaxation: float = Field(0.54, gt=0.05, le=5.0)
        """τ, in which people come to the velocity they want, s (2009)."""
        strength: float = Field(4.5, ge=0.0, le=100.0)
        """A, m/s² (2009)."""
        gamma: float = Field(0.35, gt=0.0, le=5.0)
        """γ, reach of the force for each m/s of approach, m (2009)."""
        narrow: float = Field(3.0, ge=0.0, le=20.0)
        """n', how narrow the field is in which one slows down (2009)."""
        wide: float = Field(2.0, ge=0.0, le=20.0)
        """n, and in which one turns aside (2009)."""
        weight: float = Field(2.0, ge=0.0, le=20.0)
        """λ, of the velocities beside the positions, s/m (2009)."""
        bias: float = Field(0.005, ge=-0.1, le=0.1)
        """ε, by which people who meet head-on go to the right (2009); 0: as a mirror would."""
        reach: float = Field(8.0, gt=0.5, le=50.0)
        """Of the forces between people, m (assumed: 2 % of A are left for two who meet)."""
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
        """φ, half the field of sight, rad (2010)."""
        near: float = Field(0.8, ge=0.0, le=3.0)
        """d₀, at which members of a group are too near, m (2010)."""
        max_speed_factor: float = Field(1.3, ge=1.0, le=2.0)
        """Greatest speed as a multiple of the preferred one (1995)."""
        walls: bool = True
        """Whether the grid stands in the way."""
        robot_clearance: float = Field(0.15, ge=0.0, le=2.0)
        """What those who see the robot keep from it beyond its disc, m (assumed, as for ORCA)."""
        turn_time: float = Field(0.3, gt=0.0, le=5.0)
        """Time constant of turning the body to where one walks, s (assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def step(self, crowd: Crowd, scene: Scene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`; nothing is left to chance."""
        p = self.parameters
        target = advance_targets(crowd.position, crowd.waypoints, crowd.target, crowd.loop)
        wanted = towards_targets(
            crowd.position, crowd.waypoints, target, crowd.loop, crowd.preferred_speed
        )
        wanted = _or_back(wanted, replace(crowd, target=target))
        fastest = p.max_speed_factor * crowd.preferred_speed
        forces = self.forces(crowd, scene, wanted)
        walls = walls_of(scene.grid) if p.walls else NO_WALLS
        position, velocity, radius = _with_robot(crowd, scene, p.robot_clearance)
        possible = without_contact(
            position,
            velocity,
            radius,
            crowd.velocity + dt * forces,
            fastest,
            crowd.sees_robot,
            walls.centre,
            walls.start,
            walls.tiles,
            walls.half,
            walls.X_MG,
            dt,
        )
        return replace(
            crowd,
            position=crowd.position + dt * possible,
            velocity=possible,
            heading=turned_towards(crowd.heading, possible, dt, p.turn_time),
            target=target,
        )

    def forces(self, crowd: Crowd, scene: Scene, wanted: Floats) -> Floats:
        """What drives people (n, 2) who want to walk with ``wanted`` (n, 2) m/s, m/s²."""
        p = self.parameters
        group = _ALONE * np.ones_like(crowd.target) if crowd.group is None else crowd.group
        walls = walls_of(scene.grid) if p.walls else NO_WALLS
        total: Floats = (wanted - crowd.velocity) / p.relaxation
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
            walls.centre,
            walls.start,
            walls.tiles,
            walls.half,
            walls.X_MG,
            p.wall_strength,
            p.wall_decay,
        )
        total += group_forces(
            crowd.position, crowd.velocity, wanted, group,
            p.gaze, p.attraction, p.repulsion, p.sight, p.near,
        )  # fmt: skip
        return total


def _or_back(wanted: Floats, crowd: Crowd) -> Floats:
    """``wanted`` (n, 2); who is done and was pushed away goes back to where they stood, in 1 s."""
    offset = last_of(crowd.waypoints, crowd.target) - crowd.position
    away = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), crowd.preferred_speed)
    back = offset * (crowd.preferred_speed / away)[:, None]
    return np.where(np.isfinite(offset), back, wanted)


def _with_robot(crowd: Crowd, scene: Scene, clearance: float) -> tuple[Floats, Floats, Floats]:
    """Positions, velocities and radii of all bodies, the robot's last."""
    return (
        np.vstack([crowd.position, scene.robot_position]),
        np.vstack([crowd.velocity, scene.robot_velocity]),
        np.append(crowd.radius, scene.robot_radius + clearance),
    )
