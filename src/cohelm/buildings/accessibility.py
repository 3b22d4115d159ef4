"""Accessibility of a building for one chair: rooms that it reaches, and barriers to the others."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from cohelm import plugins
from cohelm.arrays import Annotated, Booleans, Floats, Shape, replace, value
from cohelm.buildings.chair_floor import (
    AccessFault,
    AccessSource,
    ChairFloor,
    RoomResult,
    is_entrance,
    needed_width,
    outward,
)
from cohelm.buildings.entrances import AccessEntrance, door_labels, find_entrances
from cohelm.buildings.lifts import Lift, LiftLanding, lifts_of, open_front
from cohelm.buildings.norms import MeasuredValue, NormCheck, check_norms
from cohelm.buildings.storey import BuildingStorey, Door, Room
from cohelm.buildings.storey_files import door_sides, room_names
from cohelm.errors import ConfigError
from cohelm.geometry import arc_length, distance_to_polygon, nearest_on_polyline, resample
from cohelm.maps import distance_field
from cohelm.planning.planners.route import gap_at
from cohelm.robots import Robot

_AT_DOOR = 0.6
"""Distance of a narrow place from a door that it belongs to, m."""
_WIDEST = 3.0
"""Wider passages are not measured, m."""


@value
class TightPassage:
    """Narrowest place on a way."""

    place: str
    """Door, or a point on the map."""
    point: Annotated[Floats, Shape("2")]
    width: float
    """Clear width of the door, or free width on the map, m."""
    margin: float
    """Width less that of the chair, m."""
    error: float
    """The true width is up to this much larger, m: two cells for a width on the map."""


@value
class RoomAccess:
    """Answer for one room."""

    storey: int
    """Number of the storey."""
    room: Room
    name: str
    """Unique on its storey."""
    path: Annotated[Floats, Shape("k 2")] | None
    """Path on the storey to the room, m; None: not reached."""
    length: float
    """Way from the entrance, without lifts, m; NaN: not reached."""
    entrance: str
    """Entrance and lifts on the way; empty: not reached."""
    tightest: TightPassage | None
    turning: float
    """Diameter of the largest free circle, m."""
    turns: bool
    """The chair's own swept circle fits."""
    barriers: tuple[tuple[int, ...], ...]
    """Small sets of numbers of barriers; without those of any one set the room is reached."""
    remark: str
    """Reason where no set was found."""


@value
class AccessBarrier:
    """Cause that keeps the chair out of rooms."""

    number: int
    fault: AccessFault
    place: str
    text: str
    opens: tuple[str, ...]
    """Rooms that are reached without this barrier alone."""
    shares: tuple[str, ...]
    """Rooms that are reached without this barrier and others."""


@value
class AccessReport:
    """Rooms of a building that one chair reaches, barriers and norms."""

    chair: str
    footprint: tuple[float, float]
    """Length and width of the chair, m."""
    turning: float
    """Diameter of the circle that the chair sweeps turning on the spot, m."""
    entrances: tuple[AccessEntrance, ...]
    rooms: tuple[RoomAccess, ...]
    barriers: tuple[AccessBarrier, ...]
    """Those that open most rooms first."""
    norms: tuple[NormCheck, ...]
    notes: tuple[str, ...]

    @property
    def summary(self) -> str:
        """One sentence: number of rooms that are reached."""
        reached = sum(each.path is not None for each in self.rooms)
        return f"{reached} of {len(self.rooms)} rooms are reached."


def accessibility(
    storeys: Sequence[BuildingStorey], robot: Robot, entrance: str | None = None
) -> AccessReport:
    """Find the rooms that a chair reaches from an entrance, and why it does not reach the others.

    Args:
        storeys: those of one building, of which some have a map.
        robot: the chair; its footprint and ``max_step_up`` decide.
        entrance: room, door or point, see :func:`find_entrances`. None: the doors that lead
            outside, the widest one first.

    Raises:
        ConfigError: if there is no such entrance, several have that name, the chair does not fit
            there, or the building has no room.
    """
    mapped = [each for each in storeys if each.rooms and not each.grid.blocked().all()]
    if not mapped:
        raise ConfigError("no storey has rooms and free floor", key="--report")
    notes = [f"{s.name}: no rooms or no free floor; left out" for s in storeys if s not in mapped]
    lifts = lifts_of(storeys, notes)
    survey = _Survey(mapped, robot, lifts)
    chosen = find_entrances(mapped, survey.inside(), entrance, notes)
    notes += [f"the chair does not fit at {name}: no entrance" for name in survey.run(chosen)]
    rooms = [access for storey in mapped for access in survey.rooms_of(storey)]
    barriers = survey.barriers(rooms)
    numbers = {each.fault[:3]: each.number for each in barriers}
    for i, access in enumerate(rooms):
        sets = survey.results[access.storey][access.room.id].sets
        numbered = (tuple(sorted(numbers[fault[:3]] for fault in faults)) for faults in sets)
        rooms[i] = replace(access, barriers=tuple(numbered))
    size = np.ptp(robot.outline, axis=0).tolist()
    return AccessReport(
        chair=robot.name, footprint=(size[0], size[1]), turning=2.0 * robot.circumscribed_radius,
        entrances=chosen, rooms=tuple(rooms), barriers=barriers, norms=survey.norms(rooms),
        notes=tuple(notes),
    )  # fmt: skip


class _Survey:
    """Storeys one after the other, as the chair arrives on them."""

    def __init__(
        self, storeys: Sequence[BuildingStorey], robot: Robot, lifts: tuple[Lift, ...]
    ) -> None:
        self._storeys = {storey.number: storey for storey in storeys}
        self._robot, self._lifts, self._needed = robot, lifts, needed_width(robot)
        self._landings = [(lift, each) for lift in lifts for each in lift.landings]
        self._labels = door_labels(storeys)
        self._names = {storey.number: room_names(storey.rooms) for storey in storeys}
        self._floors: dict[int, ChairFloor] = {}
        self._arrived: dict[tuple[int, str], int] = {}
        """Least number of faults of the arrivals surveyed, by storey and lift."""
        self.results: dict[int, dict[str, RoomResult]] = {}

    def inside(self) -> frozenset[str]:
        """Ids of doors that do not lead outside, though they join one room: those of lifts."""
        storeys = self._storeys.values()
        shafts = [link.polygon for s in storeys for link in s.links if link.kind == "lift"]
        beside = (
            door.id
            for storey in storeys
            for door in storey.doors
            if any(distance_to_polygon(each, *door.point) < _AT_DOOR for each in shafts)
        )
        return frozenset([*beside, *(door for _, each in self._landings for door in each.doors)])

    def run(self, entrances: Sequence[AccessEntrance]) -> list[str]:
        """Survey all storeys, from the entrances up and down; returns entrances left out.

        Raises:
            ConfigError: if the chair fits at no entrance.
        """
        planner = plugins.build("global_planners", "soft_via", key="--report")
        doors = {(n, door.id): door for n, s in self._storeys.items() for door in s.doors}
        for number, storey in self._storeys.items():
            here = [doors[number, e.door] for e in entrances if e.door and e.storey == number]
            outside = [door for door in here if is_entrance(door)]
            self._floors[number] = ChairFloor(storey, self._robot, planner, outside)
        for lift, landing in self._landings:
            if landing.storey in self._floors:
                floor = self._floors[landing.storey]
                floor.rooms[f"lift {lift.name}"] = _front(floor, landing)
        arrivals: dict[int, list[AccessSource]] = {}
        left_out: list[str] = []
        for entrance in entrances:
            floor, point = self._floors[entrance.storey], entrance.point
            if point is None:
                door = doors[entrance.storey, entrance.door]
                point = floor.before(door, outward(door, floor.storey))
            if floor.check(point).fits:
                source = AccessSource(name=entrance.name, point=point)
                arrivals.setdefault(entrance.storey, []).append(source)
            else:
                left_out.append(entrance.name)
        if not arrivals:
            raise ConfigError(f"the chair does not fit at {entrances[0].name}", key="--entrance")
        while arrivals or len(self.results) < len(self._storeys):
            if not arrivals:
                number, sources = self._by_stairs()
                arrivals[number] = sources
            number = min(arrivals, key=lambda n: min(len(each.faults) for each in arrivals[n]))
            least = min(len(each.faults) for each in arrivals[number])
            sources = [each for each in arrivals[number] if len(each.faults) == least]
            arrivals[number] = [each for each in arrivals[number] if len(each.faults) > least]
            before = self.results.get(number, {})
            self.results[number] = {
                room: _better(before.get(room), _behind(sources, result))
                for room, result in self._floors[number].survey(sources, before).items()
            }
            self._arrived |= {(number, each.via[-1]): least for each in sources if each.via}
            for other, source in self._by_lift(number):
                arrivals.setdefault(other, []).append(source)
            useful = {n: [e for e in arrivals[n] if self._is_useful(n, e)] for n in arrivals}
            arrivals = {n: sources for n, sources in useful.items() if sources}
        return left_out

    def rooms_of(self, storey: BuildingStorey) -> list[RoomAccess]:
        """Answers for the rooms of a storey; the barriers are still empty."""
        floor, answers = self._floors[storey.number], []
        for room in storey.rooms:
            result, turning = self.results[storey.number][room.id], floor.clear_of(room.id)
            legs: list[tuple[int, Floats]] = []
            entrance = ""
            if result.path is not None and result.source is not None:
                legs = [*result.source.legs, (storey.number, result.path)]
                entrance = ", ".join([result.source.name, *result.source.via])
            tight = [self._tightest(*leg) for leg in legs]
            length = float(sum(arc_length(points)[-1] for _, points in legs))
            answers.append(
                RoomAccess(
                    storey=storey.number, room=room, name=self._names[storey.number][room.id],
                    path=result.path, length=length if legs else np.nan, entrance=entrance,
                    tightest=min(tight, key=lambda each: each.width, default=None),
                    turning=turning, turns=turning >= 2.0 * self._robot.circumscribed_radius,
                    barriers=(), remark=result.remark,
                )
            )  # fmt: skip
        return answers

    def barriers(self, rooms: Sequence[RoomAccess]) -> tuple[AccessBarrier, ...]:
        """Barriers of all rooms, those that open most rooms first."""
        widest: dict[tuple[str, str, int], AccessFault] = {}
        # Rooms as keys, to name each once: those opened alone, and with others.
        opens = defaultdict[tuple[str, str, int], tuple[dict[str, None], dict[str, None]]](
            lambda: ({}, {})
        )
        for access in rooms:
            for faults in self.results[access.storey][access.room.id].sets:
                for fault in faults:
                    key = fault[:3]
                    widest[key] = max(widest.get(key, fault), fault, key=lambda each: each.width)
                    title = self._title(access.storey, access.name)
                    opens[key][len(faults) > 1][title] = None
        order = sorted(widest, key=lambda key: (*(-len(each) for each in opens[key]), key))
        return tuple(
            AccessBarrier(
                number=number, fault=widest[key], place=self._place(widest[key]),
                text=self._text(widest[key]), opens=tuple(opens[key][0]),
                shares=tuple(opens[key][1]),
            )
            for number, key in enumerate(order, 1)
        )  # fmt: skip

    def norms(self, rooms: Sequence[RoomAccess]) -> tuple[NormCheck, ...]:
        """Values of the building compared with the norms."""
        found = defaultdict[str, list[MeasuredValue]](list)
        for number, storey in self._storeys.items():
            error = 2.0 * storey.grid.resolution
            for door in storey.doors:
                if door.kind != "open border":
                    name, of_map = self._door(number, door), door.width_from == "map"
                    width = MeasuredValue(name, door.width, error if of_map else 0.0)
                    found["door"].append(width)
                    depth = self._approach(storey, door)
                    found["approach"].append(MeasuredValue(name, depth, error))
                    if door.kind != "opening":
                        found["threshold"].append(MeasuredValue(name, door.threshold))
            for link in storey.links:
                if link.kind == "ramp":
                    ramp = f"{link.name or 'ramp'}, {storey.name}"
                    found["ramp"].append(MeasuredValue(ramp, None))
            for each in (each for each in rooms if each.storey == number):
                title = self._title(number, each.name)
                found["turning"].append(MeasuredValue(title, each.turning, error))
        places = {each.tightest.place: each.tightest for each in rooms if each.tightest}
        found["route"] = [
            MeasuredValue(f"{place} on the map", tight.width, tight.error)
            for place, tight in places.items()
            if tight.error
        ]
        enters = {
            lift.name: (lift, door)
            for lift, landing in self._landings
            for storey in self._storeys.values()
            for door in storey.doors
            if door.id in landing.doors and door.kind != "open border"
        }
        for name, (lift, door) in enters.items():
            for key, axis in (("car width", door.direction), ("car depth", door.normal)):
                size = None if lift.car is None else float(np.ptp(lift.car @ axis))
                found[key].append(MeasuredValue(name, size))
        return check_norms(found)

    def _is_useful(self, number: int, source: AccessSource) -> bool:
        """Check that the chair gets to that side of a storey with more faults, or not at all."""
        if number not in self.results:
            return True
        known = self.results[number][source.via[-1]]
        least = min((0,) if known.path is not None else map(len, known.sets), default=np.inf)
        return len(source.faults) < min(least, self._arrived.get((number, source.via[-1]), np.inf))

    def _by_lift(self, number: int) -> Iterator[tuple[int, AccessSource]]:
        """Arrivals on other storeys by the lifts of a storey."""
        for lift in self._lifts:
            here = self.results[number].get(f"lift {lift.name}")
            if here is None or (here.path is None and not here.sets):
                continue
            source = here.source or AccessSource(name="", point=np.zeros(2))
            legs = () if here.path is None else ((number, here.path),)
            enters = next(each for each in lift.landings if each.storey == number)
            for landing in lift.landings:
                floor = self._floors.get(landing.storey)
                point = None if floor is None else floor.place_in(f"lift {lift.name}")
                if point is None or landing.storey == number:
                    continue
                faults = min(here.sets, key=len) if here.sets else frozenset()
                if self._is_tight(lift, (enters, landing)):
                    x, y = enters.polygon.mean(axis=0).tolist()
                    faults |= {AccessFault("lift", lift.name, number, (x, y))}
                yield landing.storey, AccessSource(
                    name=source.name, point=point, legs=(*source.legs, *legs),
                    via=(*source.via, f"lift {lift.name}"), faults=faults,
                )  # fmt: skip

    def _is_tight(self, lift: Lift, landings: Iterable[LiftLanding]) -> bool:
        """Check for a door of a lift, or its car, that is too small for the chair."""
        size = sorted(np.ptp(self._robot.outline, axis=0))
        for landing in landings:
            doors = [d for d in self._storeys[landing.storey].doors if d.id in landing.doors]
            if doors and max(door.width for door in doors) < self._needed:
                return True
            axes = [doors[0].direction, doors[0].normal] if doors else np.eye(2)
            # The car is no larger than the shaft, where the model has that only.
            outline = landing.polygon if lift.car is None else lift.car
            car = sorted(np.ptp(outline @ np.transpose(axes), axis=0))
            if car[0] < size[0] or car[1] < size[1]:
                return True
        return False

    def _by_stairs(self) -> tuple[int, list[AccessSource]]:
        """Storey next to those surveyed that has stairs at most, and places at their ends."""
        rest = self._storeys.keys() - self.results
        number, nearest = min(
            itertools.product(sorted(rest), self.results), key=lambda pair: abs(pair[0] - pair[1])
        )
        floor = self._floors[number]
        ends = [
            link.polygon.mean(axis=0)
            for at in {number, min(number, nearest)}
            for link in self._storeys[at].links
            if link.kind == "stairs"
        ]
        # The largest room stands in where the model has no stairs.
        largest = max(floor.storey.rooms, key=lambda room: room.area)
        points = [floor.check(e).nearest for e in ends or [largest.polygons[0].mean(axis=0)]]
        found = [np.array(each) for each in points if each is not None]
        found = found or [floor.grid.centres(np.argwhere(~floor.grid.blocked())[0])]
        x, y = found[0].tolist()
        faults = frozenset([AccessFault("stairs", f"{nearest}-{number}", number, (x, y))])
        return number, [AccessSource(name="", point=each, faults=faults) for each in found]

    def _tightest(self, number: int, path: Floats) -> TightPassage:
        grid = self._floors[number].grid
        walls = distance_field(grid).distance
        line, points = resample(path, grid.resolution), np.ascontiguousarray(path)
        cells = grid.cells(line)
        at = int(np.argmin(walls[tuple(cells.T)]))
        ahead = line[min(at + 3, len(line) - 1)] - line[max(at - 3, 0)]
        along = float(np.arctan2(ahead[1], ahead[0]) - grid.X_MG[2])
        width = min(gap_at(walls, grid.resolution, cells[at], along, _WIDEST / 2.0)[1], _WIDEST)
        doors = [
            door
            for door in self._storeys[number].doors
            if door.kind != "open border"
            and nearest_on_polyline(points, *door.point)[1] < door.width / 2.0
        ]
        found = [(self._door(number, door), door.point, door.width, 0.0) for door in doors]
        if all(np.hypot(*(door.point - line[at])) > door.depth / 2.0 + _AT_DOOR for door in doors):
            x, y = line[at]
            found.append((f"at ({x:.1f}, {y:.1f})", line[at], width, 2.0 * grid.resolution))
        place, point, width, error = min(found, key=lambda each: each[2])
        return TightPassage(
            place=place, point=point, width=width, margin=width - self._needed, error=error
        )

    def _approach(self, storey: BuildingStorey, door: Door) -> float:
        """Free depth in front of a door, the smaller one of both sides, m."""
        grid, depths = self._floors[storey.number].grid, []
        sides = (-outward(door, storey),) if is_entrance(door) else (door.normal, -door.normal)
        # The map is that much narrower.
        half = max(0.5 * door.width - 2.0 * grid.resolution, 0.0)
        across = np.linspace(-half, half, 19)[:, None, None] * door.direction
        deep = np.arange(grid.resolution, 1.6, grid.resolution / 2.0)
        for out in sides:
            points = door.point + across + (door.depth / 2.0 + deep)[None, :, None] * out
            within = grid.contains(points)
            rows, cols = np.where(within[..., None], grid.cells(points), 0).transpose(2, 0, 1)
            hit = (grid.blocked()[rows, cols] | ~within).any(axis=0)
            depths.append(float(deep[np.argmax(hit)]) if hit.any() else 1.6)
        return min(depths)

    def _title(self, storey: int, room: str) -> str:
        return f"{room}, {self._storeys[storey].name}" if len(self._storeys) > 1 else room

    def _door(self, storey: int, door: Door) -> str:
        sides = " – ".join(door_sides(door, self._names[storey]))
        return f"door {self._labels[door.id]} ({sides})"

    def _place(self, fault: AccessFault) -> str:
        storey = self._storeys[fault.storey]
        if fault.kind == "furniture":
            return self._names[fault.storey][fault.id]
        if fault.kind == "stairs":
            below, above = sorted(int(each) for each in fault.id.split("-"))
            return f"{self._storeys[below].name} to {self._storeys[above].name}"
        if fault.kind in {"lift", "space"}:
            return f"lift {fault.id}" if fault.kind == "lift" else f"{storey.name} at {fault.id}"
        return self._door(fault.storey, next(door for door in storey.doors if door.id == fault.id))

    def _text(self, fault: AccessFault) -> str:
        storey, needed = self._storeys[fault.storey], self._needed
        circle = f"{self._floors[fault.storey].landing:.1f} m"
        if fault.kind == "furniture":
            return "furniture or other obstacles in the room are in the way"
        if fault.kind == "space":
            return f"too little space to turn; a free circle of {circle} would do"
        if fault.kind == "stairs":
            ends = [self._storeys[int(each)] for each in fault.id.split("-")]
            stairs = any(link.kind == "stairs" for each in ends for link in each.links)
            return f"{'only' if stairs else 'not even'} stairs: no lift that the chair can use"
        if fault.kind == "lift":
            length, width = np.ptp(self._robot.outline, axis=0)
            return f"door or car too small for a chair of {length:.2f} × {width:.2f} m"
        door = next(each for each in storey.doors if each.id == fault.id)
        wide, texts = f"clear width {door.width:.2f} m", []
        if (door.threshold or 0.0) > self._robot.max_step_up:
            climbs = self._robot.max_step_up
            texts.append(f"threshold {door.threshold:.3f} m, this chair climbs {climbs:.3f} m")
        if fault.kind == "width":
            narrow = f"{needed - door.width:.2f} m too narrow"
            texts.append(f"{wide}, {narrow}: the chair needs {needed:.2f} m")
            if door.width_from == "map":
                cells = 2.0 * storey.grid.resolution
                texts.append(f"measured on the map, it may be up to {cells:.2f} m wider")
        if fault.kind == "turn":
            tight = "is enough to drive straight, but the turn in front of it is too tight"
            texts.append(f"{wide} {tight}")
        if fault.width:
            texts.append(f"with {fault.width:.2f} m the chair passes")
        elif fault.kind == "turn":
            texts.append(f"free circles of {circle} on both sides would do")
        if fault.kind == "blocked":
            texts.append(f"{wide} is enough, but an obstacle is in the doorway or close to it")
        if fault.kind == "map":
            texts.append(
                f"{wide}, {door.width - needed:.2f} m more than the chair needs, but closed on a "
                f"map of {storey.grid.resolution:g} m per cell: a finer map is needed"
            )
        return "; ".join(texts)


def _behind(sources: Sequence[AccessSource], result: RoomResult) -> RoomResult:
    """Result of a room, if the chair itself only arrives without some barriers."""
    before = (result.source or sources[0]).faults
    if not before:
        return result
    sets = tuple(before | each for each in result.sets)
    remark = result.remark and f"even if the chair got to this storey: {result.remark}"
    return RoomResult(sets=sets if sets or remark else (before,), remark=remark)


def _better(one: RoomResult | None, other: RoomResult) -> RoomResult:
    """Result of a room from two surveys: its path, else the smaller sets of changes."""
    if one is None or other.path is not None:
        return other
    sets = sorted({*one.sets, *other.sets}, key=lambda each: (len(each), sorted(each)))
    if one.path is not None or not sets:
        return one
    return RoomResult(sets=tuple(each for each in sets if len(each) == len(sets[0])))


def _front(floor: ChairFloor, landing: LiftLanding) -> Booleans:
    """Cells (rows, cols) of the floor in front of a lift, with no wall between."""
    if not landing.doors:
        return open_front(replace(floor.storey, grid=floor.grid), landing.polygon)
    front = np.zeros(floor.grid.shape, dtype=np.bool_)
    for door in floor.storey.doors:
        if door.id in landing.doors:
            inwards = (landing.polygon.mean(axis=0) - door.point) @ door.normal > 0.0
            front |= floor.in_front(door, -door.normal if inwards else door.normal)
    return front
