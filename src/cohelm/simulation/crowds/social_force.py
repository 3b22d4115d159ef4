"""Pedestrians by social forces, alone and in groups (Helbing and Molnár 1995; Moussaïd 2009, 2010).

dv/dt = (v⁰e − v)/τ + Σ f_ij + f_wall + f_group, see ``forces``; at most 1.3 v⁰. Forces alone let
bodies overlap in a press, so the velocity is limited, see ``velocity_constraints``.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.simulation.api import Crowd, CrowdScene
from cohelm.simulation.crowds.forces import group_forces, pair_forces, wall_forces
from cohelm.simulation.crowds.motion import (
    advance_targets,
    last_of,
    towards_targets,
    turned_towards,
)
from cohelm.simulation.crowds.velocity_constraints import without_contact
from cohelm.simulation.wall_geometry import NO_WALLS, walls_of

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
