"""A storey as one chair meets it: the planner's paths to its rooms, and the changes that open them.

The cause of an unreachable room is a counterfactual: doors are widened and rooms cleared on a copy
of the map until the planner finds a path. Sets of changes are tried by size, so that small
ones are found. A flood fill of the cells where the chair's inscribed circle fits, which every path
needs, leaves out most sets; the planner confirms the others.
"""

from __future__ import annotations

import itertools
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping
from typing import Literal, NamedTuple

import numpy as np
from scipy import ndimage

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Integers, Shape, replace, value
from cohelm.buildings.storey import (
    BuildingStorey,
    Door,
    inner_distance,
    polygon_cells,
    room_beside,
    room_cells,
)
from cohelm.errors import NoPath, PlanningError
from cohelm.geometry import inverse, transform
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, OccupancyGrid, distance_field, signed_distance
from cohelm.messages import Path
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.planning.free_space import HEADINGS, FreeSpaceCheck, check_free_space
from cohelm.planning.path_refinement.footprint import footprint_model, overlaps
from cohelm.robots import Robot

FaultKind = Literal[
    "width", "map", "blocked", "turn", "threshold", "furniture", "space", "lift", "stairs"
]
"""Doors too narrow, closed by the map's cells, obstructed, or with too tight a turn in front; a
threshold; obstacles in a room; a place without space to turn; a lift too small; at most stairs."""
NO_PLACE = "no place where the footprint fits, even without furniture"
TURNING_SPACE = 1.5
"""Side of the level landing in front of an entrance, and of a manoeuvring space, m (ISO 21542)."""
_WIDER = (0.8, 0.9, 1.0, 1.1, 1.2)
"""Clear widths that are tried where the turn into a door is too tight, m."""
_GOALS = 3
"""Points of a room that are tried before it counts as unreachable."""
_APART = 0.5
"""Distance between them, m."""
_LARGEST_SET = 3
_LARGEST_TURNS = 2
_MOST_SETS = 400
_TRIAL = 0.15
"""Effort of the planner on changed maps, where a path is short of neither space nor time."""
_NEAR = 1.5
"""Distance from where the footprint is stuck to doors that may be the cause, m."""


class AccessFault(NamedTuple):
    """Cause that keeps the chair out of a room."""

    kind: FaultKind
    id: str
    """Id of the door or room, name of the lift, or storeys and point."""
    storey: int
    point: tuple[float, float]
    """Map frame, m."""
    width: float = 0.0
    """Clear width with which the turn is possible, m; for ``turn``."""


_Changes = Mapping[AccessFault, Booleans]
"""Cells (rows, cols) that are freed, by the fault that this mends."""


@value
class AccessSource:
    """Point of a storey where the chair arrives."""

    name: str
    point: Annotated[Floats, Shape("2")]
    legs: tuple[tuple[int, Floats], ...] = ()
    """Paths (k, 2) to lifts on the way to it, m, each with the number of its storey."""
    via: tuple[str, ...] = ()
    """Lifts taken."""
    faults: frozenset[AccessFault] = frozenset()
    """Causes that keep the chair from arriving; empty if it does."""


@value
class RoomResult:
    """Path to a room, or small sets of changes that open one."""

    path: Annotated[Floats, Shape("k 2")] | None = None
    source: AccessSource | None = None
    sets: tuple[frozenset[AccessFault], ...] = ()
    remark: str = ""
    """Reason where there is neither."""


class _Reach(NamedTuple):
    """Map after some changes."""

    grid: OccupancyGrid
    clearance: Floats32
    labels: Integers
    """Connected cells where the inscribed circle fits, from 1 on."""
    reached: Booleans
    """Those connected to a source."""


class ChairFloor:
    """Map of a storey, with landings outside and closed thresholds, and the planner on it.

    Args:
        storey: the storey.
        robot: the chair.
        planner: global planner.
        entrances: doors to the outside in front of which a level landing is assumed.
    """

    def __init__(
        self,
        storey: BuildingStorey,
        robot: Robot,
        planner: GlobalPlanner,
        entrances: Iterable[Door],
    ) -> None:
        self.storey, self.robot, self._planner = storey, robot, planner
        self.needed = needed_width(robot)
        self.landing = max(TURNING_SPACE, 2.0 * robot.circumscribed_radius) + 0.1
        count = int(np.ceil((self.landing + 0.5) / storey.grid.resolution))
        corner = transform(storey.grid.X_MG, np.full(2, -count * storey.grid.resolution))
        data = np.pad(storey.grid.data, count, constant_values=UNKNOWN)
        X_MG = np.array([*corner, storey.grid.X_MG[2]])
        self.grid = replace(storey.grid, data=data.copy(), X_MG=X_MG)
        for door in entrances:
            data[self._ahead(door, outward(door, storey)) & (data == UNKNOWN)] = FREE
        for door in storey.doors:
            if (door.threshold or 0.0) > robot.max_step_up:
                data[self._doorway(door, door.opening + 2.0 * self.grid.resolution)] = OCCUPIED
        self.grid = replace(self.grid, data=data)
        self.rooms = {room.id: room_cells(room, self.grid) for room in storey.rooms}
        """Cells of what the chair shall reach: rooms, and the floor in front of lifts."""
        self._known: list[tuple[str, _Changes]] = []
        self._fixed = polygon_cells([link.polygon for link in storey.links], self.grid)

    def before(self, door: Door, out: Floats) -> Floats:
        """Middle (2,) of the landing in front of a door, on the side ``out`` (2,)."""
        middle: Floats = door.point + out * (door.depth + self.landing) / 2.0
        return middle

    def in_front(self, door: Door, out: Floats) -> Booleans:
        """Cells of a landing to which free floor leads from the door; furniture beside it."""
        square, free = self._ahead(door, out), ~self.grid.blocked()
        half, margin = door.width / 2.0, 0.1 + self.grid.resolution
        mouth = square & polygon_cells([door.part(-half, half, margin)], self.grid)
        changes = self._changes()
        rooms = [changes[fault] for fault in changes if fault.kind == "furniture"]
        furniture = square & np.logical_or.reduce([np.zeros_like(square), *rooms])
        floor = ndimage.binary_propagation(mouth, mask=mouth | (square & free)) & free
        # Furniture is no wall: the chair gets to its cells where a change clears the room.
        beside = ndimage.binary_propagation(mouth | floor, mask=mouth | floor | furniture)
        front: Booleans = floor | (beside & furniture)
        return front

    def place_in(self, room: str) -> Floats | None:
        """Roomiest point (2,) of a room where the chair fits, m; None: there is none."""
        now = self._reach({}, [])
        return next(self._goals(room, now, now.labels > 0), None)

    def check(self, point: Floats) -> FreeSpaceCheck:
        """Check that the footprint fits at a point (2,) at some heading, and where it does."""
        x, y = point.tolist()
        return check_free_space(self.grid, self.robot, (x, y))

    def survey(
        self, sources: list[AccessSource], before: Mapping[str, RoomResult] | None = None
    ) -> dict[str, RoomResult]:
        """Result of each room, by id; the first sources are preferred, paths of ``before`` kept."""
        now = self._reach({}, sources)
        sources = self._distinct(sources, now)
        found = {room: each for room, each in (before or {}).items() if each.path is not None}
        stuck: dict[str, Floats | None] = {}
        for room in [each for each in self.rooms if each not in found]:
            result, stuck[room] = self._plan(room, now, sources)
            if result is not None:
                found[room] = result
        # The planner may find in two parts what it does not find in one.
        for _ in self.rooms:
            new = self._by_hubs([room for room in self.rooms if room not in found], found, now)
            if not new:
                break
            found |= new
        missing = [room for room in self.rooms if room not in found]
        sets: dict[str, list[frozenset[AccessFault]]] = {}
        for room in missing:
            if (at := stuck[room]) is not None:
                near = [hub for hub, _ in self._hubs(room, found, now)]
                sets[room] = self._open_turn(room, at, {}, [*near, *sources])
        if unopened := [room for room in missing if stuck[room] is None]:
            sets |= self._open(unopened, now, sources)
        for room in missing:
            opened = tuple(sorted(set(sets.get(room, ())), key=sorted))
            remark = "" if opened else self._without_remedy(room)
            found[room] = RoomResult(sets=opened, remark=remark)
        return found

    def clear_of(self, room: str) -> float:
        """Diameter of the largest free circle in a room, m."""
        free = self.rooms[room] & ~self.grid.blocked()
        return 2.0 * float(inner_distance(free, self.grid.resolution).max())

    def _beside(self, room: str) -> set[str]:
        """Ids of a room and of those that a door joins to it."""
        return {each for door in self.storey.doors if room in door.rooms for each in door.rooms}

    def _hubs(
        self, room: str, found: Mapping[str, RoomResult], now: _Reach
    ) -> list[tuple[AccessSource, RoomResult]]:
        """Ends of paths to the rooms beside one at which the chair can turn on the spot."""
        hubs = []
        for other in self._beside(room) - {room}:
            result = found.get(other)
            if result is not None and result.path is not None and result.source is not None:
                end = tuple(now.grid.cells(result.path[-1]))
                if now.clearance[end] > self.robot.circumscribed_radius + 0.5 * now.grid.resolution:
                    hubs.append((replace(result.source, point=result.path[-1]), result))
        return sorted(hubs, key=lambda hub: len(hub[1].path if hub[1].path is not None else ()))

    def _by_hubs(
        self, rooms: list[str], found: Mapping[str, RoomResult], now: _Reach
    ) -> dict[str, RoomResult]:
        """Results of rooms that the planner reaches from a room beside them."""
        new = {}
        for room in rooms:
            for hub, first in self._hubs(room, found, now):
                second, _ = self._plan(room, now, [hub], goals=1)
                if second is not None and second.path is not None and first.path is not None:
                    path = np.concatenate([first.path, second.path[1:]])
                    new[room] = RoomResult(path=path, source=first.source)
                    break
        return new

    def _open(
        self, rooms: list[str], now: _Reach, sources: list[AccessSource]
    ) -> dict[str, list[frozenset[AccessFault]]]:
        """Small sets of changes that open rooms, by breadth-first search over sets."""
        changes = self._changes()
        found: dict[str, list[frozenset[AccessFault]]] = {}
        level: dict[frozenset[AccessFault], _Reach] = {frozenset(): now}
        tried = 0
        for _ in range(_LARGEST_SET):
            following: dict[frozenset[AccessFault], _Reach] = {}
            for chosen, reach in level.items():
                away = signed_distance(reach.reached, self.grid.resolution)
                for fault, cells in changes.items():
                    near = float(away[cells].min(initial=np.inf))
                    extended = chosen | {fault}
                    if fault in chosen or extended in following or tried >= _MOST_SETS:
                        continue
                    if near <= self.robot.inscribed_radius + 0.3:
                        tried += 1
                        freed = {each: changes[each] for each in extended}
                        following[extended] = self._reach(freed, sources)
            for room in rooms:
                tight: list[tuple[frozenset[AccessFault], Floats]] = []
                sets = []
                for chosen, reach in following.items():
                    result, stuck = self._plan(room, reach, sources, _TRIAL)
                    if result is not None:
                        sets.append(chosen)
                    elif stuck is not None:
                        tight.append((chosen, stuck))
                for chosen, stuck in tight[:2] if not sets else ():
                    freed = {each: changes[each] for each in chosen}
                    sets += self._open_turn(room, stuck, freed, sources)
                if sets:
                    found[room] = sets
            rooms, level = [room for room in rooms if room not in found], following
            if not rooms:
                break
        return found

    def _open_turn(
        self, room: str, stuck: Floats, base: _Changes, sources: list[AccessSource]
    ) -> list[frozenset[AccessFault]]:
        """Sets with wider doors, cleared rooms or free circles where a path is stuck at a point.

        A single change is tried at each place where the planner is stuck; if none is enough, the
        circle there stays free, and the next place is looked at. Changes without need are dropped.
        ``base`` are changes that are needed besides.
        """

        def plan(freed: _Changes) -> tuple[RoomResult | None, Floats | None]:
            return self._plan(room, self._reach(freed, sources), sources, _TRIAL, goals=2)

        near = [door.point for door in self.storey.doors if room in door.rooms]
        for other, known in list(self._known):
            if other not in self._beside(room):
                continue
            result, after = plan({**base, **known})
            if result is not None:
                return [frozenset({**base, **known})]
            # What opens the room before this one is not tried again.
            if after is not None and any(np.hypot(*(after - each)) < _NEAR for each in near):
                base, stuck = {**base, **known}, after
                break
        for _ in range(_LARGEST_TURNS):
            options, circles = self._options(room, stuck)
            found = [each for each in options if plan({**base, **each})[0] is not None]
            for circle in circles if not found else ():
                result, after = plan({**base, **circle})
                if result is not None:
                    found = [circle]
                    break
            sets = []
            for each in found:
                whole: _Changes = {**base, **each}
                for fault in base:
                    rest = {key: cells for key, cells in whole.items() if key != fault}
                    whole = rest if plan(rest)[0] is not None else whole
                for fault in [fault for fault in whole if fault.width]:
                    door = next(each for each in self.storey.doors if each.id == fault.id)
                    narrower = [
                        {key: cells for key, cells in whole.items() if key != fault}
                        | self._widened(door, width)
                        for width in _WIDER[:-1]
                        if width > door.width
                    ]
                    # Wider is no worse: bisection.
                    at = bisect_left(narrower, True, key=lambda freed: plan(freed)[0] is not None)
                    whole = [*narrower, whole][at]
                sets.append(frozenset(whole))
                self._known.append((room, whole))
            if sets or after is None:
                return sets
            base, stuck = {**base, **circle}, after
        return []

    def _options(
        self, room: str, stuck: Floats
    ) -> tuple[list[dict[AccessFault, Booleans]], list[dict[AccessFault, Booleans]]]:
        """Single changes near the place (2,) where a path is stuck: doors, rooms; free circles."""
        away = {
            door: float(np.hypot(*(door.point - stuck)))
            for door in self.storey.doors
            if door.kind != "open border"
        }
        doors = [door for door in away if room in door.rooms or away[door] < _NEAR]
        doors = sorted(doors, key=lambda door: away[door])[:2]
        options = [self._widened(door, _WIDER[-1]) for door in doors]
        row, col = self.grid.cells(stuck)
        options += [
            {fault: cells}
            for fault, cells in self._changes().items()
            if fault.kind == "furniture" and (self.rooms[fault.id][row, col] or fault.id == room)
        ]
        circles = [
            {
                fault._replace(width=0.0): cells
                | self._circle(self.before(door, door.normal))
                | self._circle(self.before(door, -door.normal))
            }
            for door in doors
            for fault, cells in self._widened(door, _WIDER[-1]).items()
        ]
        x, y = stuck.tolist()
        space = AccessFault("space", f"({x:.1f}, {y:.1f})", self.storey.number, (x, y))
        return options, [*circles, {space: self._circle(stuck)}]

    def _circle(self, point: Floats) -> Booleans:
        """Cells of a circle to turn in about a point (2,), but none of other rooms."""
        away = np.hypot(*(np.indices(self.grid.shape).T - self.grid.cells(point)).T)
        free: Booleans = away * self.grid.resolution < self.landing / 2.0
        at = tuple(np.clip(self.grid.cells(point), 0, np.array(self.grid.shape) - 1))
        for cells in self.rooms.values():
            if not cells[at]:
                free &= ~ndimage.binary_dilation(cells, iterations=3)
        return free

    def _widened(self, door: Door, width: float) -> dict[AccessFault, Booleans]:
        x, y = door.point.tolist()
        kind: FaultKind = "width" if door.width < self.needed else "turn"
        fault = AccessFault(kind, door.id, self.storey.number, (x, y), width)
        return {fault: self._doorway(door, width)}

    def _changes(self) -> dict[AccessFault, Booleans]:
        """Cells that a change frees: a door as wide as the chair, a room without furniture."""
        res = self.grid.resolution
        found: dict[AccessFault, Booleans] = {}
        for door in self.storey.doors:
            cells = self._doorway(door, max(self.needed + 2.0 * res, door.width))
            if door.kind != "open border" and self.grid.blocked()[cells].any():
                x, y = door.point.tolist()
                kind: FaultKind = "blocked"
                if door.width < self.needed:
                    kind = "width"
                elif (door.threshold or 0.0) > self.robot.max_step_up:
                    kind = "threshold"
                elif door.width < self.needed + 2.0 * res:
                    kind = "map"
                found[AccessFault(kind, door.id, self.storey.number, (x, y))] = cells
        for room in self.storey.rooms:
            inner = ndimage.binary_erosion(self.rooms[room.id])
            for door in self.storey.doors:
                if room.id in door.rooms:  # up to the door: furniture may stand against it
                    mouth = self._doorway(door, max(door.width - 2.0 * res, res))
                    inner |= mouth & self.rooms[room.id]
            cells = inner & (self.grid.data == OCCUPIED) & ~self._fixed
            if cells.any():
                x, y = room.polygons[0].mean(axis=0).tolist()
                found[AccessFault("furniture", room.id, self.storey.number, (x, y))] = cells
        return found

    def _doorway(self, door: Door, width: float) -> Booleans:
        """Cells of a doorway, with a margin on both sides of the wall."""
        margin = 0.1 if door.depth else 0.4
        return polygon_cells([door.part(-width / 2.0, width / 2.0, margin)], self.grid)

    def _ahead(self, door: Door, out: Floats) -> Booleans:
        """Cells of a square as wide as a landing in front of a door, on the side ``out`` (2,)."""
        landing = replace(door, point=self.before(door, out), depth=self.landing)
        return polygon_cells([landing.part(-self.landing / 2.0, self.landing / 2.0)], self.grid)

    def _reach(self, freed: _Changes, sources: list[AccessSource]) -> _Reach:
        grid = self.grid
        if freed:
            cells = np.logical_or.reduce([*freed.values()])
            grid = replace(grid, data=np.where(cells, FREE, grid.data).astype(np.int8))
        clearance = distance_field(grid).distance
        labels = ndimage.label(clearance > self.robot.inscribed_radius, np.ones((3, 3)))[0]
        at = [labels[tuple(grid.cells(each.point))] for each in sources]
        reached = np.isin(labels, [label for label in at if label])
        return _Reach(grid, clearance, labels.astype(np.int64), reached)

    def _plan(
        self,
        room: str,
        reach: _Reach,
        sources: list[AccessSource],
        effort: float = 1.0,
        goals: int = _GOALS,
    ) -> tuple[RoomResult | None, Floats | None]:
        """Path to a room from the first source that may have one; else the place where it is stuck.

        The place is None if the inscribed circle does not get to a place where the footprint fits.
        """
        stuck: Floats | None = None
        for goal in itertools.islice(self._goals(room, reach, reach.reached), goals):
            label = reach.labels[tuple(reach.grid.cells(goal))]
            same = (e for e in sources if reach.labels[tuple(reach.grid.cells(e.point))] == label)
            source = next(same, None)
            if source is None:
                continue
            found = self._path(reach.grid, source.point, goal, effort)
            if isinstance(found, Path):
                return RoomResult(path=found.points, source=source), None
            stuck = found if stuck is None else stuck
            # Other points of the room help only if the path is stuck at this one.
            if np.hypot(*(found - goal)) > 2.0 * self.robot.circumscribed_radius:
                break
        return None, stuck

    def _path(
        self, grid: OccupancyGrid, start: Floats, goal: Floats, effort: float = 1.0
    ) -> Path | Floats:
        """Path of the planner, or the place (2,) where it is stuck."""
        problem = RouteProblem(grid=grid, robot=self.robot, start=start, goal=goal, effort=effort)
        try:
            return self._planner.plan(problem)
        except NoPath as cause:
            return goal if cause.passage is None else np.array(cause.passage.point)
        except PlanningError:
            return goal

    def _distinct(self, sources: list[AccessSource], now: _Reach) -> list[AccessSource]:
        """Sources without those that the chair reaches from one before, and so need no search."""
        found: list[AccessSource] = []
        for source in sources:
            labels = now.labels[tuple(now.grid.cells([each.point for each in [*found, source]]).T)]
            same = [each for each, label in zip(found, labels, strict=False) if label == labels[-1]]
            paths = (self._path(now.grid, each.point, source.point) for each in same)
            if not any(isinstance(path, Path) for path in paths):
                found.append(source)
        return found

    def _goals(self, room: str, reach: _Reach, cells: Booleans) -> Iterator[Floats]:
        """Points of a room among ``cells`` where the footprint fits, the roomiest first."""
        chosen = self.rooms[room] & cells & (reach.clearance > self.robot.inscribed_radius)
        left = np.argwhere(chosen)
        depth = inner_distance(self.rooms[room] & ~reach.grid.blocked(), self.grid.resolution)
        left = left[np.argsort(-depth[chosen], kind="stable")]
        body = footprint_model(self.robot.outline, reach.clearance, self.grid.resolution)
        angles = np.linspace(0.0, 2.0 * np.pi, HEADINGS, endpoint=False)
        while len(left):
            point = reach.grid.centres(left[0])
            x, y = transform(inverse(reach.grid.X_MG), point)
            if any(not overlaps(body, x, y, angle) for angle in angles):
                yield point
                apart = np.hypot(*(left - left[0]).T) * self.grid.resolution
                left = left[apart > _APART]
            else:
                left = left[1:]

    def _without_remedy(self, room: str) -> str:
        """Reason why no set of changes opens a room."""
        cells, links = self.rooms[room], self.storey.links
        stairs = polygon_cells([e.polygon for e in links if e.kind == "stairs"], self.grid)
        if np.count_nonzero(stairs & cells) > 0.3 * np.count_nonzero(cells):
            return "only by stairs: they fill the room"
        changes = self._changes().items()
        freed = {fault: free for fault, free in changes if fault[:2] == ("furniture", room)}
        if next(self._goals(room, self._reach(freed, []), cells), None) is None:
            return NO_PLACE
        if ndimage.binary_dilation(stairs, iterations=4)[cells].any():
            return "only by stairs"
        if not any(room in door.rooms for door in self.storey.doors):
            return "no door leads to it"
        return f"no change of up to {_LARGEST_SET} doors and rooms on the way opens it"


def needed_width(robot: Robot) -> float:
    """Clear width that a chair needs driving straight: that of its footprint, m."""
    return float(np.ptp(robot.outline[:, 1]))


def is_entrance(door: Door) -> bool:
    """Check that a door of a model leads outside: it joins one room only."""
    return door.kind in {"door", "opening"} and len(door.rooms) == 1


def outward(door: Door, storey: BuildingStorey) -> Floats:
    """Unit vector (2,) across a door, out of its room."""
    rooms = [room for room in storey.rooms if room.id in door.rooms]
    return door.normal if room_beside(door, rooms, 1.0) is None else -door.normal
