"""A scene laid on another map, moved and turned as a whole; see ``likeness`` for where."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import PlanningError, ScenarioError
from cohelm.evaluation.likeness import OPEN, SPACING, Lines, places_like
from cohelm.evaluation.scenario import Scenario
from cohelm.geometry import arc_length, compose, inverse, nearest_on_polyline, resample, transform
from cohelm.maps import MapWarning, OccupancyGrid, distance_field, read_map

if TYPE_CHECKING:
    from cohelm.evaluation.staging import Stage

WORST = 0.4
"""Difference of room beyond which no place is like the scene's own floor, m root mean square."""
ASIDE = 0.6
"""How far the route may lie from where the scene has it, at most, m."""
BESIDE = 0.10
"""Room that bodies need beyond themselves, m."""

Stager = Callable[[Scenario, int], "Stage"]


def laid(scenario: Scenario, stage: Stager) -> Scenario:
    """The scenario on the map that ``onto`` names, everything in it moved there.

    Args:
        scenario: with ``onto``.
        stage: what sets a scenario on stage.

    Raises:
        ScenarioError: if nowhere on the map is like the scene's own floor, or it has masks, which
            belong to their map.
        MapError: if the map cannot be read.
    """
    onto = scenario.onto
    if onto is None:
        return scenario
    if scenario.filters or scenario.crowding:
        raise ScenarioError(
            "masks belong to one map; this scenario cannot be laid on another",
            file=scenario.file,
            key="onto",
        )
    beside = scenario.beside(onto.map)
    file = beside if beside.is_file() else Path(onto.map).absolute()
    home = scenario.model_copy(update={"onto": None})
    places = _places(_Asked(home, stage), file, onto.place + 1)
    if len(places) <= onto.place:
        raise ScenarioError(
            f"{len(places) or 'no'} place{'s' if len(places) > 1 else ''} on {file.name} "
            f"{'are' if len(places) > 1 else 'is'} like the scene's own floor",
            file=scenario.file,
            key="onto",
        )
    return _moved(home, places[onto.place], stage(home, 0), file)


_DECIDES: dict[str, Any] = {
    **dict.fromkeys(("floor", "map", "plan", "robot", "people", "obstacles", "doors"), True),
    **dict.fromkeys(("start", "goal", "prefer", "stroke", "avoid", "global_planner"), True),
    **dict.fromkeys(("rider_goal", "rider_route"), True),
    "profile": {"clearance"},
}
"""What of a scenario its floor, its people and its routes come of."""


class _Asked:
    """A scene whose places are looked for; equal where all that decides on them is."""

    def __init__(self, home: Scenario, stage: Stager) -> None:
        self.home, self.stage = home, stage
        self._key = (home.model_dump_json(include=_DECIDES), home.file)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Asked) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


@lru_cache(maxsize=64)
def _places(asked: _Asked, file: Path, count: int) -> tuple[Floats, ...]:
    """X_MH (3,) of the first ``count`` places, H being the frame of the scene's own floor."""
    home = asked.stage(asked.home, 0)
    grid = read_map(file)  # warns once of what is odd about it
    middle, lines = _lines(home)
    found: list[Floats] = []
    for place in places_like(lines, grid):
        if place.difference > WORST or len(found) == count:
            break
        X_MH = compose(place.pose, inverse(middle))
        if any(_same(X_MH, other, middle) for other in found):
            continue
        if _sees_alike(home, grid, X_MH) and _same_route(asked, home, X_MH, file):
            found.append(X_MH)
    return tuple(found)


def _same(X_MH: Floats, other: Floats, middle: Floats) -> bool:
    """Whether the scene's middle comes to lie within 2 m of where it does elsewhere."""
    return math.dist(compose(X_MH, middle)[:2], compose(other, middle)[:2]) < 2.0


def _lines(home: Stage) -> tuple[Floats, Lines]:
    """The frame about the middle of the route (3,), and the scene's lines in it."""
    route = home.route.points
    along = arc_length(route)
    half = [np.interp(0.5 * along[-1], along, axis) for axis in route.T]
    middle = np.array([*half, 0.0])
    field = distance_field(home.grid)
    body = home.scenario.people.radius + BESIDE
    lines = [(route, home.robot.inscribed_radius + BESIDE)]
    lines += [(line, body) for line in _ways(home.scenario)]
    points, needs = [], []
    for line, need in lines:
        each = resample(line, SPACING) if len(line) > 1 else line
        points.append(each)
        needs.append(np.full(len(each), need))
    point = np.vstack(points)
    room = np.minimum(field.at(point), OPEN)
    need = np.minimum(np.concatenate(needs), room)  # no more than the scene has at home
    return middle, Lines(point=transform(inverse(middle), point), need=need, room=room)


def _ways(scenario: Scenario) -> Iterator[Floats]:
    """The lines (k, 2) that people walk, of a flow its lane and both borders."""
    for way in scenario.people.ways:
        yield np.array(way.points)
    for group in scenario.people.groups:
        yield np.array(group.points)
    for flow in scenario.people.flows:
        lane = np.array(flow.lane)
        left = np.diff(lane, axis=0, prepend=2.0 * lane[:1] - lane[1:2])
        left = np.stack([-left[:, 1], left[:, 0]], axis=-1) / np.hypot(*left.T)[:, None]
        for aside in (-0.5 * flow.width, 0.0, 0.5 * flow.width):
            yield lane + aside * left


def _sees_alike(home: Stage, grid: OccupancyGrid, X_MH: Floats) -> bool:
    """Whether the same people are in sight at the beginning as on the scene's own floor."""
    here, there = distance_field(home.grid), distance_field(grid)
    for way in home.scenario.people.ways:
        sight = resample(np.array([home.start[:2], way.points[0]]), 0.1)
        if (here.at(sight).min() > 0.0) != (there.at(transform(X_MH, sight)).min() > 0.0):
            return False
    return True


def _same_route(asked: _Asked, home: Stage, X_MH: Floats, file: Path) -> bool:
    """Whether a route is found there, near to where the scene has its own."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            route = asked.stage(_moved(asked.home, X_MH, home, file), 0).route.points
    except (PlanningError, ScenarioError):
        return False
    wanted = transform(X_MH, home.route.points)
    away = [nearest_on_polyline(wanted, x, y)[1] for x, y in resample(route, SPACING)]
    return max(away) <= ASIDE


def _moved(home: Scenario, X_MH: Floats, stage: Stage, file: Path) -> Scenario:
    """The scenario with everything that lies somewhere moved by X_MH (3,)."""
    turn = math.degrees(X_MH[2])

    def point(given: Any) -> tuple[float, float]:
        x, y = transform(X_MH, np.array(given, dtype=float)[:2])
        return float(x), float(y)

    def each(points: Any) -> tuple[tuple[float, float], ...]:
        return tuple(point(p) for p in points)

    def turned(thing: Any) -> Any:
        angle = thing.angle_deg + turn
        return thing.model_copy(update={"at": point(thing.at), "angle_deg": angle})

    def walked(way: Any) -> Any:
        facing = way.facing_deg
        facing = None if facing is None else math.remainder(facing + turn, 360.0)
        return way.model_copy(update={"points": each(way.points), "facing_deg": facing})

    people = home.people.model_copy(
        update={
            "ways": tuple(walked(way) for way in home.people.ways),
            "groups": tuple(
                group.model_copy(update={"points": each(group.points)})
                for group in home.people.groups
            ),
            "flows": tuple(
                flow.model_copy(update={"lane": each(flow.lane)}) for flow in home.people.flows
            ),
        }
    )
    x, y, heading = compose(X_MH, stage.start)
    wanted = home.rider_goal
    rider = {k: list(point(v)) if k == "near" and v else v for k, v in home.rider.items()}
    return home.model_copy(
        update={
            "floor": None,
            "plan": {},
            "map": str(file),
            "start": (float(x), float(y), math.degrees(heading)),
            "goal": point(stage.request.goal),
            "rider_goal": wanted if wanted is None or isinstance(wanted, str) else point(wanted),
            "rider_route": each(home.rider_route),
            "prefer": tuple(each(points) for points in home.prefer),
            "stroke": each(home.stroke),
            "avoid": tuple(
                zone.model_copy(update={"points": each(zone.points)}) for zone in home.avoid
            ),
            "people": people,
            "obstacles": tuple(turned(thing) for thing in home.obstacles),
            "doors": tuple(turned(thing) for thing in home.doors),
            "rider": rider,
        }
    )
