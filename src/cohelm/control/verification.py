"""Verification of a motion before it is used: slack in the optimisation is not safety.

A motion is used only if it stays clear of bodies and walls for a while, swept between its steps,
and if braking after its first command touches nothing.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, unchecked
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.messages import Predictions
from cohelm.robots.braking import braking
from cohelm.robots.contact import ContactMargins, first_contact

_FINE = 0.05
"""Time between the poses of a verified braking, s."""
_FASTER = 4.0
"""Factor on a person's measured speed with which they may return, up to ``turn_back_speed``."""
_CERTAIN = 1.0
"""Minimum probability at which only the most likely hypothesis of each person counts."""


class Verification(Model):
    """Margins and horizon of the verification; assumed. No margin is below that of the gate."""

    wall_margin: float = Field(0.02, ge=0.0)
    """Gap to a wall that counts as contact, m."""
    people_margin: float = Field(0.25, ge=0.0)
    """Gap to a person that counts as contact, m; see ``ContactMargins``."""
    stalled_people_margin: float = Field(0.14, ge=0.0)
    """Gap to a person that counts as contact while the ride is stalled, m."""
    stalled_wall_margin: float = Field(0.012, ge=0.0)
    """Gap to a wall that counts as contact while the ride is stalled, m."""
    standing_share: float = Field(0.4, ge=0.0, le=1.0)
    """Share of the people margin and of ``people_acceleration`` for a standing person."""
    people_acceleration: float = Field(0.5, ge=0.0)
    """Possible change of people's velocity, m/s². Emergency braking must keep clear of everything
    that they can reach, so the robot is slow near people."""
    min_probability: float = Field(0.1, ge=0.0, le=1.0)
    """Probability from which a hypothesis that is not the most likely one binds emergency
    braking."""
    turn_back_acceleration: float = Field(6.0, ge=0.0)
    """Acceleration of walking people who turn back, m/s²: emergency braking must keep clear of all
    of them, however unlikely it is; 0: only predicted turns count. A person who walks at 1.1 m/s
    has turned within 0.4 s."""
    turn_back_delay: float = Field(0.25, ge=0.0)
    """Delay until a turn is detected, s: two scans and the filter."""
    turn_back_speed: float = Field(1.0, ge=0.0)
    """Speed up to which people may return faster than measured, m/s: a turning person is measured
    as slow."""
    turn_back_margin: float = Field(0.1, ge=0.0)
    """Gap to a person who turns back that counts as contact, m."""
    horizon: float = Field(2.0, gt=0.0)
    """Time for which a motion must be free of contact, s; braking is checked in any case."""
    reaction: float = Field(0.2, gt=0.0)
    """Time for which a command acts before braking can begin, s: a tick and the drive's lag."""

    def passes(self, problem: LocalProblem, motion: Motion) -> bool:
        """Check that a motion is clear for a while, and so is braking after its first command.

        All motions are swept against walls and predicted bodies. Comfort braking answers the most
        likely hypothesis of each person. Emergency braking also answers every hypothesis above a
        probability, people who accelerate, and everybody who turns back.
        """
        if self._contact(problem, motion.poses, motion.step) < self.horizon:
            return False
        command, robot = motion.inputs[0], problem.robot
        comfort, emergency = (
            self._braking(problem, motion.last_input, command, deceleration)
            for deceleration in (robot.max_deceleration, robot.emergency_deceleration)
        )
        return self._contact(problem, comfort, _FINE) == np.inf and self._escapes(
            problem, emergency
        )

    def urgent(self, problem: LocalProblem, now: Floats) -> bool:
        """Check that comfort braking may violate the margins of emergency braking.

        Args:
            problem: the present problem.
            now: current input, (m,).
        """
        comfort = self._braking(problem, now, np.zeros_like(now), problem.robot.max_deceleration)
        return not self._escapes(problem, comfort)

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
        """Check that braking keeps clear of everything that people may do."""
        binding = {
            "acceleration": self.people_acceleration,
            "min_probability": self.min_probability,
        }
        if self._contact(problem, poses, _FINE, **binding) < np.inf:
            return False
        if self.turn_back_acceleration <= 0.0 or problem.stalled or len(problem.people) == 0:
            return True  # a robot that squeezes past is too slow to escape
        back = unchecked(problem, predictions=self._turned_back(problem))
        return self._contact(back, poses, _FINE, people=self.turn_back_margin) == np.inf

    def _turned_back(self, problem: LocalProblem) -> Predictions:
        """Everybody returning since the undetected start of a turn, see ``turn_back_speed``.

        The measured position is that of a person who walked on; the turn has taken them behind it.
        """
        given = problem.predictions
        mean, velocity = _return(
            problem.people.mean,
            np.asarray(given.step * np.arange(given.mean.shape[2]), dtype=float),
            self.turn_back_delay,
            self.turn_back_acceleration,
            self.turn_back_speed,
        )
        return unchecked(
            given,
            names=("turned_back",),
            weight=np.ones((len(mean), 1)),
            mean=mean,
            velocity=velocity,
            deviation=np.zeros(mean.shape[:3]),
        )

    def _contact(
        self, problem: LocalProblem, poses: Floats, step: float, **changes: float
    ) -> float:
        """First contact of poses (k, 3); changes: of the margins of ordinary driving."""
        stalled = problem.stalled
        margins = ContactMargins(
            wall=self.stalled_wall_margin if stalled else self.wall_margin,
            people=self.stalled_people_margin if stalled else self.people_margin,
            min_probability=_CERTAIN,
            standing_share=self.standing_share,
        )
        return first_contact(
            problem.robot,
            poses,
            step,
            people=problem.people,
            predictions=problem.predictions,
            walls=problem.walls,
            margins=margins._replace(**changes),
        )


@njit(cache=True)
def _return(
    people: Floats, ahead: Floats, delay: float, acceleration: float, top_speed: float
) -> tuple[Floats, Floats]:
    """(positions, velocities) (n, 1, N+1, 2) of people (n, 4) who turn back; ``_turned_back``.

    ahead: (N+1,) s.
    """
    count, states = people.shape[0], ahead.shape[0]
    mean, velocity = np.empty((count, 1, states, 2)), np.empty((count, 1, states, 2))
    for i in range(count):
        speed = math.hypot(people[i, 2], people[i, 3])
        back = max(speed, min(_FASTER * speed, top_speed))
        for k in range(states):
            # distance along the former direction: braking, then back at a constant speed
            since = delay + ahead[k]
            about = min(since, (speed + back) / acceleration)
            along = speed * about - 0.5 * acceleration * (about * about) - back * (since - about)
            along -= speed * delay
            gains = -back if since > about else speed - acceleration * about
            for a in range(2):
                unit = people[i, 2 + a] / max(speed, 1e-9)
                mean[i, 0, k, a] = people[i, a] + along * unit
                velocity[i, 0, k, a] = gains * unit
    return mean, velocity
