"""When to plan a new route, and which one to keep.

The path is kept while it is good. A new one is planned when there is none, when the goal or a wish
changes, when the way ahead has been blocked for a while, when the chair has left its path, when it
does not get on (``recovery`` says when), when another way has become much better (``better``), and
while the rider steers elsewhere, but for the end of the way: then from where the hand leads, so
that the path follows the rider round an obstacle and not the other way.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, identical, value
from cohelm.config import Model
from cohelm.errors import PlanningError
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.messages import Authority, Path, Request, Wish
from cohelm.navigation.ahead import cut_strokes, rest_of, wishes_ahead
from cohelm.navigation.better import BetterParameters, Left, Lookout, judged, worth_a_look
from cohelm.navigation.groups import cuts
from cohelm.navigation.question import RouteQuestion, Why, problem_of
from cohelm.navigation.standing import as_things, closed_but_for
from cohelm.planning import GlobalPlanner, RouteProblem

_ROUNDING = 1e-9  # s; times are sums of float steps
_LEAVES = frozenset({Why.BLOCKED, Why.BETTER, Why.STALLED})
"""After these the old path is remembered as the one that was left."""


class ReplanningParameters(Model):
    """When a path is no longer good; assumed."""

    blocked_time: float = Field(0.7, ge=0.0, le=30.0)
    """How long the way ahead must be blocked, s."""
    look_ahead: float = Field(6.0, gt=0.0, le=50.0)
    """How far ahead of the chair the path is watched, m."""
    astray: float = Field(1.0, gt=0.0, le=10.0)
    """Distance from the path at which it is given up, m."""
    steering: float = Field(0.5, ge=0.0, le=1.0)
    """η from which the path follows the rider's hand."""
    led_off: float = Field(0.2, ge=0.0, le=5.0)
    """Distance from the path of where the hand leads from which the path follows it, m."""
    docking: float = Field(1.5, ge=0.0, le=10.0)
    """Way left below which the path no longer follows the hand, m: a path from where it leads could
    begin beyond the goal."""
    hand_effort: float = Field(0.15, gt=0.0, le=1.0)
    """Share of its budget that the planner spends on following the hand: it is asked again at once,
    and until it finds something the old path is as good as it was."""
    standing: float = Field(0.3, ge=0.0, le=3.0)
    """People slower than this are walked round by a stalled ride, m/s."""
    rest: float = Field(0.5, ge=0.0, le=30.0)
    """Least time between two plans, s."""
    better: BetterParameters = BetterParameters()
    """When another one replaces a path that is still good."""


@value
class RouteState:
    """What replanning remembers."""

    request: Request
    """What the path was planned for."""
    path: Path
    planned_at: float
    """s."""
    why: Why
    """What the path was planned for."""
    replans: int = 0
    """How many paths there were before this one."""
    wished_from: Floats
    """Where the chair was when the wishes were set, (2,), m."""
    wishes: tuple[Wish, ...] = ()
    """What of them is still ahead."""
    progress: float = 0.0
    """Arc length of the chair's projection on the path, m."""
    blocked_since: float = math.inf
    """Since when the way ahead is blocked, s."""
    asked_at: float = -math.inf
    """When the planner was last asked because the path was no longer good, s."""
    lookout: Lookout
    left: Left | None = None


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
    new = _asks_anew(q.request, memory)
    if memory is None or new is not None:
        here = q.pose[:2]
        path = planner.plan(problem_of(q, here, q.request.wishes, wished_from=here, kept=None))
        return _started(q, path, new or Why.FIRST, memory)
    kept = _kept(memory, q, p)
    if q.time - max(kept.asked_at, kept.planned_at) < p.rest - _ROUNDING:
        return kept
    why = _no_longer_good(q, kept, p)
    if why is not None:
        return _replaced(q, planner, kept, why, p)
    return _better(q, planner, kept, p)


def _asks_anew(now: Request, memory: RouteState | None) -> Why | None:
    if memory is None:
        return None
    if not identical(now.goal, memory.request.goal):
        return Why.GOAL
    return None if identical(now.wishes, memory.request.wishes) else Why.WISH


def _kept(memory: RouteState, q: RouteQuestion, p: ReplanningParameters) -> RouteState:
    """The path there is, with what has become of it."""
    blocked = _blocked(memory.path, memory.progress, q, p)
    return replace(
        memory,
        request=q.request,
        wishes=wishes_ahead(memory.wishes, memory.path, memory.progress),
        blocked_since=min(memory.blocked_since, q.time) if blocked else math.inf,
    )


def _no_longer_good(q: RouteQuestion, kept: RouteState, p: ReplanningParameters) -> Why | None:
    x, y = q.pose[:2]
    _, beside = nearest_on_polyline(kept.path.points, float(x), float(y))
    rules = (
        (q.time - kept.blocked_since >= p.blocked_time - _ROUNDING, Why.BLOCKED),
        (q.stalled, Why.STALLED),
        (_led_off(q, kept, p), Why.STEERING),
        (beside > p.astray, Why.ASTRAY),
    )
    return next((why for holds, why in rules if holds), None)


def _replaced(
    q: RouteQuestion,
    planner: GlobalPlanner,
    kept: RouteState,
    why: Why,
    p: ReplanningParameters,
) -> RouteState:
    """A new path; the old one where there is none."""
    steering = _steers(q, kept, p)
    start = _start(q, steering, kept, p.docking) if steering else q.pose[:2]
    asked = q
    if q.stalled or q.side != "none":
        live = as_things(q.live, q.grid, q.people, p.standing)
        live = closed_but_for(q.side, live, q.grid, q.people, q.pose, p.standing)
        asked = replace(q, live=live)
    try:
        effort = p.hand_effort if why is Why.STEERING else 1.0
        path = planner.plan(_anew(asked, start, kept, effort))
    except PlanningError:
        return replace(kept, asked_at=q.time)
    return _followed(q, path, why, kept)


def _better(
    q: RouteQuestion, planner: GlobalPlanner, kept: RouteState, p: ReplanningParameters
) -> RouteState:
    """A much better path, where there is one; else the one there is."""
    if (
        q.time - kept.planned_at < p.better.settle - _ROUNDING
        or kept.path.length - kept.progress < p.better.least_left
    ):
        return kept
    cut = cuts(rest_of(kept.path, kept.progress), q.groups) if q.groups else 0
    if not worth_a_look(
        kept.lookout, q.time, q.live, q.crowding, q.grid.resolution, p.better, cuts=cut
    ):
        return kept
    look = replace(kept.lookout, at=q.time, live=q.live, crowding=q.crowding, cuts=cut)
    problem = _anew(q, q.pose[:2], kept)
    try:
        path = planner.plan(problem)
    except PlanningError:
        return replace(kept, lookout=look)
    why, look = judged(
        path,
        rest_of(kept.path, kept.progress),
        look,
        kept.left,
        time=q.time,
        blocked_time=p.blocked_time,
        parameters=p.better,
    )
    if why is None:
        return replace(kept, lookout=look)
    return _followed(q, path, why, kept)


def _anew(q: RouteQuestion, start: Floats, kept: RouteState, effort: float = 1.0) -> RouteProblem:
    return problem_of(
        q,
        start,
        cut_strokes(kept.wishes, kept.path, kept.progress),
        wished_from=kept.wished_from,
        kept=rest_of(kept.path, kept.progress),
        effort=effort,
    )


def _started(q: RouteQuestion, path: Path, why: Why, before: RouteState | None) -> RouteState:
    """On the way to a new goal or by a new wish: nothing is remembered."""
    return RouteState(
        request=q.request,
        path=path,
        planned_at=q.time,
        why=why,
        replans=before.replans + 1 if before else 0,
        wished_from=q.pose[:2],
        wishes=q.request.wishes,
        lookout=Lookout(at=q.time, live=q.live, crowding=q.crowding),
    )


def _followed(q: RouteQuestion, path: Path, why: Why, kept: RouteState) -> RouteState:
    """On a new path to the same goal."""
    left = Left(points=rest_of(kept.path, kept.progress), at=q.time) if why in _LEAVES else None
    return replace(
        kept,
        path=path,
        planned_at=q.time,
        why=why,
        replans=kept.replans + 1,
        progress=0.0,
        blocked_since=math.inf,
        lookout=Lookout(
            at=q.time, live=q.live, crowding=q.crowding, compares=kept.lookout.compares
        ),
        left=left,
    )


def _steers(q: RouteQuestion, kept: RouteState, p: ReplanningParameters) -> Authority | None:
    leads = q.authority is not None and q.authority.eta >= p.steering
    return q.authority if leads and kept.path.length - kept.progress >= p.docking else None


def _led_off(q: RouteQuestion, kept: RouteState, p: ReplanningParameters) -> bool:
    """Whether the hand leads elsewhere than the path."""
    steering = _steers(q, kept, p)
    if steering is None:
        return False
    x, y = _start(q, steering, kept, p.docking)
    _, beside = nearest_on_polyline(kept.path.points, float(x), float(y))
    return beside > p.led_off


def _start(q: RouteQuestion, steering: Authority, kept: RouteState, docking: float) -> Floats:
    """Where the rider's hand leads within the horizon, where the chair fits and does not dock."""
    led = steering.states.poses[:, :2]
    fits = q.walls.at(led) > q.robot.inscribed_radius + q.request.profile.clearance
    along = [nearest_on_polyline(kept.path.points, float(x), float(y))[0] for x, y in led]
    fits &= kept.path.length - np.array(along) >= docking
    reach = len(led) if fits.all() else int(np.argmin(fits))
    start: Floats = led[max(reach - 1, 0)]
    return start


def _blocked(path: Path, progress: float, q: RouteQuestion, p: ReplanningParameters) -> bool:
    """Whether something narrows the way ahead to less than the chair's width."""
    along = arc_length(path.points)
    ahead = path.points[(along >= progress) & (along <= progress + p.look_ahead)]
    inside = np.hypot(*(ahead - q.pose[:2]).T) < p.look_ahead
    return bool((q.walls.at(ahead[inside]) < q.robot.inscribed_radius).any())
