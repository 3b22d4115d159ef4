"""Rollouts over headings with a social cost; after Poddar et al. (2023).

The costs are asymmetric Gaussians about people, and early passing.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.baselines.steering import roll_out_directions, steering_of, wrapped
from cohelm.control.baselines.tracking import plan_of
from cohelm.control.trajectories import braking_trajectory
from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input
from cohelm.geometry import wrap_angle
from cohelm.kernels import CACHED
from cohelm.maps.distance import sample
from cohelm.messages import LocalPlan, Status
from cohelm.robots.capsule import nearest_on_spine_in_map
from cohelm.robots.wall_contact import WallGrid, wall_gap, wall_grid

_SLOW = 0.05
"""A person slower than this stands, m/s: front and rear are equal."""
_UNEVEN = 4.0
"""Cells by which a distance field may decrease more than its argument moves."""


@njit(**CACHED)
def social_cost(
    poses: Floats,
    capsule: Floats,
    positions: Floats,
    velocities: Floats,
    weights: Floats,
    radius: Floats,
    sigma: Floats,
) -> Floats:
    """Mean over the steps of Σ_i Σ_h w exp(−q) of rollouts (r, N+1, 3), (r,).

    q = g² (cos²δ / 2σ² + sin²δ / 2σ_s²) with g the gap between footprint and body, δ its direction
    from the person's motion, σ = σ_h where cos δ > 0, else σ_r; ``sigma`` is (σ_h, σ_s, σ_r, σ of
    standing people). Poddar et al. take a mean over people; a sum counts each
    person in full, also in a crowd.

    positions, velocities: (n, h, N+1, 2) at least.  weights: (n, h).  radius: (n,).
    """
    count, steps = poses.shape[0], poses.shape[1] - 1
    out = np.zeros(count)
    for r in range(count):
        for k in range(1, steps + 1):
            for i in range(positions.shape[0]):
                for h in range(positions.shape[1]):
                    d, nx, ny, _, _, _ = nearest_on_spine_in_map(
                        capsule, poses[r, k], positions[i, h, k, 0], positions[i, h, k, 1]
                    )
                    gap = max(d - capsule[4] - radius[i], 0.0)
                    vx, vy = velocities[i, h, k, 0], velocities[i, h, k, 1]
                    speed = math.sqrt(vx * vx + vy * vy)
                    if speed < _SLOW:
                        q = 0.5 * gap * gap / (sigma[3] * sigma[3])
                    else:
                        cos, sin = -(nx * vx + ny * vy) / speed, (nx * vy - ny * vx) / speed
                        along = sigma[0] if cos > 0.0 else sigma[2]
                        q = 0.5 * gap * gap * ((cos / along) ** 2 + (sin / sigma[1]) ** 2)
                    out[r] += weights[i, h] * math.exp(-q) / steps
    return out


@njit(**CACHED)
def passing(poses: Floats, positions: Floats, velocities: Floats, weights: Floats) -> Floats:
    """Speed at which rollouts (r, N+1, 3) pass the people in front of them, rad per step, (r,).

    The mean over people of |mean change of the direction person → robot|: high if a side is
    chosen early (topological invariance; Mavrogiannis et al., 2022).
    """
    count, steps = poses.shape[0], poses.shape[1] - 1
    people, hypotheses = positions.shape[0], positions.shape[1]
    out = np.zeros(count)
    for r in range(count):
        for i in range(people):
            for h in range(hypotheses):
                dx = poses[r, 0, 0] - positions[i, h, 0, 0]
                dy = poses[r, 0, 1] - positions[i, h, 0, 1]
                if dx * velocities[i, h, 0, 0] + dy * velocities[i, h, 0, 1] <= 0.0:
                    continue
                before, total = math.atan2(dy, dx), 0.0
                for k in range(1, steps + 1):
                    dx = poses[r, k, 0] - positions[i, h, k, 0]
                    dy = poses[r, k, 1] - positions[i, h, k, 1]
                    angle = math.atan2(dy, dx)
                    total += wrapped(angle - before)
                    before = angle
                out[r] += weights[i, h] * abs(total) / (steps * people)
    return out


@njit(**CACHED)
def wall_gaps(poses: Floats, discs: Floats, walls: WallGrid) -> tuple[Floats, float]:
    """(smallest gap to a wall along each rollout (r, N+1, 3), (r,); the gap at the start), m."""
    out = np.full(poses.shape[0], np.inf)
    last, at = np.empty(discs.shape[0]), np.empty((discs.shape[0], 2))
    for r in range(poses.shape[0]):
        for k in range(poses.shape[1]):
            cos, sin = math.cos(poses[r, k, 2]), math.sin(poses[r, k, 2])
            for j in range(discs.shape[0]):
                x = poses[r, k, 0] + cos * discs[j, 0] - sin * discs[j, 1]
                y = poses[r, k, 1] + sin * discs[j, 0] + cos * discs[j, 1]
                # a gap shrinks by no more than the motion of its disc since it was sampled
                if k > 0:
                    moved = math.sqrt((x - at[j, 0]) ** 2 + (y - at[j, 1]) ** 2)
                    if last[j] - moved - _UNEVEN * walls.resolution > out[r]:
                        continue
                gap = sample(walls.distance, walls.resolution, walls.X_MG, x, y)[0] - discs[j, 2]
                last[j], at[j, 0], at[j, 1] = gap, x, y
                if k > 0:
                    out[r] = min(out[r], gap)
    initial_gap = np.inf
    for j in range(discs.shape[0]):
        initial_gap = min(initial_gap, wall_gap(discs[j], poses[0, 0], walls))
    return out, initial_gap


@njit(**CACHED)
def nearest_squared(poses: Floats, path: Floats) -> Floats:
    """Squared distance from the positions of rollouts (r, N+1, 3) to the nearest pose of a path.

    path: (k, 3).  Returns (r, N), m², without the first position.
    """
    count, steps = poses.shape[0], poses.shape[1] - 1
    out = np.full((count, steps), np.inf)
    for r in range(count):
        for k in range(steps):
            for i in range(path.shape[0]):
                dx, dy = poses[r, k + 1, 0] - path[i, 0], poses[r, k + 1, 1] - path[i, 1]
                out[r, k] = min(out[r, k], dx * dx + dy * dy)
    return out


_TIE = 1e-9
"""Costs within this are equal."""
_CREEP = 0.1
"""Minimum speed of rollouts where the reference stands, m/s: it may wait for a turn."""


@value
class Rollouts:
    """Rollouts to compare."""

    direction: Annotated[Floats, Shape("r")]
    """Direction of motion, rad in the map frame."""
    speed: Annotated[Floats, Shape("r")]
    """m/s."""
    poses: Annotated[Floats, Shape("r N+1 3")]
    inputs: Annotated[Floats, Shape("r N m")]


class SocialMpc:
    """J = q_goal c_goal² + q_social c_social² − q_passing c_passing² over rollouts of 1.2 s.

    The authors' robot is a ball that moves in any direction, on an open floor. A chair turns before
    it drives, so there are slower rollouts and standing as well, the final heading error has a
    cost, and rollouts that touch a wall are excluded.
    """

    class Parameters(Model):
        """Horizon, Gaussians and the form of the cost are the authors'; all else is assumed."""

        steps: int = Field(20, ge=3, le=100)
        """Steps of the reference; its end is the goal of the rollouts."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """Δt, s (the authors: 0.2)."""
        horizon: float = Field(1.2, gt=0.1, le=6.0)
        """Horizon of the rollouts, s; Poddar et al. Never beyond ``steps``."""
        headings: int = Field(24, ge=3, le=90)
        """Number of directions, evenly over ``span`` about the robot's own (the authors: 10)."""
        span: float = Field(2.0 * math.pi, gt=0.0, le=2.0 * math.pi)
        """Range of the directions, rad; Poddar et al."""
        speeds: int = Field(4, ge=1, le=12)
        """Number of speeds, evenly from the reference's down to 0 (the authors: 1)."""
        gain: float = Field(2.0, gt=0.0, le=10.0)
        """Turn rate per radian of heading error, 1/s."""
        front: float = Field(1.0, gt=0.0, le=5.0)
        """σ_h, m; Poddar et al."""
        side: float = Field(0.66, gt=0.0, le=5.0)
        """σ_s, m; Poddar et al."""
        rear: float = Field(0.33, gt=0.0, le=5.0)
        """σ_r, m; Poddar et al."""
        at_rest: float = Field(0.5, gt=0.0, le=5.0)
        """σ of a standing person, m; assumed (the authors: 1.0, which a robot that must turn first
        cannot pass)."""
        goal: float = Field(2.0, ge=0.0)
        """q_goal, weight of the squared missing share of the progress."""
        social: float = Field(80.0, ge=0.0)
        """q_social, weight of the people's squared Gaussians along the rollout."""
        stalled_share: float = Field(0.05, ge=0.0, le=1.0)
        """Share of q_social while the ride is stalled."""
        passing: float = Field(3.0, ge=0.0)
        """q_passing, reward for passing people early, s²/rad²."""
        path: float = Field(0.02, ge=0.0)
        """Weight of the squared mean distance from the reference, 1/m²: the straight line to the
        goal may lead through a wall."""
        heading: float = Field(0.05, ge=0.0)
        """Weight of the final angle to the goal, 1/rad²: the only gain of a turn on the spot within
        the horizon."""
        turning: float = Field(0.02, ge=0.0)
        """Weight of the mean squared turn rate, s²/rad²."""
        walls: float = Field(0.5, ge=0.0)
        """Weight of the proximity to walls, exp(−gap² / 2σ²)."""
        wall_range: float = Field(0.15, gt=0.0, le=2.0)
        """σ of that proximity, m."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self.rolled = min(max(round(p.horizon / p.step), 2), p.steps)
        self._sigma = np.array([p.front, p.side, p.rear, p.at_rest])

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        check_problem(problem, self.steps)
        problem = problem.truncated(self.steps)
        current_input = estimate_current_input(problem, previous)
        rollouts = self.rollouts(problem, current_input)
        costs = self.costs(problem, rollouts)
        total = np.sum(list(costs.values()), axis=0)
        best = int(np.argmax(total <= total.min() + _TIE))  # first: invariant to rotation
        if not np.isfinite(total[best]):
            return plan_of(
                problem,
                braking_trajectory(problem, current_input, self.rolled),
                Status.STOP,
                costs={},
            )
        trajectory = Trajectory(
            step=self.step,
            poses=rollouts.poses[best],
            inputs=rollouts.inputs[best],
            current_input=current_input,
        )
        chosen = {name: float(each[best]) for name, each in costs.items()}
        return plan_of(problem, trajectory, Status.OK, costs=chosen)

    def rollouts(self, problem: LocalProblem, current_input: Floats) -> Rollouts:
        """Rollouts in every direction and straight to the goal, at every speed."""
        p = self.parameters
        steering = steering_of(problem, p.gain, p.step)
        top_speed = max(float(problem.reference.speeds[: self.rolled + 1].max()), _CREEP)
        top_speed = min(top_speed, problem.top_speed)
        fan = problem.pose[2] + p.span * (np.arange(p.headings) - p.headings // 2) / p.headings
        to_goal = problem.reference.poses[-1, :2] - problem.pose[:2]
        directions = np.append(fan, np.arctan2(to_goal[1], to_goal[0]))
        shares = np.linspace(1.0, 0.0, p.speeds) if p.speeds > 1 else np.ones(1)
        direction = np.repeat(directions, p.speeds)
        speed = np.tile(top_speed * shares, len(directions))
        poses, inputs = roll_out_directions(
            problem.pose,
            current_input,
            direction,
            speed,
            steering,
            self.rolled,
        )
        return Rollouts(direction=direction, speed=speed, poses=poses, inputs=inputs)

    def costs(self, problem: LocalProblem, rollouts: Rollouts) -> dict[str, Floats]:
        """Summands of J, (r,) each; infinite where a wall is touched."""
        p, robot, predicted = self.parameters, problem.robot, problem.predictions
        social = social_cost(
            rollouts.poses,
            robot.capsule,
            predicted.mean,
            predicted.velocity,
            predicted.weight,
            problem.people.radius,
            self._sigma,
        )
        early = (
            passing(rollouts.poses, predicted.mean, predicted.velocity, predicted.weight) / p.step
        )
        w = robot.motion_model.twist(rollouts.inputs)[..., 2]
        return {
            "goal": p.goal * self._missing_progress(problem, rollouts) ** 2,
            "social": p.social * (p.stalled_share if problem.stalled else 1.0) * social**2,
            "passing": -p.passing * early**2,
            "path": p.path * self._path_distance(problem, rollouts) ** 2,
            "heading": p.heading * self._final_angle(problem, rollouts) ** 2,
            "turning": p.turning * (w**2).mean(axis=1),
            "walls": self._walls(problem, rollouts),
        }

    def _missing_progress(self, problem: LocalProblem, rollouts: Rollouts) -> Floats:
        """Mean over the steps of (remaining − smallest possible distance) / 2 progress, (r,)."""
        goal = problem.reference.poses[-1, :2]
        start = float(np.hypot(*(goal - problem.pose[:2])))
        remaining = np.hypot(*(rollouts.poses[:, 1:, :2] - goal).transpose(2, 0, 1))
        longest = float(rollouts.speed.max()) * self.step * np.arange(1, self.rolled + 1)
        possible = np.minimum(longest, start)
        missing = (remaining - (start - possible)) / (2.0 * np.maximum(possible, 1e-3))
        return np.asarray(missing.mean(axis=1))

    def _path_distance(self, problem: LocalProblem, rollouts: Rollouts) -> Floats:
        """Mean distance of the rollout from the nearest poses of the reference, (r,), m."""
        nearest = nearest_squared(rollouts.poses, problem.reference.poses)
        return np.asarray(np.sqrt(nearest).mean(axis=1))

    def _final_angle(self, problem: LocalProblem, rollouts: Rollouts) -> Floats:
        """Angle between the final heading and the present direction to the goal, (r,)."""
        to_goal = problem.reference.poses[-1, :2] - problem.pose[:2]
        error = rollouts.poses[:, -1, 2] - np.arctan2(to_goal[1], to_goal[0])
        return np.asarray(wrap_angle(error))

    def _walls(self, problem: LocalProblem, rollouts: Rollouts) -> Floats:
        p = self.parameters
        gaps, initial_gap = wall_gaps(rollouts.poses, problem.robot.discs, wall_grid(problem.walls))
        near = p.walls * np.exp(-0.5 * (np.maximum(gaps, 0.0) / p.wall_range) ** 2)
        allowed = min(problem.profile.clearance, max(initial_gap - 1e-6, 0.0))
        return np.where(gaps >= allowed, near, np.inf)
