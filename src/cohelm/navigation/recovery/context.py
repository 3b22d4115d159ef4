"""Recovery context: the facts for the stage machine, and the use of its action.

Where a person stands at the goal, the chair waits near it outside the person's space, and takes the
place once it is free. To creep closer, to back up or to look for another path helps only if the
person waits for the chair, so it comes later.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.geometry import arc_length, wrap_angle
from cohelm.messages import Authority, Decision, LocalPlan, Mode, Path, People, Reason, Reference
from cohelm.navigation.recovery.driven_track import extend_track, poses_along
from cohelm.navigation.recovery.parameters import RecoveryParameters
from cohelm.navigation.recovery.progress_checker import ProgressState
from cohelm.navigation.recovery.rear_clearance import (
    RearMemory,
    RearScene,
    extend_trail,
    is_recent,
    rear_clearance,
    reverse_poses,
)
from cohelm.navigation.recovery.reversing import ReversingState
from cohelm.navigation.recovery.reversing_context import distance_behind, reverse
from cohelm.navigation.recovery.stages import (
    PeopleNearby,
    RecoveryAction,
    RecoveryContext,
    RecoveryStage,
    RecoveryState,
    after_waiting_at_goal,
    recovery_step,
)
from cohelm.navigation.replanning.remaining_path import remaining_path
from cohelm.navigation.replanning.replanner import RouteState
from cohelm.navigation.replanning.route_query import PlanReason
from cohelm.navigation.standstill import is_standing_still
from cohelm.navigation.tick import StepInput
from cohelm.navigation.world_model import WorldModel
from cohelm.robots import Robot
from cohelm.robots.capsule import gap_to_disc

_NEAR = 3.0
"""Remaining length at which a goal counts as occupied, m: from farther away the person may be gone
when the chair arrives."""
_GAP, _KEPT_GAP = 0.05, 0.1
"""Gap between the chair at its goal and a standing person that is too small to arrive, m: even a
creeping chair keeps more; the second while it waits."""
_SPACING = 0.1
"""Spacing of the places that are checked, m."""
_APPROACH = 0.7
"""Distance before the goal from which the chair's heading there is taken, m."""


def waiting_place(
    path: Path,
    progress: float,
    people: People,
    robot: Robot,
    *,
    distance: float,
    standing_speed: float,
    waits: bool,
) -> float | None:
    """Arc length on the path at which to wait for a person who stands at its end, m.

    Args:
        path: to the goal.
        progress: arc length of the chair on it, m.
        people: tracked people.
        robot: its footprint.
        distance: to keep from the person, m.
        standing_speed: speed below which a person stands, m/s.
        waits: the chair waits already.

    Returns:
        The arc length, at least ``progress``; None: the goal is far away or free.
    """
    if path.length - progress > _NEAR:
        return None
    standing = np.hypot(*people.mean[:, 2:].T) < standing_speed
    along = arc_length(path.points)
    end = float(along[-1])
    at_goal = _gaps(path.points, along, end, robot, people)
    occupying = standing & (at_goal < (_KEPT_GAP if waits else _GAP))
    if not occupying.any():
        return None
    for s in np.arange(end, progress, -_SPACING):
        if (_gaps(path.points, along, float(s), robot, people)[occupying] >= distance).all():
            return float(s)
    return progress


def _gaps(points: Floats, along: Floats, s: float, robot: Robot, people: People) -> Floats:
    """Gaps (n,) between people and the chair at arc length ``s``, heading along the path, m."""
    before, here = (
        np.array([np.interp(at, along, points[:, i]) for i in (0, 1)]) for at in (s - _APPROACH, s)
    )
    direction = here - before
    pose = np.array([*here, np.arctan2(direction[1], direction[0])])
    return np.array(
        [
            gap_to_disc(robot.capsule, pose, x, y, radius)
            for (x, y), radius in zip(people.mean[:, :2], people.radius, strict=True)
        ]
    ).reshape(len(people))


_DIRECTION_POINTS = 8
"""Number of path points over which its direction is computed."""
_MAX_CURVATURE = 1.5
"""Maximum curvature of backing up, rad/m."""
_REQUESTED = frozenset({PlanReason.FIRST, PlanReason.GOAL, PlanReason.WISH})
_LESS_SPECIFIC = frozenset({None, Reason.NO_SAFE_PLAN, Reason.BLOCKED, Reason.OVER_LIMITS})
"""Reasons that the reason of the recovery replaces."""


class RecoveryUpdate(NamedTuple):
    """Recovery action of a tick, and what to remember."""

    action: RecoveryAction
    state: RecoveryState | None
    rear: RearMemory
    track: Floats
    """Driven track, (k, 3)."""
    reversing: ReversingState | None


def update_recovery(
    step: StepInput, world: WorldModel, authority: Authority, *, hold: bool
) -> RecoveryUpdate:
    """Compute the recovery action of this tick, and what to remember.

    Args:
        step: input of the step.
        world: people and obstacles.
        authority: of the rider.
        hold: True while the chair need not make progress.
    """
    observation, memory, p = step.observation, step.memory, step.setup.recovery
    rear = extend_trail(memory.rear, observation.pose, observation.time, p.trail_time)
    track = extend_track(memory.track, observation.pose)
    progress, route = memory.progress, memory.route
    if hold or progress is None or route is None:
        return RecoveryUpdate(RecoveryAction(), None, rear, track, None)

    # A person at the goal: waiting helps, for a while.
    state = memory.recovery
    waiting = _wait_at_goal(step, world, route)
    if waiting is not None:
        action, at_goal = waiting
        if observation.time - at_goal.since < p.wait_at_goal:
            return RecoveryUpdate(action, at_goal, rear, track, None)
        state = after_waiting_at_goal(at_goal, observation.time)
    elif state is not None and state.stage is RecoveryStage.WAIT_AT_GOAL:
        state = None

    # A path that leads backwards, or a jam.
    action, reversing, rear = reverse(step, world, authority, route, rear, track)
    if reversing.active:
        return RecoveryUpdate(action, state, rear, track, reversing)

    # Rear clearance matters only once waiting did not help.
    clearance = curvature = 0.0
    if state is not None and state.stage is not RecoveryStage.WAIT and p.back_up > 0.0:
        scene = RearScene(world.detections, world.walls, world.people)
        curvatures = _curvatures(observation.pose, route, state, p.back_up)
        arc = math.isfinite(rear.curvature)
        if arc and not world.detections and is_recent(rear, observation.time):
            curvatures = (rear.curvature,)
        for curvature in curvatures:
            clearance, rear = rear_clearance(
                rear, step.setup.robot, observation, scene, curvature=curvature, limit=p.back_up
            )
            if clearance >= p.min_back_up:
                break
    context = replace(
        _context(step, authority, progress, route),
        people=_people_nearby(observation.pose, world.people, p),
        rear_clearance=clearance,
        curvature=curvature,
    )
    action, state = recovery_step(context, state, p, step.setup.progress)
    return RecoveryUpdate(action, state, rear, track, reversing)


def _wait_at_goal(
    step: StepInput, world: WorldModel, route: RouteState
) -> tuple[RecoveryAction, RecoveryState] | None:
    """Wait near a goal that a person occupies; None if none does, or waiting did not help."""
    observation, state = step.observation, step.memory.recovery
    if state is not None and state.has_waited_at_goal:
        return None
    if state is None or state.stage is not RecoveryStage.WAIT_AT_GOAL:
        state = RecoveryState(
            stage=RecoveryStage.WAIT_AT_GOAL,
            since=observation.time,
            began=observation.time,
            position=observation.pose[:2],
        )
    place = waiting_place(
        route.path,
        route.progress,
        world.people,
        step.setup.robot,
        distance=step.request.profile.social_distance,
        standing_speed=step.setup.recovery.walking_speed,
        waits=state is step.memory.recovery,
    )
    if place is None:
        return None
    return RecoveryAction(stage=state.stage, stop_at=place), state


def _context(
    step: StepInput, authority: Authority, progress: ProgressState, route: RouteState
) -> RecoveryContext:
    observation, request = step.observation, step.request
    shares = request.mode in {Mode.SHARED, Mode.AUTONOMOUS}
    return RecoveryContext(
        time=observation.time,
        position=observation.pose[:2],
        stands=is_standing_still(observation.twist),
        stalled_for=observation.time - progress.since,
        progress_at=progress.since,
        planned_at=route.planned_at,
        searched_at=max(route.planned_at, route.attempted_at),
        requested_at=route.planned_at if route.reason in _REQUESTED else -np.inf,
        deflection=authority.deflection if shares else np.zeros(2),
        goal_behind=distance_behind(observation.pose, request.goal),
    )


def _curvatures(
    pose: Floats, route: RouteState, state: RecoveryState, distance: float
) -> tuple[float, ...]:
    """Curvatures to try, rad/m: so as to face along the path afterwards, else straight back."""
    if state.stage is RecoveryStage.BACK_UP:
        return (state.curvature,)
    points = remaining_path(route.path, route.progress)
    direction = points[min(_DIRECTION_POINTS, len(points) - 1)] - points[0]
    error = float(wrap_angle(math.atan2(direction[1], direction[0]) - pose[2]))
    return (math.copysign(min(abs(error) / distance, _MAX_CURVATURE), error), 0.0)


def _people_nearby(pose: Floats, people: People, p: RecoveryParameters) -> PeopleNearby:
    near = np.hypot(*(people.mean[:, :2] - pose[:2]).T) < p.people_radius
    if not near.any():
        return PeopleNearby.NONE
    walks = np.hypot(*people.mean[near, 2:].T) >= p.walking_speed
    return PeopleNearby.WALKING if walks.any() else PeopleNearby.STANDING


def reverse_reference(
    pose: Floats, action: RecoveryAction, speed: float, *, steps: int, step: float
) -> Reference:
    """Compute the reference of a chair that backs up from ``pose`` (3,).

    Args:
        pose: X_MR.
        action: distance and curvature, or the way back.
        speed: upper bound, m/s.
        steps, step: N and Δt.
    """
    travelled = np.minimum(np.arange(steps + 1) * speed * step, action.back_up_distance)
    speeds = np.where(travelled < action.back_up_distance, -speed, 0.0)
    if action.way_back is None:
        poses = reverse_poses(pose, action.curvature, travelled)
    else:
        poses = poses_along(action.way_back, travelled)
    return Reference(step=step, poses=poses, speeds=speeds)


def with_recovery_reason(
    decision: Decision, plan: LocalPlan | None, twist: Floats, action: RecoveryAction
) -> Decision:
    """Replace a less specific reason of the decision by that of the recovery."""
    stands = is_standing_still(twist) and is_standing_still(decision.twist)
    reason = action.reason(stands=stands)
    if plan is None or reason is None or decision.reason not in _LESS_SPECIFIC:
        return decision
    return replace(decision, reason=reason)
