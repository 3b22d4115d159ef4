"""Who walks where: people whose ways cross the robot's route, on any map.

Each person is given a meeting point on the route. A way is laid through the point, as straight and
as much across the route as the building allows, on which they walk to and fro. Every second one is
so long that they are at the point when the chair should be; the others come by when they come by.
Nobody walks far along the route where it is too narrow for a chair and a person to pass each other.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import ScenarioError
from cohelm.evaluation.company import Crowding, Way
from cohelm.evaluation.flows import flow_ways
from cohelm.evaluation.parties import group_ways
from cohelm.evaluation.walkable import CELL, Walkable, pulled_tight, spread, trace, walkable
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.maps import OccupancyGrid
from cohelm.simulation import Crowd

SPACING = 3.0
"""Least distance of a drawn start from the chair and from other drawn starts, m."""
REACH = (4.0, 14.0)
"""How far from the meeting point a way ends, m."""
TRIES = 5
"""Other meeting points tried where there is no room for a way through the first."""
SHARED = 1.5
"""How far at most a way runs along the route where that is narrower, m, if it can be helped."""
CHAIR_SPEED = 0.65
"""At which the chair is expected along its route, m/s: 0.8 with slowing (Xu et al.: 0.60–0.73)."""


def people_of(crowding: Crowding) -> int:
    """How many people a scenario has."""
    usual = len(crowding.ways) + sum(group.size for group in crowding.groups)
    usual += sum(flow.count for flow in crowding.flows)
    return usual if crowding.count is None else crowding.count


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
    count = people_of(crowding)
    ways = ways[:count]
    grouped = min(sum(group.size for group in crowding.groups), count - len(ways))
    in_flows = flow_ways(crowding.flows, count - len(ways) - grouped, route[0], rng)
    speeds = rng.uniform(*crowding.speed, size=count)
    together, numbers = group_ways(crowding.groups, grouped, speeds[len(ways) :])
    group = np.full(count, -1, dtype=np.int64)
    group[len(ways) : len(ways) + grouped] = numbers
    for number, members in enumerate(crowding.together, start=len(crowding.groups)):
        group[[each for each in members if each < len(ways)]] = number
    ways += [*together, *in_flows]
    if count > len(ways):
        ways += _drawn_ways(grid, route, crowding.radius, speeds[len(ways) :], ways, rng)
    crowd = _crowd(crowding, ways, speeds[: len(ways)], rng)
    return replace(crowd, group=group[: len(ways)]) if (group >= 0).any() else crowd


def _drawn_ways(
    grid: OccupancyGrid,
    route: Floats,
    radius: float,
    speeds: Floats,
    others: list[Way],
    rng: np.random.Generator,
) -> list[Way]:
    floor = walkable(grid, radius, route)
    starts = [route[0], *(np.array(way.points[0]) for way in others)]
    moments = _meetings(floor, route, len(speeds), rng)
    ways: list[Way] = []
    for i, (along, speed) in enumerate(zip(moments, speeds, strict=True)):
        way, least = None, np.inf
        for moment in (along, *rng.choice(moments, TRIES)):
            when = moment / CHAIR_SPEED if i % 2 == 0 else rng.uniform(*REACH) / speed
            walked = float(speed * when)
            found = _way_through(floor, route, (float(moment), walked), starts, rng)
            if found is not None and found[1] < least:
                way, least = found
            if least <= SHARED:
                break
        if way is None:  # in a small room: a short way, whenever they come by
            found = _way_through(floor, route, (float(along), REACH[0]), starts, rng)
            way = found[0] if found is not None else None
        if way is None:
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
    meeting_at: tuple[float, float],
    starts: list[Floats],
    rng: np.random.Generator,
) -> tuple[Way, float] | None:
    """A way through the route, and how much of it is narrow, m; None: there is no room for one.

    ``meeting_at`` is the meeting point's arc length on the route, and how far one shall have walked
    there at the appointed moment, m.
    """
    along, walked = meeting_at
    length = arc_length(route)
    meeting = _on(route, length, along)
    tangent = _on(route, length, along + 0.5) - _on(route, length, along - 0.5)
    turns = max(math.ceil((walked / REACH[1] - 1.0) / 2.0), 0)  # to and fro before that moment
    reach = float(np.clip(walked / (2 * turns + 1), *REACH))
    row, col = floor.cell(meeting)
    distance, shared, parent = spread(floor.free, floor.narrow, row, col, 1.3 * REACH[1] / CELL)
    for slack in (0.5, 1.5, 3.0):
        ends = _ends(floor, distance, reach, slack, route, rng)
        if len(ends) < 2:
            continue
        cells = np.array([floor.cell(end) for end in ends])
        metres = shared[cells[:, 0], cells[:, 1]] * CELL
        pair = _best_pair(ends, metres, meeting, tangent, starts, rng)
        if pair is not None:
            to_meeting, back = (pulled_tight(floor.free, trace(parent, *cells[i])) for i in pair)
            points = floor.points(np.concatenate([to_meeting, back[::-1][1:]]))
            there_and_back = np.concatenate([points, points[-2:0:-1]])
            way = Way(points=tuple((float(x), float(y)) for x, y in there_and_back), loop=True)
            return way, float(metres[list(pair)].sum())
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

    Out of the way of the chair: 1.5 m from the route's ends, and as far from the route as there are
    ends enough, up to 2.5 m: who turns about does so where they are going, not under the wheels.
    """
    cells = np.argwhere(np.abs(distance * CELL - reach) < slack)
    points = floor.points(rng.permutation(cells)[:400])
    clear_of_ends = np.ones(len(points), dtype=bool)
    for end in (route[0], route[-1]):
        clear_of_ends &= np.hypot(*(points - end).T) > 1.5
    points = points[clear_of_ends]
    line = np.ascontiguousarray(route)
    beside = np.array([nearest_on_polyline(line, x, y)[1] for x, y in points])
    for away in (2.5, 1.5, 1.0):
        aside = points[beside > away]
        if len(aside) >= 10:
            return aside[:40]
    return points[np.argsort(-beside, kind="stable")][:40]


def _best_pair(
    ends: Floats,
    narrow: Floats,
    meeting: Floats,
    tangent: Floats,
    starts: list[Floats],
    rng: np.random.Generator,
) -> tuple[int, int] | None:
    """Indices of (first, last) of ``ends``: the straightest way, across the route, least narrow.

    ``narrow`` (m,) says how far the way to each end runs along the route where it is narrow, m.
    """
    spaced = np.min([np.hypot(*(ends - start).T) for start in starts], axis=0) >= SPACING
    if not spaced.any():
        return None
    to_end = ends - meeting
    unit = to_end / np.maximum(np.hypot(*to_end.T), 1e-9)[:, None]
    straight = -(unit @ unit.T)
    across = np.abs(unit @ np.array([-tangent[1], tangent[0]])) / max(np.hypot(*tangent), 1e-9)
    score = straight + 0.5 * (across[:, None] + across[None, :])
    score = score - 0.5 * (narrow[:, None] + narrow[None, :]) + 0.3 * rng.random(score.shape)
    score[~spaced] = -np.inf
    np.fill_diagonal(score, -np.inf)
    first, last = np.unravel_index(np.argmax(score), score.shape)
    return int(first), int(last)


def _crowd(crowding: Crowding, ways: list[Way], speeds: Floats, rng: np.random.Generator) -> Crowd:
    n = len(ways)
    most = max((len(way.points) for way in ways), default=1)
    waypoints = np.full((n, most, 2), np.nan)
    for i, way in enumerate(ways):
        waypoints[i, : len(way.points)] = way.points
    angle, radius = rng.uniform(-np.pi, np.pi, n), crowding.jitter * np.sqrt(rng.random(n))
    start = waypoints[:, 0] + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    towards = (waypoints[:, 1] if most > 1 else waypoints[:, 0]) - start
    facing = [np.nan if way.facing_deg is None else math.radians(way.facing_deg) for way in ways]
    heading = np.where(np.isnan(facing), np.arctan2(towards[:, 1], towards[:, 0]), facing)
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
