"""The last stage before the wheels: whatever the planner says, these rules hold.

    input       older than its limit, not a number, a clock or a pose that jumps    → stop
    rider       STOP pressed, device silent                                         → stop
    limits      more than the chair allows                                          → bounded
    separation  something inside the stopping distance                              → scaled, stop

Each with its ``Reason``. The gate knows no planner; it sees the observation, the map's and the
sensors' obstacles, the people, and the twist that is wanted.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.geometry import wrap_angle
from cohelm.maps import DistanceField
from cohelm.messages import Decision, Mode, Observation, People, Predictions, Reason, Request
from cohelm.robots import Robot
from cohelm.robots.contact import braking, first_contact

_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Of the wanted twist: the first after which the chair can brake without a touch is taken."""
_STEP = 0.05
"""Between the poses of the braking that is looked at, s."""
_UNDERRATED = 2.0
"""How many times the motion that odometry tells a pose may move without having jumped."""
_ROUNDING = 1e-6  # s; times are sums of float steps: what is exactly at its limit is still good


class GateParameters(Model):
    """Limits of the gate; all assumed."""

    scan_limit: float = Field(0.35, gt=0.0, le=5.0)
    """Greatest age of the newest scan, s."""
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
    """Share of a scan's beams that are not a number at which the scan counts for nothing."""
    separation: bool = True
    """Whether things inside the stopping distance stop the chair; off for blind baselines only."""
    reaction: float = Field(0.2, ge=0.0, le=2.0)
    """How long a command is assumed to act before braking begins, s: a tick and the drive's lag."""
    margin: float = Field(0.02, ge=0.0, le=1.0)
    """Gap to a wall that counts as contact, m."""
    people_margin: float = Field(0.12, ge=0.0, le=1.0)
    """Gap to a person that counts as contact, m."""


@value
class GateState:
    """What the gate remembers."""

    time: float
    scan_time: float
    """Of the newest usable scan, s."""
    pose: Annotated[Floats, Shape("3")]
    """The last one believed."""
    pose_time: float
    held_until: float = -math.inf
    """The chair stands until then after a jump, s."""


def check_input(
    observation: Observation,
    request: Request,
    robot: Robot,
    memory: GateState | None,
    parameters: GateParameters,
) -> tuple[Reason | None, GateState]:
    """Whether the observation can be used at all: the reason why not, and the gate's memory.

    To be asked before anything is computed from the observation.
    """
    if _not_finite(observation):
        return Reason.NOT_FINITE, memory or _first_state(observation, usable=False)
    memory = memory or _first_state(observation, usable=True)
    if _blinded(observation, parameters):
        # until a scan can be used again, what was seen before counts for nothing
        return Reason.NOT_FINITE, replace(memory, scan_time=-math.inf)
    if observation.time < memory.time or _from_the_future(observation, parameters):
        return Reason.CLOCK, memory
    scan_time = max([memory.scan_time, *(s.time for s in observation.scans)])
    held_until = memory.held_until
    if _jumped(observation, memory, parameters):
        held_until = observation.time + parameters.jump_hold
    state = GateState(
        time=observation.time,
        scan_time=scan_time,
        pose=observation.pose,
        pose_time=observation.pose_time,
        held_until=held_until,
    )
    return _stale(observation, request, robot, state, parameters), state


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
    bounded = not np.allclose(allowed, wanted, rtol=0.0, atol=1e-6)
    reason = Reason.OVER_LIMITS if bounded else None
    now = robot.motion.input(observation.twist)
    stands = not (allowed.any() or now.any())
    if request.mode is Mode.MANUAL or not parameters.separation or stands:
        return Decision(twist=allowed, reason=reason)
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
            margin=parameters.margin,
            people_margin=parameters.people_margin,
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
    }
)
"""The senses can be trusted and nobody presses STOP: ordinary braking will do."""


def _not_finite(observation: Observation) -> bool:
    rider = observation.rider
    numbers = [
        np.array([observation.time, observation.pose_time, observation.twist_time]),
        np.array([observation.late]),
        observation.pose,
        observation.twist,
        *(
            np.array([s.time, s.angle_min, s.angle_increment, s.range_max, *s.mount])
            for s in observation.scans
        ),
    ]
    if rider is not None:
        numbers.append(np.append(rider.deflection, rider.heartbeat))
    if observation.people is not None:
        numbers += _numbers_of(observation.people)
    return not all(np.isfinite(n).all() for n in numbers)


def _blinded(observation: Observation, p: GateParameters) -> bool:
    """NaN is a dropout, −inf something on the glass; +inf says that the beam is free (REP-117)."""
    return any(
        len(s.ranges) == 0 or (~(s.ranges > -np.inf)).mean() >= p.blind_share
        for s in observation.scans
    )


def _numbers_of(people: People) -> list[Floats]:
    """All that must be finite of people given from outside; a heading may be unknown (NaN)."""
    return [
        np.array([people.time]),
        people.mean,
        people.covariance,
        people.heading[~np.isnan(people.heading)],
        people.radius,
        people.confidence,
    ]


def _from_the_future(observation: Observation, p: GateParameters) -> bool:
    """Whether a stamp is further ahead than it may be old: it would keep a dead sensor fresh."""
    rider = observation.rider
    stamps = [
        (observation.pose_time, p.pose_limit),
        (observation.twist_time, p.twist_limit),
        *((s.time, p.scan_limit) for s in observation.scans),
        *([] if rider is None else [(rider.heartbeat, p.rider_limit)]),
    ]
    return any(stamp - observation.time > limit + _ROUNDING for stamp, limit in stamps)


def _stale(
    observation: Observation,
    request: Request,
    robot: Robot,
    state: GateState,
    p: GateParameters,
) -> Reason | None:
    """The first thing that is too old, too late, or says stop."""
    now, rider = observation.time, observation.rider
    needs_rider = request.mode in {Mode.MANUAL, Mode.ASSISTED}
    looks = bool(robot.lasers) and observation.people is None
    rules = (
        (request.stop, Reason.RIDER_STOP),
        (observation.late > p.late_limit + _ROUNDING, Reason.LATE),
        (now < state.held_until - _ROUNDING, Reason.POSE_JUMP),
        (now - observation.pose_time > p.pose_limit + _ROUNDING, Reason.STALE_POSE),
        (now - observation.twist_time > p.twist_limit + _ROUNDING, Reason.STALE_TWIST),
        (looks and now - state.scan_time > p.scan_limit + _ROUNDING, Reason.STALE_SCAN),
        (rider is None and needs_rider, Reason.RIDER_SILENT),
        (
            rider is not None and now - rider.heartbeat > p.rider_limit + _ROUNDING,
            Reason.RIDER_SILENT,
        ),
    )
    return next((reason for holds, reason in rules if holds), None)


def _jumped(observation: Observation, memory: GateState, p: GateParameters) -> bool:
    """Whether the pose moved more than speed and time explain."""
    elapsed = max(observation.pose_time - memory.pose_time, 0.0)
    moved = float(np.hypot(*(observation.pose[:2] - memory.pose[:2])))
    turned = abs(float(wrap_angle(observation.pose[2] - memory.pose[2])))
    speed, turn = float(np.hypot(*observation.twist[:2])), abs(float(observation.twist[2]))
    return bool(
        moved > p.jump + _UNDERRATED * speed * elapsed
        or turned > p.jump_angle + _UNDERRATED * turn * elapsed
    )


def _within_limits(wanted: Floats, robot: Robot, speed_limit: float) -> Floats:
    low, high, _, _ = robot.motion.bounds(robot.limits)
    allowed = robot.motion.twist(np.clip(robot.motion.input(wanted), low, high))
    speed, limit = float(np.hypot(*allowed[:2])), max(0.0, speed_limit)  # NaN allows nothing
    if speed > limit:
        allowed = allowed * (limit / speed)
    return allowed


def _first_state(observation: Observation, *, usable: bool) -> GateState:
    """The first tick has nothing to compare with; scans get their time limit to arrive."""
    if not usable:
        return GateState(time=-math.inf, scan_time=-math.inf, pose=np.zeros(3), pose_time=-math.inf)
    return GateState(
        time=observation.time,
        scan_time=observation.time,
        pose=observation.pose,
        pose_time=observation.pose_time,
    )
