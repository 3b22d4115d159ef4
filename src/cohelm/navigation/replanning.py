"""When to plan a new route, and which one to keep.

The path is kept while it is good. A new one is planned when there is none, when the goal or a wish
changes, when the way ahead has been blocked for a while, when the chair has left its path, when it
has not got on for long, and while the rider steers: then from where the hand leads, so that the
path follows the rider round an obstacle and not the other way.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, identical, value
from cohelm.config import Model
from cohelm.errors import PlanningError
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.maps import DistanceField, OccupancyGrid
from cohelm.messages import Authority, LiveObstacles, Path, People, Request, Wish
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.robots import Robot

_ROUNDING = 1e-9  # s; times are sums of float steps


class ReplanningParameters(Model):
    """When a path is no longer good; assumed."""

    blocked_time: float = Field(0.7, ge=0.0, le=30.0)
    """How long the way ahead must be blocked, s."""
    look_ahead: float = Field(6.0, gt=0.0, le=50.0)
    """How far ahead of the chair the path is watched, m."""
    astray: float = Field(1.0, gt=0.0, le=10.0)
    """Distance from the path at which it is given up, m."""
    stalled_time: float = Field(6.0, gt=0.0, le=120.0)
    """How long without progress until another way is looked for, s."""
    steering: float = Field(0.5, ge=0.0, le=1.0)
    """η from which the path follows the rider's hand."""
    standing: float = Field(0.3, ge=0.0, le=3.0)
    """People slower than this are walked round by a stalled ride, m/s."""
    rest: float = Field(0.5, ge=0.0, le=30.0)
    """Least time between two plans, s."""


@value
class RouteState:
    """What replanning remembers."""

    request: Request
    """What the path was planned for."""
    path: Path
    planned_at: float
    """s."""
    wished_from: Floats
    """Where the chair was when the wishes were set, (2,), m."""
    wishes: tuple[Wish, ...] = ()
    """Those that are still ahead."""
    progress: float = 0.0
    """Arc length of the chair's projection on the path, m."""
    blocked_since: float = math.inf
    """Since when the way ahead is blocked, s."""


@value
class RouteQuestion:
    """Everything that decides whether to plan anew."""

    time: float
    request: Request
    pose: Floats
    robot: Robot
    grid: OccupancyGrid
    live: LiveObstacles
    walls: DistanceField
    """About the chair."""
    authority: Authority | None
    people: People
    stalled_for: float
    """How long the ride has not got on, s."""


def route(
    question: RouteQuestion,
    planner: GlobalPlanner,
    memory: RouteState | None,
    parameters: ReplanningParameters,
) -> RouteState:
    """The path to follow now.

    Raises:
        PlanningError: if there is no path at all; a path there is is kept when replanning fails.
    """
    q, p = question, parameters
    if memory is None or _asks_anew(q.request, memory.request):
        return _planned(q, planner, q.pose[:2], q.request.wishes, wished_from=q.pose[:2])
    path, wishes = memory.path, _ahead(memory)
    _, beside = nearest_on_polyline(path.points, float(q.pose[0]), float(q.pose[1]))
    blocked = _blocked(path, memory.progress, q, p)
    since = min(memory.blocked_since, q.time) if blocked else math.inf
    kept = dataclasses.replace(memory, request=q.request, wishes=wishes, blocked_since=since)
    if q.time - memory.planned_at < p.rest - _ROUNDING:
        return kept
    steering = q.authority if q.authority and q.authority.eta >= p.steering else None
    stalled = q.stalled_for >= p.stalled_time - _ROUNDING
    shut = q.time - since >= p.blocked_time - _ROUNDING
    if not (shut or stalled or steering or beside > p.astray):
        return kept
    try:
        start = _start(q, steering) if steering else q.pose[:2]
        if stalled:
            q = dataclasses.replace(q, live=_with_standing_people(q, p))
        return _planned(q, planner, start, wishes, wished_from=memory.wished_from)
    except PlanningError:
        return kept


def _asks_anew(now: Request, then: Request) -> bool:
    return not (identical(now.goal, then.goal) and identical(now.wishes, then.wishes))


def _ahead(memory: RouteState) -> tuple[Wish, ...]:
    """The wishes but for attracting points that the chair has passed along its path."""
    points = memory.path.points

    def passed(wish: Wish) -> bool:
        x, y = wish.points[-1]
        along, _ = nearest_on_polyline(points, float(x), float(y))
        return wish.kind == "attract" and along <= memory.progress

    return tuple(wish for wish in memory.wishes if not passed(wish))


def _planned(
    q: RouteQuestion,
    planner: GlobalPlanner,
    start: Floats,
    wishes: tuple[Wish, ...],
    *,
    wished_from: Floats,
) -> RouteState:
    path = planner.plan(
        RouteProblem(
            grid=q.grid,
            robot=q.robot,
            start=start,
            goal=q.request.goal,
            wishes=wishes,
            wished_from=wished_from,
            live=q.live,
            clearance=q.request.profile.clearance,
        )
    )
    return RouteState(
        request=q.request, path=path, planned_at=q.time, wished_from=wished_from, wishes=wishes
    )


def _with_standing_people(q: RouteQuestion, p: ReplanningParameters) -> LiveObstacles:
    """The live obstacles, and who stands in the window as if they were things."""
    standing = np.hypot(*q.people.mean[:, 2:].T) < p.standing
    occupied = q.live.occupied.copy()
    rows, cols = np.indices(occupied.shape)
    centres = q.grid.centres(np.stack([rows, cols], axis=-1) + q.live.corner)
    for (x, y), radius in zip(q.people.mean[standing, :2], q.people.radius[standing], strict=True):
        occupied[np.hypot(centres[..., 0] - x, centres[..., 1] - y) < radius] = 1
    return dataclasses.replace(q.live, occupied=occupied)


def _start(q: RouteQuestion, steering: Authority) -> Floats:
    """Where the rider's hand leads within the horizon, as far as the chair fits there."""
    led = steering.states.poses[:, :2]
    fits = q.walls.at(led) > q.robot.inscribed_radius + q.request.profile.clearance
    reach = len(led) if fits.all() else int(np.argmin(fits))
    start: Floats = led[max(reach - 1, 0)]
    return start


def _blocked(path: Path, progress: float, q: RouteQuestion, p: ReplanningParameters) -> bool:
    """Whether something narrows the way ahead to less than the chair's width."""
    along = arc_length(path.points)
    ahead = path.points[(along >= progress) & (along <= progress + p.look_ahead)]
    inside = np.hypot(*(ahead - q.pose[:2]).T) < p.look_ahead
    return bool((q.walls.at(ahead[inside]) < q.robot.inscribed_radius).any())
