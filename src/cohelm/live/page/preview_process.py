"""Process of route previews: the routes of a trip with its wishes.

It is separate from the navigator's process, so that nothing waits for these plans.
"""

from __future__ import annotations

import contextlib
import pickle
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path as File

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import PlanningError, StoreError
from cohelm.geometry import nearest_on_polyline, resample
from cohelm.live.control.ipc import ProcessReady, ProcessSetup
from cohelm.live.control.owner_pipe import OwnerGone, OwnerPipe, build_again
from cohelm.live.control.planning_context import PlanningContext, warm_up_wishes
from cohelm.live.control.view_model import shown_line
from cohelm.live.messages import RouteDifference, RouteFigures, TripPlans, TripRoute
from cohelm.live.sessions.database import Database
from cohelm.live.sessions.route_choices import learned_preference
from cohelm.messages import LiveObstacles, Path, Wish
from cohelm.navigation import planning_reason
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.planning.alternatives.alternatives import (
    Alternative,
    AlternativeCriteria,
    find_alternatives,
    most_shared,
)
from cohelm.planning.alternatives.features import FeatureParameters, route_features
from cohelm.planning.alternatives.learned_preference import (
    FeatureVector,
    differences,
    preferred_order,
)
from cohelm.planning.costmap.layers.zones import distances_to_zone
from cohelm.planning.planners.route import parameters_of
from cohelm.planning.problem import prepare
from cohelm.processes import end_with_owner, leave_interrupts
from cohelm.scenarios import RideSetup

MAX_ROUTES = 3
"""Maximum number of routes to choose from."""
VIA_TOLERANCE = 1.0
"""Maximum distance of the planned route from the point that was wished for, m; assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TripRequest:
    """Request for the routes to a destination."""

    id: int
    client: str
    goal: tuple[float, float]
    """m."""
    wishes: tuple[Wish, ...]
    rider: str = ""
    """Id of the rider, whose choices decide the order."""
    planning_context: bytes = b""
    """Pickled :class:`PlanningContext`; empty: not known yet."""


def serve_previews(pipe: Connection, setup: ProcessSetup) -> None:
    """Main function of the process: answer requests until the owner closes the pipe.

    Any fault ends the process with its traceback on stderr; the owner starts another one.
    """
    leave_interrupts()
    end_with_owner()
    ride_setup = build_again(setup)
    if ride_setup is None:
        return
    warm_up(ride_setup)
    with contextlib.suppress(OwnerGone):  # the owner has closed the pipe: the drive is over
        _serve(OwnerPipe(pipe), ride_setup, setup.folder)


def _serve(pipe: OwnerPipe, ride_setup: RideSetup, folder: File | None) -> None:
    pipe.send(ProcessReady(done=True))
    while True:
        request: TripRequest = pipe.receive()
        for answer in trip_answers(request, ride_setup, _weights_of(request.rider, folder)):
            pipe.send(answer)


def _weights_of(rider: str, folder: File | None) -> FeatureVector | None:
    with contextlib.suppress(StoreError):  # a preference is no reason to lose the routes
        return learned_preference(Database(folder), rider) if folder is not None else None
    return None


def warm_up(ride_setup: RideSetup) -> None:
    """Plan a trip with a wish of each kind, a live obstacle and people that exist only here."""
    start, request, grid = ride_setup.route.points[0], ride_setup.request, ride_setup.grid
    obstacle = np.zeros((40, 40), dtype=np.uint8)
    obstacle[30:33, 30:33] = 1
    context = PlanningContext(
        pose=np.array([*start, 0.0]),
        clearance=request.profile.clearance,
        speed=request.profile.preferred_speed,
        live=LiveObstacles(corner=np.array(grid.cells(start)), occupied=obstacle, version=1),
    )
    pickled = pickle.dumps(context)
    goal = (float(request.goal[0]), float(request.goal[1]))
    for wishes in ((), warm_up_wishes(ride_setup)):
        trip = TripRequest(id=0, client="", goal=goal, wishes=wishes, planning_context=pickled)
        for _ in trip_answers(trip, ride_setup):
            pass


def trip_answers(
    request: TripRequest, ride_setup: RideSetup, weights: FeatureVector | None = None
) -> Iterator[TripPlans]:
    """Plan the routes to a destination: the planner's own, and then once more with alternatives.

    Their order is the rider's, once it is learned, and then all come at once; before, the planner's
    own comes as soon as it is known, and the alternatives by their cost.

    An alternative comes with the point where it is farthest from the first route, and is the path
    that the planner takes once that point is wished for, with all other wishes.

    Args:
        request: Destination, wishes and context.
        ride_setup: Map, chair and planner.
        weights: Learned from the rider's choices; None: too few.
    """
    context: PlanningContext = pickle.loads(request.planning_context)  # from our own process
    problem = _problem(request, context, ride_setup)
    measuring = FeatureParameters(speed=context.speed)
    criteria = AlternativeCriteria(measuring=measuring)
    planner = ride_setup.navigator.global_planner
    try:
        own = planner.plan(problem)
        if weights is None:
            found = find_alternatives(problem, planner, 1, criteria, first=own)
            yield _trip_plans(request, found, [None], None).model_copy(update={"complete": False})
        found = find_alternatives(problem, planner, MAX_ROUTES, criteria, first=own)
    except PlanningError as error:
        text = planning_reason(error).sentence
        yield TripPlans(id=request.id, error=text)
        return
    prepared = prepare(problem, parameters_of(planner))
    shown, vias = [found[0]], list[tuple[float, float] | None]([None])
    for each in found[1:]:
        via = _farthest(each.path.points, found[0].path.points)
        path = _path_by(via, problem, planner)
        # What is shown is what the planner drives, and it still differs from the others.
        if path is None or most_shared(path.points, _paths(shown), criteria) > criteria.overlap:
            continue
        shown.append(replace(each, path=path, features=route_features(prepared, path, measuring)))
        vias.append(via)
    yield _trip_plans(request, shown, vias, weights)


def _trip_plans(
    request: TripRequest,
    shown: Sequence[Alternative],
    vias: Sequence[tuple[float, float] | None],
    weights: FeatureVector | None,
) -> TripPlans:
    """Answer with routes, of which the first is the planner's own."""
    own, order = shown[0].path, preferred_order(shown, weights)
    return TripPlans(
        id=request.id,
        routes=tuple(_trip_route(shown[k], shown[order[0]], vias[k], weights) for k in order),
        learned=weights is not None,
        extra_length=round(own.wishes.extra_length, 2),
        closest=tuple(own.wishes.closest.round(2).tolist()),
        through=_through(own, request.wishes),
    )


def _through(path: Path, wishes: tuple[Wish, ...]) -> tuple[float, ...]:
    """Lengths of a path within each area to avoid, m."""
    points = resample(path.points, 0.1)
    inside = [distances_to_zone(w, points) < 0.0 for w in wishes if w.kind == "avoid"]
    return tuple(round(path.length * float(each.mean()), 2) for each in inside)


def _path_by(
    via: tuple[float, float], problem: RouteProblem, planner: GlobalPlanner
) -> Path | None:
    """Return the path with the wish for a point; None: the planner does not pass it."""
    wish = Wish(points=np.array([via]))
    path = _plan_or_none(planner, replace(problem, wishes=(*problem.wishes, wish)))
    if path is None or nearest_on_polyline(path.points, *via)[1] > VIA_TOLERANCE:
        return None
    return path


def _paths(routes: Sequence[Alternative]) -> tuple[Path, ...]:
    return tuple(each.path for each in routes)


def _trip_route(
    route: Alternative,
    first: Alternative,
    via: tuple[float, float] | None,
    weights: FeatureVector | None,
) -> TripRoute:
    path = route.path
    return TripRoute(
        points=shown_line(path.points),
        length=round(path.length, 2),
        duration=round(route.features.time, 1),
        differences=tuple(
            RouteDifference.model_validate({"what": name, "more": round(more, 2)})
            for name, more in differences(route.features, first.features, weights)
        ),
        via=via,
        figures=RouteFigures.model_validate(FeatureVector.of(route.features).model_dump()),
    )


def _farthest(line: Floats, other: Floats) -> tuple[float, float]:
    """Point of a line (k, 2) that is farthest from another line (m, 2), m."""
    points = resample(line, 0.5)
    apart = [nearest_on_polyline(other, x, y)[1] for x, y in points]
    x, y = points[int(np.argmax(apart))]
    return round(float(x), 2), round(float(y), 2)


def _problem(request: TripRequest, context: PlanningContext, ride_setup: RideSetup) -> RouteProblem:
    return RouteProblem(
        grid=ride_setup.grid,
        robot=ride_setup.robot,
        start=context.pose[:2],
        start_heading=float(context.pose[2]),
        goal=np.array(request.goal),
        wishes=request.wishes,
        wish_origin=context.pose[:2],
        live=context.live,
        crowding=ride_setup.navigator.heat,
        filters=ride_setup.navigator.filters,
        clearance=context.clearance,
    )


def _plan_or_none(planner: GlobalPlanner, problem: RouteProblem) -> Path | None:
    try:
        return planner.plan(problem)
    except PlanningError:
        return None
