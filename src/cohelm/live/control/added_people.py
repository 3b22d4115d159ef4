"""Pedestrians that a page adds to the simulation: one who walks around, or one who crosses ahead.

    floor = walkable_floor(ride_setup)                   # once; takes about 50 ms
    world.spawn(new_pedestrian(floor, world.truth, point, rng))
    world.spawn(crossing_pedestrian(floor, world.truth, route, rng))

Each call takes about 10 ms at most; the same generator gives the same people.
"""

from __future__ import annotations

from typing import ClassVar, NamedTuple

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.errors import CohelmError
from cohelm.geometry import arc_length
from cohelm.scenarios.build import RideSetup
from cohelm.scenarios.walkable import CELL, Walkable, pulled_tight, spread, trace, walkable
from cohelm.simulation import GroundTruth, NewPedestrian

MAX_PEOPLE = 60
"""Number of people above which no more can be added."""
RADIUS = 0.25
"""Radius of a body, m."""
SPEED = (1.0, 1.4)
"""Range of preferred speeds, m/s; assumed, as for the people of a scenario."""
NEAR = (2.5, 7.0)
"""Range of distances from the chair, along the floor, for a person without a given position, m."""
STROLL = (4.0, 20.0)
"""Range of distances to the place that a person walks to and back, m."""
MIN_MEETING_DISTANCE = 2.5
"""Minimum distance ahead of the chair at which a person crosses, m."""
MIN_MEETING_TIME = 4.0
"""Minimum time until a person crosses, s."""
_MIN_CHAIR_SPEED = 0.5
"""Assumed speed of a chair that stands or creeps, m/s."""
_START_SHARES = (0.6, 1.2)
"""Range of a crossing person's distance to the meeting point, as a share of what they walk until
the chair is there."""
_END_SHARES = (0.5, 1.4)
"""Range of the distance that they walk beyond it, as a share of the same."""
_SEARCH_SHARE = 1.5
"""Limit of the search about the meeting point, as a share of the same; above the other two."""
_MAX_SHIFT = 1.5
"""Maximum distance between the requested position and a free one, m."""
_BODY_GAP = 0.1
"""Minimum gap between a new body and all others, m."""
_CHAIR_GAP = 0.4
"""Minimum gap between a new body and the chair, m."""


class NoFreeSpace(CohelmError):
    """There is no free position or path for another person."""

    code: ClassVar[str] = "no_free_space"


@value
class WalkableFloor:
    """Walkable space of a floor, and the destinations on it."""

    walkable: Walkable
    places: Annotated[Floats, Shape("p 2")]
    """Named places, m."""
    chair: float
    """Circumscribed radius of the chair, m."""


class _Reached(NamedTuple):
    """Shortest paths from one point."""

    parent: Integers
    distance: Floats
    """m; infinite if a cell was not reached."""
    cells: Integers
    """(m, 2) cells that were reached."""


def walkable_floor(ride_setup: RideSetup) -> WalkableFloor:
    """Return the walkable floor of a ride, with all doors open."""
    start = ride_setup.start[:2]
    places = [place.point for place in ride_setup.places.places]
    return WalkableFloor(
        walkable=walkable(ride_setup.world.grid, RADIUS, np.array([start, start + 0.1])),
        places=np.array(places).reshape(-1, 2),
        chair=ride_setup.robot.circumscribed_radius,
    )


def new_pedestrian(
    floor: WalkableFloor, truth: GroundTruth, point: Floats | None, rng: np.random.Generator
) -> NewPedestrian:
    """Return a person who walks to a named place and back forever; without a place they stand.

    Args:
        floor: Walkable floor.
        truth: Chair and people now.
        point: (2,) requested position, m; None: near the chair.
        rng: Random stream.

    Raises:
        NoFreeSpace: No free position was found, or there are :data:`MAX_PEOPLE` already.
    """
    free = np.argwhere(_free_cells(floor, truth))
    if point is None:
        distance = _reached(floor, truth.pose[:2], NEAR[1]).distance
        away = distance[free[:, 0], free[:, 1]]
        free = free[(away >= NEAR[0]) & (away <= NEAR[1])]
        if not len(free):
            raise NoFreeSpace("No free space near the chair.")
        cell = free[rng.integers(len(free))]
    else:
        shift = np.hypot(*(floor.walkable.points(free) - point).T)
        if not len(free) or shift.min() > _MAX_SHIFT:
            raise NoFreeSpace("No free space there.")
        cell = free[int(np.argmin(shift))]
    at = floor.walkable.points(cell[None])[0]
    path = _stroll(floor, at, rng)
    return _pedestrian(np.vstack([at, path]), loop=True, rng=rng)


def crossing_pedestrian(
    floor: WalkableFloor, truth: GroundTruth, route: Floats, rng: np.random.Generator
) -> NewPedestrian:
    """Return a person who reaches a point ahead of the chair together with it, and walks on.

    They come from the side if possible, else towards the chair. They see the chair and avoid it
    like all other pedestrians.

    Args:
        floor: Walkable floor.
        truth: Chair and people now.
        route: (k, 2) route of the chair, m; empty: straight ahead.
        rng: Random stream.

    Raises:
        NoFreeSpace: No path was found, or there are :data:`MAX_PEOPLE` already.
    """
    chair_speed = max(float(np.hypot(*truth.twist[:2])), _MIN_CHAIR_SPEED)
    distance = max(MIN_MEETING_DISTANCE, MIN_MEETING_TIME * chair_speed)
    meeting, ahead = _point_ahead(truth.pose, route, distance)
    walking_speed = float(rng.uniform(*SPEED))
    # Length of the person's path, so that both arrive at the same time.
    length = walking_speed * distance / chair_speed
    reached = _reached(floor, meeting, _SEARCH_SHARE * length)
    cells = reached.cells
    away = reached.distance[cells[:, 0], cells[:, 1]]
    free = _free_cells(floor, truth)[cells[:, 0], cells[:, 1]]
    starts = cells[free & (away >= _START_SHARES[0] * length) & (away <= _START_SHARES[1] * length)]
    ends = cells[(away >= _END_SHARES[0] * length) & (away <= _END_SHARES[1] * length)]
    if not len(starts) or not len(ends):
        raise NoFreeSpace("No path for a crossing person.")
    start = _furthest(floor, starts, meeting, _sideways(ahead, rng))
    to_start = floor.walkable.points(start[None])[0] - meeting
    end = _furthest(floor, ends, meeting, -to_start)
    path = _path_through(floor, reached.parent, start, end)
    return _pedestrian(path, loop=False, rng=rng, speed=walking_speed)


def _pedestrian(
    path: Floats, *, loop: bool, rng: np.random.Generator, speed: float | None = None
) -> NewPedestrian:
    """Return a person who appears at the first point of a path (k, 2) and walks the rest."""
    ahead = path[1] - path[0] if len(path) > 1 else np.array([1.0, 0.0])
    waypoints = np.vstack([path[1:], path[:1]]) if loop and len(path) > 1 else path[1:]
    return NewPedestrian(
        position=path[0],
        waypoints=waypoints,
        heading=float(np.arctan2(ahead[1], ahead[0])),
        speed=float(rng.uniform(*SPEED)) if speed is None else speed,
        radius=RADIUS,
        loop=loop and len(path) > 1,
    )


def _free_cells(floor: WalkableFloor, truth: GroundTruth) -> Booleans:
    """Cells (rows, cols) where a body touches no wall, no person and not the chair."""
    crowd = truth.crowd
    if int(crowd.there.sum()) >= MAX_PEOPLE:
        raise NoFreeSpace(f"No more than {MAX_PEOPLE} people can be in the simulation.")
    cells = np.argwhere(floor.walkable.free)
    points = floor.walkable.points(cells)
    near = np.hypot(*(points - truth.pose[:2]).T) < floor.chair + RADIUS + _CHAIR_GAP
    for at, radius in zip(crowd.position[crowd.there], crowd.radius[crowd.there], strict=True):
        near |= np.hypot(*(points - at).T) < radius + RADIUS + _BODY_GAP
    free = floor.walkable.free.copy()
    free[cells[:, 0], cells[:, 1]] = ~near
    return free


def _reached(floor: WalkableFloor, point: Floats, limit: float) -> _Reached:
    """Shortest paths from a point up to a length, m."""
    walk = floor.walkable
    row, col = walk.cell(point)
    distance, _, parent = spread(walk.free, walk.narrow, row, col, limit / CELL)
    return _Reached(parent, distance * CELL, np.argwhere(np.isfinite(distance)))


def _stroll(floor: WalkableFloor, at: Floats, rng: np.random.Generator) -> Floats:
    """Path (k, 2) to a place and back, without its first point; empty if there is none."""
    reached = _reached(floor, at, STROLL[1])
    cells = np.array([floor.walkable.cell(place) for place in floor.places]).reshape(-1, 2)
    away = reached.distance[cells[:, 0], cells[:, 1]]
    there = cells[(away >= STROLL[0]) & (away <= STROLL[1])]
    if not len(there):
        return np.empty((0, 2))
    place = there[rng.integers(len(there))]
    back = pulled_tight(floor.walkable.free, trace(reached.parent, int(place[0]), int(place[1])))
    points = floor.walkable.points(back)
    return np.vstack([points[-2::-1], points[1:-1]])


def _point_ahead(pose: Floats, route: Floats, distance: float) -> tuple[Floats, Floats]:
    """Point (2,) at a distance along the route from the chair, m, and the direction (2,) there."""
    ahead = np.array([np.cos(pose[2]), np.sin(pose[2])])
    if len(route) < 2:
        return pose[:2] + distance * ahead, ahead
    nearest = int(np.argmin(np.hypot(*(route - pose[:2]).T)))
    along = arc_length(route)
    at = min(along[nearest] + distance, along[-1])
    point, before = (
        np.array([np.interp(s, along, route[:, i]) for i in (0, 1)]) for s in (at, at - 0.5)
    )
    step = point - before
    size = float(np.hypot(*step))
    return point, step / size if size > 1e-6 else ahead


def _sideways(ahead: Floats, rng: np.random.Generator) -> Floats:
    """Direction (2,) to the left or to the right of another."""
    side = 1.0 if rng.random() < 0.5 else -1.0
    return side * np.array([-ahead[1], ahead[0]])


def _furthest(
    floor: WalkableFloor, cells: Integers, meeting: Floats, direction: Floats
) -> Integers:
    """Return the cell (of (m, 2)) that lies most in a direction (2,) from the meeting point."""
    to = floor.walkable.points(cells) - meeting
    unit = to / np.maximum(np.hypot(*to.T), 1e-9)[:, None]
    return np.asarray(cells[int(np.argmax(unit @ direction))])


def _path_through(floor: WalkableFloor, parent: Integers, start: Integers, end: Integers) -> Floats:
    """Path (k, 2) from one cell through the meeting point to another, m."""
    free = floor.walkable.free
    there, on = (pulled_tight(free, trace(parent, int(c[0]), int(c[1]))) for c in (start, end))
    return floor.walkable.points(np.concatenate([there, on[::-1][1:]]))
