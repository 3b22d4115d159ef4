"""Who walks where: people whose ways cross the robot's route, on any map.

Each person is given a meeting point on the route and the moment when the chair should be there. A
way is laid through the point, as straight and as much across the route as the building allows, both
ends so far from it that the person is there at that moment; then they walk to and fro. Ways are
shortest paths on a coarse grid, pulled tight where the line of sight is free.
"""

from __future__ import annotations

import heapq
import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Integers, Shape, value
from cohelm.errors import ScenarioError
from cohelm.evaluation.scenario import Crowding, Way
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.maps import DistanceField, OccupancyGrid, distance_field
from cohelm.simulation import Crowd

SPACING = 3.0
"""Least distance of a drawn start from the chair and from other drawn starts, m."""
CELL = 0.15
"""Of the coarse grid, m."""
MARGIN = 0.10
"""Beyond the body's radius, kept from walls by a way, m."""
REACH = (4.0, 14.0)
"""How far from the meeting point a way ends, m."""
TRIES = 5
"""Other meeting points tried where there is no room for a way through the first."""
CHAIR_SPEED = 0.65
"""At which the chair is expected along its route, m/s: 0.8 with slowing (METHOD §6: 0.60–0.73)."""


@value
class Walkable:
    """Where people can walk: a coarse grid over the map."""

    free: Annotated[Booleans, Shape("rows cols")]
    clearance: Annotated[Floats32, Shape("rows cols")]
    """To the nearest wall, m."""
    origin: Annotated[Floats, Shape("2")]
    """Centre of cell (0, 0), m; rows run along y, columns along x of the map frame."""

    def cell(self, point: Floats) -> tuple[int, int]:
        """(row, column) of a map point, clipped into the grid."""
        col, row = np.rint((np.asarray(point) - self.origin) / CELL).astype(int)
        rows, cols = self.free.shape
        return int(np.clip(row, 0, rows - 1)), int(np.clip(col, 0, cols - 1))

    def points(self, cells: Integers) -> Floats:
        """Centres (m, 2) of cells (m, 2) given as (row, column)."""
        return self.origin + CELL * np.asarray(cells)[:, ::-1]


def make_crowd(
    crowding: Crowding, grid: OccupancyGrid, route: Floats, rng: np.random.Generator
) -> Crowd:
    """The people of a ride at its start.

    Args:
        crowding: what the scenario says of them.
        grid: all that truly stands there.
        route: the robot's way (k, 2), m, from its start.
        rng: everything that is drawn is drawn from it.

    Raises:
        ScenarioError: if there is no room for so many.
    """
    ways = list(crowding.ways)
    count = len(ways) if crowding.count is None else crowding.count
    ways = ways[:count]
    speeds = rng.uniform(*crowding.speed, size=count)
    if count > len(ways):
        ways += _drawn_ways(grid, route, crowding.radius, speeds[len(ways) :], ways, rng)
    return _crowd(crowding, ways, speeds[: len(ways)], rng)


def walkable(field: DistanceField, grid: OccupancyGrid, radius: float) -> Walkable:
    """Cells whose distance to the walls leaves room for a body and a margin."""
    x0, y0, x1, y1 = grid.bounds
    x, y = np.meshgrid(np.arange(x0 + CELL / 2, x1, CELL), np.arange(y0 + CELL / 2, y1, CELL))
    points = np.stack([x, y], axis=-1)
    clearance = np.where(grid.contains(points), field.at(points), -1.0)
    return Walkable(
        free=clearance > radius + MARGIN,
        clearance=clearance.astype(np.float32),
        origin=np.array([x0 + CELL / 2, y0 + CELL / 2]),
    )


def _drawn_ways(
    grid: OccupancyGrid,
    route: Floats,
    radius: float,
    speeds: Floats,
    others: list[Way],
    rng: np.random.Generator,
) -> list[Way]:
    floor = walkable(distance_field(grid), grid, radius)
    starts = [route[0], *(np.array(way.points[0]) for way in others)]
    moments = _meetings(floor, route, len(speeds), rng)
    ways: list[Way] = []
    for along, speed in zip(moments, speeds, strict=True):
        for moment in (along, *rng.choice(moments, TRIES)):
            way = _way_through(floor, route, float(moment), float(speed), starts, rng)
            if way is not None:
                break
        else:
            room = len(others) + len(ways)
            raise ScenarioError(
                f"there is room for {room} people along this route; ask for no more",
                key="people.count",
            )
        ways.append(way)
        starts.append(np.array(way.points[0]))
    return ways


def _meetings(floor: Walkable, route: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Arc lengths (count,) at which to meet: spread over the route, in wide places.

    Of six candidates in each of ``count`` equal pieces the one with most room wins.
    """
    length = arc_length(route)
    low, high = min(4.0, 0.3 * length[-1]), max(length[-1] - 2.0, 0.7 * length[-1])
    pieces = low + (high - low) * (np.arange(count)[:, None] + rng.random((count, 6))) / count
    at = np.stack([np.interp(pieces, length, route[:, i]) for i in (0, 1)], axis=-1)
    cells = np.array([[floor.cell(p) for p in row] for row in at])
    room = np.minimum(floor.clearance[cells[..., 0], cells[..., 1]], 1.5)
    best = np.argmax(room, axis=1)
    return np.asarray(pieces[np.arange(count), best])


def _way_through(
    floor: Walkable,
    route: Floats,
    along: float,
    speed: float,
    starts: list[Floats],
    rng: np.random.Generator,
) -> Way | None:
    """A way through the route at arc length ``along``; None where there is no room for one."""
    length = arc_length(route)
    meeting = _on(route, length, along)
    tangent = _on(route, length, along + 0.5) - _on(route, length, along - 0.5)
    passed = along / CHAIR_SPEED * speed  # walked until the chair is there
    turns = max(math.ceil((passed / REACH[1] - 1.0) / 2.0), 0)
    reach = float(np.clip(passed / (2 * turns + 1), *REACH))
    distance, parent = _spread(floor.free, *floor.cell(meeting), 1.3 * REACH[1] / CELL)
    for slack in (0.5, 1.5, 3.0):
        ends = _ends(floor, distance, reach, slack, route, rng)
        pair = _best_pair(ends, meeting, tangent, starts, rng) if len(ends) > 1 else None
        if pair is not None:
            to_meeting, back = (
                _pulled_tight(floor.free, _trace(parent, *floor.cell(end))) for end in pair
            )
            points = floor.points(np.concatenate([to_meeting, back[::-1][1:]]))
            there_and_back = np.concatenate([points, points[-2:0:-1]])
            return Way(points=tuple((float(x), float(y)) for x, y in there_and_back), loop=True)
    return None


def _ends(
    floor: Walkable,
    distance: Floats,
    reach: float,
    slack: float,
    route: Floats,
    rng: np.random.Generator,
) -> Floats:
    """Up to 40 points (m, 2) about ``reach`` from the meeting point along the floor.

    Out of the way of the chair: 1.5 m from the route's ends and, where there are such, 1 m from it.
    """
    cells = np.argwhere(np.abs(distance * CELL - reach) < slack)
    points = floor.points(rng.permutation(cells)[:400])
    clear_of_ends = np.ones(len(points), dtype=bool)
    for end in (route[0], route[-1]):
        clear_of_ends &= np.hypot(*(points - end).T) > 1.5
    points = points[clear_of_ends]
    line = np.ascontiguousarray(route)
    beside = np.array([nearest_on_polyline(line, x, y)[1] > 1.0 for x, y in points], dtype=bool)
    aside, on_route = points[beside], points[~beside]
    return np.concatenate([aside, on_route])[:40] if len(aside) < 10 else aside[:40]


def _best_pair(
    ends: Floats,
    meeting: Floats,
    tangent: Floats,
    starts: list[Floats],
    rng: np.random.Generator,
) -> tuple[Floats, Floats] | None:
    """The (first, last) of ``ends`` with the straightest way, most across the route."""
    spaced = np.min([np.hypot(*(ends - start).T) for start in starts], axis=0) >= SPACING
    if not spaced.any():
        return None
    to_end = ends - meeting
    unit = to_end / np.maximum(np.hypot(*to_end.T), 1e-9)[:, None]
    straight = -(unit @ unit.T)
    across = np.abs(unit @ np.array([-tangent[1], tangent[0]])) / max(np.hypot(*tangent), 1e-9)
    score = straight + 0.5 * (across[:, None] + across[None, :])
    score = score + 0.3 * rng.random(score.shape)
    score[~spaced] = -np.inf
    np.fill_diagonal(score, -np.inf)
    first, last = np.unravel_index(np.argmax(score), score.shape)
    return ends[first], ends[last]


def _crowd(crowding: Crowding, ways: list[Way], speeds: Floats, rng: np.random.Generator) -> Crowd:
    n = len(ways)
    most = max((len(way.points) for way in ways), default=1)
    waypoints = np.full((n, most, 2), np.nan)
    for i, way in enumerate(ways):
        waypoints[i, : len(way.points)] = way.points
    angle, radius = rng.uniform(-np.pi, np.pi, n), crowding.jitter * np.sqrt(rng.random(n))
    start = waypoints[:, 0] + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    towards = (waypoints[:, 1] if most > 1 else waypoints[:, 0]) - start
    heading = np.arctan2(towards[:, 1], towards[:, 0])
    return Crowd(
        position=start,
        velocity=np.zeros((n, 2)),
        heading=np.nan_to_num(heading),
        radius=np.full(n, crowding.radius),
        preferred_speed=np.array(
            [speeds[i] if way.speed is None else way.speed for i, way in enumerate(ways)]
        ),
        waypoints=waypoints,
        target=np.array([min(1, len(way.points) - 1) for way in ways], dtype=np.int64),
        loop=np.array([way.loop for way in ways], dtype=bool),
        sees_robot=np.array(
            [crowding.see_robot if way.see_robot is None else way.see_robot for way in ways],
            dtype=bool,
        ),
    )


def _on(route: Floats, length: Floats, along: float) -> Floats:
    return np.array([np.interp(along, length, route[:, i]) for i in (0, 1)])


@njit(cache=True)
def _spread(free: Booleans, row: int, col: int, limit: float) -> tuple[Floats, Integers]:
    """Dijkstra from a cell over free ones, 8-connected: (distance in cells, parent index or −1).

    The first cell counts as free; a wall's corner is not cut; beyond ``limit`` nothing is reached.
    """
    rows, cols = free.shape
    distance = np.full((rows, cols), np.inf)
    parent = np.full((rows, cols), -1, dtype=np.int64)
    distance[row, col] = 0.0
    queue = [(0.0, row, col)]
    while len(queue) > 0:
        d, r, c = heapq.heappop(queue)
        if d > distance[r, c] or d > limit:
            continue
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                i, j = r + dr, c + dc
                if i < 0 or j < 0 or i >= rows or j >= cols or not free[i, j]:
                    continue
                if dr != 0 and dc != 0 and not (free[i, c] and free[r, j]):
                    continue
                through = d + math.sqrt(dr * dr + dc * dc)
                if through < distance[i, j]:
                    distance[i, j] = through
                    parent[i, j] = r * cols + c
                    heapq.heappush(queue, (through, i, j))
    return distance, parent


def _trace(parent: Integers, row: int, col: int) -> Integers:
    """Cells (m, 2) from a cell back to where the spreading began."""
    cols = parent.shape[1]
    cells = [(row, col)]
    while parent[row, col] >= 0:
        row, col = divmod(int(parent[row, col]), cols)
        cells.append((row, col))
    return np.array(cells, dtype=np.int64)


def _pulled_tight(free: Booleans, cells: Integers) -> Integers:
    """The way with only the cells left at which it must bend."""
    kept, at = [0], 0
    while at < len(cells) - 1:
        far = at + 1
        while far < len(cells) - 1 and _sees(free, cells[at], cells[far + 1]):
            far += 1
        kept.append(far)
        at = far
    return cells[kept]


@njit(cache=True)
def _sees(free: Booleans, a: Integers, b: Integers) -> bool:
    """Whether all cells on the segment between two cells are free."""
    steps = 2 * max(abs(b[0] - a[0]), abs(b[1] - a[1]), 1)
    for i in range(steps + 1):
        r = round(a[0] + (b[0] - a[0]) * i / steps)
        c = round(a[1] + (b[1] - a[1]) * i / steps)
        if not free[r, c]:
            return False
    return True
