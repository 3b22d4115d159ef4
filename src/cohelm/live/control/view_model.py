"""Messages for the page computed from a tick: plain tuples, rounded to the millimetre."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats, Integers
from cohelm.health.map_changes import CELL, centres_of, connected_cells
from cohelm.live.control.surroundings import in_view
from cohelm.live.messages import (
    EdgeCells,
    MapDifference,
    MapDifferences,
    NavigatorState,
    OfferInfo,
    PersonInfo,
    Pose,
    RouteUpdate,
)
from cohelm.maps import OccupancyGrid
from cohelm.messages import Mode, Observation, SocialSpaces
from cohelm.navigation import Tick
from cohelm.shapes import extent, hull_outline

SHOWN_HORIZON = 2.0
"""Part of the plan that is shown, s."""
SHOWN_SPACING = 0.1
"""Approximate distance between the points of a route that is shown, m."""
MAX_DIFFERENCES = 40
"""Maximum number of places that differ from the map, the largest ones."""
MAX_CELLS = 60
"""Maximum number of cells of one place that are sent."""
MAX_RUNS = 4000
"""Maximum number of runs of cells behind edges, the longest ones."""
Points = tuple[tuple[float, float], ...]
"""Points of a line in the map frame, m."""


def navigator_state(tick: Tick, sweeps: Observation, free: tuple[float, ...]) -> NavigatorState:
    """Return what pages show of a tick.

    Args:
        tick: Tick of the navigator.
        sweeps: Newest observation with scans.
        free: Free distances by the same, m.
    """
    route = tick.memory.route
    remaining = None
    if route is not None and tick.path is not None:
        remaining = round(max(route.path.length - route.progress, 0.0), 2)
    offers = () if tick.destinations is None else tick.destinations.offers
    # Not validated again: the control loop waits for it.
    return NavigatorState.model_construct(
        rider_authority=_rider_authority(tick),
        remaining=remaining,
        plan=_plan(tick),
        people=_people(tick, sweeps),
        groups=_groups(tick),
        offers=tuple(
            OfferInfo(
                name=each.name, slot=each.slot, highlighted=each.highlighted, why=each.sentence
            )
            for each in offers
        ),
        free=free,
    )


def route_update(tick: Tick) -> RouteUpdate:
    """Return the route of a tick, empty without one; its version and wishes are set by the owner.

    The error is the rider's sentence for a failed plan.
    """
    path, route, failure = tick.path, tick.memory.route, tick.memory.planning_failure
    error = failure.reason.sentence if failure is not None else ""
    if path is None:
        return RouteUpdate(version=0, error=error)
    return RouteUpdate(
        version=0,
        points=shown_line(path.points),
        without_wishes=shown_line(path.without_wishes),
        length=round(path.length, 2),
        extra_length=round(path.wishes.extra_length, 2),
        error=error,
        cause="first" if route is None else route.reason.value,
    )


def map_differences(rows: Integers) -> MapDifferences:
    """Return the places of persistent contradictions; cells that touch are one place.

    Args:
        rows: ``MapChanges.persistent_rows``.
    """
    found = [
        _difference(cells, new=new)
        for new in (False, True)
        for cells in connected_cells(rows[rows[:, 2] == int(new), :2])
    ]
    found.sort(key=lambda each: (-len(each.cells), each.kind, each.x, each.y))
    return MapDifferences(cell=CELL, found=tuple(found[:MAX_DIFFERENCES]))


def edge_cells(cells: Integers, grid: OccupancyGrid) -> EdgeCells:
    """Return cells (k, 2) of the map's grid as runs along the rows of its image."""
    places = (grid.centres(cells) - grid.bounds[:2]) / grid.resolution
    pixels = np.floor(places[:, ::-1]).astype(np.int64)
    pixels = pixels[np.lexsort(pixels.T[::-1])]
    steps = np.diff(pixels, axis=0, prepend=pixels[:1] - 2)
    first = np.flatnonzero((steps != (0, 1)).any(axis=1))
    count = np.diff(first, append=len(pixels))
    runs = np.column_stack([pixels[first], count])[np.argsort(-count, kind="stable")[:MAX_RUNS]]
    return EdgeCells(runs=tuple((row, col, n) for row, col, n in runs.tolist()))


def shown_line(line: Floats) -> Points:
    """Return the points of a line (k, 2) that a drawing needs, including both ends, m."""
    if len(line) >= 3:
        step = float(np.hypot(*np.diff(line, axis=0).T).mean())
        every = max(int(SHOWN_SPACING / max(step, 1e-6)), 1)
        kept = line[::every]
        line = kept if len(line) % every == 1 or every == 1 else np.vstack([kept, line[-1]])
    return _points(line)


def _rider_authority(tick: Tick) -> float:
    """Rider's share of control: 1 if they steer alone, 0 if the chair does."""
    if tick.request.mode.rider_drives:
        return 1.0
    if tick.request.mode is Mode.AUTONOMOUS or tick.authority is None:
        return 0.0
    return round(tick.authority.eta, 3)


def _plan(tick: Tick) -> tuple[Pose, ...]:
    """Poses of the next two seconds: the planner's, else those that the stick leads to."""
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


def _people(tick: Tick, sweeps: Observation) -> tuple[PersonInfo, ...]:
    """Tracked people; a person without a space yet has that of their body."""
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
    seen = in_view(sweeps, tracked.mean[:, :2])
    rows = np.column_stack([tracked.mean, tracked.radius, shape]).round(3)
    return tuple(
        PersonInfo(
            id=int(tracked.id[k]),
            **dict(zip(_COLUMNS, rows[k].tolist(), strict=True)),
            group=int(group[k]),
            seen=seen[k],
        )
        for k in np.flatnonzero(np.isfinite(rows).all(axis=1))
    )


_COLUMNS = ("x", "y", "vx", "vy", "radius", "axis", "front", "side", "rear")
"""Fields of ``PersonInfo``, in m, m/s and rad."""


def _extents(spaces: SocialSpaces, k: int) -> Floats:
    """(axis, front, side, rear) of one person's current space, in its first hypothesis."""
    shape = spaces.shape(k)
    ahead, aside, behind = (extent(shape, delta)[0] for delta in (0.0, math.pi / 2.0, math.pi))
    return np.array([spaces.axis[k, 0, 0], ahead, aside, behind])


def _groups(tick: Tick) -> tuple[Points, ...]:
    """Current outlines of the groups' spaces, m."""
    spaces = tick.spaces
    if spaces is None or spaces.groups is None:
        return ()
    hulls = spaces.groups
    lines = (hull_outline(hulls.direction, hulls.support[k, 0]) for k in range(len(hulls.id)))
    return tuple(_points(line) for line in lines if np.isfinite(line).all())


def _difference(cells: Integers, *, new: bool) -> MapDifference:
    centres = centres_of(cells)
    # The cell nearest to the mean, which may itself lie beside an L-shaped place.
    middle = centres[np.argmin(np.hypot(*(centres - centres.mean(axis=0)).T))]
    return MapDifference(
        kind="new" if new else "gone",
        x=round(float(middle[0]), 3),
        y=round(float(middle[1]), 3),
        cells=_points(centres[:MAX_CELLS]),
    )


def _points(line: Floats) -> Points:
    """Line (k, 2), m, as tuples."""
    return tuple((round(x, 3), round(y, 3)) for x, y in line.tolist())
