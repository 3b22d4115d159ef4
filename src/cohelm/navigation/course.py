"""goal → path → reference, and the rider's hand in it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import identical
from cohelm.errors import GoalBlocked, PlanningError
from cohelm.messages import Authority, Mode, Observation, Reason, Reference, Request
from cohelm.navigation.beyond import all_obstacles
from cohelm.navigation.groups import outlines
from cohelm.navigation.progress import ProgressState, progress
from cohelm.navigation.question import Refusal, RouteQuestion, Why
from cohelm.navigation.recovery import Recovery
from cohelm.navigation.replanning import RouteState, route
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.sight import Sight
from cohelm.navigation.situation import backwards
from cohelm.navigation.tick import Memory
from cohelm.planning import reference
from cohelm.sharing import blended

_ROUNDING = 1e-9  # s; times are sums of float steps


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """Where to go, or why nowhere."""

    route: RouteState | None = None
    reference: Reference | None = None
    """Along the path."""
    shared: Reference | None = None
    """The same, blended with the rider's states where the mode is shared; backwards where the chair
    backs up."""
    progress: ProgressState | None = None
    refusal: Refusal | None = None
    """Why there is no path, where there is none."""


def lay_course(
    setup: NavigatorSetup,
    observation: Observation,
    request: Request,
    sight: Sight,
    hand: Authority,
    memory: Memory | None,
    *,
    remedy: Recovery,
    rests: bool,
) -> Course:
    """The path to follow now and the reference along it; a planning error is its reason.

    With nowhere to go there is none of it.

    Args:
        setup: the parts.
        observation: where the robot is.
        request: where it is to go.
        sight: what stands in the way.
        hand: the rider's authority.
        memory: of the last tick, None at first.
        remedy: what is done where the ride does not get on.
        rests: the chair is not to get on.
    """
    if np.isnan(request.goal).any():
        return Course()
    before, pace = (memory.route, memory.progress) if memory else (None, None)
    refused = memory.refusal if memory else None
    if refused is not None and _still(refused, request, observation.time, setup):
        return Course(refusal=refused)
    shares = request.mode is Mode.SHARED
    question = RouteQuestion(
        time=observation.time,
        request=request,
        pose=observation.pose,
        robot=setup.robot,
        grid=setup.grid,
        live=all_obstacles(sight.live, sight.beyond),
        walls=sight.walls,
        authority=hand if shares else None,
        people=sight.people,
        stalled=remedy.replans,
        side=remedy.side,
        crowding=sight.crowding.told if sight.crowding.told.density.any() else None,
        groups=outlines(sight.people, sight.groups, setup.replanning.standing),
        filters=setup.filters,
    )
    try:
        state = route(question, setup.global_planner, before, setup.replanning)
    except PlanningError as error:
        return Course(
            refusal=Refusal(
                request=request,
                time=observation.time,
                reason=reason_of(error),
                trouble=str(error),
            )
        )
    along, at = reference(
        state.path,
        observation.pose,
        observation.twist,
        steps=setup.local_planner.steps,
        step=setup.local_planner.step,
        speed=setup.speed_limit(request),
        robot=setup.robot,
        progress=state.progress,
        comfort=setup.comfort,
    )
    left = state.path.length - at
    pace = progress(
        left,
        observation.time,
        state.planned_at,
        pace,
        setup.progress,
        at=observation.pose[:2],
        follows=state.why is Why.STEERING,
        rests=rests,
    )
    if remedy.back > 0.0:
        shared = backwards(
            observation.pose,
            remedy,
            min(setup.recovery.back_up_speed, setup.progress.creep),
            steps=setup.local_planner.steps,
            step=setup.local_planner.step,
        )
    else:
        shared = blended(along, hand) if shares else along
    return Course(
        route=dataclasses.replace(state, progress=at),
        reference=along,
        shared=shared,
        progress=pace,
    )


def _still(refused: Refusal, request: Request, time: float, setup: NavigatorSetup) -> bool:
    """Whether the same is wanted so soon after that the answer would be the same."""
    then = refused.request
    same = identical(then.goal, request.goal) and identical(then.wishes, request.wishes)
    return same and time - refused.time < setup.replanning.rest - _ROUNDING


def reason_of(error: PlanningError) -> Reason:
    """What a rider is told of it."""
    if isinstance(error, GoalBlocked) and error.because:
        return Reason.KEEPOUT
    known = {reason.value: reason for reason in Reason}
    return known.get(error.code, Reason.PLANNING)
