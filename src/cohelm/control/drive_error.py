"""Bounded error of the drive in verification: commands take effect late, and casters kick.

A trajectory states poses as if the wheels obeyed at once. A real drive follows with a delay, and a
chair that sets off or reverses may be pushed aside while its casters swing round. Both are bounds
given by the user. Nothing is measured here, and no simulator's state is read.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import Trajectory
from cohelm.robots import Robot

SWING = 0.15
"""Distance driven until the casters have swung round, m: three trails (assumed)."""


class DriveError(Model):
    """Bounds of the error; 0 turns a part off."""

    delay: float = Field(0.0, ge=0.0, le=0.5)
    """Time by which commands take effect late, s. A lag of T is late by T in the long run, and
    ramps add to it: 0.12 s fits the twin (``benchmarks/twin_mechanics.py``)."""
    kick: float = Field(0.0, ge=0.0, le=0.1)
    """Largest sideways displacement by casters that swing round, m. A caster that swings about its
    point of contact moves its swivel by its trail, 0.04 to 0.06 m (assumed), at most."""

    def driven(self, trajectory: Trajectory, robot: Robot) -> Floats:
        """Poses (N+1, 3) of a trajectory whose inputs take effect late."""
        if self.delay <= 0.0:
            return trajectory.poses
        late = delayed(trajectory.inputs, trajectory.current_input, trajectory.step, self.delay)
        return robot.motion_model.rollout(trajectory.poses[0], late, trajectory.step)

    def displaced(self, poses: Floats, speed: float, robot: Robot) -> tuple[Floats, ...]:
        """The poses (k, 3), and those of a chair kicked to the left and to the right.

        Args:
            poses: of a motion that begins now.
            speed: forward velocity now, m/s; below 0 the chair reverses.
            robot: its accelerations bound how far it has driven already.
        """
        if self.kick <= 0.0:
            return (poses,)
        aside = self.kick * self._swung(poses, speed, robot)
        if not aside.any():
            return (poses,)
        left = np.column_stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2]), np.zeros(len(poses))])
        return poses, poses + aside[:, None] * left, poses - aside[:, None] * left

    def _swung(self, poses: Floats, speed: float, robot: Robot) -> Floats:
        """Angle of the casters' swing (k,) from now on, as a share of half a turn.

        A chair at v has driven v²/2a at least since it stood; that part of the swing is over. Each
        change of direction begins another one.
        """
        towards = (poses[1:, :2] - poses[:-1, :2]).T
        heading = poses[:-1, 2]
        steps = towards[0] * np.cos(heading) + towards[1] * np.sin(heading)
        gone = speed**2 / (2.0 * robot.max_acceleration)
        before, total = math.copysign(1.0, speed), 0.0
        out = np.zeros(len(poses))
        for k, step in enumerate(steps):
            if step and math.copysign(1.0, step) != before:
                before, gone = math.copysign(1.0, step), 0.0
            further = gone + abs(float(step))
            total += min(further, SWING) / SWING - min(gone, SWING) / SWING
            gone, out[k + 1] = further, total
        return out


def delayed(inputs: Floats, current_input: Floats, step: float, delay: float) -> Floats:
    """Inputs (N, m) that take effect ``delay`` seconds late, averaged over each step.

    Args:
        inputs: (N, m), constant over each step.
        current_input: (m,), which holds until then.
        step: s.
        delay: s.
    """
    ends = step * np.arange(len(inputs) + 1)
    # the integral is linear within a step, so that its differences are exact averages
    integral = np.vstack([np.zeros(inputs.shape[1]), np.cumsum(step * inputs, axis=0)])
    times = np.append(-delay, ends)
    integral = np.vstack([-delay * current_input, integral])
    at = np.column_stack([np.interp(ends - delay, times, each) for each in integral.T])
    return np.diff(at, axis=0) / step
