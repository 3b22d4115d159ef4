"""Verification of a trajectory before it is used: slack in the optimisation is not safety.

A trajectory is used only if it stays clear of people and walls for a while, swept between its
steps, and if braking after its first command touches nothing.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, unchecked
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.messages import Predictions
from cohelm.robots.braking import braking
from cohelm.robots.clearance import Clearance
from cohelm.robots.contact import ContactMargins, first_contact

_FINE = 0.05
"""Time between the poses of a verified braking, s."""
_FASTER = 4.0
"""Assumed return speed as a multiple of the measured speed, up to ``turn_back_speed``."""
_WALKED = 0.5
"""Who was slower than this lately does not turn back, m/s: tracking noise is up to 0.3 m/s."""
_NEAR = 2.0
"""Distance up to which a person ahead is near, m."""
_CERTAIN = 1.0
"""Minimum probability at which only the most likely hypothesis of each person counts."""


class Verification(Model):
    """Margins and horizon of the verification; assumed. See ``robots.clearance`` for people."""

    wall_margin: float = Field(0.02, ge=0.0)
    """Gap to a wall that counts as contact, m."""
    stalled_wall_margin: float = Field(0.012, ge=0.0)
    """Gap to a wall that counts as contact while the ride is stalled, m."""
    clearance_share: float = Field(1.0, ge=0.0, le=2.0)
    """Share of the clearance at the end of the horizon that a trajectory must keep from people."""
    people_acceleration: float = Field(0.5, ge=0.0)
    """Possible change of people's velocity, m/s². Emergency braking must keep clear of everything
    that they can reach, so the robot is slow near people."""
    min_probability: float = Field(0.1, ge=0.0, le=1.0)
    """Probability from which emergency braking must also keep clear of a hypothesis that is not the
    most likely one."""
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
    """Time for which a trajectory must be free of contact, s; braking is checked in any case."""
    reaction: float = Field(0.2, gt=0.0)
    """Time for which a command acts before braking can begin, s: a tick and the drive's lag."""

    def wall_margin_of(self, problem: LocalProblem) -> float:
        """Gap to a wall that counts as contact in a problem, m."""
        return self.stalled_wall_margin if problem.stalled else self.wall_margin

    def passes(
        self,
        problem: LocalProblem,
        trajectory: Trajectory,
        clearance: Clearance,
        speeds: Floats,
    ) -> bool:
        """Check that a trajectory is clear for a while, and so is braking after its first command.

        All trajectories are swept against walls and predicted people. The trajectory and comfort
        braking must keep clear of the most likely hypothesis of each person. Emergency braking must
        also keep clear of every hypothesis above a probability, of people who accelerate, and of
        all who turn back.
        """
        margins = self._margins(problem, clearance)
        swept = _contact(problem, trajectory.poses, trajectory.step, margins)
        if swept < self.horizon:
            return False
        command, robot = trajectory.inputs[0], problem.robot
        comfort, emergency = (
            self._braking(problem, trajectory.current_input, command, deceleration)
            for deceleration in (robot.max_deceleration, robot.emergency_deceleration)
        )
        clear = _contact(problem, comfort, _FINE, margins) == np.inf
        return clear and self._escape(problem, emergency, margins, speeds) == np.inf

    def needs_emergency_braking(
        self,
        problem: LocalProblem,
        current_input: Floats,
        clearance: Clearance,
        speeds: Floats,
    ) -> bool:
        """Check whether comfort braking is not enough, and emergency braking helps.

        It helps where it avoids or delays a contact, and towards somebody ahead, who is at least
        met slowly. It does not help beside somebody who walks into the robot.

        Args:
            problem: the present problem.
            current_input: u_{−1}, (m,).
            clearance: from people.
            speeds: (n,) of people lately, m/s.
        """
        margins, stand = self._margins(problem, clearance), np.zeros_like(current_input)
        robot = problem.robot
        comfort, emergency = (
            self._braking(problem, current_input, stand, deceleration)
            for deceleration in (robot.max_deceleration, robot.emergency_deceleration)
        )
        sooner = self._escape(problem, comfort, margins, speeds)
        later = self._escape(problem, emergency, margins, speeds)
        return sooner < later or (sooner < np.inf and _somebody_ahead(problem))

    def _braking(
        self, problem: LocalProblem, current_input: Floats, command: Floats, deceleration: float
    ) -> Floats:
        return braking(
            problem.robot,
            problem.pose,
            current_input,
            command,
            hold=self.reaction,
            deceleration=deceleration,
            step=_FINE,
        )

    def _escape(
        self, problem: LocalProblem, poses: Floats, margins: ContactMargins, speeds: Floats
    ) -> float:
        """Time of braking's (k, 3) first contact with all that people may do, s; +inf: none."""
        stricter = margins._replace(
            acceleration=self.people_acceleration, min_probability=self.min_probability
        )
        soonest = _contact(problem, poses, _FINE, stricter)
        if self.turn_back_acceleration <= 0.0 or problem.stalled or len(problem.people) == 0:
            return soonest  # a robot that squeezes past is too slow to escape
        returning = unchecked(problem, predictions=self._turned_back(problem, speeds))
        margins = margins._replace(people=self.turn_back_margin)
        return min(soonest, _contact(returning, poses, _FINE, margins))

    def _turned_back(self, problem: LocalProblem, speeds: Floats) -> Predictions:
        """Predictions of all people walking back, since a turn that is not detected yet.

        Who has stood for a while stays.

        The measured position is that of a person who walked on; the turn has taken them behind it.
        """
        given = problem.predictions
        mean, velocity = _return(
            problem.people.mean,
            np.asarray(given.step * np.arange(given.mean.shape[2]), dtype=float),
            speeds > _WALKED,
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

    def _margins(self, problem: LocalProblem, clearance: Clearance) -> ContactMargins:
        """Margins of ordinary driving."""
        gap = clearance.after(self.horizon, tight=problem.stalled)
        return ContactMargins(
            wall=self.wall_margin_of(problem),
            people=self.clearance_share * gap,
            min_probability=_CERTAIN,
            extra=problem.extra_clearance,
            standing_share=clearance.standing,
        )


def _somebody_ahead(problem: LocalProblem) -> bool:
    """Check whether there is somebody near in the direction of motion."""
    away = problem.people.mean[:, :2] - problem.pose[:2]
    distance = np.hypot(away[:, 0], away[:, 1])
    course = math.copysign(1.0, problem.twist[0])
    ahead = course * (away @ np.array([math.cos(problem.pose[2]), math.sin(problem.pose[2])]))
    return bool(((ahead > 0.5 * distance) & (distance < _NEAR)).any())


def _contact(problem: LocalProblem, poses: Floats, step: float, margins: ContactMargins) -> float:
    """Time of the first contact of poses (k, 3), s; +inf: none."""
    return first_contact(
        problem.robot,
        poses,
        step,
        people=problem.people,
        predictions=problem.predictions,
        walls=problem.walls,
        margins=margins,
    )


@njit(cache=True)
def _return(
    people: Floats,
    times: Floats,
    walked: Booleans,
    delay: float,
    acceleration: float,
    top_speed: float,
) -> tuple[Floats, Floats]:
    """(positions, velocities), (n, 1, N+1, 2) each, of people (n, 4) who turn back.

    times: (N+1,) since the measurement, s.  walked: (n,) people who have walked lately.  See
    ``Verification._turned_back``.
    """
    count, states = people.shape[0], times.shape[0]
    mean, velocity = np.empty((count, 1, states, 2)), np.empty((count, 1, states, 2))
    for i in range(count):
        speed = math.hypot(people[i, 2], people[i, 3])
        return_speed = max(speed, min(_FASTER * speed, top_speed))
        for k in range(states):
            # s: distance along the former direction, braking, then back at a constant speed
            elapsed = delay + times[k]
            turning = min(elapsed, (speed + return_speed) / acceleration)
            s = speed * turning - 0.5 * acceleration * (turning * turning)
            s -= return_speed * (elapsed - turning)
            s -= speed * delay
            v = -return_speed if elapsed > turning else speed - acceleration * turning
            if not walked[i]:
                s, v = 0.0, 0.0
            for a in range(2):
                unit = people[i, 2 + a] / max(speed, 1e-9)
                mean[i, 0, k, a] = people[i, a] + s * unit
                velocity[i, 0, k, a] = v * unit
    return mean, velocity
