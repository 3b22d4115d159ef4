"""Facts for reversing along the driven track, and its action."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import arc_length, inverse, transform
from cohelm.messages import Authority, People
from cohelm.navigation.recovery.driven_track import TRACK_LENGTH, poses_along, way_back
from cohelm.navigation.recovery.rear_clearance import (
    ALONG_TRACK,
    RearMemory,
    RearScene,
    rear_clearance,
    reverse_poses,
)
from cohelm.navigation.recovery.reversing import (
    MIN_WAY,
    NEAR_GOAL,
    ReversingCause,
    ReversingContext,
    ReversingState,
    is_caused,
    update_reversing,
)
from cohelm.navigation.recovery.stages import RecoveryAction, RecoveryStage
from cohelm.navigation.recovery.turning_room import TURNING_MARGIN, can_turn, turn_to_path
from cohelm.navigation.replanning.replanner import RouteState
from cohelm.navigation.tick import StepInput
from cohelm.navigation.world_model import WorldModel

_END_MARGIN = 0.06
"""Gap to walls while turning that ends reversing, m: more than turning needs."""
_GOAL_OFFSET = 0.15
"""Maximum lateral offset of a goal that counts as straight behind the chair, m."""
_WAY_STEP = 0.1
"""Distance between the poses on which the way back goes on to the goal, m."""
_WAITING = frozenset({None, RecoveryStage.WAIT, RecoveryStage.WAIT_AT_GOAL})
"""Stages of a chair that has not yet waited in vain."""
_JAM_AHEAD, _JAM_BESIDE = 2.0, 1.0
"""Extent of the place ahead in which people block a corridor, m."""
_DRIVES = 0.05
"""Speed above which the chair gets on and is not in a jam, m/s: odometry below is noise."""


def reverse_along_track(
    step: StepInput,
    world: WorldModel,
    authority: Authority,
    route: RouteState,
    rear: RearMemory,
    track: Floats,
) -> tuple[RecoveryAction, ReversingState, RearMemory]:
    """Compute the action of a chair whose path begins behind it; none while it is not active.

    Args:
        step: input of the step.
        world: people and obstacles.
        authority: of the rider, whose input ends reversing.
        route: with the path.
        rear: space behind the chair.
        track: driven track, (k, 3).
    """
    memory, p = step.memory.reversing, step.setup.recovery
    now, back = _context(step, world, authority, route, track)
    if (memory is not None and memory.active) or is_caused(now):
        clearance, rear = rear_clearance(
            rear,
            step.setup.robot,
            step.observation,
            RearScene(world.detections, world.walls, world.people),
            curvature=ALONG_TRACK,
            limit=p.back_up,
            way_back=lambda travelled: poses_along(back, travelled),
        )
        now = dataclasses.replace(now, clearance=min(clearance, now.way_back))
    patience = p.wait_for_walking_people if now.remaining <= NEAR_GOAL else p.wait_for_people
    state = update_reversing(now, memory, patience=patience)
    if not state.active:
        return RecoveryAction(), state, rear
    action = RecoveryAction(
        stage=RecoveryStage.REVERSE,
        takes_over=True,
        reverses=now.clearance > 0.0,
        back_up_distance=now.clearance,
        way_back=back,
        turns=state.cause is ReversingCause.TURN,
    )
    return action, state, rear


def _context(
    step: StepInput, world: WorldModel, authority: Authority, route: RouteState, track: Floats
) -> tuple[ReversingContext, Floats]:
    """Facts of this tick, and the way back (k, 3); costly ones only where they matter."""
    pose, robot, memory = step.observation.pose, step.setup.robot, step.memory
    cause = memory.reversing.cause if memory.reversing else None
    stage = memory.recovery.stage if memory.recovery else None
    turn = turn_to_path(pose, route.path, route.progress, step.request.goal)
    now = ReversingContext(
        time=step.observation.time,
        goal=step.request.goal,
        turn=abs(turn),
        has_room=True,
        waited=stage not in _WAITING,
        jammed=(
            stage is RecoveryStage.ASK
            and not step.observation.twist[0] > _DRIVES
            and _people_ahead(pose, world.people)
        ),
        remaining=route.path.length - route.progress,
        way_back=0.0,
        allowed=(
            robot.motion_model.translating == 1
            and robot.max_reverse_speed > 0.0
            and step.setup.recovery.back_up > 0.0
            and not authority.deflection.any()
        ),
    )
    if cause is None and not now.is_behind and not now.jammed:
        return now, pose[None]
    jam = cause is ReversingCause.JAM or (cause is None and not now.is_behind)
    margin = TURNING_MARGIN if cause is None else _END_MARGIN
    back = _on_to_goal(way_back(track, pose, TRACK_LENGTH), step.request.goal)
    return dataclasses.replace(
        now,
        has_room=can_turn(robot, pose, math.pi if jam else turn, world.walls, margin=margin),
        way_back=float(arc_length(back[:, :2])[-1]),
    ), back


def distance_behind(pose: Floats, goal: Floats) -> float:
    """Distance to back up until the goal is abreast, m; ∞: it is not straight behind."""
    x, y = transform(inverse(pose), goal)
    return float(-x) if x < 0.0 and abs(y) <= _GOAL_OFFSET else float("inf")


def _on_to_goal(back: Floats, goal: Floats) -> Floats:
    """Lead the way back (k, 3) straight on to a goal close behind the driven track.

    ``rear_clearance`` then decides how much of it is observed to be free.
    """
    distance = distance_behind(back[-1], goal)
    if distance > NEAR_GOAL:
        return back
    travelled = np.arange(_WAY_STEP, distance + MIN_WAY, _WAY_STEP)
    return np.concatenate([back, reverse_poses(back[-1], 0.0, travelled)])


def _people_ahead(pose: Floats, people: People) -> bool:
    """Check for people who block a corridor close ahead."""
    ahead, left = transform(inverse(pose), people.mean[:, :2]).T
    return bool(((ahead > 0.0) & (ahead < _JAM_AHEAD) & (np.abs(left) < _JAM_BESIDE)).any())
