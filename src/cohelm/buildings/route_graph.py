"""Route graph of a building: rooms, doors and lifts, and the ways between them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from typing import Any, Literal

import networkx as nx
import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.buildings.floor_zones import FloorZones, ZonePath, floor_zones
from cohelm.buildings.lifts import Lift, lifts_of, open_front
from cohelm.buildings.storey import BuildingStorey, Cell, Door, polygon_cells
from cohelm.buildings.storey_files import room_names
from cohelm.config import nearest
from cohelm.errors import ConfigError, NoRoute
from cohelm.geometry import distance_to_polygon
from cohelm.maps import NamedPlace, innermost_point

LIFT_WAIT = 30.0
"""Waiting and riding time of a lift, s; assumed."""
LIFT_PRICE = 0.8
"""Price of a second in a lift, m: the distance that a chair drives in it."""
WIDE = 1.5
"""Clear width from which a way is wide: two chairs turn, or a chair and a person pass, m."""
_WAITING = 2.0, 0.8
"""In front of a lift the chair waits at most this far from its door, with this clearance, m."""


@value
class RouteNode:
    """Place on a route."""

    kind: Literal["room", "door", "lift"]
    storey: int
    point: Annotated[Floats, Shape("2")]
    """Roomiest point of a room, side of a door, place in front of a lift; map frame, m."""
    name: str
    """Name of the room, door or lift; empty for floor in no room."""
    key: str
    """Id of the room or door, name of the lift; empty for floor in no room."""
    zone: int
    """Zone of its storey's floor that it lies in."""
    place: str
    """Name of the room that it lies in; empty for floor in no room."""
    room: str
    """Id of the room that it lies in; empty for floor in no room."""


@value
class RouteEdge:
    """Way between two places that needs no other place."""

    kind: Literal["walk", "door", "lift"]
    points: Annotated[Floats, Shape("k 2")]
    """Shortest path over free cells; map frame of the storey, m."""
    length: float
    """m; 0 for a lift."""
    clear_width: float
    """Bottleneck of the free width on the map, m; ∞ for a lift."""
    door: Door | None = None
    """The door, for kind ``door``; it knows width and threshold of the model."""
    wait: float = 0.0
    """Time in and for a lift, s."""
    ramp: bool = False
    """Leads over a ramp of the model."""


@value
class RouteWishes:
    """Wishes for a route; each is a price in metres of detour."""

    avoid: frozenset[str] = frozenset()
    """Ids of rooms to pass only if the detour is longer than ``room_price``."""
    closed: frozenset[str] = frozenset()
    """Ids of rooms never to enter."""
    room_price: float = 100.0
    """For entering and leaving a room to avoid, m."""
    narrow_price: float = 0.0
    """For each metre on a way narrower than 1.5 m, m; 0: no such wish."""
    ramp_price: float = 0.0
    """For each ramp, m; 0: no such wish."""


@value
class BuildingRoute:
    """Route through rooms, doors and lifts."""

    nodes: tuple[RouteNode, ...]
    edges: tuple[RouteEdge, ...]
    """One fewer than nodes, each directed as the route."""
    wishes: Mapping[str, float]
    """Extra length that each wish costs, m: over the route without it."""
    shortest: float
    """Length of the shortest route without wishes, m."""

    @property
    def length(self) -> float:
        """Length without lifts, m."""
        return float(sum(edge.length for edge in self.edges))

    @property
    def clear_width(self) -> float:
        """Narrowest clear width on the map, m."""
        return min((edge.clear_width for edge in self.edges), default=math.inf)


@value
class RouteGraph:
    """Rooms, doors and lifts of a building as nodes, joined within rooms, by doors and by lifts."""

    storeys: tuple[BuildingStorey, ...]
    lifts: tuple[Lift, ...]
    nodes: tuple[RouteNode, ...]
    graph: Any
    """Undirected ``networkx.Graph`` over positions in ``nodes``; each edge has a RouteEdge, from
    the lower position to the higher one, as ``edge``."""

    def edge(self, one: int, other: int) -> RouteEdge:
        """Edge of two joined nodes, directed from the first one.

        Raises:
            KeyError: if they are not joined.
        """
        edge: RouteEdge = self.graph.edges[one, other]["edge"]
        return edge if one < other else _reversed(edge)

    def storey(self, number: int) -> BuildingStorey:
        """Storey of a number.

        Raises:
            StopIteration: if there is none.
        """
        return next(each for each in self.storeys if each.number == number)

    def lift_places(self, storey: int) -> tuple[NamedPlace, ...]:
        """Waiting places in front of the lifts that are no rooms on a storey."""
        rooms = {
            o.name for o in self.lifts for each in o.landings if each.room and each.storey == storey
        }
        here = [each for each in self.nodes if each.kind == "lift" and each.storey == storey]
        points = {each.name: each.point for each in reversed(here) if each.name not in rooms}
        return tuple(NamedPlace(name=name, point=point) for name, point in points.items())

    def find(self, text: str, key: str = "") -> int:
        """Position of the room or lift of that name, number, or both; ``NAME @ STOREY`` tells more.

        Args:
            text: not case-sensitive.
            key: option or key that gives it, for errors.

        Raises:
            ConfigError: if there is none, or more than one; names candidates.
        """
        found = self._places(text)
        if len(found) == 1:
            return found[0]
        if not found:
            every = {node.name for node in self.nodes if _is_place(node)}
            raise ConfigError(f"no place {text!r}{nearest(text, every)}", key=key)
        names = " or ".join(repr(self._full_name(i)) for i in found)
        raise ConfigError(f"{text!r} may be {names}", key=key)

    def rooms(self, text: str, key: str = "") -> frozenset[str]:
        """Ids of all rooms of that name or number, on one storey with ``NAME @ STOREY``.

        Raises:
            ConfigError: if there is none; names candidates.
        """
        found = {self.nodes[i].room for i in self._places(text) if self.nodes[i].kind == "room"}
        if not found:
            every = {node.name for node in self.nodes if node.kind == "room" and node.name}
            raise ConfigError(f"no room {text!r}{nearest(text, every)}", key=key)
        return frozenset(found)

    def route(
        self,
        start: int,
        goal: int,
        *,
        width: float = 0.0,
        wishes: RouteWishes | None = None,
        blocked: Set[frozenset[int]] = frozenset(),
    ) -> BuildingRoute:
        """Cheapest route between two nodes.

        Args:
            start, goal: positions in ``nodes``.
            width: the robot's; narrower edges are closed, m.
            wishes: prices of rooms, narrow ways and ramps.
            blocked: pairs of nodes whose edges are closed.

        Raises:
            NoRoute: if there is none; names the door or room that is too narrow.
        """
        wishes = wishes or RouteWishes()
        best = self._path(start, goal, width, wishes, blocked)
        shortest = self._path(start, goal, width, RouteWishes(closed=wishes.closed), blocked)
        if best is None or shortest is None:
            narrowest = self._narrowest(start, goal, wishes, blocked)
            others = replace(wishes, closed=frozenset())
            closed = not narrowest and self._path(start, goal, width, others, blocked) is not None
            raise NoRoute(
                start=self._full_name(start), goal=self._full_name(goal), needed=width,
                narrowest=narrowest,
                because="rooms never to enter close every way" if closed else "",
            )  # fmt: skip
        length = self._length(best)
        costs = {}
        for name, without in _each_without(wishes):
            other = self._path(start, goal, width, without, blocked)
            costs[name] = length - self._length(other or best)
        return BuildingRoute(
            nodes=tuple(self.nodes[i] for i in best),
            edges=tuple(self.edge(*pair) for pair in itertools.pairwise(best)),
            wishes=costs,
            shortest=self._length(shortest),
        )

    def position(self, node: RouteNode) -> int:
        """Position of a node of this graph."""
        return next(i for i, each in enumerate(self.nodes) if each is node)

    def describe(self, one: RouteNode, other: RouteNode, edge: RouteEdge) -> str:
        """An edge in words: the door with its clear width, or the room."""
        if edge.door is None:
            where = one.place or "the floor in no room"
            return f"the way through {where}, {edge.clear_width:.2f} m wide"
        name = f" {edge.door.name!r}" if edge.door.name else ""
        sides = " – ".join(node.place or "no room" for node in (one, other))
        width = f"{edge.door.width:.2f} m wide"
        if edge.clear_width < edge.door.width - 0.005:
            width += f", {edge.clear_width:.2f} m on the map"
        return f"the {edge.door.kind}{name} ({sides}), {width}"

    def _places(self, text: str) -> list[int]:
        name, _, where = (part.strip().casefold() for part in text.partition("@"))
        found = []
        for i, node in enumerate(self.nodes):
            storey = self.storey(node.storey)
            here = not where or where in {storey.name.casefold(), str(storey.number)}
            if here and _is_place(node) and name in self._names(node):
                found.append(i)
        return found

    def _names(self, node: RouteNode) -> set[str]:
        room = next((r for r in self.storey(node.storey).rooms if r.id == node.key), None)
        names = {node.name} if room is None else {node.name, room.number, room.label, room.name}
        return {each.casefold() for each in names if each}

    def _full_name(self, i: int) -> str:
        node = self.nodes[i]
        return f"{node.name or node.place or 'no room'} @ {self.storey(node.storey).name}"

    def _path(
        self,
        start: int,
        goal: int,
        width: float,
        wishes: RouteWishes,
        blocked: Set[frozenset[int]],
    ) -> list[int] | None:
        def price(one: int, other: int, data: Mapping[str, Any]) -> float | None:
            edge: RouteEdge = data["edge"]
            rooms = [self.nodes[one].room, self.nodes[other].room]
            closed = edge.kind == "door" and any(room in wishes.closed for room in rooms)
            if closed or edge.clear_width < width or frozenset((one, other)) in blocked:
                return None
            return _price(edge, rooms, wishes)

        try:
            return list(nx.dijkstra_path(self.graph, start, goal, weight=price))
        except nx.NetworkXNoPath:
            return None

    def _length(self, path: Sequence[int]) -> float:
        return float(sum(self.edge(*pair).length for pair in itertools.pairwise(path)))

    def _narrowest(
        self, start: int, goal: int, wishes: RouteWishes, blocked: Set[frozenset[int]]
    ) -> str:
        """Narrowest edge of the widest route, in words, a door if it is one; empty if none."""
        widths = sorted({data["edge"].clear_width for _, _, data in self.graph.edges(data=True)})
        low, high = 0, len(widths)
        best: list[int] | None = None
        while low < high:
            middle = (low + high) // 2
            path = self._path(start, goal, widths[middle], wishes, blocked)
            best, low, high = (path, middle + 1, high) if path else (best, low, middle)
        pairs = list(itertools.pairwise(best or []))
        if not pairs:
            return ""
        one, other = min(
            pairs, key=lambda p: (self.edge(*p).clear_width, self.edge(*p).kind != "door")
        )
        beside = [p for p in pairs if {one, other} & set(p) and self.edge(*p).kind == "door"]
        # A doorway's jambs narrow the way up to it as much as the doorway itself.
        if beside and self.edge(*beside[0]).clear_width < self.edge(one, other).clear_width + 0.15:
            one, other = beside[0]
        return self.describe(self.nodes[one], self.nodes[other], self.edge(one, other))


def route_graph(storeys: Sequence[BuildingStorey]) -> RouteGraph:
    """Graph of a building from the maps, rooms, doors and lifts of its storeys."""
    lifts, graph = lifts_of(storeys), nx.Graph()
    nodes: list[RouteNode] = []
    landings: dict[str, list[int]] = {lift.name: [] for lift in lifts}
    for storey in storeys:
        if storey.grid.blocked().all():
            continue
        floor = _StoreyFloor(storey, lifts)
        for node, cell in floor.nodes():
            if node.kind == "lift":
                landings[node.key].append(len(nodes))
            if cell is not None:
                floor.members.setdefault(node.zone, []).append((len(nodes), cell))
            nodes.append(node)
        for one, other, edge in floor.edges(nodes):
            graph.add_edge(one, other, edge=edge)
    graph.add_nodes_from(range(len(nodes)))
    for ends in landings.values():
        for one, other in itertools.combinations(ends, 2):
            if nodes[one].storey != nodes[other].storey:
                points = np.array([nodes[one].point, nodes[other].point])
                edge = RouteEdge(
                    kind="lift", points=points, length=0.0, clear_width=math.inf, wait=LIFT_WAIT
                )
                graph.add_edge(one, other, edge=edge)
    return RouteGraph(storeys=tuple(storeys), lifts=lifts, nodes=tuple(nodes), graph=graph)


class _StoreyFloor:
    """Nodes and edges of one storey."""

    def __init__(self, storey: BuildingStorey, lifts: Iterable[Lift]) -> None:
        self.storey = storey
        self.names = room_names(storey.rooms)
        self.zones: FloorZones = floor_zones(storey)
        self.landings = [
            (lift, landing)
            for lift in lifts
            for landing in lift.landings
            if landing.storey == storey.number
        ]
        shafts = polygon_cells([each.polygon for _, each in self.landings], storey.grid)
        labels = self.zones.labels
        sizes = np.bincount(labels.ravel(), minlength=len(storey.rooms) + 1)
        inside = np.bincount(labels[shafts].ravel(), minlength=len(sizes))
        lift_rooms = {landing.room for _, landing in self.landings}
        self.open = [
            i
            for i in range(1, len(sizes))
            if inside[i] <= 0.5 * sizes[i] and self._room(i)[0] not in lift_rooms - {""}
        ]
        """Labels of zones that are no lift."""
        self.members: dict[int, list[tuple[int, Cell]]] = {}
        """Positions and cells of the nodes in each zone."""

    def nodes(self) -> Iterator[tuple[RouteNode, Cell | None]]:
        """Nodes with their cells; a room without free floor has no cell."""
        for zone in self.open:
            key, name = self._room(zone)
            cell = self.zones.roomiest(zone)
            if cell is not None:
                yield self._node("room", zone, cell, name, key), cell
            elif key:
                point = innermost_point(self.storey.rooms[zone - 1].polygons[0])
                row, col = self.storey.grid.cells(point)
                yield self._node("room", zone, (int(row), int(col)), name, key), None
        for doorway in self.zones.doorways:
            for zone, cell in doorway.sides.items():
                if zone in self.open:
                    name, key = doorway.door.name, doorway.door.id
                    yield self._node("door", zone, cell, name, key), cell
        for lift, landing in self.landings:
            fronts = {
                zone: cell
                for doorway in self.zones.doorways
                if doorway.door.id in landing.doors
                for zone, cell in doorway.sides.items()
            } or self._fronts(open_front(self.storey, landing.polygon))
            for zone, front in fronts.items():
                if zone in self.open:
                    cell = self.zones.roomiest_near(zone, front, *_WAITING)
                    yield self._node("lift", zone, cell, lift.name, lift.name), cell

    def edges(self, nodes: Sequence[RouteNode]) -> Iterator[tuple[int, int, RouteEdge]]:
        for zone, members in self.members.items():
            for i, j, path in self.zones.paths(zone, [cell for _, cell in members]):
                yield members[i][0], members[j][0], self._edge("walk", path)
        at = {
            (nodes[i].key, nodes[i].zone): i
            for members in self.members.values()
            for i, _ in members
            if nodes[i].kind == "door"
        }
        for doorway in self.zones.doorways:
            sides = [zone for zone in doorway.sides if zone in self.open]
            for one, other in itertools.combinations(sides, 2):
                passed = self.zones.through(doorway, one, other)
                if passed is not None:
                    ends = at[doorway.door.id, one], at[doorway.door.id, other]
                    yield *ends, self._edge("door", passed, doorway.door)

    def _fronts(self, front: np.ndarray[Any, Any]) -> dict[int, Cell]:
        """The middle cell of each zone among cells (rows, cols)."""
        found = {}
        for zone in np.unique(self.zones.labels[front]):
            cells = np.argwhere(front & (self.zones.labels == zone))
            middle = cells[np.argmin(np.linalg.norm(cells - cells.mean(axis=0), axis=1))]
            found[int(zone)] = (int(middle[0]), int(middle[1]))
        return found

    def _room(self, zone: int) -> tuple[str, str]:
        """Id and name of a zone's room; empty for floor in no room."""
        if zone > len(self.storey.rooms):
            return "", ""
        return self.storey.rooms[zone - 1].id, self.names[zone - 1]

    def _node(
        self, kind: Literal["room", "door", "lift"], zone: int, cell: Cell, name: str, key: str
    ) -> RouteNode:
        room, place = self._room(zone)
        return RouteNode(
            kind=kind, storey=self.storey.number, point=self.storey.grid.centres(cell), name=name,
            key=key, zone=zone, place=place, room=room,
        )  # fmt: skip

    def _edge(
        self, kind: Literal["walk", "door"], path: ZonePath, door: Door | None = None
    ) -> RouteEdge:
        ramp = any(
            link.kind == "ramp" and distance_to_polygon(link.polygon, *point) < 0.0
            for link in self.storey.links
            for point in path.points
        )
        return RouteEdge(
            kind=kind, points=path.points, length=path.length, clear_width=path.clear_width,
            door=door, ramp=ramp,
        )  # fmt: skip


def _is_place(node: RouteNode) -> bool:
    return node.kind != "door" and bool(node.name)


def _reversed(edge: RouteEdge) -> RouteEdge:
    return replace(edge, points=edge.points[::-1])


def _price(edge: RouteEdge, rooms: Sequence[str], wishes: RouteWishes) -> float:
    """Length and prices of an edge, m; half of a room's price at each of its doors."""
    price = edge.length + LIFT_PRICE * edge.wait
    if edge.kind == "door":
        price += 0.5 * wishes.room_price * sum(room in wishes.avoid for room in rooms)
    if edge.kind == "walk" and edge.clear_width < WIDE:
        price += wishes.narrow_price * edge.length
    return price + wishes.ramp_price * edge.ramp


def _each_without(wishes: RouteWishes) -> Iterator[tuple[str, RouteWishes]]:
    """Name of each wish that is set, and all the others."""
    if wishes.avoid:
        yield "avoid", replace(wishes, avoid=frozenset())
    if wishes.closed:
        yield "closed", replace(wishes, closed=frozenset())
    if wishes.narrow_price:
        yield "wide", replace(wishes, narrow_price=0.0)
    if wishes.ramp_price:
        yield "level", replace(wishes, ramp_price=0.0)
