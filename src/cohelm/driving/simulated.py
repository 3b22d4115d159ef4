"""What only a simulation can: somebody comes, or walks into the chair's way.

    floor = ground(stage)                                # once; takes some 50 ms
    world.admit(somebody(floor, world.truth, point, rng))
    world.admit(into_the_way(floor, world.truth, route, rng))

All of it takes some 10 ms at most, and the same generator gives the same people again.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.errors import CohelmError
from cohelm.evaluation.staging import Stage
from cohelm.evaluation.walkable import CELL, Walkable, pulled_tight, spread, trace, walkable
from cohelm.geometry import arc_length
from cohelm.simulation import Newcomer, Truth

MOST = 60
"""People in a scene that somebody can still be added to."""
RADIUS = 0.25
"""Of a body, m."""
SPEED = (1.0, 1.4)
"""At which people who are added like to walk, m/s; assumed, as for those of a scenario."""
NEAR = (2.5, 7.0)
"""How far from the chair somebody comes of whom nobody says where, along the floor, m."""
STROLL = (4.0, 20.0)
"""How far off the place is to which they walk, and back, m."""
MEETING = (2.5, 4.0)
"""How far ahead somebody comes into the way at least, m, and how long before they do, s."""
_SLOWEST = 0.5
"""At which a chair is taken to come that stands or crawls, m/s."""
_SHIFT = 1.5
"""From where somebody is wanted to where there is room for them at most, m."""
_APART = 0.1
"""Between a newcomer's body and everybody else's, m …"""
_FROM_CHAIR = 0.4
"""… and the chair."""


class NoRoom(CohelmError):
    """Nobody can be put there; says why."""

    code: ClassVar[str] = "no_room"


@value
class Ground:
    """Where people can walk on a floor, and where to."""

    walkable: Walkable
    places: Annotated[Floats, Shape("p 2")]
    """Those with names, m."""
    chair: float
    """Radius of the disc about the chair, m."""


def ground(stage: Stage) -> Ground:
    """Of a stage, with every door open."""
    start = stage.start[:2]
    return Ground(
        walkable=walkable(stage.world.grid, RADIUS, np.array([start, start + 0.1])),
        places=np.array([place.point for place in stage.places.places]).reshape(-1, 2),
        chair=stage.robot.circumscribed_radius,
    )


def somebody(
    floor: Ground, truth: Truth, point: Floats | None, rng: np.random.Generator
) -> Newcomer:
    """Somebody who walks to a place with a name and back, for ever; who finds none stands.

    Args:
        floor: where one can walk.
        truth: who is there already.
        point: (2,) where they come, m; None: near the chair.
        rng: all chance.

    Raises:
        NoRoom: if nobody can stand there, or there are :data:`MOST` already.
    """
    free = np.argwhere(_room(floor, truth))
    if point is None:
        _, distance, _ = _ways(floor, truth.pose[:2], NEAR[1])
        away = distance[free[:, 0], free[:, 1]]
        free = free[(away >= NEAR[0]) & (away <= NEAR[1])]
        if not len(free):
            raise NoRoom("There is no room for anybody near the chair.")
        cell = free[rng.integers(len(free))]
    else:
        apart = np.hypot(*(floor.walkable.points(free) - point).T)
        if not len(free) or apart.min() > _SHIFT:
            raise NoRoom("There is no room for anybody there.")
        cell = free[int(np.argmin(apart))]
    at = floor.walkable.points(cell[None])[0]
    way = _stroll(floor, at, rng)
    return _newcomer(np.vstack([at, way]), loop=True, rng=rng)


def into_the_way(floor: Ground, truth: Truth, route: Floats, rng: np.random.Generator) -> Newcomer:
    """Somebody who comes to a point ahead of the chair when it should, and goes on beyond.

    From the side where there is one, else towards the chair. They see it, and avoid it as everybody
    else does.

    Args:
        floor: where one can walk.
        truth: the chair, and who is there already.
        route: (k, 2) the way that the chair follows, m; empty: straight ahead.
        rng: all chance.

    Raises:
        NoRoom: if there is no way for them, or there are :data:`MOST` already.
    """
    speed = max(float(np.hypot(*truth.twist[:2])), _SLOWEST)
    far = max(MEETING[0], MEETING[1] * speed)
    meeting, ahead = _ahead(truth.pose, route, far)
    walks = float(rng.uniform(*SPEED))
    reach = walks * far / speed
    parent, distance, cells = _ways(floor, meeting, 1.5 * reach)
    away = distance[cells[:, 0], cells[:, 1]]
    free = _room(floor, truth)[cells[:, 0], cells[:, 1]]
    starts = cells[free & (away >= 0.6 * reach) & (away <= 1.2 * reach)]
    ends = cells[(away >= 0.5 * reach) & (away <= 1.4 * reach)]
    if not len(starts) or not len(ends):
        raise NoRoom("Nobody finds a way to come from.")
    start = _best(floor, starts, meeting, _across(ahead, rng))
    to_start = floor.walkable.points(start[None])[0] - meeting
    end = _best(floor, ends, meeting, -to_start)
    way = _back_and_on(floor, parent, start, end)
    return _newcomer(way, loop=False, rng=rng, speed=walks)


def _newcomer(
    way: Floats, *, loop: bool, rng: np.random.Generator, speed: float | None = None
) -> Newcomer:
    """Who appears at the first point of a way (k, 2) and walks the rest."""
    ahead = way[1] - way[0] if len(way) > 1 else np.array([1.0, 0.0])
    waypoints = np.vstack([way[1:], way[:1]]) if loop and len(way) > 1 else way[1:]
    return Newcomer(
        position=way[0],
        waypoints=waypoints,
        heading=float(np.arctan2(ahead[1], ahead[0])),
        speed=float(rng.uniform(*SPEED)) if speed is None else speed,
        radius=RADIUS,
        loop=loop and len(way) > 1,
    )


def _room(floor: Ground, truth: Truth) -> Booleans:
    """Cells (rows, cols) where a body touches neither a wall nor anybody, nor the chair."""
    crowd = truth.crowd
    if int(crowd.there.sum()) >= MOST:
        raise NoRoom(f"There are {MOST} people already; that is enough.")
    cells = np.argwhere(floor.walkable.free)
    points = floor.walkable.points(cells)
    near = np.hypot(*(points - truth.pose[:2]).T) < floor.chair + RADIUS + _FROM_CHAIR
    for at, radius in zip(crowd.position[crowd.there], crowd.radius[crowd.there], strict=True):
        near |= np.hypot(*(points - at).T) < radius + RADIUS + _APART
    room = floor.walkable.free.copy()
    room[cells[:, 0], cells[:, 1]] = ~near
    return room


def _ways(floor: Ground, point: Floats, limit: float) -> tuple[Integers, Floats, Integers]:
    """(parents, distances in m, cells (m, 2) that are reached) of ways from a point."""
    walk = floor.walkable
    row, col = walk.cell(point)
    distance, _, parent = spread(walk.free, walk.narrow, row, col, limit / CELL)
    return parent, distance * CELL, np.argwhere(np.isfinite(distance))


def _stroll(floor: Ground, at: Floats, rng: np.random.Generator) -> Floats:
    """A way (k, 2) to a place and back, without its first point; empty where there is none."""
    parent, distance, _ = _ways(floor, at, STROLL[1])
    cells = np.array([floor.walkable.cell(place) for place in floor.places]).reshape(-1, 2)
    away = distance[cells[:, 0], cells[:, 1]]
    there = cells[(away >= STROLL[0]) & (away <= STROLL[1])]
    if not len(there):
        return np.empty((0, 2))
    place = there[rng.integers(len(there))]
    back = pulled_tight(floor.walkable.free, trace(parent, int(place[0]), int(place[1])))
    points = floor.walkable.points(back)
    return np.vstack([points[-2::-1], points[1:-1]])


def _ahead(pose: Floats, route: Floats, far: float) -> tuple[Floats, Floats]:
    """A point (2,) so far along the route from the chair, m, and the direction (2,) there."""
    ahead = np.array([np.cos(pose[2]), np.sin(pose[2])])
    if len(route) < 2:
        return pose[:2] + far * ahead, ahead
    nearest = int(np.argmin(np.hypot(*(route - pose[:2]).T)))
    along = arc_length(route)
    at = min(along[nearest] + far, along[-1])
    point, before = (
        np.array([np.interp(s, along, route[:, i]) for i in (0, 1)]) for s in (at, at - 0.5)
    )
    step = point - before
    size = float(np.hypot(*step))
    return point, step / size if size > 1e-6 else ahead


def _across(ahead: Floats, rng: np.random.Generator) -> Floats:
    """To the left or to the right of a direction (2,)."""
    side = 1.0 if rng.random() < 0.5 else -1.0
    return side * np.array([-ahead[1], ahead[0]])


def _best(floor: Ground, cells: Integers, meeting: Floats, wanted: Floats) -> Integers:
    """Of cells (m, 2) the one that lies most in the wanted direction (2,) from the meeting."""
    to = floor.walkable.points(cells) - meeting
    unit = to / np.maximum(np.hypot(*to.T), 1e-9)[:, None]
    return np.asarray(cells[int(np.argmax(unit @ wanted))])


def _back_and_on(floor: Ground, parent: Integers, start: Integers, end: Integers) -> Floats:
    """The way (k, 2) from one cell through the meeting point to another, m."""
    free = floor.walkable.free
    there, on = (pulled_tight(free, trace(parent, int(c[0]), int(c[1]))) for c in (start, end))
    return floor.walkable.points(np.concatenate([there, on[::-1][1:]]))
