"""Routes of pedestrians in groups and in streams along lanes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cohelm.arrays import Floats, Integers
from cohelm.geometry import arc_length
from cohelm.scenarios.pedestrian_spec import FlowSpec, GroupSpec, PedestrianSpec

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
