"""Goal → path → reference, blended with the rider's input in shared mode."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import identical
from cohelm.errors import GoalBlocked, PlanningError
from cohelm.messages import Authority, Mode, Reason, Reference, Request
from cohelm.navigation.group_outlines import group_outlines
from cohelm.navigation.obstacle_memory import merge_obstacles
from cohelm.navigation.recovery.context import reverse_reference
from cohelm.navigation.recovery.progress_checker import ProgressState, check_progress
from cohelm.navigation.recovery.stages import RecoveryAction
from cohelm.navigation.replanning.replanner import RouteState, update_route
from cohelm.navigation.replanning.route_query import PlanningFailure, PlanReason, RouteQuery
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.tick import StepInput
from cohelm.navigation.world_model import WorldModel
from cohelm.planning import ReferenceSettings, make_reference
from cohelm.sharing import shared_reference

_ROUNDING = 1e-9  # s; times are sums of float steps


@dataclass(frozen=True, slots=True, kw_only=True)
class PathAndReference:
    """Path and references of one step, or the planning failure."""

    route: RouteState | None = None
    reference: Reference | None = None
    """Along the path."""
    shared: Reference | None = None
    """``reference`` blended with the rider's states in shared mode; backwards while the chair backs
    up."""
    progress: ProgressState | None = None
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
    setup, observation, request = step.setup, step.observation, step.request
    if np.isnan(request.goal).any():
        return PathAndReference()
    failure = step.memory.planning_failure
    if failure is not None and _is_recent(failure, request, observation.time, setup):
        return PathAndReference(failure=failure)

    query = _route_query(step, world, authority, recovery)
    try:
        route = update_route(query, setup.global_planner, step.memory.route, setup.replanning)
    except PlanningError as error:
        failure = PlanningFailure(
            request=request,
            time=observation.time,
            reason=planning_reason(error),
            detail=str(error),
        )
        return PathAndReference(failure=failure)

    settings = ReferenceSettings(
        steps=setup.local_planner.steps,
        step=setup.local_planner.step,
        speed=setup.speed_limit(request),
        robot=setup.robot,
        comfort=setup.comfort,
    )
    along, progress = make_reference(
        route.path, observation.pose, observation.twist, settings, progress=route.progress
    )
    checked = check_progress(
        route.path.length - progress,
        observation.time,
        route.planned_at,
        step.memory.progress,
        setup.progress,
        position=observation.pose[:2],
        follows_rider=route.reason is PlanReason.STEERING,
        hold=hold,
    )
    if recovery.back_up_distance > 0.0:
        shared = reverse_reference(
            observation.pose,
            recovery,
            min(setup.recovery.back_up_speed, setup.progress.creep_speed),
            steps=setup.local_planner.steps,
            step=setup.local_planner.step,
        )
    else:
        shared = shared_reference(along, authority) if request.mode is Mode.SHARED else along
    return PathAndReference(
        route=dataclasses.replace(route, progress=progress),
        reference=along,
        shared=shared,
        progress=checked,
    )


def _route_query(
    step: StepInput, world: WorldModel, authority: Authority, recovery: RecoveryAction
) -> RouteQuery:
    setup, observation, request = step.setup, step.observation, step.request
    crowding = world.crowding.published
    return RouteQuery(
        time=observation.time,
        request=request,
        pose=observation.pose,
        robot=setup.robot,
        grid=setup.grid,
        live=merge_obstacles(world.live, world.obstacle_memory),
        walls=world.walls,
        authority=authority if request.mode is Mode.SHARED else None,
        people=world.people,
        stalled=recovery.replans,
        side=recovery.side,
        crowding=crowding if crowding.density.any() else None,
        groups=group_outlines(world.people, world.groups, setup.replanning.standing_speed),
        filters=setup.filters,
    )


def _is_recent(
    failure: PlanningFailure, request: Request, time: float, setup: NavigatorSetup
) -> bool:
    """Check that planning for the same request failed less than ``min_interval`` ago."""
    before = failure.request
    same = identical(before.goal, request.goal) and identical(before.wishes, request.wishes)
    return same and time - failure.time < setup.replanning.min_interval - _ROUNDING


def planning_reason(error: PlanningError) -> Reason:
    """Map a planning error to its reason."""
    if isinstance(error, GoalBlocked) and error.because:
        return Reason.KEEPOUT
    known = {reason.value: reason for reason in Reason}
    return known.get(error.code, Reason.PLANNING)
