"""Verification of a trajectory before it is used: slack in the optimisation is not safety.

A trajectory is used only if it stays clear of people and walls for a while, swept between its
steps, and if braking after its first command helps as much as braking at once.
People may turn back: that is possible, but not expected.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, unchecked
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.unaware import near_ahead
from cohelm.geometry import wrap_angle
from cohelm.kernels import CACHED
from cohelm.messages import People, Predictions
from cohelm.robots.braking import braking
from cohelm.robots.clearance import CLOSEST, Clearance
from cohelm.robots.contact import contact_times, first_contact
from cohelm.robots.contact_kernel import ContactMargins

TURN_DELAY = 0.25
"""Delay until a turn is detected, s: two scans and the filter."""
RETURN_SPEED = 1.0
"""Maximum return speed of people who are measured as slower, m/s: a turning person is."""
_FASTER = 4.0
"""Assumed return speed as a multiple of the measured speed, up to ``RETURN_SPEED``."""
_WALKED = 0.5
"""People who have been slower than this lately are assumed not to turn back, m/s: tracking noise is
up to 0.3 m/s."""


def turned_back(
    people: People,
    given: Predictions,
    speeds: Floats,
    *,
    acceleration: float,
) -> Predictions:
    """Predictions of all people walking back, since a turn that is not detected yet.

    Who has stood for a while stays. The measured position is that of a person who walked on; the
    turn has taken them behind it.

    Args:
        people: as measured.
        given: predictions of these people.
        speeds: (n,) of people lately, m/s.
        acceleration: of a turn, m/s².
    """
    mean, velocity = _return(
        people.mean,
        np.asarray(given.step * np.arange(given.mean.shape[2]), dtype=float),
        speeds > _WALKED,
        TURN_DELAY,
        acceleration,
        RETURN_SPEED,
    )
    return unchecked(
        given,
        names=("turned_back",),
        weight=np.ones((len(mean), 1)),
        mean=mean,
        velocity=velocity,
        deviation=np.zeros(mean.shape[:3]),
    )


@njit(**CACHED)
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
    :func:`turned_back`.
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


_FINE = 0.05
"""Time between the poses of a verified braking, s."""
_NEAR = 2.0
"""Distance up to which a person ahead is near, m."""
REACTION = 0.2
"""Time for which a command acts before braking can begin, s: a tick, the drive's lag, a reserve."""
MIN_PROBABILITY = 0.1
"""Probability from which emergency braking must also keep clear of a hypothesis that is not the
most likely one. Predictors list several that are less probable."""
_STALLED_WALL_SHARE = 0.6
"""Share of the gap to a wall while the ride is stalled: a creeping robot needs less, and still more
than the safety gate's 0.01 m."""
_STALLED_SHARE = 0.5
"""Share of the horizon while the ride is stalled: a creeping robot stops within 0.12 m, and sees
the gap to a person only when it is there."""
_DEVIATION_TIME = 2.5
"""Time for which the heading of a trajectory must be that of the reference, s; later it may lead
round a corner."""
_DEVIATION_NOW = 0.02
"""Increase of a deviation that is too large already, rad."""
_REACHED = 0.08
"""Gap at which a person reaches a robot that stops, m: a tenth of a second of walking."""
_TICK = 0.05
"""Time by which a stop should end before a person reaches the robot, s."""
_SURE = 4.0
"""Time on a course after which the brakes are used hard, as a multiple of that for comfort."""
_CERTAIN = 1.0
"""Minimum probability at which only the most likely hypothesis of each person counts."""


class Verification(Model):
    """Margins and horizon of the verification; assumed. See ``robots.clearance`` for people."""

    wall_margin: float = Field(0.02, ge=0.0)
    """Gap to a wall that counts as contact, m; less while the ride is stalled."""
    clearance_share: float = Field(1.0, ge=0.0, le=2.0)
    """Share of the clearance that a trajectory must keep from people."""
    people_acceleration: float = Field(2.0, ge=0.0)
    """Possible change of a walking person's velocity, m/s²; of a standing person's, the share
    ``clearance.standing`` of it. Emergency braking must keep clear of all that they can reach."""
    turn_back_acceleration: float = Field(6.0, ge=0.0)
    """Acceleration of walking people who turn back, m/s²: emergency braking must keep clear of all
    of them, however unlikely it is; 0: only predicted turns count. A person who walks at 1.1 m/s
    has turned within 0.4 s."""
    turn_back_margin: float = Field(0.1, ge=0.0)
    """Gap to a person who turns back that counts as contact, m."""
    horizon: float = Field(2.0, gt=0.0)
    """Time for which a trajectory must be free of contact, s; braking is checked in any case."""
    unaware_after: float = Field(0.1, ge=0.0)
    """Time on a course into the robot after which a person does not see it, s. The robot stands
    before such people reach it, also from behind. A small value brakes for people who are about to
    step aside, a large one for nobody who follows."""

    def wall_margin_of(self, problem: LocalProblem) -> float:
        """Gap to a wall that counts as contact in a problem, m."""
        return self.wall_margin * (_STALLED_WALL_SHARE if problem.stalled else 1.0)

    def horizon_of(self, problem: LocalProblem) -> float:
        """Time for which a trajectory must be free of contact in a problem, s."""
        return self.horizon * (_STALLED_SHARE if problem.stalled else 1.0)

    def verifier(
        self,
        problem: LocalProblem,
        clearance: Clearance,
        current_input: Floats,
        speeds: Floats,
        courses: Floats,
        paces: Floats | None = None,
    ) -> Verifier:
        """Create the checks of the trajectories of one problem.

        Args:
            problem: the present problem.
            clearance: from people.
            current_input: u_{−1}, (m,).
            speeds: (n,) of people lately, m/s.
            courses: (n,) times for which people have been on a course into the robot, s.
            paces: (n,) see ``planner_memory.recent_paces``, m/s; None: as ``speeds``.
        """
        law = clearance.law(tight=problem.stalled)
        margins = ContactMargins(
            wall=self.wall_margin_of(problem),
            people=self.clearance_share * law.now,
            growth=self.clearance_share * law.growth,
            upper=self.clearance_share * law.upper,
            min_probability=_CERTAIN,
            extra=problem.extra_clearance,
            standing_share=clearance.standing,
        )
        returning = None
        if self.turn_back_acceleration > 0.0 and not problem.stalled and len(problem.people):
            # a robot that squeezes past is too slow to escape
            returning = turned_back(
                problem.people,
                problem.predictions,
                speeds,
                acceleration=self.turn_back_acceleration,
            )
        return Verifier(
            self, problem, current_input, margins,
            returning=returning, paces=speeds if paces is None else paces, courses=courses,
        )  # fmt: skip


class Verifier:
    """Checks of the trajectories of one problem.

    A trajectory may be used if it is swept clear of walls and of the most likely hypothesis of each
    person for a while, turns from the reference by no more than ``max_deviation``, and if after its
    first command the brakes still help as much as now: the robot, braking hard, touches nothing
    that people may do (accelerate, take a less likely way, turn back), or no sooner than if it
    brakes hard at once. Who follows, or whom no braking avoids, vetoes nothing but while unaware of
    the robot and about to walk into it. A stop need not be clear, but braking must still help.
    """

    def __init__(
        self,
        rules: Verification,
        problem: LocalProblem,
        current_input: Floats,
        margins: ContactMargins,
        *,
        returning: Predictions | None,
        paces: Floats,
        courses: Floats,
    ) -> None:
        self.rules, self.problem, self.current_input = rules, problem, current_input
        self.paces = paces
        self.margins, self.returning = margins, returning
        self.unaware = courses >= rules.unaware_after
        self.surely_unaware = courses >= _SURE * rules.unaware_after
        self._now: dict[float, Floats] = {}

    def accepts(self, trajectory: Trajectory) -> bool:
        """Check a trajectory."""
        return (
            not self._deviates(trajectory)
            and self.contact(trajectory) >= self.rules.horizon_of(self.problem)
            and self.brakes_help(trajectory)
            and self._may_brake(trajectory.inputs[0])
            and self._clears_or_stands(trajectory)
        )

    def contact(self, trajectory: Trajectory) -> float:
        """Time at which a trajectory touches a wall or what is expected of people, s; or ∞."""
        arguments = self._scene(self.problem.predictions, self.margins)
        return first_contact(self.problem.robot, trajectory.poses, trajectory.step, **arguments)

    def _deviates(self, trajectory: Trajectory) -> bool:
        """Check for a turn farther from the reference than allowed."""
        limit = self.problem.max_deviation
        if limit == math.inf:
            return False
        reference = self.problem.reference
        count = min(
            1 + round(_DEVIATION_TIME / trajectory.step),
            len(trajectory.poses),
            len(reference.poses),
        )
        off = np.abs(wrap_angle(trajectory.poses[:count, 2] - reference.poses[:count, 2]))
        return bool(off.max() > max(limit, float(off[0]) + _DEVIATION_NOW))

    def _may_brake(self, command: Floats) -> bool:
        """Check that comfort braking after ``command`` (m,) touches nothing.

        No less strict than the gate, see ``tests/safety/test_planner_margins.py``.
        """
        poses = self._braking(command, self.problem.robot.max_deceleration)
        closest = CLOSEST * self.margins.people
        margins = self.margins._replace(people=closest, growth=0.0, followers=False)
        return bool((self._contacts(poses, self.problem.predictions, margins) == np.inf).all())

    def _clears_or_stands(self, trajectory: Trajectory) -> bool:
        """Check that nobody who does not see the robot walks into it while it moves.

        Whom comfort braking after the first command would meet in motion rejects a trajectory if
        braking at once would meet them standing, or if the trajectory itself leads into them. Those
        who follow count, too: a robot that stands hurts nobody.
        """
        if not self.unaware.any():
            return True
        deceleration = self.problem.robot.max_deceleration
        reached = self._reached(trajectory.inputs[0], deceleration)
        if not reached.any():
            return True
        times = self._contacts(trajectory.poses, self._sooner, self._reach, step=trajectory.step)
        met = times[1:] < self.rules.horizon_of(self.problem)
        at_once = self._reached(np.zeros_like(self.current_input), deceleration)
        return not (reached & (met | ~at_once)).any()

    def stands_in_time(self, stop: Trajectory) -> bool:
        """Check that a stop ends before a wall, and before any person reaches the robot."""
        return bool((self._contacts_of_stop(stop) == np.inf).all())

    def only_hard_braking_helps(self, stop: Trajectory) -> bool:
        """Check that a person who does not see the robot walks into it unless it brakes hard.

        Hard braking must not end at a wall: its turn ends sooner than that of a gentler stop.
        """
        if not self.surely_unaware.any():
            return False
        met = self.surely_unaware & (self._contacts_of_stop(stop)[1:] < np.inf)
        if not met.any():
            return False
        hard = self.problem.robot.emergency_deceleration
        contacts = self._braking_contacts(np.zeros_like(self.current_input), hard)
        helped = met & (contacts[1:] == np.inf)
        return bool(helped.any() and contacts[0] == np.inf)

    def _contacts_of_stop(self, stop: Trajectory) -> Floats:
        """Times (1 + n,) of the contacts of a stop, which the drive executes later, s."""
        given = self.problem.predictions
        later = unchecked(given, mean=given.mean + (REACTION + _TICK) * given.velocity)
        return self._contacts(stop.poses, later, self._reach, step=stop.step)

    def _reached(self, command: Floats, deceleration: float) -> Booleans:
        """Mask (n,) of unaware people who reach the robot while it brakes after ``command``."""
        return self.unaware & (self._braking_contacts(command, deceleration)[1:] < np.inf)

    def _braking_contacts(self, command: Floats, deceleration: float) -> Floats:
        """Times (1 + n,) of the contacts while the robot brakes after ``command`` (m,), s."""
        return self._contacts(self._braking(command, deceleration), self._sooner, self._reach)

    @cached_property
    def _sooner(self) -> Predictions:
        """Predictions of people who are a tick ahead of time."""
        given = self.problem.predictions
        return unchecked(given, mean=given.mean + _TICK * given.velocity)

    @property
    def _reach(self) -> ContactMargins:
        return self.margins._replace(people=_REACHED, growth=0.0, leaving=True)

    def brakes_help(self, trajectory: Trajectory, share: float = 1.0) -> bool:
        """Check that hard braking after the first command is as good as at once.

        Args:
            trajectory: its first command counts.
            share: of the gap to people that must be kept. A person too close to drive on is no
                reason for hard braking yet.
        """
        command = trajectory.inputs[0]
        later = self._contacts_if_braking(command, share)
        if (later == np.inf).all():
            return True
        if share not in self._now:
            self._now[share] = self._contacts_if_braking(np.zeros_like(command), share)
        now = self._now[share]
        # As good: a contact comes later than after braking at once, or never, or at the same time
        # with what is not ahead. Ahead, braking at once would touch more slowly.
        return bool(((later > now) | (later == np.inf) | ((later == now) & ~self._ahead)).all())

    def _contacts_if_braking(self, command: Floats, share: float) -> Floats:
        """Times (1 + n,) of the contacts if the robot brakes hard after ``command`` (m,), s."""
        problem, rules = self.problem, self.rules
        poses = self._braking(command, problem.robot.emergency_deceleration)
        margins = self.margins._replace(
            people=share * self.margins.people,
            growth=share * self.margins.growth,
            upper=share * self.margins.upper,
            followers=False,
        )
        if share <= 0.0:  # what is possible but not expected needs no hard braking
            return self._contacts(poses, problem.predictions, margins)
        soonest = self._contacts(
            poses,
            problem.predictions,
            margins._replace(
                acceleration=rules.people_acceleration, min_probability=MIN_PROBABILITY
            ),
        )
        if self.returning is None:
            return soonest
        turned = margins._replace(people=share * rules.turn_back_margin, growth=0.0)
        return np.minimum(soonest, self._contacts(poses, self.returning, turned))

    def _braking(self, command: Floats, deceleration: float) -> Floats:
        """Poses (k, 3) of braking after ``command`` (m,)."""
        problem = self.problem
        return braking(
            problem.robot,
            problem.pose,
            self.current_input,
            command,
            hold=REACTION,
            deceleration=deceleration,
            step=_FINE,
        )

    def _contacts(
        self,
        poses: Floats,
        predictions: Predictions,
        margins: ContactMargins,
        step: float = _FINE,
    ) -> Floats:
        """Times (1 + n,) of the contacts of poses (k, 3), s; +inf: none."""
        arguments = self._scene(predictions, margins)
        return contact_times(self.problem.robot, poses, step, **arguments)

    def _scene(self, predictions: Predictions, margins: ContactMargins) -> dict[str, Any]:
        known = {"people": self.problem.people, "walls": self.problem.walls}
        return {**known, "predictions": predictions, "margins": margins, "paces": self.paces}

    @cached_property
    def _ahead(self) -> Booleans:
        """Mask (1 + n,) of walls and near people ahead: they are at least met slowly."""
        return np.concatenate([[True], near_ahead(self.problem, _NEAR)])
