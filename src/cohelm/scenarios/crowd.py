"""Pedestrians at the start of a ride: explicit, grouped, in flows, and drawn on any map.

A drawn pedestrian gets a meeting point on the chair's route, and a route through that point that is
as straight, and as much across the chair's route, as the building allows. They walk it back and
forth. Every second one is timed to be at the meeting point when the chair is expected there.
Routes share as little as possible of the chair's route where it is too narrow to pass.

A chair without a goal has no route to meet: pedestrians then walk over the whole connected floor.

Groups and streams walk along lanes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.errors import ScenarioError
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.maps import OccupancyGrid
from cohelm.scenarios.pedestrian_spec import CrowdSpec, FlowSpec, GroupSpec, PedestrianSpec
from cohelm.scenarios.walkable import (
    CELL,
    Walkable,
    connected_cells,
    pulled_tight,
    spread,
    trace,
    walkable,
)
from cohelm.simulation import Crowd

MIN_SPACING = 0.8
"""Smallest distance between two starts of a flow where space allows, m."""
ROBOT_CLEARANCE = 1.8
"""Smallest distance between a start of a flow and the chair, m."""
ABREAST = 3
"""Members of a group in one row (Moussaïd et al. 2010: larger groups split up)."""
ROW_SPACING = 1.0
"""Distance between the rows of a group, m (assumed)."""
_TRIES = 30


def flow_routes(
    flows: Sequence[FlowSpec], count: int, robot: Floats, rng: np.random.Generator
) -> list[PedestrianSpec]:
    """Routes of all people in the flows.

    Args:
        flows: lanes.
        count: people in all flows, shared in proportion to their own counts.
        robot: start of the chair (2,), m.
        rng: source of starts and offsets; not used without flows.
    """
    if not flows or count <= 0:
        return []
    routes: list[PedestrianSpec] = []
    for flow, share in zip(flows, _shares([flow.count for flow in flows], count), strict=True):
        routes += _flow(flow, share, robot, rng)
    return routes


def group_routes(
    groups: Sequence[GroupSpec], count: int, speeds: Floats
) -> tuple[list[PedestrianSpec], Integers]:
    """Routes of all group members, and the group index of each member, (m,).

    Args:
        groups: groups of the scenario.
        count: largest number of people; the last ones are left out.
        speeds: (m,) or more preferred speeds, m/s; a group without a speed takes that of its first
            member.
    """
    routes: list[PedestrianSpec] = []
    indices: list[int] = []
    for index, group in enumerate(groups):
        first = len(routes)
        if first >= count:
            break
        speed = float(speeds[first]) if group.speed is None else group.speed
        routes += _standing(group, speed) if len(group.points) == 1 else _walking(group, speed)
        indices += [index] * group.size
    return routes[:count], np.array(indices[:count], dtype=np.int64)


def _shares(weights: Sequence[int], count: int) -> list[int]:
    """``count`` split in proportion to ``weights``; the largest remainders are rounded up."""
    exact = np.array(weights) * count / sum(weights)
    parts = np.floor(exact).astype(int)
    rest = np.argsort(parts - exact, kind="stable")[: count - parts.sum()]
    parts[rest] += 1
    return [int(part) for part in parts]


def _flow(
    flow: FlowSpec, count: int, robot: Floats, rng: np.random.Generator
) -> list[PedestrianSpec]:
    lane = np.array(flow.lane)
    if flow.loop:
        lane = np.vstack([lane, lane[:1]])
    sideways = _offset_directions(lane, closed=flow.loop)
    along = arc_length(lane)
    extent = min(flow.spread or along[-1], along[-1])
    starts: list[Floats] = []
    routes = []
    for i in range(count):
        best, widest = (0.0, 0.0, lane[0]), -1.0
        for _ in range(_TRIES):  # the first start with enough spacing, else the one with the most
            s = extent * (i + rng.random()) / count
            offset = flow.width * (rng.random() - 0.5)
            at = _point(lane + offset * sideways, along, s)
            spacing = float(np.hypot(*(at - robot))) + MIN_SPACING - ROBOT_CLEARANCE
            spacing = min((spacing, *(float(np.hypot(*(at - other))) for other in starts)))
            if spacing > widest:
                best, widest = (s, offset, at), spacing
            if spacing >= MIN_SPACING:
                break
        s, offset, at = best
        starts.append(at)
        routes.append(_lane_route(flow, lane + offset * sideways, along, s))
    return routes


def _lane_route(flow: FlowSpec, line: Floats, along: Floats, s: float) -> PedestrianSpec:
    """Route along a line (k, 2) from arc length ``s``, m; once around where the lane is a loop."""
    ahead = line[np.flatnonzero(along > s + 1e-6)]
    behind = line[1:][along[1:] <= s + 1e-6] if flow.loop else line[:0]
    return _spec(flow, np.vstack([_point(line, along, s)[None], ahead, behind]), flow.speed)


def _walking(group: GroupSpec, speed: float) -> list[PedestrianSpec]:
    """Rows of up to three members, each with a constant offset from the group's route."""
    lane = np.array(group.points)
    aside = _offset_directions(
        np.vstack([lane, lane[:1]]) if group.loop else lane, closed=group.loop
    )
    ahead = (lane[1] - lane[0]) / max(float(np.hypot(*(lane[1] - lane[0]))), 1e-9)
    out = []
    for i in range(group.size):
        row, column = divmod(i, ABREAST)
        abreast = min(group.size - row * ABREAST, ABREAST)
        offset = (column - 0.5 * (abreast - 1)) * group.spacing
        line = lane + offset * aside[: len(lane)]
        line[0] -= row * ROW_SPACING * ahead
        out.append(_spec(group, line, speed))
    return out


def _standing(group: GroupSpec, speed: float) -> list[PedestrianSpec]:
    """Members on a circle, ``spacing`` apart, who face its centre."""
    centre = np.array(group.points[0])
    radius = 0.5 * group.spacing / math.sin(math.pi / group.size)
    out = []
    for i in range(group.size):
        angle = 2.0 * math.pi * i / group.size
        position = centre + radius * np.array([math.cos(angle), math.sin(angle)])
        facing = math.degrees(math.remainder(angle + math.pi, 2.0 * math.pi))
        out.append(_spec(group, position[None], speed).model_copy(update={"facing_deg": facing}))
    return out


def _offset_directions(lane: Floats, *, closed: bool) -> Floats:
    """Displacement (k, 2) of each corner of a lane for an offset of 1 m to the left."""
    direction = np.diff(lane, axis=0)
    left = np.stack([-direction[:, 1], direction[:, 0]], axis=-1) / np.hypot(*direction.T)[:, None]
    before = np.vstack([left[-1:] if closed else left[:1], left])
    after = np.vstack([left, left[:1] if closed else left[-1:]])
    both = before + after  # along the bisector, and longer at sharper corners
    size: Floats = (both**2).sum(axis=-1, keepdims=True)
    return np.asarray(2.0 * both / np.maximum(size, 0.5))


def _spec(source: FlowSpec | GroupSpec, line: Floats, speed: float | None) -> PedestrianSpec:
    return PedestrianSpec(
        points=tuple((float(x), float(y)) for x, y in line),
        loop=source.loop,
        speed=speed,
        see_robot=source.see_robot,
    )


def _point(line: Floats, along: Floats, s: float) -> Floats:
    return np.array([np.interp(s, along, line[:, i]) for i in (0, 1)])


SPACING = 3.0
"""Smallest distance of a drawn start from the chair and from other starts, m."""
ROUTE_ENDS = (4.0, 14.0)
"""Distance of the ends of a drawn route from the meeting point, m."""
TRIES = 5
"""Further meeting points that are tried for a better route."""
SHARED = 1.5
"""Accepted length of a route along the narrow part of the chair's route, m."""
CHAIR_SPEED = 0.65
"""Expected speed of the chair along its route, m/s: 0.8 with slowing (Xu et al.: 0.60–0.73)."""
SHORTEST_ROUTE = 1.0
"""Length of the chair's route below which there is nothing to meet, m."""
ROAMING = (4.0, 40.0)
"""Length of a route over the whole floor, m."""
_STARTS = 30
_CLOSEST = 1.0


class _Meeting(NamedTuple):
    """Meeting point on the chair's route."""

    along: float
    """Arc length on the route, m."""
    walked: float
    """Distance that the pedestrian has walked at that moment, m."""


def pedestrian_count(spec: CrowdSpec) -> int:
    """Number of pedestrians of a scenario."""
    specified = len(spec.pedestrians) + sum(group.size for group in spec.groups)
    specified += sum(flow.count for flow in spec.flows)
    return specified if spec.count is None else spec.count


def make_crowd(
    spec: CrowdSpec, grid: OccupancyGrid, route: Floats, rng: np.random.Generator
) -> Crowd:
    """Pedestrians at the start of a ride.

    Args:
        spec: pedestrians of the scenario.
        grid: true occupancy.
        route: route of the chair (k, 2) from its start, m; shorter than :data:`SHORTEST_ROUTE`
            where it has no goal.
        rng: source of all draws.

    Raises:
        ScenarioError: if there is not enough space for all of them.
    """
    count = pedestrian_count(spec)
    routes = list(spec.pedestrians)[:count]
    explicit = len(routes)
    grouped = min(sum(group.size for group in spec.groups), count - explicit)
    in_flows = flow_routes(spec.flows, count - explicit - grouped, route[0], rng)
    speeds = rng.uniform(*spec.speed, size=count)
    in_groups, indices = group_routes(spec.groups, grouped, speeds[explicit:])
    group = np.full(count, -1, dtype=np.int64)
    group[explicit : explicit + grouped] = indices
    for index, members in enumerate(spec.grouped, start=len(spec.groups)):
        group[[each for each in members if each < explicit]] = index
    routes += [*in_groups, *in_flows]
    if count > len(routes):
        starts = [route[0], *(np.array(each.points[0]) for each in routes)]
        if arc_length(route)[-1] < SHORTEST_ROUTE:
            floor = walkable(grid, spec.radius, np.array([route[0], route[0] + 0.1]))
            routes += _roaming_routes(floor, starts, count - len(routes), rng)
        else:
            floor = walkable(grid, spec.radius, route)
            routes += _meeting_routes(floor, route, speeds[len(routes) :], starts, rng)
    crowd = _crowd(spec, routes, speeds[: len(routes)], rng)
    return replace(crowd, group=group[: len(routes)]) if (group >= 0).any() else crowd


def _roaming_routes(
    floor: Walkable, starts: list[Floats], count: int, rng: np.random.Generator
) -> list[PedestrianSpec]:
    """Routes between random points of the floor that is connected to the chair, back and forth."""
    cells = connected_cells(floor, starts[0])
    routes: list[PedestrianSpec] = []
    for _ in range(count):
        start, spacing = None, -1.0
        for cell in rng.permutation(cells)[:_STARTS]:
            at = floor.points(cell[None])[0]
            nearest = min(float(np.hypot(*(at - other))) for other in starts)
            if nearest > spacing:
                start, spacing = cell, nearest
            if nearest >= SPACING:
                break
        if start is None or spacing < _CLOSEST:
            raise _no_space(len(starts) - 1)
        limit = ROAMING[1] / CELL
        distance, _, parent = spread(floor.free, floor.narrow, int(start[0]), int(start[1]), limit)
        # Any point in walking distance, the farthest where all are too near.
        reached = np.where(np.isfinite(distance), distance * CELL, -1.0)
        ends = np.argwhere(reached >= min(ROAMING[0], float(reached.max())))
        end = ends[rng.integers(len(ends))]
        corners = pulled_tight(floor.free, trace(parent, int(end[0]), int(end[1])))[::-1]
        routes.append(_back_and_forth(floor.points(corners)))
        starts.append(np.array(routes[-1].points[0]))
    return routes


def _meeting_routes(
    floor: Walkable,
    route: Floats,
    speeds: Floats,
    starts: list[Floats],
    rng: np.random.Generator,
) -> list[PedestrianSpec]:
    """A route through a meeting point for each pedestrian with speeds (n,)."""
    meetings = _meetings(floor, route, len(speeds), rng)
    routes: list[PedestrianSpec] = []
    for i, (along, speed) in enumerate(zip(meetings, speeds, strict=True)):
        chosen, least = None, np.inf
        for moment in (along, *rng.choice(meetings, TRIES)):
            when = moment / CHAIR_SPEED if i % 2 == 0 else rng.uniform(*ROUTE_ENDS) / speed
            meeting = _Meeting(float(moment), float(speed * when))
            found = _route_through(floor, route, meeting, starts, rng)
            if found is not None and found[1] < least:
                chosen, least = found
            if least <= SHARED:
                break
        if chosen is None:  # in a small room: a short route without timing
            meeting = _Meeting(float(along), ROUTE_ENDS[0])
            found = _route_through(floor, route, meeting, starts, rng)
            chosen = found[0] if found is not None else None
        if chosen is None:
            raise _no_space(len(starts) - 1)
        routes.append(chosen)
        starts.append(np.array(chosen.points[0]))
    return routes


def _no_space(count: int) -> ScenarioError:
    return ScenarioError(
        f"there is space for {count} people along this route; ask for no more", key="people.count"
    )


def _meetings(floor: Walkable, route: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Arc lengths (count,) of the meeting points, m: spread over the route, at wide places.

    The route is divided into ``count`` equal pieces; of six candidates in each, the one with the
    largest clearance is taken.
    """
    length = arc_length(route)
    low, high = min(4.0, 0.3 * length[-1]), max(length[-1] - 2.0, 0.7 * length[-1])
    pieces = low + (high - low) * (np.arange(count)[:, None] + rng.random((count, 6))) / count
    at = np.stack([np.interp(pieces, length, route[:, i]) for i in (0, 1)], axis=-1)
    cells = np.array([[floor.cell(p) for p in row] for row in at])
    clearance = np.minimum(floor.clearance[cells[..., 0], cells[..., 1]], 1.5)
    best = np.argmax(clearance, axis=1)
    return np.asarray(pieces[np.arange(count), best])


def _route_through(
    floor: Walkable,
    route: Floats,
    meeting: _Meeting,
    starts: list[Floats],
    rng: np.random.Generator,
) -> tuple[PedestrianSpec, float] | None:
    """A route through a meeting point and the length of its narrow part, m; None: no space."""
    length = arc_length(route)
    point = _on(route, length, meeting.along)
    tangent = _on(route, length, meeting.along + 0.5) - _on(route, length, meeting.along - 0.5)
    turns = max(math.ceil((meeting.walked / ROUTE_ENDS[1] - 1.0) / 2.0), 0)  # before the meeting
    reach = float(np.clip(meeting.walked / (2 * turns + 1), *ROUTE_ENDS))
    row, col = floor.cell(point)
    limit = 1.3 * ROUTE_ENDS[1] / CELL
    distance, shared, parent = spread(floor.free, floor.narrow, row, col, limit)
    for slack in (0.5, 1.5, 3.0):
        ends = _ends(floor, np.abs(distance * CELL - reach) < slack, route, rng)
        if len(ends) < 2:
            continue
        cells = np.array([floor.cell(end) for end in ends])
        metres = shared[cells[:, 0], cells[:, 1]] * CELL
        spaced = np.min([np.hypot(*(ends - start).T) for start in starts], axis=0) >= SPACING
        if spaced.any():
            pair = _best_pair(ends - point, metres, spaced, tangent, rng)
            there, back = (pulled_tight(floor.free, trace(parent, *cells[i])) for i in pair)
            points = floor.points(np.concatenate([there, back[::-1][1:]]))
            return _back_and_forth(points), float(metres[list(pair)].sum())
    return None


def _back_and_forth(points: Floats) -> PedestrianSpec:
    """Route along a polyline (k, 2) and back, repeated."""
    round_trip = np.concatenate([points, points[-2:0:-1]])
    return PedestrianSpec(points=tuple((float(x), float(y)) for x, y in round_trip), loop=True)


def _ends(floor: Walkable, candidates: Booleans, route: Floats, rng: np.random.Generator) -> Floats:
    """Up to 40 possible ends (m, 2) of a pedestrian's route among cells (rows, cols).

    They lie 1.5 m from the ends of the chair's route and, where enough candidates do, up to 2.5 m
    from the route itself, so that pedestrians do not turn back in front of the chair.
    """
    points = floor.points(rng.permutation(np.argwhere(candidates))[:400])
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
    to_end: Floats, narrow: Floats, spaced: Booleans, tangent: Floats, rng: np.random.Generator
) -> tuple[int, int]:
    """Indices of the first and last point of the straightest route across, least in narrow places.

    Args:
        to_end: (m, 2) from the meeting point to the possible ends, m.
        narrow: (m,) length of the narrow part on the path to each end, m.
        spaced: (m,) ends that are far enough from other starts.
        tangent: (2,) direction of the chair's route at the meeting point.
        rng: source of a random preference.
    """
    unit = to_end / np.maximum(np.hypot(*to_end.T), 1e-9)[:, None]
    straight = -(unit @ unit.T)
    across = np.abs(unit @ np.array([-tangent[1], tangent[0]])) / max(np.hypot(*tangent), 1e-9)
    score = straight + 0.5 * (across[:, None] + across[None, :])
    score = score - 0.5 * (narrow[:, None] + narrow[None, :]) + 0.3 * rng.random(score.shape)
    score[~spaced] = -np.inf
    np.fill_diagonal(score, -np.inf)
    first, last = np.unravel_index(np.argmax(score), score.shape)
    return int(first), int(last)


def _crowd(
    spec: CrowdSpec,
    routes: Sequence[PedestrianSpec],
    speeds: Floats,
    rng: np.random.Generator,
) -> Crowd:
    n = len(routes)
    longest = max((len(each.points) for each in routes), default=1)
    waypoints = np.full((n, longest, 2), np.nan)
    for i, each in enumerate(routes):
        waypoints[i, : len(each.points)] = each.points
    angle, radius = rng.uniform(-np.pi, np.pi, n), spec.jitter * np.sqrt(rng.random(n))
    start = waypoints[:, 0] + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    towards = (waypoints[:, 1] if longest > 1 else waypoints[:, 0]) - start
    facing = [
        np.nan if each.facing_deg is None else math.radians(each.facing_deg) for each in routes
    ]
    heading = np.where(np.isnan(facing), np.arctan2(towards[:, 1], towards[:, 0]), facing)
    see = [spec.see_robot if each.see_robot is None else each.see_robot for each in routes]
    return Crowd(
        position=start,
        velocity=np.zeros((n, 2)),
        heading=np.nan_to_num(heading),
        radius=np.full(n, spec.radius),
        preferred_speed=np.array(
            [speeds[i] if each.speed is None else each.speed for i, each in enumerate(routes)]
        ),
        waypoints=waypoints,
        target=np.array([min(1, len(each.points) - 1) for each in routes], dtype=np.int64),
        loop=np.array([each.loop for each in routes], dtype=bool),
        sees_robot=np.array(see, dtype=bool),
    )


def _on(route: Floats, length: Floats, along: float) -> Floats:
    return np.array([np.interp(along, length, route[:, i]) for i in (0, 1)])
