"""The last stage before the wheels: whatever the planner says, these rules hold.

    input       older than its limit, not a number, a clock or a pose that jumps    → stop
    rider       STOP pressed, device silent                                         → stop
    limits      more than the chair allows                                          → bounded
    separation  something inside the stopping distance                              → scaled, stop

Each with its ``Reason``; the first two are in ``safety.trust``. The gate knows no planner; it sees
the observation, the map's and the sensors' obstacles, the people, and the twist that is wanted.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.maps import DistanceField
from cohelm.messages import Decision, Mode, Observation, People, Predictions, Reason, Request
from cohelm.robots import Robot
from cohelm.robots.contact import braking, first_contact

_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Of the wanted twist: the first after which the chair can brake without a touch is taken."""
_STEP = 0.05
"""Between the poses of the braking that is looked at, s."""


class GateParameters(Model):
    """Limits of the gate; all assumed."""

    scan_limit: float = Field(0.35, gt=0.0, le=5.0)
    """Greatest age of the newest scan or cloud of any one sensor, s."""
    pose_limit: float = Field(0.3, gt=0.0, le=5.0)
    """Greatest age of the pose, s."""
    twist_limit: float = Field(0.2, gt=0.0, le=5.0)
    """Greatest age of the odometry, s."""
    rider_limit: float = Field(0.3, gt=0.0, le=5.0)
    """Greatest age of the device's heartbeat, s."""
    late_limit: float = Field(0.15, gt=0.0, le=5.0)
    """Greatest lateness of a tick, s."""
    jump: float = Field(0.25, gt=0.0, le=10.0)
    """Change of pose beyond what the speed explains that is a jump, m."""
    jump_angle: float = Field(0.35, gt=0.0, le=math.pi)
    """The same for the heading, rad."""
    jump_hold: float = Field(0.5, ge=0.0, le=10.0)
    """How long the chair stands after a jump, s."""
    blind_share: float = Field(0.5, gt=0.0, le=1.0)
    """Share of a scan's beams that are not a number at which the scan counts for nothing; a cloud
    does where none of its points is one."""
    separation: bool = True
    """Whether things inside the stopping distance stop the chair; off for blind baselines only."""
    reaction: float = Field(0.2, ge=0.0, le=2.0)
    """How long a command is assumed to act before braking begins, s: a tick and the drive's lag."""
    margin: float = Field(0.01, ge=0.0, le=1.0)
    """Gap to a wall that counts as contact, m."""
    margin_time: float = Field(0.1, ge=0.0, le=1.0)
    """By how much that gap grows with the speed of the command, s, where the rider steers and no
    planner keeps away from walls: the pose is wrong by centimetres, and what is on the map is met
    where it really is."""
    people_margin: float = Field(0.12, ge=0.0, le=1.0)
    """Gap to a person that counts as contact, m."""
    standing: float = Field(0.4, ge=0.0, le=1.0)
    """Share of that which counts for who stands."""
    at_least: float = Field(0.5, ge=0.0, le=1.0)
    """Probability from which on a future counts that is not a person's likeliest; what is less
    likely is the planner's to weigh."""


def gate(
    wanted: Floats,
    observation: Observation,
    request: Request,
    robot: Robot,
    *,
    walls: DistanceField,
    people: People,
    predictions: Predictions,
    parameters: GateParameters,
) -> Decision:
    """What of the wanted twist (3,) goes to the wheels, in a usable observation.

    The greatest share after which ordinary braking touches nothing; see ``robots.contact``.
    In ``Mode.MANUAL`` only numbers and limits are checked: the rider alone answers for distance.
    """
    if not np.isfinite(wanted).all():
        return stop(Reason.NOT_FINITE)
    allowed = _within_limits(wanted, robot, request.speed_limit)
    bounded = not bool((np.abs(allowed - wanted) <= 1e-6).all())
    reason = Reason.OVER_LIMITS if bounded else None
    now = robot.motion.input(observation.twist)
    stands = not (allowed.any() or now.any())
    if request.mode is Mode.MANUAL or not parameters.separation or stands:
        return Decision(twist=allowed, reason=reason)
    hasty = parameters.margin_time if request.mode is Mode.ASSISTED else 0.0
    for share in _SHARES:
        poses = braking(
            robot,
            observation.pose,
            now,
            share * robot.motion.input(allowed),
            hold=parameters.reaction,
            deceleration=robot.max_deceleration,
            step=_STEP,
        )
        contact = first_contact(
            robot,
            poses,
            _STEP,
            people=people,
            predictions=predictions,
            walls=walls,
            margin=parameters.margin + hasty * share * float(np.hypot(*allowed[:2])),
            people_margin=min(parameters.people_margin + max(request.farther, 0.0), 1.0),
            at_least=parameters.at_least,
            standing=parameters.standing,
        )
        if contact == math.inf:
            if share < 1.0:
                reason = Reason.TOO_CLOSE if share > 0.0 else Reason.BLOCKED
            return Decision(twist=share * allowed, reason=reason)
    return stop(Reason.BLOCKED)


def stop(reason: Reason) -> Decision:
    """Zero at the wheels; hard braking where the senses cannot be trusted or STOP is pressed."""
    gentle = reason in _GENTLE
    return Decision(twist=np.zeros(3), reason=reason, emergency=not gentle)


_GENTLE = frozenset(
    {
        Reason.RIDER_SILENT,
        Reason.NO_SAFE_PLAN,
        Reason.SOLVER_FAILED,
        Reason.START_BLOCKED,
        Reason.GOAL_BLOCKED,
        Reason.OUTSIDE_MAP,
        Reason.KEEPOUT,
        Reason.NO_PATH,
        Reason.TOO_MANY_WISHES,
        Reason.INVALID_PROBLEM,
        Reason.PLANNING_TIMEOUT,
        Reason.PLANNING,
        Reason.ARRIVED,
        Reason.WAITING,
        Reason.REPLANNING,
        Reason.BACKING_UP,
        Reason.CREEPING,
        Reason.ASK_RIDER,
    }
)
"""The senses can be trusted and nobody presses STOP: ordinary braking will do."""


def _within_limits(wanted: Floats, robot: Robot, speed_limit: float) -> Floats:
    low, high, _, _ = robot.input_bounds
    allowed = robot.motion.twist(np.clip(robot.motion.input(wanted), low, high))
    speed, limit = float(np.hypot(*allowed[:2])), max(0.0, speed_limit)  # NaN allows nothing
    if speed > limit:
        allowed = allowed * (limit / speed)
    return allowed
