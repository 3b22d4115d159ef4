"""A storey as one chair meets it: the planner's paths to its rooms, and the changes that open them.

The cause of an unreachable room is a counterfactual: doors are widened and rooms cleared on a copy
of the map until the planner finds a path. Sets of changes are tried by size, so that small
ones are found. A flood fill of the cells where the chair's inscribed circle fits, which every path
needs, leaves out most sets; the planner confirms the others.
"""

from __future__ import annotations

import itertools
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Literal, NamedTuple

import numpy as np
from scipy import ndimage

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Integers, Shape, replace, value
from cohelm.buildings.storey import BuildingStorey, Door, Room, polygon_cells, room_cells
from cohelm.errors import NoPath, PlanningError
from cohelm.geometry import inverse, transform
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, OccupancyGrid, distance_field, signed_distance
from cohelm.messages import Path
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.planning.free_space import HEADINGS, check_free_space
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
        entrances: Iterable[Door] = (),
    ) -> None:
        self.storey, self.robot, self._planner = storey, robot, planner
        self.needed = needed_width(robot)
        self.landing = max(TURNING_SPACE, 2.0 * robot.circumscribed_radius) + 0.1
        self.grid = _padded(storey.grid, self.landing + 0.5)
        data = self.grid.data.copy()
        for door in entrances:
            data[self.ahead(door, outward(door, storey)) & (data == UNKNOWN)] = FREE
        for door in storey.doors:
            if (door.threshold or 0.0) > robot.max_step_up:
                data[self._doorway(door, door.opening + 2.0 * self.grid.resolution)] = OCCUPIED
        self.grid = replace(self.grid, data=data)
        self.rooms = {room.id: room_cells(room, self.grid) for room in storey.rooms}
        """Cells of what the chair shall reach: rooms, and the floor in front of lifts."""
        self._known: list[tuple[str, dict[AccessFault, Booleans]]] = []
        self._fixed = polygon_cells([link.polygon for link in storey.links], self.grid)

    def outside_point(self, door: Door) -> Floats:
        """Middle (2,) of the landing in front of a door to the outside."""
        return door.point + outward(door, self.storey) * (door.depth + self.landing) / 2.0

    def ahead(self, door: Door, out: Floats) -> Booleans:
        """Cells of a square as wide as a landing in front of a door, on the side ``out`` (2,)."""
        side, along = self.landing, door.direction
        near = door.point + out * door.depth / 2.0
        corners = [near + along * a * side / 2.0 + out * b * side for a, b in _SQUARE]
        return polygon_cells([np.array(corners)], self.grid)

    def in_front(self, door: Door, out: Floats) -> Booleans:
        """Cells of :meth:`ahead` to which free floor leads from the door; furniture beside it."""
        square, free = self.ahead(door, out), ~self.grid.blocked()
        half, margin = door.width / 2.0, 0.1 + self.grid.resolution
        mouth = square & polygon_cells([door.part(-half, half, margin)], self.grid)
        rooms = [cells for key, cells in self._changes().items() if key.startswith("room ")]
        furniture = square & np.logical_or.reduce([np.zeros_like(square), *rooms])
        floor = ndimage.binary_propagation(mouth, mask=mouth | (square & free)) & free
        # Furniture is no wall: the chair gets to its cells where a change clears the room.
        beside = ndimage.binary_propagation(mouth | floor, mask=mouth | floor | furniture)
        front: Booleans = floor | (beside & furniture)
        return front

    def place_in(self, room: str) -> Floats | None:
        """Roomiest point (2,) of a room where the chair fits, m; None: there is none."""
        now = self._reach(np.zeros(self.grid.shape, dtype=np.bool_), [])
        return next(self._goals(room, now, now.labels > 0), None)

    def place_near(self, point: Floats) -> Floats | None:
        """Nearest point (2,) where the chair fits, map frame, m; None: there is none."""
        x, y = point.tolist()
        found = check_free_space(self.grid, self.robot, (x, y)).nearest
        return None if found is None else np.array(found)

    def fits(self, point: Floats) -> bool:
        """Check that the footprint fits at a point (2,) at some heading."""
        x, y = point.tolist()
        return check_free_space(self.grid, self.robot, (x, y)).fits

    def survey(
        self, sources: list[AccessSource], before: Mapping[str, RoomResult] | None = None
    ) -> dict[str, RoomResult]:
        """Result of each room, by id; the first sources are preferred, paths of ``before`` kept."""
        now = self._reach(np.zeros(self.grid.shape, dtype=np.bool_), sources)
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
                sets[room] = self._open_turn(room, at, frozenset(), [*near, *sources])
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
        window = _window(free)
        inside = np.pad(free[window], 1)
        clearance = signed_distance(~inside, self.grid.resolution)
        return 2.0 * max(float(clearance.max(initial=0.0)), 0.0)

    def _hubs(
        self, room: str, found: Mapping[str, RoomResult], now: _Reach
    ) -> list[tuple[AccessSource, RoomResult]]:
        """Ends of paths to the rooms beside one at which the chair can turn on the spot."""
        beside = {each for door in self.storey.doors if room in door.rooms for each in door.rooms}
        hubs = []
        for other in beside - {room}:
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
                if second is None or second.path is None or first.path is None:
                    continue
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
        level: dict[frozenset[str], _Reach] = {frozenset(): now}
        tried = 0
        for _ in range(_LARGEST_SET):
            following: dict[frozenset[str], _Reach] = {}
            for chosen, reach in level.items():
                away = signed_distance(reach.reached, self.grid.resolution)
                for key, cells in changes.items():
                    near = float(away[cells].min(initial=np.inf))
                    extended = chosen | {key}
                    if key in chosen or extended in following or tried >= _MOST_SETS:
                        continue
                    if near <= self.robot.inscribed_radius + 0.3:
                        tried += 1
                        freed = np.logical_or.reduce([changes[each] for each in extended])
                        following[extended] = self._reach(freed, sources)
            opened = {room: self._confirm(room, following, sources) for room in rooms}
            found |= {room: sets for room, sets in opened.items() if sets}
            rooms = [room for room in rooms if room not in found]
            level = following
            if not rooms:
                break
        return found

    def _confirm(
        self, room: str, sets: Mapping[frozenset[str], _Reach], sources: list[AccessSource]
    ) -> list[frozenset[AccessFault]]:
        """Sets of changes with which the planner reaches a room."""
        found: list[frozenset[AccessFault]] = []
        tight: list[tuple[frozenset[str], Floats]] = []
        for chosen, reach in sets.items():
            result, stuck = self._plan(room, reach, sources, _TRIAL)
            if result is not None:
                found.append(frozenset(self._fault(key) for key in chosen))
            elif stuck is not None:
                tight.append((chosen, stuck))
        for chosen, stuck in tight[:2] if not found else ():
            found += self._open_turn(room, stuck, chosen, sources)
        return found

    def _open_turn(
        self, room: str, stuck: Floats, chosen: frozenset[str], sources: list[AccessSource]
    ) -> list[frozenset[AccessFault]]:
        """Sets with wider doors, cleared rooms or free circles where a path is stuck.

        A single change is tried at each place where the planner is stuck; if none is enough, the
        circle there stays free, and the next place is looked at. Changes without need are dropped.

        Args:
            room: id.
            stuck: the place (2,), m.
            chosen: changes that are needed besides.
            sources: where the chair arrives.
        """
        changes = self._changes()
        base = {self._fault(key): changes[key] for key in chosen}

        def plan(freed: Mapping[AccessFault, Booleans]) -> tuple[RoomResult | None, Floats | None]:
            cells = np.logical_or.reduce([*freed.values()])
            return self._plan(room, self._reach(cells, sources), sources, _TRIAL, goals=2)

        near = [door.point for door in self.storey.doors if room in door.rooms]
        beside = {each for door in self.storey.doors if room in door.rooms for each in door.rooms}
        for other, known in list(self._known):
            if other not in beside:
                continue
            result, after = plan(base | known)
            if result is not None:
                return [frozenset(base | known)]
            # What opens the room before this one is not tried again.
            if after is not None and any(np.hypot(*(after - each)) < _NEAR for each in near):
                base, stuck = base | known, after
                break
        for _ in range(_LARGEST_TURNS):
            options, circles = self._options(room, stuck, changes)
            found = [each for each in options if plan(base | each)[0] is not None]
            circle = circles[-1]
            for each in circles if not found else ():
                result, after = plan(base | each)
                if result is not None:
                    found, circle = [each], each
                    break
            if found:
                sets = []
                for each in found:
                    whole = base | each
                    for fault in base:
                        rest = {key: cells for key, cells in whole.items() if key != fault}
                        whole = rest if plan(rest)[0] is not None else whole
                    whole = self._with_least_width(whole, lambda freed: plan(freed)[0] is not None)
                    sets.append(frozenset(whole))
                    self._known.append((room, whole))
                return sets
            if after is None:
                break
            base, stuck = base | circle, after
        return []

    def _options(
        self, room: str, stuck: Floats, changes: Mapping[str, Booleans]
    ) -> tuple[list[dict[AccessFault, Booleans]], list[dict[AccessFault, Booleans]]]:
        """Single changes near the place (2,) where a path is stuck: doors, rooms; free circles."""
        doors = [
            door
            for door in self.storey.doors
            if door.kind != "open border"
            and (room in door.rooms or np.hypot(*(door.point - stuck)) < _NEAR)
        ]
        doors = sorted(doors, key=lambda door: float(np.hypot(*(door.point - stuck))))[:2]
        options = [
            {self._turn_fault(door, _WIDER[-1]): self._doorway(door, _WIDER[-1])} for door in doors
        ]
        row, col = self.grid.cells(stuck)
        options += [
            {self._fault(key): cells}
            for key, cells in changes.items()
            if key.startswith("room ") and (self.rooms[key[5:]][row, col] or key[5:] == room)
        ]
        circles = [
            {
                self._turn_fault(door, 0.0): self._doorway(door, _WIDER[-1])
                | self._beside(door, 1.0)
                | self._beside(door, -1.0)
            }
            for door in doors
        ]
        at = (float(stuck[0]), float(stuck[1]))
        where = f"({at[0]:.1f}, {at[1]:.1f})"
        space = AccessFault("space", where, self.storey.number, at)
        return options, [*circles, {space: self._circle(stuck)}]

    def _with_least_width(
        self,
        freed: dict[AccessFault, Booleans],
        passes: Callable[[Mapping[AccessFault, Booleans]], bool],
    ) -> dict[AccessFault, Booleans]:
        """Changes with the widened door, if there is one, as narrow as the planner allows."""
        wide = [fault for fault in freed if fault.width]
        for fault in wide:
            door = next(each for each in self.storey.doors if each.id == fault.id)
            rest = {key: cells for key, cells in freed.items() if key != fault}
            widths = [each for each in _WIDER[:-1] if each > door.width]
            # Wider is no worse: bisection.
            at = bisect_left(
                widths, True, key=lambda width: passes(rest | {fault: self._doorway(door, width)})
            )
            if at < len(widths):
                freed = rest | {fault._replace(width=widths[at]): self._doorway(door, widths[at])}
        return freed

    def _beside(self, door: Door, side: float) -> Booleans:
        """Cells of a circle in front of a door, in which the chair can turn."""
        normal = side * np.array([-door.direction[1], door.direction[0]])
        return self._circle(door.point + normal * (door.depth + self.landing) / 2.0)

    def _circle(self, point: Floats) -> Booleans:
        """Cells of a circle to turn in about a point (2,), but none of other rooms."""
        away = np.hypot(*(np.indices(self.grid.shape).T - self.grid.cells(point)).T)
        free: Booleans = away * self.grid.resolution < self.landing / 2.0
        at = tuple(np.clip(self.grid.cells(point), 0, np.array(self.grid.shape) - 1))
        for cells in self.rooms.values():
            if not cells[at]:
                free &= ~ndimage.binary_dilation(cells, iterations=3)
        return free

    def _turn_fault(self, door: Door, width: float) -> AccessFault:
        x, y = door.point.tolist()
        kind: FaultKind = "width" if door.width < self.needed else "turn"
        return AccessFault(kind, door.id, self.storey.number, (x, y), width)

    def _fault(self, key: str) -> AccessFault:
        """Fault that a change of :meth:`_changes` mends."""
        what, _, name = key.partition(" ")
        if what == "room":
            room = next(each for each in self.storey.rooms if each.id == name)
            x, y = room.polygons[0].mean(axis=0).tolist()
            return AccessFault("furniture", name, self.storey.number, (x, y))
        door = next(each for each in self.storey.doors if each.id == name)
        x, y = door.point.tolist()
        kind: FaultKind = "blocked"
        if door.width < self.needed:
            kind = "width"
        elif (door.threshold or 0.0) > self.robot.max_step_up:
            kind = "threshold"
        elif door.width < self.needed + 2.0 * self.grid.resolution:
            kind = "map"
        return AccessFault(kind, name, self.storey.number, (x, y))

    def _changes(self) -> dict[str, Booleans]:
        """Cells that a change frees: a door as wide as the chair, a room without furniture."""
        res, found = self.grid.resolution, {}
        for door in self.storey.doors:
            cells = self._doorway(door, max(self.needed + 2.0 * res, door.width))
            if door.kind != "open border" and self.grid.blocked()[cells].any():
                found[f"door {door.id}"] = cells
        for room in self.storey.rooms:
            inner = ndimage.binary_erosion(self.rooms[room.id])
            for door in self.storey.doors:
                if room.id in door.rooms:  # up to the door: furniture may stand against it
                    mouth = self._doorway(door, max(door.width - 2.0 * res, res))
                    inner |= mouth & self.rooms[room.id]
            cells = inner & (self.grid.data == OCCUPIED) & ~self._fixed
            if cells.any():
                found[f"room {room.id}"] = cells
        return found

    def _doorway(self, door: Door, width: float) -> Booleans:
        """Cells of a doorway, with a margin on both sides of the wall."""
        margin = 0.1 if door.depth else 0.4
        return polygon_cells([door.part(-width / 2.0, width / 2.0, margin)], self.grid)

    def _reach(self, freed: Booleans, sources: list[AccessSource]) -> _Reach:
        data = np.where(freed, FREE, self.grid.data).astype(np.int8)
        grid = replace(self.grid, data=data) if freed.any() else self.grid
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
            same = [e for e in sources if reach.labels[tuple(reach.grid.cells(e.point))] == label]
            if not same:
                continue
            source = same[0]
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
            label = now.labels[tuple(now.grid.cells(source.point))]
            if not any(
                label == now.labels[tuple(now.grid.cells(each.point))]
                and isinstance(self._path(now.grid, each.point, source.point), Path)
                for each in found
            ):
                found.append(source)
        return found

    def _goals(self, room: str, reach: _Reach, cells: Booleans) -> Iterator[Floats]:
        """Points of a room among ``cells`` where the footprint fits, the roomiest first."""
        inside = self.rooms[room] & ~reach.grid.blocked()
        chosen = self.rooms[room] & cells & (reach.clearance > self.robot.inscribed_radius)
        if not chosen.any():
            return
        window = _window(inside)
        depth = signed_distance(~np.pad(inside[window], 1), self.grid.resolution)[1:-1, 1:-1]
        at = np.argwhere(chosen[window])
        left = at[np.argsort(-depth[tuple(at.T)], kind="stable")]
        left = left + np.array([window[0].start, window[1].start])
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
        cleared = self._reach(self._changes().get(f"room {room}", np.zeros_like(cells)), [])
        if next(self._goals(room, cleared, cells), None) is None:
            return NO_PLACE
        if ndimage.binary_dilation(stairs, iterations=4)[cells].any():
            return "only by stairs"
        if not any(room in door.rooms for door in self.storey.doors):
            return "no door leads to it"
        return f"no change of up to {_LARGEST_SET} doors and rooms on the way opens it"


_SQUARE = ((-1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-1.0, 1.0))


def needed_width(robot: Robot) -> float:
    """Clear width that a chair needs driving straight: that of its footprint, m."""
    return float(np.ptp(robot.outline[:, 1]))


def is_entrance(door: Door) -> bool:
    """Check that a door of a model leads outside: it joins one room only."""
    return door.kind in {"door", "opening"} and len(door.rooms) == 1


def outward(door: Door, storey: BuildingStorey) -> Floats:
    """Unit vector (2,) across a door, out of its room."""
    normal = np.array([-door.direction[1], door.direction[0]])
    rooms: list[Room] = [room for room in storey.rooms if room.id in door.rooms]
    for distance in door.depth / 2.0 + np.array([0.05, 0.15, 0.3, 0.5]):
        if any(room.contains(door.point + distance * normal) for room in rooms):
            return -normal
    return normal


def _padded(grid: OccupancyGrid, margin: float) -> OccupancyGrid:
    """Grid with unknown cells around it."""
    count = int(np.ceil(margin / grid.resolution))
    corner = transform(grid.X_MG, np.full(2, -count * grid.resolution))
    data = np.pad(grid.data, count, constant_values=UNKNOWN)
    return OccupancyGrid(
        data=data, resolution=grid.resolution, X_MG=np.array([*corner, grid.X_MG[2]])
    )


def _window(mask: Booleans) -> tuple[slice, slice]:
    """Slices of the smallest window with all true cells; the first cell if there is none."""
    if not mask.any():
        return slice(0, 1), slice(0, 1)
    rows, cols = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return slice(rows[0], rows[-1] + 1), slice(cols[0], cols[-1] + 1)
