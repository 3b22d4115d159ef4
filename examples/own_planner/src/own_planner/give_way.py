"""Follow the path and give way: pure pursuit at the highest speed without contact.

The steering is Coulter's (Implementation of the pure pursuit path tracking algorithm, 1992); the
rest is a minimal local planner among people. It never leaves its path.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control import LocalProblem
from cohelm.geometry import transform
from cohelm.messages import LocalPlan, Reason, Status
from cohelm.robots.kinematics import within_limits


class GiveWay:
    """One arc to a point ahead on the reference, as fast as the predicted people allow."""

    class Parameters(Model):
        """Horizon, speeds and margins; all assumed."""

        steps: int = Field(25, ge=3, le=100)
        """Steps of the plan."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """s."""
        ahead: int = Field(10, ge=1, le=100)
        """Lookahead of the target on the reference, steps."""
        speeds: int = Field(8, ge=1, le=50)
        """Number of speeds to try, from the reference's down."""
        people_margin: float = Field(0.3, ge=0.0, le=5.0)
        """Gap between the footprint and a predicted person, m."""
        wall_margin: float = Field(0.02, ge=0.0, le=1.0)
        """Gap to a wall, m."""
        turn_first: float = Field(1.0, gt=0.0, le=math.pi)
        """Bearing of the target from which the robot turns on the spot, rad."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`cohelm.control.LocalPlanner`; without memory."""
        wanted = self._wanted(problem)
        for share in np.linspace(1.0, 0.0, self.parameters.speeds, endpoint=False):
            inputs = self._driven(problem, share * wanted)
            poses = problem.robot.motion_model.rollout(problem.pose, inputs, self.step)
            if self._is_clear(problem, poses):
                return self._plan(problem, poses, inputs, Status.OK)
        inputs = self._driven(problem, np.zeros(3))
        poses = problem.robot.motion_model.rollout(problem.pose, inputs, self.step)
        return self._plan(problem, poses, inputs, Status.STOP)

    def _wanted(self, problem: LocalProblem) -> Floats:
        """The twist (3,) of the arc through the point ahead: ω = 2 v y / (x² + y²).

        If the target is behind or beside the robot, it is a turn on the spot.
        """
        p, reference = self.parameters, problem.reference
        k = min(p.ahead, len(reference.poses) - 1)
        dx, dy = reference.poses[k, :2] - problem.pose[:2]
        cos, sin = math.cos(problem.pose[2]), math.sin(problem.pose[2])
        x, y = cos * dx + sin * dy, -sin * dx + cos * dy
        square = x * x + y * y
        speed = float(reference.speeds[1 : k + 1].max())
        if math.sqrt(square) < 0.05:  # at the end only the heading counts
            return np.array([0.0, 0.0, float(reference.poses[k, 2] - problem.pose[2])])
        bearing = math.atan2(y, x)
        if abs(bearing) > p.turn_first:
            return np.array([0.0, 0.0, bearing])
        return np.array([speed, 0.0, 2.0 * speed * y / square])

    def _driven(self, problem: LocalProblem, twist: Floats) -> Floats:
        """Inputs (N, m) that reach a twist (3,) as fast as the limits allow."""
        motion = problem.robot.motion_model
        low, high, rise, fall = problem.input_bounds()
        wanted = np.tile(motion.input(twist), (self.steps, 1))
        now = motion.input(problem.twist)
        up, down = self.step * rise[None], self.step * fall[None]
        return within_limits(
            wanted, now, low, high, up, down, motion.translating, problem.top_speed
        )

    def _is_clear(self, problem: LocalProblem, poses: Floats) -> bool:
        """Check the margins of poses (N+1, 3) to walls and to all predicted people.

        A robot that starts within a margin may leave, but not come closer.
        """
        p, discs = self.parameters, problem.robot.discs
        centres = transform(poses[:, None], discs[:, :2])  # (N+1, c, 2)
        walls = (problem.walls.at(centres) - discs[:, 2]).min(axis=1)
        if walls.min() < min(p.wall_margin, walls[0]) - 1e-9:
            return False
        people = problem.predictions.mean[:, :, : len(poses), None]  # (n, h, N+1, 1, 2)
        reach = problem.people.radius[:, None, None, None] + discs[:, 2]
        gaps = np.hypot(*np.moveaxis(people - centres, -1, 0)) - reach
        least = np.minimum(p.people_margin, gaps[:, :, :1].min(axis=-1, keepdims=True))
        return bool((gaps >= least - 1e-9).all())

    def _plan(
        self, problem: LocalProblem, poses: Floats, inputs: Floats, status: Status
    ) -> LocalPlan:
        return LocalPlan(
            time=problem.time,
            step=self.step,
            command=problem.robot.motion_model.twist(inputs[0]),
            poses=poses,
            inputs=inputs,
            status=status,
            reason=Reason.NO_SAFE_PLAN if status is Status.STOP else None,
        )
