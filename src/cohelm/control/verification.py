"""Slack is not safety: what a motion must pass before it is used, and what is done without one.

A motion is used only if it stays outside bodies and walls for a while, swept between its steps, and
if braking after its first command touches nothing.
"""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.warm_start import followed
from cohelm.robots.contact import braking, first_contact

_FINE = 0.05
"""Between the poses of a braking that is verified, s."""
_CERTAIN = 1.0
"""The probability from which on the likeliest future of each person alone counts."""


class Verification(Model):
    """What counts as contact, and how far ahead; assumed. Nothing is below what the gate asks."""

    wall_margin: float = Field(0.03, ge=0.0)
    """Gap to a wall that counts as contact, m."""
    people_margin: float = Field(0.25, ge=0.0)
    """Gap to a person that counts as contact, m; see ``first_contact``."""
    squeezing_margin: float = Field(0.14, ge=0.0)
    """The same when the ride is stalled, m."""
    standing: float = Field(0.4, ge=0.0, le=1.0)
    """Share of both, and of ``agility``, that counts for who stands."""
    agility: float = Field(0.5, ge=0.0)
    """How fast people may change their velocity, m/s²: hard braking must keep clear of all that
    they can reach, so the robot goes slowly where they are near."""
    at_least: float = Field(0.1, ge=0.0, le=1.0)
    """Probability from which on a future that is not a person's likeliest binds hard braking."""
    time: float = Field(2.0, gt=0.0)
    """How far ahead a motion must be free of contact, s; braking is checked in any case."""
    reaction: float = Field(0.2, gt=0.0)
    """How long a command acts before braking can begin, s: a tick and the drive's lag."""

    def passes(self, problem: LocalProblem, motion: Motion) -> bool:
        """Whether a motion is clear for a while, and so is braking after its first command.

        All swept, against walls and the people's predicted bodies. Ordinary braking answers what
        each person most likely does; hard braking what they may do: every future of some
        probability, and in each people who turn as fast as their ``agility`` allows.
        """
        robot = problem.robot
        if self._contact(problem, motion.poses, motion.step) < self.time:
            return False
        return all(
            self._contact(
                problem,
                braking(
                    robot,
                    problem.pose,
                    motion.last_input,
                    motion.inputs[0],
                    hold=self.reaction,
                    deceleration=deceleration,
                    step=_FINE,
                ),
                _FINE,
                agility=agility,
                at_least=at_least,
            )
            == np.inf
            for deceleration, agility, at_least in (
                (robot.max_deceleration, 0.0, _CERTAIN),
                (robot.emergency_deceleration, self.agility, self.at_least),
            )
        )

    def _contact(
        self,
        problem: LocalProblem,
        poses: Floats,
        step: float,
        *,
        agility: float = 0.0,
        at_least: float = _CERTAIN,
    ) -> float:
        return first_contact(
            problem.robot,
            poses,
            step,
            people=problem.people,
            predictions=problem.predictions,
            walls=problem.walls,
            margin=self.wall_margin,
            people_margin=self.squeezing_margin if problem.stalled else self.people_margin,
            agility=agility,
            at_least=at_least,
            standing=self.standing,
        )


def brought_to_rest(problem: LocalProblem, now: Floats, steps: int) -> Motion:
    """Braking as in ordinary driving, all inputs in proportion: the curvature is kept.

    Args:
        problem: whose robot brakes.
        now: what the wheels do, (m,).
        steps: N.
    """
    _, _, _, fall = problem.robot.motion.bounds(problem.robot.limits)
    step = problem.reference.step
    moving, turning = now[:-1], now[-1:]
    fading = max(np.linalg.norm(moving) / fall[0], np.abs(turning).max() / fall[-1], step)
    times = (np.arange(steps) + 0.5) * step
    left = np.clip(1.0 - times / fading, 0.0, 1.0)
    return followed(problem, left[:, None] * now, now)
