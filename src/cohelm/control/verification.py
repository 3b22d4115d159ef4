"""Slack is not safety: what a motion must pass before it is used, and what is done without one.

A motion is used only if it stays outside bodies and walls for a while, swept between its steps, and
if braking after its first command touches nothing.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, unchecked
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.warm_start import followed
from cohelm.messages import Predictions
from cohelm.robots.contact import braking, first_contact

_FINE = 0.05
"""Between the poses of a braking that is verified, s."""
_FASTER = 4.0
"""Times as fast as he is seen to go somebody may come back, up to ``Verification.pace``."""
_CERTAIN = 1.0
"""The probability from which on the likeliest future of each person alone counts."""


class Verification(Model):
    """What counts as contact, and how far ahead; assumed. Nothing is below what the gate asks."""

    wall_margin: float = Field(0.02, ge=0.0)
    """Gap to a wall that counts as contact, m."""
    people_margin: float = Field(0.25, ge=0.0)
    """Gap to a person that counts as contact, m; see ``first_contact``."""
    squeezing_margin: float = Field(0.14, ge=0.0)
    """The same when the ride is stalled, m."""
    squeezing_wall_margin: float = Field(0.012, ge=0.0)
    """Gap to a wall that counts as contact when the ride is stalled, m."""
    standing: float = Field(0.4, ge=0.0, le=1.0)
    """Share of both, and of ``agility``, that counts for who stands."""
    agility: float = Field(0.5, ge=0.0)
    """How fast people may change their velocity, m/s²: hard braking must keep clear of all that
    they can reach, so the robot goes slowly where they are near."""
    at_least: float = Field(0.1, ge=0.0, le=1.0)
    """Probability from which on a future that is not a person's likeliest binds hard braking."""
    turning: float = Field(6.0, ge=0.0)
    """What people turn back with where they walk, m/s²: hard braking must keep clear of everybody
    who does, however unlikely it is; 0: nobody turns back without being predicted to. Who walks at
    1.1 m/s has turned about within 0.4 s."""
    unseen: float = Field(0.25, ge=0.0)
    """How long a turn goes unnoticed, s: two scans and what filtering takes."""
    pace: float = Field(1.0, ge=0.0)
    """Up to which people may come back faster than they are seen to go, m/s: who turns is
    seen to be slow meanwhile."""
    turned_margin: float = Field(0.1, ge=0.0)
    """Gap to who turns back that counts as contact, m."""
    time: float = Field(2.0, gt=0.0)
    """How far ahead a motion must be free of contact, s; braking is checked in any case."""
    reaction: float = Field(0.2, gt=0.0)
    """How long a command acts before braking can begin, s: a tick and the drive's lag."""

    def passes(self, problem: LocalProblem, motion: Motion) -> bool:
        """Whether a motion is clear for a while, and so is braking after its first command.

        All swept, against walls and the people's predicted bodies. Ordinary braking answers what
        each person most likely does; hard braking what they may do: every future of some
        probability, in each people who turn as fast as their ``agility`` allows, and everybody who
        turns back.
        """
        if self._contact(problem, motion.poses, motion.step) < self.time:
            return False
        command = motion.inputs[0]
        gently, hard = (
            self._braking(problem, motion.last_input, command, deceleration)
            for deceleration in (
                problem.robot.max_deceleration,
                problem.robot.emergency_deceleration,
            )
        )
        return self._contact(problem, gently, _FINE) == np.inf and self._escapes(problem, hard)

    def urgent(self, problem: LocalProblem, now: Floats) -> bool:
        """Whether who brakes as in ordinary driving may touch what hard braking must keep clear of.

        Args:
            problem: whose robot brakes.
            now: what the wheels do, (m,).
        """
        still = np.zeros_like(now)
        gently = self._braking(problem, now, still, problem.robot.max_deceleration)
        return not self._escapes(problem, gently)

    def _braking(
        self, problem: LocalProblem, now: Floats, command: Floats, deceleration: float
    ) -> Floats:
        return braking(
            problem.robot,
            problem.pose,
            now,
            command,
            hold=self.reaction,
            deceleration=deceleration,
            step=_FINE,
        )

    def _escapes(self, problem: LocalProblem, poses: Floats) -> bool:
        """Whether braking keeps clear of all that people may do."""
        if (
            self._contact(problem, poses, _FINE, agility=self.agility, at_least=self.at_least)
            < np.inf
        ):
            return False
        if self.turning <= 0.0 or problem.stalled or len(problem.people) == 0:
            return True  # who squeezes past is slow, and would not get away
        back = unchecked(problem, predictions=self._turned_back(problem))
        return self._contact(back, poses, _FINE, margin=self.turned_margin) == np.inf

    def _turned_back(self, problem: LocalProblem) -> Predictions:
        """Everybody on the way back since a moment ago, as fast as he came or faster, see ``pace``.

        Where he is seen he would be had he gone on; he is behind that by what he turned meanwhile.
        """
        given = problem.predictions
        mean, velocity = _back(
            problem.people.mean,
            np.asarray(given.step * np.arange(given.mean.shape[2]), dtype=float),
            self.unseen,
            self.turning,
            self.pace,
        )
        people = len(mean)
        return unchecked(
            given,
            names=("turned_back",),
            weight=np.ones((people, 1)),
            mean=mean,
            velocity=velocity,
            deviation=np.zeros(mean.shape[:3]),
        )

    def _contact(
        self,
        problem: LocalProblem,
        poses: Floats,
        step: float,
        *,
        agility: float = 0.0,
        at_least: float = _CERTAIN,
        margin: float | None = None,
    ) -> float:
        if margin is None:
            margin = self.squeezing_margin if problem.stalled else self.people_margin
        return first_contact(
            problem.robot,
            poses,
            step,
            people=problem.people,
            predictions=problem.predictions,
            walls=problem.walls,
            margin=self.squeezing_wall_margin if problem.stalled else self.wall_margin,
            people_margin=margin,
            agility=agility,
            at_least=at_least,
            standing=self.standing,
        )


@njit(cache=True)
def _back(
    people: Floats, ahead: Floats, unseen: float, turning: float, pace: float
) -> tuple[Floats, Floats]:
    """(positions, velocities) (n, 1, N+1, 2) of people (n, 4) who turn back; ``_turned_back``.

    ahead: (N+1,) s.
    """
    count, states = people.shape[0], ahead.shape[0]
    mean, velocity = np.empty((count, 1, states, 2)), np.empty((count, 1, states, 2))
    for i in range(count):
        speed = math.hypot(people[i, 2], people[i, 3])
        back = max(speed, min(_FASTER * speed, pace))
        for k in range(states):
            since = unseen + ahead[k]
            about = min(since, (speed + back) / turning)
            way = speed * about - 0.5 * turning * (about * about) - back * (since - about)
            way -= speed * unseen
            gains = -back if since > about else speed - turning * about
            for a in range(2):
                unit = people[i, 2 + a] / max(speed, 1e-9)
                mean[i, 0, k, a] = people[i, a] + way * unit
                velocity[i, 0, k, a] = gains * unit
    return mean, velocity


def brought_to_rest(problem: LocalProblem, now: Floats, steps: int) -> Motion:
    """Braking as in ordinary driving, all inputs in proportion: the curvature is kept.

    Args:
        problem: whose robot brakes.
        now: what the wheels do, (m,).
        steps: N.
    """
    _, _, _, fall = problem.robot.input_bounds
    step = problem.reference.step
    moving, turning = now[:-1], now[-1:]
    fading = max(np.linalg.norm(moving) / fall[0], np.abs(turning).max() / fall[-1], 1e-9)
    times = (np.arange(steps) + 0.5) * step
    left = np.clip(1.0 - times / fading, 0.0, 1.0)
    return followed(problem, left[:, None] * now, now)
