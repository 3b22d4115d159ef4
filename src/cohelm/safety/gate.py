"""Safety gate: the last stage before the wheels; its rules hold for every planner.

    input       older than its limit, not a number, a clock or a pose that jumps    → stop
    rider       STOP pressed, device silent                                         → stop
    limits      more than the chair allows                                          → bounded
    separation  an obstacle inside the stopping distance                            → scaled, stop

Each rule has its ``Reason``; the first two are in ``safety.input_check``. The gate sees the
observation, the obstacles of map and sensors, the people, and the requested twist.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.maps import DistanceField
from cohelm.messages import Decision, Mode, Observation, People, Predictions, Reason, Request
from cohelm.robots import Robot
from cohelm.robots.braking import braking
from cohelm.robots.clearance import CLOSEST, Clearance
from cohelm.robots.contact import first_contact
from cohelm.robots.contact_kernel import ContactMargins

_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Shares of the requested twist; the first one that allows braking without contact is used."""
_STEP = 0.05
"""Time between the poses of the predicted braking, s."""


class GateParameters(Model):
    """Limits of the gate; all assumed."""

    scan_limit: float = Field(0.35, gt=0.0, le=5.0)
    """Maximum age of the newest scan or cloud of each sensor, s."""
    pose_limit: float = Field(0.3, gt=0.0, le=5.0)
    """Maximum age of the pose, s."""
    twist_limit: float = Field(0.2, gt=0.0, le=5.0)
    """Maximum age of the odometry, s."""
    rider_limit: float = Field(0.3, gt=0.0, le=5.0)
    """Maximum age of the device's heartbeat, s."""
    late_limit: float = Field(0.15, gt=0.0, le=5.0)
    """Maximum lateness of a tick, s."""
    jump: float = Field(0.25, gt=0.0, le=10.0)
    """Change of pose beyond what the speed explains that is a jump, m."""
    jump_angle: float = Field(0.35, gt=0.0, le=math.pi)
    """Change of heading beyond what the turn rate explains that is a jump, rad."""
    jump_hold: float = Field(0.5, ge=0.0, le=10.0)
    """Standstill after a jump, s."""
    blind_share: float = Field(0.5, gt=0.0, le=1.0)
    """Share of beams without a number from which a scan is unusable; a cloud is unusable without
    any finite point."""
    separation: bool = True
    """Stop for obstacles inside the stopping distance; off only for blind baselines."""
    reaction: float = Field(0.2, ge=0.0, le=2.0)
    """Time for which a command acts before braking begins, s: a tick and the drive's lag."""
    wall_margin: float = Field(0.01, ge=0.0, le=1.0)
    """Gap to a wall that counts as contact, m."""
    wall_margin_time: float = Field(0.1, ge=0.0, le=1.0)
    """Growth of that gap with the commanded speed, s, in the modes in which no planner keeps
    clear of walls: pose and map are wrong by centimetres."""
    min_probability: float = Field(0.5, ge=0.0, le=1.0)
    """Probability from which a hypothesis counts that is not a person's most likely one; the
    planner weighs the others."""


def gate(
    wanted: Floats,
    observation: Observation,
    request: Request,
    robot: Robot,
    *,
    walls: DistanceField,
    people: People,
    predictions: Predictions,
    clearance: Clearance,
    parameters: GateParameters,
) -> Decision:
    """Decide which part of the requested twist (3,) goes to the wheels; the observation is usable.

    It is the largest share after which comfort braking touches nothing, see ``robots.contact``; if
    there is none, hard braking, unless a share delays the contact more than that.
    In ``Mode.MANUAL`` only numbers and limits are checked: distance is the rider's responsibility.
    """
    requested: list[float] = wanted.tolist()
    if not all(map(math.isfinite, requested)):
        return stop(Reason.NOT_FINITE)
    allowed = _within_limits(wanted, robot, request.speed_limit)
    kept = zip(allowed.tolist(), requested, strict=True)
    reason = None if all(abs(a - b) <= 1e-6 for a, b in kept) else Reason.OVER_LIMITS
    now = robot.motion_model.input(observation.twist)
    stands = not (allowed.any() or now.any())
    if request.mode is Mode.MANUAL or not parameters.separation or stands:
        return Decision(twist=allowed, reason=reason)
    contact = functools.partial(
        _contact,
        observation=observation,
        request=request,
        robot=robot,
        walls=walls,
        people=people,
        predictions=predictions,
        clearance=clearance,
        parameters=parameters,
    )
    latest, best = 0.0, 0.0
    for share in _SHARES:
        time = contact(share * allowed, robot.max_deceleration)
        if time > latest:
            latest, best = time, share
        if time == math.inf:
            if share < 1.0:
                reason = Reason.TOO_CLOSE if share > 0.0 else Reason.BLOCKED
            return Decision(twist=share * allowed, reason=reason)
    if best > 0.0 and latest > contact(np.zeros(3), robot.emergency_deceleration):
        return Decision(twist=best * allowed, reason=reason if best == 1.0 else Reason.TOO_CLOSE)
    return stop(Reason.BLOCKED)


def _contact(
    allowed: Floats,
    deceleration: float,
    *,
    observation: Observation,
    request: Request,
    robot: Robot,
    walls: DistanceField,
    people: People,
    predictions: Predictions,
    clearance: Clearance,
    parameters: GateParameters,
) -> float:
    """Time of the first contact if the robot brakes after a twist, s; +inf: none."""
    growth = parameters.wall_margin_time if request.mode.rider_drives else 0.0
    poses = braking(
        robot,
        observation.pose,
        robot.motion_model.input(observation.twist),
        robot.motion_model.input(allowed),
        hold=parameters.reaction,
        deceleration=deceleration,
        step=_STEP,
    )
    margins = ContactMargins(
        wall=parameters.wall_margin + growth * _speed(allowed),
        people=CLOSEST * clearance.now,
        extra=max(request.extra_clearance, 0.0),
        min_probability=parameters.min_probability,
        standing_share=clearance.standing,
        followers=False,
    )
    return first_contact(
        robot, poses, _STEP, people=people, predictions=predictions, walls=walls, margins=margins
    )


def stop(reason: Reason) -> Decision:
    """Zero twist, by emergency braking unless the reason is one of ``_GENTLE``."""
    return Decision(twist=np.zeros(3), reason=reason, emergency=reason not in _GENTLE)


_GENTLE = frozenset(
    {
        Reason.STALE_RIDER_COMMAND,
        Reason.STICK_STUCK,
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
        Reason.GOAL_OCCUPIED,
        Reason.REPLANNING,
        Reason.BACKING_UP,
        Reason.REVERSING,
        Reason.CREEPING,
        Reason.ASK_RIDER,
    }
)
"""Reasons for comfort braking: the sensors are trusted, nothing is near and nobody wants a stop.

A new reason brakes hard until it is listed. Hard are also a stick that is pulled back (the rider
wants to stand, or backwards), an obstacle ahead, and whatever waits for the driver's word."""


def _within_limits(wanted: Floats, robot: Robot, speed_limit: float) -> Floats:
    low, high, _, _ = robot.input_bounds
    inputs = np.minimum(np.maximum(robot.motion_model.input(wanted), low), high)
    allowed = robot.motion_model.twist(inputs)
    speed, limit = _speed(allowed), max(0.0, speed_limit)  # NaN allows nothing
    if speed > limit:
        allowed = allowed * (limit / speed)
    return allowed


def _speed(twist: Floats) -> float:
    """Speed over the floor, m/s."""
    return float(np.hypot(twist[0], twist[1]))
