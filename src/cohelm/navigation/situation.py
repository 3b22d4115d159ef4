"""What there is to judge by when a ride does not get on, and what is done about it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import inverse, transform, wrap_angle
from cohelm.messages import (
    Authority,
    Decision,
    LocalPlan,
    Mode,
    Observation,
    People,
    Reason,
    Reference,
    Request,
)
from cohelm.navigation.ahead import rest_of
from cohelm.navigation.behind import Behind, follow, is_held, room_behind, way_back
from cohelm.navigation.progress import ProgressState
from cohelm.navigation.question import Why
from cohelm.navigation.recovery import (
    Company,
    Recovery,
    RecoveryParameters,
    RecoveryState,
    Situation,
    Stage,
    recovery,
)
from cohelm.navigation.replanning import RouteState
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.sight import Sight
from cohelm.navigation.tick import Memory

_STILL, _STILL_TURNING = 0.05, 0.1
"""Odometry below this is noise or standing, m/s and rad/s."""
_BESIDE = 0.15
"""A goal no farther from the straight line back is behind the chair, m."""
_LOOK = 8
"""Points of the path over which its direction is taken."""
_SHARPEST = 1.5
"""Turn on the way back, rad/m."""
_WANTED = frozenset({Why.FIRST, Why.GOAL, Why.WISH})


def stands(twist: Floats) -> bool:
    """Whether a measured twist (3,) is that of a chair that stands still."""
    return float(np.hypot(*twist[:2])) < _STILL and abs(float(twist[2])) < _STILL_TURNING


def recover(
    setup: NavigatorSetup,
    observation: Observation,
    request: Request,
    sight: Sight,
    hand: Authority,
    memory: Memory | None,
    *,
    rests: bool,
) -> tuple[Recovery, RecoveryState | None, Behind]:
    """What to do about a ride that does not get on, and what to remember.

    Args:
        setup: the parts.
        observation: where the robot is.
        request: where it is to go.
        sight: who and what is about.
        hand: of the rider.
        memory: of the last tick, None at first.
        rests: the chair is not to get on.
    """
    pose, time, p = observation.pose, observation.time, setup.recovery
    behind = follow(memory.behind if memory else None, pose, time, p.recent)
    pace, way = (memory.progress, memory.route) if memory else (None, None)
    if rests or memory is None or pace is None or way is None:
        return Recovery(), None, behind
    then = memory.recovery
    room = bend = 0.0
    if then is not None and then.stage is not Stage.WAIT and p.back_up > 0.0:
        bends = _bends(pose, way, then, p.back_up)
        if not sight.detections and is_held(behind, time):
            bends = (behind.bend,)
        for bend in bends:
            room, behind = room_behind(
                behind,
                setup.robot,
                pose,
                time,
                bend=bend,
                detections=sight.detections,
                walls=sight.walls,
                people=sight.people,
                most=p.back_up,
            )
            if room >= p.least:
                break
    company = _company(pose, sight.people, p)
    now = _situation(observation, request, hand, (pace, way), company, (room, bend))
    done, state = recovery(now, then, p, setup.progress)
    return done, state, behind


def _situation(
    observation: Observation,
    request: Request,
    hand: Authority,
    ride: tuple[ProgressState, RouteState],
    company: Company,
    room: tuple[float, float],
) -> Situation:
    pace, way = ride
    shares = request.mode in {Mode.SHARED, Mode.AUTONOMOUS}
    return Situation(
        time=observation.time,
        position=observation.pose[:2],
        stands=stands(observation.twist),
        stalled_for=observation.time - pace.since,
        got_on_at=pace.since,
        planned_at=way.planned_at,
        looked_at=max(way.planned_at, way.asked_at),
        wanted_at=way.planned_at if way.why in _WANTED else -np.inf,
        company=company,
        deflection=hand.deflection if shares else np.zeros(2),
        room_behind=room[0],
        bend=room[1],
        goal_behind=_goal_behind(observation.pose, request.goal),
    )


def _bends(pose: Floats, way: RouteState, then: RecoveryState, most: float) -> tuple[float, ...]:
    """By how much to turn on the way back, rad/m: so as to face along the path, or not at all."""
    if then.stage is Stage.BACK_UP:
        return (then.bend,)
    rest = rest_of(way.path, way.progress)
    ahead = rest[min(_LOOK, len(rest) - 1)] - rest[0]
    off = float(wrap_angle(math.atan2(ahead[1], ahead[0]) - pose[2]))
    along = math.copysign(min(abs(off) / most, _SHARPEST), off)
    return (along, 0.0)


def _company(pose: Floats, people: People, p: RecoveryParameters) -> Company:
    near = np.hypot(*(people.mean[:, :2] - pose[:2]).T) < p.near
    if not near.any():
        return Company.NOBODY
    walks = np.hypot(*people.mean[near, 2:].T) >= p.walking
    return Company.WALKING if walks.any() else Company.STANDING


def _goal_behind(pose: Floats, goal: Floats) -> float:
    """How far back the goal is abreast of the chair, m; ∞: it does not lie straight behind."""
    x, y = transform(inverse(pose), goal)
    return float(-x) if x < 0.0 and abs(y) <= _BESIDE else float("inf")


def backwards(
    pose: Floats, remedy: Recovery, speed: float, *, steps: int, step: float
) -> Reference:
    """The reference of a chair that backs up from ``pose`` (3,).

    Args:
        pose: X_MR.
        remedy: how far, and by how much it turns.
        speed: how fast at most, m/s.
        steps, step: N and Δt.
    """
    gone = np.minimum(np.arange(steps + 1) * speed * step, remedy.back)
    speeds = np.where(gone < remedy.back, -speed, 0.0)
    return Reference(step=step, poses=way_back(pose, remedy.bend, gone), speeds=speeds)


def explained(
    decision: Decision, plan: LocalPlan | None, twist: Floats, remedy: Recovery
) -> Decision:
    """The decision with what is done about a ride that does not get on as its reason.

    It says more than that there is no plan, or that something stands in the way.
    """
    still = stands(twist) and stands(decision.twist)
    reason = remedy.reason(stands=still)
    if plan is None or reason is None or decision.reason not in _SAYS_LESS:
        return decision
    return dataclasses.replace(decision, reason=reason)


_SAYS_LESS = frozenset({None, Reason.NO_SAFE_PLAN, Reason.BLOCKED, Reason.OVER_LIMITS})
