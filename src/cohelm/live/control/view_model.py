"""Values for the page computed from a tick: plain tuples, rounded to the millimetre."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.live.control.ipc import OfferRow, PersonRow, Points, Poses, RouteView
from cohelm.live.control.surroundings import in_view
from cohelm.live.messages import RouteCause
from cohelm.messages import Mode, Observation, Path, SocialSpaces
from cohelm.navigation import Tick
from cohelm.shapes import extent, hull_outline

SHOWN_HORIZON = 2.0
"""Part of the plan that is shown, s."""
SHOWN_SPACING = 0.1
"""Approximate distance between the points of a route that is shown, m."""


def rider_authority_of(tick: Tick) -> float:
    """Return the rider's share of control: 1 if they steer alone, 0 if the chair does."""
    if tick.request.mode.rider_drives:
        return 1.0
    if tick.request.mode is Mode.AUTONOMOUS or tick.authority is None:
        return 0.0
    return round(tick.authority.eta, 3)


def remaining_of(tick: Tick) -> float | None:
    """Return the distance along the route, m; None without a route."""
    route = tick.memory.route
    if route is None or tick.path is None:
        return None
    return round(max(route.path.length - route.progress, 0.0), 2)


def route_error_of(tick: Tick) -> str:
    """Return the rider's sentence for a failed plan; empty if there is none."""
    failure = tick.memory.planning_failure
    return failure.reason.sentence if failure is not None else ""


def plan_of(tick: Tick) -> Poses:
    """Return poses of the next two seconds: the planner's, else those that the stick leads to."""
    if tick.plan is not None:
        poses, step = tick.plan.poses, tick.plan.step
    elif tick.authority is not None and tick.request.speed_limit > 0.0:
        poses, step = tick.authority.states.poses, tick.authority.states.step
    else:
        return ()
    every = max(round(0.2 / step), 1)
    shown = poses[: round(SHOWN_HORIZON / step) + 1 : every]
    if not np.isfinite(shown).all():
        return ()
    return tuple((round(x, 3), round(y, 3), round(h, 3)) for x, y, h in shown.tolist())


def people_of(tick: Tick, sweeps: Observation) -> tuple[PersonRow, ...]:
    """Return ``StepAnswer.people``; a person without a space yet has that of their body.

    Args:
        tick: Tick of the navigator.
        sweeps: Newest observation with scans.
    """
    tracked, spaces = tick.people, tick.spaces
    n = len(tracked)
    shape = np.zeros((n, 4))
    shape[:, 1:] = tracked.radius[:, None]
    if spaces is not None and len(spaces.axis) == n:
        for k in range(n):
            shape[k] = _extents(spaces, k)
    group = np.full(n, -1)
    if tick.groups is not None and len(tick.groups.member) == n and len(tick.groups.id):
        member = tick.groups.member
        group = np.where(member >= 0, tick.groups.id[np.maximum(member, 0)], -1)
    seen = np.array(in_view(sweeps, tracked.mean[:, :2]), dtype=np.float64)
    columns = [tracked.id, tracked.mean, tracked.radius, shape, group, seen]
    rows = np.column_stack(columns).round(3)
    return tuple(PersonRow(*row) for row in rows.tolist() if all(map(math.isfinite, row)))


def groups_of(tick: Tick) -> tuple[Points, ...]:
    """Return the current outlines of the groups' spaces, m."""
    spaces = tick.spaces
    if spaces is None or spaces.groups is None:
        return ()
    hulls = spaces.groups
    lines = (hull_outline(hulls.direction, hulls.support[k, 0]) for k in range(len(hulls.id)))
    return tuple(points_of(line) for line in lines if np.isfinite(line).all())


def offers_of(tick: Tick) -> tuple[OfferRow, ...]:
    """Return the destinations to offer; none while the rider has one."""
    if tick.destinations is None:
        return ()
    return tuple(
        OfferRow(name=each.name, slot=each.slot, highlighted=each.highlighted, why=each.sentence)
        for each in tick.destinations.offers
    )


def route_cause_of(tick: Tick) -> RouteCause:
    """Return the cause of planning the current route."""
    route = tick.memory.route
    return route.reason.value if route is not None else "first"


def route_view(path: Path, cause: RouteCause = "first") -> RouteView:
    """Return a route as the page draws it."""
    return RouteView(
        points=points_of(_thinned(path.points)),
        without_wishes=points_of(_thinned(path.without_wishes)),
        length=round(path.length, 2),
        extra_length=round(path.wishes.extra_length, 2),
        cause=cause,
    )


def points_of(line: Floats) -> Points:
    """Return a line (k, 2), m, as tuples."""
    return tuple((round(x, 3), round(y, 3)) for x, y in line.tolist())


def _extents(spaces: SocialSpaces, k: int) -> Floats:
    """(axis, front, side, rear) of one person's current space, in its first hypothesis."""
    shape = spaces.shape(k)
    ahead, aside, behind = (extent(shape, delta)[0] for delta in (0.0, math.pi / 2.0, math.pi))
    return np.array([spaces.axis[k, 0, 0], ahead, aside, behind])


def _thinned(line: Floats) -> Floats:
    """Reduce a line to the points that a drawing needs, including both ends."""
    if len(line) < 3:
        return line
    step = float(np.hypot(*np.diff(line, axis=0).T).mean())
    every = max(int(SHOWN_SPACING / max(step, 1e-6)), 1)
    kept = line[::every]
    return kept if len(line) % every == 1 or every == 1 else np.vstack([kept, line[-1]])
