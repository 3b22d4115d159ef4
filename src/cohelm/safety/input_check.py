"""Plausibility of the observation: numbers, clock, pose and the age of every sensor's data."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.geometry import wrap_angle
from cohelm.messages import Observation, People, PointCloud, Reason, Request, Scan
from cohelm.robots import Robot
from cohelm.safety.gate import GateParameters

_UNDERRATED = 2.0
"""Factor on the odometry's motion up to which a change of pose is no jump."""
_IMPOSSIBLE = 5.0
"""Factor on the robot's limits beyond which a twist is implausible, in any direction: a spinning
wheel or a push downhill is less. A predicted braking from it would be extremely long."""
_ROUNDING = 1e-6  # s; times are sums of float steps: what is exactly at its limit is still good


@value
class GateState:
    """Memory of the gate."""

    time: float
    last_message: Annotated[Floats, Shape("s")]
    """Time of the newest usable scan or cloud of each sensor of the robot, s."""
    pose: Annotated[Floats, Shape("3")]
    """The last accepted pose."""
    pose_time: float
    held_until: float = -math.inf
    """End of the standstill after a jump, s."""


def check_input(
    observation: Observation,
    request: Request,
    robot: Robot,
    memory: GateState | None,
    parameters: GateParameters,
) -> tuple[Reason | None, GateState]:
    """Check the observation before anything is computed from it.

    Returns:
        (the reason why it is unusable, or None; the gate's memory).
    """
    if _not_finite(observation):
        return Reason.NOT_FINITE, memory or _first_state(observation, robot, usable=False)
    memory = memory or _first_state(observation, robot, usable=True)
    if _blinded(observation, parameters):
        # earlier scans expire as well, until one is usable again
        return Reason.NOT_FINITE, replace(memory, last_message=_never(robot))
    if observation.time < memory.time or _from_the_future(observation, parameters):
        return Reason.CLOCK, memory
    held_until = memory.held_until
    largest, twist = _plausible_twist(robot), observation.twist.tolist()
    plausible = [min(max(v, -most), most) for v, most in zip(twist, largest, strict=True)]
    if _jumped(observation, plausible, memory, parameters):
        held_until = observation.time + parameters.jump_hold
    state = GateState(
        time=observation.time,
        last_message=_last_messages(observation, robot, memory.last_message),
        pose=observation.pose,
        pose_time=observation.pose_time,
        held_until=held_until,
    )
    unknown = any(abs(v) > most for v, most in zip(twist, largest, strict=True))
    return _stale(observation, request, state, parameters, unknown=unknown), state


def _not_finite(observation: Observation) -> bool:
    o, rider, people = observation, observation.rider, observation.people
    numbers = [o.time, o.pose_time, o.twist_time, o.late, *o.pose.tolist(), *o.twist.tolist()]
    for scan in o.scans:
        numbers += (scan.time, scan.angle_min, scan.angle_increment, scan.range_max)
        numbers += scan.mount.tolist()
    for cloud in o.clouds:
        numbers += (cloud.time, cloud.range_max)
        numbers += np.delete(cloud.mount, 2).tolist()  # the height may be unknown
    for given in (o.pose_covariance, o.command):
        numbers += [] if given is None else given.ravel().tolist()
    if rider is not None:
        numbers += (*rider.deflection.tolist(), rider.heartbeat)
    if people is not None and not all(np.isfinite(n).all() for n in _numbers_of(people)):
        return True
    return not all(map(math.isfinite, numbers))


def _blinded(observation: Observation, p: GateParameters) -> bool:
    """Check for unusable scans: NaN is a dropout, −inf a blocked lens, +inf free (REP-117)."""
    scans = any(
        len(s.ranges) == 0
        or (len(s.ranges) - np.count_nonzero(s.ranges > -np.inf)) / len(s.ranges) >= p.blind_share
        for s in observation.scans
    )
    # most rows of a LiDAR that points at the sky are NaN, so one finite point is enough
    return scans or not all(np.isfinite(c.points).all(axis=1).any() for c in observation.clouds)


def _numbers_of(people: People) -> list[Floats]:
    """Arrays that must be finite of people given from outside; a heading may be unknown (NaN)."""
    return [
        np.array([people.time]),
        people.mean,
        people.covariance,
        people.heading[~np.isnan(people.heading)],
        people.radius,
        people.confidence,
    ]


def _from_the_future(observation: Observation, p: GateParameters) -> bool:
    """Check for stamps in the far future: they would keep a dead sensor fresh."""
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
    """The first violated rule, or None. unknown: the twist is implausible."""
    now, rider = observation.time, observation.rider
    needs_rider = request.mode.rider_drives
    uses_scans = observation.people is None
    oldest = state.last_message.min(initial=np.inf)
    rules = (
        (request.stop, Reason.RIDER_STOP),
        (observation.late > p.late_limit + _ROUNDING, Reason.LATE),
        (now < state.held_until - _ROUNDING, Reason.POSE_JUMP),
        (now - observation.pose_time > p.pose_limit + _ROUNDING, Reason.STALE_POSE),
        (
            unknown or now - observation.twist_time > p.twist_limit + _ROUNDING,
            Reason.STALE_TWIST,
        ),
        (uses_scans and now - oldest > p.scan_limit + _ROUNDING, Reason.STALE_SCAN),
        (rider is None and needs_rider, Reason.STALE_RIDER_COMMAND),
        (
            rider is not None and now - rider.heartbeat > p.rider_limit + _ROUNDING,
            Reason.STALE_RIDER_COMMAND,
        ),
    )
    return next((reason for holds, reason in rules if holds), None)


def _plausible_twist(robot: Robot) -> tuple[float, float, float]:
    """Largest plausible twist."""
    speed = _IMPOSSIBLE * max(robot.max_speed, robot.max_reverse_speed)
    return speed, speed, _IMPOSSIBLE * robot.max_turn_rate


def _jumped(
    observation: Observation, twist: Sequence[float], memory: GateState, p: GateParameters
) -> bool:
    """Check that the pose moved more than speed and time explain."""
    elapsed = max(observation.pose_time - memory.pose_time, 0.0)
    (x, y, heading), before = observation.pose.tolist(), memory.pose.tolist()
    moved = float(np.hypot(x - before[0], y - before[1]))
    turned = abs(float(wrap_angle(heading - before[2])))
    speed, turn = float(np.hypot(twist[0], twist[1])), abs(twist[2])
    return (
        moved > p.jump + _UNDERRATED * speed * elapsed
        or turned > p.jump_angle + _UNDERRATED * turn * elapsed
    )


def _first_state(observation: Observation, robot: Robot, *, usable: bool) -> GateState:
    """Memory at the first tick; scans have their time limit to arrive."""
    if not usable:
        return GateState(
            time=-math.inf, last_message=_never(robot), pose=np.zeros(3), pose_time=-math.inf
        )
    return GateState(
        time=observation.time,
        last_message=np.full_like(_never(robot), observation.time),
        pose=observation.pose,
        pose_time=observation.pose_time,
    )


def _never(robot: Robot) -> Floats:
    """Times of no message at all, (s,)."""
    return np.full(len(robot.lasers) + len(robot.cloud_mounts), -math.inf)


def _last_messages(observation: Observation, robot: Robot, before: Floats) -> Floats:
    """Time of the newest message of each sensor, scanners first, (s,).

    A message belongs to the sensor of its kind whose mount is nearest to the one that it states.
    """
    if not observation.scans and not observation.clouds:
        return before
    out, scanners = before.copy(), len(robot.lasers)
    for scan in observation.scans:
        _record(out[:scanners], scan, np.array([m.pose for m in robot.lasers]))
    for cloud in observation.clouds:
        _record(out[scanners:], cloud, np.array([m.pose for m in robot.cloud_mounts]))
    return out


def _record(last_message: Floats, message: Scan | PointCloud, poses: Floats) -> None:
    """Record the message's time for the sensors (s,) at the nearest of ``poses`` (s, ·)."""
    if not len(last_message):
        return
    apart = np.abs(np.nan_to_num(poses - message.mount)).sum(axis=1)
    nearest = apart <= apart.min() + _ROUNDING
    last_message[nearest] = np.maximum(last_message[nearest], message.time)
