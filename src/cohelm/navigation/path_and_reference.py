"""Goal → path → reference, blended with the rider's input in shared mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cohelm.arrays import Floats, identical, replace
from cohelm.errors import GoalBlocked, PlanningError
from cohelm.geometry import wrap_angle
from cohelm.messages import Authority, Mode, Reason, Reference
from cohelm.navigation.final_approach import approach_limit, final_approach, path_up_to
from cohelm.navigation.floor import with_all_edges
from cohelm.navigation.group_outlines import group_outlines
from cohelm.navigation.recovery.context import reverse_reference
from cohelm.navigation.recovery.progress_checker import ProgressState, check_progress
from cohelm.navigation.recovery.stages import RecoveryAction, RecoveryStage
from cohelm.navigation.replanning.remaining_path import leg_of, next_leg, turn_to_path
from cohelm.navigation.replanning.replanner import RouteState, update_route
from cohelm.navigation.replanning.route_query import PlanningFailure, PlanReason, RouteQuery
from cohelm.navigation.tick import StepInput
from cohelm.navigation.world_model import WorldModel
from cohelm.planning import ReferenceSettings, make_reference
from cohelm.robots.turning_room import must_turn_elsewhere
from cohelm.sharing import shared_reference

_ROUNDING = 1e-9  # s; times are sums of float steps
_AT_END = 0.3
"""Remaining length of a leg at its end, m."""
_REPEATED = frozenset({PlanReason.STEERING, PlanReason.OFF_PATH, PlanReason.TURN})
"""Causes that may hold on the new path as well: then it is replaced again and again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PathAndReference:
    """Path and references of one step, or the planning failure."""

    route: RouteState | None = None
    reference: Reference | None = None
    """Along the path."""
    shared: Reference | None = None
    """``reference`` blended with the rider's states in shared mode; backwards while the chair backs
    up."""
    rider_inputs: Floats | None = None
    """(L, m) inputs of the motion that the rider asks for in shared mode."""
    speed_limit: float = np.inf
    """For a chair that is too fast for the end of the path, m/s."""
    progress: ProgressState | None = None
    holds: bool = False
    """The chair waits until the space behind it is known to be free."""
    failure: PlanningFailure | None = None
    """None if there is a path."""


def plan_path_and_reference(
    step: StepInput,
    world: WorldModel,
    authority: Authority,
    recovery: RecoveryAction,
    *,
    hold: bool,
) -> PathAndReference:
    """Update the path and compute the reference along it; without a goal there is neither.

    Args:
        step: input of the step.
        world: people and obstacles.
        authority: of the rider.
        recovery: action of a ride that makes no progress.
        hold: True while the chair need not make progress.
    """
    if np.isnan(step.request.goal).any():
        return PathAndReference()
    failure = step.memory.planning_failure
    if failure is not None and _is_recent(failure, step):
        return PathAndReference(failure=failure)
    query = _route_query(step, world, authority, recovery)
    try:
        route = update_route(
            query, step.setup.global_planner, step.memory.route, step.setup.replanning
        )
    except PlanningError as error:
        return PathAndReference(failure=_failure(step, error))
    leg = leg_of(route.path, route.leg)
    stop_at = recovery.stop_at
    if leg.backward and recovery.stage is not RecoveryStage.REVERSE:
        stop_at = route.progress  # until the space behind is known to be free
    along, progress = _reference_along(step, world, route, stop_at=stop_at)
    route = replace(
        route,
        progress=progress,
        leg=next_leg(route.path, route.leg, progress, step.observation.twist),
    )
    reverses = recovery.way_back is not None or leg.backward
    backs_out = recovery.turns and recovery.reverses  # along the path, so it must get on
    waits = recovery.stage is RecoveryStage.REVERSE or np.isfinite(recovery.stop_at)
    return PathAndReference(
        route=route,
        reference=along,
        shared=_reference_to_track(step, along, authority, recovery),
        speed_limit=np.inf if reverses else _speed_limit(step, world, authority, route, recovery),
        progress=_check_progress(
            step, route, progress, along, hold=hold or (waits and not backs_out)
        ),
        holds=leg.backward and not (recovery.reverses or authority.deflection.any()),
    )


def _speed_limit(
    step: StepInput,
    world: WorldModel,
    authority: Authority,
    route: RouteState,
    recovery: RecoveryAction,
) -> float:
    """Speed limit, m/s, towards the end of the path and away from its beginning; +inf without."""
    setup = step.setup
    leg = leg_of(route.path, route.leg)
    remaining = min(leg.begin + leg.path.length, recovery.stop_at) - route.progress
    limit = approach_limit(remaining, step.observation.twist, setup.comfort.deceleration)
    if not authority.deflection.any() and _cannot_turn(step, world, route):
        return min(limit, setup.progress.creep_speed)
    return limit


def _cannot_turn(step: StepInput, world: WorldModel, route: RouteState) -> bool:
    """Check for a leg that begins behind a chair that cannot turn to it where it is.

    At the end of a leg, where the chair changes its gear, nothing is behind it.
    """
    leg = leg_of(route.path, route.leg)
    at = route.progress - leg.begin
    if leg.backward or not (leg.is_last or leg.path.length - at > _AT_END):
        return False
    pose = step.observation.pose
    turn = turn_to_path(pose, leg.path, at, leg.path.points[-1])
    return must_turn_elsewhere(step.setup.robot, pose, turn, world.walls)


def _is_recent(failure: PlanningFailure, step: StepInput) -> bool:
    """Check that planning for the same request failed less than ``min_interval`` ago."""
    before, request = failure.request, step.request
    same = identical(before.goal, request.goal) and identical(before.wishes, request.wishes)
    elapsed = step.observation.time - failure.time
    return same and elapsed < step.setup.replanning.min_interval - _ROUNDING


def _route_query(
    step: StepInput, world: WorldModel, authority: Authority, recovery: RecoveryAction
) -> RouteQuery:
    setup, observation, request = step.setup, step.observation, step.request
    return RouteQuery(
        time=observation.time,
        request=request,
        pose=observation.pose,
        robot=setup.robot,
        grid=setup.grid,
        live=(
            world.live
            if world.floor is None or request.over_edges
            else with_all_edges(world.live, world.floor.edges)
        ),
        walls=world.walls,
        authority=authority if request.mode is Mode.SHARED else None,
        people=world.people,
        stalled=recovery.replans,
        backed_up=_has_backed_up(step),
        cannot_turn=(
            setup.robot.max_reverse_speed > 0.0
            and setup.robot.motion_model.translating == 1
            and step.memory.route is not None
            and not authority.deflection.any()
            and _cannot_turn(step, world, step.memory.route)
        ),
        side=recovery.side,
        crowding=setup.heat,
        groups=group_outlines(world.people, world.groups, setup.replanning.standing_speed),
        filters=setup.filters,
    )


def _has_backed_up(step: StepInput) -> bool:
    """Check that the chair has backed up along its track since the last plan."""
    reversing, route = step.memory.reversing, step.memory.route
    if reversing is None or route is None:
        return False
    return max(route.planned_at, route.attempted_at) < reversing.ended_at


def _failure(step: StepInput, error: PlanningError) -> PlanningFailure:
    """Record of a planning error, so that planning is not repeated at once."""
    return PlanningFailure(
        request=step.request,
        time=step.observation.time,
        reason=planning_reason(error),
        detail=str(error),
    )


def planning_reason(error: PlanningError) -> Reason:
    """Map a planning error to its reason."""
    if isinstance(error, GoalBlocked) and error.because:
        return Reason.KEEPOUT
    known = {reason.value: reason for reason in Reason}
    return known.get(error.code, Reason.PLANNING)


def _reference_along(
    step: StepInput, world: WorldModel, route: RouteState, *, stop_at: float
) -> tuple[Reference, float]:
    """(reference along the path; arc length of the robot's projection on the path, m).

    Near the goal the reference leads a chair that is beside the path straight to the goal, because
    the heading there is free: parallel to the path it would pass beside the goal.
    """
    setup, observation = step.setup, step.observation
    leg = leg_of(route.path, route.leg)
    limit = setup.speed_limit(step.request)
    settings = ReferenceSettings(
        steps=setup.local_planner.steps,
        step=setup.local_planner.step,
        speed=min(limit, _backing_speed(step)) if leg.backward else limit,
        robot=setup.robot,
        comfort=setup.comfort,
        backward=leg.backward,
    )
    pose, twist = observation.pose, observation.twist
    along, at = make_reference(
        leg.path, pose, twist, settings, progress=max(route.progress - leg.begin, 0.0)
    )
    final = None
    if stop_at - leg.begin < leg.path.length:
        final = path_up_to(leg.path, max(stop_at - leg.begin, 0.0))
    elif leg.is_last and not leg.backward:
        final = final_approach(leg.path, at, pose[:2], world.walls, setup.robot)
    if final is not None:
        along, _ = make_reference(final, pose, twist, settings)
    return along, leg.begin + at


def _backing_speed(step: StepInput) -> float:
    return min(step.setup.recovery.back_up_speed, step.setup.progress.creep_speed)


def _reference_to_track(
    step: StepInput, along: Reference, authority: Authority, recovery: RecoveryAction
) -> Reference:
    """Reference of the local planner: backwards, blended with the rider's states, or ``along``."""
    setup = step.setup
    if recovery.back_up_distance > 0.0 or recovery.way_back is not None:
        return reverse_reference(
            step.observation.pose,
            recovery,
            _backing_speed(step),
            steps=setup.local_planner.steps,
            step=setup.local_planner.step,
        )
    return shared_reference(along, authority) if step.request.mode is Mode.SHARED else along


def _check_progress(
    step: StepInput, route: RouteState, progress: float, along: Reference, *, hold: bool
) -> ProgressState:
    """Update the progress checker with the remaining length of the path and the turn to it."""
    turn = wrap_angle(along.poses[0, 2] - step.observation.pose[2])
    return check_progress(
        route.path.length - progress,
        step.observation.time,
        route.planned_at,
        step.memory.progress,
        step.setup.progress,
        position=step.observation.pose[:2],
        turn=abs(float(turn)),
        replanned=route.reason in _REPEATED,
        hold=hold,
    )
