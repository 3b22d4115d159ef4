"""Dynamic window approach: Fox, Burgard and Thrun (1997), with the critics of Nav2's DWB.

A velocity is admissible if the robot can brake from it before it touches anything. Critics give
each reachable velocity a cost, and the cheapest admissible one is driven.
"""

from __future__ import annotations

import itertools

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.baselines.dwa_critics import (
    AT_REST,
    DwaWeights,
    DynamicWindow,
    ramp,
    velocity_costs,
)
from cohelm.control.baselines.tracking import plan_of
from cohelm.control.trajectories import braking_trajectory, limited_trajectory
from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input
from cohelm.messages import LocalPlan, Status
from cohelm.robots.wall_contact import wall_grid

_STOPPED = 0.02
"""A reference that is always slower than this needs no motion, m/s."""
_CREEP = 0.1
"""Speeds up to this are sampled even where the reference stands, m/s."""


class Dwa:
    """Samples velocities, simulates each, and drives the cheapest admissible one.

    The path is the reference over ``steps``, its end the local goal. If only standing is
    admissible, the robot brakes with a reason. It simulates one constant velocity at a time.
    """

    class Parameters(Model):
        """Horizon, samples, margins and critic weights; assumed unless a source is named."""

        steps: int = Field(30, ge=3, le=100)
        """Steps of the reference that is the path."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """s."""
        horizon: float = Field(1.7, gt=0.1, le=6.0)
        """Simulated time of each velocity, s (DWB's ``sim_time``)."""
        speeds: int = Field(15, ge=2, le=60)
        """Samples of the speed (DWB has 20)."""
        turns: int = Field(25, ge=3, le=99)
        """Samples of the turn rate (DWB has 20)."""
        predict: bool = True
        """People move as predicted; off, they stay at their present positions, as in a costmap."""
        reaction: float = Field(0.2, ge=0.0, le=1.0)
        """Time for which a velocity acts before braking can begin, s."""
        wall_margin: float = Field(0.04, ge=0.0, le=0.5)
        """Gap to a wall that counts as contact, m."""
        people_margin: float = Field(0.2, ge=0.0, le=1.0)
        """Gap to a person that counts as contact, m."""
        inflation: float = Field(0.5, gt=0.0, le=3.0)
        """Gap below which the obstacle critic counts, m (DWB: that of the inflation layer)."""
        forward_point_distance: float = Field(0.325, gt=0.0, le=2.0)
        """Distance of the aligned point ahead of the robot, m (DWB's name)."""
        path: float = Field(0.8, ge=0.0)
        """Weight of the mean distance from the path, 1/m (PathDist)."""
        path_alignment: float = Field(0.8, ge=0.0)
        """Weight of the distance of the point ahead from the path, 1/m (PathAlign)."""
        goal: float = Field(1.0, ge=0.0)
        """Weight of the remaining distance to the local goal, 1/m (GoalDist)."""
        goal_alignment: float = Field(0.4, ge=0.0)
        """Weight of the distance of the point ahead from the local goal, 1/m (GoalAlign)."""
        obstacles: float = Field(0.6, ge=0.0)
        """Weight of the squared missing share of ``inflation``, mean over time (BaseObstacle)."""
        changes: float = Field(0.02, ge=0.0)
        """Weight of a change of the velocity, s/m (replaces Oscillation)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self._simulated = min(max(round(p.horizon / p.step), 2), p.steps)

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        check_problem(problem, self.steps)
        problem = problem.truncated(self.steps)
        current_input = estimate_current_input(problem, previous)
        samples = self._samples(problem, current_input)
        costs = self._costs(problem, current_input, samples, previous)
        moving = np.abs(samples).max(axis=1) > AT_REST
        must_move = bool(problem.reference.speeds.max() > _STOPPED)
        if not np.isfinite(costs).any() or (must_move and not np.isfinite(costs[moving]).any()):
            rest = braking_trajectory(problem, current_input, self._simulated)
            return plan_of(problem, rest, Status.STOP, costs={})
        # the first of all equal costs, so that a rotation of the world changes nothing
        lowest = float(costs.min())
        best = int(np.argmax(costs <= lowest + 1e-9))
        trajectory = self._driven(problem, current_input, samples[best])
        return plan_of(
            problem, trajectory, Status.OK, costs={"critics": lowest}, memory=trajectory.inputs[-1]
        )

    def _samples(self, problem: LocalProblem, current_input: Floats) -> Floats:
        """Inputs (a, m) within the limits that can be reached within the horizon."""
        p = self.parameters
        low, high, rise, fall = problem.input_bounds()
        fastest = max(float(problem.reference.speeds.max()), _CREEP)
        high[0] = min(high[0], fastest)
        low, high = (
            np.maximum(low, current_input - fall * p.horizon),
            np.minimum(high, current_input + rise * p.horizon),
        )
        high = np.maximum(high, low)
        counts = [p.speeds, *[max(p.speeds // 2, 3)] * (len(current_input) - 2), p.turns]
        axes = [_spread(low[i], high[i], counts[i]) for i in range(len(current_input))]
        samples = np.array(list(itertools.product(*axes)))
        speed = np.hypot(*problem.robot.motion_model.twist(samples)[:, :2].T)
        limit = max(high[0], float(np.hypot(*problem.twist[:2])))
        allowed: Floats = samples[speed <= limit + 1e-9]
        return allowed

    def _costs(
        self,
        problem: LocalProblem,
        current_input: Floats,
        samples: Floats,
        previous: LocalPlan | None,
    ) -> Floats:
        p, robot = self.parameters, problem.robot
        _, _, rise, fall = problem.input_bounds()
        memory = previous.memory if previous is not None else None
        last = (
            memory
            if isinstance(memory, np.ndarray) and memory.shape == current_input.shape
            else current_input
        )
        window = DynamicWindow(
            current_input=current_input,
            rise=rise * p.step,
            fall=fall * p.step,
            twists=robot.motion_model.twist(np.eye(len(current_input))),
            start=problem.pose,
            steps=self._simulated,
            step=p.step,
            path=_extended(problem.reference.poses, p.forward_point_distance),
            capsule=robot.capsule,
            discs=robot.discs,
            people=self._people(problem),
            radius=np.repeat(problem.people.radius, problem.predictions.mean.shape[1]),
            walls=wall_grid(problem.walls),
        )
        braking = {
            "deceleration": robot.max_deceleration,
            "turn_deceleration": robot.max_turn_acceleration,
        }
        same = {name: getattr(p, name) for name in DwaWeights._fields if name not in braking}
        weights = DwaWeights(**same, **braking)
        costs: Floats = velocity_costs(samples, window, weights, last)
        return costs

    def _people(self, problem: LocalProblem) -> Floats:
        """Positions of people at the simulated times, (n·h, N+1, 2); every hypothesis counts."""
        mean = problem.predictions.mean[:, :, : self._simulated + 1]
        if not self.parameters.predict:
            mean = np.repeat(mean[:, :, :1], self._simulated + 1, axis=2)
        return np.ascontiguousarray(mean).reshape(-1, self._simulated + 1, 2)

    def _driven(self, problem: LocalProblem, current_input: Floats, target: Floats) -> Trajectory:
        _, _, rise, fall = problem.input_bounds()
        inputs = np.empty((self._simulated, len(current_input)))
        ramp(target, current_input, rise * self.step, fall * self.step, inputs)
        return limited_trajectory(problem, inputs, current_input)


def _extended(poses: Floats, distance: float) -> Floats:
    """The path (k + 1, 2) of reference poses (k, 3), extended straight beyond its end."""
    heading = poses[-1, 2]
    beyond = poses[-1, :2] + distance * np.array([np.cos(heading), np.sin(heading)])
    return np.concatenate([poses[:, :2], beyond[None]])


def _spread(low: float, high: float, count: int) -> Floats:
    """Even samples from low to high, and 0 if it lies between them."""
    values = np.linspace(low, high, count)
    return np.union1d(values, [0.0]) if low < 0.0 < high else values
