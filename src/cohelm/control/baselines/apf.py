"""Artificial potential field with the joystick as a force; Khatib (1986), Petry et al. (2010).

It has local minima by nature: where attraction and repulsion cancel, the chair stops with a reason.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.baselines.steering import Steering, advance, steering_of, twist_toward
from cohelm.control.baselines.tracking import plan_of, touches_wall
from cohelm.control.trajectories import braking_trajectory
from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input
from cohelm.kernels import CACHED
from cohelm.maps.distance import sample
from cohelm.messages import LocalPlan, Status
from cohelm.robots.capsule import nearest_on_spine_in_map
from cohelm.robots.wall_contact import WallGrid, wall_grid

_FORCES = ("path", "rider", "walls", "people")
_BALANCED = 0.02
"""A twist below this is standing, m/s and rad/s."""
_MIN_GAP = 0.05
"""Smaller gaps repel like this one, m, so that the force stays finite."""


class Apf:
    """F = (1 − η) F_path + η F_rider + Σ F_walls + Σ F_people; the robot steers along it.

    The path attracts with unit force toward a point ahead on the reference, as does a full
    deflection of the stick. Walls and people repel by Khatib's law within their range. People count
    at their present positions: a field has no prediction.
    """

    class Parameters(Model):
        """Ranges and strengths; the authors give none that fit this chair, these are assumed."""

        steps: int = Field(15, ge=3, le=100)
        """Steps along the field, for display and walls."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """s."""
        ahead: float = Field(1.0, gt=0.0, le=5.0)
        """Lookahead of the attracting point on the reference, s."""
        gain: float = Field(1.5, gt=0.0, le=10.0)
        """Turn rate per radian between heading and force, 1/s."""
        speed: float = Field(1.0, gt=0.0, le=1.0)
        """Share of the reference's speed for a unit force."""
        people_range: float = Field(1.8, gt=0.0, le=10.0)
        """ρ₀ of people, from body to footprint, m."""
        people_strength: float = Field(0.25, ge=0.0, le=20.0)
        """η of people, m³."""
        wall_range: float = Field(0.3, gt=0.0, le=5.0)
        """ρ₀ of walls, m."""
        wall_strength: float = Field(0.0006, ge=0.0, le=5.0)
        """η of walls, m³."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        check_problem(problem, self.steps)
        problem = problem.truncated(self.steps)
        current_input = estimate_current_input(problem, previous)
        trajectory, forces, target = self._descended(problem, current_input)
        sizes = {name: float(np.hypot(*f)) for name, f in zip(_FORCES, forces, strict=True)}
        balanced = np.abs(target).max() < _BALANCED
        moves = float(problem.reference.speeds.max()) > _BALANCED
        if (balanced and moves) or touches_wall(problem, trajectory):
            rest = braking_trajectory(problem, current_input, self.steps)
            return plan_of(problem, rest, Status.STOP, costs=sizes)
        return plan_of(problem, trajectory, Status.OK, costs=sizes)

    def _descended(
        self, problem: LocalProblem, current_input: Floats
    ) -> tuple[Trajectory, Floats, Floats]:
        """(the trajectory down the field, the forces now (4, 2), the target twist now (3,))."""
        p, reference, rider = self.parameters, problem.reference, problem.authority
        lead = np.minimum(np.arange(self.steps) + max(round(p.ahead / p.step), 1), self.steps)
        soon = np.minimum(np.arange(self.steps) + 2, self.steps)
        field = PotentialField(
            goals=np.ascontiguousarray(reference.poses[lead, :2]),
            speeds=p.speed * np.maximum(reference.speeds[soon], reference.speeds[lead]),
            stick=rider.deflection if rider else np.zeros(2),
            eta=rider.eta if rider else 0.0,
            capsule=problem.robot.capsule,
            discs=problem.robot.discs,
            positions=problem.people.mean[:, :2],
            radius=problem.people.radius,
            walls=wall_grid(problem.walls),
            people_range=p.people_range,
            people_strength=p.people_strength,
            wall_range=p.wall_range,
            wall_strength=p.wall_strength,
        )
        steering = steering_of(problem, p.gain, p.step)
        poses, inputs, forces, target = descend(problem.pose, current_input, field, steering)
        trajectory = Trajectory(
            step=p.step, poses=poses, inputs=inputs, current_input=current_input
        )
        return trajectory, forces, target


class PotentialField(NamedTuple):
    """Sources of all forces for compiled code."""

    goals: Floats
    """(N, 2) attracting points."""
    speeds: Floats
    """(N,) of a unit force, m/s."""
    stick: Floats
    """(2,) deflection, forward and left."""
    eta: float
    """Authority of the rider."""
    capsule: Floats
    discs: Floats
    """Footprint, as in ``Robot``."""
    positions: Floats
    """(n, 2) people."""
    radius: Floats
    """(n,) m."""
    walls: WallGrid
    people_range: float
    people_strength: float
    wall_range: float
    wall_strength: float


@njit(**CACHED)
def descend(
    start: Floats, current_input: Floats, field: PotentialField, steering: Steering
) -> tuple[Floats, Floats, Floats, Floats]:
    """(poses (N+1, 3), inputs (N, m), forces now (4, 2), target twist now (3,)) down the field.

    Forces are those of path, rider, walls and people. Where their sum points backwards, the robot
    does not turn around: it steers to the side of the sum, and stands or, if allowed, reverses.
    """
    eta, stick = field.eta, field.stick
    steps, m = field.goals.shape[0], current_input.shape[0]
    poses, inputs = np.empty((steps + 1, 3)), np.empty((steps, m))
    first, target = np.zeros((4, 2)), np.zeros(3)
    pose, u = start.copy(), current_input.copy()
    poses[0] = start
    for k in range(steps):
        # attraction: unit forces of path and stick, weighted by η
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        dx, dy = field.goals[k, 0] - pose[0], field.goals[k, 1] - pose[1]
        distance = max(math.sqrt(dx * dx + dy * dy), 1e-9)
        ax, ay = (1.0 - eta) * dx / distance, (1.0 - eta) * dy / distance
        hx = eta * (cos * stick[0] - sin * stick[1])
        hy = eta * (sin * stick[0] + cos * stick[1])
        # repulsion
        px, py = people_force(pose, field)
        wx, wy = walls_force(pose, field)
        fx, fy = ax + hx + px + wx, ay + hy + py + wy
        # from the sum to a twist
        forward, left = cos * fx + sin * fy, -sin * fx + cos * fy
        attraction = cos * (ax + hx) + sin * (ay + hy)
        speed = field.speeds[k] * min(math.sqrt(fx * fx + fy * fy), 1.0)
        if forward < 0.0 and attraction > 0.0 and not steering.holonomic:
            vx, vy = speed * min(forward, 0.0), 0.0
            w = steering.gain * math.atan2(left, -forward)
        else:
            vx, vy, w = twist_toward(math.atan2(left, forward), speed, steering)
        if k == 0:
            first[0], first[1] = (ax, ay), (hx, hy)
            first[2], first[3] = (wx, wy), (px, py)
            target[:] = (max(vx, steering.bounds.low[0]), vy, w)
        advance(pose, u, (vx, vy, w), steering, k)
        poses[k + 1] = pose
        inputs[k] = u
    return poses, inputs, first, target


@njit(**CACHED)
def people_force(pose: Floats, field: PotentialField) -> tuple[float, float]:
    """Sum of the repulsion of all people, away from each; map frame."""
    x, y = 0.0, 0.0
    for i in range(field.positions.shape[0]):
        px, py = field.positions[i, 0], field.positions[i, 1]
        d, nx, ny, _, _, _ = nearest_on_spine_in_map(field.capsule, pose, px, py)
        gap = d - field.capsule[4] - field.radius[i]
        size = repulsion(gap, field.people_range, field.people_strength)
        x -= size * nx
        y -= size * ny
    return x, y


@njit(**CACHED)
def walls_force(pose: Floats, field: PotentialField) -> tuple[float, float]:
    """Mean over the discs of the walls' repulsion, along the gradient of the distance field."""
    discs, walls = field.discs, field.walls
    x, y = 0.0, 0.0
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for j in range(discs.shape[0]):
        px = pose[0] + cos * discs[j, 0] - sin * discs[j, 1]
        py = pose[1] + sin * discs[j, 0] + cos * discs[j, 1]
        d, gx, gy = sample(walls.distance, walls.resolution, walls.X_MG, px, py)
        size = repulsion(d - discs[j, 2], field.wall_range, field.wall_strength) / discs.shape[0]
        x += size * gx
        y += size * gy
    return x, y


@njit(**CACHED)
def repulsion(gap: float, limit: float, strength: float) -> float:
    """Khatib's force of an obstacle, η (1/ρ − 1/ρ₀) / ρ² within ρ₀, without unit.

    gap: ρ, m.  limit: ρ₀, m.  strength: η, m³.
    """
    if gap >= limit:
        return 0.0
    rho = max(gap, _MIN_GAP)
    return max(strength * (1.0 / rho - 1.0 / limit) / (rho * rho), 0.0)
