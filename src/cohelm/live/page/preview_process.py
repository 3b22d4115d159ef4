"""Process of route previews: plans with and without a wish, and returns the difference.

It is separate from the navigator's process, so that nothing waits for these plans.
"""

from __future__ import annotations

import contextlib
import os
import pickle
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection

import numpy as np

from cohelm.errors import PlanningError
from cohelm.live.control.ipc import Points, ProcessReady, ProcessSetup
from cohelm.live.control.owner_pipe import OwnerGone, OwnerPipe, build_again
from cohelm.live.control.planning_context import PlanningContext, warm_up_wishes
from cohelm.live.control.view_model import route_view
from cohelm.messages import Crowding, LiveObstacles, Path, Wish
from cohelm.navigation import planning_reason
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.processes import end_with_owner, leave_interrupts
from cohelm.scenarios import RideSetup

_NICENESS = 10
"""Niceness added to that of the navigator's process."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PreviewRequest:
    """Request for the route with one more wish."""

    id: int
    client: str
    wish: Wish
    planning_context: bytes
    """Pickled :class:`PlanningContext`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PreviewAnswer:
    """Route with the wish of a request."""

    id: int
    client: str
    points: Points = ()
    length: float = 0.0
    """m."""
    extra_length: float = 0.0
    """Difference from the route without the wish, m."""
    error: str = ""
    """Reason why there is no route; empty if there is one."""


def serve_previews(pipe: Connection, setup: ProcessSetup) -> None:
    """Main function of the process: answer requests until the owner closes the pipe.

    Any fault ends the process with its traceback on stderr; the owner starts another one.
    """
    leave_interrupts()
    end_with_owner()
    ride_setup = build_again(setup)
    if ride_setup is None:
        return
    os.nice(_NICENESS)
    warm_up(ride_setup)
    with contextlib.suppress(OwnerGone):  # the owner has closed the pipe: the drive is over
        _serve(OwnerPipe(pipe), ride_setup)


def _serve(pipe: OwnerPipe, ride_setup: RideSetup) -> None:
    pipe.send(ProcessReady(done=True))
    while True:
        pipe.send(preview(pipe.receive(), ride_setup))


def warm_up(ride_setup: RideSetup) -> None:
    """Preview one wish of each kind, with a live obstacle and people that exist only here."""
    start, request, grid = ride_setup.route.points[0], ride_setup.request, ride_setup.grid
    obstacle = np.zeros((40, 40), dtype=np.uint8)
    obstacle[30:33, 30:33] = 1
    context = PlanningContext(
        pose=np.array([*start, 0.0]),
        goal=request.goal,
        wishes=(),
        wish_origin=start,
        clearance=request.profile.clearance,
        live=LiveObstacles(corner=np.array(grid.cells(start)), occupied=obstacle, version=1),
        crowding=Crowding(
            density=np.full((4, 4), 0.1, dtype=np.float32),
            resolution=1.0,
            X_MG=np.array([*start, 0.0]),
            version=1,
        ),
    )
    for number, wish in enumerate(warm_up_wishes(ride_setup)):
        pickled = pickle.dumps(context)
        preview(
            PreviewRequest(id=number, client="", wish=wish, planning_context=pickled), ride_setup
        )


def preview(request: PreviewRequest, ride_setup: RideSetup) -> PreviewAnswer:
    """Plan the route with and without a wish.

    Args:
        request: Wish, and the context of the current route.
        ride_setup: Map, chair and planner.
    """
    context: PlanningContext = pickle.loads(request.planning_context)  # from our own process
    planner = ride_setup.navigator.global_planner
    problem = RouteProblem(
        grid=ride_setup.grid,
        robot=ride_setup.robot,
        start=context.pose[:2],
        goal=context.goal,
        wishes=context.wishes,
        wish_origin=context.wish_origin,
        live=context.live,
        crowding=context.crowding,
        filters=ride_setup.navigator.filters,
        clearance=context.clearance,
    )
    wishes = (*context.wishes, request.wish)
    wished = replace(problem, wishes=wishes, wish_origin=context.pose[:2])
    try:
        path = planner.plan(wished)
    except PlanningError as error:
        text = planning_reason(error).sentence
        return PreviewAnswer(id=request.id, client=request.client, error=text)
    current = _plan_or_none(planner, problem)
    return PreviewAnswer(
        id=request.id,
        client=request.client,
        points=route_view(path).points,
        length=round(path.length, 2),
        extra_length=round(path.length - current.length, 2) if current is not None else 0.0,
    )


def _plan_or_none(planner: GlobalPlanner, problem: RouteProblem) -> Path | None:
    try:
        return planner.plan(problem)
    except PlanningError:
        return None
