"""Facts for reversing along the driven track, and its action."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import arc_length, inverse, transform
from cohelm.messages import Authority
from cohelm.navigation.recovery.driven_track import TRACK_LENGTH, poses_along, way_back
from cohelm.navigation.recovery.rear_clearance import (
    ALONG_TRACK,
    RearMemory,
    RearScene,
    rear_clearance,
)
from cohelm.navigation.recovery.reversing import (
    ReversingContext,
    ReversingState,
    may_begin,
    update_reversing,
)
from cohelm.navigation.recovery.stages import RecoveryAction, RecoveryStage
from cohelm.navigation.recovery.turning_room import can_turn
from cohelm.navigation.replanning.replanner import RouteState
from cohelm.navigation.tick import StepInput
from cohelm.navigation.world_model import WorldModel

_LOOKAHEAD = 0.5
"""Distance ahead on the path at which its direction is taken, m."""
_WALL_MARGIN, _END_MARGIN = 0.02, 0.06
"""Gap to walls while turning, m: that of the planner's verification; more to end reversing."""


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
    active = memory is not None and memory.active
    now, back = _context(step, world, authority, route, track, active=active)
    if active or may_begin(now):
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
    state = update_reversing(now, memory, patience=p.wait_for_walking_people)
    if not state.active:
        return RecoveryAction(), state, rear
    action = RecoveryAction(
        stage=RecoveryStage.REVERSE,
        takes_over=True,
        reverses=now.clearance > 0.0,
        back_up_distance=now.clearance,
        way_back=back,
    )
    return action, state, rear


def _context(
    step: StepInput,
    world: WorldModel,
    authority: Authority,
    route: RouteState,
    track: Floats,
    *,
    active: bool,
) -> tuple[ReversingContext, Floats]:
    """Facts of this tick, and the way back (k, 3); costly ones only where they matter."""
    pose, robot = step.observation.pose, step.setup.robot
    turn = _turn_to_path(pose, route, step.request.goal)
    now = ReversingContext(
        time=step.observation.time,
        goal=step.request.goal,
        turn=abs(turn),
        has_room=True,
        remaining=route.path.length - route.progress,
        way_back=0.0,
        allowed=(
            robot.motion_model.translating == 1
            and robot.max_reverse_speed > 0.0
            and step.setup.recovery.back_up > 0.0
            and not authority.deflection.any()
        ),
    )
    if not active and not now.is_behind:
        return now, pose[None]
    margin = _END_MARGIN if active else _WALL_MARGIN
    back = way_back(track, pose, TRACK_LENGTH)
    return dataclasses.replace(
        now,
        has_room=can_turn(robot, pose, turn, world.walls, margin=margin),
        way_back=float(arc_length(back[:, :2])[-1]),
    ), back


def _turn_to_path(pose: Floats, route: RouteState, goal: Floats) -> float:
    """Angle from the heading to a point ahead on the path, or to the goal if it is nearer, rad."""
    along = arc_length(route.path.points)
    s = route.progress + _LOOKAHEAD
    ahead = goal
    if s < along[-1]:
        ahead = np.array([np.interp(s, along, route.path.points[:, i]) for i in (0, 1)])
    x, y = transform(inverse(pose), ahead)
    return math.atan2(y, x)
