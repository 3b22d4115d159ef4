"""Replanning: keep the current path, or plan a new one.

A path is kept while it is usable. A new one is planned if there is none, if the goal or a wish
changes, if the path ahead has been blocked for some time, if the chair has left the path, makes no
progress or has backed up (``recovery``), and while the rider steers away from it, except near the
goal. Then the new path starts where the rider's input leads, so that it passes an obstacle on the
side that the rider chose.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, identical, replace, value
from cohelm.config import Model
from cohelm.errors import PlanningError
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.messages import Authority, Path, Request, Wish
from cohelm.navigation.replanning.remaining_path import (
    remaining_wishes,
    trim_strokes,
)
from cohelm.navigation.replanning.route_query import PlanReason, RouteQuery
from cohelm.navigation.static_people import with_closed_side, with_static_people
from cohelm.planning import GlobalPlanner, RouteProblem


def is_blocked(path: Path, progress: float, query: RouteQuery, lookahead: float) -> bool:
    """Check for a passage ahead on the path that is narrower than the chair.

    Args:
        path: followed now.
        progress: arc length of the chair on it, m.
        query: pose, walls and robot.
        lookahead: distance ahead of the chair over which the path is checked, m.
    """
    along = arc_length(path.points)
    ahead = path.points[(along >= progress) & (along <= progress + lookahead)]
    near = ahead[np.hypot(*(ahead - query.pose[:2]).T) < lookahead]
    return bool((query.walls.at(near) < query.robot.inscribed_radius).any())


_ROUNDING = 1e-9  # s; times are sums of float steps
_TURN_INTERVAL = 2.0
"""Minimum time after a plan or an attempt where the path begins behind a chair that cannot turn to
it, s; the next one may have no manoeuvre either."""


class ReplanningParameters(Model):
    """Conditions for planning a new path; assumed."""

    blocked_time: float = Field(0.7, ge=0.0, le=30.0)
    """Time for which the path ahead must be blocked, s."""
    lookahead: float = Field(6.0, gt=0.0, le=50.0)
    """Distance ahead of the chair over which the path is checked, m."""
    max_deviation: float = Field(1.0, gt=0.0, le=10.0)
    """Distance from the path beyond which it is given up, m."""
    steering_eta: float = Field(0.5, ge=0.0, le=1.0)
    """Minimum η at which the path follows the rider's input."""
    steering_offset: float = Field(0.2, ge=0.0, le=5.0)
    """Minimum distance from the path of the rider's predicted position, m."""
    docking_distance: float = Field(1.5, ge=0.0, le=10.0)
    """Remaining length below which the path no longer follows the rider, m: otherwise it could
    begin beyond the goal."""
    steering_effort: float = Field(0.15, gt=0.0, le=1.0)
    """Share of the planner's budget for following the rider: planning is repeated at once, and the
    old path is kept until it succeeds."""
    standing_speed: float = Field(0.3, ge=0.0, le=3.0)
    """Speed below which people are obstacles to a stalled ride, m/s."""
    min_interval: float = Field(0.5, ge=0.0, le=30.0)
    """Minimum time between two plans, s."""


@value
class RouteState:
    """The current path, and the state of replanning."""

    request: Request
    """Request for which the path was planned."""
    path: Path
    planned_at: float
    """s."""
    reason: PlanReason
    """Cause of planning it."""
    replans: int = 0
    """Number of paths before this one."""
    wish_origin: Floats
    """Position of the chair when the wishes were set, (2,), m."""
    wishes: tuple[Wish, ...] = ()
    """Remaining wishes."""
    progress: float = 0.0
    """Arc length of the chair's projection on the path, m."""
    leg: int = 0
    """Index of the leg of the path that the chair drives, see ``remaining_path.leg_of``."""
    blocked_since: float = math.inf
    """Time since which the path ahead is blocked, s."""
    attempted_at: float = -math.inf
    """Time of the last attempt to replan that failed, or whose path was refused, s."""


def update_route(
    query: RouteQuery,
    planner: GlobalPlanner,
    memory: RouteState | None,
    parameters: ReplanningParameters,
) -> RouteState:
    """Return the path to follow now.

    Raises:
        PlanningError: if there is no path at all; an existing path is kept if replanning fails.
    """
    q, p = query, parameters
    changed = _changed_request(q.request, memory)
    if memory is None or changed is not None:
        here = q.pose[:2]
        path = planner.plan(_problem(q, here, q.request.wishes, wish_origin=here, effort=1.0))
        return _first_route(q, path, changed or PlanReason.FIRST, memory)
    current = _update(memory, q, p)
    if q.time - max(current.attempted_at, current.planned_at) < p.min_interval - _ROUNDING:
        return current
    reason = _cause(q, current, p)
    return current if reason is None else _replan(q, planner, current, reason, p)


def _changed_request(now: Request, memory: RouteState | None) -> PlanReason | None:
    if memory is None:
        return None
    if not identical(now.goal, memory.request.goal):
        return PlanReason.GOAL
    return None if identical(now.wishes, memory.request.wishes) else PlanReason.WISH


def _update(memory: RouteState, q: RouteQuery, p: ReplanningParameters) -> RouteState:
    """Update remaining wishes and blockage of the current path."""
    blocked = is_blocked(memory.path, memory.progress, q, p.lookahead)
    return replace(
        memory,
        request=q.request,
        wishes=remaining_wishes(memory.wishes, memory.path, memory.progress),
        blocked_since=min(memory.blocked_since, q.time) if blocked else math.inf,
    )


def _cause(q: RouteQuery, current: RouteState, p: ReplanningParameters) -> PlanReason | None:
    x, y = q.pose[:2]
    _, deviation = nearest_on_polyline(current.path.points, float(x), float(y))
    searched_at = max(current.planned_at, current.attempted_at)
    rules = (
        (q.time - current.blocked_since >= p.blocked_time - _ROUNDING, PlanReason.BLOCKED),
        (q.stalled, PlanReason.STALLED),
        (q.backed_up, PlanReason.BACKED_UP),
        (q.cannot_turn and q.time - searched_at >= _TURN_INTERVAL - _ROUNDING, PlanReason.TURN),
        (_rider_leaves_path(q, current, p), PlanReason.STEERING),
        (deviation > p.max_deviation, PlanReason.OFF_PATH),
    )
    return next((reason for holds, reason in rules if holds), None)


def _replan(
    q: RouteQuery,
    planner: GlobalPlanner,
    current: RouteState,
    reason: PlanReason,
    p: ReplanningParameters,
) -> RouteState:
    """Plan a new path; keep the old one if there is none."""
    steering = _steering(q, current, p)
    start = _steered_start(q, steering, current, p.docking_distance) if steering else q.pose[:2]
    query = q
    if q.stalled or q.side != "none":
        live = with_static_people(q.live, q.grid, q.people, p.standing_speed)
        live = with_closed_side(q.side, live, q.grid, q.people, q.pose, p.standing_speed)
        query = replace(q, live=live)
    try:
        effort = p.steering_effort if reason is PlanReason.STEERING else 1.0
        path = planner.plan(_problem_from(query, start, current, effort))
    except PlanningError:
        return replace(current, attempted_at=q.time)
    return _next_route(q, path, reason, current)


def _problem_from(
    q: RouteQuery, start: Floats, current: RouteState, effort: float = 1.0
) -> RouteProblem:
    return _problem(
        q,
        start,
        trim_strokes(current.wishes, current.path, current.progress),
        wish_origin=current.wish_origin,
        effort=effort,
    )


def _problem(
    q: RouteQuery,
    start: Floats,
    wishes: tuple[Wish, ...],
    *,
    wish_origin: Floats,
    effort: float,
) -> RouteProblem:
    return RouteProblem(
        grid=q.grid,
        robot=q.robot,
        start=start,
        start_heading=float(q.pose[2]) if np.array_equal(start, q.pose[:2]) else math.nan,
        goal=q.request.goal,
        wishes=wishes,
        wish_origin=wish_origin,
        live=q.live,
        crowding=q.crowding,
        groups=q.groups,
        filters=q.filters,
        clearance=q.request.profile.clearance,
        effort=effort,
    )


def _first_route(
    q: RouteQuery, path: Path, reason: PlanReason, before: RouteState | None
) -> RouteState:
    """State on a path to a new goal or with new wishes; nothing else is kept."""
    return RouteState(
        request=q.request,
        path=path,
        planned_at=q.time,
        reason=reason,
        replans=before.replans + 1 if before else 0,
        wish_origin=q.pose[:2],
        wishes=q.request.wishes,
    )


def _next_route(q: RouteQuery, path: Path, reason: PlanReason, current: RouteState) -> RouteState:
    """State on a new path to the same goal."""
    return replace(
        current,
        path=path,
        planned_at=q.time,
        reason=reason,
        replans=current.replans + 1,
        progress=0.0,
        leg=0,
        blocked_since=math.inf,
    )


def _steering(q: RouteQuery, current: RouteState, p: ReplanningParameters) -> Authority | None:
    """Rider input that the path may follow: strong enough, and not near the goal."""
    strong = q.authority is not None and q.authority.eta >= p.steering_eta
    far = current.path.length - current.progress >= p.docking_distance
    return q.authority if strong and far else None


def _rider_leaves_path(q: RouteQuery, current: RouteState, p: ReplanningParameters) -> bool:
    """Check that the rider's input leads away from the path."""
    steering = _steering(q, current, p)
    if steering is None:
        return False
    x, y = _steered_start(q, steering, current, p.docking_distance)
    _, offset = nearest_on_polyline(current.path.points, float(x), float(y))
    return offset > p.steering_offset


def _steered_start(
    q: RouteQuery, steering: Authority, current: RouteState, docking: float
) -> Floats:
    """Last position that the rider's input leads to without contact and not near the goal."""
    positions = steering.states.poses[:, :2]
    fits = q.walls.at(positions) > q.robot.inscribed_radius + q.request.profile.clearance
    along = [nearest_on_polyline(current.path.points, float(x), float(y))[0] for x, y in positions]
    fits &= current.path.length - np.array(along) >= docking
    count = len(positions) if fits.all() else int(np.argmin(fits))
    start: Floats = positions[max(count - 1, 0)]
    return start
