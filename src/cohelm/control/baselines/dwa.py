"""The dynamic window approach: Fox, Burgard and Thrun (1997), with critics as Nav2's DWB has them.

Of all velocities that can be reached within the horizon, those are admissible from which the robot
can brake before it touches anything; critics give each a cost, and the cheapest is driven.
"""

from __future__ import annotations

import itertools

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.baselines.dwa_critics import AT_REST, ramp, scores
from cohelm.control.baselines.tracking import plan_of
from cohelm.control.usable import usable
from cohelm.control.verification import brought_to_rest
from cohelm.control.warm_start import followed, last_input
from cohelm.messages import LocalPlan, Status

_STOPPED = 0.02
"""A reference slower than this all along wants no motion, m/s."""
_CREEP = 0.1
"""Speeds up to this are sampled even where the reference stands, m/s."""


class Dwa:
    """Samples velocities, simulates each, and takes the cheapest that is admissible.

    The path is the reference over ``steps``, its end the local goal. Where no velocity but standing
    is admissible the robot brakes and says so. It looks one constant velocity ahead: see its page.
    """

    class Parameters(Model):
        """Horizon, samples, margins and the critics' weights; assumed unless a source is named."""

        steps: int = Field(30, ge=3, le=100)
        """Steps of the reference that is the path."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """s."""
        horizon: float = Field(1.7, gt=0.1, le=6.0)
        """For which each velocity is simulated, s (DWB's ``sim_time``)."""
        speeds: int = Field(15, ge=2, le=60)
        """Samples of the speed (DWB has 20)."""
        turns: int = Field(25, ge=3, le=99)
        """Samples of the turn rate (DWB has 20)."""
        predict: bool = True
        """Whether people move on as predicted; off, they stay where they are now, as in a costmap.
        """
        reaction: float = Field(0.2, ge=0.0, le=1.0)
        """How long a velocity acts before braking can begin, s."""
        wall_margin: float = Field(0.04, ge=0.0, le=0.5)
        """Gap to a wall that counts as contact, m."""
        people_margin: float = Field(0.2, ge=0.0, le=1.0)
        """Gap to a person that counts as contact, m."""
        reach: float = Field(0.5, gt=0.0, le=3.0)
        """Gap below which the obstacle critic counts, m (DWB: the inflation's)."""
        ahead: float = Field(0.325, gt=0.0, le=2.0)
        """Distance of the point ahead of the robot that is aligned, m (DWB's
        ``forward_point_distance``)."""
        path: float = Field(0.8, ge=0.0)
        """Weight of the mean distance from the path, 1/m (PathDist)."""
        path_alignment: float = Field(0.8, ge=0.0)
        """Of the distance from the path of the point ahead, 1/m (PathAlign)."""
        goal: float = Field(1.0, ge=0.0)
        """Of the way that is left to the local goal, 1/m (GoalDist)."""
        goal_alignment: float = Field(0.4, ge=0.0)
        """Of the distance from the local goal of the point ahead, 1/m (GoalAlign)."""
        obstacles: float = Field(0.6, ge=0.0)
        """Of the squared share of ``reach`` that is wanting, mean over time (BaseObstacle)."""
        changes: float = Field(0.02, ge=0.0)
        """Of a change against the velocity driven before, s/m (in Oscillation's place)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self._simulated = min(max(round(p.horizon / p.step), 2), p.steps)

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        problem = usable(problem, self.steps)
        now = last_input(problem, previous)
        samples = self._samples(problem, now)
        costs = self._costs(problem, now, samples, previous)
        moving = np.abs(samples).max(axis=1) > AT_REST
        wants_on = bool(problem.reference.speeds.max() > _STOPPED)
        if not np.isfinite(costs).any() or (wants_on and not np.isfinite(costs[moving]).any()):
            rest = brought_to_rest(problem, now, self._simulated)
            return plan_of(problem, rest, Status.STOP, costs={})
        # a tie is a tie whichever way the world is turned: the first of them
        least = float(costs.min())
        best = int(np.argmax(costs <= least + 1e-9))
        motion = self._driven(problem, now, samples[best])
        return plan_of(
            problem, motion, Status.OK, costs={"critics": least}, memory=motion.inputs[-1]
        )

    def _samples(self, problem: LocalProblem, now: Floats) -> Floats:
        """Inputs (a, m) within the limits that can be reached within the horizon."""
        p = self.parameters
        low, high, rise, fall = problem.input_bounds()
        fastest = max(float(problem.reference.speeds.max()), _CREEP)
        high[0] = min(high[0], fastest)
        low, high = (
            np.maximum(low, now - fall * p.horizon),
            np.minimum(high, now + rise * p.horizon),
        )
        high = np.maximum(high, low)
        counts = [p.speeds, *[max(p.speeds // 2, 3)] * (len(now) - 2), p.turns]
        axes = [_spread(low[i], high[i], counts[i]) for i in range(len(now))]
        samples = np.array(list(itertools.product(*axes)))
        speed = np.hypot(*problem.robot.motion.twist(samples)[:, :2].T)
        limit = max(high[0], float(np.hypot(*problem.twist[:2])))
        kept: Floats = samples[speed <= limit + 1e-9]
        return kept

    def _costs(
        self, problem: LocalProblem, now: Floats, samples: Floats, previous: LocalPlan | None
    ) -> Floats:
        p, robot = self.parameters, problem.robot
        _, _, rise, fall = problem.input_bounds()
        memory = previous.memory if previous is not None else None
        last = memory if isinstance(memory, np.ndarray) and memory.shape == now.shape else now
        bodies = self._bodies(problem)
        costs: Floats = scores(
            samples,
            now,
            rise * p.step,
            fall * p.step,
            robot.motion.twist(np.eye(len(now))),
            problem.pose,
            self._simulated,
            p.step,
            _drawn_on(problem.reference.poses, p.ahead),
            robot.capsule,
            robot.discs,
            bodies,
            np.repeat(problem.people.radius, problem.predictions.mean.shape[1]),
            problem.walls.distance,
            problem.walls.resolution,
            problem.walls.X_MG,
            np.array([p.wall_margin, p.people_margin, p.reach]),
            np.array([p.reaction, robot.max_deceleration, robot.max_turn_acceleration]),
            np.array(
                [
                    p.path,
                    p.path_alignment,
                    p.goal,
                    p.goal_alignment,
                    p.obstacles,
                    p.changes,
                    p.ahead,
                ]
            ),
            last,
        )
        return costs

    def _bodies(self, problem: LocalProblem) -> Floats:
        """Where people are at the simulated times, (n·h, N+1, 2); every hypothesis counts."""
        mean = problem.predictions.mean[:, :, : self._simulated + 1]
        if not self.parameters.predict:
            mean = np.repeat(mean[:, :, :1], self._simulated + 1, axis=2)
        return np.ascontiguousarray(mean).reshape(-1, self._simulated + 1, 2)

    def _driven(self, problem: LocalProblem, now: Floats, target: Floats) -> Motion:
        _, _, rise, fall = problem.input_bounds()
        inputs = np.empty((self._simulated, len(now)))
        ramp(target, now, rise * self.step, fall * self.step, inputs)
        return followed(problem, inputs, now)


def _drawn_on(poses: Floats, ahead: float) -> Floats:
    """The path (k + 1, 2) of reference poses (k, 3), and so far on beyond its end."""
    heading = poses[-1, 2]
    beyond = poses[-1, :2] + ahead * np.array([np.cos(heading), np.sin(heading)])
    return np.concatenate([poses[:, :2], beyond[None]])


def _spread(low: float, high: float, count: int) -> Floats:
    """Even samples from low to high, and 0 where it lies between them."""
    values = np.linspace(low, high, count)
    return np.union1d(values, [0.0]) if low < 0.0 < high else values
