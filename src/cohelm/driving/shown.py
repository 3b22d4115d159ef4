"""From a tick to what a page shows of it: numbers in plain tuples, to the millimetre."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.driving.asking import Points, Way
from cohelm.messages import Mode, Path, SocialSpaces
from cohelm.navigation import Tick
from cohelm.shapes import hull_outline, reach

AHEAD = 2.0
"""Of the plan that is shown, s."""
SPACING = 0.1
"""Between the points of a way that is shown, m, about."""


def eta_of(tick: Tick) -> float:
    """The rider's share, 0…1: all of it where they steer alone, none where the chair does."""
    if tick.request.mode in {Mode.MANUAL, Mode.ASSISTED}:
        return 1.0
    if tick.request.mode is Mode.AUTONOMOUS or tick.authority is None:
        return 0.0
    return round(tick.authority.eta, 3)


def remaining_of(tick: Tick) -> float | None:
    """Along the route, m; None where there is none."""
    way = tick.memory.route
    if way is None or tick.path is None:
        return None
    return round(max(way.path.length - way.progress, 0.0), 2)


def trouble_of(tick: Tick) -> str:
    """Why there is no way, in the rider's words: without coordinates and widths."""
    refusal = tick.memory.refusal
    return refusal.reason.sentence if refusal is not None else ""


def plan_of(tick: Tick) -> tuple[tuple[float, float, float], ...]:
    """Poses of the next two seconds: the planner's, else where the rider's hand leads."""
    if tick.plan is not None:
        poses, step = tick.plan.poses, tick.plan.step
    elif tick.authority is not None and tick.request.speed_limit > 0.0:
        poses, step = tick.authority.states.poses, tick.authority.states.step
    else:
        return ()
    every = max(round(0.2 / step), 1)
    shown = poses[: round(AHEAD / step) + 1 : every]
    if not np.isfinite(shown).all():
        return ()
    return tuple((round(x, 3), round(y, 3), round(h, 3)) for x, y, h in shown.tolist())


def people_of(tick: Tick) -> tuple[tuple[float, ...], ...]:
    """See ``Answer.people``; who has no space yet has a body's."""
    seen, spaces = tick.people, tick.spaces
    n = len(seen)
    shape = np.zeros((n, 4))
    shape[:, 1:] = seen.radius[:, None]
    if spaces is not None and len(spaces.axis) == n:
        for k in range(n):
            shape[k] = _reaches(spaces, k)
    group = np.full(n, -1)
    if tick.groups is not None and len(tick.groups.member) == n and len(tick.groups.id):
        member = tick.groups.member
        group = np.where(member >= 0, tick.groups.id[np.maximum(member, 0)], -1)
    rows = np.column_stack([seen.id, seen.mean, seen.radius, shape, group]).round(3)
    return tuple(tuple(row) for row in rows.tolist() if all(map(math.isfinite, row)))


def groups_of(tick: Tick) -> tuple[Points, ...]:
    """Outlines of the groups' spaces as they are now."""
    spaces = tick.spaces
    if spaces is None or spaces.groups is None:
        return ()
    hulls = spaces.groups
    lines = (hull_outline(hulls.direction, hulls.support[k, 0]) for k in range(len(hulls.id)))
    return tuple(points_of(line) for line in lines if np.isfinite(line).all())


def way_of(path: Path) -> Way:
    """A route as it is drawn."""
    return Way(
        points=points_of(_thinned(path.points)),
        without=points_of(_thinned(path.without_wishes)),
        length=round(path.length, 2),
        extra=round(path.wishes.extra_length, 2),
    )


def points_of(line: Floats) -> Points:
    """(k, 2), m."""
    return tuple((round(x, 3), round(y, 3)) for x, y in line.tolist())


def _reaches(spaces: SocialSpaces, k: int) -> Floats:
    """(axis, front, side, rear) of one person's space now, in its first hypothesis."""
    at = (k, 0, 0)
    front, side, rear = spaces.front[at], spaces.side[at], spaces.rear[at]
    ahead, aside, behind = (
        reach(spaces.kind, front, side, rear, spaces.scale, spaces.floor, delta)[0]
        for delta in (0.0, math.pi / 2.0, math.pi)
    )
    return np.array([spaces.axis[at], ahead, aside, behind])


def _thinned(line: Floats) -> Floats:
    """As many points as a drawing needs, the ends among them."""
    if len(line) < 3:
        return line
    step = float(np.hypot(*np.diff(line, axis=0).T).mean())
    every = max(int(SPACING / max(step, 1e-6)), 1)
    kept = line[::every]
    return kept if len(line) % every == 1 or every == 1 else np.vstack([kept, line[-1]])
