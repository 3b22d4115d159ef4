"""Facts for reversing along a leg of the path or the driven track, and its action."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.geometry import arc_length, inverse, transform
from cohelm.messages import Authority, People
from cohelm.navigation.recovery.driven_track import (
    TRACK_LENGTH,
    poses_along,
    poses_backward,
    way_back,
)
from cohelm.navigation.recovery.rear_clearance import (
    ALONG_TRACK,
    RearMemory,
    RearScene,
    rear_clearance,
)
from cohelm.navigation.recovery.reversing import (
    ReversingCause,
    ReversingContext,
    ReversingState,
    is_caused,
    update_reversing,
)
from cohelm.navigation.recovery.stages import RecoveryAction, RecoveryStage
from cohelm.navigation.replanning.remaining_path import leg_of
from cohelm.navigation.replanning.replanner import RouteState
from cohelm.navigation.standstill import is_standing_still
from cohelm.navigation.tick import StepInput
from cohelm.navigation.world_model import WorldModel
from cohelm.robots.turning_room import TURNING_MARGIN, can_turn

_END_MARGIN = 0.06
"""Gap to walls while turning that ends reversing, m: more than turning needs."""
_GOAL_OFFSET = 0.15
"""Maximum lateral offset of a goal that counts as straight behind the chair, m."""
_JAM_AHEAD, _JAM_BESIDE = 2.0, 1.0
"""Extent of the place ahead in which people block a corridor, m."""
_DRIVES = 0.05
"""Speed above which the chair gets on and is not in a jam, m/s: odometry below is noise."""


def reverse(
    step: StepInput,
    world: WorldModel,
    authority: Authority,
    route: RouteState,
    rear: RearMemory,
    track: Floats,
) -> tuple[RecoveryAction, ReversingState, RearMemory]:
    """Compute the action of a chair that must drive backwards; none while it is not active.

    Args:
        step: input of the step.
        world: people and obstacles.
        authority: of the rider; only a stick that is pulled back does not end reversing.
        route: with the path and its legs.
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
        now = replace(now, clearance=min(clearance, now.way_back))
    on_leg = now.backward
    patience = p.wait_for_walking_people if on_leg else p.wait_for_people
    state = update_reversing(now, memory, patience=patience)
    if not state.active:
        return RecoveryAction(), state, rear
    action = RecoveryAction(
        stage=RecoveryStage.REVERSE,
        takes_over=True,
        reverses=now.clearance > 0.0,
        back_up_distance=0.0 if on_leg else now.clearance,
        way_back=None if on_leg else back,
        stop_at=route.progress + now.clearance if on_leg else math.inf,
        turns=on_leg,
    )
    return action, state, rear


def _context(
    step: StepInput, world: WorldModel, authority: Authority, route: RouteState, track: Floats
) -> tuple[ReversingContext, Floats]:
    """Facts of this tick, and the way back (k, 3); costly ones only where they matter."""
    pose, robot, memory = step.observation.pose, step.setup.robot, step.memory
    cause = memory.reversing.cause if memory.reversing else None
    stage = memory.recovery.stage if memory.recovery else None
    leg = leg_of(route.path, route.leg)
    now = ReversingContext(
        time=step.observation.time,
        goal=step.request.goal,
        backward=leg.backward,
        stands=is_standing_still(step.observation.twist),
        jammed=(
            stage is RecoveryStage.ASK
            and not step.observation.twist[0] > _DRIVES
            and _people_ahead(pose, world.people)
        ),
        allowed=(
            robot.motion_model.translating == 1
            and robot.max_reverse_speed > 0.0
            and step.setup.recovery.back_up > 0.0
            and (authority.deflection[0] < 0.0 or not authority.deflection.any())
        ),
    )
    if leg.backward:
        back = poses_backward(leg.path, pose, route.progress - leg.begin)
    elif cause is ReversingCause.JAM or now.jammed:
        back = way_back(track, pose, TRACK_LENGTH)
        margin = _END_MARGIN if cause else TURNING_MARGIN
        has_room = can_turn(robot, pose, math.pi, world.walls, margin=margin)
        now = replace(now, has_room=has_room)
    else:
        return now, pose[None]
    return replace(now, way_back=float(arc_length(back[:, :2])[-1])), back


def distance_behind(pose: Floats, goal: Floats) -> float:
    """Distance to back up until the goal is abreast, m; ∞: it is not straight behind."""
    x, y = transform(inverse(pose), goal)
    return float(-x) if x < 0.0 and abs(y) <= _GOAL_OFFSET else float("inf")


def _people_ahead(pose: Floats, people: People) -> bool:
    """Check for people who block a corridor close ahead."""
    ahead, left = transform(inverse(pose), people.mean[:, :2]).T
    return bool(((ahead > 0.0) & (ahead < _JAM_AHEAD) & (np.abs(left) < _JAM_BESIDE)).any())
