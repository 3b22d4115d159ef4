"""Whether what the chair is told can be trusted: numbers, clock, pose, and every sensor's age."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.geometry import wrap_angle
from cohelm.messages import Mode, Observation, People, PointCloud, Reason, Request, Scan
from cohelm.robots import Robot
from cohelm.safety.gate import GateParameters

_UNDERRATED = 2.0
"""How many times the motion that odometry tells a pose may move without having jumped."""
_IMPOSSIBLE = 5.0
"""A twist beyond so many times what the robot can do, in any direction, tells nothing: a wheel that
spins or a push downhill is less. Braking from it would be looked at over hours."""
_ROUNDING = 1e-6  # s; times are sums of float steps: what is exactly at its limit is still good


@value
class GateState:
    """What the gate remembers."""

    time: float
    heard: Annotated[Floats, Shape("s")]
    """Time of the newest usable scan or cloud of each of the robot's sensors, s."""
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
        return Reason.NOT_FINITE, memory or _first_state(observation, robot, usable=False)
    memory = memory or _first_state(observation, robot, usable=True)
    if _blinded(observation, parameters):
        # until a scan can be used again, what was seen before counts for nothing
        return Reason.NOT_FINITE, replace(memory, heard=_never(robot))
    if observation.time < memory.time or _from_the_future(observation, parameters):
        return Reason.CLOCK, memory
    held_until = memory.held_until
    most = _most(robot)
    if _jumped(observation, np.clip(observation.twist, -most, most), memory, parameters):
        held_until = observation.time + parameters.jump_hold
    state = GateState(
        time=observation.time,
        heard=_heard(observation, robot, memory.heard),
        pose=observation.pose,
        pose_time=observation.pose_time,
        held_until=held_until,
    )
    unknown = bool((np.abs(observation.twist) > most).any())
    return _stale(observation, request, state, parameters, unknown=unknown), state


def _not_finite(observation: Observation) -> bool:
    o, rider, people = observation, observation.rider, observation.people
    numbers = [o.time, o.pose_time, o.twist_time, o.late, *o.pose.tolist(), *o.twist.tolist()]
    for scan in o.scans:
        numbers += (scan.time, scan.angle_min, scan.angle_increment, scan.range_max)
        numbers += scan.mount.tolist()
    for cloud in o.clouds:
        numbers += (cloud.time, cloud.range_max)
        numbers += np.delete(cloud.mount, 2).tolist()  # at what height may be unknown
    if rider is not None:
        numbers += (*rider.deflection.tolist(), rider.heartbeat)
    if people is not None and not all(np.isfinite(n).all() for n in _numbers_of(people)):
        return True
    return not all(map(math.isfinite, numbers))


def _blinded(observation: Observation, p: GateParameters) -> bool:
    """NaN is a dropout, −inf something on the glass; +inf says that the beam is free (REP-117)."""
    scans = any(
        len(s.ranges) == 0 or (~(s.ranges > -np.inf)).mean() >= p.blind_share
        for s in observation.scans
    )
    # where a LiDAR points at the sky most rows are no numbers: only none at all is blind
    return scans or not all(np.isfinite(c.points).all(axis=1).any() for c in observation.clouds)


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
        *((c.time, p.scan_limit) for c in observation.clouds),
        *([] if rider is None else [(rider.heartbeat, p.rider_limit)]),
    ]
    return any(stamp - observation.time > limit + _ROUNDING for stamp, limit in stamps)


def _stale(
    observation: Observation,
    request: Request,
    state: GateState,
    p: GateParameters,
    *,
    unknown: bool,
) -> Reason | None:
    """The first thing that is too old, too late, or says stop; ``unknown``: the twist is."""
    now, rider = observation.time, observation.rider
    needs_rider = request.mode in {Mode.MANUAL, Mode.ASSISTED}
    looks = observation.people is None
    oldest = state.heard.min(initial=np.inf)
    rules = (
        (request.stop, Reason.RIDER_STOP),
        (observation.late > p.late_limit + _ROUNDING, Reason.LATE),
        (now < state.held_until - _ROUNDING, Reason.POSE_JUMP),
        (now - observation.pose_time > p.pose_limit + _ROUNDING, Reason.STALE_POSE),
        (
            unknown or now - observation.twist_time > p.twist_limit + _ROUNDING,
            Reason.STALE_TWIST,
        ),
        (looks and now - oldest > p.scan_limit + _ROUNDING, Reason.STALE_SCAN),
        (rider is None and needs_rider, Reason.RIDER_SILENT),
        (
            rider is not None and now - rider.heartbeat > p.rider_limit + _ROUNDING,
            Reason.RIDER_SILENT,
        ),
    )
    return next((reason for holds, reason in rules if holds), None)


def _most(robot: Robot) -> Floats:
    """Size of a twist (3,) from which on it cannot be one."""
    speed = max(robot.max_speed, robot.max_reverse_speed)
    return _IMPOSSIBLE * np.array([speed, speed, robot.max_turn_rate])


def _jumped(observation: Observation, twist: Floats, memory: GateState, p: GateParameters) -> bool:
    """Whether the pose moved more than speed and time explain."""
    elapsed = max(observation.pose_time - memory.pose_time, 0.0)
    moved = float(np.hypot(*(observation.pose[:2] - memory.pose[:2])))
    turned = abs(float(wrap_angle(observation.pose[2] - memory.pose[2])))
    speed, turn = float(np.hypot(*twist[:2])), abs(float(twist[2]))
    return bool(
        moved > p.jump + _UNDERRATED * speed * elapsed
        or turned > p.jump_angle + _UNDERRATED * turn * elapsed
    )


def _first_state(observation: Observation, robot: Robot, *, usable: bool) -> GateState:
    """The first tick has nothing to compare with; scans get their time limit to arrive."""
    if not usable:
        return GateState(time=-math.inf, heard=_never(robot), pose=np.zeros(3), pose_time=-math.inf)
    return GateState(
        time=observation.time,
        heard=np.full_like(_never(robot), observation.time),
        pose=observation.pose,
        pose_time=observation.pose_time,
    )


def _never(robot: Robot) -> Floats:
    """No sensor was heard; (s,)."""
    return np.full(len(robot.lasers) + len(robot.cloud_mounts), -math.inf)


def _heard(observation: Observation, robot: Robot, before: Floats) -> Floats:
    """When each sensor was heard, scanners before the others; (s,).

    A message comes from the sensor of its kind that is mounted where it says, or next to there.
    """
    out = before.copy()
    scanners = len(robot.lasers)
    for scan in observation.scans:
        _note(out[:scanners], scan, np.array([m.pose for m in robot.lasers]))
    for cloud in observation.clouds:
        _note(out[scanners:], cloud, np.array([m.pose for m in robot.cloud_mounts]))
    return out


def _note(heard: Floats, message: Scan | PointCloud, poses: Floats) -> None:
    """Put the message's time down for the sensors (s,) at the nearest of ``poses`` (s, ·)."""
    if not len(heard):
        return
    apart = np.abs(np.nan_to_num(poses - message.mount)).sum(axis=1)
    nearest = apart <= apart.min() + _ROUNDING
    heard[nearest] = np.maximum(heard[nearest], message.time)
