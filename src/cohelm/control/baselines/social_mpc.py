"""Rollouts over headings, the socially cheapest of which is driven; after Poddar et al. (2023)."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.baselines.social_cost import nearest_squared, passing, social_cost, wall_gaps
from cohelm.control.baselines.steering import Steering, rollouts
from cohelm.control.baselines.tracking import plan_of
from cohelm.control.usable import usable
from cohelm.control.verification import brought_to_rest
from cohelm.control.warm_start import last_input
from cohelm.geometry import wrap_angle
from cohelm.messages import LocalPlan, Status

_TIE = 1e-9
"""Costs that are as near are equal."""
_CREEP = 0.1
"""Rollouts are at least so fast where the reference stands, m/s: it may wait for a turn."""


@value
class Rollouts:
    """What is compared."""

    direction: Annotated[Floats, Shape("r")]
    """To drive in, rad in the map frame."""
    speed: Annotated[Floats, Shape("r")]
    """m/s."""
    poses: Annotated[Floats, Shape("r N+1 3")]
    inputs: Annotated[Floats, Shape("r N m")]


class SocialMpc:
    """J = q_goal c_goal² + q_social c_social² − q_passing c_passing² over rollouts of 1.2 s.

    The authors' robot is a ball that moves any way, on an open floor. A chair turns before it
    drives, so slower rollouts and standing are offered as well, the heading left at the end has a
    price, and what would touch a wall is left out.
    """

    class Parameters(Model):
        """Horizon, Gaussians and the form of the cost are the authors'; the rest is assumed."""

        steps: int = Field(20, ge=3, le=100)
        """Steps of the reference, whose end is the goal of the rollouts."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """Δt, s (the authors: 0.2)."""
        horizon: float = Field(1.2, gt=0.1, le=6.0)
        """Of the rollouts, s; Poddar et al. Never beyond ``steps``."""
        headings: int = Field(24, ge=3, le=90)
        """Directions, evenly over ``span`` about the robot's own (the authors: 10)."""
        span: float = Field(2.0 * math.pi, gt=0.0, le=2.0 * math.pi)
        """rad; Poddar et al."""
        speeds: int = Field(4, ge=1, le=12)
        """Shares of the wanted speed, evenly from 1 down to 0 (the authors: 1 only)."""
        gain: float = Field(2.0, gt=0.0, le=10.0)
        """Turn rate for each radian off the direction, 1/s."""
        front: float = Field(1.0, gt=0.0, le=5.0)
        """σ_h, m; Poddar et al."""
        side: float = Field(0.66, gt=0.0, le=5.0)
        """σ_s, m; Poddar et al."""
        rear: float = Field(0.33, gt=0.0, le=5.0)
        """σ_r, m; Poddar et al."""
        at_rest: float = Field(0.5, gt=0.0, le=5.0)
        """σ of a person who stands, m; assumed (the authors: 1.0, round which nobody gets who must
        turn first)."""
        goal: float = Field(2.0, ge=0.0)
        """q_goal, of the share of the way that is not made good, squared."""
        social: float = Field(80.0, ge=0.0)
        """q_social, of the people's Gaussians along the way, squared."""
        squeezing: float = Field(0.05, ge=0.0, le=1.0)
        """Share of q_social that is left when the ride is stalled."""
        passing: float = Field(3.0, ge=0.0)
        """q_passing, reward of getting round people early, 1/rad² for each second of it."""
        path: float = Field(0.02, ge=0.0)
        """Of the mean distance from the reference, squared, 1/m²: the straight way to the goal may
        lead through a wall."""
        heading: float = Field(0.05, ge=0.0)
        """Of the angle to the goal that is left at the end, 1/rad²: who must turn on the spot to
        get on gains nothing else by it within the horizon."""
        turning: float = Field(0.02, ge=0.0)
        """Of the mean turn rate squared, s²/rad²."""
        walls: float = Field(0.5, ge=0.0)
        """Of the nearness to walls, exp(−gap² / 2σ²)."""
        wall_reach: float = Field(0.15, gt=0.0, le=2.0)
        """σ of that nearness, m."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self.rolled = min(max(round(p.horizon / p.step), 2), p.steps)
        self._sigma = np.array([p.front, p.side, p.rear, p.at_rest])

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        problem = usable(problem, self.steps)
        now = last_input(problem, previous)
        ways = self.rollouts(problem, now)
        costs = self.costs(problem, ways)
        total = np.sum(list(costs.values()), axis=0)
        best = int(np.argmax(total <= total.min() + _TIE))  # the first, however the world is turned
        if not np.isfinite(total[best]):
            return plan_of(
                problem, brought_to_rest(problem, now, self.rolled), Status.STOP, costs={}
            )
        motion = Motion(
            step=self.step, poses=ways.poses[best], inputs=ways.inputs[best], last_input=now
        )
        chosen = {name: float(each[best]) for name, each in costs.items()}
        return plan_of(problem, motion, Status.OK, costs=chosen)

    def rollouts(self, problem: LocalProblem, now: Floats) -> Rollouts:
        """Every direction at every speed, and straight to the goal at every speed."""
        p, steering = self.parameters, Steering.of(problem, self.parameters.gain)
        wanted = max(float(problem.reference.speeds[: self.rolled + 1].max()), _CREEP)
        wanted = min(wanted, problem.top_speed)
        fan = problem.pose[2] + p.span * (np.arange(p.headings) - p.headings // 2) / p.headings
        away = problem.reference.poses[-1, :2] - problem.pose[:2]
        directions = np.append(fan, np.arctan2(away[1], away[0]))
        shares = np.linspace(1.0, 0.0, p.speeds) if p.speeds > 1 else np.ones(1)
        direction = np.repeat(directions, p.speeds)
        speed = np.tile(wanted * shares, len(directions))
        poses, inputs = rollouts(
            problem.pose,
            now,
            direction,
            speed,
            steering.to_input,
            steering.to_twist,
            steering.bounds,
            steering.sideways,
            steering.gain,
            self.rolled,
            p.step,
        )
        return Rollouts(direction=direction, speed=speed, poses=poses, inputs=inputs)

    def costs(self, problem: LocalProblem, ways: Rollouts) -> dict[str, Floats]:
        """Each summand of J, (r,); infinite where a wall is touched."""
        p, robot, predicted = self.parameters, problem.robot, problem.predictions
        social = social_cost(
            ways.poses,
            robot.capsule,
            predicted.mean,
            predicted.velocity,
            predicted.weight,
            problem.people.radius,
            self._sigma,
        )
        early = passing(ways.poses, predicted.mean, predicted.velocity, predicted.weight) / p.step
        w = robot.motion.twist(ways.inputs)[..., 2]
        return {
            "goal": p.goal * self._not_made_good(problem, ways) ** 2,
            "social": p.social * (p.squeezing if problem.stalled else 1.0) * social**2,
            "passing": -p.passing * early**2,
            "path": p.path * self._beside(problem, ways) ** 2,
            "heading": p.heading * self._angle_left(problem, ways) ** 2,
            "turning": p.turning * (w**2).mean(axis=1),
            "walls": self._walls(problem, ways),
        }

    def _not_made_good(self, problem: LocalProblem, ways: Rollouts) -> Floats:
        """Mean over the steps of (distance left − the least possible) / 2 way made, (r,)."""
        goal = problem.reference.poses[-1, :2]
        start = float(np.hypot(*(goal - problem.pose[:2])))
        left = np.hypot(*(ways.poses[:, 1:, :2] - goal).transpose(2, 0, 1))
        most = float(ways.speed.max()) * self.step * np.arange(1, self.rolled + 1)
        made = np.minimum(most, start)
        lost = (left - (start - made)) / (2.0 * np.maximum(made, 1e-3))
        return np.asarray(lost.mean(axis=1))

    def _beside(self, problem: LocalProblem, ways: Rollouts) -> Floats:
        """Mean distance of the rollout's places from the nearest of the reference, (r,), m."""
        nearest = nearest_squared(ways.poses, problem.reference.poses)
        return np.asarray(np.sqrt(nearest).mean(axis=1))

    def _angle_left(self, problem: LocalProblem, ways: Rollouts) -> Floats:
        """Between the heading at the end of the rollout and the way to the goal now, (r,)."""
        away = problem.reference.poses[-1, :2] - problem.pose[:2]
        off = ways.poses[:, -1, 2] - np.arctan2(away[1], away[0])
        return np.asarray(wrap_angle(off))

    def _walls(self, problem: LocalProblem, ways: Rollouts) -> Floats:
        p, walls = self.parameters, problem.walls
        gaps, now = wall_gaps(
            ways.poses, problem.robot.discs, walls.distance, walls.resolution, walls.X_MG
        )
        near = p.walls * np.exp(-0.5 * (np.maximum(gaps, 0.0) / p.wall_reach) ** 2)
        allowed = min(problem.profile.clearance, max(now - 1e-6, 0.0))
        return np.where(gaps >= allowed, near, np.inf)
